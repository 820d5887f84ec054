//! The map's time: outages, sensors that never came, stamps that jump, clocks that differ.

use limpid::map::{Clock, State};

const S: u64 = 1_000_000_000;
const MS: u64 = 1_000_000;
const BEGAN: u64 = 1_700_000_000 * S;
/// Tick of the first stamp.
const FIRST: u32 = 1001;

fn clock() -> Clock {
    Clock::new(&[S / 2, S / 2])
}

#[test]
fn ticks_count_hundredths_from_10_s_before_the_first_stamp() {
    let mut clock = Clock::new(&[S / 2; 4]);
    assert_eq!(clock.observe(0, BEGAN).tick, FIRST);
    assert_eq!(clock.observe(1, BEGAN + 25 * MS).tick, FIRST + 2);
    // Late: its own tick, and the map's time stays.
    assert_eq!(clock.observe(2, BEGAN + 15 * MS).tick, FIRST + 1);
    assert_eq!((clock.now(), clock.now_ns()), (FIRST + 2, BEGAN + 25 * MS));
    // Before the map's first: older than it.
    assert_eq!(clock.observe(3, BEGAN - 5 * MS).tick, FIRST - 1);
    assert_eq!(clock.observe(1, BEGAN - 5 * MS).tick, FIRST - 1, "a sensor's own message may be late too");
    let mut other = self::clock();
    other.observe(0, BEGAN);
    assert_eq!(other.observe(1, BEGAN - 60 * S).tick, 1, "as old as a tick can be");
}

#[test]
fn a_sensor_that_never_came_is_stale_from_the_start() {
    let mut clock = clock();
    clock.observe(0, BEGAN);
    assert_eq!(clock.states(), [State::Ok, State::Stale]);
    assert_eq!(clock.fresh_since()[1], u32::MAX);
}

#[test]
fn after_an_outage_only_new_evidence_is_fresh() {
    let mut clock = clock();
    for at in 0..10 {
        clock.observe(0, BEGAN + at * 100 * MS);
        clock.observe(1, BEGAN + at * 100 * MS);
    }
    clock.observe(1, BEGAN + 1500 * MS);
    assert_eq!(clock.states(), [State::Stale, State::Ok], "0.6 s without data");
    assert_eq!(clock.fresh_since(), [u32::MAX, FIRST + 150], "and the other was away for as long");
    let back = clock.observe(0, BEGAN + 2000 * MS);
    clock.observe(1, BEGAN + 2000 * MS);
    assert_eq!((back.tick, back.since_last_ns), (FIRST + 200, Some(1100 * MS)));
    assert_eq!(clock.states(), [State::Ok, State::Ok]);
    assert_eq!(clock.fresh_since()[0], FIRST + 200);
}

#[test]
fn a_timeout_of_0_never_comes() {
    let mut clock = Clock::new(&[0, S]);
    clock.observe(0, BEGAN);
    clock.observe(1, BEGAN + 100 * S);
    assert_eq!(clock.states(), [State::Ok, State::Ok]);
}

#[test]
fn time_goes_on_where_stamps_of_one_sensor_jump_back() {
    let mut clock = clock();
    clock.observe(0, BEGAN + 100 * S);
    clock.observe(1, BEGAN + 100 * S);
    let jump = clock.observe(0, BEGAN);
    assert!(jump.jumped);
    assert_eq!(jump.tick, clock.now());
    let next = clock.observe(0, BEGAN + 100 * MS);
    assert_eq!((next.jumped, next.tick, next.since_last_ns), (false, clock.now(), Some(100 * MS)));
    assert_eq!(clock.states(), [State::Ok, State::Ok]);
}

#[test]
fn a_stamp_far_ahead_of_the_others_is_believed_only_when_it_stays() {
    let mut clock = clock();
    clock.observe(0, BEGAN);
    clock.observe(1, BEGAN);
    assert_eq!(clock.ahead_s(0, BEGAN + 100 * MS), None);
    for _ in 0..3 {
        assert_eq!(clock.ahead_s(0, BEGAN + 30 * S), Some(30));
    }
    assert_eq!(clock.ahead_s(0, BEGAN + 30 * S), None, "a clock of its own");
    // With one sensor it is a gap in the recording.
    let mut alone = Clock::new(&[S]);
    alone.observe(0, BEGAN);
    assert_eq!(alone.ahead_s(0, BEGAN + 3600 * S), None);
}

#[test]
fn the_control_a_moved_clock_makes_all_stale() {
    let mut clock = clock();
    clock.observe(0, BEGAN);
    clock.observe(1, BEGAN);
    clock.advance(BEGAN + S);
    assert_eq!(clock.states(), [State::Stale, State::Stale]);
}

#[test]
fn after_a_pause_of_all_sensors_the_second_one_back_is_believed() {
    let mut clock = Clock::new(&[S / 2; 3]);
    for sensor in 0..3 {
        clock.observe(sensor, BEGAN);
    }
    let later = BEGAN + 60 * S;
    assert_eq!(clock.ahead_s(0, later), Some(60));
    assert_eq!(clock.ahead_s(1, later + 20 * MS), None, "it says what the first said");
    clock.observe(1, later + 20 * MS);
    assert_eq!(clock.ahead_s(0, later + 33 * MS), None);
    // The control: another that is ahead by another time is alone.
    let mut clock = Clock::new(&[S / 2; 3]);
    for sensor in 0..3 {
        clock.observe(sensor, BEGAN);
    }
    assert_eq!(clock.ahead_s(0, later), Some(60));
    assert_eq!(clock.ahead_s(1, BEGAN + 30 * S), Some(30));
    assert_eq!(clock.ahead_s(2, BEGAN + 20 * MS), None);
}
