//! Materials of everyday things that stereo cameras see badly, and things with labels.

use super::layout::Layout;
use crate::sim::material::{Kind, Material, Pattern};

/// Adds foil, brushed steel, black gloss, and two coloured patterns: `label` and `goods`.
pub(super) fn materials(layout: &mut Layout<'_>) {
    let random = &mut *layout.random;
    let foil = Material {
        bump: random.within(0.1, 0.4),
        bump_scale_m: random.within(0.006, 0.025),
        roughness: random.within(0.01, 0.04),
        ..Material::foil()
    };
    let steel = Material {
        reflectance: random.within(0.5, 0.7),
        roughness: random.within(0.04, 0.15),
        ..Material::metal()
    };
    let tone = random.within(0.01, 0.04);
    let black = Material {
        kind: Kind::Glossy,
        albedo: [tone; 3],
        albedo_ir: tone * random.within(1.0, 3.0),
        reflectance: random.within(0.04, 0.08),
        ..Material::default()
    };
    let label = patches(layout, 0.012, 0.04);
    let goods = patches(layout, 0.03, 0.15);
    let all = [("foil", foil), ("steel", steel), ("black", black), ("label", label), ("goods", goods)];
    layout.scene.materials.extend(all.map(|(name, material)| (name.into(), material)));
}

/// Patches of any colour, at times under a clear coat.
fn patches(layout: &mut Layout<'_>, least_m: f64, most_m: f64) -> Material {
    let random = &mut *layout.random;
    let bright = random.within(0.5, 0.9);
    let dark = random.within(0.02, 0.2);
    let coated = random.chance(0.4);
    Material {
        kind: if coated { Kind::Glossy } else { Kind::Textured },
        albedo: [bright, bright * random.within(0.7, 1.0), bright * random.within(0.6, 1.0)],
        albedo_ir: random.within(0.5, 0.85),
        pattern: Pattern::Patches,
        pattern_albedo: [dark; 3],
        pattern_albedo_ir: random.within(0.15, 0.5),
        pattern_scale_m: random.within(least_m, most_m),
        reflectance: if coated { 0.05 } else { 0.0 },
        ..Material::default()
    }
}
