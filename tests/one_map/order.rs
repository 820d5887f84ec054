//! Several sensors under way at once: results in the order of what was asked for, and the same bits twice.

use limpid::Config;
use limpid::map::Update;
use limpid::mapper::{SensorInfo, Submitted};
use limpid::sensor::Observation;

use super::rig::{
    Rig, camera_and_lidar, config, dim_wall, frame, half_camera, mount, room, sweep, two_cameras,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

/// What is done with a mapper.
enum Step {
    See(Box<Observation>),
    Publish,
}

fn sensors(config: &Config) -> Vec<SensorInfo> {
    let [front, rear] = two_cameras(config);
    let [_, top] = camera_and_lidar(config);
    vec![front, rear, top]
}

fn scene() -> Scene {
    room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.5])])
}

/// Cameras at 30 and 20 Hz, a lidar at 10 Hz, and maps at 10 Hz, each with the moment it is asked for.
fn steps() -> Vec<Step> {
    let mut steps = Vec::new();
    for ms in 0..400 {
        if ms % 33 == 0 {
            steps.push(Step::See(Box::new(frame(0, ms, &scene(), small_camera(), mount(0.0, 0.2)))));
        }
        if ms % 50 == 7 {
            steps.push(Step::See(Box::new(frame(1, ms, &scene(), small_camera(), mount(0.6, 0.2)))));
        }
        if ms % 100 == 20 {
            steps.push(Step::See(Box::new(sweep(2, ms, &dim_wall(2.52, -0.5..0.5, 0.7)))));
        }
        if ms % 100 == 99 {
            steps.push(Step::Publish);
        }
    }
    steps
}

/// The results where up to `most` are under way, waited for or asked for until they are there.
fn results(most: usize, polled: bool) -> Vec<Update> {
    let config = config();
    let mut rig = Rig::open(&config, &sensors(&config));
    let mut updates = Vec::new();
    let take = |rig: &mut Rig, updates: &mut Vec<Update>| {
        if !polled {
            return updates.extend(rig.mapper.wait().unwrap());
        }
        let until = std::time::Instant::now() + std::time::Duration::from_secs(30);
        let update = std::iter::from_fn(|| Some(rig.mapper.poll().unwrap())).find_map(|update| {
            assert!(std::time::Instant::now() < until, "nothing came in 30 s");
            update
        });
        updates.extend(update);
    };
    for step in steps() {
        let (sensor, full) = match &step {
            Step::See(observation) => (observation.sensor, rig.mapper.is_full(observation.sensor)),
            Step::Publish => (3, rig.mapper.is_publishing_full()),
        };
        while rig.mapper.in_flight() >= most || (full && rig.mapper.is_full(sensor)) {
            take(&mut rig, &mut updates);
        }
        match step {
            Step::See(observation) => {
                assert_eq!(rig.mapper.submit(&observation).unwrap(), Submitted::Taken);
            }
            Step::Publish => assert!(rig.mapper.publish(None).unwrap()),
        }
    }
    while rig.mapper.in_flight() > 0 {
        take(&mut rig, &mut updates);
    }
    assert!(rig.mapper.poll().unwrap().is_none() && rig.mapper.wait().unwrap().is_none());
    updates
}

#[test]
fn results_come_in_the_order_of_what_was_asked_for_and_the_same_messages_give_the_same_bits() {
    if skipped() {
        return;
    }
    let asked: Vec<(Option<usize>, Option<u64>)> = steps()
        .iter()
        .map(|step| match step {
            Step::See(observation) => (Some(observation.sensor), Some(observation.stamp_ns())),
            Step::Publish => (None, None),
        })
        .collect();
    let one = results(1, false);
    let came: Vec<_> =
        one.iter().map(|update| (update.sensor, update.sensor.map(|_| update.stamp_ns))).collect();
    assert_eq!(came, asked);
    assert!(one.iter().all(|update| update.sensor.is_none() == update.map.is_some()));
    let last = one.last().unwrap().map.as_ref().unwrap();
    let rows = [6, 7, 8, 9, 10].map(|row| last.verdicts.iter().any(|verdict| verdict.row() == row));
    assert_eq!(rows, [true; 5], "the map has something to differ in");

    for (most, polled) in [(1, false), (8, false), (8, true)] {
        let other = results(most, polled);
        assert!(one == other, "with {most} under way, polled: {polled}");
    }
}

#[test]
fn a_map_is_that_of_the_moment_at_which_it_was_asked_for() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &sensors(&config));
    let scan = |ms, y_m| sweep(2, ms, &dim_wall(2.52, y_m..y_m + 0.05, 0.7));
    let mut submit = |observation: &Observation| {
        assert_eq!(rig.mapper.submit(observation).unwrap(), Submitted::Taken);
        assert!(rig.mapper.publish(None).unwrap());
    };
    submit(&scan(0, -0.35));
    submit(&scan(10, 0.0));
    submit(&scan(20, 0.35));
    let places = [-0.33, 0.02, 0.37];
    let mut passable = Vec::new();
    while let Some(update) = rig.mapper.wait().unwrap() {
        let Some(map) = update.map else { continue };
        let stamp_ns = update.stamp_ns;
        let out = super::rig::Published { map, stamp_ns };
        passable.push(places.map(|y_m| out.said([2.52, y_m]).0 == 7));
    }
    assert_eq!(passable, [[true, false, false], [true, true, false], [true; 3]]);
}

#[test]
fn sensors_that_write_in_another_order_with_the_same_stamps_agree_where_each_is_alone() {
    if skipped() {
        return;
    }
    // Two cameras of two sizes that see nothing in common.
    let config = config();
    let sensors = [
        super::rig::camera("a", &config, small_camera(), false),
        super::rig::camera("b", &config, half_camera(), false),
    ];
    let run = |order: [usize; 2]| {
        let mut rig = Rig::open(&config, &sensors);
        for index in 0..10 {
            for sensor in order {
                let size = [small_camera(), half_camera()][sensor];
                let yaw = [0.0, std::f64::consts::PI][sensor];
                rig.see(&frame(sensor, index * 33, &scene(), size, mount(yaw, 0.2)));
            }
        }
        rig.publish(None)
    };
    let (one, other) = (run([0, 1]), run([1, 0]));
    assert!(one.of(9, 0).len() > 500 && one.of(9, 1).len() > 500);
    assert!(one == other);
}
