//! The metrics of a step response. Between ticks the response is interpolated linearly.

use crate::closed_loop::simulate::Trace;
use steerwright_formats::StepMetrics;

/// The metrics of the file, and one that only a search uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metrics {
    /// The metrics of the file.
    pub step: StepMetrics,
    /// A settling time without jumps, s: the settling time jumps where a response just leaves its band
    /// again, which a search cannot cross.
    pub(crate) smooth_settling_s: f64,
}

/// Overshoot that counts as rounding, percent.
const ROUNDING_PERCENT: f64 = 1e-9;
/// Largest overshoot reported, percent: that of a diverging loop has no bound.
const RUNAWAY_PERCENT: f64 = 1e4;

/// The metrics of a measured response to a step from 0 to `height`, rad, at time 0, the settling band
/// in percent of it; `None` for an empty trace.
///
/// The error is read at the end of the trace; a response that is outside the band there has no settling time.
#[must_use]
pub fn metrics_of(trace: &Trace, height: f64, band_percent: f64) -> Option<Metrics> {
    let n = trace.time.len();
    if n > 0 && trace.yaw.len() == n { Some(metrics(trace, height, band_percent)) } else { None }
}

/// As [`metrics_of`], for traces of the simulator, which are never empty.
pub(crate) fn metrics(trace: &Trace, height: f64, band_percent: f64) -> Metrics {
    let share = height.recip();
    let y = |k: usize| trace.yaw[k] * share;
    let t = &trace.time;
    let last = t.len() - 1;
    let band = band_percent / 100.0;
    let between = |k: usize, level: f64| {
        // Where the response crosses a level between ticks k and k + 1.
        t[k] + (t[k + 1] - t[k]) * ((level - y(k)) / (y(k + 1) - y(k))).clamp(0.0, 1.0)
    };
    let inside = |k: usize| (y(k) - 1.0).abs() <= band;
    let settling_time_s = match (0..=last).rev().find(|&k| !inside(k)) {
        None => Some(0.0),
        Some(k) if k == last => None,
        Some(k) => Some(between(k, if y(k) > 1.0 { 1.0 + band } else { 1.0 - band })),
    };
    let first_above = |level: f64| {
        (0..=last)
            .find(|&k| y(k) >= level)
            .map(|k| if k == 0 { t[0] } else { between(k - 1, level) })
    };
    let rise_time_s = first_above(0.9).and_then(|high| first_above(0.1).map(|low| high - low));
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut before = trace.steering_before;
    let (mut largest_angle_rad, mut largest_increment_rad) = (0.0_f64, 0.0_f64);
    for &u in &trace.steering {
        largest_angle_rad = larger(largest_angle_rad, u.abs());
        largest_increment_rad = larger(largest_increment_rad, (u - before).abs());
        before = u;
    }
    let (mut peak, mut integral_absolute_error) = (0.0, 0.0);
    let (mut off_before, mut t_before) = ((1.0 - y(0)).abs(), t[0]);
    for (yaw, now) in trace.yaw.iter().zip(t) {
        let reached = yaw * share;
        peak = larger(peak, reached);
        let off = (1.0 - reached).abs();
        integral_absolute_error += 0.5 * (off_before + off) * (now - t_before);
        (off_before, t_before) = (off, *now);
    }
    let overshoot = percent(100.0 * (peak - 1.0));
    Metrics {
        step: StepMetrics {
            overshoot_percent: if overshoot > ROUNDING_PERCENT { overshoot } else { 0.0 },
            settling_time_s,
            steady_state_error_percent: error_percent(trace, height),
            rise_time_s,
            largest_angle_rad,
            largest_increment_rad,
            integral_absolute_error_s: integral_absolute_error,
        },
        smooth_settling_s: smooth_settling(trace, height, band),
    }
}

/// The error at the end of a trace, which must not be empty, percent of the step.
pub(crate) fn error_percent(trace: &Trace, height: f64) -> f64 {
    let last = trace.yaw.len() - 1;
    percent(100.0 * (1.0 - trace.yaw[last] * height.recip()).abs())
}

fn percent(x: f64) -> f64 {
    if x.is_nan() { RUNAWAY_PERCENT } else { x.min(RUNAWAY_PERCENT) }
}

/// Shares of the band at which leaving it again begins to count and at which it counts fully. The smooth
/// settling time is not before the response is within the first.
pub(crate) const LEAVING: (f64, f64) = (0.98, 1.1);

