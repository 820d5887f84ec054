//! Results out of what comes back from the GPU.

use bytemuck::pod_read_unaligned;

use super::build::Kind;
use super::channel::{Built, Pending};
use crate::base::Result;
use crate::config::InflationLaw;
use crate::gpu::{Executor, Readback};
use crate::map::glass::LabelledScan;
use crate::map::{
    CameraUpdate, Counters, FrameImages, FrameLayers, Ground, LidarUpdate, MapUpdate, ScanLayers, Seen,
    State, Update, Verdict,
};
use crate::stage::camera::map_reliability;
use crate::stage::lidar::solidity::INPUTS;
use crate::stage::{CameraJob, LidarJob, MapJob};

/// States of a cell in bits 0-1, as in `shaders/lib/cell.wgsl`.
const FREE: u32 = 1;
const OCCUPIED: u32 = 2;

impl Built {
    /// The result of what was under way.
    pub(super) fn update(&self, pending: Pending, readback: &Readback) -> Result<Update> {
        let reader = Reader { readback, executor: &self.executor, scope: self.kind.scope() };
        let (seen, map) = match &self.kind {
            Kind::Camera(job) => (Some(Seen::Camera(reader.camera(job, &pending)?)), &job.map),
            Kind::Lidar(job) => (Some(Seen::Lidar(reader.lidar(job, &pending)?)), &job.map),
            Kind::Map(map) => (None, map),
        };
        let published = pending.sensor.is_none() || !map.apart;
        let ground = self.kind.ground_z_m().map(|z_m| reader.ground(&pending, z_m)).transpose()?;
        let map = published.then(|| reader.map(map, &pending)).transpose()?;
        let spans = readback.spans.iter();
        Ok(Update {
            sensor: pending.sensor,
            index: pending.index,
            stamp_ns: pending.stamp_ns,
            map_frame: pending.map_frame,
            map_from_base: pending.pose.map_from_base,
            base_from_sensor: pending.pose.base_from_sensor,
            seen,
            ground,
            map,
            pass_ms: spans.clone().map(|(name, span)| (name.clone(), span.length_ns * 1e-6)).collect(),
            pass_start_ms: spans.map(|(_, span)| span.start_ns * 1e-6).collect(),
        })
    }
}

struct Reader<'a> {
    readback: &'a Readback,
    executor: &'a Executor,
    scope: &'a str,
}

