//! Reasons that lie in the recording: faults of channels, play of the steering, clocks, offsets.

use crate::validation::faults::clocks::LARGEST_DELAY_S;
use steerwright_formats::{ChannelSummary, Grade, Reason, ReasonCode, SteeringPlay};

/// Share of spikes beyond which a sensor or its bus is broken, and smaller ones go unseen.
const MOST_SPIKES: f64 = 1e-3;
/// A gyro that is frozen for that share of the log cannot be relied on in the rest.
const MOST_FROZEN: f64 = 0.1;
/// Play that makes a yaw loop hunt visibly, deg: 0.5 °/s of yaw rate at 20 m/s.
const NOTICED_PLAY_DEG: f64 = 0.1;
/// Half the play over the steering's amplitude that turns the phase by 15°: no model holds.
const MOST_PLAY: f64 = 0.3;
/// Yaw rate when driving straight, deg/s; gyros of production cars are zeroed to 0.3 °/s.
const MOST_OFFSET_DEGPS: f64 = 0.7;
/// Standard deviation of rounding, step/√12, over that of the signal: beyond, it shows in the fit.
const COARSE: f64 = 0.02;
/// … of the steering, whose rounding biases the gain by the square of it: by 1 %.
const COARSE_STEERING: f64 = 0.1;
/// Share of the noise's variance from which rounding dominates it.
const DOMINATES: f64 = 0.5;
/// A yaw rate that leads by more costs a controller 10° of phase at 1 Hz.
const LARGEST_LEAD_S: f64 = 0.03;

/// The properties of a recording that do not depend on the identified model.
pub(crate) struct Recorded<'a> {
    pub(crate) channels: &'a [ChannelSummary],
    pub(crate) play: Option<&'a SteeringPlay>,
    /// Delay of accumulated drives, whose clocks are not compared sample by sample.
    pub(crate) delay_in_windows_s: Option<f64>,
    pub(crate) yaw_rate_lead_s: Option<f64>,
    pub(crate) yaw_rate_lag_s: Option<f64>,
    pub(crate) road_wheel_std_rad: f64,
    pub(crate) yaw_rate_std_radps: f64,
    pub(crate) steering_ratio: f64,
    pub(crate) noise_radps: f64,
    /// Length without what was left out, s.
    pub(crate) seconds: f64,
    /// Road-wheel angle that driving straight would need, rad.
    pub(crate) road_wheel_offset_rad: f64,
    /// The yaw rate that driving straight would read, rad/s.
    pub(crate) yaw_rate_offset_radps: f64,
}

pub(crate) fn faults(of: &Recorded<'_>) -> Vec<(Reason, String)> {
    let mut out = Vec::new();
    for channel in of.channels {
        spikes(channel, &mut out);
        frozen(channel, of, &mut out);
        coarse(channel, of, &mut out);
    }
    play(of, &mut out);
    clocks(of, &mut out);
    let degrees = of.yaw_rate_offset_radps.to_degrees();
    if !is_yaw_rate_of_yaw(of) && degrees.abs() > MOST_OFFSET_DEGPS {
        let wheel = of.road_wheel_offset_rad.to_degrees();
        let message = format!(
            "driving straight reads {degrees:.2} °/s of yaw rate, or needs {wheel:.2}° at the road wheel"
        );
        let advice = "a bias of the gyro and a wrong zero of the steering angle look alike: record the gyro at standstill, subtract its mean there, and zero the steering on a straight; an integrated yaw drifts by the bias";
        let compared = (degrees.abs(), MOST_OFFSET_DEGPS, "deg/s");
        out.push(fault((ReasonCode::Offset, Grade::Warn), message, compared, advice));
    }
    out
}

/// A reason with its number, limit and unit, and what to do about it.
fn fault(
    (code, grade): (ReasonCode, Grade),
    message: String,
    (value, limit, unit): (f64, f64, &str),
    advice: impl Into<String>,
) -> (Reason, String) {
    (Reason::new(code, grade, message).compared(value, limit, unit), advice.into())
}

/// Whether the yaw rate was differenced from a yaw, which no bias of a gyro is in.
fn is_yaw_rate_of_yaw(of: &Recorded<'_>) -> bool {
    of.channels.iter().any(|c| c.role == "yaw_rate" && matches!(c.unit.as_str(), "deg" | "rad"))
}

fn spikes(channel: &ChannelSummary, out: &mut Vec<(Reason, String)>) {
    let share = channel.spikes_s.len() as f64 / channel.rows.max(1) as f64;
    if share > MOST_SPIKES {
        let message = format!(
            "the column {} has {} spikes or dropouts, the first at {:.3} s",
            channel.column,
            channel.spikes_s.len(),
            channel.spikes_s[0]
        );
        let compared = (channel.spikes_s.len() as f64, MOST_SPIKES * channel.rows as f64, "");
        let advice = "check the sensor, its plug and the bus for lost or corrupted messages";
        out.push(fault((ReasonCode::Spikes, Grade::Warn), message, compared, advice));
    }
}

