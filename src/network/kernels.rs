//! The network's kernels: WGSL put together from the parts that a block and an adapter need.

use std::fmt::Write as _;

use crate::gpu::{Context, ShaderText};

/// How kernels reach tensors and weights; the arithmetic is the same for all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Backend {
    /// Tensors are storage textures, which software drivers read fastest; else buffers.
    pub textures: bool,
    /// Lanes of a subgroup share the reading of weights.
    pub subgroups: bool,
}

impl Backend {
    /// What suits that adapter.
    pub fn of(context: &Context) -> Self {
        Self { textures: context.is_software(), subgroups: context.has_subgroups() }
    }

    /// Every combination.
    pub const ALL: [Self; 4] = [
        Self { textures: true, subgroups: true },
        Self { textures: true, subgroups: false },
        Self { textures: false, subgroups: true },
        Self { textures: false, subgroups: false },
    ];
}

/// A text of `shaders/`.
macro_rules! wgsl {
    ($($path:literal),+) => {
        include_str!(concat!("../../shaders/", $($path,)+ ".wgsl"))
    };
}

/// The text for textures, or that for buffers.
macro_rules! stored {
    ($backend:expr, $role:literal) => {
        if $backend.textures {
            wgsl!("lib/net/", $role, "_texture")
        } else {
            wgsl!("lib/net/", $role, "_buffer")
        }
    };
}

/// Where a kernel's taps lie in its source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sampling {
    Straight,
    Upsampled,
}

/// What a kernel does with its sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Finish {
    Store,
    Head,
}

/// One of the network's passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kernel {
    Resize,
    Pack,
    Convolve,
    Fused { from: Sampling, skip: bool, finish: Finish },
    Depthwise { from: Sampling },
    Pointwise,
    Head,
    Unpack,
    Restore,
}

impl Kernel {
    fn entry_point(self) -> &'static str {
        match self {
            Self::Pack => "pack",
            Self::Convolve => "convolve",
            Self::Fused { .. } => "fused",
            Self::Depthwise { .. } => "depthwise",
            Self::Pointwise => "pointwise",
            Self::Head => "head",
            Self::Unpack => "unpack",
            Self::Resize => "resize",
            Self::Restore => "restore",
        }
    }

    fn parts(self, backend: Backend) -> Vec<&'static str> {
        let lanes = match backend.subgroups {
            true => wgsl!("lib/net/lanes_subgroup"),
            false => wgsl!("lib/net/lanes_alone"),
        };
        let weights = stored!(backend, "weights");
        let source = stored!(backend, "source");
        let sink = stored!(backend, "sink");
        let [window, sums] = [wgsl!("lib/net/window"), wgsl!("lib/net/sums")];
        let [numbers, sigmoid] = [wgsl!("lib/numbers"), wgsl!("lib/net/sigmoid")];
        let store = wgsl!("lib/net/finish_store");
        let straight = wgsl!("lib/net/source_straight");
        let depthwise = wgsl!("lib/net/depthwise_tile");
        let sampled = |from| match from {
            Sampling::Straight => straight,
            Sampling::Upsampled => wgsl!("lib/net/source_upsampled"),
        };
        match self {
            Self::Pack => vec![sink, wgsl!("net/pack")],
            Self::Unpack => vec![source, wgsl!("net/unpack")],
            Self::Resize => vec![sink, wgsl!("net/resize")],
            Self::Restore => vec![wgsl!("net/restore")],
            Self::Head => vec![weights, source, numbers, sigmoid, wgsl!("net/head")],
            Self::Pointwise => {
                vec![weights, lanes, source, sink, window, sums, store, wgsl!("net/pointwise")]
            }
            Self::Convolve => {
                vec![weights, lanes, source, sink, window, straight, sums, store, wgsl!("net/convolve")]
            }
            Self::Depthwise { from } => {
                vec![weights, lanes, source, sink, window, sampled(from), depthwise, wgsl!("net/depthwise")]
            }
            Self::Fused { from, skip, finish } => {
                let skip = if skip { stored!(backend, "skip") } else { wgsl!("lib/net/skip_none") };
                let finish = match finish {
                    Finish::Store => vec![sink, store],
                    Finish::Head => vec![numbers, sigmoid, wgsl!("lib/net/finish_head")],
                };
                let mut parts = vec![weights, lanes, source, skip, window, sampled(from)];
                parts.extend([depthwise, sums]);
                parts.extend(finish);
                parts.push(wgsl!("net/fused"));
                parts
            }
        }
    }

    /// Its WGSL, with the shapes of one block as constants before it.
    pub(crate) fn text(self, label: String, backend: Backend, constants: &[(&str, u32)]) -> ShaderText {
        let mut text = String::new();
        for (name, value) in constants {
            let _ = writeln!(text, "const {name} = {value};");
        }
        for part in self.parts(backend) {
            text.push('\n');
            text.push_str(part);
        }
        ShaderText { label, entry_point: self.entry_point(), text }
    }
}

/// The parts of every kernel for every backend, so that a test can tell whether each file is of use.
pub fn all_kernels() -> Vec<Vec<&'static str>> {
    let both = [Sampling::Straight, Sampling::Upsampled];
    let fused = both.into_iter().flat_map(|from| {
        [false, true].into_iter().flat_map(move |skip| {
            [Finish::Store, Finish::Head].map(|finish| Kernel::Fused { from, skip, finish })
        })
    });
    let depthwise = both.map(|from| Kernel::Depthwise { from });
    let others = [
        Kernel::Pack,
        Kernel::Convolve,
        Kernel::Pointwise,
        Kernel::Head,
        Kernel::Unpack,
        Kernel::Resize,
        Kernel::Restore,
    ];
    let kernels: Vec<_> = fused.chain(depthwise).chain(others).collect();
    Backend::ALL.into_iter().flat_map(|b| kernels.iter().map(move |kernel| kernel.parts(b))).collect()
}
