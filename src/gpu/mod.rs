//! The GPU host: adapter and device, shaders read by naga, the plan of a frame, its memory and its run.

pub mod arena;
mod cache;
pub mod context;
pub mod frame;
pub mod plan;
mod ring;
pub mod shader;
mod timing;

pub use context::{AdapterReport, Context, Requirements, adapters};
pub use frame::{Executor, Readback};
pub use plan::{BufferId, Invocations, Plan};
pub use shader::{Access, Binding, Params, Shader, ShaderSource};