/// The time of entering a slightly tighter band plus a share of the time from there to the last exit, which
/// grows with the distance by which the response leaves it again.
fn smooth_settling(trace: &Trace, height: f64, band: f64) -> f64 {
    let t = &trace.time;
    let last = t.len() - 1;
    let band_at = |share: f64| share * band;
    let share = height.recip();
    let off = |k: usize| (trace.yaw[k] * share - 1.0).abs();
    let tight = band_at(LEAVING.0);
    let Some(entry) = (0..=last).find(|&k| off(k) <= tight) else {
        return t[last] * (1.0 + off(last).min(RUNAWAY_PERCENT));
    };
    let crossing = |outside: usize, inside: usize| {
        let share = (off(outside) - tight) / (off(outside) - off(inside)).max(f64::MIN_POSITIVE);
        t[outside] + (t[inside] - t[outside]) * share.clamp(0.0, 1.0)
    };
    let entry_s = if entry == 0 { t[0] } else { crossing(entry - 1, entry) };
    let Some(exit) = (entry..=last).rev().find(|&k| off(k) > tight) else { return entry_s };
    let exit_s = if exit == last { t[last] } else { crossing(exit, exit + 1) };
    let farthest = (entry..=exit).map(off).fold(0.0, f64::max);
    let share = (farthest - tight) / (band_at(LEAVING.1) - tight);
    entry_s + share.min(1.0) * (exit_s - entry_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(f: impl Fn(f64) -> f64, ts: f64) -> Trace {
        let time: Vec<f64> = (0..=(5.0 / ts).round() as usize).map(|k| k as f64 * ts).collect();
        let yaw: Vec<f64> = time.iter().map(|t| 0.1 * f(*t)).collect();
        let steering = time.iter().map(|t| 0.2 * (-t).exp()).collect();
        let yaw_reference = vec![0.1; time.len()];
        Trace { yaw_reference, time, yaw, steering, steering_before: 0.0 }
    }

    /// ω²/(s² + 2ζω s + ω²): overshoot exp(−πζ/√(1−ζ²)).
    #[test]
    fn a_second_order_response_has_its_textbook_overshoot() {
        for (zeta, omega) in [(0.4, 3.0), (0.6, 5.0), (0.8, 4.0)] {
            let root = f64::sqrt(1.0 - zeta * zeta);
            let wd = omega * root;
            let response = |t: f64| {
                1.0 - (-zeta * omega * t).exp() * ((wd * t).cos() + zeta / root * (wd * t).sin())
            };
            let m = metrics(&trace(response, 0.001), 0.1, 2.0);
            let expected = 100.0 * (-std::f64::consts::PI * zeta / root).exp();
            assert!((m.step.overshoot_percent - expected).abs() < 1e-3);
            // The last crossing of the band, found by bisection-free scanning at 1e-5 s.
            let settled = (0..500_000)
                .rev()
                .map(|i| f64::from(i) * 1e-5)
                .find(|t| (response(*t) - 1.0).abs() > 0.02)
                .unwrap();
            assert!((m.step.settling_time_s.unwrap() - settled).abs() < 5e-5);
            assert!(m.step.largest_increment_rad == 0.2 && m.step.largest_angle_rad == 0.2);
        }
    }

    /// 1 − e^{−t/τ}: settling τ·ln 50, rise τ·ln 9, error e^{−5/τ}, IAE τ·(1 − e^{−5/τ}).
    #[test]
    fn a_first_order_response_has_its_textbook_times() {
        let tau = 0.7;
        let m = metrics(&trace(|t| 1.0 - (-t / tau).exp(), 0.01), 0.1, 2.0);
        assert!((m.step.settling_time_s.unwrap() - tau * 50.0_f64.ln()).abs() < 1e-4);
        assert!((m.step.rise_time_s.unwrap() - tau * 9.0_f64.ln()).abs() < 1e-4);
        let error = (-5.0 / tau).exp();
        assert!((m.step.steady_state_error_percent - 100.0 * error).abs() < 1e-9);
        assert!((m.step.integral_absolute_error_s - tau * (1.0 - error)).abs() < 1e-4);
        assert_eq!(m.step.overshoot_percent, 0.0);
    }

    /// A dip after the rise delays the settling time, the more the deeper it is; within the band it does not
    /// count, and in between nothing jumps.
    #[test]
    fn the_smooth_settling_time_has_no_jumps() {
        let settling = |depth: f64| {
            let dip = move |t: f64| depth * (-((t - 2.0) / 0.3).powi(2)).exp();
            metrics(&trace(|t| 1.0 - (-8.0 * t).exp() - dip(t), 0.01), 0.1, 2.0)
        };
        let rise = settling(0.0).smooth_settling_s;
        assert!((rise - 0.0196_f64.recip().ln() / 8.0).abs() < 1e-3, "{rise}");
        assert!((settling(0.018).smooth_settling_s - rise).abs() < 1e-6);
        let deep = settling(0.03);
        assert!((deep.smooth_settling_s - deep.step.settling_time_s.unwrap()).abs() < 0.02);
        let mut before = rise;
        for i in 0..2000 {
            let now = settling(0.015 + 1e-5 * f64::from(i)).smooth_settling_s;
            assert!(now >= before - 1e-9 && now - before < 0.02, "{i}: {before} {now}");
            before = now;
        }
    }

    /// A steering offset before the step does not count as an increment.
    #[test]
    fn the_largest_increment_is_counted_from_the_steering_before() {
        let mut trace = trace(|t| 1.0 - (-t).exp(), 0.01);
        trace.steering = trace.time.iter().map(|t| 0.3 + 0.1 * t.min(1.0)).collect();
        trace.steering_before = 0.299;
        let step = metrics(&trace, 0.1, 2.0).step;
        assert!((step.largest_increment_rad - 0.001).abs() < 1e-12, "{step:?}");
    }

    #[test]
    fn rounding_is_no_overshoot() {
        let overshoot = |by: f64| {
            metrics(&trace(|t| (1.0 - (-20.0 * t).exp()) * (1.0 + by), 0.01), 0.1, 2.0)
                .step
                .overshoot_percent
        };
        assert_eq!(overshoot(1e-15), 0.0);
        assert!((overshoot(1e-9) - 1e-7).abs() < 1e-9);
    }

    #[test]
    fn a_response_that_never_settles_or_rises_has_no_time() {
        let m = metrics(&trace(|t| 0.5 + 0.01 * t, 0.01), 0.1, 2.0);
        assert_eq!((m.step.settling_time_s, m.step.rise_time_s), (None, None));
        let m = metrics(&trace(|_| f64::NAN, 0.01), 0.1, 2.0);
        assert!(m.step.settling_time_s.is_none() && m.step.steady_state_error_percent > 1e3);
    }
}