impl Reader<'_> {
    fn bytes(&self, name: &str) -> Result<&[u8]> {
        self.readback.bytes(self.executor.find_in(self.scope, name)?)
    }

    fn words(&self, name: &str) -> Result<Vec<u32>> {
        Ok(self.bytes(name)?.chunks_exact(4).map(pod_read_unaligned).collect())
    }

    fn floats(&self, name: &str, count: usize) -> Result<Vec<f32>> {
        Ok(self.bytes(name)?.chunks_exact(4).take(count).map(pod_read_unaligned).collect())
    }

    /// A grid of bytes, four to a word, without the padding of its rows.
    fn quads(&self, name: &str, side: u32) -> Result<Vec<u8>> {
        let side = side as usize;
        let rows = self.bytes(name)?.chunks_exact(side.next_multiple_of(4));
        Ok(rows.flat_map(|row| &row[..side]).copied().collect())
    }

    fn camera(&self, job: &CameraJob, pending: &Pending) -> Result<CameraUpdate> {
        let counters = counters(&self.words("counters")?, job);
        let low_reliability_fraction = f64::from(counters.low_reliability) / f64::from(job.pixels());
        Ok(CameraUpdate {
            counters,
            low_reliability_fraction,
            degraded: low_reliability_fraction > job.config.degraded_fraction,
            depth_alone: pending.depth_alone.clone(),
            images: (job.images && pending.images).then(|| self.images(job)).transpose()?,
            layers: job.layers.then(|| self.layers()).transpose()?,
            cell_inputs: self.cell_inputs(job)?,
        })
    }

    fn map(&self, job: &MapJob, pending: &Pending) -> Result<MapUpdate> {
        let costmap = self.quads("costmap", job.side)?;
        let verdicts = match job.verdicts {
            true => self
                .bytes("verdicts")?
                .chunks_exact(4)
                .map(|word| Verdict(pod_read_unaligned(word)))
                .collect(),
            false => Vec::new(),
        };
        let classes = if job.layers.lidars { self.quads("cell_classes", job.side)? } else { Vec::new() };
        Ok(MapUpdate {
            grid: pending.grid,
            costmap,
            verdicts,
            classes,
            towards_goal: pending.towards_goal,
            state: State::Ok,
            sensors: pending.states.clone(),
        })
    }

    fn ground(&self, pending: &Pending, ground_z_m: f64) -> Result<Ground> {
        let mut words = self.bytes("ground_now")?.chunks_exact(16).map(pod_read_unaligned::<[f32; 4]>);
        let now = std::array::from_fn(|_| words.next().unwrap_or_default());
        Ok(Ground::read(&now, pending.pose, ground_z_m))
    }

    fn images(&self, job: &CameraJob) -> Result<FrameImages> {
        let pixels = job.pixels() as usize;
        let color = |_| -> Result<Vec<u8>> {
            let packed = self.bytes("color")?.chunks_exact(4).take(pixels);
            Ok(packed.flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect())
        };
        Ok(FrameImages {
            width: job.depth.width,
            height: job.depth.height,
            depth_m: self.floats(job.depth_buffer(), pixels)?,
            reliability: self.floats("reliability", pixels)?,
            color: job.color.map(color).transpose()?,
        })
    }

    fn layers(&self) -> Result<FrameLayers> {
        let state = self.words("state")?;
        let cells = state.len();
        let cells_in = |wanted: u32| state.iter().map(|&s| if s & 3 == wanted { 1.0 } else { 0.0 }).collect();
        Ok(FrameLayers {
            evidence: self.floats("evidence", cells)?,
            occupancy: self.floats("occupancy", cells)?,
            occupied: cells_in(OCCUPIED),
            free: cells_in(FREE),
        })
    }

    fn lidar(&self, job: &LidarJob, pending: &Pending) -> Result<LidarUpdate> {
        let glass = job.glass.as_ref();
        let labels = |_| {
            LabelledScan::read(self.readback, self.executor, self.scope, pending.points, pending.pose_jumped)
        };
        Ok(LidarUpdate {
            points: pending.points,
            pose_jumped: pending.pose_jumped,
            glass: glass.map(labels).transpose()?,
            layers: job.layers.then(|| self.scan_layers(job)).transpose()?,
            solidity_inputs: self.solidity_inputs(job)?,
        })
    }

    fn cell_inputs(&self, job: &CameraJob) -> Result<Vec<f32>> {
        if job.map.reliability.is_none() || !job.cell_inputs {
            return Ok(Vec::new());
        }
        let cells = job.map.side as usize * job.map.side as usize;
        self.floats("map_reliability_inputs", cells * map_reliability::INPUTS.len())
    }

    fn solidity_inputs(&self, job: &LidarJob) -> Result<Vec<f32>> {
        if job.solidity.is_none() || !job.solidity_inputs {
            return Ok(Vec::new());
        }
        self.floats("solidity_inputs", job.cells() as usize * INPUTS.len())
    }

    fn scan_layers(&self, job: &LidarJob) -> Result<ScanLayers> {
        let cells = job.cells() as usize;
        let floats = |bytes: &[u8]| bytes.chunks_exact(4).map(pod_read_unaligned).collect::<Vec<f32>>();
        let values = self.bytes("layer_values")?.chunks_exact(4 * cells);
        let named = job.layer_names().into_iter().map(|name| format!("intensity_{name}"));
        let mut grids: Vec<_> = named.zip(values.map(floats)).collect();
        let cells: Vec<[f32; 4]> =
            self.bytes("cell_values")?.chunks_exact(16).map(pod_read_unaligned).collect();
        // Inflated by another law, or with the published map, there is nothing of it here.
        let inflates = !job.map.apart && job.map.law() == InflationLaw::Goal;
        let names = ["true_positive", "false_positive", "false_negative", "inflated"];
        for (at, name) in names.into_iter().enumerate().filter(|&(at, _)| inflates || at < 3) {
            grids.push((name.into(), cells.iter().map(|values| values[at]).collect()));
        }
        // Eq. 11: I_plan = I_inflate u I_FP.
        if inflates {
            let plan = cells.iter().map(|[_, passable, _, inflated]| passable.max(*inflated));
            grids.push(("plan".into(), plan.collect()));
        }
        Ok(ScanLayers { grids })
    }
}

fn counters(words: &[u32], job: &CameraJob) -> Counters {
    let at = |index: usize| words.get(index).copied().unwrap_or(0);
    Counters {
        pixels: job.pixels(),
        valid: at(0),
        low_reliability: at(1),
        hits: at(2),
        hit_cells: at(3),
        seen_through_cells: at(4),
        occupied_cells: at(5),
        free_cells: at(6),
    }
}
