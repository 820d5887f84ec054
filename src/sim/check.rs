//! What cannot be in a scene, each with its key.

use glam::DVec2;

use super::footprint::footprints;
use super::lidar::Lidar;
use super::material::{Kind, Material};
use super::pack;
use super::scene::{Lamp, Scene};
use super::settings::{Checks, bad};
use super::trajectory::poses;
use super::walker::Walker;
use super::walls::{is_inside, walls};
use crate::base::Result;

/// Largest coordinate and length, metres.
const LARGEST_M: f64 = 100.0;
/// Brightest light.
const BRIGHTEST: f64 = 1e4;
/// The spec's largest travel a frame.
const LARGEST_STEP_M: f64 = 0.04;

pub(super) fn scene(scene: &Scene) -> Result<()> {
    scene.camera.validate()?;
    scene.imager.validate()?;
    scene.matcher.validate()?;
    scene.lidar.iter().try_for_each(Lidar::validate)?;
    for (name, material) in &scene.materials {
        self::material(name, material)?;
    }
    rooms(scene)?;
    solids(scene)?;
    walkers(scene)?;
    vessels(scene)?;
    upright(scene)?;
    thin(scene)?;
    lights(scene)?;
    counts(scene)?;
    way(scene)?;
    free(scene)
}

fn material(name: &str, material: &Material) -> Result<()> {
    let section = format!("materials.{name}.");
    let checks = Checks { section: &section };
    let [r, g, b] = material.albedo;
    let [pr, pg, pb] = material.pattern_albedo;
    for (key, values) in [("albedo", [r, g, b]), ("pattern_albedo", [pr, pg, pb])] {
        for value in values {
            checks.within(&[(key, value, 0.0, 1.0)])?;
        }
    }
    checks.within(&[
        ("albedo_ir", material.albedo_ir, 0.0, 1.0),
        ("pattern_albedo_ir", material.pattern_albedo_ir, 0.0, 1.0),
        ("pattern_scale_m", material.pattern_scale_m, 1e-3, LARGEST_M),
        ("reflectance", material.reflectance, 0.0, 1.0),
        ("roughness", material.roughness, 0.0, 1.0),
        ("transmission", material.transmission, 0.0, 1.0),
        ("refractive_index", material.refractive_index, 1.0, 3.0),
        ("bump", material.bump, 0.0, 2.0),
        ("bump_scale_m", material.bump_scale_m, 1e-3, LARGEST_M),
    ])?;
    let shines = matches!(material.kind, Kind::Glossy | Kind::Glass | Kind::Mirror | Kind::Metal);
    if material.reflectance > 0.0 && !shines {
        let reason = format!("a {:?} surface reflects no images; use glossy, metal or mirror", material.kind);
        return Err(bad(format!("{section}reflectance"), reason));
    }
    if (material.transmission > 0.0) != (material.kind == Kind::Glass) {
        let reason = "glass transmits (more than 0), and nothing else does";
        return Err(bad(format!("{section}transmission"), reason));
    }
    if material.refractive_index > 1.0 && material.kind != Kind::Glass {
        return Err(bad(format!("{section}refractive_index"), "only glass bends light"));
    }
    Ok(())
}

fn known(scene: &Scene, key: String, name: &str) -> Result<()> {
    if scene.materials.contains_key(name) {
        return Ok(());
    }
    let nearest = scene
        .materials
        .keys()
        .max_by(|a, b| strsim::jaro_winkler(name, a).total_cmp(&strsim::jaro_winkler(name, b)));
    let nearest = nearest.map_or("there are none".into(), |near| format!("the nearest is `{near}`"));
    Err(bad(key, format!("`materials` has no `{name}`; {nearest}")))
}

fn opaque(scene: &Scene, key: String, name: &str) -> Result<()> {
    known(scene, key.clone(), name)?;
    if scene.materials.get(name).is_some_and(|material| material.transmission > 0.0) {
        return Err(bad(key, format!("`{name}` is glass, which only panes, boxes and vessels can be")));
    }
    Ok(())
}

/// A point's coordinates.
fn place(key: &str, values: &[f64]) -> Result<()> {
    let checks = Checks { section: "" };
    values.iter().try_for_each(|&value| checks.within(&[(key, value, -LARGEST_M, LARGEST_M)]))
}

/// Lengths, of which none may be 0.
fn lengths(key: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|&&value| !(value > 0.0 && value <= LARGEST_M)) {
        Some(value) => Err(bad(key, format!("{value} is not a length above 0 and up to {LARGEST_M} m"))),
        None => Ok(()),
    }
}

fn rooms(scene: &Scene) -> Result<()> {
    lengths("ceiling_m", &[scene.ceiling_m])?;
    opaque(scene, "floor".into(), &scene.floor)?;
    opaque(scene, "ceiling".into(), &scene.ceiling)?;
    if scene.rooms.is_empty() {
        return Err(bad("rooms", "there is none"));
    }
    for (index, room) in scene.rooms.iter().enumerate() {
        let key = |field: &str| format!("rooms[{index}].{field}");
        place(&key("min_m"), &room.min_m)?;
        place(&key("max_m"), &room.max_m)?;
        if (0..2).any(|axis| room.max_m[axis] <= room.min_m[axis]) {
            return Err(bad(key("max_m"), format!("{:?} is not beyond min_m {:?}", room.max_m, room.min_m)));
        }
        opaque(scene, key("walls"), &room.walls)?;
    }
    Ok(())
}

