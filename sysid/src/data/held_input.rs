//! The steering as a model takes it, held over each sample, so that it does to this vehicle what the logged steering
//! did.
//!
//! The reader of the log delivers the mean over each sample of a steering that moves on between its samples (filter
//! `V₀`), which is right for a vehicle that integrates. A vehicle with poles of its own weights the end of a sample
//! more than its start. With the response G(jω) of the vehicle and G_d(e^{jωT}) of its samples under a held input, the
//! held input is right where it is the steering filtered by `V = G/G_d`; where an angle is taken for held over a period h of
//! its own, G is that of its samples over h; where it goes along straight lines from sample to sample, G is that of its
//! samples under such an input, and V of a vehicle that integrates is `cos(ωT/2)·exp(jωT/2)`. A command stays as the reader holds it. So the input of the log is filtered by `V/V₀`, which is 1 for slow
//! steering. A model that is identified from this input has the response of the vehicle where G has: an error of G
//! changes V by less than `ωT/12` of it.

use crate::linalg::dense::eigenvalues;
use crate::model::StateSpace;
use crate::model::conversion::discretize;
use faer::{Mat, c64};
use std::borrow::Cow;
use std::f64::consts::PI;
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{Continuous, Intersample, Matrix};

/// Samples on either side that the filter takes.
const HALF: usize = 16;
/// Points of the filter's response up to half the sample rate.
const POINTS: usize = 256;
/// Share of half the sample rate from which the filter goes over to 1: near half the sample rate the samples of a
/// vehicle behind an actuator vanish, and there is hardly any steering.
const FULL: f64 = 0.6;
/// Most by which the filter differs from 1.
const LARGEST: f64 = 0.5;

/// A continuous model from steering to yaw rate without a delay, time in s: `ẋ = F x + G u`, `y = H x + D u`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContinuousResponse {
    pub(crate) f: Mat<f64>,
    pub(crate) g: Mat<f64>,
    pub(crate) h: Mat<f64>,
    pub(crate) d: f64,
}

impl ContinuousResponse {
    /// Without the direct gain, which no vehicle that was estimated has.
    pub(crate) fn to_file(&self) -> Continuous {
        let matrix = |m: &Mat<f64>| Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]);
        Continuous { f: matrix(&self.f), g: matrix(&self.g), h: matrix(&self.h) }
    }

    /// At a frequency, rad/s.
    pub(crate) fn value_at(&self, omega: f64) -> c64 {
        self.with(self.f.clone(), self.g.clone())((0.0, omega))
    }

    /// Whether a vehicle and its actuator can have poles and zero, and samples so far apart can show them: poles that are
    /// stable, damped and slower than half the sample rate, and no zero in the right half plane.
    pub(crate) fn is_of_a_vehicle(&self, sample_s: f64) -> bool {
        const LEAST_DAMPING: f64 = 0.2;
        let numerator: Vec<f64> =
            (0..self.g.nrows()).map(|i| self.g[(i, 0)]).filter(|g| *g != 0.0).collect();
        let is_minimum_phase = numerator.windows(2).all(|g| g[0] * g[1] > 0.0);
        let poles = eigenvalues(self.f.as_ref()).unwrap_or_default();
        let is_damped = |(re, im): &(f64, f64)| {
            let size = re.hypot(*im);
            size * sample_s < PI && -re >= LEAST_DAMPING * size && size > 0.0
        };
        !poles.is_empty() && poles.iter().all(is_damped) && is_minimum_phase
    }

    /// The samples' response to an input that is held over `period_s`, at a frequency, rad/s.
    pub(crate) fn held(&self, period_s: f64) -> impl Fn(f64) -> c64 {
        let (a, b) = discretize(self.f.as_ref(), self.g.as_ref(), period_s);
        let at = self.with(a, b);
        move |omega| {
            let (sin, cos) = (omega * period_s).sin_cos();
            at((cos, sin))
        }
    }

    /// The samples' response to an input that goes from sample to sample along straight lines, at a frequency, rad/s:
    /// `x⁺ = A x + (Γ − Λ/T) u + (Λ/T) u⁺` with `Γ` of a held input and `Λ` of one that rises by 1 a second.
    fn along_lines(&self, step: f64) -> impl Fn(f64) -> c64 + use<> {
        let n = self.f.nrows();
        // The input is the last state, its slope the input.
        let f = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => self.f[(i, j)],
            (true, false) => self.g[(i, 0)],
            (false, _) => 0.0,
        });
        let g = Mat::from_fn(n + 1, 1, |i, _| if i < n { 0.0 } else { 1.0 });
        let (augmented, rising) = discretize(f.as_ref(), g.as_ref(), step);
        let a = Mat::from_fn(n, n, |i, j| augmented[(i, j)]);
        let of_next = Mat::from_fn(n, 1, |i, _| rising[(i, 0)] / step);
        let of_own = Mat::from_fn(n, 1, |i, _| augmented[(i, n)] - of_next[(i, 0)]);
        // The direct gain is that of the sample itself.
        let (own, next) =
            (self.with(a.clone(), of_own), Self { d: 0.0, ..self.clone() }.with(a, of_next));
        move |omega| {
            let (sin, cos) = (omega * step).sin_cos();
            own((cos, sin)) + next((cos, sin)) * c64::new(cos, sin)
        }
    }

    /// The response with another state equation, by the complex variable.
    fn with(&self, a: Mat<f64>, b: Mat<f64>) -> impl Fn((f64, f64)) -> c64 + use<> {
        let model = StateSpace { a, b, c: self.h.clone(), d: Mat::from_fn(1, 1, |_, _| self.d) };
        move |z| {
            let (re, im) = model.response_at(0, 0, z);
            c64::new(re, im)
        }
    }
}

