//! Brings channels with clocks of their own onto one uniform grid without biasing the dynamics.
//!
//! Interpolation onto a fine grid, one zero-phase low-pass filter for all channels, decimation, and an
//! additional factor for the input, which the model holds over a sample: see `docs/methods/logs.md`.
//!
//! With that factor the held coarse input does to a vehicle what the true one did, in the pass band. A
//! measured angle acts on the yaw acceleration at once, which the mean over each hold leaves as it was: what
//! a plant that integrates takes (in its samples the images of the hold add up to sinc²). A command acts
//! behind its actuator's lag, which the images do not pass. A log's own rate is kept by the same filters, up
//! to the Nyquist frequency (no low-pass, for the output is not filtered then).

use std::f64::consts::PI;
use steerwright_formats::Intersample;

const ROLL_OFF: f64 = 0.25;
const HALF_LENGTH: f64 = 8.0;
/// Samples beyond an instant, on either side, that its filters may need.
pub(crate) const MARGIN: f64 = HALF_LENGTH + 1.0;
const KAISER_BETA: f64 = 6.0;
/// A channel whose period is more fine steps is slower than the fine grid.
const SLOW: f64 = 1.5;

/// A uniform grid: `count` instants from `start`, `step` apart, made from `per_step` fine steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub(crate) start: f64,
    pub(crate) step: f64,
    pub(crate) count: usize,
    pub(crate) per_step: usize,
}