fn solids(scene: &Scene) -> Result<()> {
    for (index, block) in scene.boxes.iter().enumerate() {
        let key = |field: &str| format!("boxes[{index}].{field}");
        place(&key("center_m"), &block.center_m)?;
        place(&key("yaw_rad"), &[block.yaw_rad])?;
        lengths(&key("size_m"), &block.size_m)?;
        known(scene, key("material"), &block.material)?;
    }
    for (index, cylinder) in scene.cylinders.iter().enumerate() {
        let key = |field: &str| format!("cylinders[{index}].{field}");
        place(&key("base_m"), &cylinder.base_m)?;
        lengths(&key("radius_m"), &[cylinder.radius_m])?;
        lengths(&key("height_m"), &[cylinder.height_m])?;
        opaque(scene, key("material"), &cylinder.material)?;
    }
    Ok(())
}

fn vessels(scene: &Scene) -> Result<()> {
    for (index, vessel) in scene.vessels.iter().enumerate() {
        let section = format!("vessels[{index}].");
        let key = |field: &str| format!("{section}{field}");
        place(&key("base_m"), &vessel.base_m)?;
        known(scene, key("material"), &vessel.material)?;
        if let Some(contents) = &vessel.contents {
            known(scene, key("contents"), contents)?;
        }
        vessel.check(scene, &section)?;
    }
    Ok(())
}

fn walkers(scene: &Scene) -> Result<()> {
    for (index, walker) in scene.walkers.iter().enumerate() {
        let section = format!("walkers[{index}].");
        let key = |field: &str| format!("{section}{field}");
        let Walker { waypoints_m, speed_m_s, ahead_s, radius_m, height_m, material } = walker;
        if waypoints_m.is_empty() {
            return Err(bad(key("waypoints_m"), "there is none"));
        }
        for point in waypoints_m {
            place(&key("waypoints_m"), point)?;
        }
        Checks { section: &section }
            .within(&[("speed_m_s", *speed_m_s, 0.0, 20.0), ("ahead_s", *ahead_s, 0.0, 1e6)])?;
        lengths(&key("radius_m"), &[*radius_m])?;
        lengths(&key("height_m"), &[*height_m])?;
        opaque(scene, key("material"), material)?;
    }
    Ok(())
}

fn upright(scene: &Scene) -> Result<()> {
    for (index, pane) in scene.panes.iter().enumerate() {
        let key = |field: &str| format!("panes[{index}].{field}");
        place(&key("center_m"), &pane.center_m)?;
        place(&key("yaw_rad"), &[pane.yaw_rad])?;
        lengths(&key("width_m"), &[pane.width_m])?;
        lengths(&key("height_m"), &[pane.height_m])?;
        known(scene, key("material"), &pane.material)?;
    }
    for (index, window) in scene.windows.iter().enumerate() {
        let key = |field: &str| format!("windows[{index}].{field}");
        place(&key("center_m"), &window.center_m)?;
        place(&key("yaw_rad"), &[window.yaw_rad])?;
        lengths(&key("width_m"), &[window.width_m])?;
        lengths(&key("height_m"), &[window.height_m])?;
        light(&key(""), window.color, window.infrared)?;
    }
    Ok(())
}

fn thin(scene: &Scene) -> Result<()> {
    for (index, curtain) in scene.curtains.iter().enumerate() {
        let key = |field: &str| format!("curtains[{index}].{field}");
        place(&key("center_m"), &curtain.center_m)?;
        place(&key("yaw_rad"), &[curtain.yaw_rad])?;
        for (field, length_m) in [
            ("width_m", curtain.width_m),
            ("height_m", curtain.height_m),
            ("spacing_m", curtain.spacing_m),
            ("string_width_m", curtain.string_width_m),
        ] {
            lengths(&key(field), &[length_m])?;
        }
        opaque(scene, key("material"), &curtain.material)?;
    }
    for (index, thicket) in scene.thickets.iter().enumerate() {
        let section = format!("thickets[{index}].");
        let key = |field: &str| format!("{section}{field}");
        place(&key("center_m"), &thicket.center_m)?;
        place(&key("yaw_rad"), &[thicket.yaw_rad])?;
        lengths(&key("size_m"), &thicket.size_m)?;
        Checks { section: &section }.within(&[
            ("density_per_m3", thicket.density_per_m3, 0.0, 1e9),
            ("element_width_m", thicket.element_width_m, 1e-4, 1.0),
            ("element_length_m", thicket.element_length_m, 1e-4, 10.0),
        ])?;
        opaque(scene, key("material"), &thicket.material)?;
    }
    Ok(())
}

