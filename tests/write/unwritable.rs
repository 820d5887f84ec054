//! Outputs that cannot be written give errors that name the path.

use std::path::Path;

use limpid::output::{DumpSink, McapSink, PngSink, Sink, save_map};
use limpid::{Config, Error, Result};
use tempfile::TempDir;

use crate::support::sample;

fn write_one(mut sink: impl Sink) -> Result<()> {
    sink.write(&sample::output(), Some(&sample::input()))?;
    sink.finish()
}

fn mcap(path: &Path) -> Result<()> {
    write_one(McapSink::create(path, &Config::default(), &sample::alone())?)
}

fn png(path: &Path) -> Result<()> {
    write_one(PngSink::create(path, &Config::default(), &sample::alone())?)
}

fn dump(path: &Path) -> Result<()> {
    write_one(DumpSink::create(path, &Config::default(), &sample::alone())?)
}

fn map(path: &Path) -> Result<()> {
    save_map(path, &sample::output().map.unwrap()).map(|_| ())
}

type Write = fn(&Path) -> Result<()>;

const WRITERS: [(&str, Write); 4] = [("mcap", mcap), ("png", png), ("dump", dump), ("map", map)];

/// The error is of the operating system and names `path` or something in it.
fn assert_names(writer: &str, result: Result<()>, path: &Path) {
    match result {
        Err(Error::File { path: named, .. }) => {
            let (named, path) = (named.display().to_string(), path.display().to_string());
            assert!(named.starts_with(&path), "{writer}: {named} does not name {path}");
        }
        other => panic!("{writer} at {}: {other:?}", path.display()),
    }
}

#[test]
fn missing_parent() {
    let folder = TempDir::new().unwrap();
    for (writer, write) in WRITERS {
        let path = folder.path().join("missing").join("out");
        assert_names(writer, write(&path), &path);
        assert!(!folder.path().join("missing").exists(), "{writer} made the parent");
    }
}

#[test]
fn a_file_where_a_folder_must_be() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "text").unwrap();
    for (writer, write) in &WRITERS[1..3] {
        assert_names(writer, write(&file), &file);
    }
    for (writer, write) in WRITERS {
        assert_names(writer, write(&file.join("out")), &file);
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), "text");
}

#[test]
fn a_folder_where_a_file_must_be() {
    let folder = TempDir::new().unwrap();
    assert_names("mcap", mcap(folder.path()), folder.path());
    std::fs::create_dir(folder.path().join("000012-costmap.png")).unwrap();
    assert_names("png", png(folder.path()), folder.path());
    std::fs::write(folder.path().join("000012"), "text").unwrap();
    assert_names("dump", dump(folder.path()), folder.path());
}

#[test]
fn a_disk_that_is_full_or_read_only() {
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped: no /dev/full");
        return;
    }
    assert_names("mcap", mcap(Path::new("/dev/full")), Path::new("/dev/full"));
    // Nothing can be created there, not even by root.
    for (writer, write) in WRITERS {
        assert_names(writer, write(Path::new("/proc/limpid")), Path::new("/proc/limpid"));
    }
}

#[test]
fn the_same_writers_work_where_they_can() {
    let (_temporary, folder) = sample::output_folder();
    for (writer, write) in WRITERS {
        write(&folder.join(format!("sample-{writer}"))).unwrap();
    }
}
