//! A peer of another make: Cyclone DDS by its Python package, where that is to be had.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::node::config;
use super::peer::{Node, domain, no_network, node_options, play_options, played};
use crate::cli::ROOM;
use crate::support::gpu::skipped;
use crate::support::say;

/// A Python that has the package `cyclonedds`, by `LIMPID_PYTHON` or `python3`; `None`, said aloud, where there is none.
pub(super) fn python() -> Option<PathBuf> {
    let python = std::env::var_os("LIMPID_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let has = Command::new(&python).args(["-c", "import cyclonedds"]).stderr(Stdio::null()).status();
    if has.is_ok_and(|status| status.success()) {
        return Some(python);
    }
    say("skipped: tests with Cyclone DDS: no Python with the package cyclonedds (set LIMPID_PYTHON)");
    None
}

#[test]
fn cyclone_dds_receives_the_map_and_every_update() {
    if no_network() || skipped() {
        return;
    }
    let Some(python) = python() else { return };
    let environment = domain();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live/listener.py");
    let node = Node::start(&environment, node_options(config()));
    let listener = Command::new(python)
        .args([script, &environment.domain.to_string(), "12"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The map comes with the first frame; who listens by then has it.
    node.wait_for("/limpid in ROS domain", 1);
    played(&environment, ROOM, &play_options()).unwrap();
    let output = listener.wait_with_output().unwrap();
    let (said, failed) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let lines: Vec<Vec<&str>> = said.lines().skip(1).map(|line| line.split(' ').collect()).collect();
    assert!(lines.len() >= 12, "{said}{failed}");
    let (maps, updates): (Vec<_>, Vec<_>) = lines.iter().partition(|line| line[0] == "Grid");
    assert!(!maps.is_empty() && updates.len() >= 8, "{said}");
    let stamps: Vec<u64> = updates.iter().map(|line| line[1].parse().unwrap()).collect();
    assert!(stamps.is_sorted() && updates.iter().all(|line| line[2] == "map"), "{said}");
    assert_eq!(maps[0][3..], ["280", "280"], "240 cells and a margin of 20 on both sides");
    node.end();
}
