//! The frames of a recording, whatever became of their transforms, and why a sensor has no pose in them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::input::event::TransformEvent;
use crate::input::transforms::TransformError;
use crate::sensor::SensorKind;

/// Most frames kept; a robot has tens.
const MAX_FRAMES: usize = 4096;

/// Most frames that a message lists.
const MAX_LISTED: usize = 24;

/// Longest chain of parents followed.
const MAX_DEPTH: usize = 128;

/// Stamps before this are of a clock that starts at 0, as simulators have it, nanoseconds.
const SIMULATED_NS: u64 = 100_000_000 * 1_000_000_000;

/// What is known of a frame's transform.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Link {
    pub(crate) parent: String,
    /// For all time.
    pub(crate) fixed: bool,
    /// Of the configuration alone.
    pub(crate) stated: bool,
    /// Transforms seen.
    pub(crate) count: u64,
    /// Stamps of the earliest and the latest, nanoseconds.
    pub(crate) span_ns: [u64; 2],
}

/// Every frame of which a transform was seen, with its newest parent.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct FrameTree {
    links: BTreeMap<String, Link>,
}

/// The observations of one sensor, as far as poses are concerned.
#[derive(Debug, Clone, Default)]
pub(crate) struct Posing {
    /// Those with a pose.
    pub(crate) posed: u64,
    /// The first without: its frame and why.
    first: Option<(String, TransformError)>,
    /// Stamps of the earliest and the latest without, nanoseconds.
    span_ns: [u64; 2],
}

impl Posing {
    /// Counts an observation without a pose.
    pub(crate) fn miss(&mut self, frame: &str, stamp_ns: u64, error: &TransformError) {
        if self.first.is_none() {
            (self.first, self.span_ns) = (Some((frame.into(), error.clone())), [stamp_ns; 2]);
        }
        self.span_ns = [self.span_ns[0].min(stamp_ns), self.span_ns[1].max(stamp_ns)];
    }
}

/// What an explanation is about.
pub(crate) struct Asked<'a> {
    pub(crate) kind: SensorKind,
    pub(crate) map_frame: &'a str,
    pub(crate) base_frame: &'a str,
    /// What to say where the recording has no transforms at all.
    pub(crate) without_transforms: &'a str,
    /// What to say of odometry that could be used and is not; empty where there is none.
    pub(crate) odometry: &'a str,
}

impl FrameTree {
    /// Takes in a transform of the recording.
    pub(crate) fn see(&mut self, transform: &TransformEvent) {
        let TransformEvent { parent, child, stamp_ns, fixed, .. } = transform;
        match self.links.get_mut(child) {
            Some(link) if !link.stated => {
                if link.parent != *parent {
                    link.parent.clone_from(parent);
                }
                link.fixed |= fixed;
                link.count += 1;
                link.span_ns = [link.span_ns[0].min(*stamp_ns), link.span_ns[1].max(*stamp_ns)];
            }
            _ => self.put(child, parent, *fixed, false, *stamp_ns),
        }
    }

    /// Takes in a transform of the configuration.
    pub(crate) fn state(&mut self, parent: &str, child: &str) {
        self.put(child, parent, true, true, 0);
    }

    fn put(&mut self, child: &str, parent: &str, fixed: bool, stated: bool, stamp_ns: u64) {
        if self.links.len() < MAX_FRAMES || self.links.contains_key(child) {
            let link = Link { parent: parent.into(), fixed, stated, count: 1, span_ns: [stamp_ns; 2] };
            self.links.insert(child.into(), link);
        }
    }

    /// Whether a frame is a child or a parent.
    pub(crate) fn knows(&self, frame: &str) -> bool {
        self.links.contains_key(frame) || self.links.values().any(|link| link.parent == frame)
    }

    /// Whether the recording has any transform.
    pub(crate) fn is_recorded(&self) -> bool {
        self.links.values().any(|link| !link.stated)
    }

