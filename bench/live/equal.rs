//! Are a node's costmaps those of a replay, frame for frame?

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use limpid::message::ros2::decode_cdr;
use limpid::{Config, Error, Observation, Options, Result, Sink, Update, open_source, run as replay};

use crate::Arguments;
use crate::beside::{Beside, Costs, RAW, said};
use crate::recording::Recording;

/// Origin and costs of a map.
type Map = ([f64; 2], Vec<u8>);

/// Costmaps of a replay by stamp.
#[derive(Default, Clone)]
struct Maps(Arc<Mutex<BTreeMap<u64, Map>>>);

impl Sink for Maps {
    fn write(&mut self, update: &Update, _: Option<&Observation>) -> Result<()> {
        if let Some(map) = &update.map {
            let origin = [map.grid.origin_x_m, map.grid.origin_y_m];
            let mut maps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            maps.insert(update.stamp_ns, (origin, map.costmap.clone()));
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut config = Config::default();
    config.set("method", &arguments.method)?;
    let maps = Maps::default();
    let mut source = open_source(&arguments.recording, &config)?;
    let sinks: &mut [Box<dyn Sink>] = &mut [Box::new(maps.clone())];
    replay(source.as_mut(), 0..u64::MAX, &config, &Options::default(), sinks, &mut |_| ())?;
    let wanted = maps.0.lock().unwrap_or_else(PoisonError::into_inner).clone();

    let node = ["--method", &arguments.method, "--ros-args", "-p", "reliable_sensors:=true"];
    let node: Vec<String> = node.map(str::to_owned).into();
    let beside = Beside::start(&arguments.program, &node)?;
    let recording = Recording::read(&arguments.recording)?;
    let player = limpid::ros2::Participant::join(&beside.environment)?;
    let publications = recording.publish(&player)?;
    std::thread::sleep(Duration::from_secs(3));
    #[expect(clippy::cast_precision_loss, reason = "seconds of a recording")]
    let pace = recording.frames as f64 / arguments.hz / (recording.span_ns as f64 * 1e-9);
    let (start, first_ns) = (Instant::now(), recording.messages[0].at_ns);
    for message in &recording.messages {
        let due = start + Duration::from_nanos(message.at_ns - first_ns).mul_f64(pace);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        publications[message.topic].send(message.payload.clone())?;
    }
    compare(&beside, &wanted)
}

fn compare(beside: &Beside, wanted: &BTreeMap<u64, Map>) -> Result<()> {
    let (mut same, mut other, mut counts) = (0, 0, Vec::new());
    let until = Instant::now() + Duration::from_secs(3);
    while beside.inbox.wait(until) {
        let Some(parcel) = beside.inbox.take(None) else { continue };
        if parcel.topic != RAW {
            counts = said(&parcel.payload).map(|(_, values)| values).unwrap_or(counts);
            continue;
        }
        let costs: Costs = decode_cdr("Costmap", &parcel.payload)?;
        let map = ([costs.origin.position.x, costs.origin.position.y], costs.data);
        match wanted.get(&costs.header.stamp.stamp_ns()?) {
            Some(wanted) if *wanted == map => same += 1,
            // The last map once more, when its sensor has become stale.
            _ if !map.1.contains(&0) => {}
            _ => other += 1,
        }
    }
    println!("{} maps in the replay; live {same} equal to the bit, {other} other", wanted.len());
    counts.iter().filter(|(key, _)| key.contains('/')).for_each(|(key, value)| println!("  {key}: {value}"));
    if same == wanted.len() && other == 0 {
        return Ok(());
    }
    Err(Error::Empty { reason: "live and replay differ".into() })
}
