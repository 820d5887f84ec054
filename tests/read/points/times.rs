//! Times of points, of all units and starts that drivers write.

use limpid::message::ros2::Header;
use limpid::sensor::{PointClock, Scan};

use super::cloud::read;
use super::make::{XYZI, cloud};

const STAMP_NS: u64 = 1_700_000_000_000_000_000;

/// Three points at these times, in a field of that type.
fn timed<const N: usize>(name: &str, datatype: u8, times: [[u8; N]; 3]) -> Scan {
    let fields = [XYZI, &[(name, 16, datatype)]].concat();
    let step = 16 + N;
    let point =
        |time: [u8; N]| [[1.0_f32; 4].iter().flat_map(|v| v.to_le_bytes()).collect(), time.to_vec()].concat();
    let mut message = cloud(&fields, step as u32, 3, times.into_iter().flat_map(point).collect());
    message.header = Header::new(STAMP_NS, "lidar");
    read(message).unwrap()
}

#[track_caller]
fn expect(scan: &Scan, seconds: [f32; 3], clock: PointClock) {
    let times: Vec<f32> = scan.points.iter().map(|point| point.time_s).collect();
    let near = times.iter().zip(seconds).all(|(time, want)| (time - want).abs() < 2e-5);
    assert!(near && scan.columns.clock == clock, "{times:?} by {:?}", scan.columns.clock);
}

/// 0, 50 and 100 ms.
const SWEEP: [f64; 3] = [0.0, 0.05, 0.1];
const SWEEP_S: [f32; 3] = [0.0, 0.05, 0.1];

#[test]
fn times_after_the_stamp_in_every_unit_and_type() {
    for unit in [1.0, 1e3, 1e6, 1e9] {
        let f32s = SWEEP.map(|s| ((s * unit) as f32).to_le_bytes());
        expect(&timed("time", 7, f32s), SWEEP_S, PointClock::Stamp);
        let f64s = SWEEP.map(|s| (s * unit).to_le_bytes());
        expect(&timed("timestamp", 8, f64s), SWEEP_S, PointClock::Stamp);
        let before = SWEEP.map(|s| ((s - 0.1) * unit).to_le_bytes());
        expect(&timed("t", 8, before), [-0.1, -0.05, 0.0], PointClock::Stamp);
    }
    for unit in [1e3, 1e6, 1e9] {
        let u32s = SWEEP.map(|s| ((s * unit) as u32).to_le_bytes());
        expect(&timed("offset_time", 6, u32s), SWEEP_S, PointClock::Stamp);
    }
    // Of a sensor that gives a cloud each 10 ms.
    let short = [0.0_f64, 5e3, 1e4].map(|us| (us as f32).to_le_bytes());
    expect(&timed("time", 7, short), [0.0, 0.005, 0.01], PointClock::Stamp);
}

#[test]
fn times_since_1970_in_every_unit() {
    let stamp_s = STAMP_NS as f64 * 1e-9;
    for unit in [1.0, 1e3, 1e6, 1e9] {
        let f64s = SWEEP.map(|s| ((stamp_s + s) * unit).to_le_bytes());
        expect(&timed("timestamp", 8, f64s), SWEEP_S, PointClock::Stamp);
        // A clock 37 s ahead, as TAI is of UTC.
        let tai = SWEEP.map(|s| ((stamp_s + 37.0 + s) * unit).to_le_bytes());
        expect(&timed("timestamp", 8, tai), SWEEP_S, PointClock::Own);
    }
    // Stamped after its last point.
    let before = SWEEP.map(|s| (stamp_s - 0.12 + s).to_le_bytes());
    expect(&timed("timestamp", 8, before), [-0.12, -0.07, -0.02], PointClock::Stamp);
    // Whole nanoseconds of 64 bits that are called a float.
    let whole = SWEEP.map(|s| (STAMP_NS + (s * 1e9) as u64).to_le_bytes());
    expect(&timed("timestamp", 8, whole), SWEEP_S, PointClock::Stamp);
}

#[test]
fn times_since_a_start_of_the_sensor_s_own() {
    for since_s in [5.0, 60.0, 12_345.0, 250_000.0] {
        for unit in [1.0, 1e3, 1e6, 1e9] {
            let f64s = SWEEP.map(|s| ((since_s + s) * unit).to_le_bytes());
            expect(&timed("timestamp", 8, f64s), SWEEP_S, PointClock::Own);
        }
    }
    for (since_s, unit) in
        [(5.0, 1e3), (2000.0, 1e3), (250_000.0, 1e3), (5.0, 1e6), (3000.0, 1e6), (4.0, 1e9)]
    {
        let u32s = SWEEP.map(|s| (((since_s + s) * unit) as u32).to_le_bytes());
        expect(&timed("timestamp", 6, u32s), SWEEP_S, PointClock::Own);
    }
}

#[test]
fn times_that_cannot_be_used_are_said_to_be() {
    let stamp_s = STAMP_NS as f64 * 1e-9;
    let rounded = SWEEP.map(|s| ((stamp_s + s) as f32).to_le_bytes());
    let whole = SWEEP.map(|s| ((stamp_s + s) as u32).to_le_bytes());
    let spread = [0.0_f32, 1.0, 11.0].map(f32::to_le_bytes);
    let accumulated = [0.0, 10.0, 60.0].map(|s| (stamp_s + s).to_le_bytes());
    for (scan, clock) in [
        (timed("time", 7, rounded), PointClock::Rounded),
        (timed("timestamp", 6, whole), PointClock::Rounded),
        (timed("timestamp", 8, accumulated), PointClock::Spread),
    ] {
        expect(&scan, [0.0; 3], clock);
        assert!(!scan.columns.time && clock.note().unwrap().contains("not deskewed"));
    }
    // Eleven of a float may be milliseconds.
    expect(&timed("time", 7, spread), [0.0, 0.001, 0.011], PointClock::Stamp);
    assert!(PointClock::Own.note().unwrap().contains("another clock") && PointClock::Stamp.note().is_none());
}
