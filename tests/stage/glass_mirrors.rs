//! Walls, what goes on behind them and the mirrors on them, pass by pass: analytic halls, a twin, counts made up.

use bytemuck::cast_slice;
use glam::{DVec3, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::sensor::{BeamGrid, Point, ReturnType, Scan};
use limpid::stage::glass::{
    GlassParams, IMAGES, MIRRORS, OPENINGS, ROW_TEXELS, SCAN_WALLS, WALLS, row_texels,
};
use limpid::stage::lidar::intensity_layers::POINT_ROW;

use super::glass::uploaded;
use super::glass_search::{Found, params, usual};
use crate::reference::floor_images::Cells;
use crate::reference::glass::organize;
use crate::reference::mirrors::{Counts, Wall};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::mirror_hall::{Opening, WALL_X_M, hall, in_lidar};

const NONE: u32 = u32::MAX;
const WALL_COUNT: usize = SCAN_WALLS as usize;
const STRIPS: usize = 256;
const WORDS: usize = 9;

/// A scan as the passes get it.
struct Given {
    scan: Scan,
    grid: BeamGrid,
    params: GlassParams,
    cells: Vec<u32>,
}

impl Given {
    fn of(scan: Scan) -> Self {
        let grid = BeamGrid::of_scan(&scan).unwrap();
        let row = |p: &Point| grid.ring_rows[usize::from(p.ring)] as usize;
        let beams: Vec<_> = scan
            .points
            .iter()
            .map(|p| (p.position_m(), row(p), usize::from(p.return_type == ReturnType::Last)))
            .collect();
        let mut cells = vec![NONE; 2 * grid.cells() as usize];
        for ((column, row, slot), index) in organize(&beams, grid.columns as usize) {
            let [x, y, z] = beams[index].0;
            let range_m = (x * x + y * y + z * z).sqrt();
            cells[2 * (column * grid.rows as usize + row) + slot] =
                ((range_m * 100.0) as u32) << 18 | index as u32;
        }
        let params = params(grid.clone(), &Config::default(), Rigid::IDENTITY);
        Self { scan, grid, params, cells }
    }

    fn fragment(&self) -> Fragment {
        let mut padded = uploaded(&self.scan);
        let height = (2 * padded.len() as u32).div_ceil(POINT_ROW);
        padded.resize((height * POINT_ROW) as usize / 2, [0; 8]);
        Fragment::new()
            .params("glass_params", &self.params)
            .texture("points", [POINT_ROW, height], cast_slice(&padded))
            .input("beam_cells", &self.cells)
    }

    fn walls(&self, panes: &[Pane]) -> Outputs {
        let found = Found { panes: panes.len() as u32, ..Found::default() };
        let mut padded = panes.to_vec();
        padded.resize(6, Pane::default());
        self.fragment()
            .input("found", &[found])
            .input("scan_panes", &padded)
            .output("scan_walls", 12 * WALL_COUNT)
            .output("wall_strips", WORDS * STRIPS * WALL_COUNT)
            .changed("passed_beams", &[7_u32; 2])
            .run(WALLS, Invocations::line(1))
    }
}

fn planes(out: &Outputs) -> Vec<Vec4> {
    out.floats("scan_walls")[..4 * WALL_COUNT].chunks(4).map(Vec4::from_slice).collect()
}

#[test]
fn truth_walls_are_those_of_the_hall() {
    if skipped() {
        return;
    }
    let given = Given::of(hall(Opening::Mirror, true).0);
    let out = given.walls(&[]);
    let walls = planes(&out);
    for (way, distance_m) in [(DVec3::X, WALL_X_M), (-DVec3::X, 4.0), (DVec3::Y, 3.5), (-DVec3::Y, 3.5)] {
        let normal = in_lidar(way).as_vec3();
        let is_it = |wall: &&Vec4| {
            wall.truncate().dot(normal) > 0.9999 && (f64::from(wall.w) - distance_m).abs() < 0.02
        };
        assert_eq!(walls.iter().filter(is_it).count(), 1, "{way} {walls:?}");
    }
    let strips = out.words("wall_strips");
    assert!(strips.chunks(WORDS).all(|strip| strip == [0, 0, 0, 0, 0, 0, 0, NONE, 0]));
    assert_eq!(out.words("passed_beams")[0], 0);
    // A pane of the scan in the first wall, from u = -1 to 2: no mirror is looked for there nor 0.3 m beside.
    let glazed = |out: &Outputs, wall: usize| {
        let at = 8 * WALL_COUNT + 4 * wall;
        out.floats("scan_walls")[at..at + 2].to_vec()
    };
    assert_eq!(glazed(&out, 0), [1e9, -1e9]);
    let level = Vec4::from_slice(&out.floats("scan_walls")[4 * WALL_COUNT..][..4]);
    let pane =
        Pane { normal: walls[0], level, extent_m: Vec4::new(-1.0, 2.0, -0.5, 1.0), id: 1, ..Pane::default() };
    let [least, largest] = glazed(&given.walls(&[pane]), 0)[..] else { panic!() };
    assert!((least + 1.3).abs() < 1e-4 && (largest - 2.3).abs() < 1e-4, "{least} {largest}");
    // Points of a mere dozen of columns make no wall.
    let mut few = Given::of(hall(Opening::Wall, false).0);
    let column = 2 * few.grid.rows as usize;
    few.cells
        .chunks_mut(column)
        .enumerate()
        .filter(|(k, _)| k % 120 != 0)
        .for_each(|(_, cells)| cells.fill(NONE));
    let none = planes(&few.walls(&[]));
    assert!(none.iter().all(|wall| wall.w == 0.0), "{none:?}");
}

/// What the passes count in the strips of the walls, and the twin.
fn counted(given: &Given, walls: &[f32]) -> Vec<u32> {
    let strips = vec![[0, 0, 0, 0, 0, 0, 0, NONE, 0]; STRIPS * WALL_COUNT];
    let size = given.grid.cells() as usize;
    let out = given
        .fragment()
        .input("scan_walls", walls)
        .changed("wall_strips", &strips)
        .changed("passed_beams", &vec![0_u32; 1 + 2 * size])
        .run(OPENINGS, Invocations::line(size.div_ceil(8) as u32));
    let rows = row_texels(&given.grid);
    let out = given
        .fragment()
        .float_texture("row_texels", ROW_TEXELS, rows.len() as u32 / ROW_TEXELS, &rows)
        .input("scan_walls", walls)
        .input("passed_beams", out.words("passed_beams"))
        .changed("wall_strips", out.words("wall_strips"))
        .run(IMAGES, Invocations::line(size.div_ceil(64) as u32));
    out.words("wall_strips").to_vec()
}

#[test]
fn twin_of_what_goes_on_behind_the_walls() {
    if skipped() {
        return;
    }
    for opening in [Opening::Mirror, Opening::Door(5.0)] {
        let given = Given::of(hall(opening, true).0);
        let walls = given.walls(&[]).floats("scan_walls");
        let strips = counted(&given, &walls);
        let config = Config::default();
        let place = |point: &Point| DVec3::from(point.position_m().map(f64::from));
        let points: Vec<_> = given.scan.points.iter().map(|p| (place(p), usize::from(p.ring))).collect();
        let cells = Cells::new(&given.grid, &config, &points);
        let vec = |at: usize| Vec4::from_slice(&walls[4 * at..]);
        let mut want = vec![Counts::default(); STRIPS * WALL_COUNT];
        let first = given.cells.chunks(2).filter(|cell| cell[0] != NONE);
        for cell in first {
            let at = points[(cell[0] & 0x3ffff) as usize].0;
            // Of the walls that it goes through the nearest two.
            let mut met: Vec<(f64, usize, usize, Wall)> = (0..WALL_COUNT)
                .filter(|&k| vec(k).w > 0.0)
                .filter_map(|k| {
                    let (plane, level) = (vec(k), vec(WALL_COUNT + k));
                    let [normal, level] = [plane, level].map(|v| v.truncate().as_dvec3());
                    let wall = Wall { normal, distance_m: plane.w.into(), level };
                    Some((wall.distance_m / normal.dot(at), k, wall.strip(at)?, wall))
                })
                .collect();
            met.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, k, strip, wall) in met.into_iter().take(2) {
                let counts = wall.counts(&cells, at, cell[1] != NONE);
                want[k * STRIPS + strip].iter_mut().zip(counts).for_each(|(sum, one)| *sum += one);
            }
        }
        let sum = |of: &dyn Fn(usize) -> u32| (0..STRIPS * WALL_COUNT).map(of).sum::<u32>();
        // The word of each count in a strip, and how many there are at least.
        let at_a_mirror = opening == Opening::Mirror;
        let some = [
            (0, 100),
            (1, 0),
            (3, 100),
            (4, 16),
            (5, if at_a_mirror { 0 } else { 16 }),
            (6, 16 * u32::from(at_a_mirror)),
        ];
        for (what, (word, least)) in some.into_iter().enumerate() {
            let all = sum(&|k| want[k][what]);
            let off = sum(&|k| want[k][what].abs_diff(strips[WORDS * k + word]));
            // Ends of strips and of tolerances decide by the last digit.
            assert!(off <= 2 + all / 50, "{opening:?}: of {all} in word {word} {off} differ");
            assert!(all >= least, "{opening:?}: {all} in word {word}");
        }
    }
}

