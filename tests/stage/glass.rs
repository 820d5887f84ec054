//! The organized cloud.

use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::BeamGrid;
use limpid::sensor::{Point, ReturnType, Scan};
use limpid::stage::glass::{Glass, GlassMoment, ORGANIZE, ROW_TEXELS, row_texels};
use limpid::stage::lidar::intensity_layers::POINT_ROW;

use crate::reference::glass::organize;
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::{Fragment, skipped};

const EMPTY: u32 = u32::MAX;
const INDEX_BITS: u32 = 18;

/// The points as the passes get them.
pub(super) fn uploaded(scan: &Scan) -> Vec<[u32; 8]> {
    scan.points
        .iter()
        .map(|p| {
            let ring = u32::from(p.ring) | (u32::from(p.column) << 16);
            let bits = [p.x_m, p.y_m, p.z_m, p.intensity, p.time_s].map(f32::to_bits);
            [bits[0], bits[1], bits[2], bits[3], bits[4], ring, p.return_type as u32, p.label]
        })
        .collect()
}

/// Words of the cells, as column, row, slot; and of each point where it lies and the number of its cell, from 1.
fn cells(scan: &Scan, grid: &BeamGrid) -> (Vec<u32>, Vec<[f32; 4]>) {
    let glass = Glass { grid: grid.clone(), load: limpid::map::PaneSet::default() };
    let points = u32::try_from(scan.points.len()).unwrap();
    let moment = GlassMoment { points, local_from_lidar: Rigid::IDENTITY, load: None };
    let words = uploaded(scan);
    let rows = row_texels(grid);
    let out = Fragment::new()
        .params("glass_params", &glass.params(&Config::default(), &moment))
        .texture("points", [POINT_ROW, (2 * points).div_ceil(POINT_ROW)], bytemuck::cast_slice(&words))
        .float_texture("row_texels", ROW_TEXELS, rows.len() as u32 / ROW_TEXELS, &rows)
        .changed("beam_cells", &vec![EMPTY; 2 * grid.cells() as usize])
        .texture_output("placed", POINT_ROW, points.div_ceil(POINT_ROW))
        .changed("glass_counters", &[0_u32; 16])
        .run(ORGANIZE, Invocations::line(points));
    let placed = bytemuck::cast_slice(&out.floats("placed")[..4 * scan.points.len()]).to_vec();
    (out.words("beam_cells").to_vec(), placed)
}

fn compare_with_twin(scan: &Scan, grid: &BeamGrid) {
    let beams: Vec<_> = scan
        .points
        .iter()
        .map(|p| {
            let row = grid.ring_rows[usize::from(p.ring)] as usize;
            (p.position_m(), row, usize::from(p.return_type == ReturnType::Last))
        })
        .collect();
    let want = organize(&beams, grid.columns as usize);
    let (got, placed) = cells(scan, grid);
    let filled = got.iter().filter(|&&word| word != EMPTY).count();
    assert_eq!(filled, want.len());
    for ((column, row, slot), index) in want {
        let cell = 2 * (column * grid.rows as usize + row) + slot;
        let word = got[cell];
        let [x_m, y_m, z_m] = scan.points[index].position_m();
        assert_eq!(placed[index], [x_m, y_m, z_m, 1.0 + cell as f32]);
        assert_eq!(
            (word & ((1 << INDEX_BITS) - 1)) as usize,
            index,
            "column {column}, row {row}, slot {slot}"
        );
    }
}

#[test]
fn twin_on_a_room_at_all_sizes() {
    if skipped() {
        return;
    }
    // Beams in the middle of their columns, so that rounding of angles decides nothing.
    let (scan, _) = GlassRoom { yaw: 0.0, ..GlassRoom::default() }.scan();
    let grid = BeamGrid::of_scan(&scan).unwrap();
    compare_with_twin(&scan, &grid);
    for count in [1, 63, 64, 65] {
        let mut few = scan.clone();
        few.points.truncate(count);
        compare_with_twin(&few, &grid);
    }
}

#[test]
fn twin_where_points_share_cells() {
    if skipped() {
        return;
    }
    let (mut scan, _) = GlassRoom { yaw: 0.0, ..GlassRoom::default() }.scan();
    let grid = BeamGrid::of_scan(&scan).unwrap();
    let nearer =
        |point: &Point| Point { x_m: 0.5 * point.x_m, y_m: 0.5 * point.y_m, z_m: 0.5 * point.z_m, ..*point };
    let doubled: Vec<Point> = scan.points.iter().step_by(3).map(nearer).collect();
    let same: Vec<Point> = scan.points.iter().step_by(7).copied().collect();
    scan.points.extend(doubled);
    scan.points.extend(same);
    compare_with_twin(&scan, &grid);
}
