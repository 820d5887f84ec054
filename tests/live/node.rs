//! A node's maps are those of a replay, frame for frame; what it does when data stop, come again, and at its end.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use limpid::config::Method;
use limpid::message::ros2::decode_cdr;
use limpid::output::occupancy_of_cost;
use limpid::ros2::Quality;
use limpid::{Config, Observation, Options, Sink, Update as Result_, open_source, run};

use super::peer::{
    Costs, Diagnostics, Node, Occupancy, PATIENCE, Peer, SpeedLimit, Update, domain, no_network,
    node_options, play_options, played,
};
use crate::cli::ROOM;
use crate::support::gpu::skipped;

const COSTMAP: u32 = 0;
const UPDATES: u32 = 1;
const RAW: u32 = 2;
const DIAGNOSTICS: u32 = 3;
const SPEED: u32 = 4;

/// Occupancy of a cell of which nothing is known.
const UNKNOWN: u8 = 255;

pub(super) fn config() -> Config {
    // Nothing may be lost or given up on a machine however slow; how long a frame waits has tests of its own.
    Config {
        method: Method::Range,
        wait_s: 20.0,
        publish_deadline_s: 0.0,
        timeout_s: 2.0,
        reliable_sensors: true,
        ..Config::default()
    }
}

pub(super) fn listener(environment: &limpid::ros2::Environment) -> Peer {
    let mut peer = Peer::join(environment);
    let many = Quality::Latched { depth: 1000 };
    peer.listen(COSTMAP, "/limpid/costmap", "nav_msgs/msg/OccupancyGrid", many);
    peer.listen(
        UPDATES,
        "/limpid/costmap_updates",
        "map_msgs/msg/OccupancyGridUpdate",
        Quality::Stream { depth: 1000 },
    );
    peer.listen(RAW, "/limpid/costmap_raw", "nav2_msgs/msg/Costmap", many);
    peer.listen(
        DIAGNOSTICS,
        "/diagnostics",
        "diagnostic_msgs/msg/DiagnosticArray",
        Quality::Stream { depth: 1000 },
    );
    peer.listen(SPEED, "/speed_limit", "nav2_msgs/msg/SpeedLimit", Quality::Stream { depth: 1000 });
    peer
}

/// Origin of a window and its costs.
type Window = ([f64; 2], Vec<u8>);

/// Costmaps of a replay by stamp.
#[derive(Default)]
struct Replay(std::sync::Arc<std::sync::Mutex<BTreeMap<u64, Window>>>);

impl Sink for Replay {
    fn write(&mut self, update: &Result_, _: Option<&Observation>) -> limpid::Result<()> {
        if let Some(map) = &update.map {
            let origin = [map.grid.origin_x_m, map.grid.origin_y_m];
            self.0.lock().unwrap().insert(update.stamp_ns, (origin, map.costmap.clone()));
        }
        Ok(())
    }

    fn finish(&mut self) -> limpid::Result<()> {
        Ok(())
    }
}

fn replay(config: &Config) -> BTreeMap<u64, Window> {
    let replay = Replay::default();
    let maps = std::sync::Arc::clone(&replay.0);
    let mut room = open_source(ROOM.as_ref(), config).unwrap();
    run(room.as_mut(), 0..u64::MAX, config, &Options::default(), &mut [Box::new(replay)], &mut |_| ())
        .unwrap();
    let maps = maps.lock().unwrap().clone();
    assert_eq!(maps.len(), 30);
    maps
}

/// What Nav2's StaticLayer holds: the whole map, with the rectangles that came since.
struct Layer(Occupancy);

impl Layer {
    fn take(&mut self, update: &Update) {
        for (row, cells) in update.data.chunks_exact(update.width as usize).enumerate() {
            let start = (update.y as usize + row) * self.0.width as usize + update.x as usize;
            self.0.data[start..start + cells.len()].copy_from_slice(cells);
        }
    }

    /// Asserts that it holds a window's costs and else nothing.
    fn assert_holds(&self, ([x_m, y_m], costs): &Window, resolution_m: f64) {
        let side = (costs.len() as f64).sqrt() as usize;
        let offset = |at_m: f64, origin_m: f64| ((at_m - origin_m) / resolution_m).round() as usize;
        let (x, y) = (offset(*x_m, self.0.origin.position.x), offset(*y_m, self.0.origin.position.y));
        let mut wanted = vec![UNKNOWN; self.0.data.len()];
        for (row, cells) in costs.chunks_exact(side).enumerate() {
            let start = (y + row) * self.0.width as usize + x;
            for (to, &cost) in wanted[start..start + side].iter_mut().zip(cells) {
                *to = occupancy_of_cost(cost).cast_unsigned();
            }
        }
        assert!(wanted == self.0.data, "the layer holds something else than the window");
    }
}

