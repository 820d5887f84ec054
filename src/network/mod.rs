//! DRM-Net on the GPU (spec 1 §1): which passes run a network, on which tensors, with which weights.

mod alone;
mod kernels;
mod packing;
mod passes;
pub mod weights;

pub use alone::{BlockOutput, Inference};
pub(crate) use kernels::Kernel;
pub use kernels::{Backend, all_kernels};
pub use passes::{INPUT, OUTPUT, Passes};
