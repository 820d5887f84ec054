//! The GPU host: adapter and device, shaders read by naga, the plan of a frame, its memory and its run.

pub mod arena;
mod cache;
pub mod context;
mod dispatch;
pub mod executor;
mod input;
mod loops;
mod parts;
pub mod plan;
mod programs;
mod readback;
mod ring;
pub mod shader;
mod store;
mod timing;
mod upload;

pub use context::{AdapterReport, Context, Requirements, adapters};
pub use executor::{Executor, FRAMES_IN_FLIGHT};
pub use input::FrameInput;
pub use plan::{BufferId, Extent, Invocations, Plan};
pub use readback::Readback;
pub use shader::{Access, Binding, Params, Shader, ShaderSource, ShaderText};
pub use store::Store;
