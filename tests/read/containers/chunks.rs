//! Chunks that say what is not so: nothing is taken on their word.

use std::io::Write as _;
use std::time::{Duration, Instant};

use limpid::input::points;
use mcap::{Compression, WriteOptions};

use super::{FRAMES, expected, folder, mcap_with, messages, read, says};

/// How many chunks of zeros a recording has here: a few megabytes, which unpack to more than a hundred GiB.
const CHUNKS: usize = 300;

/// Far less than it takes to go through the zeros, far more than it takes not to.
const AT_ONCE: Duration = Duration::from_secs(20);

fn chunk(compression: &str, size: u64, crc: u32, packed: &[u8]) -> Vec<u8> {
    let mut body = [0_u64, 0, size].map(u64::to_le_bytes).concat();
    body.extend(crc.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((packed.len() as u64).to_le_bytes());
    body.extend(packed);
    record(6, &body)
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn zstd_of(start: &[u8], zeros: u64) -> Vec<u8> {
    let mut packing = zstd::Encoder::new(Vec::new(), 1).unwrap();
    packing.write_all(start).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), zeros), &mut packing).unwrap();
    packing.finish().unwrap()
}

fn lz4_of(zeros: u64) -> Vec<u8> {
    let mut packing = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), zeros), &mut packing).unwrap();
    packing.finish().0
}

/// The recording with records put in after its first bytes.
fn with(records: &[Vec<u8>]) -> Vec<u8> {
    let options = WriteOptions::new().compression(Some(Compression::Lz4)).chunk_size(Some(256));
    let whole = mcap_with(&messages(), options.emit_summary_records(false).emit_summary_offsets(false));
    let (magic, rest) = whole.split_at(8);
    [magic, &records.concat(), rest].concat()
}

#[track_caller]
fn damaged(records: &[Vec<u8>], reason: &str) {
    let file = folder(&[("run.mcap", with(records))]);
    let start = Instant::now();
    let (frames, report) = read(&file.path().join("run.mcap")).unwrap();
    assert!(start.elapsed() < AT_ONCE, "{:?}", start.elapsed());
    assert!(frames == expected(), "the other chunks are read: {} frames", frames.len());
    says(&report.notes, &["chunk at byte 8 is damaged", reason]);
    let told = report.notes.iter().filter(|note| note.contains("is damaged")).count();
    assert!(told == records.len() || told > 200, "each is told, up to a bound: {told}");
}

#[test]
fn zeros_are_no_records_whatever_packs_them() {
    let many = 500 << 20;
    let zeros = vec![0; 1 << 20];
    // The checksum of so many zeros, and none.
    let mut crc = crc32fast::Hasher::new();
    (0..500).for_each(|_| crc.update(&zeros));
    let packed = zstd_of(&[], many);
    for crc in [0, crc.finalize()] {
        damaged(&vec![chunk("zstd", many, crc, &packed); CHUNKS], "opcode 0");
    }
    damaged(&[chunk("lz4", 64 << 20, 0, &lz4_of(64 << 20))], "opcode 0");
    damaged(&[chunk("", 1 << 20, 0, &zeros)], "opcode 0");
    damaged(&vec![chunk("zstd", 8 << 20, 7, &zstd_of(&[], 8 << 20)); CHUNKS], "opcode 0");
    // After records that are right, too.
    let start = record(5, &[0; 30]);
    damaged(&[chunk("zstd", 500 << 20, 7, &zstd_of(&start, 500 << 20))], "opcode 0");
    damaged(&[chunk("zstd", 500 << 20, 0, &zstd_of(&start, 500 << 20))], "opcode 0");
}

#[test]
fn sizes_that_contradict_each_other_are_damage() {
    let message = record(5, &[0; 30]);
    damaged(&[chunk("zstd", 2 << 30, 0, &zstd_of(&[], 1 << 20))], "unpacks to 2048 MiB, more than 512");
    damaged(&[chunk("zstd", 20, 0, &zstd_of(&message, 0))], "longer than the rest");
    damaged(&[chunk("zstd", 39 + 9, 0, &zstd_of(&message, 0))], "ends within a record");
    damaged(&[chunk("zstd", 0, 0, &zstd_of(&message, 0))], "more than it says");
    damaged(&[chunk("zstd", 39, 7, &zstd_of(&message, 0))], "checksum");
    damaged(&[chunk("zstd", 40 << 20, 7, &zstd_of(&record(200, &vec![0; (40 << 20) - 9]), 0))], "checksum");
    damaged(&[chunk("brotli", 39, 0, &message)], "`brotli` is neither zstd nor lz4");
    damaged(&[chunk("zstd", 39, 0, &message)], "");
    let long = [&[5][..], &(1_u64 << 60).to_le_bytes(), &[0; 30]].concat();
    damaged(&[chunk("", long.len() as u64, 0, &long)], "longer than the rest");
    let short = record(5, &[0; 10]);
    damaged(&[chunk("", short.len() as u64, 0, &short)], "shorter than its header");
    let mut body = vec![0; 28];
    body.extend(u32::MAX.to_le_bytes());
    damaged(&[record(6, &body)], "header is cut short");
}

#[test]
fn large_chunks_with_a_right_checksum_are_read() {
    // Larger than what is held, most of it a record that nobody reads.
    let filler = record(200, &vec![3; 20 << 20]);
    let packed = zstd::encode_all(&filler[..], 1).unwrap();
    let good = chunk("zstd", filler.len() as u64, crc32fast::hash(&filler), &packed);
    let file = folder(&[("run.mcap", with(&[good]))]);
    let (frames, report) = read(&file.path().join("run.mcap")).unwrap();
    assert_eq!(frames.len(), usize::from(FRAMES));
    assert!(!report.notes.iter().any(|note| note.contains("damaged")), "{:?}", report.notes);
}

