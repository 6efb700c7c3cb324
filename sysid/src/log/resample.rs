//! Brings channels with clocks of their own onto one uniform grid without biasing the dynamics.
//!
//! 1. Linear interpolation onto a fine uniform grid, at least as fast as the fastest channel; on
//!    a clock that is uniform already this changes nothing.
//! 2. A zero-phase low-pass filter, the same for every channel, so that the transfer function from
//!    input to output is that of the unfiltered signals throughout the pass band.
//! 3. Decimation.
//!
//! The filter is a square-root raised cosine with its −3 dB point at the Nyquist frequency of the
//! new rate 1/T and a roll-off of 25 %, windowed (Kaiser, β = 6) to ±8 T. Its squared response
//! plus the image of it about the Nyquist frequency is one, so white sensor noise is white after
//! the decimation as before, and tests of residuals keep their meaning.
//!
//! *The input is held.* Eq 9–10 take an input that is constant over a sample. On the log's own
//! clock (period h) it is; after decimation to T = q·h it is not. A hold over T shapes a
//! signal by sin(ωT/2)/(ωT/2) and delays it by T/2, one over h by h/2. So the input channel is
//! filtered with the additional factor
//! `sinc(ωh/2)/sinc(ωT/2) · exp(jω(T−h)/2)`,
//! with which the held coarse input equals the held fine input in the pass band. Without it a
//! model identified from decimated data would lead the vehicle by (T−h)/2 when it is converted to
//! continuous time.

use std::f64::consts::PI;

const ROLL_OFF: f64 = 0.25;
const HALF_LENGTH: f64 = 8.0;
/// Samples beyond an instant, on either side, that its filters may ask for.
pub(crate) const MARGIN: f64 = HALF_LENGTH + 1.0;
const KAISER_BETA: f64 = 6.0;

/// A uniform grid: `count` instants from `start`, `step` apart, made from `per_step` fine steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub(crate) start: f64,
    pub(crate) step: f64,
    pub(crate) count: usize,
    pub(crate) per_step: usize,
}

impl Grid {
    /// The grid within `from..to`, with room for the filter at both ends where it is used.
    pub(crate) fn within(from: f64, to: f64, step: f64, per_step: usize) -> Self {
        let margin = if per_step > 1 { MARGIN } else { 0.0 };
        let count = ((to - from) / step + 1e-6 - 2.0 * margin).floor();
        let count = if count >= 0.0 { count as usize + 1 } else { 0 };
        Self { start: from + margin * step, step, count, per_step }
    }
}

/// How a channel is held between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Hold {
    /// A measured signal, sampled.
    Sampled,
    /// A command held for its clock's period, s.
    Held(f64),
}

/// The channel (`time`, `value`) on the grid.
pub(crate) fn resample(time: &[f64], value: &[f64], grid: &Grid, hold: Hold) -> Vec<f64> {
    let q = grid.per_step;
    if q <= 1 {
        return interpolate(time, value, grid.start, grid.step, grid.count);
    }
    let fine = grid.step / q as f64;
    let (taps, first) = kernel(grid.step, q, hold);
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
fn kernel(step: f64, q: usize, hold: Hold) -> (Vec<f64>, i64) {
    let fine = step / q as f64;
    // Where the tap's centre lies: a held input is advanced by half the difference of the holds.
    let (period, centre) = match hold {
        Hold::Sampled => (None, 0.0),
        Hold::Held(h) => {
            let h = h.min(step);
            (Some(h), 0.5 * (step - h))
        }
    };
    let half = HALF_LENGTH * step;
    let first = ((centre - half) / fine).ceil() as i64;
    let last = ((centre + half) / fine).floor() as i64;
    let taps: Vec<f64> = (first..=last)
        .map(|i| {
            let t = i as f64 * fine - centre;
            impulse_response(t, step, period) * kaiser(t / half)
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    (taps.iter().map(|h| h / sum).collect(), first)
}

/// Inverse Fourier transform of the wanted magnitude at time `t`, by Simpson's rule.
fn impulse_response(t: f64, step: f64, held: Option<f64>) -> f64 {
    const PANELS: usize = 256;
    let top = 0.5 * (1.0 + ROLL_OFF) / step;
    let width = top / PANELS as f64;
    let f = |i: usize| {
        let frequency = i as f64 * width;
        let hold = held.map_or(1.0, |h| sinc(PI * frequency * h) / sinc(PI * frequency * step));
        root_raised_cosine(frequency * step) * hold * (2.0 * PI * frequency * t).cos()
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
        let grid = Grid::within(0.0, 29.99, 0.04, 4);
        for (frequency, tolerance) in [(0.5, 2e-3), (3.0, 2e-3), (8.0, 5e-3)] {
            let out = resample(&time, &sine(frequency, &time), &grid, Hold::Sampled);
            for (k, y) in out.iter().enumerate() {
                let t = grid.start + k as f64 * grid.step;
                assert!((y - (2.0 * PI * frequency * t).sin()).abs() < tolerance, "{frequency} Hz");
            }
        }
        for frequency in [18.0, 24.0, 40.0] {
            let out = resample(&time, &sine(frequency, &time), &grid, Hold::Sampled);
            assert!(out.iter().all(|y| y.abs() < 5e-3), "{frequency} Hz");
        }
    }

    #[test]
    fn white_noise_stays_white() {
        // Autocorrelation of the decimated noise at lags of whole samples: zero.
        let (taps, _) = kernel(0.04, 4, Hold::Sampled);
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
        let grid = Grid::within(time[0], time[1999], 0.04, 4);
        let out = resample(&time, &sine(1.0, &time), &grid, Hold::Sampled);
        for (k, y) in out.iter().enumerate() {
            let t = grid.start + k as f64 * grid.step;
            assert!((y - (2.0 * PI * t).sin()).abs() < 5e-3);
        }
    }
}
