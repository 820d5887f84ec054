//! The one error type: every variant names the pass, buffer, topic, file or key at fault.

use std::path::PathBuf;

/// Result of limpid's fallible functions.
///
/// ```
/// fn cells_of(yaml: &str) -> limpid::Result<u32> {
///     limpid::Config::from_yaml(yaml)?.cells_per_side()
/// }
/// assert_eq!(cells_of("map_size_m: 10.0")?, 200);
/// # Ok::<(), limpid::Error>(())
/// ```
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong, each with what it concerns and, where there is one, the mend.
///
/// ```
/// let error = limpid::Config::from_yaml("map_sise_m: 8.0").unwrap_err();
/// assert!(matches!(&error, limpid::Error::Config { key, .. } if key == "map_sise_m"));
/// assert!(error.to_string().contains("map_size_m"), "it names the nearest key: {error}");
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or folder could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file was read but its content is not what its format asks for.
    #[error("{path}: {reason}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// An output could not be written, for a reason that is not the operating system's.
    #[error("{path}: {reason}", path = path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What is wrong with its content or its use.
        reason: String,
    },
    /// An output that would be written over an input, or over another output; nothing was written.
    #[error("{path}: {reason}", path = path.display())]
    Output {
        /// The output.
        path: PathBuf,
        /// What it also is.
        reason: String,
    },
    /// A run failed after it had written results.
    #[error("{cause} (what was written before that is in {})", list(kept))]
    Partial {
        /// Why it failed.
        cause: Box<Error>,
        /// The files that hold its results so far.
        kept: Vec<PathBuf>,
    },
    /// A message, image or field of a recording does not decode.
    #[error("{what}: {reason}")]
    Decode {
        /// The message type, encoding or field.
        what: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A configuration key has an impossible value or does not exist.
    #[error("configuration key `{key}`: {reason}")]
    Config {
        /// The key as written in the YAML file.
        key: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A configuration file is not valid YAML; the text holds line, column and a snippet.
    #[error("configuration: {0}")]
    Yaml(String),
    /// A WGSL file does not parse or breaks a rule of the house.
    #[error("shader `{pass}`: {reason}")]
    Shader {
        /// The pass.
        pass: String,
        /// naga's message or the rule.
        reason: String,
    },
    /// The plan of a frame is wrong.
    #[error("plan: `{pass}` {reason}")]
    Plan {
        /// The pass or buffer at fault.
        pass: String,
        /// What is wrong.
        reason: String,
    },
    /// No adapter can run limpid.
    #[error(
        "no GPU adapter{wanted}. Found: {found}. Install a Vulkan driver; without a GPU Mesa's lavapipe does \
         (Debian and Ubuntu: apt-get install mesa-vulkan-drivers)"
    )]
    NoAdapter {
        /// The name asked for, with a leading word, or nothing.
        wanted: String,
        /// What there is.
        found: String,
    },
    /// The adapter offers less than the plan needs.
    #[error("adapter `{adapter}` has {limit} {available}, and {needed} is needed; {mend}")]
    Limit {
        /// The adapter.
        adapter: String,
        /// Name of the limit.
        limit: &'static str,
        /// What it offers.
        available: u64,
        /// What the plan needs.
        needed: u64,
        /// What to do about it.
        mend: &'static str,
    },
    /// The driver or wgpu refused an operation.
    #[error("GPU, {what}: {reason}")]
    Gpu {
        /// The pass, buffer or operation.
        what: String,
        /// What wgpu said.
        reason: String,
    },
    /// The device went away; the mapper must be built anew.
    #[error("GPU device lost: {0}")]
    DeviceLost(String),
    /// A weight file does not hold a network that limpid can run.
    #[error("weights, {what}: {reason}")]
    Weights {
        /// The tensor, block or metadata key.
        what: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A recording gave nothing that could be used.
    #[error("nothing of the recording could be used: {reason}")]
    Empty {
        /// What was met instead.
        reason: String,
    },
    /// DDS, or a name in ROS 2, refused an operation.
    #[error("ROS 2, {what}: {reason}")]
    Ros2 {
        /// The topic, name or operation.
        what: String,
        /// What is wrong.
        reason: String,
    },
    /// What a tool was given does not fit: its size, its type or its numbers.
    #[error("input `{what}`: {reason}")]
    Input {
        /// The image, scan, map or list.
        what: String,
        /// What was expected and what came.
        reason: String,
    },
}

fn list(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

impl Error {
    /// An [`Error::File`] for `path`, for use with `map_err`.
    pub fn file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
