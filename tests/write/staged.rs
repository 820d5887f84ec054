//! Files take their names when they are complete.

use std::fs;
use std::path::{Path, PathBuf};

use limpid::input::{Source, SourceReport};
use limpid::output::{McapSink, Sink, free_path, save_file};
use limpid::{Config, Error, Observation, Options, Result, SensorInfo, open_source, run};

use crate::support::gpu::skipped;
use crate::support::sample;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn an_mcap_takes_its_name_when_it_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.mcap");
    fs::write(&path, "old").unwrap();
    let mut sink = McapSink::create(&path, &Config::default(), &sample::alone()).unwrap();
    sink.write(&sample::output(), Some(&sample::input())).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["out.mcap", "out.partial.mcap"]);
    sink.finish().unwrap();
    assert_eq!(names(folder.path()), ["out.mcap"]);
    assert!(fs::read(&path).unwrap().ends_with(b"\x89MCAP0\r\n"));
}

#[cfg(unix)]
#[test]
fn a_link_to_an_output_stays_a_link_and_rights_stay_as_they_were() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["run-5.json", "latest.json"].map(|name| folder.path().join(name));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("run-5.json", &link).unwrap();
    save_file(&link, b"new").unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    assert!(link.is_symlink());
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(names(folder.path()), ["latest.json", "run-5.json"]);
    // One that leads nowhere yet leads to the new file.
    symlink("run-6.json", folder.path().join("next.json")).unwrap();
    save_file(&folder.path().join("next.json"), b"newer").unwrap();
    assert_eq!(fs::read_to_string(folder.path().join("run-6.json")).unwrap(), "newer");
}

#[test]
fn what_cannot_be_renamed_over_is_written_directly() {
    save_file(Path::new("/dev/null"), b"text").unwrap();
    let full = save_file(Path::new("/dev/full"), b"text");
    assert!(!Path::new("/dev/full").exists() || matches!(full, Err(Error::File { .. })), "{full:?}");
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(save_file(folder.path(), b"text"), Err(Error::File { .. })), "a folder");
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_free_path_is_the_path_itself_or_a_partial_one() {
    let taken = |names: &'static [&str]| move |path: &Path| !names.iter().any(|name| Path::new(name) == path);
    let free = |names| free_path(Path::new("a/map.v2.yaml"), taken(names));
    assert_eq!(free(&[]), PathBuf::from("a/map.v2.yaml"));
    assert_eq!(free(&["a/map.v2.yaml"]), PathBuf::from("a/map.v2.partial.yaml"));
    let both = &["a/map.v2.yaml", "a/map.v2.partial.yaml"];
    assert_eq!(free(both), PathBuf::from("a/map.v2.partial-2.yaml"));
}

/// A recording that breaks, or that its user stops, after some frames.
struct Ending {
    source: Box<dyn Source>,
    left: u32,
    breaks: bool,
}

impl Source for Ending {
    fn sensors(&self) -> &[SensorInfo] {
        self.source.sensors()
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        if self.left > 0 {
            self.left -= 1;
            return self.source.next();
        }
        let broken = Error::Format { path: "room.mcap".into(), reason: "breaks here".into() };
        if self.breaks { Err(broken) } else { Ok(None) }
    }

    fn report(&self) -> SourceReport {
        self.source.report()
    }

    fn count_hint(&self) -> Option<u64> {
        None
    }

    fn was_stopped(&self) -> bool {
        !self.breaks
    }
}

/// Runs three frames into a file; what comes of it.
fn run_to_an_end(path: &Path, breaks: bool) -> Result<limpid::RunReport> {
    let config = Config { method: limpid::config::Method::Range, ..Config::default() };
    let source = open_source("testdata/room.mcap".as_ref(), &config)?;
    let mut source = Ending { source, left: 3, breaks };
    let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(McapSink::create(path, &config, source.sensors())?)];
    run(&mut source, 0..u64::MAX, &config, &Options::default(), &mut sinks, &mut |_| ())
}

#[test]
fn a_run_that_fails_keeps_the_old_result_and_names_the_new_one() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.mcap");
    fs::write(&path, "old").unwrap();
    let Err(Error::Partial { cause, kept }) = run_to_an_end(&path, true) else { panic!("it must fail") };
    assert!(matches!(*cause, Error::Format { .. }), "{cause}");
    assert_eq!(kept, [folder.path().join("out.partial.mcap")]);
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert!(fs::read(&kept[0]).unwrap().ends_with(b"\x89MCAP0\r\n"));
    // Nor does it take the name of a complete one.
    fs::remove_file(&path).unwrap();
    run_to_an_end(&path, true).unwrap_err();
    assert_eq!(names(folder.path()), ["out.partial-2.mcap", "out.partial.mcap"]);
}

#[test]
fn a_run_that_its_user_stops_keeps_both() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.mcap");
    let report = run_to_an_end(&path, false).unwrap();
    assert!(report.stopped && report.taken() == 3, "{report:?}");
    assert_eq!((report.kept, names(folder.path())), (vec![path.clone()], vec!["out.mcap".to_owned()]));
    let report = run_to_an_end(&path, false).unwrap();
    assert_eq!(report.kept, [folder.path().join("out.partial.mcap")]);
    assert_eq!(names(folder.path()), ["out.mcap", "out.partial.mcap"]);
}
