//! Boundaries and the memory of panes, pass by pass, on analytic surveys and against their twins.

use bytemuck::cast_slice;
use glam::{DVec3, Vec3, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::stage::glass::{ACCEPT, CANDIDATE_ROW, MOST_CANDIDATES, REMEMBER};

use super::glass_search::{Found, SQUARES, grid, params, usual};
use crate::reference::glass::{ended, refined};
use crate::support::gpu::{Fragment, Outputs, skipped};

/// Squares of a survey along u.
const WIDE: usize = 128;

/// A survey in which a function gives the counts of each square.
fn survey(counts: impl Fn(usize, usize) -> [u32; 5]) -> Vec<u32> {
    let mut words = vec![0; 5 * SQUARES];
    for v in 0..64 {
        for u in 0..WIDE {
            for (kind, count) in counts(u, v).into_iter().enumerate() {
                words[kind * SQUARES + v * WIDE + u] = count;
            }
        }
    }
    words
}

const SHOWN: [u32; 5] = [4, 0, 0, 0, 0];
const BRIGHT: [u32; 5] = [0, 0, 9, 0, 0];
const BEYOND: [u32; 5] = [0, 0, 0, 6, 0];

fn accept(survey: &[u32], candidates: &[[f32; 4]], tilt: f32) -> Outputs {
    accept_in(survey, candidates, tilt, 0)
}

/// As [`accept`], in a scan with so many dual returns.
fn accept_in(survey: &[u32], candidates: &[[f32; 4]], tilt: f32, dual: u32) -> Outputs {
    let mut counters = [0_u32; 16];
    counters[2] = dual;
    let normal = Vec3::new(tilt.cos(), 0.0, tilt.sin());
    let found = Found {
        candidates: candidates.len() as u32,
        inliers: 50,
        plane: normal.extend(4.0),
        level: Vec4::new(0.0, 1.0, 0.0, 30.0),
        ..Found::default()
    };
    Fragment::new()
        .params("glass_params", &usual())
        .float_texture("candidates", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW, candidates)
        .input("survey", survey)
        .changed("found", &[found])
        .texture_output("left", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW)
        .changed("scan_panes", &[Pane::default(); 4])
        .changed("scores", &[1_u32; 512])
        .changed("glass_counters", &counters)
        .changed("scan_ends", &[Vec4::NAN; 4])
        .run(ACCEPT, Invocations::line(1))
}

fn found_panes(out: &Outputs) -> u32 {
    out.words("found")[1]
}

#[test]
fn truth_boundaries_go_over_frames_and_end_at_walls() {
    if skipped() {
        return;
    }
    // Glass at u = 60..=66 and v = 30..=34; beyond a frame of two squares a view through at u = 69..=72; wall around.
    let squares = |u: usize, v: usize| match (u, v) {
        (60..=66, 30..=34) => SHOWN,
        (69..=72, 30..=34) => BEYOND,
        (_, 20..=45) => BRIGHT,
        _ => [0; 5],
    };
    let on = [4.0, 0.3, 0.0, 20.0];
    let off = [2.0, 1.0, 0.4, 20.0];
    let behind = [8.0, 0.0, 0.0, 20.0];
    let list: Vec<[f32; 4]> = (0..130).map(|k| [on, off, behind][k % 3]).collect();
    let out = accept(&survey(squares), &list, 0.0);
    assert_eq!(found_panes(&out), 1);
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[..16]));
    let metres = |square: usize, middle: f32| (square as f32 - middle) * 0.25;
    let want = Vec4::new(metres(60, 64.0), metres(73, 64.0), metres(30, 32.0), metres(35, 32.0));
    assert_eq!(pane.extent_m, want);
    assert_eq!((pane.normal, pane.level), (Vec4::new(1.0, 0.0, 0.0, 4.0), Vec4::new(0.0, 1.0, 0.0, 30.0)));
    let left = list.iter().filter(|c| **c == off).count();
    assert_eq!(out.words("found")[0] as usize, left);
    assert!(out.floats("left")[..4 * left].chunks(4).all(|c| c == off));
    assert!(out.words("scores").iter().all(|&score| score == 0));
    // A wall of a metre ends it.
    let wall = |u: usize, v: usize| if (67..=70).contains(&u) { BRIGHT } else { squares(u, v) };
    let out = accept(&survey(wall), &list, 0.0);
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[..16]));
    assert_eq!((found_panes(&out), pane.extent_m.y), (1, metres(67, 64.0)));
    // The controls: nothing goes on behind it, or it lies.
    let blind = |u: usize, v: usize| match squares(u, v) {
        SHOWN => [0, 0, 0, 0, 4],
        BEYOND => BRIGHT,
        other => other,
    };
    assert_eq!(found_panes(&accept(&survey(blind), &list, 0.0)), 0);
    assert_eq!(found_panes(&accept(&survey(squares), &list, 1.0)), 0, "a floor");
    // Glass that shows on less than a tenth of the beams is no pane.
    let thin = |u: usize, v: usize| if squares(u, v) == SHOWN { [4, 0, 60, 0, 0] } else { squares(u, v) };
    let out = accept(&survey(thin), &list, 0.0);
    assert_eq!((found_panes(&out), out.words("glass_counters")[6]), (0, 1));
}

