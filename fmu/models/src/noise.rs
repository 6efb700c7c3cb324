//! Gaussian numbers by counter: the k-th number of a seed, without any state but k.
//!
//! SplitMix64 (Steele, Lea and Flood 2014) mixes seed and counter into two uniform numbers, the
//! Box–Muller transform makes a standard normal one of them. A counter makes the sequence
//! independent of step sizes, and a saved state that is restored draws the same numbers again.

use std::f64::consts::TAU;

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// SplitMix64's finalizer.
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The uniform number in (0, 1] of 53 random bits.
fn uniform(bits: u64) -> f64 {
    ((bits >> 11) + 1) as f64 / 9_007_199_254_740_992.0
}

/// The `index`-th number, from 0, of a standard normal sequence named by `seed`.
#[must_use]
pub fn gaussian(seed: i32, index: u64) -> f64 {
    let stream = mix((seed as u32 as u64).wrapping_add(GOLDEN));
    let counter = index.wrapping_mul(2);
    let draw = |k: u64| uniform(mix(stream.wrapping_add(k.wrapping_mul(GOLDEN))));
    let radius = (-2.0 * draw(counter.wrapping_add(1)).ln()).sqrt();
    radius * (TAU * draw(counter.wrapping_add(2))).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_whiteness() {
        for seed in [0, 1, -7, 123_456] {
            let n = 200_000;
            let e: Vec<f64> = (0..n).map(|k| gaussian(seed, k)).collect();
            let mean = |f: &dyn Fn(usize) -> f64| (0..e.len() - 9).map(f).sum::<f64>() / n as f64;
            // Five standard errors.
            let five = 5.0 / (n as f64).sqrt();
            assert!(mean(&|k| e[k]).abs() < five);
            assert!((mean(&|k| e[k].powi(2)) - 1.0).abs() < five * 2_f64.sqrt());
            assert!((mean(&|k| e[k].powi(4)) - 3.0).abs() < five * 96_f64.sqrt());
            for lag in 1..9 {
                assert!(mean(&|k| e[k] * e[k + lag]).abs() < five, "seed {seed}, lag {lag}");
            }
            // One number in 370 lies beyond three standard deviations.
            let tail = e.iter().filter(|e| e.abs() > 3.0).count() as f64 / n as f64;
            assert!((tail - 0.0027).abs() < 0.0006, "{tail}");
        }
    }

    #[test]
    fn seeds_are_unrelated() {
        let product: f64 = (0..100_000).map(|k| gaussian(1, k) * gaussian(2, k)).sum::<f64>() / 1e5;
        assert!(product.abs() < 5.0 / 1e5_f64.sqrt());
    }
}
