//! Transforms over time: a tree of frames, each with its pose in its parent, sampled or fixed.

use std::collections::{HashMap, VecDeque};
use std::fmt;

use crate::base::Rigid;

/// Samples older than this before a frame's newest one are forgotten, nanoseconds of recording time.
const WINDOW_NS: u64 = 10_000_000_000;

/// Most samples kept for a frame (1 kHz over the window).
const MAX_SAMPLES: usize = 10_000;

/// Most frames kept; a tree on a robot has tens.
const MAX_FRAMES: usize = 4096;

/// Longest chain of parents followed.
const MAX_DEPTH: usize = 128;

/// A stamp this far before a frame's newest sample is a clock set back or a bag that looped, nanoseconds.
pub(crate) const JUMP_NS: u64 = 1_000_000_000;

/// Why a transform cannot be given. Texts hold no stamps, so that equal reasons are counted together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TransformError {
    /// No chain of frames leads from one to the other.
    Disconnected,
    /// The stamp lies before the oldest sample of a frame in the chain.
    Past {
        /// That frame.
        child: String,
    },
    /// The stamp lies after the newest sample of a frame in the chain.
    Future {
        /// That frame.
        child: String,
    },
    /// A frame is its own ancestor, or the chain is longer than 128 frames.
    Loop {
        /// A frame of the loop.
        frame: String,
    },
}

impl fmt::Display for TransformError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disconnected => write!(f, "the frames are not connected"),
            Self::Past { child } => write!(f, "the stamp is before the oldest transform of `{child}`"),
            Self::Future { child } => write!(f, "the stamp is past the newest transform of `{child}`"),
            Self::Loop { frame } => write!(f, "the parents of `{frame}` form a loop"),
        }
    }
}

/// What became of an inserted transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inserted {
    /// It was taken.
    Taken,
    /// It was left out: a fixed transform is known for this frame, or there are too many frames.
    Ignored,
}

#[derive(Debug)]
struct Edge {
    parent: String,
    fixed: bool,
    /// From the configuration: what a recording says replaces it.
    stated: bool,
    /// In order of stamps, never empty.
    samples: VecDeque<(u64, Rigid)>,
}

impl Edge {
    fn newest_ns(&self) -> u64 {
        self.samples.back().map_or(0, |&(stamp_ns, _)| stamp_ns)
    }

    fn insert(&mut self, stamp_ns: u64, parent_from_child: Rigid) {
        let at = self.samples.partition_point(|&(other_ns, _)| other_ns < stamp_ns);
        match self.samples.get_mut(at) {
            Some(same) if same.0 == stamp_ns => same.1 = parent_from_child,
            _ => self.samples.insert(at, (stamp_ns, parent_from_child)),
        }
        let oldest_ns = self.newest_ns().saturating_sub(WINDOW_NS);
        while self.samples.len() > MAX_SAMPLES || (self.samples.len() > 2 && self.samples[0].0 < oldest_ns) {
            self.samples.pop_front();
        }
    }

    /// Whether it is told up to a stamp, or nearly.
    fn reaches(&self, stamp_ns: u64, tolerance_ns: u64) -> bool {
        self.fixed || stamp_ns <= self.newest_ns().saturating_add(tolerance_ns)
    }

    /// Parent from child at a stamp, linear in translation and slerp in rotation between samples.
    fn at(&self, child: &str, stamp_ns: u64, tolerance_ns: u64) -> Result<Rigid, TransformError> {
        let after = self.samples.partition_point(|&(other_ns, _)| other_ns < stamp_ns);
        match (after.checked_sub(1).and_then(|before| self.samples.get(before)), self.samples.get(after)) {
            (_, Some(&(other_ns, exact))) if self.fixed || other_ns == stamp_ns => Ok(exact),
            (Some(&(_, fixed)), None) if self.fixed => Ok(fixed),
            (Some(&(t0, before)), Some(&(t1, after))) => {
                #[expect(clippy::cast_precision_loss, reason = "a share of an interval")]
                let share = (stamp_ns - t0) as f64 / (t1 - t0) as f64;
                Ok(before.interpolate(after, share))
            }
            (Some(&(newest_ns, newest)), None) if stamp_ns - newest_ns <= tolerance_ns => Ok(newest),
            (Some(_), None) => Err(TransformError::Future { child: child.into() }),
            (None, _) => Err(TransformError::Past { child: child.into() }),
        }
    }
}

/// A tree of frames with bounded memory; see the module.
#[derive(Debug, Default)]
pub struct TransformBuffer {
    edges: HashMap<String, Edge>,
}

impl TransformBuffer {
    /// An empty tree.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a fixed transform; it replaces whatever was known of the child.
    pub fn insert_fixed(&mut self, parent: &str, child: &str, parent_from_child: Rigid) -> Inserted {
        let samples = VecDeque::from([(0, parent_from_child)]);
        self.put(child, Edge { parent: parent.into(), fixed: true, stated: false, samples })
    }

    /// Adds a fixed transform that gives way to whatever is inserted for the child later.
    pub fn insert_stated(&mut self, parent: &str, child: &str, parent_from_child: Rigid) -> Inserted {
        let samples = VecDeque::from([(0, parent_from_child)]);
        self.put(child, Edge { parent: parent.into(), fixed: true, stated: true, samples })
    }