    fn has_fixed(&self) -> bool {
        self.links.values().any(|link| link.fixed && !link.stated)
    }

    /// Frames with their links, by name.
    pub(crate) fn links(&self) -> impl Iterator<Item = (&str, &Link)> {
        self.links.iter().map(|(child, link)| (child.as_str(), link))
    }

    /// Frames without a parent, by name.
    pub(crate) fn roots(&self) -> Vec<&str> {
        let parents = self.links.values().map(|link| link.parent.as_str());
        let mut roots: Vec<_> = parents.filter(|parent| !self.links.contains_key(*parent)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots
    }

    /// Children of a frame, by name.
    pub(crate) fn children<'a>(&'a self, frame: &'a str) -> impl Iterator<Item = &'a str> {
        self.links().filter(move |(_, link)| link.parent == frame).map(|(child, _)| child)
    }

    /// A frame, its parent and so on; up to the root, or once around a loop.
    fn chain<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let mut chain = vec![frame];
        let mut at = frame;
        while let Some(link) = self.links.get(at).filter(|_| chain.len() < MAX_DEPTH) {
            at = &link.parent;
            let is_loop = chain.contains(&at);
            chain.push(at);
            if is_loop {
                break;
            }
        }
        chain
    }

    fn root<'a>(&'a self, frame: &'a str) -> &'a str {
        self.chain(frame).last().copied().unwrap_or(frame)
    }

    /// All trees in a line: `map -> odom -> base_link -> {camera, lidar}; and apart: world -> mocap`.
    pub(crate) fn text(&self) -> String {
        let mut listed = 0;
        let roots = self.roots();
        let trees = roots.iter().take(MAX_LISTED).map(|root| self.tree_text(root, &mut listed, 0));
        let mut text = trees.filter(|tree| !tree.is_empty()).collect::<Vec<_>>().join("; and apart: ");
        let all = self.links.len() + roots.len();
        if listed < all {
            // Frames of loops have no root. Writing into a String cannot fail.
            let _ = write!(text, " ({} more frames)", all - listed);
        }
        text
    }

    fn tree_text(&self, frame: &str, listed: &mut usize, depth: usize) -> String {
        if *listed >= MAX_LISTED || depth >= MAX_DEPTH {
            return String::new();
        }
        *listed += 1;
        let children: Vec<&str> = self.children(frame).collect();
        let children = children.into_iter().map(|child| self.tree_text(child, listed, depth + 1));
        let children: Vec<_> = children.filter(|child| !child.is_empty()).collect();
        match &children[..] {
            [] => frame.into(),
            [only] => format!("{frame} -> {only}"),
            several => format!("{frame} -> {{{}}}", several.join(", ")),
        }
    }

    /// A known frame that another name may mean: the same but for a namespace or capital letters.
    fn alike(&self, name: &str) -> Option<&str> {
        let all = self.links.iter().flat_map(|(child, link)| [child.as_str(), link.parent.as_str()]);
        let mut alike: Vec<_> = all.filter(|known| is_alike(known, name)).collect();
        alike.sort_unstable_by_key(|known| (known.len(), *known));
        alike.first().copied()
    }

    /// Why a sensor has no poses and what to do about it; `None` where it has some, and lacks others only for a while.
    pub(crate) fn explain(&self, posing: &Posing, asked: &Asked<'_>) -> Option<String> {
        let (frame, error) = posing.first.as_ref().filter(|_| posing.posed == 0)?;
        let reason = match error {
            TransformError::Loop { frame } => self.explain_loop(frame),
            TransformError::Disconnected => self.explain_parts(frame, asked),
            TransformError::Past { child } | TransformError::Future { child } => {
                self.explain_times(child, posing, matches!(error, TransformError::Future { .. }))?
            }
        };
        Some(format!("no pose of `{frame}` in `{}`: {reason}", asked.map_frame))
    }

