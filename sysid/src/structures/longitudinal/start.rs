//! What the estimation begins with: the schedules that it compares, and the priors.

use crate::linalg::bounded_step::Normal;
use crate::structures::longitudinal::model::{
    BRAKE_DELAY, BRAKE_GAIN, BRAKE_LAG, COUNT, DELAY, DRAG, GAINS, GRADE, LAG, PEDAL, RESISTANCE,
    RESISTANCE_PER_SPEED, Schedule,
};
use crate::structures::longitudinal::signals::{Piece, Signals};

/// Numbers of gains over the speed that are tried.
const SPEED_GAINS: [usize; 4] = [2, 3, 4, 6];
/// Least distance between the speeds of two gains, m/s.
const LEAST_SPACING_MPS: f64 = 3.0;
/// The schedules that are tried beside a constant gain.
pub(super) fn schedules(signals: &Signals<'_>, pieces: &[Piece]) -> Vec<Schedule> {
    let mut speeds: Vec<f64> = Vec::new();
    for piece in pieces {
        for k in piece.range.clone() {
            if signals.log.input[k].abs() > 0.02 {
                speeds.push(signals.mean_speed[k]);
            }
        }
    }
    speeds.sort_by(f64::total_cmp);
    let mut all = Vec::new();
    if !speeds.is_empty() {
        let at = |share: f64| speeds[(share * (speeds.len() - 1) as f64).round() as usize];
        let (low, high) = (at(0.03), at(0.97));
        for count in SPEED_GAINS {
            let spacing = (high - low) / (count - 1) as f64;
            if spacing >= LEAST_SPACING_MPS {
                let knots = (0..count).map(|i| low + i as f64 * spacing).collect();
                all.push(Schedule::Speeds(knots));
            }
        }
    }
    if (2..=GAINS).contains(&signals.gears.len()) {
        all.push(Schedule::Gears(signals.gears.clone()));
    }
    all
}

/// Weak priors: they keep what the drive does not determine where vehicles have it.
pub(super) fn priors(signals: &Signals<'_>) -> [Normal; COUNT] {
    let normal = |mean, deviation, bounds| Normal { mean, deviation, bounds };
    let gain = match signals.is_acceleration {
        true => normal(1.0, 30.0, [-1e3, 1e3]),
        false => normal(3.0, 30.0, [-1e3, 1e3]),
    };
    let mut priors = [gain; COUNT];
    let brake = if signals.brake.is_some() { 8.0 } else { 0.0 };
    priors[BRAKE_GAIN] = normal(brake, 60.0, [-1e3, 1e3]);
    priors[LAG] = normal(0.3, 1.0, [0.005, 5.0]);
    priors[DELAY] = normal(0.1, 0.5, [0.0, 1.0]);
    priors[BRAKE_LAG] = normal(0.15, 0.3, [0.005, 3.0]);
    priors[BRAKE_DELAY] = normal(0.1, 0.2, [0.0, 1.0]);
    priors[RESISTANCE] = normal(0.15, 1.0, [-10.0, 10.0]);
    priors[RESISTANCE_PER_SPEED] = normal(0.0, 0.05, [-1.0, 1.0]);
    priors[DRAG] = normal(4e-4, 6e-4, [-0.02, 0.02]);
    // From −1 to 1 more of the pedal drives more.
    priors[PEDAL] = normal(0.0, 0.5, [-0.9, 0.9]);
    priors[GRADE] = normal(1.0, 0.5, [-3.0, 3.0]);
    priors
}