/// What the steering did between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Between {
    /// What the reader took it for.
    AsRead,
    /// It was held over each period of its own clock, s, though the reader took it for moving on.
    Held(f64),
    /// It moved on, though the reader took it for held.
    MovingOn,
    /// It went from sample to sample along straight lines, though the reader took it for band-limited.
    Lines,
}

/// The drive with its steering, as it was read, held over each sample as suits the vehicle; as suits one that
/// integrates where there is none.
pub(crate) fn held_for<'a>(
    log: &'a DriveLog,
    between: Between,
    vehicle: Option<&ContinuousResponse>,
) -> Cow<'a, DriveLog> {
    let Some(taps) = taps(log, between, vehicle) else { return Cow::Borrowed(log) };
    let mut held = log.clone();
    let taken_for = match between {
        Between::AsRead => None,
        Between::Held(_) => Some(Intersample::Zoh),
        // Of a command; only an angle is band-limited.
        Between::MovingOn | Between::Lines => Some(Intersample::Foh),
    };
    for channel in &mut held.channels {
        if channel.role == Role::Steering.key() {
            channel.intersample = taken_for.or(channel.intersample);
            channel.along_lines = between == Between::Lines;
        }
    }
    for segment in &log.segments {
        let samples = &log.input[segment.range.clone()];
        let Some(last) = samples.len().checked_sub(1) else { continue };
        for (k, out) in held.input[segment.range.clone()].iter_mut().enumerate() {
            let at = |i: usize| samples[(k + HALF).saturating_sub(i).min(last)];
            *out = taps.iter().enumerate().map(|(i, tap)| tap * at(i)).sum();
        }
    }
    Cow::Owned(held)
}

