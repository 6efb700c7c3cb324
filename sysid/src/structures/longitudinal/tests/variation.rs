//! The variation of the gain from scores of a known one.

use super::car::Random;
use crate::structures::longitudinal::fit::GainScore;
use crate::structures::longitudinal::variation::variation;

/// Stretches whose gain differs by a random number of a standard deviation.
fn stretches(count: usize, deviation: f64, seed: u64) -> Vec<GainScore> {
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    for _ in 0..count {
        let information = random.between(50.0, 2000.0);
        let score =
            information * deviation * random.normal() + information.sqrt() * random.normal();
        all.push(GainScore { score, information });
    }
    all
}

#[test]
fn the_band_contains_the_deviation_of_random_gains() {
    for truth in [0.05, 0.2] {
        let mut within = 0;
        for seed in 0..200 {
            let found = variation(&stretches(50, truth, seed));
            assert!((found.deviation / truth - 1.0).abs() < 0.7, "{found:?}");
            within += usize::from(found.largest >= truth);
        }
        // The band has two ends, of which this is one.
        assert!((188..=200).contains(&within), "{truth}: {within}");
    }
}

#[test]
fn a_gain_that_does_not_vary_is_found_not_to() {
    let mut noticed = 0;
    for seed in 0..200 {
        let found = variation(&stretches(50, 0.0, seed));
        assert!(found.largest < 0.06, "{found:?}");
        noticed += usize::from(found.log_likelihood_ratio > 1.35);
    }
    assert!(noticed <= 16, "{noticed}");
}
