"""Weight files that the same weights give the same bytes."""

import json


def in_order(file):
    """The same safetensors file with its header's keys sorted: the library writes metadata in random order."""
    length = int.from_bytes(file[:8], "little")
    header = json.dumps(json.loads(file[8 : 8 + length]), sort_keys=True).encode()
    header += b" " * (-len(header) % 8)
    return len(header).to_bytes(8, "little") + header + file[8 + length :]
