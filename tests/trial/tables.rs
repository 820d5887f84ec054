//! Figures of tables from records that are made up, and the page.

use limpid::offline::trial::record::Depth;
use limpid::offline::trial::{Label, Limits, Outcome, Record, Report, Terms, drive, replay};

use super::{config, hall, label, setup, world};

/// A record of a hall, changed.
fn record(method: &str, outcome: Outcome, change: impl Fn(&mut Record)) -> Record {
    let mut world = world(&hall(), [5.0, 0.0]);
    world.impossible = Some("made up".into());
    let label = Label { scenario: "glare".into(), level: "L2".into(), ..label() };
    let context = crate::support::gpu::context();
    let terms = Terms::default();
    let mut record = drive(&context, &world, &setup(config()), &Limits::default(), terms, &label).unwrap();
    (record.method, record.outcome, record.ideal_m) = (method.into(), outcome, 10.0);
    (record.driven_m, record.left_m, record.time_s) = (10.0, 0.0, 30.0);
    record.depth = Some(Depth { holes: 0.4, spikes: 0.3 });
    change(&mut record);
    record
}

fn report() -> Report {
    let arrived = || Outcome::Arrived;
    let records = vec![
        record("drm", arrived(), |r| (r.driven_m, r.left_m, r.stops) = (9.8, 0.3, 2)),
        record("drm", arrived(), |r| (r.driven_m, r.time_s) = (14.0, 50.0)),
        record("drm", Outcome::Collision { with: "boxes[3]".into() }, |r| r.driven_m = 2.0),
        record("drm", Outcome::Frozen, |r| (r.driven_m, r.stops) = (5.0, 1)),
        record("drm", Outcome::Impossible { reason: "no <way>".into() }, |_| {}),
        record("naive", Outcome::Timeout, |_| {}),
    ];
    Report { records }
}

#[test]
fn figures_follow_from_the_records() {
    let json = report().json();
    let drm = &json["settings"][0];
    assert_eq!((drm["method"].as_str(), drm["trials"].as_u64()), (Some("drm"), Some(4)));
    assert_eq!((drm["arrived"].as_u64(), drm["collisions"].as_u64()), (Some(2), Some(1)));
    assert_eq!((drm["frozen"].as_u64(), drm["timeouts"].as_u64()), (Some(1), Some(0)));
    let mean = |key: &str| drm[key][0].as_f64().unwrap();
    // 2 in 9.8 m, 0, 0, 1 in 5 m.
    assert!((mean("stops_per_10_m") - (20.0 / 9.8 + 2.0) / 4.0).abs() < 1e-9);
    assert!((mean("ratio") - (1.01 + 1.4) / 2.0).abs() < 1e-9);
    assert!((drm["detours_percent"].as_f64().unwrap() - 50.0).abs() < 1e-9);
    assert!((mean("time_s") - 40.0).abs() < 1e-9);
    assert!(json["settings"][1]["ratio"].is_null(), "none arrived");
}

#[test]
fn tables_have_the_papers_figures_beside_and_name_every_failure() {
    let text = report().text();
    let row = text.lines().find(|line| line.contains("| drm ") && line.contains("91.4")).unwrap_or(&text);
    for part in ["glare L2", "50.0", "0.85", "1.08"] {
        assert!(row.contains(part), "{part} is not in {row}");
    }
    for part in ["collision with boxes[3]", "frozen", "timeout", "impossible: no <way>"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn the_page_is_one_file_and_holds_every_trial() {
    let page = replay::page(&report());
    for outside in ["http://", "https://", "src=", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let data = page.split("const trials = ").nth(1).unwrap().split(";\n").next().unwrap();
    let trials: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(trials.as_array().unwrap().len(), 6);
    assert!(!data.contains('<'), "no text can end the script");
    assert_eq!(trials[0]["outlines"].as_array().unwrap().len(), 4);
    assert!(page.contains("impossible: no &lt;way&gt;"));
}
