//! The spectral density of the outputs' errors, by which they are weighted.
//!
//! A model of a vehicle is wrong somewhere, and its errors last: weighted as if white they would count
//! many times over, against each other and against the priors. An output's sum of squares is divided by
//! the density of its errors at the frequencies of the vehicle's motion instead.

use crate::structures::single_track::problem::{Densities, Point, Problem};
use crate::structures::single_track::simulate::SimulationRun;
use std::f64::consts::TAU;
use steerwright_drivelog::signal::standard_deviation;

/// Share of an output's deviation that errors are supposed to have before there are any.
const SUPPOSED_ERROR: f64 = 0.1;
/// How long errors are supposed to last, s.
const SUPPOSED_DURATION_S: f64 = 0.5;
/// Frequencies of the vehicle's motion, at which its errors are weighed, Hz.
const FREQUENCIES_HZ: [f64; 5] = [0.0, 0.25, 0.5, 1.0, 2.0];
/// Windows whose sums' variance is the density, s.
const WINDOWS_S: [f64; 3] = [1.0, 2.0, 4.0];
/// No output is better known than this, unit²·s.
const LEAST: f64 = 1e-14;

/// Densities before there are errors.
pub(super) fn supposed(problem: &Problem<'_>) -> Densities {
    std::array::from_fn(|i| {
        let measured = |s| problem.measured_signal(s, i).unwrap_or_default().to_vec();
        let all: Vec<f64> = problem.segments.iter().flat_map(measured).collect();
        let error = SUPPOSED_ERROR * standard_deviation(&all);
        (error * error * SUPPOSED_DURATION_S).max(LEAST)
    })
}

/// Densities of the errors of a run; `None` where the model spins.
pub(super) fn observed(problem: &Problem<'_>, p: &Point, run: &SimulationRun) -> Option<Densities> {
    let errors = problem.errors(p, run)?;
    let period = problem.period(run);
    Some(std::array::from_fn(|i| density(&errors[i], period).max(LEAST)))
}

/// The largest of the periodograms with Bartlett's weights over several windows at the frequencies of the
/// vehicle's motion, and of the density of white errors of the same variance. Vibration at higher frequency does
/// not lower it.
pub(super) fn density(segments: &[Vec<f64>], period: f64) -> f64 {
    let squares: f64 = segments.iter().flatten().map(|e| e * e).sum();
    let count = segments.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let mut largest = squares / count * period;
    for window_s in WINDOWS_S {
        let window = (window_s / period).round().max(1.0) as usize;
        for hz in
            FREQUENCIES_HZ.into_iter().filter(|hz| hz * window_s == 0.0 || hz * window_s >= 1.0)
        {
            largest = largest.max(periodogram(segments, window, TAU * hz * period) * period);
        }
    }
    largest
}

/// Mean square of the sum of errors, turned by an angle a sample, over all windows, a sample of the window.
fn periodogram(segments: &[Vec<f64>], window: usize, turn: f64) -> f64 {
    let (mut sum, mut windows) = (0.0, 0);
    for errors in segments.iter().filter(|e| e.len() >= 2 * window) {
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..errors.len() {
            let (sin, cos) = (turn * k as f64).sin_cos();
            re += errors[k] * cos;
            im += errors[k] * sin;
            if let Some(old) = k.checked_sub(window) {
                let (sin, cos) = (turn * old as f64).sin_cos();
                re -= errors[old] * cos;
                im -= errors[old] * sin;
            }
            if k + 1 >= window {
                sum += re * re + im * im;
                windows += 1;
            }
        }
    }
    if windows > 0 { sum / (windows * window) as f64 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an autoregressive signal the density at zero is known: σ²·T/(1 − a)². White noise keeps its
    /// own, and an oscillation takes nothing away.
    #[test]
    fn densities_of_known_noise() {
        let mut seed = 1_u64;
        let mut white = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                sum += (seed >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum
        };
        let noise: Vec<f64> = (0..60_000).map(|_| white()).collect();
        let of = |x: &[f64]| density(&[x.to_vec()], 0.01);
        // The largest of several estimates.
        assert!((0.95..1.25).contains(&(of(&noise) / 0.01)), "{}", of(&noise));
        let mut state = 0.0;
        let slow: Vec<f64> = noise
            .iter()
            .map(|e| {
                state = 0.9 * state + e;
                state
            })
            .collect();
        assert!((0.8..1.3).contains(&of(&slow)), "{}", of(&slow));
        let hum = (0..60_000).map(|k| 20.0 * (0.9 * f64::from(k)).sin());
        let humming: Vec<f64> = slow.iter().zip(hum).map(|(a, b)| a + b).collect();
        assert!(of(&humming) > 0.8, "{}", of(&humming));
        // Half of the squared amplitude is that of 1 Hz, within windows of 4 s: 4 s/4 of it is the density.
        let swaying = (0..60_000).map(|k| 2.0 * (TAU * 0.01 * f64::from(k)).sin());
        let swaying: Vec<f64> = noise.iter().zip(swaying).map(|(a, b)| 0.1 * a + b).collect();
        assert!((of(&swaying) - 4.0).abs() < 0.1, "{}", of(&swaying));
    }
}
