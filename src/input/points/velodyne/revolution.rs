//! Packets to points, cut into revolutions.

use std::collections::VecDeque;

use crate::base::Result;
use crate::input::ReadReport;
use crate::input::points::Options;
use crate::input::points::velodyne::detect::{detect, elapsed_us};
use crate::input::points::velodyne::model::Calibration;
use crate::input::points::velodyne::packet::{BLOCKS, Packet, ReturnMode, TURN};
use crate::sensor::{Columns, DropReason, Dropped, Point, ReturnType, Scan, Strength};

/// Packets looked at before the model is decided.
const DETECTION_PACKETS: usize = 16;

/// Most packets in a revolution: at five turns a second a VLP-16 in dual mode sends 302, an HDL-32E 724.
const MAX_PACKETS: usize = 1024;

/// Longest time of a revolution, microseconds; the slowest turn takes 200 ms.
const MAX_REVOLUTION_US: u32 = 1_000_000;

/// Fastest turn that is believed, hundredths of a degree in a second: 25 turns.
const MAX_RATE: f32 = 900_000.0;

/// Where scans end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// Where the azimuth wraps.
    AtWrap,
    /// Not in this packet: its sender says where.
    Not,
    /// After this packet, and not before.
    After,
}

/// A packet with the time it came at, before the model is decided.
struct Waiting {
    packet: Packet,
    stamp_ns: u64,
    cut: Cut,
}

/// A revolution in the making.
struct Building {
    scan: Scan,
    /// The sensor's time of the packet that it starts in.
    start_us: u32,
    /// From that to the revolution's first firing, seconds.
    start_s: f32,
    last_azimuth: u16,
    packets: usize,
    column: u16,
}

/// Decodes the packets of one sensor, without I/O: packets in, revolutions out.
///
/// Revolutions end where the azimuth wraps, or where the caller says so. A scan's stamp is the time that its first packet
/// came at, plus the time of its first firing in the packet. Memory is bounded: a revolution that does not end is cut
/// after 1024 packets or a second.
pub struct Decoder {
    /// Names the packets in reports.
    source: String,
    frame_id: String,
    waiting: Vec<Waiting>,
    calibration: Option<Calibration>,
    /// Factory byte of the first packet; those of another sensor are passed over.
    model_byte: Option<u8>,
    building: Option<Building>,
    /// Points of the last scan: about as many will be in the next.
    last_points: usize,
    finished: VecDeque<Scan>,
}

impl Decoder {
    /// For the packets of `source` (a topic or file) in frame `frame_id`.
    pub fn new(source: &str, frame_id: &str, options: &Options) -> Self {
        let calibration = options.model.map(Calibration::new);
        Self {
            source: source.into(),
            frame_id: frame_id.into(),
            waiting: Vec::new(),
            calibration,
            model_byte: None,
            building: None,
            last_points: 0,
            finished: VecDeque::new(),
        }
    }

    /// Takes a packet that came at `stamp_ns`; bad packets are counted in the report.
    pub fn push(&mut self, payload: &[u8], stamp_ns: u64, cut: Cut, report: &mut ReadReport) {
        let packet = match self.check(payload) {
            Ok(packet) => packet,
            Err(reason) => {
                report.skip(&self.source, reason, stamp_ns);
                if cut == Cut::After {
                    self.finish(report);
                }
                return;
            }
        };
        let waiting = Waiting { packet, stamp_ns, cut };
        if self.calibration.is_some() {
            self.decode(&waiting, report);
            return;
        }
        self.waiting.push(waiting);
        if self.waiting.len() == DETECTION_PACKETS {
            self.decide(report);
        }
    }

    /// Ends the revolution that is being decoded; to be called after the last packet.
    pub fn finish(&mut self, report: &mut ReadReport) {
        self.decide(report);
        self.end_scan();
    }

    /// The next whole revolution.
    pub fn pop(&mut self) -> Option<Scan> {
        self.finished.pop_front()
    }

    fn check(&mut self, payload: &[u8]) -> Result<Packet, String> {
        let packet = Packet::new(payload).map_err(|error| error.to_string())?;
        let first = *self.model_byte.get_or_insert(packet.model_byte());
        if packet.model_byte() == first {
            return Ok(packet);
        }
        let byte = packet.model_byte();
        Err(format!("Velodyne packet: factory byte {byte:#04x} after {first:#04x}, from another sensor"))
    }

