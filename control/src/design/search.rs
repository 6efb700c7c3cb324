//! The search for the best controller on given plants.

use crate::Error;
use crate::design::aim::Aim;
use crate::design::objective::{CROSSOVER_TIMES_SETTLING, Objective, VARIABLES};
use crate::design::optimise::{Effort, minimise, sequence};
use vehicle_models::PidParameters;

/// Digits of the gains, and where those just miss a requirement.
pub(crate) const READABLE_DIGITS: i32 = 5;
pub(crate) const EXACT_DIGITS: i32 = 12;

/// Where a search begins, about a multiple of the objective's scale: a guess and `count` others.
pub(crate) fn starts(objective: &Objective, multiple: f64, count: u32, seed: u64) -> Vec<Vec<f64>> {
    let (t, ts) = (multiple * objective.scale, objective.sample_time);
    // A crossover that settles in time, a reset that forgets an offset within the 5 s, a little
    // lead; and the lag of a fast pole at the crossover, which cancels the slow pole of the reset.
    let crossover = CROSSOVER_TIMES_SETTLING / t;
    let guess = [crossover, 0.8 / t, 0.05 * t, 0.01 * t + ts, 0.2 * t].map(f64::ln);
    let ranges = [(3.0, 10.0), (0.3, 1.5), (0.02, 0.3), (0.01, 0.05), (0.1, 0.4)];
    let mut box_ = [(0.0, 0.0); VARIABLES];
    for (i, ((low, high), bounds)) in ranges.into_iter().zip(objective.bounds()).enumerate() {
        let unit = if i < 2 { 1.0 / t } else { t };
        box_[i] = ((low * unit).max(bounds.0).ln(), (high * unit).min(bounds.1).max(bounds.0).ln());
    }
    let mut starts = vec![guess.to_vec()];
    starts.extend(sequence(&box_, count, seed));
    starts
}

/// The decision variables of the controllers found for an aim, from the best on.
pub(crate) fn search(
    objective: &Objective,
    aim: &Aim,
    starts: &[Vec<f64>],
    effort: Effort,
) -> Result<Vec<Vec<f64>>, Error> {
    let found = minimise(&|x, most| objective.cost(x, aim, most), starts, effort)?;
    Ok(found.into_iter().map(|(x, _)| x).collect())
}

/// Gains rounded to some significant digits.
pub(crate) fn rounded(pid: &PidParameters, digits: i32) -> PidParameters {
    let round = |value| significant(value, digits);
    PidParameters {
        kp: round(pid.kp),
        ki: round(pid.ki),
        kd: round(pid.kd),
        derivative_filter_time: round(pid.derivative_filter_time),
        setpoint_weight_proportional: round(pid.setpoint_weight_proportional),
        anti_windup_time: round(pid.anti_windup_time),
        ..*pid
    }
}

/// A number to some significant digits.
pub(crate) fn significant(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10.0_f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    // Dividing keeps decimal numbers short: 0.3 and not 0.30000000000000004.
    (value * scale).round() / scale
}