fn frozen(channel: &ChannelSummary, of: &Recorded<'_>, out: &mut Vec<(Reason, String)>) {
    let Some(first) = channel.frozen_s.first() else { return };
    let lost: f64 = channel.frozen_s.iter().map(|[a, b]| b - a).sum();
    let recorded = of.seconds + lost;
    let limit = MOST_FROZEN * recorded;
    let grade = if lost > limit { Grade::Fail } else { Grade::Warn };
    let message = format!(
        "the yaw rate (column {}) is frozen for {lost:.1} s in all while the vehicle is steered, first from {:.2} to {:.2} s",
        channel.column, first[0], first[1]
    );
    let advice = "check the gyro, its plug and the bus; the frozen samples were left out, shorter dropouts may remain";
    out.push(fault((ReasonCode::FrozenYawRate, grade), message, (lost, limit, "s"), advice));
}

fn coarse(channel: &ChannelSummary, of: &Recorded<'_>, out: &mut Vec<(Reason, String)>) {
    let Some(step) = channel.resolution else { return };
    let rounding = step / 12_f64.sqrt();
    let (spread, limit) = match channel.role.as_str() {
        "yaw_rate" if !is_yaw_rate_of_yaw(of) => {
            let noise = of.noise_radps;
            if rounding * rounding < DOMINATES * noise * noise {
                return;
            }
            (of.yaw_rate_std_radps, COARSE)
        }
        "steering" => (of.road_wheel_std_rad * of.steering_ratio, COARSE_STEERING),
        _ => return,
    };
    let share = rounding / spread;
    if share > limit {
        let message = format!(
            "the column {} is quantised to {:.3}°, which is {:.1} % of its signal as noise",
            channel.column,
            step.to_degrees(),
            100.0 * share
        );
        let advice = format!(
            "log {} with a finer resolution (quantisation dominates its noise), or steer more strongly",
            channel.column
        );
        let compared = (100.0 * share, 100.0 * limit, "%");
        out.push(fault((ReasonCode::CoarseResolution, Grade::Warn), message, compared, advice));
    }
}

fn play(of: &Recorded<'_>, out: &mut Vec<(Reason, String)>) {
    let Some(play) = of.play else { return };
    let degrees = play.road_wheel_rad.to_degrees();
    if degrees < NOTICED_PLAY_DEG {
        return;
    }
    let amplitude = std::f64::consts::SQRT_2 * of.road_wheel_std_rad;
    let far = 0.5 * play.road_wheel_rad > MOST_PLAY * amplitude;
    let grade = if far { Grade::Fail } else { Grade::Warn };
    let message = format!(
        "the steering has {degrees:.2} ± {:.2}° of play at the road wheel",
        2.0 * play.standard_error_rad.to_degrees()
    );
    let limit = if far { (2.0 * MOST_PLAY * amplitude).to_degrees() } else { NOTICED_PLAY_DEG };
    let cycle = match play.limit_cycle {
        Some(c) => {
            format!(
                "a yaw loop that settles in a second is expected to hunt by ±{:.2}° at the road wheel and ±{:.2}° of yaw with a period of {:.1} s (describing function of play)",
                c.road_wheel_rad.to_degrees(),
                c.yaw_rad.to_degrees(),
                c.period_s
            )
        }
        None => "a yaw loop of moderate gain is expected to come to rest within it".to_owned(),
    };
    let advice = format!(
        "play (lash) between the recorded steering angle and the road wheels: {cycle}; take the play out, or measure the angle behind it"
    );
    out.push(fault((ReasonCode::SteeringPlay, grade), message, (degrees, limit, "deg"), advice));
}

fn clocks(of: &Recorded<'_>, out: &mut Vec<(Reason, String)>) {
    if let Some(lead) = of.yaw_rate_lead_s {
        let grade = if lead > LARGEST_LEAD_S { Grade::Fail } else { Grade::Warn };
        let message = format!(
            "the yaw rate comes at least {:.0} ms before the steering that causes it",
            1e3 * lead
        );
        let limit = if grade == Grade::Fail { LARGEST_LEAD_S } else { 0.0 };
        let advice = "the clocks of the channels are apart: the steering is stamped late, or the yaw rate early; align them, or record both with one clock";
        out.push(fault((ReasonCode::EarlyYawRate, grade), message, (lead, limit, "s"), advice));
    }
    // Play delays the wheels by itself, and what is early is not late too.
    let has_play = of.play.is_some_and(|play| play.road_wheel_rad.to_degrees() >= NOTICED_PLAY_DEG);
    if has_play || of.yaw_rate_lead_s.is_some() {
        return;
    }
    let in_windows = of.delay_in_windows_s.filter(|delay| *delay > LARGEST_DELAY_S);
    if let Some(late) = of.yaw_rate_lag_s.or(in_windows) {
        let message = format!(
            "the yaw rate follows the steering {:.0} ms late, later than a vehicle's",
            1e3 * late
        );
        let advice = "the clocks of the channels may be apart (yaw rate stamped late), the gyro filtered, or the steering a command to a slow actuator: record both channels with one clock, or log the angle that was reached";
        let compared = (late, LARGEST_DELAY_S, "s");
        out.push(fault((ReasonCode::LateYawRate, Grade::Warn), message, compared, advice));
    }
}
