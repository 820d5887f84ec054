//! `limpid why`: a cell of every reason that the hall has, in words.

use super::{CONFIG, Map, recording, run};
use crate::cli::{ROOM, fails, limpid, succeeds};
use crate::support::gpu::skipped;

/// Reason, how the sentence begins and what it names, and a line of a layer.
const SAID: [(u8, &str, &str, &str); 6] = [
    (1, "254: glass, pane 1", "seen by top", "panes: pane 1, found by top"),
    (2, "254: solid", "seen by top", "lidars: solid, seen by top"),
    (6, "254: occupied", "seen by front", "cameras: occupied"),
    (8, "", "free, seen by top", "lidars: free, beams crossed from "),
    (9, "", "free, seen by front", "cameras: free"),
    (10, "", "unknown (row 10 of the rule)", "lidars: nothing"),
];

fn text(recording: &str, config: &str, at: [f64; 2]) -> String {
    let at = format!("{},{}", at[0], at[1]);
    succeeds(&limpid(&["why", recording, "--config", config, "--at", &at]))
}

#[test]
fn why_explains_a_cell_of_every_reason_of_the_hall() {
    if skipped() {
        return;
    }
    let recording = recording();
    let hall = run(&recording, CONFIG);
    let map: Map = hall.map();
    let (path, config) = (recording.path.to_str().unwrap(), hall.path("robot.yaml"));
    for (reason, begins, names, layer) in SAID {
        let Some(at) = map.first(reason) else { panic!("no cell of row {reason}") };
        let said = text(path, config.to_str().unwrap(), at);
        let row = format!("(row {reason} of the rule)");
        let sentence = said.lines().next().unwrap();
        assert!(sentence.starts_with(begins) && sentence.contains(names), "{said}");
        assert!(sentence.ends_with(&row) && said.contains(layer), "{said}");
        assert_eq!(said.lines().count(), 4, "a sentence, and a line a layer: {said}");
    }
}

#[test]
fn what_why_cannot_explain_is_said() {
    fails(&limpid(&["why", ROOM, "--at", "here"]), 2, &["`here` is not of the form X,Y"]);
    fails(&limpid(&["why", ROOM, "--at", "1,nan"]), 2, &["`1,nan` is not of the form X,Y"]);
    if skipped() {
        return;
    }
    let outside = limpid(&["why", ROOM, "--method", "range", "--at", "-99,0"]);
    fails(&outside, 1, &["(-99, 0) is outside of the map", "covers x"]);
    let late = limpid(&["why", ROOM, "--method", "range", "--at", "0,0", "--frame", "99"]);
    fails(&late, 1, &["there is no map 99; the nearest is 29"]);
    let said = succeeds(&limpid(&["why", ROOM, "--method", "range", "--at", "0,0", "--frame", "3"]));
    assert!(said.contains("seen by camera 0.0 s ago") && said.contains("lidars: nothing"), "{said}");
}
