//! PLY and PCD files, one and many.

use limpid::input::points::{Options, pcd, ply};
use limpid::output::save_scan;
use limpid::sensor::{DropReason, Point, ReturnType, Scan, Strength};

use super::make::{VLP16, lzf_plain, turning};
use super::velodyne::decode;
use super::{read_all, read_bytes, refused};

fn read_ply(bytes: &[u8]) -> limpid::Result<Scan> {
    ply::read(bytes, 0, &Options::default())
}

fn read_pcd(bytes: &[u8]) -> limpid::Result<Scan> {
    pcd::read(bytes, 0, &Options::default())
}

const PROPERTIES: &str = "property double x\nproperty float y\nproperty short z\nproperty uchar intensity\n\
                          property uint t\nproperty uchar ring\nproperty int label\n";

fn header(format: &str, vertices: usize, before: &str) -> String {
    format!("ply\nformat {format} 1.0\n{before}element vertex {vertices}\n{PROPERTIES}end_header\n")
}

/// The two vertices that all PLY tests write, each number in its type.
fn vertices(big_endian: bool) -> Vec<u8> {
    let order = |le: &[u8]| if big_endian { le.iter().rev().copied().collect() } else { le.to_vec() };
    let vertex = |x: f64, y: f32, z: i16, intensity: u8, t: u32, ring: u8, label: i32| {
        let parts = [
            order(&x.to_le_bytes()),
            order(&y.to_le_bytes()),
            order(&z.to_le_bytes()),
            vec![intensity],
            order(&t.to_le_bytes()),
            vec![ring],
            order(&label.to_le_bytes()),
        ];
        parts.concat()
    };
    [vertex(1.5, -2.5, 3, 200, 0, 4, 7), vertex(4.0, 5.0, -6, 0, 50_000_000, 63, 0)].concat()
}

#[track_caller]
fn assert_vertices(scan: &Scan) {
    let [a, b] = &scan.points[..] else { panic!("{scan:?}") };
    assert_eq!(
        (a.position_m(), a.intensity, a.ring, a.label, a.time_s),
        ([1.5, -2.5, 3.0], 200.0, 4, 7, 0.0)
    );
    assert_eq!(
        (b.position_m(), b.intensity, b.ring, b.label, b.time_s),
        ([4.0, 5.0, -6.0], 0.0, 63, 0, 0.05)
    );
    assert!(scan.columns.label && scan.columns.time && scan.columns.ring && !scan.columns.return_type);
    assert_eq!(a.return_type, ReturnType::Single);
}

#[test]
fn ply_is_read_in_all_encodings() {
    let text = "1.5 -2.5 3 200 0 4 7\n4 5 -6 0 50000000 63 0\n";
    assert_vertices(
        &read_ply(&[header("ascii", 2, "comment made by hand\n").as_bytes(), text.as_bytes()].concat())
            .unwrap(),
    );
    for (format, big_endian) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let bytes = [header(format, 2, "").into_bytes(), vertices(big_endian)].concat();
        assert_vertices(&read_ply(&bytes).unwrap());
    }
    // Elements before the vertices are passed over, lists in them too.
    let before = "element camera 2\nproperty uchar id\nproperty list uchar short values\n";
    let cameras = [1, 2, 0xaa, 0xaa, 0xaa, 0xaa, 2, 0];
    let bytes =
        [header("binary_little_endian", 2, before).into_bytes(), cameras.into(), vertices(false)].concat();
    assert_vertices(&read_ply(&bytes).unwrap());
}

