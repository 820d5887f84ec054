//! The state of a frame as a ROS diagnostic (spec 1 §5).

use crate::frame::FrameOutput;
use crate::message::ros2::Header;
use crate::message::written::{DiagnosticArray, DiagnosticStatus, KeyValue};
use crate::output::pass_sums_ms;

const LEVEL_OK: u8 = 0;
const LEVEL_WARN: u8 = 1;

/// Level WARN when degraded; low-reliability share, all counters and the passes' milliseconds as values.
pub(super) fn of_frame(output: &FrameOutput, camera_frame: &str) -> DiagnosticArray {
    let percent = output.low_reliability_fraction * 100.0;
    let (level, message) = if output.degraded {
        (
            LEVEL_WARN,
            format!("DEGRADED: {percent:.0} % of the depth pixels are unreliable; slow down or look again"),
        )
    } else {
        (LEVEL_OK, format!("OK: {percent:.0} % of the depth pixels are unreliable"))
    };
    let status = DiagnosticStatus {
        level,
        name: "limpid: depth reliability".into(),
        message,
        hardware_id: camera_frame.to_owned(),
        values: values(output),
    };
    DiagnosticArray { header: Header::new(output.stamp_ns, ""), status: vec![status] }
}

fn values(output: &FrameOutput) -> Vec<KeyValue> {
    let pair = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let mut values = vec![pair("low_reliability_fraction", output.low_reliability_fraction.to_string())];
    if let Ok(serde_json::Value::Object(counters)) = serde_json::to_value(output.counters) {
        values.extend(counters.iter().map(|(key, value)| pair(key, value.to_string())));
    }
    let passes = pass_sums_ms(output).into_iter();
    values.extend(passes.map(|(pass, ms)| pair(&format!("{pass}_ms"), format!("{ms:.4}"))));
    values
}
