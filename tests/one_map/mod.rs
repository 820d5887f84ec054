//! The one map through the mapper: observations of several sensors in, published maps out (spec 4).

mod clock;
mod ghost;
mod moving;
mod order;
mod outage;
mod panes;
mod refusals;
pub(crate) mod rig;
mod rows;
mod rows_refuted;
mod states;
