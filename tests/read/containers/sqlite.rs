//! SQLite bags: what lies beside them, what is cut off, what is no bag.

use rusqlite::Connection;

use super::{FRAMES, db3, expected, fill, folder, messages, read, refused, says, whole, write_db3};

#[test]
fn a_bag_in_one_file_is_read_in_full() {
    let bag = folder(&[("bag.db3", db3(&messages()))]);
    let notes = whole(&bag.path().join("bag.db3"));
    assert_eq!(notes.len(), 1, "only the topics are told: {notes:?}");
    let names: Vec<_> =
        std::fs::read_dir(bag.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["bag.db3"], "nothing is made beside it");
}

#[test]
fn paths_of_any_letters_are_opened() {
    let bag = folder(&[("50% of #1?mode=rw&ä.db3", db3(&messages()))]);
    whole(&bag.path().join("50% of #1?mode=rw&ä.db3"));
}

/// A recorder that was killed leaves its messages in the log beside.
fn killed() -> tempfile::TempDir {
    let recording = tempfile::tempdir().unwrap();
    let path = recording.path().join("bag.db3");
    let mut connection = Connection::open(&path).unwrap();
    connection.execute_batch("PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0").unwrap();
    fill(&mut connection, &messages());
    let left = |name: &str| std::fs::read(recording.path().join(name)).unwrap();
    folder(&[("bag.db3", left("bag.db3")), ("bag.db3-wal", left("bag.db3-wal"))])
}

#[test]
fn messages_in_a_write_ahead_log_are_read() {
    let bag = killed();
    let before = std::fs::read(bag.path().join("bag.db3")).unwrap();
    assert!(before.len() < 8192, "all is in the log");
    whole(&bag.path().join("bag.db3"));
    whole(bag.path());
    let mut names: Vec<_> =
        std::fs::read_dir(bag.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["bag.db3", "bag.db3-wal"], "nothing is made, nothing removed");
    assert!(std::fs::read(bag.path().join("bag.db3")).unwrap() == before, "nothing is written");
}

#[test]
fn a_journal_beside_is_told() {
    let bag = folder(&[("bag.db3", db3(&messages())), ("bag.db3-journal", vec![1; 600])]);
    says(&whole(&bag.path().join("bag.db3")), &["bag.db3-journal", "broke off"]);
}

#[test]
fn a_bag_that_is_cut_off_gives_the_messages_before_the_cut() {
    let bytes = db3(&messages());
    let mut counts = Vec::new();
    for cut in (512..bytes.len()).step_by(512) {
        let bag = folder(&[("bag.db3", bytes[..cut].to_vec())]);
        // The calibration and the tables have to be there.
        let Ok((frames, report)) = read(&bag.path().join("bag.db3")) else { continue };
        let same = frames.iter().zip(expected()).all(|(frame, expected)| frame.depth == expected.depth);
        assert!(same, "cut at {cut}");
        says(&report.notes, &["cut off or damaged", "lost"]);
        counts.push(frames.len());
    }
    assert!(counts.is_sorted(), "{counts:?}");
    assert!(counts.iter().any(|&count| (2..9).contains(&count)), "{counts:?}");
    assert!(counts.len() > 5, "{counts:?}");
}

#[test]
fn damage_in_the_middle_costs_what_lies_there() {
    let bytes = db3(&messages());
    let (mut middle, mut most, mut tables) = (0, 0, 0);
    for page in bytes.len() / 512 / 3..bytes.len() / 512 {
        let mut damaged = bytes.clone();
        damaged[page * 512..(page + 1) * 512].fill(0xff);
        let bag = folder(&[("bag.db3", damaged)]);
        let Ok((frames, report)) = read(&bag.path().join("bag.db3")) else {
            tables += 1;
            continue;
        };
        let lost = usize::from(FRAMES) - frames.len();
        if lost > 0 {
            assert!(report.notes.iter().any(|note| note.contains("lost")), "page {page}: {report:?}");
            let last = frames.last().map(|frame| frame.depth.stamp_ns);
            middle += usize::from(last == expected().last().map(|frame| frame.depth.stamp_ns));
        }
        most = most.max(lost);
    }
    assert!(tables < 4, "{tables} pages are those of the tables themselves");
    assert!(middle > 2, "messages after the damage are read");
    assert!((1..=8).contains(&most), "{most} lost by a page");
}

#[test]
fn other_databases_are_refused_for_what_they_lack() {
    let other = folder(&[]);
    let path = other.path().join("notes.db3");
    Connection::open(&path).unwrap().execute_batch("CREATE TABLE notes(text TEXT)").unwrap();
    refused(&path, &["notes.db3", "topics", "messages"]);
    let path = other.path().join("views.db3");
    let views = "CREATE VIEW topics AS SELECT 1; CREATE VIEW messages AS SELECT 1 AS id, zeroblob(1000000000) AS data";
    Connection::open(&path).unwrap().execute_batch(views).unwrap();
    refused(&path, &["views.db3", "topics", "messages"]);
    let path = other.path().join("header.db3");
    std::fs::write(&path, b"SQLite format 3\0").unwrap();
    refused(&path, &["header.db3", "SQLite"]);
}

#[test]
fn a_message_that_is_too_large_is_passed_over() {
    let bag = folder(&[]);
    let path = bag.path().join("bag.db3");
    write_db3(&path, &messages());
    let connection = Connection::open(&path).unwrap();
    let row = "SELECT max(id) FROM messages";
    let row: i64 = connection.query_row(row, [], |row| row.get(0)).unwrap();
    connection.execute("UPDATE messages SET data = zeroblob(140000000) WHERE id = ?1", [row]).unwrap();
    drop(connection);
    let (frames, report) = read(&path).unwrap();
    assert_eq!(frames.len(), usize::from(FRAMES) - 1);
    says(&report.notes, &["a message of 133 MiB", "at most 128 MiB"]);
}
