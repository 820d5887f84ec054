//! How long does DRM-Net take by itself? `cargo bench --bench net -- WEIGHTS [--serve] [--buffers] [--no-subgroups] [--passes]`
//!
//! One inference is: 1x5x240x320 floats in, all passes, 240x320 floats out, waited for. With `--serve`, a number n on standard
//! input asks for n inferences, and a line of JSON answers; `bench/peers/net.py` drives it so, in turns with its peers.

use std::io::BufRead;
use std::time::Instant;

use cpu_time::ProcessTime;
use limpid::gpu::Context;
use limpid::network::weights::{INPUT_CHANNELS, NATIVE_SIZE, Network};
use limpid::network::{Backend, Inference};
use limpid::{Error, Result};

const SAMPLES: usize = 60;

/// Milliseconds of `count` inferences one after another, and the processor time of each.
fn measure(inference: &mut Inference, input: &[f32], count: usize) -> Result<(Vec<f64>, Vec<f64>)> {
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let (start, start_cpu) = (Instant::now(), ProcessTime::now());
        inference.run(input)?;
        wall.push(start.elapsed().as_secs_f64() * 1e3);
        cpu.push(start_cpu.elapsed().as_secs_f64() * 1e3);
    }
    Ok((wall, cpu))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The least time of each pass.
fn print_passes(inference: &mut Inference, input: &[f32]) -> Result<()> {
    let mut least: Vec<(String, f64)> = Vec::new();
    for _ in 0..SAMPLES {
        inference.run(input)?;
        let now = inference.pass_ms().to_vec();
        least.resize_with(now.len(), || (String::new(), f64::MAX));
        least.iter_mut().zip(now).for_each(|(least, now)| *least = (now.0, least.1.min(now.1)));
    }
    least.iter().for_each(|(name, ms)| println!("{ms:8.3} ms  {name}"));
    println!("{:8.3} ms  in all", least.iter().map(|(_, ms)| ms).sum::<f64>());
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    let no_weights = Error::Input { what: "arguments".into(), reason: "want a weight file".into() };
    let path = arguments.iter().find(|argument| !argument.starts_with("--")).ok_or(no_weights)?;
    let network = Network::read(std::path::Path::new(path))?;
    let size = NATIVE_SIZE.map(|extent| u32::try_from(extent).unwrap_or(0));
    // Any numbers in [0, 1] will do: no kernel's time depends on them.
    let count = INPUT_CHANNELS * NATIVE_SIZE[0] * NATIVE_SIZE[1];
    let input: Vec<f32> = (0..count).map(|i| ((i * 7919) % 1009) as f32 / 1009.0).collect();
    let context = Context::open(None, has("--passes"))?;
    let best = Backend::of(&context);
    let backend = Backend {
        textures: best.textures && !has("--buffers"),
        subgroups: best.subgroups && !has("--no-subgroups"),
    };
    let start = Instant::now();
    let mut inference = Inference::build(network, size, false, backend, &context)?;
    let first = inference.run(&input)?;
    let first_ms = start.elapsed().as_secs_f64() * 1e3;
    if has("--passes") {
        return print_passes(&mut inference, &input);
    }
    if !has("--serve") {
        measure(&mut inference, &input, SAMPLES / 4)?;
        let (wall, cpu) = measure(&mut inference, &input, SAMPLES)?;
        println!("{}\n{backend:?}", inference.describe());
        println!("build and first inference {first_ms:.0} ms; then {SAMPLES} inferences:");
        let least = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
        println!("wall ms: min {:.2}, median {:.2}", least(&wall), median(wall.clone()));
        println!("cpu ms: min {:.2}, median {:.2}", least(&cpu), median(cpu.clone()));
        return Ok(());
    }
    let sampled: Vec<f32> = first.iter().flat_map(|o| o.values.iter().step_by(997).copied()).collect();
    println!("{{\"first_ms\": {first_ms:.1}, \"output\": {sampled:?}}}");
    for line in std::io::stdin().lock().lines().map_while(std::io::Result::ok) {
        let (wall, cpu) = measure(&mut inference, &input, line.trim().parse().unwrap_or(1))?;
        println!("{{\"wall_ms\": {wall:?}, \"cpu_ms\": {cpu:?}}}");
    }
    Ok(())
}
