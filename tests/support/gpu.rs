//! Runs one pass on given data: a plan of that pass alone, whose outputs hold a sentinel before it.

use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use bytemuck::{Pod, bytes_of, cast_slice, pod_read_unaligned};
use limpid::gpu::{Context, Executor, Extent, Invocations, Params, Plan, ShaderSource, ShaderText};

use crate::support::compare::{EXACT, compare};
use crate::support::say;

/// What outputs hold before the pass; as a float it is a NaN, which the comparator refuses.
pub(crate) const SENTINEL: u32 = 0x7fc0_dead;

/// Words behind every buffer that a pass writes; they must keep what they hold.
const GUARD: usize = 16;

/// Copies an upload into a buffer that only passes may write.
const PREFILL: ShaderSource = ShaderSource {
    name: "prefill",
    parts: &["
@group(0) @binding(0) var<storage, read> filling: array<u32>;
@group(0) @binding(1) var<storage, read_write> filled: array<u32>;

@compute @workgroup_size(64)
fn prefill(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&filled) {
        filled[id.x] = filling[id.x];
    }
}
"],
};

/// Copies a texture into a buffer.
const UNPACK_TEXELS: ShaderSource = ShaderSource {
    name: "unpack_texels",
    parts: &["
@group(0) @binding(0) var packed: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(1) var<storage, read_write> unpacked: array<vec4<f32>>;

@compute @workgroup_size(64)
fn unpack_texels(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = textureDimensions(packed).x;
    if id.x < arrayLength(&unpacked) {
        unpacked[id.x] = textureLoad(packed, vec2(id.x % width, id.x / width), 0u);
    }
}
"],
};

/// Whether GPU tests are to be left out (`LIMPID_SKIP_GPU=1`); says how many were so far, past libtest's capture.
pub(crate) fn skipped() -> bool {
    static SKIPPED: AtomicUsize = AtomicUsize::new(0);
    let skip = std::env::var("LIMPID_SKIP_GPU").is_ok_and(|value| value == "1");
    if skip {
        let count = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
        say(&format!("GPU tests skipped so far: {count}"));
    }
    skip
}

/// A grid of bytes, four to a word, without the padding of its rows.
pub(crate) fn cells_of_quads(words: &[u32], side: u32) -> Vec<u8> {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.chunks_exact(4 * side.div_ceil(4) as usize).flat_map(|row| row[..side as usize].to_vec()).collect()
}

/// The device that all stage tests share: what wgpu refuses is the error of the call that caused it.
pub(crate) fn context() -> Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(|| Context::open(None, false).unwrap()).clone()
}