/// The filter, its first tap for the sample [`HALF`] after; `None` where the input is as the model takes it.
fn taps(
    log: &DriveLog,
    between: Between,
    vehicle: Option<&ContinuousResponse>,
) -> Option<Vec<f64>> {
    let step = log.sample_time_s;
    let channel = log.channels.iter().find(|c| c.role == Role::Steering.key())?;
    let as_read = match channel.intersample? {
        Intersample::Bl | Intersample::Foh => None,
        Intersample::Zoh => Some(1.0 / channel.rate_hz),
    };
    let period = match between {
        Between::AsRead => as_read,
        Between::Held(period) => Some(period),
        Between::MovingOn | Between::Lines => None,
    };
    if period.is_some_and(|p| !p.is_finite()) {
        return None;
    }
    let is_lines = between == Between::Lines;
    let is_own = period == as_read && !is_lines;
    // Of a command the reader's filter is near enough, and one by an estimate moves what is left of a delay.
    if is_own && (vehicle.is_none() || period.is_some()) {
        return None;
    }
    // Of an integrator, whose samples are filtered in the same way whatever it is.
    let hold = |period: Option<f64>, omega: f64| {
        let half = 0.5 * omega * step;
        match period {
            None => c64::cis(half) * sinc(half),
            Some(period) => {
                let own = 0.5 * omega * period.min(step);
                c64::cis(half - own) * (sinc(own) / sinc(half))
            }
        }
    };
    let wanted = |omega: f64| match is_lines {
        true => c64::cis(0.5 * omega * step) * (0.5 * omega * step).cos(),
        false => hold(period, omega),
    };
    let along_lines = vehicle.filter(|_| is_lines).map(|v| v.along_lines(step));
    let of_step = vehicle.map(|v| v.held(step));
    let of_period = vehicle.zip(period).map(|(v, period)| v.held(period.min(step)));
    let response: Vec<c64> = (0..POINTS)
        .map(|k| {
            let share = (k as f64 + 0.5) / POINTS as f64;
            let omega = PI * share / step;
            let wanted = wanted(omega);
            let moved = |vehicle: &ContinuousResponse| match &along_lines {
                Some(along_lines) => along_lines(omega),
                None => vehicle.value_at(omega),
            };
            let ratio = match (vehicle, &of_step, &of_period) {
                (Some(_), Some(of_step), Some(of_period)) => of_period(omega) / of_step(omega),
                (Some(vehicle), Some(of_step), None) => moved(vehicle) / of_step(omega),
                _ => wanted,
            };
            let change = ratio / wanted - 1.0;
            let size = change.re.hypot(change.im);
            let kept = fade(share) * (LARGEST / size).min(1.0);
            let kept =
                if size.is_finite() && size > 0.0 { change * kept } else { c64::new(0.0, 0.0) };
            wanted * (kept + 1.0) / hold(as_read, omega) - 1.0
        })
        .collect();
    let tap = |i: usize| {
        let lag = i as f64 - HALF as f64;
        let sum: f64 = response
            .iter()
            .enumerate()
            .map(|(k, change)| {
                let turn = c64::cis(PI * (k as f64 + 0.5) / POINTS as f64 * lag);
                (change * turn).re
            })
            .sum();
        // Of von Hann's window.
        let window = (0.5 * PI * lag / (HALF as f64 + 1.0)).cos().powi(2);
        window * sum / POINTS as f64
    };
    let mut taps: Vec<f64> = (0..=2 * HALF).map(tap).collect();
    // Steering at rest stays as it is.
    let sum: f64 = taps.iter().sum();
    taps[HALF] += 1.0 - sum;
    Some(taps)
}