#[test]
fn bad_ply_files_are_refused() {
    let whole = [header("binary_little_endian", 2, "").into_bytes(), vertices(false)].concat();
    refused(read_ply(&whole[..whole.len() - 1]), &["PLY", "vertex"]);
    for cut in 0..whole.len() {
        assert!(read_ply(&whole[..cut]).is_err(), "cut at {cut}");
    }
    refused(
        read_ply(header("ascii", 4_000_000_000, "").as_bytes()),
        &["4000000000 of element `vertex` do not fit"],
    );
    let empty = "ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n";
    refused(read_ply(empty.as_bytes()), &["4000000000 of element `vertex`"]);
    refused(read_ply(b"ply\nformat ascii 1.0\nelement face 0\nend_header\n"), &["no element `vertex`"]);
    let list = "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n1 2\n";
    refused(read_ply(list.as_bytes()), &["PLY", "`x`"]);
    let flat =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n";
    refused(read_ply(flat.as_bytes()), &["no field `z`", "x, y"]);
    let scan = read_ply(header("ascii", 0, "").as_bytes()).unwrap();
    assert!(scan.points.is_empty());
}

fn pcd_header(points: usize, data: &str) -> String {
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z normal intensity ring\n\
         SIZE 4 4 4 4 4 2\nTYPE F F F F F U\nCOUNT 1 1 1 3 1 1\nWIDTH {points}\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    )
}

/// By point, then by field: x, y, z, three of a normal, intensity, ring.
const PCD: [([f32; 7], u16); 2] =
    [([1.0, 2.0, 3.0, 9.0, 9.0, 9.0, 40.0], 5), ([-1.0, f32::NAN, 3.0, 9.0, 9.0, 9.0, 41.0], 6)];

fn pcd_rows() -> Vec<u8> {
    let row = |(floats, ring): &([f32; 7], u16)| {
        [floats.iter().flat_map(|value| value.to_le_bytes()).collect(), ring.to_le_bytes().to_vec()].concat()
    };
    PCD.iter().flat_map(row).collect()
}

