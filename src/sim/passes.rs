//! The passes of a simulated frame and their parameters.

use glam::Vec4;

use crate::gpu::ShaderSource;

/// Intersections and the scene's layout, for passes and their tests.
pub const SCENE_LIBRARY: &str = include_str!("../../shaders/lib/sim/scene.wgsl");
/// The solids out of the scene's tables.
pub const SOLIDS_LIBRARY: &str = include_str!("../../shaders/lib/sim/solids.wgsl");
/// Hashes and noise.
pub const RANDOM_LIBRARY: &str = include_str!("../../shaders/lib/sim/random.wgsl");
/// Fresnel's share, patterns, lamps, speckle.
pub const SHADE_LIBRARY: &str = include_str!("../../shaders/lib/sim/shade.wgsl");

/// Thickets and curtains.
pub const THIN_LIBRARY: &str = include_str!("../../shaders/lib/sim/thin.wgsl");

/// The thin things out of the scene's tables.
pub const NEAREST_THIN_LIBRARY: &str = include_str!("../../shaders/lib/sim/nearest_thin.wgsl");

/// Sunlight.
pub const SUN_LIBRARY: &str = include_str!("../../shaders/lib/sim/sun.wgsl");

/// Rays through the scene.
pub const TRACE: ShaderSource = ShaderSource {
    name: "sim/trace",
    parts: &[
        SCENE_LIBRARY,
        SOLIDS_LIBRARY,
        RANDOM_LIBRARY,
        SHADE_LIBRARY,
        THIN_LIBRARY,
        NEAREST_THIN_LIBRARY,
        SUN_LIBRARY,
        include_str!("../../shaders/sim/trace.wgsl"),
    ],
};

/// Sub-rays of a lidar's beams.
pub const BEAM: ShaderSource = ShaderSource {
    name: "sim/beam",
    parts: &[
        SCENE_LIBRARY,
        SOLIDS_LIBRARY,
        RANDOM_LIBRARY,
        SHADE_LIBRARY,
        THIN_LIBRARY,
        NEAREST_THIN_LIBRARY,
        include_str!("../../shaders/sim/beam.wgsl"),
    ],
};

/// Echoes of a lidar's beams.
pub const ECHO: ShaderSource =
    ShaderSource { name: "sim/echo", parts: &[RANDOM_LIBRARY, include_str!("../../shaders/sim/echo.wgsl")] };

/// Auto exposure.
pub const METER: ShaderSource =
    ShaderSource { name: "sim/meter", parts: &[include_str!("../../shaders/sim/meter.wgsl")] };

/// Infrared images.
pub const EXPOSE: ShaderSource = ShaderSource {
    name: "sim/expose",
    parts: &[RANDOM_LIBRARY, include_str!("../../shaders/sim/expose.wgsl")],
};

/// Colour image.
pub const TONE: ShaderSource =
    ShaderSource { name: "sim/tone", parts: &[RANDOM_LIBRARY, include_str!("../../shaders/sim/tone.wgsl")] };

/// Census signatures.
pub const CENSUS: ShaderSource =
    ShaderSource { name: "sim/census", parts: &[include_str!("../../shaders/sim/census.wgsl")] };

/// Matching costs.
pub const COST: ShaderSource =
    ShaderSource { name: "sim/cost", parts: &[include_str!("../../shaders/sim/cost.wgsl")] };

/// Best disparities.
pub const WINNER: ShaderSource =
    ShaderSource { name: "sim/winner", parts: &[include_str!("../../shaders/sim/winner.wgsl")] };

/// Depth with its checks.
pub const DEPTH: ShaderSource =
    ShaderSource { name: "sim/depth", parts: &[include_str!("../../shaders/sim/depth.wgsl")] };

/// All of them.
pub const ALL: [ShaderSource; 10] = [TRACE, METER, EXPOSE, TONE, CENSUS, COST, WINNER, DEPTH, BEAM, ECHO];