    fn explain_loop(&self, frame: &str) -> String {
        let chain = self.chain(frame);
        let end = chain.last().copied().unwrap_or(frame);
        match chain.iter().position(|at| *at == end) {
            Some(around) if around + 1 < chain.len() => format!(
                "the transforms form a loop ({}): two publishers disagree on a frame's parent",
                chain[around..].join(" -> ")
            ),
            _ => format!("its chain of parents is longer than {MAX_DEPTH} frames"),
        }
    }

    fn explain_parts(&self, frame: &str, asked: &Asked<'_>) -> String {
        if !self.is_recorded() {
            return self.explain_none(frame, asked);
        }
        let mut advice = Vec::new();
        let (map, base) = (asked.map_frame, asked.base_frame);
        let likely_base = self.likely_base(base);
        let frame_key = match asked.kind {
            SensorKind::Camera => "camera_frame",
            SensorKind::Lidar => "lidar_frame",
        };
        let mut anchor = frame;
        if !self.knows(frame) {
            match self.alike(frame) {
                Some(alike) => {
                    anchor = alike;
                    advice.push(format!("there is no `{frame}`, but `{alike}`: set {frame_key}: {alike}"));
                }
                None => {
                    anchor = likely_base.unwrap_or(map);
                    let advice_to_state = self.advice_to_state(frame, anchor);
                    advice.push(format!("nothing says where `{frame}` is: {advice_to_state}"));
                }
            }
        }
        if !self.knows(map) {
            advice.push(self.explain_no_map(frame, anchor, asked));
        } else if self.knows(frame) {
            advice.push(self.explain_apart(map, frame, likely_base));
        }
        format!("the recording's frames are {}; {}", self.text(), advice.join("; "))
    }

    fn explain_no_map(&self, frame: &str, anchor: &str, asked: &Asked<'_>) -> String {
        let (map, base) = (asked.map_frame, asked.base_frame);
        let chain = self.chain(anchor);
        let alike = chain.iter().rev().find(|above| is_alike(above, map)).copied();
        let root = chain.last().copied().unwrap_or(anchor);
        let moves = if self.knows(frame) {
            chain.iter().any(|at| self.links.get(*at).is_some_and(|link| !link.fixed))
        } else {
            self.links.values().any(|link| !link.fixed)
        };
        if alike.is_none() && !moves {
            if !asked.odometry.is_empty() {
                return format!("none of them moves, but there is {}", asked.odometry);
            }
            return format!(
                "there is no `{map}`, and none of them moves: record what says how the robot does, or state `{map}` from `{root}` \
                 in static_transforms ({{parent: {map}, child: {root}, ...}}) where it stood still"
            );
        }
        let top = alike.unwrap_or(root);
        let moving = self.moving_child(anchor, top).filter(|moving| *moving != frame && !self.knows(base));
        let and_base = moving.map(|moving| format!("; there is no `{base}`: set base_frame: {moving}"));
        format!("there is no `{map}`: set map_frame: {top}{}", and_base.unwrap_or_default())
    }

    fn explain_apart(&self, map: &str, frame: &str, likely_base: Option<&str>) -> String {
        let (a, b) = (self.root(map), self.root(frame));
        if a == b {
            return format!("the transforms between `{map}` and `{frame}` came after the sensor's messages");
        }
        let parent = likely_base.filter(|base| self.root(base) == a).unwrap_or(a);
        let advice = self.advice_to_state(b, parent);
        format!(
            "`{map}` and `{frame}` are in parts that nothing connects (their roots are `{a}` and `{b}`): {advice}"
        )
    }

    /// What to say where `child` has no transform.
    fn advice_to_state(&self, child: &str, parent: &str) -> String {
        let none = if self.has_fixed() {
            ""
        } else {
            "no static transforms were recorded (/tf_static); record them, or "
        };
        format!("{none}state it in static_transforms ({{parent: {parent}, child: {child}, ...}})")
    }

