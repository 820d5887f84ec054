//! Velodyne sensors by model.

/// The sensors whose packets are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum VelodyneModel {
    /// VLP-16 and Puck LITE: 16 lasers, 30 degrees.
    Vlp16,
    /// Puck Hi-Res: as VLP-16 with 20 degrees.
    #[serde(rename = "puck-hi-res")]
    PuckHiRes,
    /// HDL-32E: 32 lasers, 41.3 degrees.
    Hdl32e,
    /// VLP-32C (Ultra Puck): 32 lasers, 40 degrees.
    Vlp32c,
}

impl VelodyneModel {
    /// All, for messages and tests.
    pub const ALL: [Self; 4] = [Self::Vlp16, Self::PuckHiRes, Self::Hdl32e, Self::Vlp32c];

    /// The name in the manual.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vlp16 => "VLP-16",
            Self::PuckHiRes => "Puck Hi-Res",
            Self::Hdl32e => "HDL-32E",
            Self::Vlp32c => "VLP-32C",
        }
    }
}
