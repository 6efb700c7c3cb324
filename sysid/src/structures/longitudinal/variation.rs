//! How far the gain varies from one stretch of the drive to another at one speed, as it does in gears that the log does not
//! have.
//!
//! The relative deviation of the gain in a stretch is a random number with the standard deviation τ. Its score s and
//! information i, sums over the stretch, give the likelihood of τ once the prediction errors are almost linear in the gain:
//! `ln L(τ) − ln L(0) = ½ Σ (s²·τ²/(1 + i·τ²) − ln(1 + i·τ²))`, the likelihood of a random effect (J. C. Pinheiro and D. M.
//! Bates, *Mixed-Effects Models in S and S-PLUS*, 2000, chapter 2).

use crate::structures::longitudinal::fit::{Fit, GainScore, gain_scores};
use crate::structures::longitudinal::signals::{Piece, Signals};
use steerwright_formats::GainVariation;

/// Length of a stretch, s: vehicles stay in a gear that long while their speed changes.
const STRETCH_S: f64 = 5.0;
/// Fewest stretches.
const LEAST_STRETCHES: usize = 8;
/// Standard deviations that are tried, and their distance.
const LARGEST: f64 = 2.0;
const STEP: f64 = 0.002;
/// Half of the 95 % quantile of χ² with a degree of freedom.
const BAND: f64 = 1.92;

/// `None` where the drive is too short.
pub(super) fn gain_variation(
    fit: &Fit,
    signals: &Signals<'_>,
    pieces: &[Piece],
) -> Option<GainVariation> {
    let stretches = gain_scores(fit, signals, pieces, STRETCH_S);
    if stretches.len() < LEAST_STRETCHES {
        return None;
    }
    Some(variation(&stretches))
}

pub(super) fn variation(stretches: &[GainScore]) -> GainVariation {
    let log_likelihood_ratio = |deviation: f64| {
        let mut sum = 0.0;
        for GainScore { score, information } in stretches {
            let grown = information * deviation * deviation;
            sum += 0.5 * ((score * deviation).powi(2) / (1.0 + grown) - grown.ln_1p());
        }
        sum
    };
    let tried = || (0..=(LARGEST / STEP) as usize).map(|k| STEP * k as f64);
    let (mut deviation, mut best) = (0.0, 0.0);
    for own in tried() {
        let now = log_likelihood_ratio(own);
        if now > best {
            (deviation, best) = (own, now);
        }
    }
    let mut largest = deviation;
    for own in tried() {
        if log_likelihood_ratio(own) > best - BAND {
            largest = f64::max(largest, own);
        }
    }
    GainVariation { stretch_s: STRETCH_S, deviation, largest, log_likelihood_ratio: best }
}
