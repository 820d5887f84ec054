//! What comes back from a frame, and where it lands.

use std::sync::Arc;

use crate::base::{Error, Result};
use crate::gpu::plan::{BufferId, Plan};
use crate::gpu::timing::{PassSpan, Timing};

/// A range of a readback slot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Landing {
    pub(crate) id: BufferId,
    pub(crate) offset: u64,
    pub(crate) bytes: u64,
}

/// What came back from one frame.
#[derive(Debug, Clone)]
pub struct Readback {
    pub(crate) data: Vec<u8>,
    pub(crate) landings: Vec<Landing>,
    /// Name and time span of each pass, when the device was opened for profiling.
    pub spans: Vec<(Arc<str>, PassSpan)>,
}

impl Readback {
    /// The ranges of a slot.
    pub(crate) fn of(slot: &[u8], landings: Vec<Landing>) -> Self {
        let mut data = Vec::with_capacity(landings.iter().map(|landing| bytes_of(landing.bytes)).sum());
        let mut list = landings;
        for landing in &mut list {
            let start = bytes_of(landing.offset);
            landing.offset = data.len() as u64;
            data.extend_from_slice(slot.get(start..start + bytes_of(landing.bytes)).unwrap_or_default());
        }
        Self { data, landings: list, spans: Vec::new() }
    }

    /// The bytes of a buffer that the plan reads back.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the plan does not read it back.
    pub fn bytes(&self, id: BufferId) -> Result<&[u8]> {
        let range = self.landings.iter().find(|landing| landing.id == id).and_then(|landing| {
            let start = usize::try_from(landing.offset).ok()?;
            self.data.get(start..start + usize::try_from(landing.bytes).ok()?)
        });
        range.ok_or_else(|| Error::Gpu { what: "readback".into(), reason: "buffer was not read back".into() })
    }
}

/// Where each buffer that is read back lands, the pass times last, and the bytes of all.
pub(crate) fn landings(plan: &Plan, timing: Option<&Timing>) -> (Vec<Landing>, u64) {
    let mut offset = 0;
    let mut list = Vec::new();
    let read_back = plan.buffers().iter().enumerate().filter(|(_, buffer)| buffer.read_back);
    let times = timing.map(|t| (plan.buffers().len(), t.resolved.size()));
    for (index, bytes) in read_back.map(|(index, buffer)| (index, buffer.bytes)).chain(times) {
        list.push(Landing { id: BufferId(index), offset, bytes });
        offset = (offset + bytes).next_multiple_of(16);
    }
    (list, offset)
}

fn bytes_of(bytes: u64) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}