/// Takes every frame's map, by the raw costs and by whole map and updates, and asserts that they are those of the replay; the
/// newest stamp.
fn assert_all_maps_come(peer: &Peer, wanted: &BTreeMap<u64, Window>, resolution_m: f64) -> u64 {
    let (mut raw, mut layer, mut early, mut last) = (BTreeMap::new(), None::<Layer>, Vec::new(), 0);
    let until = Instant::now() + PATIENCE;
    let stamp_of = |update: &Update| update.header.stamp.stamp_ns().unwrap();
    while raw.len() < wanted.len() || last < *wanted.keys().last().unwrap() {
        let (topic, payload) = peer.next(until).unwrap_or_else(|| panic!("{} of 30 maps came", raw.len()));
        match topic {
            COSTMAP => {
                let whole: Occupancy = decode_cdr("OccupancyGrid", &payload).unwrap();
                let stamp_ns = whole.header.stamp.stamp_ns().unwrap();
                let layer = layer.insert(Layer(whole));
                // Topics may overtake each other: what came before is laid over it, where it is of a later time.
                early.retain(|update| stamp_of(update) > stamp_ns);
                early.iter().for_each(|update| layer.take(update));
                last = early.last().map_or(stamp_ns, stamp_of);
            }
            UPDATES => {
                let update: Update = decode_cdr("update", &payload).unwrap();
                early.push(update.clone());
                let Some(layer) = &mut layer else { continue };
                layer.take(&update);
                last = stamp_of(&update);
            }
            RAW => {
                let costs: Costs = decode_cdr("Costmap", &payload).unwrap();
                raw.insert(costs.header.stamp.stamp_ns().unwrap(), costs);
                continue;
            }
            _ => continue,
        }
        layer.as_ref().unwrap().assert_holds(&wanted[&last], resolution_m);
    }
    for (stamp_ns, (origin, costs)) in wanted {
        let live = &raw[stamp_ns];
        assert_eq!([live.origin.position.x, live.origin.position.y], *origin);
        assert!(live.data == *costs, "the costmap of {stamp_ns} differs");
    }
    last
}

#[test]
fn live_maps_are_those_of_a_replay_and_free_space_goes_when_data_stop() {
    if no_network() || skipped() {
        return;
    }
    let (environment, config) = (domain(), config());
    let wanted = replay(&config);
    let peer = listener(&environment);
    let node = Node::start(&environment, node_options(config.clone()));
    for name in ["/limpid/costmap", "/limpid/costmap_updates", "/limpid/costmap_raw"] {
        peer.wait_for_topic(name);
    }
    // By then the node knows who listens, and sends nobody a whole map for coming late.
    peer.wait_for::<Diagnostics>(DIAGNOSTICS, |_| true);
    peer.wait_for::<Diagnostics>(DIAGNOSTICS, |_| true);
    played(&environment, ROOM, &play_options()).unwrap();

    let last = assert_all_maps_come(&peer, &wanted, config.resolution_m);

    // No data any more: what was free is unknown, and both a person and Nav2's controller are told.
    let stale = peer.wait_for::<Costs>(RAW, |costs| !costs.data.contains(&0));
    assert!(stale.data.contains(&254), "lethal cells stay");
    assert_eq!(stale.header.stamp.stamp_ns().unwrap(), last, "the stamp is the sensor's");
    let said = peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].level == 2);
    assert!(said.status[0].message.contains("STALE: camera"), "{said:?}");
    let limit = peer.wait_for::<SpeedLimit>(SPEED, |limit| limit.speed_limit > 0.0);
    assert_eq!((limit.percentage, limit.speed_limit), (true, config.degraded_speed_percent));

    // The recording once more: its stamps jump back, so the map begins anew; then all is well again.
    played(&environment, ROOM, &play_options()).unwrap();
    node.wait_for("the map begins anew: stamps jumped back", 1);
    let first_ns = *wanted.keys().next().unwrap();
    let again = peer.wait_for::<Costs>(RAW, |costs| costs.header.stamp.stamp_ns().unwrap() == first_ns);
    assert!(again.data == wanted[&first_ns].1, "nothing of the first round is left");
    peer.wait_for::<SpeedLimit>(SPEED, |limit| limit.speed_limit == 0.0);
    peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].level == 0);

    // The end.
    let took = node.end();
    assert!(took < Duration::from_secs(1), "it took {took:?}");
    let left = peer.wait_for::<Occupancy>(COSTMAP, |whole| whole.data.iter().all(|&cell| cell == UNKNOWN));
    assert!(left.width > 240, "with the margin");
    peer.wait_for::<Costs>(RAW, |costs| costs.data.iter().all(|&cost| cost == 255));
}
