//! Panes, labels and memory on analytic rooms and real recordings.

mod bad_input;
mod command;
mod floor;
mod labels;
mod memory;
mod metrics;
mod mirrors;
mod pipeline;
mod real;

use limpid::Config;
use limpid::base::Rigid;
use limpid::map::glass::{LabelledScan, PointClass};
use limpid::offline::labeller::Labeller;
use limpid::sensor::Scan;

use crate::support::glass_room::Truth;

fn alone() -> Config {
    Config { glass_memory: false, ..Config::default() }
}

fn label(config: &Config, scan: &Scan) -> LabelledScan {
    Labeller::open(config, scan, None, false).unwrap().label(scan, Rigid::IDENTITY).unwrap()
}

/// Of the points away from edges: how many of a class there are, how many are called something else, and how many nothing.
fn wrong(labelled: &LabelledScan, truth: &[Truth], class: PointClass) -> [usize; 3] {
    assert_eq!(labelled.classes.len(), truth.len());
    let of = labelled.classes.iter().zip(truth).filter(|(_, t)| t.class == class && t.away_from_edges);
    of.fold([0; 3], |[all, wrong, open], ((called, _), _)| {
        let undecided = *called == PointClass::Unlabelled;
        [all + 1, wrong + usize::from(*called != class && !undecided), open + usize::from(undecided)]
    })
}
