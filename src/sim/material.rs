//! What surfaces of a simulated scene do with light, in colour and in the infrared.

use serde::{Deserialize, Serialize};

/// Kind of a surface; its number is what the truth's material image holds (0: nothing was met).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Matt, one colour: 1.
    Diffuse,
    /// Matt, with a pattern: 2.
    Textured,
    /// A matt base under a clear coat that reflects by Fresnel's law: 3.
    Glossy,
    /// Clear: it transmits and reflects: 4.
    Glass,
    /// Reflects nearly everything: 5.
    Mirror,
    /// Reflects much, blurred by its roughness, over a dark base: 6.
    Metal,
    /// A lamp's panel: 7. Lamps have it; materials cannot.
    #[serde(skip)]
    Lamp,
    /// A window that daylight comes through: 8. Windows have it; materials cannot.
    #[serde(skip)]
    Window,
}

impl Kind {
    /// The number in material images.
    pub fn code(self) -> u8 {
        match self {
            Self::Diffuse => 1,
            Self::Textured => 2,
            Self::Glossy => 3,
            Self::Glass => 4,
            Self::Mirror => 5,
            Self::Metal => 6,
            Self::Lamp => 7,
            Self::Window => 8,
        }
    }

    /// The kind of that number.
    pub fn of_code(code: u8) -> Option<Self> {
        use Kind::{Diffuse, Glass, Glossy, Lamp, Metal, Mirror, Textured, Window};
        [Diffuse, Textured, Glossy, Glass, Mirror, Metal, Lamp, Window].into_iter().find(|k| k.code() == code)
    }
}

/// Procedural patterns; `None` is one colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pattern {
    /// One colour.
    #[default]
    None,
    /// Squares of two colours.
    Checker,
    /// Tiles of slightly different tone with joints of the second colour.
    Tiles,
    /// Planks of different tone with grain.
    Planks,
    /// Smooth irregular patches.
    Clouds,
    /// Stripes of two colours.
    Stripes,
    /// Rectangles, each of a colour of its own between the two: labels, wrappings, books.
    Patches,
}

impl Pattern {
    /// The number that shaders know it by.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Checker => 1,
            Self::Tiles => 2,
            Self::Planks => 3,
            Self::Clouds => 4,
            Self::Stripes => 5,
            Self::Patches => 6,
        }
    }
}

/// A material of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// What it does with light.
    pub kind: Kind,
    /// Diffuse reflectance in red, green and blue (linear, 0 to 1).
    pub albedo: [f64; 3],
    /// Diffuse reflectance in the infrared, 0 to 1.
    pub albedo_ir: f64,
    /// Pattern between `albedo` and `pattern_albedo`.
    pub pattern: Pattern,
    /// The pattern's second colour.
    pub pattern_albedo: [f64; 3],
    /// The pattern's second reflectance in the infrared.
    pub pattern_albedo_ir: f64,
    /// Period of the pattern, metres.
    pub pattern_scale_m: f64,
    /// F0: mirror reflectance at normal incidence, 0 to 1 (Schlick's approximation; glass: of one face).
    pub reflectance: f64,
    /// Spread of the mirror direction: deviation of the surface's slopes.
    pub roughness: f64,
    /// Glass: share of what is not reflected that passes.
    pub transmission: f64,
    /// Glass: refractive index of a box or vessel of it; 1: a thin wall, which light passes straight.
    #[serde(skip_serializing_if = "is_thin")]
    pub refractive_index: f64,
    /// Deviation of the slopes of a crumpled surface, which its mirror images follow; 0: smooth.
    #[serde(skip_serializing_if = "is_smooth")]
    pub bump: f64,
    /// Size of the crumples, metres.
    #[serde(skip_serializing_if = "is_usual")]
    pub bump_scale_m: f64,
}

/// Size of crumples where none is stated, metres.
const BUMP_SCALE_M: f64 = 0.01;

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_thin(index: &f64) -> bool {
    *index == 1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_smooth(bump: &f64) -> bool {
    *bump == 0.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_usual(scale_m: &f64) -> bool {
    *scale_m == BUMP_SCALE_M
}

impl Default for Material {
    fn default() -> Self {
        Self {
            kind: Kind::Diffuse,
            albedo: [0.5; 3],
            albedo_ir: 0.5,
            pattern: Pattern::None,
            pattern_albedo: [0.3; 3],
            pattern_albedo_ir: 0.4,
            pattern_scale_m: 0.3,
            reflectance: 0.0,
            roughness: 0.0,
            transmission: 0.0,
            refractive_index: 1.0,
            bump: 0.0,
            bump_scale_m: BUMP_SCALE_M,
        }
    }
}

impl Material {
    /// Matt, one colour.
    pub fn diffuse(albedo: [f64; 3], albedo_ir: f64) -> Self {
        Self { albedo, albedo_ir, ..Self::default() }
    }

    /// A thin pane of window glass.
    pub fn glass() -> Self {
        Self {
            kind: Kind::Glass,
            albedo: [0.0; 3],
            albedo_ir: 0.0,
            reflectance: 0.04,
            transmission: 0.95,
            ..Self::default()
        }
    }

    /// Clear material that fills the body it is the surface of: solid glass, plastic, water.
    pub fn clear(refractive_index: f64) -> Self {
        Self { refractive_index, transmission: 1.0, ..Self::glass() }
    }

    /// Crumpled metal foil.
    pub fn foil() -> Self {
        Self { reflectance: 0.85, roughness: 0.02, bump: 0.25, bump_scale_m: 0.012, ..Self::metal() }
    }

    /// A mirror.
    pub fn mirror() -> Self {
        Self { kind: Kind::Mirror, albedo: [0.0; 3], albedo_ir: 0.0, reflectance: 0.95, ..Self::default() }
    }

    /// Brushed metal.
    pub fn metal() -> Self {
        Self {
            kind: Kind::Metal,
            albedo: [0.12; 3],
            albedo_ir: 0.15,
            reflectance: 0.6,
            roughness: 0.12,
            ..Self::default()
        }
    }
}