/// Counts of a mirror in the strips from 100 to 115 of the first wall.
fn made_up(strip: [u32; WORDS]) -> Vec<u32> {
    let mut strips = vec![[0, 0, 0, 0, 0, 0, 0, NONE, 0]; STRIPS * WALL_COUNT];
    strips[100..116].fill(strip);
    strips.concat()
}

fn mirrors(strips: &[u32], dual: u32) -> Outputs {
    let mut walls = vec![0.0_f32; 12 * WALL_COUNT];
    walls[..4].copy_from_slice(&[1.0, 0.0, 0.0, 3.0]);
    walls[4 * WALL_COUNT..][..4].copy_from_slice(&[0.0, 1.0, 0.0, 0.0]);
    let mut counters = [0_u32; 16];
    counters[2] = dual;
    Fragment::new()
        .params("glass_params", &usual())
        .input("scan_walls", &walls)
        .input("wall_strips", strips)
        .changed("found", &[Found { panes: 2, ..Found::default() }])
        .changed("scan_panes", &[Pane::default(); 6])
        .changed("scan_ends", &[Vec4::NAN; 6])
        .changed("glass_counters", &counters)
        .run(MIRRORS, Invocations::line(1))
}

#[test]
fn truth_an_opening_is_a_mirror_by_its_counts() {
    if skipped() {
        return;
    }
    // Beams that go on, with two returns, glazed, images, missing, refuted, proofs; v from -0.5 to 1.0.
    let good = [20, 0, 1, 14, 2, 0, 1, 63_500, 65_000];
    let out = mirrors(&made_up(good), 50);
    assert_eq!((out.words("found")[3], out.words("glass_counters")[13]), (1, 1));
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[32..48]));
    assert_eq!(pane.extent_m, Vec4::new(-3.5, -1.5, -0.5, 1.0));
    assert!(pane.is_mirror() && pane.normal == Vec4::new(1.0, 0.0, 0.0, 3.0) && pane.id == 1);
    assert_eq!(out.floats("scan_ends")[8..12], [-3.5, -1.5, 0.0, 0.0]);
    // Each by itself makes it none.
    let with = |at: usize, count: u32| {
        let mut strip = good;
        strip[at] = count;
        made_up(strip)
    };
    let lone = |strip: usize| {
        let mut strips = made_up([0, 0, 0, 0, 0, 0, 0, NONE, 0]);
        strips[WORDS * strip..][..WORDS].copy_from_slice(&good);
        strips
    };
    for (why, strips, dual) in [
        ("few images", with(3, 2), 50),
        ("no proof", with(6, 0), 50),
        ("refuted", with(5, 1), 50),
        ("glass beside its image", with(1, 5), 50),
        ("glass that shows itself", with(2, 8), 50),
        ("a few beams", lone(100), 50),
        ("one return a beam", made_up(good), 0),
    ] {
        let out = mirrors(&strips, dual);
        assert_eq!((out.words("found")[3], out.words("glass_counters")[13]), (0, 0), "{why}");
    }
    // A gap of three strips parts two openings; the one with more beams is taken.
    let mut parted = made_up(good);
    parted[WORDS * 104..WORDS * 107].copy_from_slice(&[[0, 0, 0, 0, 0, 0, 0, NONE, 0]; 3].concat());
    let out = mirrors(&parted, 50);
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[32..48]));
    assert_eq!((out.words("found")[3], pane.extent_m.x, pane.extent_m.y), (1, -2.625, -1.5));
}