    /// Decides for a model and decodes what waited for that; without one, all is counted and the next packets
    /// decide anew.
    fn decide(&mut self, report: &mut ReadReport) {
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.is_empty() {
            return;
        }
        let packets: Vec<&Packet> = waiting.iter().map(|waiting| &waiting.packet).collect();
        match detect(&packets) {
            Ok((model, note)) => {
                note.into_iter().for_each(|note| report.note(format!("{}: {note}", self.source)));
                self.calibration = Some(Calibration::new(model));
                waiting.iter().for_each(|waiting| self.decode(waiting, report));
            }
            Err(error) => {
                self.model_byte = None;
                for waiting in &waiting {
                    report.skip(&self.source, error.to_string(), waiting.stamp_ns);
                }
            }
        }
    }

    fn end_scan(&mut self) {
        let ended = self.building.take().map(|building| building.scan);
        self.last_points = ended.as_ref().map_or(self.last_points, |scan| scan.points.len());
        self.finished.extend(ended);
    }

    fn decode(&mut self, waiting: &Waiting, report: &mut ReadReport) {
        let Waiting { packet, stamp_ns, cut } = waiting;
        self.cut_endless(packet, *stamp_ns, report);
        let Some(calibration) = self.calibration.take() else { return };
        let rate = rate(packet, &calibration);
        for block in (0..BLOCKS).step_by(packet.blocks_per_firing()) {
            let azimuth = packet.azimuth(block);
            let wraps = |building: &Building| building.last_azimuth.saturating_sub(azimuth) > TURN / 2;
            if *cut == Cut::AtWrap && self.building.as_ref().is_some_and(wraps) {
                self.end_scan();
            }
            let firing = block / packet.blocks_per_firing();
            let start_s = calibration.firing_s[firing][0];
            let building = self.building.get_or_insert_with(|| {
                let scan = new_scan(&self.frame_id, stamp_after(*stamp_ns, start_s), self.last_points);
                Building { scan, start_us: packet.time_us(), start_s, last_azimuth: 0, packets: 0, column: 0 }
            });
            building.last_azimuth = azimuth;
            building.add(packet, block, rate, &calibration);
        }
        self.calibration = Some(calibration);
        if let Some(building) = &mut self.building {
            building.packets += 1;
        }
        if *cut == Cut::After {
            self.end_scan();
        }
    }

    fn cut_endless(&mut self, packet: &Packet, stamp_ns: u64, report: &mut ReadReport) {
        let Some(building) = &self.building else { return };
        if building.packets >= MAX_PACKETS {
            let reason = format!("a revolution does not end: cut after {MAX_PACKETS} packets");
            report.skip(&self.source, reason, stamp_ns);
        } else if elapsed_us(building.start_us, packet.time_us()) <= MAX_REVOLUTION_US {
            return;
        }
        self.end_scan();
    }
}

fn new_scan(frame_id: &str, stamp_ns: u64, points: usize) -> Scan {
    Scan {
        index: 0,
        stamp_ns,
        frame_id: frame_id.into(),
        // The next revolution has a few in a hundred more or less.
        points: Vec::with_capacity(points + points / 16),
        columns: Columns { ring: true, column: true, time: true, return_type: true, ..Columns::default() },
        dropped: Dropped::default(),
    }
}

fn stamp_after(stamp_ns: u64, seconds: f32) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 1.4 ms, positive")]
    let after_ns = (f64::from(seconds) * 1e9).round() as u64;
    stamp_ns.saturating_add(after_ns)
}

/// Hundredths of a degree that the sensor turns in a second, on average over a packet. A gap within the packet (a
/// limited field of view) would make it spin: then it is the smallest step between blocks that counts.
fn rate(packet: &Packet, calibration: &Calibration) -> f32 {
    let step = packet.blocks_per_firing();
    let turned = |from: usize, to: usize| {
        let (from, to) = (u32::from(packet.azimuth(from)), u32::from(packet.azimuth(to)));
        f32::from(u16::try_from((to + u32::from(TURN) - from) % u32::from(TURN)).unwrap_or_default())
    };
    let last = (BLOCKS - 1) / step;
    let mean = turned(0, BLOCKS - 1) / (calibration.firing_s[last][0] - calibration.firing_s[0][0]);
    if mean <= MAX_RATE {
        return mean;
    }
    let block_s = calibration.firing_s[1][0];
    let steps = (step..BLOCKS).step_by(step).map(|block| turned(block - step, block));
    (steps.fold(f32::INFINITY, f32::min) / block_s).min(MAX_RATE)
}

