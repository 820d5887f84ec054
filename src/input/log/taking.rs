//! What a log does with a message: unpacked, it goes to the sensors and the motion that read its channel.

use crate::base::Result;
use crate::input::event::{Event, TransformEvent};
use crate::input::log::decode::{self, CalibrationMessage};
use crate::input::log::reading::Log;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::topics::{Channel, Kind};
use crate::input::zstd_frame;

impl Log {
    /// Messages that rosbag2 packed one by one are unpacked.
    pub(super) fn take_message(&mut self, channel_id: u32, log_time_ns: u64, payload: &[u8]) {
        if !zstd_frame::is_packed(payload) {
            return self.take_unpacked(channel_id, log_time_ns, payload);
        }
        match zstd_frame::unpack(payload) {
            Ok(unpacked) => self.take_unpacked(channel_id, log_time_ns, &unpacked),
            Err(error) => {
                let topic = self.channels.get(channel_id).map_or("", |channel| &channel.topic);
                self.report.skip(topic, error.to_string(), log_time_ns);
            }
        }
    }

    fn take_unpacked(&mut self, channel_id: u32, log_time_ns: u64, payload: &[u8]) {
        let Some(channel) = self.channels.get(channel_id) else { return };
        let Channel { topic, kind: Some(kind), .. } = channel else { return };
        let (channel, topic, kind) = (channel.clone(), topic.clone(), *kind);
        self.log_time_ns = self.log_time_ns.max(log_time_ns);
        let taken = if kind.is_calibration() {
            self.take_calibration(&topic, kind, payload)
        } else if self.motion.reads(&channel) {
            let transforms = self.motion.take(&topic, kind, log_time_ns, payload, &mut self.report);
            transforms.map(|transforms| transforms.iter().for_each(|t| self.take_transform(&topic, t)))
        } else {
            self.take_data(&channel, kind, log_time_ns, payload)
        };
        if let Err(error) = taken {
            self.report.skip(&topic, error.to_string(), log_time_ns);
        }
    }

    fn take_calibration(&mut self, topic: &str, kind: Kind, payload: &[u8]) -> Result<()> {
        let CalibrationMessage { stamp_ns, frame_id, calibration } = decode::calibration(kind, payload)?;
        let calibration = calibration.map_err(|error| {
            let reason = error.to_string();
            self.report.skip(topic, &*reason, stamp_ns);
            reason
        });
        let Self { sensors, motion, .. } = self;
        for sensor in sensors {
            let Reader::Camera(camera) = &mut sensor.reader else { continue };
            let frame_id = camera.frame_id(topic).unwrap_or(&frame_id).to_owned();
            let event =
                Event::Calibration { topic: topic.into(), frame_id, calibration: calibration.clone() };
            camera.sync.push(event, &motion.poses, &mut camera.report);
        }
        Ok(())
    }

    fn take_transform(&mut self, topic: &str, transform: &TransformEvent) {
        if self.motion.poses.jumps_back(transform) {
            self.restart(
                "transform stamps jumped back by more than a second: pairing and transforms start over there",
            );
        }
        self.motion.poses.take(topic, transform, &mut self.report);
    }

    /// The transforms start over, and with them what was seen before they did.
    fn restart(&mut self, note: &str) {
        for sensor in &mut self.sensors {
            sensor.restart_with_transforms(&self.motion);
        }
        self.motion.poses.tree.clear_samples();
        self.report.note(note);
    }

    fn take_data(&mut self, channel: &Channel, kind: Kind, log_time_ns: u64, payload: &[u8]) -> Result<()> {
        for at in 0..self.sensors.len() {
            if !self.sensors[at].reads(channel) {
                continue;
            }
            match &mut self.sensors[at].reader {
                Reader::Lidar(lidar) => lidar.take(kind, log_time_ns, payload),
                Reader::Camera(camera) if matches!(kind, Kind::RosTransform(_) | Kind::RosFloat(_)) => {
                    let transform = camera.sdk_transform(&channel.topic, kind, payload)?;
                    if let Some(transform) = transform {
                        self.take_transform(&channel.topic, &transform);
                    }
                }
                Reader::Camera(camera) => {
                    if let Some(event) = camera.event(&channel.topic, kind, log_time_ns, payload) {
                        self.take_event(at, event, log_time_ns);
                    }
                }
                Reader::Absent => {}
            }
        }
        Ok(())
    }

    fn take_event(&mut self, at: usize, event: Event, log_time_ns: u64) {
        let alone = self.sensors.len() == 1;
        let LogSensor { name, reader, ready, track } = &mut self.sensors[at];
        let Reader::Camera(camera) = reader else { return };
        if let Some(what) = camera.restart_at(&event, &self.motion) {
            while let Some(observation) = camera.pop(&self.motion) {
                ready.push_back((track.jumps, observation));
            }
            let scope = if alone { "pairing and transforms start" } else { "its pairing starts" };
            camera
                .report
                .note(format!("`{name}`: {what} jumped back by more than a second: {scope} over there"));
            // The transforms serve others whose stamps may not have jumped.
            if alone {
                self.motion.poses.tree.clear_samples();
            }
        }
        let seen_ns = if let Event::Depth(image) = &event { Some(image.stamp_ns) } else { None };
        if let Some(stamp_ns) = seen_ns {
            track.see(stamp_ns, log_time_ns);
        }
        camera.sync.push(event, &self.motion.poses, &mut camera.report);
        if seen_ns.is_some() {
            self.compare_clocks(at);
        }
    }

    /// Has scans that are decoded wait for their poses.
    pub(super) fn take_scans(&mut self) {
        for at in 0..self.sensors.len() {
            let mut seen = false;
            let LogSensor { name, reader, track, .. } = &mut self.sensors[at];
            let Reader::Lidar(lidar) = reader else { continue };
            while let Some(scan) = lidar.next_scan() {
                let jumped = track.see(scan.stamp_ns, self.log_time_ns);
                if jumped {
                    let note = format!("`{name}`: stamps of scans jumped back by more than a second");
                    lidar.report.read.note(note);
                }
                lidar.wait(scan, jumped);
                seen = true;
            }
            if seen {
                self.compare_clocks(at);
            }
        }
    }

    /// Tells of clocks that differ from that of a sensor.
    fn compare_clocks(&mut self, at: usize) {
        let this = &self.sensors[at];
        for other in self.sensors.iter().filter(|other| other.name != this.name) {
            let Some(ahead_s) = this.track.ahead_of_s(&other.track) else { continue };
            let (first, last, ahead_s) = if ahead_s > 0.0 {
                (&this.name, &other.name, ahead_s)
            } else {
                (&other.name, &this.name, -ahead_s)
            };
            self.report.note_once(
                &format!("clocks differ: stamps of `{first}` are ahead of those of `{last}`"),
                &format!(" by {ahead_s:.1} s when they are read"),
            );
        }
    }
}
