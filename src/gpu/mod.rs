//! The GPU host: adapter and device, shaders read by naga, the plan of a frame, its memory and its run.

pub mod arena;
mod cache;
pub mod context;
mod dispatch;
pub mod frame;
mod input;
mod loops;
mod parts;
pub mod plan;
mod readback;
mod ring;
pub mod shader;
mod timing;
mod upload;

pub use context::{AdapterReport, Chosen, Context, Requirements, adapters};
pub use frame::Executor;
pub use input::FrameInput;
pub use plan::{BufferId, Extent, Invocations, Plan};
pub use readback::Readback;
pub use shader::{Access, Binding, Params, Shader, ShaderSource, ShaderText};
