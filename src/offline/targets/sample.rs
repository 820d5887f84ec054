//! One training sample.

/// The network's pixels judged by one reference (spec 1 §2); rows x columns each.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// D*, metres; 0 where there is none, and the pixel is to be left out.
    pub reference_m: Vec<f32>,
    /// exp(-|D - D*| / sigma(D*)); 0 where D is invalid.
    pub soft: Vec<f32>,
    /// 1 where |D - D*| <= delta(D*); 0 where D is invalid.
    pub binary: Vec<f32>,
}

impl Judged {
    /// From quads of reference, soft, binary, depth.
    pub(crate) fn from_quads(quads: &[f32]) -> Self {
        let channel = |c: usize| quads.chunks_exact(4).map(|quad| quad[c]).collect();
        Self { reference_m: channel(0), soft: channel(1), binary: channel(2) }
    }
}

/// What the network is to be trained with, for one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Number of the frame in the recording.
    pub index: u64,
    /// Stamp of its depth, nanoseconds.
    pub stamp_ns: u64,
    /// 5 x rows x columns as `net/resize` wrote them: R, G, B in [0, 1], depth and change of depth over 10 m.
    pub input: Vec<f32>,
    /// Depth that the input's depth was made from, metres; rows x columns.
    pub depth_m: Vec<f32>,
    /// By the reference drawn from other frames.
    pub measured: Judged,
    /// By true depth, and the kind of the true surface ([`crate::sim::material::Kind::code`]), where the recording has truth.
    pub truth: Option<(Judged, Vec<u8>)>,
    /// delta of each true depth, metres; empty without truth.
    pub tolerance_m: Vec<f32>,
}