fn pcd_packed(columns: &[u8], packed: &[u8]) -> Vec<u8> {
    let sizes = [packed.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    [pcd_header(2, "binary_compressed").into_bytes(), sizes, packed.into()].concat()
}

fn pcd_columns() -> Vec<u8> {
    let spans = [0..1, 1..2, 2..3, 3..6, 6..7];
    let floats =
        spans.into_iter().flat_map(|span| PCD.iter().flat_map(move |row| row.0[span.clone()].to_vec()));
    let mut bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    bytes.extend(PCD.iter().flat_map(|row| row.1.to_le_bytes()));
    bytes
}

#[test]
fn pcd_is_read_in_all_encodings() {
    let text = "1 2 3 9 9 9 40 5\n-1 nan 3 9 9 9 41 6\n";
    let columns = pcd_columns();
    let files = [
        [pcd_header(2, "ascii").as_bytes(), text.as_bytes()].concat(),
        [pcd_header(2, "binary").into_bytes(), pcd_rows()].concat(),
        pcd_packed(&columns, &lzf_plain(&columns)),
    ];
    for file in files {
        let scan = read_pcd(&file).unwrap();
        let [point] = &scan.points[..] else { panic!("{scan:?}") };
        assert_eq!((point.position_m(), point.intensity, point.ring), ([1.0, 2.0, 3.0], 40.0, 5));
        assert_eq!(scan.dropped.count(DropReason::NotFinite), 1);
    }
}

#[test]
fn repeated_bytes_are_unpacked() {
    // x = y = z = intensity = 1.0 twice, ring 0: four bytes as they are, then the same four 28 bytes long, then zeros.
    let header = "VERSION .7\nFIELDS x y z intensity ring\nSIZE 4 4 4 4 2\nTYPE F F F F U\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n\
                  DATA binary_compressed\n";
    let packed = [3, 0, 0, 0x80, 0x3f, 0xe0, 19, 3, 0, 0, 0x20, 0];
    let sizes = [packed.len() as u32, 36].map(u32::to_le_bytes).concat();
    let scan = read_pcd(&[header.as_bytes(), &sizes, &packed].concat()).unwrap();
    assert_eq!(scan.points.len(), 2);
    assert!(scan.points.iter().all(|point| point.position_m() == [1.0; 3] && point.ring == 0), "{scan:?}");
    let far = [3, 0, 0, 0x80, 0x3f, 0xe0, 19, 200, 0, 0, 0x20, 0];
    refused(read_pcd(&[header.as_bytes(), &sizes, &far].concat()), &["PCD", "damaged"]);
}

#[test]
fn bad_pcd_files_are_refused() {
    let whole = [pcd_header(2, "binary").into_bytes(), pcd_rows()].concat();
    refused(read_pcd(&whole[..whole.len() - 1]), &["PCD", "past the data"]);
    let columns = pcd_columns();
    let packed = pcd_packed(&columns, &lzf_plain(&columns));
    for file in [&whole, &packed] {
        for cut in 0..file.len() {
            assert!(read_pcd(&file[..cut]).is_err(), "cut at {cut}");
        }
    }
    refused(read_pcd(&packed[..packed.len() - 1]), &["packed bytes are cut short"]);
    refused(
        read_pcd(&pcd_packed(&columns[1..], &lzf_plain(&columns[1..]))),
        &["2 points of 30 bytes are not 59"],
    );
    refused(read_pcd(&pcd_packed(&columns, &[0])), &["damaged"]);
    let text = pcd_header(2, "ascii") + "1 2 3 9 9 9 40 5\n1 2 3 9 9 9 40 5\n";
    let changed = |from: &str, to: &str| text.replace(from, to);
    assert!(read_pcd(changed("", "").as_bytes()).is_ok());
    refused(read_pcd(changed("WIDTH 2", "WIDTH 3").as_bytes()), &["WIDTH 3 times HEIGHT 1 is not POINTS 2"]);
    refused(read_pcd(changed("DATA ascii", "DATA xml").as_bytes()), &["DATA xml"]);
    refused(read_pcd(changed("SIZE 4 ", "SIZE 3 ").as_bytes()), &["field `x` is of type F and size 3"]);
    refused(read_pcd(changed("COUNT 1 1 1 3", "COUNT 1 1 1 0").as_bytes()), &["field `normal` has COUNT 0"]);
    refused(read_pcd(changed("COUNT 1 1 1 3", "COUNT 1 1 3").as_bytes()), &["equally many"]);
    refused(read_pcd(changed("HEIGHT 1\n", "").as_bytes()), &["no HEIGHT"]);
    refused(read_pcd(changed(" 40 5\n", " 40\n").as_bytes()), &["point 0 does not have 8 numbers"]);
    refused(read_pcd(changed(" 40 5\n", " forty 5\n").as_bytes()), &["`forty`"]);
    let many = pcd_header(2, "ascii")
        .replace("WIDTH 2", "WIDTH 90000000000")
        .replace("POINTS 2", "POINTS 90000000000");
    refused(read_pcd(many.as_bytes()), &["cut short: 0 of 90000000000 points"]);
    refused(read_pcd(many.replace("ascii", "binary").as_bytes()), &["past the data"]);
    refused(read_pcd(b"DATA"), &["no DATA line"]);
}

#[test]
fn what_is_written_is_read_back() {
    let (scans, _) = decode(&turning(80, VLP16), None);
    let mut scan = scans[0].clone();
    scan.columns.label = true;
    for (at, point) in scan.points.iter_mut().enumerate() {
        point.label = at as u32;
        (point.return_type, point.strength) = (ReturnType::Last, Strength::Weaker);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("000000.ply");
    save_scan(&path, &scan).unwrap();
    let (found, _) = read_all(&path, &Options::default()).unwrap();
    // PLY files have no columns by azimuth.
    scan.points.iter_mut().for_each(|point| point.column = Point::UNKNOWN);
    assert!(found[0].points == scan.points);
    assert!(scan.stamp_ns > 0 && !scan.frame_id.is_empty());
    assert_eq!((found[0].stamp_ns, &found[0].frame_id), (scan.stamp_ns, &scan.frame_id));
    refused(save_scan(&folder.path().join("no/such.ply"), &scan), &["no/such.ply"]);
}

#[test]
fn comments_that_name_a_stamp_and_a_frame_are_read() {
    let read = |comments: &str| {
        let bytes = [header("ascii", 1, comments).as_bytes(), b"1 2 3 4 5 6 7\n"].concat();
        let scan = ply::read(&bytes, 5, &Options::default()).unwrap();
        (scan.stamp_ns, scan.frame_id)
    };
    let late = "1689496219652560123";
    let both = format!("comment stamp_ns {late}\ncomment frame_id velodyne\n");
    assert_eq!(read(&both), (1_689_496_219_652_560_123, "velodyne".into()));
    // The controls: what is no such comment leaves the stamp that the file's name gave.
    for other in ["", "comment stamp_ns 0\n", "comment stamp_ns soon\n", "comment stamp_ns -1\n"] {
        assert_eq!(read(other), (5, String::new()), "{other}");
    }
    let prose =
        format!("comment stamp_ns {late} or so\ncomment the frame_id is missing\ncomment frame_id \n");
    assert_eq!(read(&prose), (5, String::new()));
}

#[test]
fn points_without_a_ring_among_others_that_have_one_are_kept() {
    let (scans, _) = decode(&turning(80, VLP16), None);
    let mut scan = scans[0].clone();
    scan.points.iter_mut().for_each(|point| point.column = Point::UNKNOWN);
    scan.points.iter_mut().step_by(3).for_each(|point| point.ring = Point::UNKNOWN);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("000000.ply");
    save_scan(&path, &scan).unwrap();
    let (found, _) = read_all(&path, &Options::default()).unwrap();
    assert!(found[0].points == scan.points && found[0].columns.ring);
    assert_eq!(found[0].dropped.total(), 0);
    // A ring that is no number of one costs the ring.
    let text =
        header("ascii", 2, "").replace("uchar ring", "int ring") + "1 2 3 4 5 65535 7\n1 2 3 4 5 65536 7\n";
    let scan = read_ply(text.as_bytes()).unwrap();
    assert_eq!(scan.points.iter().map(|point| point.ring).collect::<Vec<_>>(), [Point::UNKNOWN; 2]);
    assert_eq!(scan.dropped.total(), 0);
}

#[test]
fn points_without_rings_are_written_and_read_back() {
    let (scans, _) = decode(&turning(80, VLP16), None);
    let mut scan = scans[0].clone();
    (scan.columns.ring, scan.columns.column) = (false, false);
    scan.points.iter_mut().for_each(|point| (point.ring, point.column) = (Point::UNKNOWN, Point::UNKNOWN));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("000000.ply");
    save_scan(&path, &scan).unwrap();
    let (found, _) = read_all(&path, &Options::default()).unwrap();
    assert!(found[0].points == scan.points && !found[0].points.is_empty());
    assert!(!found[0].columns.ring && found[0].dropped.reasons().next().is_none());
}

#[test]
fn a_folder_is_read_in_order_of_names() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let ply = header("ascii", 1, "") + "1 2 3 4 5 6 7\n";
    file("1689496220.25.ply", &ply);
    file("1689496219.652560.ply", &ply);
    file("b.pcd", &(pcd_header(1, "ascii") + "1 2 3 9 9 9 40 5\n"));
    file("c.ply", "ply\nnonsense\n");
    file("notes.txt", "nothing");
    let (scans, report) = read_all(folder.path(), &Options::default()).unwrap();
    let stamps: Vec<u64> = scans.iter().map(|scan| scan.stamp_ns).collect();
    assert_eq!(stamps, [1_689_496_219_652_560_000, 1_689_496_220_250_000_000, 0]);
    assert_eq!(report.read.skipped.len(), 1, "{report:?}");
    assert_eq!(report.read.skipped[0].source, "c.ply");
    refused(read_bytes("c.ply", b"ply\nnonsense\n"), &["c.ply", "PLY"]);
    let nothing = tempfile::tempdir().unwrap();
    refused(read_all(nothing.path(), &Options::default()), &["without .ply and .pcd files"]);
    refused(read_bytes("a.xyz", b"1 2 3"), &["a.xyz", "no known format", "pcap"]);
    refused(read_bytes("a.pcd", b""), &["a.pcd", "is empty"]);
    refused(read_all("no/such.pcap".as_ref(), &Options::default()), &["no/such.pcap"]);
}
