//! What the node sends of its maps and results (spec 5 §2).

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_bytes::Bytes;

use crate::base::{Error, Result, duration_ns};
use crate::config::{Config, SensorInfo};
use crate::live::clouds::{Clouds, of_camera, of_lidar};
use crate::live::health::Health;
use crate::live::mapping::UnderWay;
use crate::live::outputs::{Outputs, PASSING};
#[cfg(feature = "foxglove")]
use crate::live::served::{Served, TRANSFORMS};
use crate::live::sheet::{Page, Sheet};
use crate::map::{Ground, MapUpdate, Seen, State, Update};
use crate::message::RosMessage;
use crate::message::live::{GridUpdate, Log, SpeedLimit};
use crate::message::ros2::{Header, PointCloud2, Time};
use crate::message::service::{ParameterEvent, SaveMapRequest};
use crate::message::written::{Costmap, DiagnosticArray, OccupancyGrid};
use crate::output::cloud::TrustedPoints;
use crate::output::save_map;
#[cfg(feature = "foxglove")]
use crate::output::topics::{TopicSink, transforms};
use crate::output::topics::{Topics, costmap, occupancy_grid, occupancy_of_cost};
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
const PARAMETERS: &str = "/parameter_events";

const MAP: Quality = Quality::Latched { depth: 1 };
const STREAM: Quality = Quality::Stream { depth: 10 };
const LOG: Quality = Quality::Latched { depth: 100 };

/// Cost of a cell of which nothing is known, and the least that a robot must not enter.
const UNKNOWN: u8 = 255;
const INSCRIBED: u8 = 253;

/// Longest wait for a full map to arrive before an update of it is sent.
const OVERTAKEN: Duration = Duration::from_millis(20);

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
    /// As logs name the node.
    name: String,
    config: Config,
    sheet: Sheet,
    /// Who listened to the costmap at the last look.
    listeners: usize,
    last: Option<Sent>,
    sensors: Vec<SensorInfo>,
    topics: Topics,
    points: Vec<TrustedPoints>,
    limited: bool,
    /// The same for Foxglove.
    #[cfg(feature = "foxglove")]
    served: Option<Served<'a>>,
}

