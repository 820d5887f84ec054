//! Pictures of every result: the map, reliability over the camera's image, labelled scans from above.

use std::path::{Path, PathBuf};

use crate::base::Result;
use crate::config::{Config, SensorInfo};
use crate::map::{Seen, State, Update};
use crate::output::{FileNames, Sink, create_folder, encode_error, grid_mismatch, narrow};
use crate::sensor::Observation;

pub(crate) mod canvas;
mod classes;
mod costmap;
mod font;
mod glass;
mod reliability;

use canvas::{Canvas, Rgb, TEXT_HEIGHT};
pub(crate) use costmap::color_of_cost;
#[cfg(feature = "ros2")]
pub(crate) use costmap::save_costs;

/// Ground of the legends.
const PANEL: Rgb = [24, 24, 26];
const TEXT: Rgb = [222, 222, 222];
const WARNING: Rgb = [255, 176, 32];
const BLACK: Rgb = [0, 0, 0];
const WHITE: Rgb = [255, 255, 255];

/// Height of the legend under a picture, pixels: two lines of text.
const PANEL_HEIGHT: u32 = 66;
const MARGIN: i64 = 12;
/// From a line of text to the next.
const LINE_HEIGHT: u32 = 26;

/// Writes pictures of what updates hold:
///
/// - `DIR/NNNNNN-costmap.png`: the map in RViz's colours, or `DIR/NNNNNN-map.png`: by class, where a lidar takes part;
/// - `DIR/NNNNNN-reliability.png` of a camera whose images were read back;
/// - `DIR/NNNNNN-glass.png` of a lidar, where glass is searched for.
///
/// Where the map has several sensors, the names of files begin with the sensor's, or with `map`: `DIR/front-NNNNNN-glass.png`.
pub struct PngSink {
    folder: PathBuf,
    names: FileNames,
    /// Of each sensor.
    taus: Vec<f32>,
}

impl PngSink {
    /// Creates the folder `folder` unless it is there; `sensors` as [`Update::sensor`] counts them.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) where it cannot be created.
    pub fn create(folder: &Path, _config: &Config, sensors: &[SensorInfo]) -> Result<Self> {
        create_folder(folder)?;
        let taus = sensors.iter().map(|sensor| narrow(sensor.config.tau)).collect();
        Ok(Self { folder: folder.into(), names: FileNames::of(sensors), taus })
    }

    /// Where a picture of `update` goes; `name`: what the file's name begins with, unless empty.
    fn path(&self, name: &str, update: &Update, what: &str) -> PathBuf {
        let dash = if name.is_empty() { "" } else { "-" };
        self.folder.join(format!("{name}{dash}{:06}-{what}.png", update.index))
    }

    fn write_map(&self, update: &Update) -> Result<()> {
        let Some(map) = &update.map else { return Ok(()) };
        let by_class = !map.classes.is_empty();
        let path = self.path(self.names.map(), update, if by_class { "map" } else { "costmap" });
        if let Some(reason) = grid_mismatch(map) {
            return Err(encode_error(&path, reason));
        }
        let picture = if by_class { classes::draw(update, map) } else { costmap::draw(update, map) };
        picture.save(&path)
    }
}

impl Sink for PngSink {
    fn write(&mut self, update: &Update, observation: Option<&Observation>) -> Result<()> {
        self.write_map(update)?;
        let name = self.names.sensor(update);
        if let Some(images) = update.camera().and_then(|camera| camera.images.as_ref()) {
            let path = self.path(name, update, "reliability");
            let tau = update.sensor.and_then(|sensor| self.taus.get(sensor));
            let tau = tau.ok_or_else(|| encode_error(&path, "a result of an unknown sensor"))?;
            let picture = reliability::draw(images, update, *tau)
                .ok_or_else(|| encode_error(&path, "depth, reliability and colour do not fill the image"))?;
            picture.save(&path)?;
        }
        if let Some(labelled) = update.lidar().and_then(|lidar| lidar.glass.as_ref()) {
            let path = self.path(name, update, "glass");
            let scan = observation.and_then(Observation::scan);
            let scan = scan.ok_or_else(|| encode_error(&path, "labels without their scan"))?;
            glass::draw(scan, labelled, update.index).save(&path)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// A picture of `width` x `height` pixels with a panel under it for a legend of `legend_width` pixels.
fn with_panel(width: u32, height: u32, legend_width: u32) -> Canvas {
    with_panel_of_lines(width, height, legend_width, 1)
}

/// As [`with_panel`], for a legend of some lines.
fn with_panel_of_lines(width: u32, height: u32, legend_width: u32, lines: u32) -> Canvas {
    let more = LINE_HEIGHT * lines.saturating_sub(1);
    Canvas::new(width.max(legend_width), height + PANEL_HEIGHT + more, PANEL)
}

/// A patch of colour with its name; gives the x where the next one starts.
fn legend_entry(canvas: &mut Canvas, x: i64, y: i64, label: &str, color: Rgb) -> i64 {
    canvas.fill_framed(x + 1, y, TEXT_HEIGHT, TEXT_HEIGHT, color, TEXT);
    canvas.text(x + TEXT_HEIGHT + 10, y, label, TEXT) + MARGIN
}

/// Number, stamp and state.
fn status_line(canvas: &mut Canvas, y: i64, update: &Update) {
    let (seconds, milliseconds) = (update.stamp_ns / 1_000_000_000, update.stamp_ns / 1_000_000 % 1000);
    let text = format!("{:06}  {seconds}.{milliseconds:03} s  ", update.index);
    let x = canvas.text(MARGIN, y, &text, TEXT);
    match (&update.seen, &update.map) {
        (Some(Seen::Camera(camera)), _) => {
            let (state, color) = if camera.degraded { ("DEGRADED ", WARNING) } else { ("", TEXT) };
            let percent = camera.low_reliability_fraction * 100.0;
            canvas.text(x, y, &format!("{state}{percent:.0} % unreliable"), color);
        }
        (Some(Seen::Lidar(lidar)), _) => {
            canvas.text(x, y, &format!("{} points", lidar.points), TEXT);
        }
        (None, Some(map)) if map.state != State::Ok => {
            canvas.text(x, y, map.state.name(), WARNING);
        }
        (None, _) => {}
    }
}
