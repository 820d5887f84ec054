//! Which model sent a run of packets: its factory byte, unless the packets' timing contradicts it.

use crate::base::Result;
use crate::input::points::velodyne::packet::{BLOCKS, Packet};
use crate::message::decode_error;
use crate::sensor::VelodyneModel;

/// Microseconds of an hour, at which sensors' clocks start anew.
pub(super) const HOUR_US: u32 = 3_600_000_000;

/// How far a model's block time may be off; those of different models are 17 % and more apart.
const TIMING_TOLERANCE: f64 = 0.05;

/// From one packet's time to another's, across a full hour too. Times beyond an hour, which no sensor sends, count as
/// within it.
pub(super) fn elapsed_us(from_us: u32, to_us: u32) -> u32 {
    let (from_us, to_us) = (from_us % HOUR_US, to_us % HOUR_US);
    if to_us >= from_us { to_us - from_us } else { HOUR_US - (from_us - to_us) }
}

/// The median time between firings of a block, microseconds; `None` of less than two packets.
fn block_us(packets: &[&Packet]) -> Option<f64> {
    let mut spacings: Vec<u32> =
        packets.windows(2).map(|pair| elapsed_us(pair[0].time_us(), pair[1].time_us())).collect();
    spacings.sort_unstable();
    let firings = BLOCKS / packets.first()?.blocks_per_firing();
    spacings.get(spacings.len() / 2).map(|&spacing| f64::from(spacing) / firings as f64)
}

/// The model of the first packets of a sensor, and what the user should know about the choice.
///
/// # Errors
/// [`crate::Error::Decode`] where the factory byte names no model.
pub(super) fn detect(packets: &[&Packet]) -> Result<(VelodyneModel, Option<String>)> {
    let byte = packets.first().map_or(0, |packet| packet.model_byte());
    let Some(named) = VelodyneModel::of_factory_byte(byte) else {
        let known: Vec<String> =
            VelodyneModel::ALL.map(|model| format!("{:#04x} {}", model.factory_byte(), model.name())).into();
        let known = known.join(", ");
        let reason =
            format!("factory byte {byte:#04x} names no model that is decoded ({known}); state the model");
        return Err(decode_error("Velodyne packet", reason));
    };
    let Some(measured_us) = block_us(packets) else { return Ok((named, None)) };
    let fits = |model: &VelodyneModel| (measured_us / model.block_us() - 1.0).abs() < TIMING_TOLERANCE;
    if fits(&named) {
        return Ok((named, None));
    }
    let name = named.name();
    Ok(match VelodyneModel::ALL.iter().find(|model| fits(model)) {
        Some(&model) => {
            let timed = model.name();
            let note = format!(
                "the packets' factory byte {byte:#04x} says {name}, but a block takes {measured_us:.1} us as in {timed}: decoded as {timed}"
            );
            (model, Some(note))
        }
        None => {
            let note = format!(
                "a block takes {measured_us:.1} us, which fits no model: decoded as {name}, as the factory byte {byte:#04x} says"
            );
            (named, Some(note))
        }
    })
}
