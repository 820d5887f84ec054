//! The map's time: the newest stamp of any sensor, and which sensors are behind it.

/// When each sensor was last heard of.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    last_ns: Vec<Option<u64>>,
}

impl Clock {
    pub(super) fn new(sensors: usize) -> Self {
        Self { last_ns: vec![None; sensors] }
    }

    /// Takes on a sensor's stamp.
    pub(super) fn observe(&mut self, sensor: usize, stamp_ns: u64) {
        if let Some(last_ns) = self.last_ns.get_mut(sensor) {
            *last_ns = Some(stamp_ns);
        }
    }
}
