"""Average precision and best F1 by scikit-learn on random scores with ties: testdata/reference/ranking.json.

Needs numpy and scikit-learn. python3 tests/reference/ranking.py > testdata/reference/ranking.json
"""
import json

import numpy as np
from sklearn.metrics import average_precision_score, precision_recall_curve

random = np.random.default_rng(4)


def case(name, scores, bad):
    precision, recall, _ = precision_recall_curve(bad, scores)
    f1 = 2 * precision * recall / np.maximum(precision + recall, 1e-300)
    return {
        "name": name,
        "scores": [float(s) for s in scores],
        "bad": [int(b) for b in bad],
        "auprc": float(average_precision_score(bad, scores)),
        "best_f1": float(f1.max()),
    }


def overlapping(count, share, gap):
    bad = random.random(count) < share
    return random.normal(size=count) + gap * bad, bad


cases = []
for name, (count, share, gap) in {"rare": (600, 0.05, 1.5), "even": (400, 0.5, 0.7), "blind": (300, 0.3, 0.0)}.items():
    scores, bad = overlapping(count, share, gap)
    # Halves of whole numbers: many ties, and exact in a few bits.
    cases.append(case(name + ", ties", np.round(scores * 2) / 2, bad))
    cases.append(case(name + ", 32-bit floats", scores.astype(np.float32), bad))
print(json.dumps(cases))
