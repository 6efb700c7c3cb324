//! The parts of a cost, its lower bound, and the bounds on a response that follow from it.

use crate::closed_loop::early_stopping::StoppingBounds;
use crate::closed_loop::metrics::LEAVING;
use crate::design::objective::Objective;
use crate::design::target::Target;
use steerwright_formats::{Margins, PidGains, Requirement};
use steerwright_models::PidParameters;

/// Weight of the logarithm of the settling time, the longest of all plants.
const SETTLING_WEIGHT: f64 = 2.0;
/// Modulus margin beyond which more is not rewarded, and the cost of one that is short of it by 1: a tenth
/// of the margin for a seventh of the settling time.
const MODULUS_ENOUGH: f64 = 0.7;
const MODULUS_WEIGHT: f64 = 3.0;
/// Weight of the other measures of speed: lag behind a ramp and integral of absolute error.
const SPEED_WEIGHT: f64 = 0.5;
/// Weight of violations against the rest of the cost, which is about 1.
const VIOLATION_WEIGHT: f64 = 100.0;
/// Where a requirement is relaxed: weight of its slack, small enough that no other requirement is violated for
/// it, and of the rest of the cost.
const SLACK_WEIGHT: f64 = 4.0;
const REST_WEIGHT: f64 = 0.1;
/// Shortest settling time, s, of which the logarithm is taken.
const LEAST_SETTLING: f64 = 1e-9;
/// An overshoot that counts as none, percent.
const NO_OVERSHOOT: f64 = 1e-8;

#[derive(Clone, Copy)]
pub(crate) struct Parts {
    pub(crate) violation: f64,
    pub(crate) rest: f64,
    /// −∞ where no requirement is relaxed.
    pub(crate) slack: f64,
    /// Longest smooth settling time, s.
    pub(crate) slowest: f64,
}

impl Parts {
    /// Weight of the part that is no requirement.
    fn rest_weight(&self) -> f64 {
        if self.slack.is_finite() { REST_WEIGHT } else { 1.0 }
    }
}

impl Objective {
    /// The cost that consists of these parts.
    pub(super) fn total(&self, parts: &Parts) -> f64 {
        let settling = (parts.slowest.max(LEAST_SETTLING) / self.scale).ln();
        let rest = parts.rest + SETTLING_WEIGHT * settling;
        let rest = match parts.slack.is_finite() {
            true => parts.slack + REST_WEIGHT * rest,
            false => rest,
        };
        VIOLATION_WEIGHT * parts.violation + rest
    }

    /// Whether parts of a cost are a lower bound on it: once the slack of a stable plant is known.
    pub(super) fn is_lower_bound(&self, parts: &Parts, target: &Target) -> bool {
        target.relaxed.is_none() || parts.slack.is_finite()
    }

    /// The smallest cost that the nominal plant can have, whatever its response.
    pub(super) fn least(
        &self,
        pid: &PidParameters,
        margins: &Margins,
        target: &Target,
        parts: Parts,
    ) -> Parts {
        // Half of the step is reached no earlier than half of the first sample.
        let half = LEAVING.0 * target.band * self.spec.settling_band_percent < 50.0;
        let slowest = if half { 0.5 * self.sample_time } else { 0.0 };
        let slack = self.relaxed(target).map_or(f64::NEG_INFINITY, |(relaxed, required)| {
            let best = match relaxed {
                Requirement::Settling => slowest,
                other if other.at_least() => f64::INFINITY,
                _ => 0.0,
            };
            slack(relaxed, target.bound(relaxed, required), best)
        });
        Parts { rest: self.rest(pid, margins, 0.0), slack, slowest, ..parts }
    }

    /// The bounds beyond which the response of a plant makes the cost exceed `most`.
    pub(super) fn stopping_bounds(
        &self,
        target: &Target,
        least: &Parts,
        most: f64,
        other: bool,
    ) -> StoppingBounds {
        let spare = most - self.total(least);
        if spare == f64::INFINITY || !self.is_lower_bound(least, target) {
            return StoppingBounds::NONE;
        }
        let largest = |r: Requirement| {
            let required = r.required(&self.spec).filter(|_| target.applies(r, other));
            required.map_or(f64::INFINITY, |required| {
                target.value_at_violation(r, required, spare / VIOLATION_WEIGHT)
            })
        };
        let overshoot = largest(Requirement::Overshoot) + NO_OVERSHOOT;
        // The largest logarithm of the settling time.
        let of_slowest = least.rest_weight() * SETTLING_WEIGHT;
        let now = of_slowest * least.slowest.max(LEAST_SETTLING).ln();
        let logarithm = match target.relaxed {
            Some(Requirement::Settling) => {
                (now + least.slack + spare) / (of_slowest + SLACK_WEIGHT)
            }
            _ => (now + spare) / of_slowest,
        };
        let band = target.band * self.spec.settling_band_percent / 100.0;
        StoppingBounds {
            highest: 1.0 + 0.01 * overshoot,
            settled: (band, largest(Requirement::Settling)),
            entered: (LEAVING.0 * band, logarithm.exp()),
            decay: None,
        }
    }

    /// The relaxed requirement and its bound in the specification, or 0.
    pub(super) fn relaxed(&self, target: &Target) -> Option<(Requirement, f64)> {
        let relaxed = target.relaxed?;
        Some((relaxed, relaxed.required(&self.spec).unwrap_or(0.0)))
    }

    /// The part of the cost that is no requirement: speed, robustness and noise.
    pub(super) fn rest(
        &self,
        pid: &PidParameters,
        margins: &Margins,
        integral_absolute_error: f64,
    ) -> f64 {
        let t = self.scale;
        let PidGains { kp, ki, kd, derivative_filter_time_s, .. } = pid.gains;
        let lag = kp * (1.0 - pid.gains.setpoint_weight_proportional) / ki;
        let slow = (lag + integral_absolute_error) / t;
        let weak = (MODULUS_ENOUGH - margins.modulus_margin).max(0.0);
        let high_frequency = 1.0 + kd / (kp * (derivative_filter_time_s + pid.sample_time));
        let noise = 0.004 * high_frequency * kp * self.gain;
        SPEED_WEIGHT * slow + MODULUS_WEIGHT * weak + noise
    }
}

/// The weighted slack of a relaxed requirement: the logarithm of its value, no smaller than at its bound.
pub(super) fn slack(relaxed: Requirement, bound: f64, value: f64) -> f64 {
    let ratio = if relaxed.at_least() {
        bound / value.clamp(1e-3 * bound, bound)
    } else {
        value.max(bound).max(1e-9)
    };
    SLACK_WEIGHT * ratio.ln()
}