/// What the measurements of a channel have in common.
struct Firing<'a> {
    calibration: &'a Calibration,
    channel: usize,
    azimuth: usize,
    time_s: f32,
    column: u16,
}

impl Building {
    /// The points of a block, in dual mode of a pair of blocks.
    fn add(&mut self, packet: &Packet, block: usize, rate: f32, calibration: &Calibration) {
        let firing_s = &calibration.firing_s[block / packet.blocks_per_firing()];
        #[expect(clippy::cast_precision_loss, reason = "within a second, to a tenth of a microsecond")]
        let packet_s = elapsed_us(self.start_us, packet.time_us()) as f32 * 1e-6 - self.start_s;
        let azimuth = f32::from(packet.azimuth(block));
        let first_column = self.column;
        let firing = |channel: usize| Firing {
            calibration,
            channel,
            azimuth: turned_azimuth(azimuth, rate * (firing_s[channel] - firing_s[0])),
            time_s: packet_s + firing_s[channel],
            column: first_column.saturating_add(calibration.channels[channel].sequence),
        };
        let mode = packet.mode();
        if mode == ReturnMode::Dual {
            let pairs = packet.measurements(block).zip(packet.measurements(block + 1)).enumerate();
            pairs.for_each(|(channel, (last, other))| self.add_pair(&firing(channel), last, other));
        } else {
            for (channel, measured) in packet.measurements(block).enumerate() {
                self.add_return(&firing(channel), measured, ReturnType::Single, Strength::Unknown);
            }
        }
        self.column = self.column.saturating_add(calibration.sequences);
    }

    /// The two slots of a beam: equal distances are one return.
    fn add_pair(&mut self, firing: &Firing, last: (u16, u8), other: (u16, u8)) {
        if last.0 == other.0 {
            let slots = if last.0 == 0 { 1 } else { 0 };
            self.scan.dropped.add(DropReason::NoReturn, slots);
            return self.add_return(firing, other, ReturnType::Both, Strength::Unknown);
        }
        let [of_last, of_other] = match (last.0, other.0) {
            (0, _) | (_, 0) => [Strength::Unknown; 2],
            _ => [Strength::of(last.1, other.1), Strength::of(other.1, last.1)],
        };
        self.add_return(firing, last, ReturnType::Last, of_last);
        self.add_return(firing, other, ReturnType::StrongestOrSecond, of_other);
    }

    fn add_return(
        &mut self,
        firing: &Firing,
        (distance, reflectivity): (u16, u8),
        return_type: ReturnType,
        strength: Strength,
    ) {
        if distance == 0 {
            return self.scan.dropped.add(DropReason::NoReturn, 1);
        }
        let channel = &firing.calibration.channels[firing.channel];
        let distance_m = f32::from(distance) * firing.calibration.distance_unit_m;
        let ahead = (firing.azimuth + channel.ahead) % usize::from(TURN);
        let [cos, sin] = firing.calibration.directions[ahead];
        let across_m = distance_m * channel.cos_elevation;
        self.scan.points.push(Point {
            x_m: across_m * cos,
            y_m: -across_m * sin,
            z_m: distance_m * channel.sin_elevation + channel.offset_m,
            intensity: reflectivity.into(),
            time_s: firing.time_s,
            ring: channel.ring,
            column: firing.column,
            return_type,
            strength,
            reserved: 0,
            label: Point::UNLABELLED,
        });
    }
}

/// The azimuth of a later firing of a block, rounded to the hundredths of a degree that the sensor counts in.
fn turned_azimuth(azimuth: f32, turned: f32) -> usize {
    // A whole turn keeps it positive, so that cutting off after adding a half rounds.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most three turns, positive"
    )]
    let hundredths = (azimuth + turned + f32::from(TURN) + 0.5) as u32;
    (hundredths % u32::from(TURN)) as usize
}
