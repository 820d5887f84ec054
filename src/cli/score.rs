//! `limpid score`.

use std::path::PathBuf;

use clap::Args;
use limpid::config::SensorKind;
use limpid::input::open_source;
use limpid::mapper::Options;
use limpid::offline::score::{Score, Scorer};
use limpid::run::run_to;
use limpid::{Error, Result};

use super::Common;

#[derive(Debug, Args)]
pub(crate) struct ScoreArguments {
    /// Lidar recording
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Score on the plan map after this scan, counted from 0
    #[arg(long, default_value_t = 0)]
    scan: u64,
    /// Forward velocities: LOW,HIGH,COUNT in m/s
    #[arg(long, value_name = "LOW,HIGH,COUNT", default_value = "0.1,1.0,10", value_parser = parse_samples, allow_hyphen_values = true)]
    v: Samples,
    /// Turn rates: LOW,HIGH,COUNT in rad/s
    #[arg(long, value_name = "LOW,HIGH,COUNT", default_value = "-1.0,1.0,21", value_parser = parse_samples, allow_hyphen_values = true)]
    omega: Samples,
    /// How long each is held, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0)]
    horizon: f64,
    /// Print all candidates as JSON in place of the ten cheapest
    #[arg(long)]
    json: bool,
}

/// Values evenly from one end to the other.
#[derive(Debug, Clone)]
struct Samples(Vec<f64>);

fn parse_samples(text: &str) -> std::result::Result<Samples, String> {
    let wrong = || format!("`{text}` is not of the form LOW,HIGH,COUNT with COUNT from 1 to 1000");
    let mut parts = text.split(',');
    let mut number = || parts.next().and_then(|part| part.trim().parse::<f64>().ok());
    let (Some(low), Some(high), Some(count)) = (number(), number(), number()) else { return Err(wrong()) };
    if !(low.is_finite() && high.is_finite() && (1.0..=1000.0).contains(&count) && parts.next().is_none()) {
        return Err(wrong());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 1..=1000")]
    let count = count as u32;
    let share = |at: u32| f64::from(at) / f64::from(count.max(2) - 1);
    Ok(Samples((0..count).map(|at| low + (high - low) * share(at)).collect()))
}

pub(crate) fn execute(arguments: &ScoreArguments) -> Result<()> {
    let config = arguments.common.config()?.only(SensorKind::Lidar)?;
    let mut source = open_source(&arguments.input, &config)?;
    let options = Options { adapter: arguments.common.adapter.clone(), ..Options::default() };
    let (mapper, last) = run_to(source.as_mut(), Some(arguments.scan), &config, &options)?;
    let no_map = || Error::Empty { reason: "no scan was mapped".into() };
    let map = last.map.as_ref().ok_or_else(no_map)?;
    if last.index != arguments.scan {
        let reason =
            format!("scan {} was not mapped; the last before it that was is {}", arguments.scan, last.index);
        return Err(Error::Empty { reason });
    }
    let velocities: Vec<[f64; 2]> =
        arguments.v.0.iter().flat_map(|&v| arguments.omega.0.iter().map(move |&omega| [v, omega])).collect();
    let fastest = arguments.v.0.iter().map(|v| v.abs()).fold(0.0, f64::max);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates; the scorer checks"
    )]
    let places = (2.0 * fastest * arguments.horizon.max(0.0) / map.grid.resolution_m).ceil() as u32;
    let candidates = u32::try_from(velocities.len()).unwrap_or(u32::MAX);
    let (context, places) = (mapper.context(), places.saturating_add(2));
    let mut scorer = Scorer::on(context, map.grid.width, candidates, places)?;
    let scores = scorer.score_velocities(map, last.map_from_base, &velocities, arguments.horizon)?;
    print(&velocities, &scores, arguments.json);
    Ok(())
}

fn print(velocities: &[[f64; 2]], scores: &[Score], json: bool) {
    let mut all: Vec<_> = velocities.iter().zip(scores).collect();
    if json {
        let entry = |([v, omega], score): &(&[f64; 2], &Score)| serde_json::json!({"v_m_per_s": v, "omega_rad_per_s": omega, "score": score});
        println!("{}", serde_json::Value::from(all.iter().map(entry).collect::<Vec<_>>()));
        return;
    }
    all.sort_by_key(|(_, score)| score.cost);
    println!(
        "cost: sum over the cells crossed, unknown ones as 255; worst: the highest known, from 253 up a collision"
    );
    println!(
        "{} candidates, the cheapest first\n  v m/s  omega rad/s     cost  worst  cells  unknown",
        all.len()
    );
    for ([v, omega], Score { cost, worst, cells, unknown }) in all.into_iter().take(10) {
        println!("{v:7.2} {omega:12.3} {cost:8} {worst:6} {cells:6} {unknown:8}");
    }
}
