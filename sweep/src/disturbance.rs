//! Disturbances: signals of time that are added to an input, whatever feeds it.
//!
//! With amplitude A, start t₀ and duration T, τ = t − t₀:
//!
//! - `step`: A from t₀ on;
//! - `pulse`: A for 0 ≤ τ < T;
//! - `gust`: A/2·(1 − cos 2πτ/T) for 0 ≤ τ ≤ T, the one-minus-cosine gust of aviation's and road
//!   vehicles' cross-wind tests;
//! - `noise`: Gaussian with standard deviation A and a first-order spectrum of bandwidth f, the
//!   Gauss–Markov process x⁺ = a·x + √(1 − a²)·A·ξ, a = exp(−2πf·h), stationary from the start on.
//!
//! Values hold from a communication point to the next. What such a signal represents depends on the
//! study: a force where the plant has an input for one, else what acts like it, such as the
//! steering that balances a banked road.

use crate::draws::{Key, Number};
use crate::study::Shape;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A disturbance as the study states it, its amplitude in the input's unit.
#[derive(Debug, Clone)]
pub(crate) struct Disturbance {
    pub(crate) shape: Shape,
    pub(crate) amplitude: Number,
    /// From the amplitude's unit to the input's.
    pub(crate) factor: f64,
    pub(crate) start: Number,
    pub(crate) duration: Number,
    pub(crate) bandwidth: f64,
    pub(crate) key: Key,
}

/// A disturbance in a run.
#[derive(Debug)]
pub(crate) struct Signal {
    shape: Shape,
    amplitude: f64,
    start: f64,
    duration: f64,
    /// a of the noise.
    pole: f64,
    noise: f64,
    stream: ChaCha8Rng,
}

impl Disturbance {
    /// The signal of a run with communication steps of `step`.
    pub(crate) fn signal(&self, draws: &[f64], run: usize, step: f64) -> Signal {
        let mut stream = self.key.stream(run);
        let unit: f64 = stream.sample(StandardNormal);
        Signal {
            shape: self.shape,
            amplitude: self.factor * self.amplitude.evaluate(draws),
            start: self.start.evaluate(draws),
            duration: self.duration.evaluate(draws),
            pole: (-2.0 * std::f64::consts::PI * self.bandwidth * step).exp(),
            noise: unit,
            stream,
        }
    }
}

impl Signal {
    /// The value from the communication point `time` on; to be called once for each, in order.
    pub(crate) fn next(&mut self, time: f64, step: f64) -> f64 {
        // k·step may fall an ulp short of the start that was stated.
        let since = time + 1e-6 * step - self.start;
        let amplitude = self.amplitude;
        match self.shape {
            Shape::Step if since >= 0.0 => amplitude,
            Shape::Pulse if since >= 0.0 && since < self.duration => amplitude,
            Shape::Gust if since >= 0.0 && since <= self.duration => {
                let turn = 2.0 * std::f64::consts::PI * (since / self.duration);
                0.5 * amplitude * (1.0 - turn.cos())
            }
            Shape::Noise => {
                let value = amplitude * self.noise;
                let unit: f64 = self.stream.sample(StandardNormal);
                self.noise = self.pole * self.noise + (1.0 - self.pole * self.pole).sqrt() * unit;
                value
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(shape: Shape, run: usize) -> Signal {
        let disturbance = Disturbance {
            shape,
            amplitude: Number::Drawn(0),
            factor: 0.5,
            start: Number::Fixed(1.0),
            duration: Number::Fixed(2.0),
            bandwidth: 2.0,
            key: Key::new(1, "d"),
        };
        disturbance.signal(&[4.0], run, 0.01)
    }

    fn over_time(shape: Shape, run: usize, steps: usize) -> Vec<f64> {
        let mut signal = signal(shape, run);
        (0..steps).map(|k| signal.next(0.01 * k as f64, 0.01)).collect()
    }

    #[test]
    fn shapes_begin_end_and_peak_where_stated() {
        let step = over_time(Shape::Step, 0, 500);
        assert_eq!((step[99], step[100], step[499]), (0.0, 2.0, 2.0));
        let pulse = over_time(Shape::Pulse, 0, 500);
        assert_eq!((pulse[99], pulse[100], pulse[299], pulse[300]), (0.0, 2.0, 2.0, 0.0));
        let gust = over_time(Shape::Gust, 0, 500);
        assert!(gust[100].abs() < 1e-9 && (gust[150] - 1.0).abs() < 1e-6);
        assert!((gust[200] - 2.0).abs() < 1e-9 && gust[300].abs() < 1e-9 && gust[301] == 0.0);
        // Its impulse is that of a pulse of half the amplitude.
        let impulse: f64 = gust.iter().sum::<f64>() * 0.01;
        assert!((impulse - 2.0).abs() < 1e-6, "{impulse}");
    }

    #[test]
    fn noise_has_its_deviation_and_its_bandwidth_and_differs_between_runs() {
        let noise = over_time(Shape::Noise, 0, 400_000);
        let n = noise.len() as f64;
        let variance = noise.iter().map(|x| x * x).sum::<f64>() / n;
        assert!((variance.sqrt() - 2.0).abs() < 0.05, "{}", variance.sqrt());
        let lag = 10;
        let covariance =
            noise.windows(lag + 1).map(|w| w[0] * w[lag]).sum::<f64>() / (n - lag as f64);
        let expected = (-2.0 * std::f64::consts::PI * 2.0 * 0.01 * lag as f64).exp();
        assert!((covariance / variance - expected).abs() < 0.03);
        assert_ne!(over_time(Shape::Noise, 0, 3), over_time(Shape::Noise, 1, 3));
        assert_eq!(over_time(Shape::Noise, 5, 3), over_time(Shape::Noise, 5, 3));
    }
}
