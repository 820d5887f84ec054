//! Plan maps of lidar scans in an MCAP.

use std::path::Path;

use serde_bytes::Bytes;

use crate::base::Result;
use crate::config::Config;
use crate::lidar::{CellClass, ScanFrame, ScanOutput};
use crate::message::ros2::{Header, TFMessage, TransformStamped};
use crate::output::glass::{cleaned_cloud, labelled_cloud, pane_markers};
use crate::output::mcap::{GridTopics, occupancy_grid, write_costmap};
use crate::output::{McapSink, Sink};

/// Topics of the plan map.
const TOPICS: GridTopics =
    GridTopics { occupancy: "/limpid/plan", raw: "/limpid/plan_raw", layer: "limpid_plan" };

/// Writes, for every scan, stamped as the scan:
///
/// | topic | type |
/// |---|---|
/// | `/limpid/plan` | `nav_msgs/OccupancyGrid` of the plan map's costs |
/// | `/limpid/plan_raw` | `nav2_msgs/Costmap`, its costs |
/// | `/limpid/plan_classes` | `nav_msgs/OccupancyGrid`: 0 free, 25 passable, 50 inflated, 75 transparent, 100 solid, -1 unknown |
/// | `/limpid/glass/points` | `sensor_msgs/PointCloud2`: x, y, z, intensity, ring, return_type, class, plane_id (lidar frame), where glass is searched for |
/// | `/limpid/glass/cleaned` | the same, for SLAM: inside, glass, outside and mirrored points |
/// | `/limpid/glass/panes` | `visualization_msgs/MarkerArray`: panes as thin boxes (lidar frame) |
/// | `/tf` | map from base, base from lidar, where the map is not the lidar's own frame |
pub struct ScanMcapSink {
    mcap: McapSink,
    base_frame: String,
    lidar_frame: String,
}

impl ScanMcapSink {
    /// Creates (or replaces) the file `path`.
    ///
    /// # Errors
    /// [`crate::Error::File`] where it cannot be created.
    pub fn create(path: &Path, config: &Config) -> Result<Self> {
        Ok(Self::beside(McapSink::create(path, config)?, config))
    }

    /// Writes into the file of another sink, which is complete when both are finished.
    pub fn beside(mcap: McapSink, config: &Config) -> Self {
        Self { mcap, base_frame: config.base_frame.clone(), lidar_frame: config.lidar_frame.clone() }
    }
}

/// Occupancy by which a class is shown.
fn occupancy_of_class(class: u8) -> i8 {
    match class {
        c if c == CellClass::Free as u8 => 0,
        c if c == CellClass::Passable as u8 => 25,
        c if c == CellClass::Inflated as u8 => 50,
        c if c == CellClass::Transparent as u8 => 75,
        c if c == CellClass::Solid as u8 => 100,
        _ => -1,
    }
}

impl Sink<ScanFrame, ScanOutput> for ScanMcapSink {
    fn write(&mut self, input: &ScanFrame, output: &ScanOutput) -> Result<()> {
        let (stamp_ns, map_frame) = (output.stamp_ns, output.map_frame.as_str());
        let lidar_frame = [&self.lidar_frame, &input.scan.frame_id].into_iter().find(|name| !name.is_empty());
        let lidar_frame = lidar_frame.map_or("lidar", String::as_str);
        let base_frame = self.base_frame.as_str();
        let edge = |parent: &str, child: &str, pose| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.to_owned(),
            transform: crate::base::Rigid::into(pose),
        };
        let transforms = (map_frame != lidar_frame).then(|| {
            let mut transforms = vec![edge(map_frame, base_frame, output.map_from_base)];
            if lidar_frame != base_frame {
                transforms.push(edge(base_frame, lidar_frame, output.base_from_lidar));
            }
            transforms
        });
        self.mcap.with_file(|file, path| {
            write_costmap(file, path, &TOPICS, stamp_ns, map_frame, &output.grid, &output.costmap)?;
            let classes: Vec<u8> =
                output.classes.iter().map(|&class| occupancy_of_class(class).cast_unsigned()).collect();
            let message = occupancy_grid(stamp_ns, map_frame, &output.grid, Bytes::new(&classes));
            file.write("/limpid/plan_classes", stamp_ns, &message)?;
            if let Some(labelled) = &output.glass {
                let header = || Header::new(stamp_ns, lidar_frame);
                let points = labelled_cloud(header(), &input.scan, labelled);
                file.write("/limpid/glass/points", stamp_ns, &points)?;
                let points = cleaned_cloud(header(), &input.scan, labelled);
                file.write("/limpid/glass/cleaned", stamp_ns, &points)?;
                file.write("/limpid/glass/panes", stamp_ns, &pane_markers(&header(), &labelled.panes))?;
            }
            match transforms {
                Some(transforms) => file.write("/tf", stamp_ns, &TFMessage { transforms }),
                None => Ok(()),
            }
        })?;
        self.mcap.end_frame()
    }

    fn finish(&mut self) -> Result<()> {
        self.mcap.close()
    }
}