    /// Adds a sample. A new parent replaces the old one; a fixed transform stays.
    pub fn insert(&mut self, parent: &str, child: &str, stamp_ns: u64, parent_from_child: Rigid) -> Inserted {
        match self.edges.get_mut(child) {
            Some(edge) if edge.fixed && !edge.stated => Inserted::Ignored,
            Some(edge) if edge.parent == parent && !edge.fixed => {
                edge.insert(stamp_ns, parent_from_child);
                Inserted::Taken
            }
            _ => {
                let samples = VecDeque::from([(stamp_ns, parent_from_child)]);
                self.put(child, Edge { parent: parent.into(), fixed: false, stated: false, samples })
            }
        }
    }

    fn put(&mut self, child: &str, edge: Edge) -> Inserted {
        if self.edges.len() >= MAX_FRAMES && !self.edges.contains_key(child) {
            return Inserted::Ignored;
        }
        self.edges.insert(child.into(), edge);
        Inserted::Taken
    }

    /// Whether the child's transform is one of [`TransformBuffer::insert_stated`].
    pub fn is_stated(&self, child: &str) -> bool {
        self.edges.get(child).is_some_and(|edge| edge.stated)
    }

    /// Whether a sample of `child` at this stamp would lie more than a second before its newest one.
    pub fn jumps_back(&self, child: &str, stamp_ns: u64) -> bool {
        self.edges.get(child).is_some_and(|edge| {
            !edge.fixed && stamp_ns.checked_add(JUMP_NS).is_some_and(|end_ns| end_ns < edge.newest_ns())
        })
    }

    /// Newest stamp of the samples of a frame and its ancestors; `None` where there are none.
    pub fn newest_ns(&self, frame: &str) -> Option<u64> {
        let edges = self.climb_from(frame, |_| true).0.into_iter().filter_map(|at| self.edges.get(at));
        edges.filter(|edge| !edge.fixed).map(Edge::newest_ns).max()
    }

    /// Forgets all samples; fixed transforms stay.
    pub fn clear_samples(&mut self) {
        self.edges.retain(|_, edge| edge.fixed);
    }

    /// Whether nothing was inserted.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// Whether the frame is part of the tree, as a child or as a parent.
    pub fn knows(&self, frame: &str) -> bool {
        self.edges.contains_key(frame) || self.edges.values().any(|edge| edge.parent == frame)
    }

    /// `target_from_source` at a stamp; a stamp up to `tolerance_ns` past a frame's newest sample
    /// takes that sample.
    ///
    /// # Errors
    /// [`TransformError`], as a value to count, not to end on.
    pub fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
    ) -> Result<Rigid, TransformError> {
        // Where parents form a loop, a transform that is no longer told may be what closes it.
        let (up, down) = self.ways(target, source, |_| true).or_else(|error| {
            let told = self.ways(target, source, |edge| edge.reaches(stamp_ns, tolerance_ns));
            told.map_err(|_| error)
        })?;
        let common = up.iter().find(|frame| down.contains(frame)).ok_or(TransformError::Disconnected)?;
        let common_from_source = self.climb(&up, common, stamp_ns, tolerance_ns)?;
        let common_from_target = self.climb(&down, common, stamp_ns, tolerance_ns)?;
        Ok(common_from_target.inverse().then(common_from_source))
    }

    /// The ancestors of source and target by the edges that count.
    fn ways<'a>(
        &'a self,
        target: &'a str,
        source: &'a str,
        counts: impl Fn(&Edge) -> bool,
    ) -> Result<(Vec<&'a str>, Vec<&'a str>), TransformError> {
        let way = |frame: &'a str| match self.climb_from(frame, &counts) {
            (chain, false) => Ok(chain),
            (_, true) => Err(TransformError::Loop { frame: frame.into() }),
        };
        Ok((way(source)?, way(target)?))
    }

    /// The frame, its parent, and so on up to the root or to where a loop closes, and whether one does.
    fn climb_from<'a>(&'a self, frame: &'a str, counts: impl Fn(&Edge) -> bool) -> (Vec<&'a str>, bool) {
        let mut chain = vec![frame];
        let mut at = frame;
        while let Some(edge) = self.edges.get(at).filter(|edge| counts(edge)) {
            at = &edge.parent;
            if chain.len() > MAX_DEPTH || chain.contains(&at) {
                return (chain, true);
            }
            chain.push(at);
        }
        (chain, false)
    }

    /// `top` from the chain's first frame.
    fn climb(
        &self,
        chain: &[&str],
        top: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
    ) -> Result<Rigid, TransformError> {
        let steps = chain
            .iter()
            .take_while(|&&frame| frame != top)
            .filter_map(|&frame| self.edges.get(frame).map(|edge| edge.at(frame, stamp_ns, tolerance_ns)));
        let mut top_from_first = Rigid::IDENTITY;
        for parent_from_child in steps {
            top_from_first = parent_from_child?.then(top_from_first);
        }
        Ok(top_from_first)
    }
}
