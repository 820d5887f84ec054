//! What the node sends of its maps and results (spec 5 §2).

use std::time::{Duration, Instant};

use serde_bytes::Bytes;

use crate::base::{Result, duration_ns};
use crate::config::{Config, SensorInfo};
use crate::live::clouds::{Clouds, of_camera, of_lidar};
use crate::live::health::Health;
use crate::live::mapping::UnderWay;
use crate::live::outputs::Outputs;
use crate::live::sheet::{Page, Sheet};
use crate::map::{Ground, MapUpdate, Seen, State, Update};
use crate::message::RosMessage;
use crate::message::live::{GridUpdate, Log, SpeedLimit};
use crate::message::ros2::{Header, PointCloud2, Time};
use crate::message::written::{Costmap, DiagnosticArray, OccupancyGrid};
use crate::output::cloud::TrustedPoints;
use crate::output::{costmap, occupancy_grid, occupancy_of_cost};
use crate::ros2::{Graph, Naming, Participant, Quality};
use crate::sensor::{Observation, SensorData};

const COSTMAP: &str = "~/costmap";
const UPDATES: &str = "~/costmap_updates";
const RAW: &str = "~/costmap_raw";
const MARKING: &str = "~/marking";
const CLEARING: &str = "~/clearing";
const DIAGNOSTICS: &str = "/diagnostics";
const SPEED_LIMIT: &str = "/speed_limit";
const ROSOUT: &str = "/rosout";

const MAP: Quality = Quality::Latched { depth: 1 };
const STREAM: Quality = Quality::Stream { depth: 10 };
/// Reliable writers serve readers of both kinds.
const CLOUD: Quality = Quality::Stream { depth: 2 };
const LOG: Quality = Quality::Latched { depth: 100 };

/// Cost of a cell of which nothing is known, and the least that a robot must not enter.
const UNKNOWN: u8 = 255;
const INSCRIBED: u8 = 253;

/// How long the end waits for those who fetch the last map.
const LINGER: Duration = Duration::from_millis(300);

/// The map as it was sent last.
struct Sent {
    stamp_ns: u64,
    frame: String,
    map: MapUpdate,
}

/// See the module.
pub(super) struct Publisher<'a> {
    outputs: Outputs<'a>,
    name: String,
    config: &'a Config,
    sheet: Sheet,
    /// Who listened to the costmap at the last look.
    listeners: usize,
    last: Option<Sent>,
    sensors: Vec<SensorInfo>,
    points: Vec<TrustedPoints>,
    limited: bool,
}

