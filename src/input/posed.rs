//! Scans with what their recording says of the robot: poses at the scan's stamp and at those of its first and last point,
//! and the goal.

use std::path::Path;

use crate::base::Result;
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::log::{Log, LogFiles, lidar_log};
use crate::input::points;
use crate::input::points::{Options, ScanReport, Scans};
use crate::input::pose::PoseResolver;
use crate::input::report::merge;
use crate::input::scan_pose::ScanPoser;
use crate::sensor::{Observation, SensorKind};

/// What the scans come from.
enum From {
    Log(Box<Log>),
    Files(Box<Files>),
}

/// Files, whose poses are `static_transforms` alone; without these the map is the lidar's own frame.
struct Files {
    scans: Box<dyn Scans>,
    stated: Option<PoseResolver>,
    poser: ScanPoser,
    report: ReadReport,
}

/// A stream of scans with poses; see the module.
pub struct PosedScans {
    from: From,
    scan_count_hint: Option<u64>,
}

impl PosedScans {
    /// Opens any recording that [`points::open`] reads. Where it has neither transforms nor odometry and the configuration
    /// states no transforms, maps lie in the lidar's own frame.
    ///
    /// # Errors
    /// What [`points::open`] returns; [`crate::Error::Config`] for a configured topic that is absent or of another type.
    pub fn open(path: &Path, config: &Config) -> Result<Self> {
        if let Some(files) = LogFiles::find(path)? {
            let log = lidar_log(files, config)?;
            return Ok(Self { scan_count_hint: log.scan_count_hint(), from: From::Log(Box::new(log)) });
        }
        let scans = points::open(path, &Options::of(config))?;
        let stated = !config.static_transforms.is_empty();
        let scan_count_hint = scans.scan_count_hint();
        let files = Files {
            stated: stated.then(|| PoseResolver::new(config)).transpose()?,
            poser: ScanPoser::new(config),
            report: ReadReport::default(),
            scans,
        };
        Ok(Self { from: From::Files(Box::new(files)), scan_count_hint })
    }

    /// The next scan with its pose and goal, of sensor 0; the pose is `None` where it is not known at that stamp, which is
    /// counted.
    ///
    /// # Errors
    /// Only what ends the recording.
    pub fn next_observation(&mut self) -> Result<Option<Observation>> {
        match &mut self.from {
            From::Log(log) => log.next_of_one(),
            From::Files(files) => {
                let Files { scans, stated, poser, report } = &mut **files;
                Ok(scans.next_scan()?.map(|scan| poser.observe(scan, stated.as_ref(), report)))
            }
        }
    }

    /// What was met so far, poses included.
    pub fn report(&self) -> ScanReport {
        match &self.from {
            From::Log(log) => log.scan_report(),
            From::Files(files) => {
                let mut whole = files.scans.report().clone();
                merge(&mut whole.read, &files.report);
                let explain = |poses: &PoseResolver| {
                    let without = "the file has no transforms";
                    poses.explain(&files.poser.posing, SensorKind::Lidar, without, "")
                };
                files
                    .stated
                    .as_ref()
                    .and_then(explain)
                    .into_iter()
                    .for_each(|told| whole.read.tell_frames(told));
                whole
            }
        }
    }

    /// How many scans the recording says it holds, where it does.
    pub fn scan_count_hint(&self) -> Option<u64> {
        self.scan_count_hint
    }
}