/// Extent of the first pane, and what it shows of its ends.
fn first_pane(out: &Outputs) -> (Vec4, Vec4) {
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[..16]));
    (pane.extent_m, bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_ends")[..4])))
}

#[test]
fn truth_a_pane_ends_where_beams_go_on_that_glass_would_return() {
    if skipped() {
        return;
    }
    let list = [[4.0, 0.3, 0.0, 20.0]; 50];
    // Glass from u = 56 to 65, an open way from 66 to 80. Glass shows to 1.15 m from the foot, u = 64 and v = 32.
    let beside_a_way = |u: usize, v: usize| match (u, v) {
        (56..=65, 30..=34) => SHOWN,
        (66..=80, 30..=34) => BEYOND,
        (_, 20..=45) => BRIGHT,
        _ => [0; 5],
    };
    let metres = |square: usize| (square as f32 - 64.0) * 0.25;
    let (extent_m, ends) = first_pane(&accept(&survey(beside_a_way), &list, 0.0));
    assert_eq!((extent_m.x, extent_m.y), (metres(56), metres(66)));
    assert_eq!(ends, Vec4::new(metres(56), metres(66), 0.0, 1.0));
    // The control: seen aslant, glass need not show itself, so the pane goes on.
    let aslant = |u: usize, v: usize| {
        if u < 70 && (30..=34).contains(&v) && u > 55 { SHOWN } else { beside_a_way(u, v) }
    };
    let (extent_m, ends) = first_pane(&accept(&survey(aslant), &list, 0.0));
    assert_eq!((extent_m.y, ends.w), (metres(81), 0.0));
    // An open door: the part that shows more is the pane.
    let door = |u: usize, v: usize| match (u, v) {
        (64..=66, 30..=34) => BEYOND,
        (56..=70, 30..=34) => SHOWN,
        _ => beside_a_way(u, v),
    };
    let (extent_m, ends) = first_pane(&accept(&survey(door), &list, 0.0));
    assert_eq!((extent_m.x, extent_m.y), (metres(56), metres(64)));
    assert_eq!((ends.y, ends.w), (metres(64), 1.0));
}

#[test]
fn truth_a_view_through_is_a_pane_no_farther_than_a_sheet_is_wide() {
    if skipped() {
        return;
    }
    let list = [[4.0, 0.3, 0.0, 20.0]; 50];
    let metres = |square: usize| (square as f32 - 64.0) * 0.25;
    // Glass as far as it shows from the foot, u = 64; beyond, 4 m of a view through to a wall.
    let beside = |u: usize, v: usize| match (u, v) {
        (60..=70, 30..=34) => SHOWN,
        (71..=86, 30..=34) => BEYOND,
        (_, 20..=45) => BRIGHT,
        _ => [0; 5],
    };
    let end =
        |counts: &dyn Fn(usize, usize) -> [u32; 5]| first_pane(&accept(&survey(counts), &list, 0.0)).0.y;
    assert_eq!(end(&beside), metres(71));
    // With a post in it, narrower than a square, it goes on to the wall.
    let post =
        |u: usize, v: usize| if u == 80 && (30..=34).contains(&v) { [0, 0, 1, 5, 0] } else { beside(u, v) };
    assert_eq!(end(&post), metres(87));
    // So it does where the wall is nearer.
    let near = |u: usize, v: usize| if u > 80 && (20..=45).contains(&v) { BRIGHT } else { beside(u, v) };
    assert_eq!(end(&near), metres(81));
}

#[test]
fn truth_what_stops_beams_among_dual_returns_is_no_pane_however_dim() {
    if skipped() {
        return;
    }
    let list = [[4.0, 0.3, 0.0, 20.0]; 50];
    let squares = survey(|u, v| match (u, v) {
        (60..=66, 30..=34) => SHOWN,
        (67..=72, 30..=34) => [0, 9, 0, 0, 0],
        (_, 20..=45) => BRIGHT,
        _ => [0; 5],
    });
    let end = |dual: u32| first_pane(&accept_in(&squares, &list, 0.0, dual)).0.y;
    let metres = |square: usize| (square as f32 - 64.0) * 0.25;
    assert_eq!([end(0), end(500)], [metres(73), metres(67)]);
}