    /// The configured base, or a frame that may be it; a root where no name says so.
    fn likely_base<'a>(&'a self, base: &'a str) -> Option<&'a str> {
        let named = self.links.keys().filter(|frame| frame.contains("base"));
        let named = named.min_by_key(|frame| self.chain(frame).len()).map(String::as_str);
        let configured = Some(base).filter(|base| self.knows(base));
        configured.or_else(|| self.alike(base)).or(named).or_else(|| self.roots().first().copied())
    }

    /// The topmost frame between a frame and `top` that moves, which a robot's base does.
    fn moving_child<'a>(&'a self, frame: &'a str, top: &str) -> Option<&'a str> {
        let chain = self.chain(frame);
        let below = chain.iter().rev().skip_while(|at| **at != top).skip(1);
        let mut moving = below.copied().filter(|at| self.links.get(*at).is_some_and(|link| !link.fixed));
        // Where `odom` moves in `map`, the base moves in `odom`.
        moving.find(|at| !at.contains("odom"))
    }

    fn explain_none(&self, frame: &str, asked: &Asked<'_>) -> String {
        let stated: Vec<_> = self
            .links()
            .map(|(child, link)| format!("{} -> {child}", link.parent))
            .take(MAX_LISTED)
            .collect();
        let example = format!(
            "{{parent: {}, child: {frame}, translation_m: [x, y, z], rotation_xyzw: [x, y, z, w]}}",
            asked.map_frame
        );
        let ahead = match asked.kind {
            SensorKind::Camera => " (rotation [-0.5, 0.5, -0.5, 0.5]: a camera that looks along x)",
            SensorKind::Lidar => "",
        };
        if stated.is_empty() {
            let without = asked.without_transforms;
            return format!("{without}; state where it is in static_transforms: {example}{ahead}");
        }
        format!(
            "{}, and static_transforms ({}) do not lead from one to the other; the missing one has the form {example}",
            asked.without_transforms,
            stated.join(", ")
        )
    }

    /// Stamps that transforms do not cover.
    fn explain_times(&self, child: &str, posing: &Posing, is_future: bool) -> Option<String> {
        let Link { parent, span_ns: [first_ns, last_ns], .. } = self.links.get(child)?;
        let [from_ns, to_ns] = posing.span_ns;
        let span = format!(
            "`{parent}` -> `{child}` is known from {} to {} s, and its messages are stamped {} to {} s",
            seconds(*first_ns),
            seconds(*last_ns),
            seconds(from_ns),
            seconds(to_ns)
        );
        let (apart_ns, how) = if is_future {
            (from_ns.saturating_sub(*last_ns), "after the last transform")
        } else {
            (first_ns.saturating_sub(to_ns), "before the first transform")
        };
        let advice = if (*last_ns < SIMULATED_NS) != (to_ns < SIMULATED_NS) {
            "one clock is a simulator's and the other is not: record with use_sim_time in all nodes"
        } else if apart_ns > 1_000_000_000 {
            "the clocks of the two computers differ, or one part was not recorded"
        } else {
            "transform_tolerance_s bounds how long the last transform may be held"
        };
        Some(format!("{span}, {} s {how}: {advice}", seconds(apart_ns)))
    }
}

/// Whether two names are the same but for a namespace or capital letters.
fn is_alike(a: &str, b: &str) -> bool {
    let last = |name: &str| name.rsplit('/').next().unwrap_or(name).to_lowercase();
    let prefixed = |a: &str, b: &str| a.strip_suffix(b).is_some_and(|rest| rest.ends_with(['/', '_']));
    a != b && !a.is_empty() && !b.is_empty() && (last(a) == last(b) || prefixed(a, b) || prefixed(b, a))
}

/// Nanoseconds as seconds with three decimals, exactly.
fn seconds(ns: u64) -> String {
    format!("{}.{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000)
}
