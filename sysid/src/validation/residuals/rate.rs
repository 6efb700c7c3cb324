//! Whether the log is fast enough for the vehicle. Folded and interpolated content is small where
//! the rate is many times the bandwidth: of simulated cars of 2 to 4 Hz bandwidth the identified
//! response from 0.1 to 2 Hz is wrong by 2 % at 20 Hz and by 4 % at 10 Hz (`cargo xtask evaluate
//! response`).

use steerwright_formats::{ChannelSummary, Grade, Intersample, Reason, ReasonCode};

/// Samples in a period of the bandwidth below which a design is doubtful, and below which there is none.
const DOUBTFUL: f64 = 5.0;
const TOO_FEW: f64 = 2.5;

/// The reason against a slow log: of the sampled channels, held commands apart, the slowest counts.
pub(crate) fn slow_log(channels: &[ChannelSummary], bandwidth_hz: f64) -> Option<(Reason, String)> {
    let sampled = channels.iter().filter(|c| match c.role.as_str() {
        "steering" => c.intersample != Some(Intersample::Zoh),
        "yaw_rate" => true,
        _ => false,
    });
    let slowest = sampled.min_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz))?;
    let ratio = slowest.rate_hz / bandwidth_hz;
    let (grade, limit) = match ratio {
        r if r < TOO_FEW => (Grade::Fail, TOO_FEW),
        r if r < DOUBTFUL => (Grade::Warn, DOUBTFUL),
        _ => return None,
    };
    let message = format!(
        "column `{}` is sampled at {:.0} Hz, {ratio:.1} times the bandwidth of the vehicle ({bandwidth_hz:.1} Hz), below {limit:.1} times",
        slowest.column, slowest.rate_hz
    );
    let reason = Reason::new(ReasonCode::SlowLog, grade, message).compared(ratio, limit, "");
    let advice = "log steering and yaw rate faster, or filter them before they are sampled";
    Some((reason, advice.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(role: &str, rate_hz: f64, intersample: Intersample) -> ChannelSummary {
        ChannelSummary {
            role: role.into(),
            column: role.into(),
            unit: "rad".into(),
            rows: 1000,
            rate_hz,
            intersample: Some(intersample),
            along_lines: false,
            min: -1.0,
            mean: 0.0,
            max: 1.0,
            resolution: None,
            spikes_s: Vec::new(),
            frozen_s: Vec::new(),
        }
    }

    #[test]
    fn the_slowest_sampled_channel_counts() {
        let of = |steering: f64, held: Intersample, yaw_rate: f64| {
            let channels = [
                channel("steering", steering, held),
                channel("yaw_rate", yaw_rate, Intersample::Bl),
            ];
            slow_log(&channels, 2.0).map(|(r, _)| r.grade)
        };
        assert_eq!(of(100.0, Intersample::Bl, 100.0), None);
        assert_eq!(of(7.0, Intersample::Bl, 100.0), Some(Grade::Warn));
        assert_eq!(of(100.0, Intersample::Bl, 4.0), Some(Grade::Fail));
        assert_eq!(of(4.0, Intersample::Zoh, 100.0), None);
    }
}
