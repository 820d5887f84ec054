//! A series of trials goes on where it was.

use limpid::Config;
use limpid::offline::trial::world::APART_M;
use limpid::offline::trial::{CameraMode, Course, Outcome, Report, Scenario};
use limpid::sim::generate::Level;

fn course(keep: Option<&std::path::Path>, drift: f64) -> Course {
    let keep = keep.map(std::path::Path::to_owned);
    Course::new(&Config::default(), CameraMode::Small, drift, keep).unwrap()
}

#[test]
fn kept_trials_are_taken_where_their_settings_hold() {
    let folder = tempfile::tempdir().unwrap();
    let first = course(Some(folder.path()), 0.0);
    let trial = &first.trials(Scenario::Dying, &[Level::L0], &[], &[6000])[0];
    let context = crate::support::gpu::context();
    let (record, made) = first.run(&context, trial).unwrap();
    assert!(made && matches!(record.outcome, Outcome::Halted { .. }), "{}", record.line());
    let (again, made) = course(Some(folder.path()), 0.0).run(&context, trial).unwrap();
    assert!(!made);
    assert_eq!((again.line(), again.outcome.name()), (record.line(), record.outcome.name()));
    assert_eq!((again.pictures.len(), again.steps.len()), (record.pictures.len(), record.steps.len()));
}

#[test]
fn a_kept_trial_that_is_cut_off_or_of_other_settings_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let first = course(Some(folder.path()), 0.0);
    // There is no way through the scenes of this seed, so that making it takes no time.
    let trial = &first.trials(Scenario::Glass, &[], &["default".into()], &[6103])[0];
    let context = crate::support::gpu::context();
    let (record, made) = first.run(&context, trial).unwrap();
    assert!(made && matches!(record.outcome, Outcome::Impossible { .. }), "{}", record.line());
    assert!(!first.run(&context, trial).unwrap().1);
    let path = folder.path().join("glass-L0-default-6103.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    assert!(first.run(&context, trial).unwrap().1);
    assert!(course(Some(folder.path()), 0.01).run(&context, trial).unwrap().1);
}

#[test]
fn figures_of_another_run_are_taken_where_their_settings_hold() {
    let folder = tempfile::tempdir().unwrap();
    let context = crate::support::gpu::context();
    let first = course(None, 0.0);
    let trial = &first.trials(Scenario::Glass, &[], &["default".into()], &[6103])[0];
    let (record, _) = first.run(&context, trial).unwrap();
    let path = folder.path().join("trials.json");
    std::fs::write(&path, Report { records: vec![record.clone()] }.json().to_string()).unwrap();
    let with = |drift: f64| {
        let mut course = course(None, drift);
        course.take(&path).unwrap();
        course
    };
    let (taken, made) = with(0.0).run(&context, trial).unwrap();
    assert!(!made && taken == record.figures() && taken.line() == record.line());
    assert!(with(0.01).run(&context, trial).unwrap().1, "other settings");
    let other = &first.trials(Scenario::Glass, &[], &["adaptive".into()], &[6103])[0];
    assert!(with(0.0).run(&context, other).unwrap().1, "another method");
    std::fs::write(&path, "{\"trials\": [{}]}").unwrap();
    let error = course(None, 0.0).take(&path).unwrap_err().to_string();
    assert!(error.contains("trials.json") && error.contains("scenario"), "{error}");
}

#[test]
fn all_methods_of_a_seed_have_one_task() {
    let course = course(None, 0.0);
    let trials = course.trials(Scenario::Glare, &[Level::L2], &[], &[6000]);
    assert_eq!(
        trials.iter().map(|trial| trial.setup.key).collect::<Vec<_>>(),
        ["naive", "range", "median", "temporal", "drm"]
    );
    let worlds: Vec<_> = [&trials[0], &trials[4]].map(|trial| course.world(trial).unwrap()).into();
    assert_eq!(
        (&worlds[0].scene, worlds[0].start, worlds[0].goal),
        (&worlds[1].scene, worlds[1].start, worlds[1].goal)
    );
    let apart_m = worlds[0].start.at.distance(worlds[0].goal);
    assert!((APART_M[0]..=APART_M[1]).contains(&apart_m), "{apart_m}");
    assert!(worlds[0].ideal_m() >= apart_m - 1e-9);
}

#[test]
fn what_cannot_be_asked_for_is_refused() {
    assert!(Course::new(&Config::default(), CameraMode::Small, 0.9, None).is_err());
    assert!(Course::new(&Config::default(), CameraMode::Small, f64::NAN, None).is_err());
    let missing = Config { weights: "/nowhere/at/all".into(), ..Config::default() };
    assert!(Course::new(&missing, CameraMode::Small, 0.0, None).is_err());
}

#[test]
fn tasks_ask_for_what_their_scenario_is_about_or_say_that_none_does() {
    let course = course(None, 0.0);
    for scenario in [Scenario::Glass, Scenario::Curtain, Scenario::Both] {
        let trials = course.trials(scenario, &[], &["default".into(), "both".into()], &[6101, 6103]);
        let worlds: Vec<_> = trials.iter().map(|trial| course.world(trial).unwrap()).collect();
        assert!(worlds.iter().any(|world| world.impossible.is_none()), "{scenario:?}");
        for world in worlds {
            match &world.impossible {
                Some(reason) => assert!(reason.contains("of this seed"), "{reason}"),
                None => assert!(!world.ideal.is_empty()),
            }
        }
    }
}
