//! The whole pipeline on analytic scenes.

mod bad_input;
mod clock;
mod determinism;
mod drm;
mod drops;
mod evidence;
mod geometry;
mod ground;
mod inputs;
mod learned;
mod methods;
mod rolling;
mod time;