fn lights(scene: &Scene) -> Result<()> {
    light("ambient.", scene.ambient.color, scene.ambient.infrared)?;
    if let Some(sun) = &scene.sun {
        let checks = Checks { section: "sun." };
        let upright = std::f64::consts::FRAC_PI_2;
        checks.within(&[
            ("yaw_rad", sun.yaw_rad, -LARGEST_M, LARGEST_M),
            ("elevation_rad", sun.elevation_rad, 0.01, upright),
        ])?;
        light("sun.", sun.color, sun.infrared)?;
    }
    for (index, Lamp { center_m, size_m, color, infrared }) in scene.lamps.iter().enumerate() {
        let key = |field: &str| format!("lamps[{index}].{field}");
        place(&key("center_m"), center_m)?;
        lengths(&key("size_m"), size_m)?;
        light(&key(""), *color, *infrared)?;
    }
    Ok(())
}

fn light(section: &str, color: [f64; 3], infrared: f64) -> Result<()> {
    let checks = Checks { section };
    color.iter().try_for_each(|&value| checks.within(&[("color", value, 0.0, BRIGHTEST)]))?;
    checks.within(&[("infrared", infrared, 0.0, BRIGHTEST)])
}

fn counts(scene: &Scene) -> Result<()> {
    let quads = walls(scene).len() + scene.panes.len() + scene.lamps.len() + scene.windows.len();
    let lamps = scene.lamps.len() + scene.windows.len();
    let frustums = scene.vessels.iter().map(|vessel| vessel.frustums(scene).len()).sum();
    for (key, count, most) in [
        ("materials", scene.materials.len() + lamps, pack::MATERIALS),
        ("panes", quads, pack::QUADS),
        ("boxes", scene.boxes.len(), pack::BOXES),
        ("cylinders", scene.cylinders.len() + scene.walkers.len(), pack::CYLINDERS),
        ("lamps", lamps, pack::LIGHTS),
        ("vessels", scene.vessels.len(), pack::VESSELS),
        ("vessels", frustums, pack::FRUSTUMS),
        ("curtains", scene.curtains.len(), pack::CURTAINS),
        ("thickets", scene.thickets.len(), pack::THICKETS),
    ] {
        if count > most {
            let reason = format!(
                "{count} are too many, {most} fit (lights count as materials and panes, walls as panes, people as cylinders, pieces of an outline as vessels)"
            );
            return Err(bad(key, reason));
        }
    }
    Ok(())
}

fn way(scene: &Scene) -> Result<()> {
    let way = &scene.trajectory;
    Checks { section: "trajectory." }.within(&[
        ("step_m", way.step_m, 1e-4, LARGEST_STEP_M),
        ("turn_rad", way.turn_rad, 1e-4, 1.0),
        ("rate_hz", way.rate_hz, 0.1, 1e3),
        ("clearance_m", way.clearance_m, 0.0, 5.0),
        ("yaw_rad", way.yaw_rad, -LARGEST_M, LARGEST_M),
    ])?;
    if way.waypoints_m.is_empty() {
        return Err(bad("trajectory.waypoints_m", "there is none"));
    }
    if !(1..=100_000).contains(&way.frames) {
        return Err(bad("trajectory.frames", format!("{} is not in 1..=100000", way.frames)));
    }
    for (index, point) in way.waypoints_m.iter().enumerate() {
        place(&format!("trajectory.waypoints_m[{index}]"), point)?;
    }
    Ok(())
}

/// The robot keeps its distance, and the camera is in free air.
fn free(scene: &Scene) -> Result<()> {
    let things: Vec<_> = footprints(scene).into_iter().filter(|thing| !thing.passable).collect();
    if scene.camera.height_m >= scene.ceiling_m {
        return Err(bad("camera.height_m", "is above the ceiling"));
    }
    for (frame, pose) in poses(scene).into_iter().enumerate() {
        let robot = pose.map_from_base.translation_m.truncate();
        let camera = pose.map_from_base.then(pose.base_from_camera).translation_m;
        let at = |p: DVec2| format!("at frame {frame}, ({:.2}, {:.2}) m,", p.x, p.y);
        if !is_inside(scene, robot.x, robot.y) {
            return Err(bad("trajectory.waypoints_m", format!("{} the robot is in no room", at(robot))));
        }
        if !is_inside(scene, camera.x, camera.y) {
            return Err(bad("camera.forward_m", format!("{} the camera is in no room", at(robot))));
        }
        for thing in &things {
            let overhead = thing.span_m[0] > 1.5;
            if !overhead && thing.shape.distance_m(robot) < scene.trajectory.clearance_m {
                let reason = format!("{} the robot is nearer than clearance_m to {}", at(robot), thing.key);
                return Err(bad("trajectory.waypoints_m", reason));
            }
            let level = (thing.span_m[0]..=thing.span_m[1]).contains(&camera.z);
            if level && thing.shape.distance_m(camera.truncate()) < 0.01 {
                return Err(bad("camera", format!("{} it is inside {}", at(robot), thing.key)));
            }
        }
    }
    Ok(())
}