/// A cloud of 30 million points, all of them 0, in 50 kB.
fn endless_cloud() -> Vec<u8> {
    use limpid::message::ros2::{PointCloud2, PointField, encode_cdr};
    let field = |(name, offset): (&str, u32)| PointField { name: name.into(), offset, datatype: 7, count: 1 };
    let points = 30_000_000;
    let cloud = PointCloud2 {
        header: super::super::synthetic::header(super::at_ms(0), "lidar"),
        height: 1,
        width: points,
        fields: [("x", 0), ("y", 4), ("z", 8), ("intensity", 12)].map(field).to_vec(),
        is_bigendian: 0,
        point_step: 16,
        row_step: 16 * points,
        data: Vec::new(),
        is_dense: 1,
    };
    let mut start = encode_cdr("", &cloud).unwrap();
    // The length of the data, and `is_dense`.
    let length_at = start.len() - 5;
    start.truncate(length_at);
    start.extend((16 * points).to_le_bytes());
    let data_bytes = 16 * u64::from(points) + 1;
    let mut message =
        [&[5][..], &(22 + start.len() as u64 + data_bytes).to_le_bytes(), &[1, 0], &[0; 20]].concat();
    message.extend(&start);
    let size = message.len() as u64 + data_bytes;
    let schema =
        [&[1, 0, 27, 0, 0, 0][..], b"sensor_msgs/msg/PointCloud2", &[7, 0, 0, 0], b"ros2msg", &[0; 4]]
            .concat();
    let channel = [&[1, 0, 1, 0, 7, 0, 0, 0][..], b"/points", &[3, 0, 0, 0], b"cdr", &[0; 4]].concat();
    let chunk = chunk("zstd", size, 0, &zstd_of(&message, data_bytes));
    [mcap::MAGIC, &record(3, &schema), &record(4, &channel), &chunk, &record(15, &[0; 4]), mcap::MAGIC]
        .concat()
}

#[test]
fn a_cloud_of_30_million_points_in_a_small_file_is_passed_over() {
    let file = folder(&[("run.mcap", endless_cloud())]);
    let path = file.path().join("run.mcap");
    assert!(std::fs::metadata(&path).unwrap().len() < 100_000);
    let mut scans = points::open(&path, &Default::default()).unwrap();
    assert!(scans.next_scan().unwrap().is_none());
    says(&scans.report().read.notes, &["a message of 457 MiB in the chunk", "at most 128 MiB"]);
}

/// Under a limit of memory: what a process takes, not what a test sees.
#[test]
#[cfg(target_os = "linux")]
fn small_files_take_little_memory_whatever_they_say() {
    let zeros = zstd_of(&[], 400 << 20);
    let image = [
        &b"ply\nformat binary_little_endian 1.0\nelement vertex 30000000\n"[..],
        b"property float x\nend_header\n",
    ]
    .concat();
    let pcd = b"VERSION 0.7\nFIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 30000000\nHEIGHT 1\nPOINTS 30000000\nDATA binary\n";
    let files = folder(&[
        ("cloud.mcap", endless_cloud()),
        ("zeros.mcap", with(&[chunk("zstd", 400 << 20, 0, &zeros)])),
        ("zeros.db3.zst", zstd_of(b"SQLite format 3\0", 100)),
        ("zeros.mcap.zst", zstd_of(mcap::MAGIC, 400 << 20)),
        ("a.ply", image),
        ("a.pcd", pcd.to_vec()),
    ]);
    for entry in std::fs::read_dir(files.path()).unwrap() {
        let path = entry.unwrap().path();
        // Virtual memory, kB; without limits the cloud takes 2.35 GB.
        let limited = "ulimit -v 400000; exec \"$0\" points \"$1\" -o \"$2\"";
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", limited, env!("CARGO_BIN_EXE_limpid")]).arg(&path).arg(files.path().join("out"));
        let output = shell.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{path:?}: {:?} {said}", output.status);
        assert!(!said.contains("memory") && !said.contains("panicked"), "{path:?}: {said}");
    }
}

#[test]
fn images_that_say_more_than_their_bytes_can_hold_are_refused() {
    use image::{DynamicImage, ImageFormat};
    use limpid::input::image_decode::{color_from_file, depth_from_file};
    let file = |format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        DynamicImage::new_rgb8(64, 64).write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    let mut png = file(ImageFormat::Png);
    // The size in the header, and the checksum of that.
    png[16..24].copy_from_slice(&[8000_u32, 8000].map(u32::to_be_bytes).concat());
    let crc = crc32fast::hash(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let text = color_from_file(&png).unwrap_err().to_string();
    assert!(text.contains("8000x8000") && text.contains("bytes can hold"), "{text}");
    let mut jpeg = file(ImageFormat::Jpeg);
    let size_at = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap() + 5;
    jpeg[size_at..size_at + 4].copy_from_slice(&[8000_u16, 8000].map(u16::to_be_bytes).concat());
    let text = color_from_file(&jpeg).unwrap_err().to_string();
    assert!(text.contains("8000x8000") && text.contains("bytes can hold"), "{text}");
    // What is plain packs best, and is read.
    let mut plain = std::io::Cursor::new(Vec::new());
    DynamicImage::new_luma16(2000, 2000).write_to(&mut plain, ImageFormat::Png).unwrap();
    assert!(depth_from_file(plain.get_ref(), 0.001).is_ok());
    let mut plain = std::io::Cursor::new(Vec::new());
    DynamicImage::new_rgb8(2000, 2000).write_to(&mut plain, ImageFormat::Jpeg).unwrap();
    assert!(color_from_file(plain.get_ref()).is_ok());
}
