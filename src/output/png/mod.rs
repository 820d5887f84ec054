//! Pictures of every frame: the costmap in RViz colours, and reliability over the camera's image.

use std::path::{Path, PathBuf};

use crate::base::Result;
use crate::config::Config;
use crate::frame::FrameOutput;
use crate::lidar::{ScanFrame, ScanOutput};
use crate::output::{Sink, create_folder, encode_error, grid_mismatch, narrow};
use crate::sensor::RgbdFrame;

pub(crate) mod canvas;
mod costmap;
mod font;
mod glass;
mod plan;
mod reliability;

use canvas::{Canvas, Rgb, TEXT_HEIGHT};
pub(crate) use costmap::color_of_cost;

/// Ground of the legends.
const PANEL: Rgb = [24, 24, 26];
const TEXT: Rgb = [222, 222, 222];
const WARNING: Rgb = [255, 176, 32];
const BLACK: Rgb = [0, 0, 0];
const WHITE: Rgb = [255, 255, 255];

/// Height of the legend under a picture, pixels: two lines of text.
const PANEL_HEIGHT: u32 = 66;
const MARGIN: i64 = 12;

/// Writes `DIR/NNNNNN-costmap.png`, and `DIR/NNNNNN-reliability.png` where images were read back.
pub struct PngSink {
    folder: PathBuf,
    tau: f32,
}

impl PngSink {
    /// Creates the folder `folder` unless it is there.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) where it cannot be created.
    pub fn create(folder: &Path, config: &Config) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.into(), tau: narrow(config.tau) })
    }
}

impl Sink for PngSink {
    fn write(&mut self, _input: &RgbdFrame, output: &FrameOutput) -> Result<()> {
        let path = self.folder.join(format!("{:06}-costmap.png", output.index));
        if let Some(reason) = grid_mismatch(output) {
            return Err(encode_error(&path, reason));
        }
        costmap::draw(output).save(&path)?;
        let Some(images) = &output.images else { return Ok(()) };

        let path = self.folder.join(format!("{:06}-reliability.png", output.index));
        let picture = reliability::draw(images, output, self.tau)
            .ok_or_else(|| encode_error(&path, "depth, reliability and colour do not fill the image"))?;
        picture.save(&path)
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Writes `DIR/NNNNNN-plan.png` of every lidar scan, and `DIR/NNNNNN-glass.png` where glass is searched for.
pub struct ScanPngSink {
    folder: PathBuf,
}

impl ScanPngSink {
    /// Creates the folder `folder` unless it is there.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) where it cannot be created.
    pub fn create(folder: &Path, _config: &Config) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.into() })
    }
}

impl Sink<ScanFrame, ScanOutput> for ScanPngSink {
    fn write(&mut self, input: &ScanFrame, output: &ScanOutput) -> Result<()> {
        if let Some(labelled) = &output.glass {
            let path = self.folder.join(format!("{:06}-glass.png", output.index));
            glass::draw(&input.scan, labelled, output).save(&path)?;
        }
        plan::draw(output).save(&self.folder.join(format!("{:06}-plan.png", output.index)))
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// A picture of `width` x `height` pixels with a panel under it for a legend of `legend_width` pixels.
fn with_panel(width: u32, height: u32, legend_width: u32) -> Canvas {
    Canvas::new(width.max(legend_width), height + PANEL_HEIGHT, PANEL)
}

/// A patch of colour with its name; gives the x where the next one starts.
fn legend_entry(canvas: &mut Canvas, x: i64, y: i64, label: &str, color: Rgb) -> i64 {
    canvas.fill_framed(x + 1, y, TEXT_HEIGHT, TEXT_HEIGHT, color, TEXT);
    canvas.text(x + TEXT_HEIGHT + 10, y, label, TEXT) + MARGIN
}

/// Frame number, stamp and state.
fn status_line(canvas: &mut Canvas, y: i64, output: &FrameOutput) {
    let (seconds, milliseconds) = (output.stamp_ns / 1_000_000_000, output.stamp_ns / 1_000_000 % 1000);
    let text = format!("{:06}  {seconds}.{milliseconds:03} s  ", output.index);
    let x = canvas.text(MARGIN, y, &text, TEXT);
    let (state, color) = if output.degraded { ("DEGRADED ", WARNING) } else { ("", TEXT) };
    let percent = output.low_reliability_fraction * 100.0;
    canvas.text(x, y, &format!("{state}{percent:.0} % unreliable"), color);
}
