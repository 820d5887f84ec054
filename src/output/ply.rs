//! Scans as binary PLY files.

use std::io::Write as _;
use std::path::Path;

use crate::base::Result;
use crate::output::StagedFile;
use crate::sensor::{Point, Scan, Strength};

/// Writes a scan as a binary little-endian PLY file: per point `x`, `y`, `z` (metres), `intensity` as float where the scan has it, `ring` as
/// ushort where a point has one (65535, [`Point::UNKNOWN`], for those that have none), `return_type` as uchar ([`crate::sensor::ReturnType`]), `time_s` as float (seconds after the scan's
/// stamp, which is in a comment); then `strength` as uchar ([`Strength`]) where a point has one, and `label` as uint
/// where the scan is labelled.
///
/// # Errors
/// [`crate::Error::File`].
pub fn save_scan(path: &Path, scan: &Scan) -> Result<()> {
    let optional = Optional {
        intensity: scan.columns.intensity,
        ring: scan.points.iter().any(|point| point.ring != Point::UNKNOWN),
        strength: scan.points.iter().any(|point| point.strength != Strength::Unknown),
        label: scan.columns.label,
    };
    let written = StagedFile::create_in_folder(path)?.filled(|file| {
        file.write_all(header(scan, optional).as_bytes())?;
        scan.points.iter().try_for_each(|point| write_point(file, point, optional))
    });
    written?.commit()
}

/// Which properties a file has beside those that all have.
#[derive(Clone, Copy)]
struct Optional {
    intensity: bool,
    ring: bool,
    strength: bool,
    label: bool,
}

fn header(scan: &Scan, optional: Optional) -> String {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment stamp_ns {}\ncomment frame_id {}\nelement vertex {}\n",
        scan.stamp_ns,
        scan.frame_id.replace(|c: char| !c.is_ascii_graphic(), "_"),
        scan.points.len()
    );
    let properties = [
        ("float x", true),
        ("float y", true),
        ("float z", true),
        ("float intensity", optional.intensity),
        ("ushort ring", optional.ring),
        ("uchar return_type", true),
        ("float time_s", true),
        ("uchar strength", optional.strength),
        ("uint label", optional.label),
    ];
    for (property, _) in properties.into_iter().filter(|(_, present)| *present) {
        header.push_str("property ");
        header.push_str(property);
        header.push('\n');
    }
    header + "end_header\n"
}

fn write_point(file: &mut impl std::io::Write, point: &Point, optional: Optional) -> std::io::Result<()> {
    for value in [point.x_m, point.y_m, point.z_m] {
        file.write_all(&value.to_le_bytes())?;
    }
    if optional.intensity {
        file.write_all(&point.intensity.to_le_bytes())?;
    }
    if optional.ring {
        file.write_all(&point.ring.to_le_bytes())?;
    }
    file.write_all(&[point.return_type as u8])?;
    file.write_all(&point.time_s.to_le_bytes())?;
    if optional.strength {
        file.write_all(&[point.strength as u8])?;
    }
    if optional.label {
        file.write_all(&point.label.to_le_bytes())?;
    }
    Ok(())
}