#[test]
fn truth_what_lets_beams_through_head_on_is_no_glass() {
    if skipped() {
        return;
    }
    let list = [[4.0, 0.3, 0.0, 20.0]; 50];
    let strings = [4, 0, 0, 1, 0];
    let panes = |from: usize, kind: [u32; 5], dual: u32| {
        let squares = survey(|u, v| match (u, v) {
            (60..=68, 30..=34) if u.abs_diff(64) >= from => kind,
            (60..=68, 30..=34) => SHOWN,
            (69..=72, 30..=34) => BEYOND,
            (_, 20..=45) => BRIGHT,
            _ => [0; 5],
        });
        found_panes(&accept_in(&squares, &list, 0.0, dual))
    };
    assert_eq!(panes(0, SHOWN, 500), 1);
    assert_eq!(panes(0, strings, 500), 0);
    // Away from head on glass lets beams through too, and so it does of a sensor that gives the stronger return alone.
    assert_eq!(panes(4, strings, 500), 1);
    assert_eq!(panes(0, strings, 0), 1);
}

#[test]
fn truth_edges_away_from_the_foot_and_peaks_alone_among_dual_returns_are_no_pane() {
    if skipped() {
        return;
    }
    let list = [[4.0, 0.3, 0.0, 20.0]; 50];
    let at = |first: usize, kind: [u32; 5]| {
        survey(move |u, v| match (u, v) {
            (u, 30..=34) if (first..first + 7).contains(&u) => kind,
            (_, 20..=45) => BEYOND,
            _ => [0; 5],
        })
    };
    let shining = [0, 0, 0, 0, 4];
    for (first, kind, dual, panes) in [
        (60, SHOWN, 0, 1),
        (90, SHOWN, 0, 0),
        (60, SHOWN, 500, 1),
        (60, shining, 0, 1),
        (60, shining, 500, 0),
    ] {
        let out = accept_in(&at(first, kind), &list, 0.0, dual);
        assert_eq!(found_panes(&out), panes, "{kind:?} from {first} among {dual} dual returns");
    }
}

/// `kept` and `panes` after one scan that shows `fresh`.
fn remember(kept: &Pane, fresh: &Pane, pose: Rigid) -> (Vec<Pane>, Vec<Pane>) {
    let shown = fresh.extent_m;
    let (panes, now, _) = remember_ends(kept, Vec4::ZERO, fresh, Vec4::new(shown.x, shown.y, 0.0, 0.0), pose);
    (panes, now)
}

/// As [`remember`], with what is known of the ends of the kept pane and seen of those of the fresh one; and what is known after.
fn remember_ends(
    kept: &Pane,
    kept_ends: Vec4,
    fresh: &Pane,
    ends: Vec4,
    pose: Rigid,
) -> (Vec<Pane>, Vec<Pane>, Vec4) {
    let mut known = [Vec4::ZERO; 16];
    known[0] = kept_ends;
    let mut list = [Pane::default(); 16];
    list[0] = *kept;
    let header = |count: u32, panes: &[Pane]| {
        let words: &[u32] = cast_slice(panes);
        [&[count, 0, 0, 0], words].concat()
    };
    let mut scan = [Pane::default(); 4];
    scan[0] = *fresh;
    let out = Fragment::new()
        .params("glass_params", &params(grid(), &Config::default(), pose))
        .input("scan_panes", &scan)
        .input("found", &[Found { panes: 1, ..Found::default() }])
        .input("loaded_panes", &[Pane::default(); 16])
        .changed("kept", &header(kept.id, &list))
        .changed("pane_counts", &[0_u32; 128])
        .output("panes", 4 + 16 * 16)
        .changed("met_points", &[9_u32; 2])
        .input("scan_ends", &[ends; 4])
        .changed("kept_ends", &known)
        .texture_output("pane_texels", 4, 16)
        .run(REMEMBER, Invocations::line(1));
    assert_eq!(out.words("met_points")[0], 0);
    // The texels are the panes, with numbers as floats.
    for (slot, (texels, pane)) in
        out.floats("pane_texels").chunks(16).zip(out.words("panes")[4..].chunks(16)).enumerate()
    {
        assert!(
            texels[..12].iter().map(|value| value.to_bits()).eq(pane[..12].iter().copied()),
            "slot {slot}"
        );
        let numbers = [pane[12], pane[13], out.words("panes")[0], 0].map(|number| number as f32);
        assert_eq!(texels[12..], numbers, "slot {slot}");
    }
    let read = |name: &str| {
        let panes = out.words(name)[4..].chunks(16);
        panes.map(|words| bytemuck::pod_read_unaligned::<Pane>(cast_slice(words))).collect()
    };
    (read("kept"), read("panes"), bytemuck::pod_read_unaligned(cast_slice(&out.words("kept_ends")[..4])))
}

