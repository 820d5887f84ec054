//! Odometry in place of tf's own transform of the same frame.

use crate::config::Config;
use crate::input::ReadReport;
use crate::input::event::TransformEvent;
use crate::message::bare_name;

/// Tells which of a log's transforms give way to those of `odometry_topic`.
#[derive(Debug)]
pub(super) struct Odometry {
    map_frame: String,
    base_frame: String,
    /// Frame that odometry gives the pose of; the base until the first message says.
    child: String,
    /// Whether a message has said so.
    said: bool,
    /// A fixed transform of the base that came before the first message, as these come once only.
    held: Option<TransformEvent>,
}

impl Odometry {
    pub(super) fn new(config: &Config) -> Self {
        Self {
            map_frame: bare_name(&config.map_frame).into(),
            base_frame: bare_name(&config.base_frame).into(),
            child: bare_name(&config.base_frame).into(),
            said: false,
            held: None,
        }
    }

    /// The transforms to take in for one of odometry; frames other than the configured ones are noted.
    pub(super) fn take(&mut self, transform: TransformEvent, report: &mut ReadReport) -> Vec<TransformEvent> {
        if (&transform.parent, &transform.child) != (&self.map_frame, &self.base_frame) {
            report.note(format!(
                "odometry gives `{}` from `{}`, not `{}` from `{}` as configured (map_frame, base_frame)",
                transform.parent, transform.child, self.map_frame, self.base_frame
            ));
        }
        self.said = true;
        self.child.clone_from(&transform.child);
        let held = self.held.take().filter(|held| held.child != transform.child);
        held.into_iter().chain([transform]).collect()
    }

    /// Leaves out tf's own transform of odometry's frame.
    pub(super) fn leave_out(&mut self, transforms: &mut Vec<TransformEvent>) {
        transforms.retain(|transform| {
            let own = transform.child == self.child;
            if own && transform.fixed && !self.said {
                self.held = Some(transform.clone());
            }
            !own
        });
    }
}