/// A pass under construction, with the data of its buffers.
#[derive(Default)]
pub(crate) struct Fragment {
    plan: Plan,
    inputs: Vec<(String, Vec<u8>)>,
    changed: Vec<(String, usize)>,
    constants: Vec<(&'static str, bool)>,
    /// Textures that the pass writes, and their texels.
    written: Vec<(&'static str, u32)>,
}

impl Fragment {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Parameters.
    pub(crate) fn params<P: Params>(mut self, name: &str, params: &P) -> Self {
        self.plan.uniform::<P>(name).unwrap();
        self.inputs.push((name.into(), bytes_of(params).to_vec()));
        self
    }

    /// Values of the pass's `override` constants; without them it runs with its defaults.
    pub(crate) fn constants(mut self, constants: &[(&'static str, bool)]) -> Self {
        self.constants = constants.to_vec();
        self
    }

    /// A buffer that the pass reads.
    pub(crate) fn input<T: Pod>(mut self, name: &str, data: &[T]) -> Self {
        let bytes = cast_slice::<T, u8>(data).to_vec();
        self.plan.upload(name, bytes.len() as u64).unwrap();
        self.inputs.push((name.into(), bytes));
        self
    }

    /// A texture of whole numbers that the pass reads; `data` fills it from its first row on.
    pub(crate) fn texture(mut self, name: &str, [width, height]: [u32; 2], data: &[u8]) -> Self {
        self.plan.upload_texture(name, width, height).unwrap();
        self.inputs.push((name.into(), data.to_vec()));
        self
    }

    /// A texture of floats that the pass reads, from its first row on; zeros after `texels`.
    pub(crate) fn float_texture(mut self, name: &str, width: u32, height: u32, texels: &[[f32; 4]]) -> Self {
        let extent = Extent { width, height, layers: 1 };
        let mut data = cast_slice::<_, u8>(texels).to_vec();
        data.resize(usize::try_from(extent.bytes()).unwrap(), 0);
        self.plan.fixed_texture(name, extent, data).unwrap();
        self
    }

    /// A texture that the pass writes; its outputs are the texels, row by row.
    pub(crate) fn texture_output(mut self, name: &'static str, width: u32, height: u32) -> Self {
        self.plan.texture(name, Extent { width, height, layers: 1 }).unwrap();
        self.written.push((name, width * height));
        self
    }

    /// A buffer that the pass changes, with what it holds before.
    pub(crate) fn changed<T: Pod>(mut self, name: &str, before: &[T]) -> Self {
        let mut words: Vec<u32> =
            cast_slice::<T, u8>(before).chunks_exact(4).map(pod_read_unaligned).collect();
        self.changed.push((name.into(), words.len()));
        words.extend([SENTINEL; GUARD]);
        let filling = format!("{name}_before");
        self = self.input(&filling, &words);
        self.plan.scratch(name, words.len() as u64 * 4).unwrap();
        self.plan.read_back(name).unwrap();
        let count = Invocations::line(u32::try_from(words.len()).unwrap());
        self.plan.step(PREFILL, count, &[("filling", &filling), ("filled", name)]).unwrap();
        self
    }

    /// A buffer of `words` words that the pass writes; it holds [`SENTINEL`]s before.
    pub(crate) fn output(self, name: &str, words: usize) -> Self {
        self.changed(name, &vec![SENTINEL; words])
    }

    /// Runs the pass once.
    pub(crate) fn run(self, source: impl Into<ShaderText>, invocations: Invocations) -> Outputs {
        self.try_run(source, invocations).unwrap()
    }

    /// Runs the pass once.
    ///
    /// # Errors
    /// Those of the plan and the GPU.
    pub(crate) fn try_run(
        mut self,
        source: impl Into<ShaderText>,
        invocations: Invocations,
    ) -> limpid::Result<Outputs> {
        self.plan.step(source, invocations, &[])?;
        self.plan.with(&self.constants)?;
        for (name, texels) in &self.written {
            let unpacked = format!("{name}_texels");
            self.plan.scratch(&unpacked, u64::from(*texels) * 16)?;
            let names = [("packed", *name), ("unpacked", unpacked.as_str())];
            self.plan.step(UNPACK_TEXELS, Invocations::line(*texels), &names)?;
            self.plan.read_back(&unpacked)?;
        }
        let mut executor = Executor::build(&context(), self.plan)?;
        let mut input = executor.begin()?;
        for (name, data) in &self.inputs {
            input.write(name, data)?;
        }
        input.submit()?;
        let readback = executor.receive()?.unwrap();
        let mut buffers = HashMap::new();
        for (name, words) in self.changed {
            let bytes = readback.bytes(executor.find(&name)?)?;
            let mut all: Vec<u32> = bytes.chunks_exact(4).map(pod_read_unaligned).collect();
            let guard = all.split_off(words);
            assert!(guard.iter().all(|&word| word == SENTINEL), "the pass wrote behind the end of `{name}`");
            buffers.insert(name, all);
        }
        for (name, _) in self.written {
            let bytes = readback.bytes(executor.find(&format!("{name}_texels"))?)?;
            buffers.insert(name.into(), bytes.chunks_exact(4).map(pod_read_unaligned).collect());
        }
        Ok(Outputs { buffers })
    }

    /// Asserts that the plan refuses the pass over no invocations at all.
    #[track_caller]
    pub(crate) fn refuses_nothing(mut self, source: impl Into<ShaderText>) {
        let text = source.into();
        for extent in [[0, 1, 1], [1, 0, 1]] {
            let reason = self.plan.step(text.clone(), Invocations(extent), &[]).unwrap_err().to_string();
            assert!(reason.contains(&text.label) && reason.contains("an extent is 0"), "{reason}");
        }
    }
}

/// What the changed buffers held after the pass.
pub(crate) struct Outputs {
    buffers: HashMap<String, Vec<u32>>,
}

impl Outputs {
    /// The words of a buffer.
    pub(crate) fn words(&self, name: &str) -> &[u32] {
        &self.buffers[name]
    }

    /// A buffer as floats.
    pub(crate) fn floats(&self, name: &str) -> Vec<f32> {
        self.words(name).iter().map(|&word| f32::from_bits(word)).collect()
    }
}

#[test]
#[should_panic(expected = "wrote behind the end")]
fn notices_writes_behind_the_end() {
    const SPILL: ShaderSource = ShaderSource {
        name: "spill",
        parts: &["
@group(0) @binding(0) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(64)
fn spill(@builtin(global_invocation_id) id: vec3<u32>) {
    out[id.x] = 1u;
}
"],
    };
    if skipped() {
        panic!("skipped, not: wrote behind the end");
    }
    Fragment::new().output("out", 5).run(SPILL, Invocations::line(5));
}

#[test]
fn unwritten_outputs_keep_the_sentinel() {
    const HALF: ShaderSource = ShaderSource {
        name: "half",
        parts: &["
@group(0) @binding(0) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(4)
fn half(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < 2u {
        out[id.x] = 7u;
    }
}
"],
    };
    if skipped() {
        return;
    }
    let out = Fragment::new().output("out", 4).run(HALF, Invocations::line(4));
    assert_eq!(out.words("out"), [7, 7, SENTINEL, SENTINEL]);
    assert!(compare("out", &out.floats("out"), &[7.0_f32; 4], EXACT).is_err());
}