impl<'a> Publisher<'a> {
    /// Offers all topics.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn open(participant: &'a Participant, naming: &'a Naming, config: &'a Config) -> Result<Self> {
        let mut outputs = Outputs::new(participant, naming);
        outputs.offer(COSTMAP, OccupancyGrid::TYPE, MAP)?;
        outputs.offer(UPDATES, GridUpdate::TYPE, STREAM)?;
        outputs.offer(RAW, Costmap::TYPE, MAP)?;
        outputs.offer(MARKING, PointCloud2::TYPE, CLOUD)?;
        outputs.offer(CLEARING, PointCloud2::TYPE, CLOUD)?;
        outputs.offer(DIAGNOSTICS, DiagnosticArray::TYPE, STREAM)?;
        outputs.offer(SPEED_LIMIT, SpeedLimit::TYPE, STREAM)?;
        outputs.offer(ROSOUT, Log::TYPE, LOG)?;
        Ok(Self {
            outputs,
            name: naming.full_name().trim_start_matches('/').replace('/', "."),
            config,
            sheet: Sheet::new(config.full_map_m),
            listeners: 0,
            last: None,
            sensors: Vec::new(),
            points: Vec::new(),
            limited: false,
        })
    }

    /// Identities of the writers.
    pub(super) fn writers(&self) -> Vec<[u8; 16]> {
        self.outputs.writers()
    }

    /// Takes what is known of others; one who comes to the costmap late has missed updates, so it is sent whole.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn see(&mut self, graph: &Graph) -> Result<()> {
        self.outputs.see(graph.clone());
        let listeners = self.outputs.listeners(COSTMAP);
        if listeners > self.listeners {
            self.sheet.begin_anew();
            if let Some(last) = self.last.take() {
                self.send_costmap(&last)?;
                self.last = Some(last);
            }
        }
        self.listeners = listeners;
        Ok(())
    }

    /// The sensors, as updates count them.
    pub(super) fn watch(&mut self, sensors: &[SensorInfo]) {
        self.sensors = sensors.to_vec();
        self.points = sensors.iter().map(|_| TrustedPoints::default()).collect();
    }

    /// Sends what came of an observation, or a map.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn publish(&mut self, update: &Update, of: UnderWay, health: &mut Health) -> Result<()> {
        if let (Some(observation), Some(seen)) = (&of.observation, &update.seen) {
            self.send_clouds(observation, seen, update.ground)?;
        }
        let Some(map) = &update.map else { return Ok(()) };
        let took = of.since.elapsed();
        health.latency_ms = took.as_secs_f64() * 1e3;
        let deadline_ns = duration_ns(self.config.publish_deadline_s);
        if deadline_ns > 0 && took > Duration::from_nanos(deadline_ns) && map.state < State::Stale {
            health.late_maps += 1;
            return Ok(());
        }
        health.maps += 1;
        let sent = Sent { stamp_ns: of.stamp_ns, frame: update.map_frame.clone(), map: map.clone() };
        self.send_map(sent)?;
        self.limit_speed(health.state(), of.stamp_ns, false)
    }

    fn send_map(&mut self, sent: Sent) -> Result<()> {
        self.send_costmap(&sent)?;
        let header = Header::new(sent.stamp_ns, &sent.frame);
        self.outputs.send(RAW, MAP, &costmap(&header, &sent.map.grid, Bytes::new(&sent.map.costmap)))?;
        self.last = Some(sent);
        Ok(())
    }

    /// The costmap as a whole, or what of it has changed.
    fn send_costmap(&mut self, Sent { stamp_ns, frame, map }: &Sent) -> Result<()> {
        let occupancy: Vec<u8> =
            map.costmap.iter().map(|&cost| occupancy_of_cost(cost).cast_unsigned()).collect();
        let header = Header::new(*stamp_ns, frame);
        match self.sheet.turn(frame, &map.grid, &occupancy) {
            Page::Full { grid, data } => {
                self.outputs.send(COSTMAP, MAP, &occupancy_grid(&header, &grid, Bytes::new(&data)))
            }
            Page::Update { x, y, width, height, data } => {
                let [x, y] = [x, y].map(|at| i32::try_from(at).unwrap_or(i32::MAX));
                let update = GridUpdate { header, x, y, width, height, data: Bytes::new(&data) };
                self.outputs.send(UPDATES, STREAM, &update)
            }
        }
    }

    fn send_clouds(&mut self, observation: &Observation, seen: &Seen, ground: Option<Ground>) -> Result<()> {
        let wanted = self.outputs.listeners(MARKING) + self.outputs.listeners(CLEARING) > 0;
        let sensor = observation.sensor;
        let (Some(info), Some(pose), true) = (self.sensors.get(sensor), observation.pose, wanted) else {
            return Ok(());
        };
        let map = self.last.as_ref().map(|sent| &sent.map);
        let header = Header::new(observation.stamp_ns(), &frame_of(info, observation));
        let Clouds { marking, clearing } = match (seen, &observation.data) {
            (Seen::Camera(camera), SensorData::Frame(frame)) => {
                let Some(images) = &camera.images else { return Ok(()) };
                let points = &mut self.points[sensor];
                of_camera(points, &info.config, &frame.depth, images, &header, (pose, ground, map))
            }
            (Seen::Lidar(lidar), SensorData::Scan(scan)) => {
                of_lidar(&info.config, scan, lidar, &header, (pose, ground, map))
            }
            _ => return Ok(()),
        };
        self.outputs.send(MARKING, CLOUD, &marking)?;
        self.outputs.send(CLEARING, CLOUD, &clearing)
    }

    /// Sets a limit while the map is not OK and lifts it afterwards; `again`: tells a limit that holds once more.
    fn limit_speed(&mut self, state: State, stamp_ns: u64, again: bool) -> Result<()> {
        let limit = state != State::Ok;
        if limit == self.limited && !(again && limit) {
            return Ok(());
        }
        self.limited = limit;
        // To Nav2 0 means that there is no limit.
        let speed_limit = if limit { self.config.degraded_speed_percent } else { 0.0 };
        let message = SpeedLimit { header: Header::new(stamp_ns, ""), percentage: true, speed_limit };
        self.outputs.send(SPEED_LIMIT, STREAM, &message)
    }

    /// What is told every second.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn second(&mut self, health: &mut Health, stamp_ns: u64, now: Instant) -> Result<()> {
        health.held_up = self.outputs.held_up;
        let message = health.message(stamp_ns, now);
        self.outputs.send(DIAGNOSTICS, STREAM, &message)?;
        self.limit_speed(health.state(), stamp_ns, true)
    }

    /// A line on `/rosout`.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn log(&mut self, level: u8, message: &str, stamp_ns: u64) -> Result<()> {
        let (stamp, name) = (Time::from_stamp_ns(stamp_ns), self.name.clone());
        let log = Log { stamp, level, name: &name, msg: message, file: "", function: "", line: 0 };
        self.outputs.send(ROSOUT, LOG, &log)
    }

    /// No cell of the last map counts as free any more.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn forget_free(&mut self, health: &Health) -> Result<()> {
        self.forget(|cost| cost < INSCRIBED)?;
        let stamp_ns = self.last.as_ref().map_or(0, |last| last.stamp_ns);
        self.limit_speed(health.state(), stamp_ns, false)
    }

    /// Leaves the topics of the map unknown, and waits a moment for those who listen.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn leave_unknown(&mut self) -> Result<()> {
        // Whole, so that a subscriber that comes later finds nothing else.
        self.sheet.begin_anew();
        self.forget(|_| true)?;
        let until = Instant::now() + LINGER;
        for name in [COSTMAP, UPDATES, RAW] {
            self.outputs.flush(name, until.saturating_duration_since(Instant::now()));
        }
        Ok(())
    }

    /// Sends the last map with some of its cells unknown.
    fn forget(&mut self, which: impl Fn(u8) -> bool) -> Result<()> {
        let Some(mut last) = self.last.take() else { return Ok(()) };
        last.map.costmap.iter_mut().filter(|cost| which(**cost)).for_each(|cost| *cost = UNKNOWN);
        self.send_map(last)
    }
}

/// Frame of what was observed.
fn frame_of(info: &SensorInfo, observation: &Observation) -> String {
    let [first, second] = match &observation.data {
        SensorData::Frame(frame) => [&frame.depth.frame_id, &info.config.camera_frame],
        SensorData::Scan(scan) => [&info.config.lidar_frame, &scan.frame_id],
    };
    let named = [first, second].into_iter().find(|name| !name.is_empty());
    named.unwrap_or(&info.name).clone()
}
