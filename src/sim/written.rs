//! A scene's solids and thin things written out as shader code: a software driver reads a number in the code for nothing, and one out of a
//! table as dearly as it does ten operations.

use std::fmt::Write as _;

use glam::Vec4;

use super::pack::SimScene;
use super::passes::{NEAREST_THIN_LIBRARY, SOLIDS_LIBRARY};
use super::scene::Scene;
use crate::gpu::{Context, ShaderSource, ShaderText};

/// From so many rays on (twenty frames of 424x240 by two imagers) tracing saves more than it takes to compile a scene.
const WORTH_RAYS: u64 = 4_000_000;

/// Whether a scene's solids are to be written out for so many rays.
pub(crate) fn is_worth_it(scene: &Scene, context: &Context, rays: u64) -> bool {
    context.is_software() && scene.walkers.is_empty() && rays >= WORTH_RAYS
}

/// The text of a pass that follows rays, with the scene's numbers in it; without a scene it looks into the tables.
pub(crate) fn text(source: ShaderSource, scene: Option<&SimScene>) -> ShaderText {
    let table = ShaderText::from(source);
    let Some(scene) = scene else { return table };
    let (solids, thin) = (solids(scene), thin(scene));
    let part = |part: &&'static str| match *part {
        SOLIDS_LIBRARY => solids.clone(),
        NEAREST_THIN_LIBRARY => thin.clone(),
        other => other.to_string(),
    };
    ShaderText { text: source.parts.iter().map(part).collect::<Vec<_>>().join("\n"), ..table }
}

/// What `shaders/lib/sim/solids.wgsl` does, for one scene.
fn solids(scene: &SimScene) -> String {
    let (mut nearest, mut shadow) = (String::new(), String::new());
    for cluster in 0..scene.counts.y as usize {
        let [low, high] = [scene.cluster_low[cluster], scene.cluster_high[cluster]].map(three);
        let members = members(scene, cluster);
        let looked_at = |reach: &str, lines: Vec<String>| {
            let lines = lines.join("\n        ");
            format!(
                "    for (var k = u32(meets_bounds({low}, {high}, origin, inverse, {reach})); k > 0u; k--) {{\n        {lines}\n    }}\n"
            )
        };
        nearest += &looked_at("hit.t", members.iter().map(Member::nearest).collect());
        let casting: Vec<String> = members.iter().filter(|m| m.casts).map(Member::shadow).collect();
        if !casting.is_empty() {
            shadow += &looked_at("min(nearest, reach)", casting);
        }
    }
    let ray = "origin: vec3<f32>, direction: vec3<f32>, inverse: vec3<f32>";
    format!(
        "fn nearest_solid(before: Hit, {ray}) -> Hit {{\n    var hit = before;\n{nearest}    return hit;\n}}\n\n\
         fn nearest_shadow({ray}, reach: f32) -> f32 {{\n    var nearest = FAR;\n{shadow}    return nearest;\n}}\n"
    )
}

/// What `shaders/lib/sim/nearest_thin.wgsl` does, for one scene.
fn thin(scene: &SimScene) -> String {
    let mut code = String::from(
        "fn nearest_thin(before: Hit, origin: vec3<f32>, direction: vec3<f32>) -> Hit {\n    var hit = before;\n",
    );
    for i in 0..scene.counts.z as usize {
        let rows = [scene.curtain_plane[i], scene.curtain_u[i], scene.curtain_v[i], scene.curtain_look[i]];
        let curtain = format!("Curtain({})", rows.map(four).join(", "));
        let distance = format!("curtain_distance({curtain}, origin, direction)");
        let _ = writeln!(code, "    hit = nearer(hit, {distance}, CURTAIN_HIT | {i}u);");
    }
    for i in 0..scene.counts.w as usize {
        let rows = [scene.thicket_center[i], scene.thicket_half[i], scene.thicket_look[i]];
        let thicket = format!("Thicket({i}u, {})", rows.map(four).join(", "));
        let distance = format!("thicket_distance({thicket}, origin, direction, hit.t)");
        let _ = writeln!(code, "    hit = nearer(hit, {distance}, THICKET_HIT | {i}u);");
    }
    code + "    return hit;\n}\n"
}

/// A solid of a cluster as code.
struct Member {
    /// Its distance along the ray, or a vessel's range.
    code: String,
    /// Kind and index; empty for a vessel, which has many.
    id: String,
    casts: bool,
}

impl Member {
    fn nearest(&self) -> String {
        if self.id.is_empty() {
            return format!("hit = nearest_of_vessel(hit, {}, origin, direction);", self.code);
        }
        format!("hit = nearer(hit, {}, {});", self.code, self.id)
    }

    fn shadow(&self) -> String {
        if self.id.is_empty() {
            let vessel =
                format!("nearest_of_vessel(Hit(nearest, NOTHING), {}, origin, direction)", self.code);
            return format!("nearest = {vessel}.t;");
        }
        format!("nearest = min(nearest, {});", self.code)
    }
}

/// In the order in which the tables are gone through.
fn members(scene: &SimScene, cluster: usize) -> Vec<Member> {
    let range = scene.cluster_range[cluster];
    let mut members = Vec::new();
    for index in range.x & 255..(range.x >> 8) & 255 {
        let i = index as usize;
        let [plane, u, v] = [scene.quad_plane[i], scene.quad_u[i], scene.quad_v[i]].map(four);
        let code = format!("quad_distance({plane}, {u}, {v}, origin, direction)");
        members.push(Member { code, id: format!("QUAD_HIT | {index}u"), casts: index < range.x >> 16 });
    }
    for index in range.y & 255..(range.y >> 8) & 255 {
        let i = index as usize;
        let [center, half] = [scene.box_center[i], scene.box_half[i]].map(four);
        let clear = scene.box_material[i].y > 0;
        let code = format!("box_distance({center}, {half}, {clear}, origin, direction)");
        members.push(Member { code, id: format!("BOX_HIT | {index}u"), casts: index < range.y >> 16 });
    }
    for index in range.z & 255..range.z >> 8 {
        let i = index as usize;
        let [axis, span] = [scene.cylinder_axis[i], scene.cylinder_span[i]].map(four);
        let code = format!("cylinder_distance({axis}, {span}, origin, direction)");
        members.push(Member { code, id: format!("CYLINDER_HIT | {index}u"), casts: true });
    }
    if range.w > 0 {
        members.push(Member { code: format!("{}u", range.w), id: String::new(), casts: range.w >> 24 > 0 });
    }
    members
}

fn numbers(values: &[f32]) -> String {
    let mut text = String::new();
    for (index, value) in values.iter().enumerate() {
        let comma = if index > 0 { ", " } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{value:?}f");
    }
    text
}

fn three(v: Vec4) -> String {
    format!("vec3({})", numbers(&v.to_array()[..3]))
}

fn four(v: Vec4) -> String {
    format!("vec4({})", numbers(&v.to_array()))
}
