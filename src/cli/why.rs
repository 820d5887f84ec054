//! `limpid why`.

use std::path::PathBuf;

use clap::Args;
use limpid::input::open_source;
use limpid::map::rule::RuleSettings;
use limpid::mapper::Options;
use limpid::run::run_to;
use limpid::{Error, Result};

use super::Common;

#[derive(Debug, Args)]
pub(crate) struct WhyArguments {
    /// Recording
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Place in the map frame, metres
    #[arg(long, value_name = "X,Y", value_parser = parse_place, allow_hyphen_values = true)]
    at: [f64; 2],
    /// In the map of the frame or scan of this number, or, of several sensors, in the published map of this number, counted
    /// from 0; left out: in the last
    #[arg(long, value_name = "N")]
    frame: Option<u64>,
    /// Lidar: find panes of glass, as `run --glass` does
    #[arg(long)]
    glass: bool,
}

fn parse_place(text: &str) -> std::result::Result<[f64; 2], String> {
    let wrong = || format!("`{text}` is not of the form X,Y in metres");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|m| m.is_finite()).ok_or_else(wrong);
    Ok([number(x)?, number(y)?])
}

pub(crate) fn execute(arguments: &WhyArguments) -> Result<()> {
    let mut config = arguments.common.config()?;
    config.change_all(|parameters| parameters.glass |= arguments.glass);
    let mut source = open_source(&arguments.input, &config)?;
    let adapter = arguments.common.adapter.clone();
    let options = Options { adapter, layers: true, verdicts: true, ..Options::default() };
    let (mapper, last) = run_to(source.as_mut(), arguments.frame, &config, &options)?;
    if let Some(wanted) = arguments.frame.filter(|&wanted| wanted != last.index) {
        let reason = format!("there is no map {wanted}; the nearest is {}", last.index);
        return Err(Error::Empty { reason });
    }
    let [x_m, y_m] = arguments.at;
    let Some(why) = mapper.why(&last, x_m, y_m)? else {
        let reason = match &last.map {
            Some(map) => {
                let grid = map.grid;
                let end = |origin_m: f64, cells: u32| origin_m + f64::from(cells) * grid.resolution_m;
                format!(
                    "({x_m}, {y_m}) is outside of the map, which then covers x {:.2} to {:.2} m and y {:.2} to {:.2} m",
                    grid.origin_x_m,
                    end(grid.origin_x_m, grid.width),
                    grid.origin_y_m,
                    end(grid.origin_y_m, grid.height)
                )
            }
            None => "there is no map".into(),
        };
        return Err(Error::Input { what: "--at".into(), reason });
    };
    let names: Vec<String> = source.sensors().iter().map(|sensor| sensor.name.clone()).collect();
    println!("{}", why.text(&RuleSettings::of(&config), &names));
    Ok(())
}
