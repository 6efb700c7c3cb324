//! The largest rate of the road wheels, of a servo that its command outruns, as the structures with an actuator find it.
//!
//! It is no parameter until the drive shows it: a drive that does not reach the limit says nothing about it, and the cost has
//! no slope there. So rates below the fastest of the command are tried, with a faster lag, which stands for the limit until
//! then; the best is where the search goes on with the rate as a parameter, where it is better or what it is compared with is so
//! poor that its other parameters say little. The model with the fewer parameters stays unless
//! the other is better by the Bayesian information criterion.

use steerwright_drivelog::signal::standard_deviation;
use steerwright_formats::Prior;

/// The prior of a rate that the drive shows, rad/s: servos of model cars, of road cars and of lorries.
pub(crate) const PRIOR: Prior = Prior { mean: 0.5, standard_deviation: 1.0, min: 0.02, max: 10.0 };

/// Rates that are tried, each as a share of the one before, from that share of the fastest of the command.
const RATES: i32 = 6;
const SHARE: f64 = 0.6;
/// Time constants that are tried with them, over the one that was found without a limit.
const LAGS: [f64; 2] = [0.5, 0.15];
/// Share of the steering's motions that may be faults of the log.
const RARE: f64 = 1e-3;

/// Share of the yaw rate's deviation that a model leaves whose parameters are too far off for a trial to be judged.
const POOR: f64 = 0.1;

/// Whether a model leaves so much of the yaw rate, by its errors.
pub(crate) fn is_poor(yaw_rate: &[f64], errors: &[f64]) -> bool {
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    (squares / errors.len().max(1) as f64).sqrt() > POOR * standard_deviation(yaw_rate)
}

/// Rates with a factor on the time constant that are worth a try, for a command whose fastest is `fastest`, rad/s at the road wheel.
pub(crate) fn trials(fastest: f64) -> impl Iterator<Item = (f64, f64)> {
    let rate = move |power| (fastest * SHARE.powi(power)).clamp(PRIOR.min, PRIOR.max);
    (1..=RATES).flat_map(move |power| LAGS.map(|lag| (rate(power), lag)))
}

/// Whether a logarithm of the posterior density that is higher by `gain` is worth the parameter.
pub(crate) fn is_worth_it(gain: f64, samples: usize) -> bool {
    gain > 0.5 * (samples as f64).ln()
}

/// The fastest of a steering in samples, by its unit and second, but for a share of [`RARE`].
pub(crate) fn fastest<'a>(segments: impl Iterator<Item = &'a [f64]>, sample_time_s: f64) -> f64 {
    let moves = segments.flat_map(|s| s.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    let mut moves: Vec<f64> = moves.collect();
    moves.sort_by(f64::total_cmp);
    let at = ((1.0 - RARE) * moves.len() as f64) as usize;
    moves.get(at).map_or(0.0, |most| most / sample_time_s)
}
