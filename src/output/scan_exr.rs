//! The lidar path's grids of every scan as OpenEXR images, with the scan's figures as JSON beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::base::Result;
use crate::config::Config;
use crate::lidar::{CellClass, ScanFrame, ScanOutput};
use crate::output::exr::{PoseRecord, write_exr, write_json};
use crate::output::{Sink, create_folder};

/// Writes `DIR/NNNNNN/<grid>.exr` and `DIR/NNNNNN/frame.json`, `NNNNNN` being the scan's index: `plan_costs`, `class`
/// ([`CellClass`] as its number), and where they were read back `intensity_<layer>`, `true_positive`, `false_positive`,
/// `false_negative`, `inflated` and `plan`. Row 0 = smallest y.
pub struct ScanDumpSink {
    folder: PathBuf,
}

impl ScanDumpSink {
    /// Creates the folder `folder` unless it is there.
    ///
    /// # Errors
    /// [`crate::Error::File`] where it cannot be created.
    pub fn create(folder: &Path, _config: &Config) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.into() })
    }
}

impl Sink<ScanFrame, ScanOutput> for ScanDumpSink {
    fn write(&mut self, _input: &ScanFrame, output: &ScanOutput) -> Result<()> {
        let folder = self.folder.join(format!("{:06}", output.index));
        create_folder(&folder)?;
        let cells = (output.grid.width as usize, output.grid.height as usize);
        let write = |name: &str, samples| write_exr(&folder.join(format!("{name}.exr")), cells, samples);
        write("plan_costs", output.costmap.iter().map(|&cost| f32::from(cost)).collect())?;
        write("class", output.classes.iter().map(|&class| f32::from(class)).collect())?;
        for (name, values) in output.layers.iter().flat_map(|layers| &layers.grids) {
            write(name, values.clone())?;
        }
        write_json(&folder.join("frame.json"), &ScanRecord::of(output))
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// `frame.json`.
#[derive(Serialize)]
struct ScanRecord<'a> {
    stamp_ns: u64,
    map_frame: &'a str,
    map_from_base: PoseRecord,
    base_from_lidar: PoseRecord,
    origin_x_m: f64,
    origin_y_m: f64,
    resolution_m: f64,
    width: u32,
    height: u32,
    points: usize,
    cells: BTreeMap<&'static str, usize>,
    pass_ms: BTreeMap<&'a str, f64>,
}

impl<'a> ScanRecord<'a> {
    fn of(output: &'a ScanOutput) -> Self {
        let grid = output.grid;
        Self {
            stamp_ns: output.stamp_ns,
            map_frame: &output.map_frame,
            map_from_base: output.map_from_base.into(),
            base_from_lidar: output.base_from_lidar.into(),
            origin_x_m: grid.origin_x_m,
            origin_y_m: grid.origin_y_m,
            resolution_m: grid.resolution_m,
            width: grid.width,
            height: grid.height,
            points: output.points,
            cells: CellClass::ALL.into_iter().map(|class| (class.name(), output.count(class))).collect(),
            pass_ms: output.pass_ms.iter().map(|(pass, ms)| (pass.as_str(), *ms)).collect(),
        }
    }
}
