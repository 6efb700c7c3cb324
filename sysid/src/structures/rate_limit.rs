//! The largest rate of the road wheels, of a servo that its command outruns, as the structures with an actuator find it.
//!
//! It is no parameter until the drive shows it: a drive that does not reach the limit does not determine it, and the cost has
//! no slope there. So rates about and below the fastest of the command are tried, with the lag that was found without a limit
//! and with shorter ones, since a lag stands for the limit until then; the best of each lag is refined, and the search goes on
//! from the better one. The model with the fewer parameters stays unless the other is better by the Bayesian information
//! criterion.

use steerwright_formats::Prior;

/// The prior of a rate that the drive shows, rad/s: servos of model cars, of road cars and of lorries.
pub(crate) const PRIOR: Prior = Prior { mean: 0.5, standard_deviation: 1.0, min: 0.02, max: 10.0 };

/// Rates that are tried, each as a share of the one before, from the fastest of the command.
const RATES: i32 = 7;
const SHARE: f64 = 0.6;
/// Time constants that are tried with them, over the one that was found without a limit.
pub(crate) const LAGS: [f64; 2] = [1.0, 0.3];
/// Time over which the command's motion is read, s: steps of a held one have a rate that is that of the samples.
const MOTION_S: f64 = 0.2;
/// Share of the steering's motions that may be faults of the log.
const RARE: f64 = 1e-3;

/// Rates that are worth a try, for a command whose fastest is `fastest`, rad/s at the road wheel.
pub(crate) fn rates(fastest: f64) -> impl Iterator<Item = f64> + Clone {
    (0..RATES).map(move |power| (fastest * SHARE.powi(power)).clamp(PRIOR.min, PRIOR.max))
}

/// Share of the squared errors that a limit explains at least: what a model lacks otherwise is not taken for one.
const LEAST_SHARE: f64 = 0.1;

/// Whether a logarithm of the posterior density that is higher by `gain`, of `cost` below its largest without a limit, is
/// worth the parameter.
pub(crate) fn is_worth_it(gain: f64, cost: f64, samples: usize) -> bool {
    gain > 0.5 * (samples as f64).ln() && gain > LEAST_SHARE * cost
}

/// The fastest of a steering in samples, by its unit and second, but for a share of [`RARE`].
pub(crate) fn fastest<'a>(segments: impl Iterator<Item = &'a [f64]>, sample_time_s: f64) -> f64 {
    let apart = (MOTION_S / sample_time_s).round().max(1.0) as usize;
    let moves = segments.flat_map(|s| s.iter().zip(s.iter().skip(apart)));
    let mut moves: Vec<f64> = moves.map(|(from, to)| (to - from).abs()).collect();
    moves.sort_by(f64::total_cmp);
    let at = ((1.0 - RARE) * moves.len() as f64) as usize;
    moves.get(at).map_or(0.0, |most| most / (apart as f64 * sample_time_s))
}