crate::params! {
    /// Parameters of `sim/trace`.
    pub struct SimTraceParams {
        /// Camera in the map; w: half the projector's field as x/z.
        pub origin: Vec4,
        /// The optical frame's x in the map; w: focal length.
        pub right: Vec4,
        /// y; w: principal point x.
        pub down: Vec4,
        /// z; w: principal point y.
        pub forward: Vec4,
        /// Projector in the map; w: its strength.
        pub projector: Vec4,
        /// Dot size as x/z, contrast.
        pub speckle: Vec4,
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Of the projector's pattern.
        pub speckle_seed: u32,
        /// Of this frame and camera.
        pub frame_seed: u32,
    }
}

crate::params! {
    /// Parameters of `sim/meter`.
    pub struct SimMeterParams {
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Pixels between samples.
        pub step: u32,
        /// Share of full scale.
        pub wanted_mean: f32,
        /// Full scale over radiance.
        pub largest_gain: f32,
        /// Factor on the gain.
        pub bias: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

crate::params! {
    /// Parameters of `sim/expose`.
    pub struct SimExposeParams {
        /// Words of four pixels.
        pub words: u32,
        /// Of this frame and camera.
        pub seed: u32,
        /// At full scale.
        pub electrons: f32,
        /// Share of full scale.
        pub read_noise: f32,
        /// Gain by exposure alone.
        pub full_gain: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

crate::params! {
    /// Parameters of `sim/tone`.
    pub struct SimToneParams {
        /// Pixels of the image.
        pub pixels: u32,
        /// Of this frame.
        pub seed: u32,
        /// At full scale.
        pub electrons: f32,
        /// Unused.
        pub pad0: u32,
    }
}

crate::params! {
    /// Parameters of `sim/census`.
    pub struct SimCensusParams {
        /// Words of four pixels a row.
        pub words: u32,
        /// Pixels.
        pub height: u32,
    }
}

crate::params! {
    /// Parameters of `sim/cost`.
    pub struct SimCostParams {
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Words of two disparities.
        pub disparity_words: u32,
    }
}

crate::params! {
    /// Parameters of `sim/winner`.
    pub struct SimWinnerParams {
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Words of two disparities.
        pub disparity_words: u32,
        /// Share.
        pub uniqueness: f32,
        /// Differing bits in 5x5.
        pub largest_cost: f32,
    }
}

crate::params! {
    /// Parameters of `sim/depth`.
    pub struct SimDepthParams {
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Pixels times millimetres.
        pub focal_baseline_mm: f32,
        /// Pixels.
        pub left_right_px: f32,
        /// Levels of 255.
        pub texture: f32,
        /// Pixels.
        pub step_px: f32,
        /// Pixels.
        pub largest_px: f32,
        /// Unused.
        pub pad0: u32,
    }
}

crate::params! {
    /// Parameters of `sim/beam`.
    pub struct SimBeamParams {
        /// Beams of a column.
        pub rows: u32,
        /// Of this dispatch.
        pub first_beam: u32,
        /// Of this dispatch.
        pub beams: u32,
        /// Of a beam.
        pub subrays: u32,
        /// Of the pattern of sub-rays, radians.
        pub turn: f32,
        /// Metres.
        pub largest_range_m: f32,
        /// Half the divergence across the vertical, radians.
        pub spread_level_rad: f32,
        /// Half the divergence along the vertical, radians.
        pub spread_upright_rad: f32,
        /// Share of a white wall's power at 1 m.
        pub faintest: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

crate::params! {
    /// Parameters of `sim/echo`.
    pub struct SimEchoParams {
        /// Of this dispatch.
        pub beams: u32,
        /// Of a beam.
        pub subrays: u32,
        /// 0 strongest, 1 last and strongest, 2 first and last.
        pub returns: u32,
        /// 1: intensity is reflectivity.
        pub calibrated: u32,
        /// Of this scan and dispatch.
        pub seed: u32,
        /// Share of a white wall's power at 1 m.
        pub threshold: f32,
        /// Metres between echoes.
        pub pulse_m: f32,
        /// Metres.
        pub range_noise_m: f32,
        /// Share.
        pub power_noise: f32,
        /// Intensity of 1.
        pub scale: f32,
        /// Intensity.
        pub largest: f32,
        /// Metres.
        pub nearest_m: f32,
        /// Metres.
        pub focus_m: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}
