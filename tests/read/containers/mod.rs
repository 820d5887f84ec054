//! One recording in all the files that people have it in.

mod chunks;
mod field;
mod folders;
mod hostile;
mod packed;
mod sqlite;
mod streams;

use std::path::Path;

use limpid::input::{ReadReport, open};
use limpid::message::ros2;
use limpid::sensor::RgbdFrame;
use limpid::{Config, Result};
use mcap::WriteOptions;
use rusqlite::{Connection, params};

use super::read_all;
use super::synthetic::{DEPTH, DEPTH_INFO, FRAME, Recorder, at_ms, camera_info, depth_image, transform};

/// Depth images of the recording.
const FRAMES: u16 = 12;

/// A message as any file holds it.
#[derive(Debug, Clone)]
struct Message {
    topic: &'static str,
    type_name: &'static str,
    stamp_ns: u64,
    data: Vec<u8>,
}

impl Message {
    fn new<T: serde::Serialize>(topic: &'static str, type_name: &'static str, ms: u64, message: &T) -> Self {
        let data = ros2::encode_cdr(type_name, message).unwrap();
        Self { topic, type_name, stamp_ns: at_ms(ms), data }
    }

    fn transform(topic: &'static str, ms: u64, frames: [&str; 2], translation: [f64; 3]) -> Self {
        let transforms = vec![transform(at_ms(ms), frames, translation, [0.0, 0.0, 0.0, 1.0])];
        Self::new(topic, "tf2_msgs/msg/TFMessage", ms, &ros2::TFMessage { transforms })
    }

    fn packed(self) -> Self {
        Self { data: zstd::encode_all(&self.data[..], 1).unwrap(), ..self }
    }
}

/// Twelve depth images of a robot that drives; the camera's place and calibration come once, at the start.
fn messages() -> Vec<Message> {
    let mut messages = vec![
        Message::transform("/tf_static", 0, ["base_link", FRAME], [0.1, 0.0, 0.5]),
        Message::new(DEPTH_INFO, "sensor_msgs/msg/CameraInfo", 0, &camera_info(at_ms(0), FRAME)),
    ];
    for number in 0..FRAMES {
        let ms = 100 * u64::from(number);
        messages.push(Message::transform("/tf", ms, ["map", "base_link"], [f64::from(number), 0.0, 0.0]));
        let image = depth_image(at_ms(ms), 1000 + number);
        messages.push(Message::new(DEPTH, "sensor_msgs/msg/Image", ms, &image));
    }
    messages
}

/// The recording in three parts, each with all its topics written as it starts, as rosbag2 does.
fn parts() -> Vec<Vec<Message>> {
    let messages = messages();
    vec![messages[..9].to_vec(), messages[9..18].to_vec(), messages[18..].to_vec()]
}

fn mcap_with(messages: &[Message], options: WriteOptions) -> Vec<u8> {
    let mut recorder = Recorder::with(options);
    for message in messages {
        recorder.bytes(message.topic, message.type_name, "cdr", message.stamp_ns, &message.data);
    }
    recorder.finish()
}

fn mcap(messages: &[Message]) -> Vec<u8> {
    mcap_with(messages, WriteOptions::new().compression(None).chunk_size(Some(256)))
}

/// rosbag2's tables, its topics in the reverse of the order of their first messages.
fn fill(connection: &mut Connection, messages: &[Message]) {
    connection
        .execute_batch(
            "CREATE TABLE IF NOT EXISTS topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,\
             serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);\
             CREATE TABLE IF NOT EXISTS messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,\
             timestamp INTEGER NOT NULL, data BLOB NOT NULL);\
             CREATE INDEX IF NOT EXISTS timestamp_idx ON messages (timestamp ASC);",
        )
        .unwrap();
    let mut topics: Vec<(&str, &str)> = Vec::new();
    for message in messages {
        let topic = (message.topic, message.type_name);
        if !topics.contains(&topic) {
            topics.insert(0, topic);
        }
    }
    let writing = connection.transaction().unwrap();
    for (id, (name, type_name)) in topics.iter().enumerate() {
        let row = "INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr', '')";
        writing.execute(row, params![id as i64 + 1, name, type_name]).unwrap();
    }
    for message in messages {
        let id = topics.iter().position(|topic| topic.0 == message.topic).unwrap() as i64 + 1;
        let row = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        writing.execute(row, params![id, message.stamp_ns as i64, message.data]).unwrap();
    }
    writing.commit().unwrap();
}

fn write_db3(path: &Path, messages: &[Message]) {
    let mut connection = Connection::open(path).unwrap();
    connection.execute_batch("PRAGMA page_size = 512").unwrap();
    fill(&mut connection, messages);
}

fn db3(messages: &[Message]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bag.db3");
    write_db3(&path, messages);
    std::fs::read(path).unwrap()
}

fn metadata(files: &[&str]) -> String {
    let files: String = files.iter().map(|file| format!("    - {file}\n")).collect();
    format!(
        "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n{files}  compression_format: ''\n"
    )
}

/// A folder of these files.
fn folder(files: &[(&str, Vec<u8>)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn read(path: &Path) -> Result<(Vec<RgbdFrame>, ReadReport)> {
    struct Any(Box<dyn limpid::input::Recording>);
    impl limpid::input::Recording for Any {
        fn next_frame(&mut self) -> Result<Option<RgbdFrame>> {
            self.0.next_frame()
        }
        fn report(&self) -> &ReadReport {
            self.0.report()
        }
        fn frame_count_hint(&self) -> Option<u64> {
            self.0.frame_count_hint()
        }
    }
    read_all(Any(open(path, &Config::default())?))
}

/// The frames of the recording as one MCAP file.
fn expected() -> Vec<RgbdFrame> {
    let folder = folder(&[("whole.mcap", mcap(&messages()))]);
    let (frames, report) = read(&folder.path().join("whole.mcap")).unwrap();
    assert_eq!(frames.len(), usize::from(FRAMES));
    assert!(frames.iter().all(|frame| frame.pose.is_some()), "{report:?}");
    frames
}

/// Asserts that a path holds the whole recording; what was noted.
#[track_caller]
fn whole(path: &Path) -> Vec<String> {
    let (frames, report) = read(path).unwrap();
    assert!(report.skipped.is_empty(), "{report:?}");
    assert!(frames == expected(), "{} frames; {report:?}", frames.len());
    report.notes
}

/// Asserts that reading fails, and with which words.
#[track_caller]
fn refused(path: &Path, parts: &[&str]) {
    let text = read(path).unwrap_err().to_string();
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
}

/// Asserts that a note has all the parts.
#[track_caller]
fn says(notes: &[String], parts: &[&str]) {
    assert!(notes.iter().any(|note| parts.iter().all(|part| note.contains(part))), "{notes:?}");
}
