//! What the product makes of a recording, as hashes of its bits. All use of limpid's API by the golden test is here.

use std::path::Path;

use limpid::Config;
use limpid::config::SensorKind;
use limpid::input::open_source;
use limpid::map::{Grid, Update};
use limpid::mapper::Options;
use limpid::run::run;

/// One product of one frame; those of later frames come later.
pub(super) struct Product {
    pub(super) name: &'static str,
    pub(super) hash: u64,
}

impl Product {
    pub(super) fn new(name: &'static str, parts: &[&[u8]]) -> Self {
        Self { name, hash: fnv1a(parts) }
    }
}

/// FNV-1a of 64 bits over all parts in turn.
pub(super) fn fnv1a(parts: &[&[u8]]) -> u64 {
    let bytes = parts.iter().copied().flatten();
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// What a camera's first `frames` depth images give with a configuration in YAML.
pub(super) fn camera_case(path: &Path, yaml: &str, frames: u64) -> Vec<Product> {
    let config = Config::from_yaml(yaml).unwrap();
    let options = Options { images: true, layers: true, verdicts: true, ..Options::default() };
    let config = config.only(SensorKind::Camera).unwrap();
    let mut source = open_source(path, &config).unwrap();
    let mut products = Vec::new();
    let mut add = |update: &Update| {
        let out = update.camera().unwrap();
        let (layers, images) = (out.layers.as_ref().unwrap(), out.images.as_ref().unwrap());
        let map = update.map.as_ref().unwrap();
        let c = out.counters;
        let counts = [c.pixels, c.valid, c.low_reliability, c.hits, c.hit_cells, c.seen_through_cells];
        let states = [c.occupied_cells, c.free_cells, out.degraded.into()];
        let grids = [&layers.evidence, &layers.occupancy, &layers.occupied];
        let color = images.color.as_deref().unwrap_or_default();
        products.extend([
            moment(update, &map.grid),
            pose(update),
            Product::new("costmap", &[&map.costmap]),
            Product::new("layers", &grids.map(|grid| bytemuck::cast_slice(grid))),
            Product::new("counters", &[bytemuck::cast_slice(&counts), bytemuck::cast_slice(&states)]),
            Product::new("depth", &[bytemuck::cast_slice(&images.depth_m)]),
            Product::new("reliability", &[bytemuck::cast_slice(&images.reliability)]),
            Product::new("color", &[color]),
        ]);
    };
    run(source.as_mut(), 0..frames, &config, &options, &mut [], &mut add).unwrap();
    products
}

/// What a lidar's first `scans` scans give with a configuration in YAML.
pub(super) fn lidar_case(path: &Path, yaml: &str, scans: u64) -> Vec<Product> {
    let config = Config::from_yaml(yaml).unwrap();
    let options = Options { layers: true, verdicts: true, ..Options::default() };
    let config = config.only(SensorKind::Lidar).unwrap();
    let mut source = open_source(path, &config).unwrap();
    let mut products = Vec::new();
    let mut add = |update: &Update| {
        let (out, map) = (update.lidar().unwrap(), update.map.as_ref().unwrap());
        let grids = &out.layers.as_ref().unwrap().grids;
        let grids: Vec<&[u8]> = grids.iter().map(|(_, values)| bytemuck::cast_slice(values)).collect();
        products.extend([
            moment(update, &map.grid),
            pose(update),
            Product::new("costmap", &[&map.costmap]),
            Product::new("classes", &[&map.classes]),
            Product::new("layers", &grids),
        ]);
        if let Some(glass) = &out.glass {
            let labels = glass.classes.iter().flat_map(|&(class, pane)| [class as u32, pane]);
            let labels: Vec<u32> = labels.collect();
            products.push(Product::new("labels", &[bytemuck::cast_slice(&labels)]));
            products.push(Product::new("panes", &[bytemuck::cast_slice(&glass.panes)]));
        }
    };
    run(source.as_mut(), 0..scans, &config, &options, &mut [], &mut add).unwrap();
    products
}

/// Number and stamp of a frame, and where its grids lie.
fn moment(update: &Update, grid: &Grid) -> Product {
    let numbers = [update.index, update.stamp_ns, grid.width.into(), grid.height.into()];
    let places = [grid.origin_x_m, grid.origin_y_m, grid.resolution_m];
    Product::new("moment", &[bytemuck::cast_slice(&numbers), bytemuck::cast_slice(&places)])
}

fn pose(update: &Update) -> Product {
    let numbers = [update.map_from_base, update.base_from_sensor]
        .map(|rigid| (rigid.translation_m.to_array(), rigid.rotation.to_array()));
    let [(a, b), (c, d)] = &numbers;
    let parts: [&[f64]; 4] = [a, b, c, d];
    Product::new("pose", &parts.map(bytemuck::cast_slice))
}

/// What the bits depend on beside the code: adapter with driver, and what its compiler takes of the CPU.
pub(super) fn machine() -> [String; 2] {
    let adapters = limpid::gpu::adapters(None).unwrap();
    let info = adapters.into_iter().find(|adapter| adapter.chosen.is_some()).unwrap().info;
    [format!("{} ({} {})", info.name, info.driver, info.driver_info), cpu_features()]
}

#[cfg(target_arch = "x86_64")]
fn cpu_features() -> String {
    let features = [
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
        ("fma", std::is_x86_feature_detected!("fma")),
    ];
    let found: Vec<_> = features.into_iter().filter(|(_, found)| *found).map(|(name, _)| name).collect();
    format!("x86_64 {}", found.join(" "))
}

#[cfg(not(target_arch = "x86_64"))]
fn cpu_features() -> String {
    std::env::consts::ARCH.into()
}