/// From 1 to 0 at half the sample rate.
fn fade(share: f64) -> f64 {
    let beyond = ((share - FULL) / (1.0 - FULL)).max(0.0);
    (0.5 * PI * beyond).cos().powi(2)
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use steerwright_drivelog::{LogOptions, read_log};

    fn log(period_s: f64, step_s: f64, intersample: Intersample) -> DriveLog {
        let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps\n");
        for k in 0..800 {
            let t = period_s * f64::from(k);
            csv += &format!("{t:.4},{:.9},{:.9}\n", 0.1 * (3.0 * t).sin(), (3.0 * t).cos());
        }
        let options = LogOptions {
            intersample: Some(intersample),
            sample_time_s: Some(step_s),
            ..LogOptions::default()
        };
        read_log(&[("log.csv".into(), csv.into_bytes())], &options).unwrap()
    }

    fn vehicle(pole: f64) -> ContinuousResponse {
        let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
        ContinuousResponse { f: one(-pole), g: one(1.0), h: one(1.0), d: 0.0 }
    }

    /// What is held over the samples does to a lag what the steering does, as the reader's filter does to an
    /// integrator.
    #[test]
    fn the_filter_is_the_vehicle_over_its_samples() {
        let step = 0.1;
        for intersample in [Intersample::Bl, Intersample::Foh] {
            let log = log(step, step, intersample);
            for pole in [1e-3, 2.0, 10.0, 20.0] {
                let taps = taps(&log, Between::AsRead, Some(&vehicle(pole))).unwrap();
                for hz in [0.2, 0.5, 1.0, 2.0] {
                    let omega = 2.0 * PI * hz;
                    let filter =
                        taps.iter().enumerate().fold(c64::new(0.0, 0.0), |sum, (i, tap)| {
                            sum + c64::cis(omega * step * (HALF as f64 - i as f64)) * *tap
                        });
                    let half = 0.5 * omega * step;
                    let held = c64::cis(half) * sinc(half) * filter;
                    let (a, s) = ((-pole * step).exp(), c64::new(0.0, omega));
                    let of_samples = c64::new((1.0 - a) / pole, 0.0) / (c64::cis(omega * step) - a);
                    let off = of_samples * held * (s + pole) - 1.0;
                    let size = off.re.hypot(off.im);
                    assert!(size < 2e-3, "{intersample:?} pole {pole} at {hz} Hz: {size}");
                }
            }
        }
    }

    /// Along straight lines, an integrator gets the mean of two samples, and a lag what the integral of its response over
    /// the lines is.
    #[test]
    fn straight_lines_do_to_a_lag_what_their_integral_is() {
        let (step, pole) = (0.1, 8.0_f64);
        let at = vehicle(pole).along_lines(step);
        // ∫ e^{−p(T−s)} s/T ds over a sample, and the rest of ∫ e^{−p(T−s)} ds.
        let a = (-pole * step).exp();
        let of_next = (step - (1.0 - a) / pole) / (pole * step);
        let of_own = (1.0 - a) / pole - of_next;
        let log = log(step, step, Intersample::Bl);
        let taps = taps(&log, Between::Lines, Some(&vehicle(pole))).unwrap();
        for hz in [0.5, 1.0, 2.0] {
            let omega = 2.0 * PI * hz;
            let z = c64::cis(omega * step);
            let expected = (z * of_next + of_own) / (z - a);
            let off = at(omega) / expected - 1.0;
            assert!(off.re.hypot(off.im) < 1e-9, "{hz} Hz: {off}");
            let filter = taps.iter().enumerate().fold(c64::new(0.0, 0.0), |sum, (i, tap)| {
                sum + c64::cis(omega * step * (HALF as f64 - i as f64)) * *tap
            });
            let half = 0.5 * omega * step;
            let held = c64::cis(half) * sinc(half) * filter * ((1.0 - a) / pole) / (z - a);
            let off = held / expected - 1.0;
            assert!(off.re.hypot(off.im) < 4e-3, "{hz} Hz: {off}");
        }
    }

    #[test]
    fn a_command_stays_and_an_unstable_model_leaves_the_input_finite() {
        for command in [log(0.1, 0.1, Intersample::Zoh), log(0.01, 0.05, Intersample::Zoh)] {
            let held = held_for(&command, Between::AsRead, Some(&vehicle(10.0)));
            assert!(matches!(held, Cow::Borrowed(_)));
        }
        for pole in [10.0, 0.0, -5.0, 1e9, f64::NAN] {
            let moving_on = log(0.1, 0.1, Intersample::Bl);
            for between in [Between::AsRead, Between::Held(0.1)] {
                let held = held_for(&moving_on, between, Some(&vehicle(pole)));
                assert!(matches!(held, Cow::Owned(_)));
                assert!(held.input.iter().all(|u| u.is_finite()), "{pole} {between:?}");
            }
        }
    }
}
