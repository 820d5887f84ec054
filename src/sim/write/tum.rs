//! A simulated recording as a TUM RGB-D folder.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::Recorder;
use crate::base::Result;
use crate::map::Grid;
use crate::output::{create_folder, encode_error, save_in_folder, write_exr};
use crate::sensor::CameraModel;
use crate::sim::frame::SimFrame;
use crate::sim::scene::Scene;

/// Writes `rgb.txt`, `depth.txt`, `groundtruth.txt` (map from camera), `camera.yaml`, the images, and `truth/` as
/// [`crate::sim::truth`] lists it, with `truth.txt`: stamp, depth, material and map of every frame.
pub struct TumRecorder {
    folder: PathBuf,
    camera: CameraModel,
    infrared: bool,
    lists: [String; 4],
    grid: Option<Grid>,
}

const LISTS: [&str; 4] = ["rgb.txt", "depth.txt", "groundtruth.txt", "truth.txt"];

impl TumRecorder {
    /// Creates the folder unless it is there, and its parts.
    ///
    /// # Errors
    /// [`crate::Error::File`] where that is not possible.
    pub fn create(folder: &Path, scene: &Scene, infrared: bool) -> Result<Self> {
        let parts = ["", "rgb", "depth", "truth", "truth/depth", "truth/material", "truth/map"];
        let more = ["infra1", "infra2"];
        for part in parts.iter().chain(more.iter().filter(|_| infrared)) {
            create_folder(&folder.join(part))?;
        }
        let camera = scene.camera.model();
        let recorder =
            Self { folder: folder.into(), camera, infrared, lists: Default::default(), grid: None };
        recorder.text("camera.yaml", &camera_yaml(&camera))?;
        recorder.text("truth/scene.yaml", &scene.to_yaml()?)?;
        Ok(recorder)
    }

    fn text(&self, name: &str, text: &str) -> Result<()> {
        save_in_folder(&self.folder.join(name), text.as_bytes())
    }

    fn picture(&self, name: &str, bytes: &[u8], kind: ExtendedColorType) -> Result<()> {
        let CameraModel { width, height, .. } = self.camera;
        save_png(&self.folder.join(name), bytes, [width, height], kind)
    }
}

fn save_png(path: &Path, bytes: &[u8], [width, height]: [u32; 2], kind: ExtendedColorType) -> Result<()> {
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new(&mut png)
        .write_image(bytes, width, height, kind)
        .map_err(|error| encode_error(path, error))?;
    save_in_folder(path, &png.into_inner())
}

fn camera_yaml(camera: &CameraModel) -> String {
    let CameraModel { width, height, fx, fy, cx, cy, .. } = camera;
    format!(
        "image_width: {width}\nimage_height: {height}\ncamera_name: simulated\ncamera_matrix:\n  rows: 3\n  cols: 3\n  \
         data: [{fx}, 0.0, {cx}, 0.0, {fy}, {cy}, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n\
         distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\ndepth_scale_m: 0.001\n"
    )
}

impl Recorder for TumRecorder {
    fn write(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()> {
        let name = format!("{:06}.png", frame.index);
        self.picture(&format!("rgb/{name}"), &frame.rgb, ExtendedColorType::Rgb8)?;
        let depth: &[u8] = bytemuck::cast_slice(&frame.depth_mm);
        self.picture(&format!("depth/{name}"), depth, ExtendedColorType::L16)?;
        if self.infrared {
            self.picture(&format!("infra1/{name}"), &frame.infrared_left, ExtendedColorType::L8)?;
            self.picture(&format!("infra2/{name}"), &frame.infrared_right, ExtendedColorType::L8)?;
        }
        let exr = format!("truth/depth/{:06}.exr", frame.index);
        let size = (frame.width as usize, frame.height as usize);
        write_exr(&self.folder.join(&exr), size, frame.true_depth_m.clone())?;
        self.picture(&format!("truth/material/{name}"), &frame.material, ExtendedColorType::L8)?;
        let codes: Vec<u8> = cells.iter().map(|cell| cell.wrapping_add(1).cast_unsigned()).collect();
        let map = self.folder.join(format!("truth/map/{name}"));
        save_png(&map, &codes, [grid.width, grid.height], ExtendedColorType::L8)?;
        self.grid = Some(*grid);
        let stamp = format!("{}.{:09}", frame.stamp_ns / 1_000_000_000, frame.stamp_ns % 1_000_000_000);
        let camera = frame.pose.map_from_base.then(frame.pose.base_from_camera);
        let ([x, y, z], [qx, qy, qz, qw]) = (camera.translation_m.to_array(), camera.rotation.to_array());
        let lines = [
            format!("rgb/{name}"),
            format!("depth/{name}"),
            format!("{x} {y} {z} {qx} {qy} {qz} {qw}"),
            format!("{exr} truth/material/{name} truth/map/{name}"),
        ];
        for (list, line) in self.lists.iter_mut().zip(lines) {
            // Writing into a String cannot fail.
            let _ = writeln!(list, "{stamp} {line}");
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        for (name, text) in LISTS.iter().zip(&self.lists) {
            self.text(name, text)?;
        }
        let Some(grid) = self.grid else { return Ok(()) };
        let Grid { origin_x_m, origin_y_m, resolution_m, .. } = grid;
        let map = format!(
            "origin_x_m: {origin_x_m:?}\norigin_y_m: {origin_y_m:?}\nresolution_m: {resolution_m:?}\n\
             codes: {{unknown: 0, free: 1, glass: 100, occupied: 101}}\n"
        );
        self.text("truth/map.yaml", &map)
    }
}