#[test]
fn twin_of_the_memory_of_panes() {
    if skipped() {
        return;
    }
    let pane = |degrees: f32, distance_m: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Pane {
            normal: Vec4::new(cos, sin, 0.0, distance_m),
            level: Vec4::new(-sin, cos, 0.0, 30.0),
            extent_m: Vec4::new(-1.5, 2.0, -1.0, 1.5),
            id: 1,
            hits: 3,
            misses: 0,
            age: 5,
        }
    };
    let pose =
        Rigid { rotation: glam::DQuat::from_rotation_z(0.7), translation_m: DVec3::new(0.4, -0.8, 0.2) };
    let to_lidar = pose.inverse();
    for (degrees, distance_m, same) in
        [(0.0, 4.0, true), (3.0, 4.1, true), (-5.0, 3.8, true), (12.0, 4.0, false), (0.0, 4.5, false)]
    {
        let (kept, fresh) = (pane(0.0, 4.0), pane(degrees, distance_m));
        let seen = fresh.moved(to_lidar);
        let (after, now) = remember(&kept, &seen, pose);
        let count = after.iter().filter(|pane| pane.id != 0).count();
        assert_eq!(count, if same { 1 } else { 2 }, "{degrees} degrees, {distance_m} m");
        assert_eq!(now[0].id, 1);
        if same {
            let (normal, on_plane_m) = refined(&kept, &fresh);
            let got = after[0].unit_normal().as_dvec3();
            assert!(got.dot(normal) > 1.0 - 1e-7, "{got} {normal}");
            assert!((got.dot(on_plane_m) - f64::from(after[0].normal.w)).abs() < 1e-4);
            assert_eq!((after[0].hits, after[0].misses, after[0].age), (4, 0, 6));
            // The scan's own plane fits it best.
            assert!((now[0].normal - seen.normal).abs().max_element() < 1e-4, "{:?} {seen:?}", now[0]);
        } else {
            assert_eq!((after[1].id, after[1].hits, after[1].age), (2, 1, 1));
            assert_eq!((after[0].hits, after[0].normal), (3, kept.normal));
        }
    }
}

#[test]
fn twin_of_ends_at_open_air_over_scans() {
    if skipped() {
        return;
    }
    let pane = |from_m: f32, to_m: f32| Pane {
        normal: Vec4::new(1.0, 0.0, 0.0, 4.0),
        level: Vec4::new(0.0, 1.0, 0.0, 30.0),
        extent_m: Vec4::new(from_m, to_m, -1.0, 1.5),
        id: 1,
        hits: 3,
        misses: 0,
        age: 5,
    };
    let kept = pane(-3.0, 3.0);
    let air = 1.0;
    for (known, seen, shown, ends, same) in [
        // The third scan in which it ends at open air proves it; the second does not.
        (Vec4::new(0.0, 1.0, 0.0, 2.0), [-2.0, 1.0], [-2.0, 1.0], [0.0, air], true),
        (Vec4::new(0.0, 1.0, 0.0, 1.0), [-2.0, 1.0], [-2.0, 1.0], [0.0, air], true),
        // From afar it seems to go on; what is proven holds.
        (Vec4::new(-2.0, 1.0, 3.0, 3.0), [-4.0, 4.0], [-2.0, 1.0], [0.0, 0.0], true),
        // Glass that shows beyond takes an end back.
        (Vec4::new(-2.0, 1.0, 3.0, 3.0), [-4.0, 4.0], [-2.0, 2.5], [0.0, 0.0], true),
        // What shows beyond alone is another pane, as behind an open door.
        (Vec4::new(-2.0, 1.0, 3.0, 3.0), [1.8, 4.0], [1.9, 3.8], [0.0, 0.0], false),
    ] {
        let fresh = pane(seen[0], seen[1]);
        let given = Vec4::new(shown[0], shown[1], ends[0], ends[1]);
        let (after, _, got) = remember_ends(&kept, known, &fresh, given, Rigid::IDENTITY);
        let want = ended(known.to_array(), [-3.0, 3.0], seen, given.to_array());
        assert_eq!(want.is_some(), same, "{known} {given}");
        assert_eq!(after[1].id, if same { 0 } else { 2 }, "{known} {given}");
        let (want_known, want_extent) = want.unwrap_or((known.to_array(), [-3.0, 3.0]));
        assert!((got - Vec4::from(want_known)).abs().max_element() < 1e-4, "{got} {want_known:?}");
        let extent = after[0].extent_m;
        assert!(
            (extent.x - want_extent[0]).abs() + (extent.y - want_extent[1]).abs() < 1e-4,
            "{extent} {want_extent:?}"
        );
    }
}
