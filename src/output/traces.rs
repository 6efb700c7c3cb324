//! The signals of an identification as CSV.

use std::fmt::Write;
use steerwright_sysid::Traces;
use steerwright_sysid::multivariable::ChannelTraces;

/// The signals as CSV; with the yaw rate of a bicycle model where there is one.
pub(crate) fn traces_csv(traces: &Traces, bicycle: Option<&[f64]>) -> String {
    let mut text = String::from(
        "time_s,steering_rad,yaw_rate_radps,simulated_yaw_rate_radps,held_out,yaw_rad,simulated_yaw_rad",
    );
    if bicycle.is_some() {
        text.push_str(",bicycle_yaw_rate_radps");
    }
    text.push('\n');
    for k in 0..traces.time_s.len() {
        let _ = write!(
            text,
            "{},{},{},{},{},{},{}",
            traces.time_s[k],
            traces.steering_rad[k],
            traces.yaw_rate_radps[k],
            traces.simulated_yaw_rate_radps[k],
            u8::from(traces.is_validation[k]),
            traces.yaw_rad[k],
            traces.simulated_yaw_rad[k]
        );
        if let Some(bicycle) = bicycle {
            let _ = write!(text, ",{}", bicycle[k]);
        }
        text.push('\n');
    }
    text
}

/// The signals as CSV: time, inputs, outputs, simulated outputs, and whether the sample is validation data.
pub(crate) fn channels_csv(traces: &ChannelTraces) -> String {
    let mut text = String::from("time_s");
    for (name, _) in &traces.inputs {
        let _ = write!(text, ",{name}");
    }
    for (name, ..) in &traces.outputs {
        let _ = write!(text, ",{name},simulated_{name}");
    }
    text.push_str(",held_out\n");
    for (k, time) in traces.time_s.iter().enumerate() {
        let _ = write!(text, "{time}");
        for (_, samples) in &traces.inputs {
            let _ = write!(text, ",{}", samples[k]);
        }
        for (_, measured, simulated) in &traces.outputs {
            let _ = write!(text, ",{},{}", measured[k], simulated[k]);
        }
        let _ = writeln!(text, ",{}", u8::from(traces.is_validation[k]));
    }
    text
}