impl Grid {
    /// The grid within `from..to`, with room for the filters of `margin` samples at both ends.
    pub(crate) fn within(from: f64, to: f64, step: f64, per_step: usize, margin: f64) -> Self {
        let count = ((to - from) / step + 1e-6 - 2.0 * margin).floor();
        let count = if count >= 0.0 { count as usize + 1 } else { 0 };
        Self { start: from + margin * step, step, count, per_step }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Becomes {
    Samples,
    /// What, held over each step, does the same as the signal that was logged.
    Held(Intersample),
}

/// The channel (`time`, `value`) of that period, s, on the grid.
pub(crate) fn resample(
    time: &[f64],
    value: &[f64],
    period: f64,
    grid: &Grid,
    becomes: Becomes,
) -> Vec<f64> {
    let q = grid.per_step;
    if q <= 1 && matches!(becomes, Becomes::Samples | Becomes::Held(Intersample::Zoh)) {
        return interpolate(time, value, grid.start, grid.step, grid.count);
    }
    let fine = grid.step / q as f64;
    let (taps, first) = kernel(grid.step, q, period, becomes);
    let fine_start = grid.start + first as f64 * fine;
    let fine_count = (grid.count.max(1) - 1) * q + taps.len();
    let signal = interpolate(time, value, fine_start, fine, fine_count);
    (0..grid.count)
        .map(|k| taps.iter().zip(&signal[k * q..]).map(|(h, x)| h * x).sum::<f64>())
        .collect()
}

/// Linear interpolation at uniform instants; the ends are held.
pub(crate) fn interpolate(
    time: &[f64],
    value: &[f64],
    start: f64,
    step: f64,
    count: usize,
) -> Vec<f64> {
    let mut i = time.partition_point(|t| *t <= start).saturating_sub(1).min(time.len() - 2);
    (0..count)
        .map(|k| {
            let t = start + k as f64 * step;
            while i + 2 < time.len() && time[i + 1] <= t {
                i += 1;
            }
            let (a, b) = (time[i], time[i + 1]);
            let w = ((t - a) / (b - a)).clamp(0.0, 1.0);
            value[i] + w * (value[i + 1] - value[i])
        })
        .collect()
}

/// Taps on the fine grid, and the index of the first relative to the output's instant.
fn kernel(step: f64, q: usize, period: f64, becomes: Becomes) -> (Vec<f64>, i64) {
    let fine = step / q as f64;
    // Where the tap's centre lies: what is to be held is advanced by what the hold delays.
    let held = period.min(step);
    let centre = match becomes {
        Becomes::Samples => 0.0,
        Becomes::Held(Intersample::Zoh) => 0.5 * (step - held),
        Becomes::Held(Intersample::Foh | Intersample::Bl) => 0.5 * step,
    };
    let magnitude = |frequency: f64| {
        let sinc_of = |duration: f64| sinc(PI * frequency * duration);
        let low_pass = if q > 1 { root_raised_cosine(frequency * step) } else { 1.0 };
        let hold = match becomes {
            Becomes::Samples => 1.0,
            Becomes::Held(Intersample::Zoh) => sinc_of(held) / sinc_of(step),
            Becomes::Held(Intersample::Foh) => sinc_of(held).powi(2) * sinc_of(step),
            Becomes::Held(Intersample::Bl) => sinc_of(step),
        };
        let drawn = if period > SLOW * fine { sinc_of(held).powi(2) } else { 1.0 };
        low_pass * hold / drawn
    };
    let top = if q > 1 { 0.5 * (1.0 + ROLL_OFF) } else { 0.5 } / step;
    let half = HALF_LENGTH * step;
    let first = ((centre - half) / fine).ceil() as i64;
    let last = ((centre + half) / fine).floor() as i64;
    let taps: Vec<f64> = (first..=last)
        .map(|i| {
            let t = i as f64 * fine - centre;
            impulse_response(t, top, magnitude) * kaiser(t / half)
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    (taps.iter().map(|h| h / sum).collect(), first)
}

/// Inverse Fourier transform of the wanted magnitude, which ends at `top`, at time `t`, by Simpson's rule.
fn impulse_response(t: f64, top: f64, magnitude: impl Fn(f64) -> f64) -> f64 {
    const PANELS: usize = 256;
    let width = top / PANELS as f64;
    let f = |i: usize| {
        let frequency = i as f64 * width;
        magnitude(frequency) * (2.0 * PI * frequency * t).cos()
    };
    let inner: f64 = (1..PANELS).map(|i| if i % 2 == 1 { 4.0 * f(i) } else { 2.0 * f(i) }).sum();
    (f(0) + inner + f(PANELS)) * width / 3.0
}

/// Magnitude at `x` = frequency times the new sample time.
fn root_raised_cosine(x: f64) -> f64 {
    let (low, high) = (0.5 * (1.0 - ROLL_OFF), 0.5 * (1.0 + ROLL_OFF));
    if x <= low {
        1.0
    } else if x >= high {
        0.0
    } else {
        (0.5 * PI * (x - low) / (high - low)).cos()
    }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}

/// Kaiser window over −1..1.
fn kaiser(x: f64) -> f64 {
    let inside = (1.0 - x * x).max(0.0).sqrt();
    bessel_i0(KAISER_BETA * inside) / bessel_i0(KAISER_BETA)
}

fn bessel_i0(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..40 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(frequency: f64, time: &[f64]) -> Vec<f64> {
        time.iter().map(|t| (2.0 * PI * frequency * t).sin()).collect()
    }

    #[test]
    fn the_pass_band_passes_without_phase_and_the_stop_band_is_stopped() {
        let time: Vec<f64> = (0..3000).map(|i| i as f64 * 0.01).collect();
        let grid = Grid::within(0.0, 29.99, 0.04, 4, MARGIN);
        for (frequency, tolerance) in [(0.5, 2e-3), (3.0, 2e-3), (8.0, 5e-3)] {
            let out = resample(&time, &sine(frequency, &time), 0.01, &grid, Becomes::Samples);
            for (k, y) in out.iter().enumerate() {
                let t = grid.start + k as f64 * grid.step;
                assert!((y - (2.0 * PI * frequency * t).sin()).abs() < tolerance, "{frequency} Hz");
            }
        }
        for frequency in [18.0, 24.0, 40.0] {
            let out = resample(&time, &sine(frequency, &time), 0.01, &grid, Becomes::Samples);
            assert!(out.iter().all(|y| y.abs() < 5e-3), "{frequency} Hz");
        }
    }

    #[test]
    fn white_noise_stays_white() {
        // Autocorrelation of the decimated noise at lags of whole samples: zero.
        let (taps, _) = kernel(0.04, 4, 0.01, Becomes::Samples);
        let r = |lag: usize| -> f64 {
            taps.iter().zip(&taps[4 * lag..]).map(|(a, b)| a * b).sum::<f64>()
        };
        for lag in 1..6 {
            assert!(r(lag).abs() < 0.02 * r(0), "lag {lag}: {}", r(lag) / r(0));
        }
    }

    #[test]
    fn an_irregular_clock_is_followed() {
        let time: Vec<f64> =
            (0..2000).map(|i| (i as f64 + 0.3 * (i as f64).sin()) * 0.012).collect();
        let grid = Grid::within(time[0], time[1999], 0.04, 4, MARGIN);
        let out = resample(&time, &sine(1.0, &time), 0.012, &grid, Becomes::Samples);
        for (k, y) in out.iter().enumerate() {
            let t = grid.start + k as f64 * grid.step;
            assert!((y - (2.0 * PI * t).sin()).abs() < 5e-3);
        }
    }

    /// What is held over each step does the same to an integrator as what was logged did: a sine, the
    /// straight lines through its samples, and its held samples.
    #[test]
    fn the_held_input_does_what_the_logged_one_did() {
        const FREQUENCY: f64 = 1.5;
        let w = 2.0 * PI * FREQUENCY;
        for (period, q) in [(0.01, 4_usize), (0.02, 2), (0.04, 1), (0.1, 1)] {
            let step = period * q as f64;
            let time: Vec<f64> = (0..900).map(|i| f64::from(i) * period).collect();
            let value = sine(FREQUENCY, &time);
            let grid = Grid::within(0.0, time[899], step, q, MARGIN);
            for behaviour in [Intersample::Zoh, Intersample::Foh, Intersample::Bl] {
                let held = resample(&time, &value, period, &grid, Becomes::Held(behaviour));
                // ∫ of the sine with the gain and delay of the log's hold.
                let x = 0.5 * w * period;
                let (gain, delay) = match behaviour {
                    Intersample::Zoh => (sinc(x), 0.5 * period),
                    Intersample::Foh => (sinc(x).powi(2), 0.0),
                    Intersample::Bl => (1.0, 0.0),
                };
                let exact = |t: f64| -gain * (w * (t - delay)).cos() / w;
                let mut sum = exact(grid.start);
                for (k, u) in held.iter().enumerate() {
                    let t = grid.start + k as f64 * step;
                    let off = sum - exact(t);
                    // A command's actuator does not pass the images of the hold, an integrator does; the
                    // sum begins at a value without them, so that they count up to twice.
                    let images = match behaviour {
                        Intersample::Zoh => (0.5 * w * step).powi(2) / 3.0,
                        _ => 0.0,
                    };
                    assert!(
                        off.abs() < (3.5e-3 + 2.2 * images) / w,
                        "{behaviour:?} {period} {q}: {off}"
                    );
                    sum += u * step;
                }
            }
        }
    }
}
