//! Summaries, tables, page.

use limpid::offline::eval::report::{Report, paper};
use limpid::offline::eval::result::Spread;
use limpid::offline::eval::{MethodTally, SceneResult};

/// A scene in which naive calls `occupied` of 100 free cells occupied.
fn scene(name: &str, level: &str, occupied: u64) -> SceneResult {
    let mut tally = MethodTally::default();
    tally.map.free = [100; 3];
    tally.map.free_called_occupied = [occupied; 3];
    tally.map.free_called_free = [90 - occupied; 3];
    tally.depth.pixels = 10;
    tally.depth.trusted = 8;
    let methods = ["naive", "drm"].map(|key| (key.to_owned(), tally.clone())).into();
    SceneResult { name: name.into(), level: level.into(), frames: 5, methods, ..SceneResult::default() }
}

fn report() -> Report {
    Report::new("two <scenes>", &[scene("a", "L2", 10), scene("b", "L2", 30), scene("c", "L0", 0)])
}

#[test]
fn figures_are_pooled_and_spread() {
    let json = report().json();
    let naive = &json["levels"]["L2"]["naive"];
    assert_eq!((&json["levels"]["L2"]["scenes"], &json["levels"]["L2"]["frames"]), (&2.into(), &10.into()));
    assert_eq!((&naive["for"], &naive["fsr"], &naive["hole_rate"]), (&0.2.into(), &0.7.into(), &0.2.into()));
    assert_eq!(naive["over_scenes"]["for"]["mean"], 0.2);
    let deviation = naive["over_scenes"]["for"]["deviation"].as_f64().unwrap();
    assert!((deviation - 0.02_f64.sqrt()).abs() < 1e-12);
    assert!(naive["or"].is_null() && naive["rmse_m"].is_null(), "a share of nothing is left out");
    assert_eq!(Spread::of(&[]), None);
    assert_eq!(Spread::of(&[0.5]), Some(Spread { mean: 0.5, deviation: 0.0 }));
}

#[test]
fn the_papers_figures_stand_beside_ours() {
    let text = report().text();
    let row = |level: &str, method: &str| {
        let start = format!("| {level}    | {method} ");
        let rows: Vec<&str> = text.lines().filter(|line| line.starts_with(&start)).collect();
        assert_eq!(rows.len(), 2, "{text}");
        rows.join("\n")
    };
    let naive = row("L2", "naive");
    assert!(
        ["0.200 (0.200 +- 0.141)", "0.432", "0.515", "0.452", "0.276", "0.840"]
            .iter()
            .all(|f| naive.contains(f)),
        "{naive}"
    );
    assert!(row("L0", "drm").contains("0.995"));
    assert_eq!(paper::find("L1", "drm").unwrap().map, [0.024, 0.968]);
    assert!(paper::find("L1", "naive_3_hits").is_none());
    // FOR falls from method to method at L1 and L2, as the paper's text has it.
    for level in ["L1", "L2"] {
        let rates: Vec<f64> = paper::ROWS.iter().filter(|r| r.level == level).map(|r| r.map[0]).collect();
        assert!(rates.len() == 5 && rates.windows(2).all(|pair| pair[0] > pair[1]));
    }
}

#[test]
fn scenes_stand_worst_first_with_the_reason() {
    let mut scenes = [scene("good", "L1", 1), scene("bad", "L1", 20), scene("dull", "L1", 1)];
    for scene in &mut scenes {
        for (key, tally) in &mut scene.methods {
            (tally.map.solid, tally.map.solid_lethal) = (100, 80);
            tally.map.lethal_too_near = 3;
            if scene.name == "dull" && key == "drm" {
                (tally.map.solid_lethal, tally.map.missed_unknown) = (75, 12);
            }
        }
    }
    let text = Report::new("scenes", &scenes).text();
    let rows: Vec<&str> =
        text.lines().filter(|line| line.contains("| L1    | ") && line.contains('(')).collect();
    let rows: Vec<&&str> =
        rows.iter().filter(|row| row.contains("true obstacle") || row.contains("unknown")).collect();
    let starts = ["bad", "dull", "good"].map(|name| format!("| L1    | {name} "));
    assert_eq!(rows.len(), 3, "{text}");
    assert!(rows.iter().zip(&starts).all(|(row, start)| row.starts_with(start)), "{text}");
    assert!(rows[0].contains("lethal up to 0.2 m before a true obstacle (0.03)"), "{text}");
    assert!(rows[1].contains("obstacles left unknown (0.12)"), "{text}");
    assert!(!text.contains("Frontier"), "it was not asked for");
}

#[test]
fn the_frontier_names_its_keys_in_order() {
    let mut scene = scene("a", "L1", 10);
    let tally = scene.methods["drm"].clone();
    for key in ["evidence_exponent: 12", "evidence_exponent: 2", "tau: 0.45"] {
        scene.methods.insert(key.into(), tally.clone());
    }
    let text = Report::new("frontier", &[scene]).text();
    let place = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part}: {text}"));
    assert!(place("evidence_exponent: 2 ") < place("evidence_exponent: 12"), "{text}");
    assert!(place("evidence_exponent: 12") < place("as configured"), "{text}");
    assert_eq!(text.matches("evidence_exponent: 12").count(), 1, "no method of its own: {text}");
}

#[test]
fn the_page_is_safe_and_complete() {
    let mut report = report();
    report.scenes[0].1 = Some("a.png".into());
    let html = report.html();
    assert!(html.contains("two &lt;scenes&gt;") && !html.contains("<scenes>"));
    assert!(html.contains("src=\"a.png\"") && html.matches("<img").count() == 1);
    assert_eq!(html.matches("<table>").count(), 4);
}