impl<'a> Publisher<'a> {
    /// Offers all topics.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn open(participant: &'a Participant, naming: &'a Naming, config: &Config) -> Result<Self> {
        let mut outputs = Outputs::new(participant, naming);
        outputs.offer(COSTMAP, OccupancyGrid::TYPE, MAP)?;
        outputs.offer(UPDATES, GridUpdate::TYPE, STREAM)?;
        outputs.offer(RAW, Costmap::TYPE, MAP)?;
        outputs.offer(MARKING, PointCloud2::TYPE, PASSING)?;
        outputs.offer(CLEARING, PointCloud2::TYPE, PASSING)?;
        outputs.offer(DIAGNOSTICS, DiagnosticArray::TYPE, STREAM)?;
        outputs.offer(SPEED_LIMIT, SpeedLimit::TYPE, STREAM)?;
        outputs.offer(ROSOUT, Log::TYPE, LOG)?;
        outputs.offer(PARAMETERS, ParameterEvent::TYPE, STREAM)?;
        Ok(Self {
            outputs,
            name: naming.full_name().trim_start_matches('/').replace('/', "."),
            config: config.clone(),
            sheet: Sheet::new(config.full_map_m),
            listeners: 0,
            last: None,
            sensors: Vec::new(),
            topics: Topics::default(),
            points: Vec::new(),
            limited: false,
            #[cfg(feature = "foxglove")]
            served: None,
        })
    }

    /// Tells Foxglove too, at an address; the port.
    ///
    /// # Errors
    /// As [`Served::open`].
    #[cfg(feature = "foxglove")]
    pub(super) fn serve(&mut self, address: std::net::SocketAddr, naming: &'a Naming) -> Result<u16> {
        Ok(self.served.insert(Served::open(address, naming)?).port())
    }

    /// Identities of the writers.
    pub(super) fn writers(&self) -> Vec<[u8; 16]> {
        self.outputs.writers()
    }

    /// As [`Outputs::unheard`].
    pub(super) fn unheard(&self) -> Vec<String> {
        self.outputs.unheard()
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

    /// The sensors, as updates count them: offers what is told of them.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn watch(&mut self, sensors: &[SensorInfo]) -> Result<()> {
        self.sensors = sensors.to_vec();
        self.topics = Topics::of(sensors);
        self.points = sensors.iter().map(|_| TrustedPoints::default()).collect();
        #[cfg(feature = "foxglove")]
        if let Some(served) = &mut self.served {
            served.offer_list(&self.topics.names())?;
        }
        self.outputs.offer_list(&self.topics.names())
    }

    /// Whether somebody listens to what is made of a camera's images.
    pub(super) fn wants_images(&self, sensor: usize) -> bool {
        #[cfg(feature = "foxglove")]
        if self.served.as_ref().is_some_and(|served| self.topics.wants_images(served, sensor)) {
            return true;
        }
        self.wants_clouds() || self.topics.wants_images(&self.outputs, sensor)
    }

    fn wants_clouds(&self) -> bool {
        self.outputs.listeners(MARKING) + self.outputs.listeners(CLEARING) > 0
    }

    /// Sends what came of an observation, or a map.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn publish(&mut self, update: &Update, of: UnderWay, health: &mut Health) -> Result<()> {
        if let (Some(observation), Some(seen)) = (&of.observation, &update.seen) {
            self.send_clouds(observation, seen, update.ground)?;
            self.topics.write_seen(&mut self.outputs, observation.sensor, seen, observation)?;
            #[cfg(feature = "foxglove")]
            self.serve_seen(update, seen, observation)?;
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
        Topics::write_map(&mut self.outputs, of.stamp_ns, &update.map_frame, map)?;
        let sent = Sent { stamp_ns: of.stamp_ns, frame: update.map_frame.clone(), map: map.clone() };
        self.send_map(sent)?;
        self.limit_speed(health.state(), of.stamp_ns, false)
    }

    #[cfg(feature = "foxglove")]
    fn serve_seen(&mut self, update: &Update, seen: &Seen, observation: &Observation) -> Result<()> {
        let Some(served) = &mut self.served else { return Ok(()) };
        let stamp_ns = observation.stamp_ns();
        let frame = self.topics.frame(observation.sensor, observation).unwrap_or_default();
        if let Some(transforms) = transforms(stamp_ns, &self.config.base_frame, &frame, update) {
            served.put(TRANSFORMS, stamp_ns, &transforms)?;
        }
        self.topics.write_seen(served, observation.sensor, seen, observation)
    }

    fn send_map(&mut self, sent: Sent) -> Result<()> {
        #[cfg(feature = "foxglove")]
        if let Some(served) = &mut self.served {
            Topics::write_map(served, sent.stamp_ns, &sent.frame, &sent.map)?;
        }
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
                self.outputs.send(COSTMAP, MAP, &occupancy_grid(&header, &grid, Bytes::new(&data)))?;
                // An update of this grid would be laid over the one of before where it came first.
                self.outputs.flush(COSTMAP, OVERTAKEN);
                Ok(())
            }
            Page::Update { x, y, width, height, data } => {
                let [x, y] = [x, y].map(|at| i32::try_from(at).unwrap_or(i32::MAX));
                let update = GridUpdate { header, x, y, width, height, data: Bytes::new(&data) };
                self.outputs.send(UPDATES, STREAM, &update)
            }
        }
    }

    fn send_clouds(&mut self, observation: &Observation, seen: &Seen, ground: Option<Ground>) -> Result<()> {
        let sensor = observation.sensor;
        let (Some(info), Some(pose), true) =
            (self.sensors.get(sensor), observation.pose, self.wants_clouds())
        else {
            return Ok(());
        };
        let Some(frame) = self.topics.frame(sensor, observation) else { return Ok(()) };
        let map = self.last.as_ref().map(|sent| &sent.map);
        let header = Header::new(observation.stamp_ns(), &frame);
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
        self.outputs.send(MARKING, PASSING, &marking)?;
        self.outputs.send(CLEARING, PASSING, &clearing)
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
        #[cfg(feature = "foxglove")]
        if let Some(served) = &mut self.served {
            served.put(crate::live::served::DIAGNOSTICS, stamp_ns, &message)?;
        }
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

    /// Goes on with other parameters.
    pub(super) fn set_parameters(&mut self, config: &Config) {
        if config.full_map_m != self.config.full_map_m {
            self.sheet = Sheet::new(config.full_map_m);
        }
        self.config = config.clone();
    }

    /// Tells which parameters have changed.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn tell_parameters(&mut self, event: &ParameterEvent) -> Result<()> {
        self.outputs.send(PARAMETERS, STREAM, event)
    }

    /// Whether a map is saved as is asked for; else why not.
    pub(super) fn can_save(&self, asked: &SaveMapRequest) -> Result<(), String> {
        let own = [COSTMAP, RAW].map(|name| self.outputs.full_name(name));
        let topic = asked.map_topic.as_str();
        if !topic.is_empty()
            && !own.iter().any(|name| name.trim_start_matches('/') == topic.trim_start_matches('/'))
        {
            return Err(format!("the map of `{topic}` is not limpid's: that is on {}", own[0]));
        }
        for (what, asked, done) in
            [("image_format", &asked.image_format, "pgm"), ("map_mode", &asked.map_mode, "trinary")]
        {
            if !asked.is_empty() && asked != done {
                return Err(format!("{what} `{asked}` is not written, `{done}` is"));
            }
        }
        Ok(())
    }

    /// Saves the map as it was sent last as a picture and a description beside it, whose path is returned. `stem`: without an
    /// extension; empty: `map_` and the map's second.
    ///
    /// # Errors
    /// [`crate::Error::Empty`] before the first map; [`crate::Error::File`].
    pub(super) fn save_map(&self, stem: &Path) -> Result<PathBuf> {
        let Some(Sent { stamp_ns, map, .. }) = &self.last else {
            return Err(Error::Empty { reason: "there is no map yet".into() });
        };
        let named = PathBuf::from(format!("map_{}", stamp_ns / 1_000_000_000));
        let stem = if stem.as_os_str().is_empty() { &named } else { stem };
        let [_, description] = save_map(stem, map)?;
        Ok(description)
    }

    /// Nothing of the last map is known any more.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn forget_all(&mut self) -> Result<()> {
        self.forget(|_| true)
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
