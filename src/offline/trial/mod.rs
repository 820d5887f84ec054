//! Navigation trials: a simulated robot drives through simulated worlds with limpid's map in the loop (spec 7).
//!
//! What is measured is the map: planner, controller and recovery are standard ones, and the same for all methods.

pub mod classes;
pub mod controller;
pub mod course;
pub mod drive;
pub mod judge;
pub mod paper;
pub mod picture;
pub mod record;
pub mod recovery;
pub mod replay;
pub mod robot;
pub mod route;
pub mod sensors;
pub mod setup;
pub mod tables;
pub mod world;

pub use course::{CameraMode, Course, Trial};
pub use drive::{Label, Terms, drive};
pub use record::{Outcome, Record};
pub use robot::{Limits, Pose};
pub use setup::{Scenario, Setup};
pub use tables::Report;
pub use world::World;
