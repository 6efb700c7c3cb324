//! The noise model and its predictor: a Kalman filter of the error between the measured and the simulated speed, whose
//! states are that error and a disturbance of the acceleration that decays exponentially.
//!
//! A driver or a cruise control reacts to what a disturbance does to the speed, so that command and disturbance are
//! correlated. The prediction errors are not: given the past, they do not depend on the command. Least squares of the
//! prediction errors is therefore free of bias in a closed loop (L. Ljung, *System Identification*, 2nd edition,
//! section 13.4), as far as the noise model holds; least squares of simulation errors is not. The initial speed of a piece
//! is a state without prior, which is the same as to estimate it.

use crate::linalg::dual::Scalar;
use crate::structures::longitudinal::signals::Piece;

/// Standard deviation of the initial speed error over that of the noise: none is known.
const DIFFUSE: f64 = 1e4;
/// Bounds of the logarithms that are searched: deviation of the disturbance over that of the speed's noise (1/s), and
/// time constant (s).
const BOUNDS: [[f64; 2]; 2] = [[-4.0, 9.0], [-1.0, 4.5]];
/// First and last step of the search in these.
const STEPS: [f64; 2] = [1.0, 0.05];

/// The noise of the speed, and the disturbance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Standard deviation of the noise of the speed, m/s.
    pub(super) speed: f64,
    /// Standard deviation of the disturbance over it, 1/s.
    pub(super) ratio: f64,
    /// Time constant of the disturbance, s.
    pub(super) time: f64,
}

/// Gains of the filter at each sample of a piece, and the standard deviation of the prediction error.
pub(super) struct Filter {
    gains: Vec<[f64; 2]>,
    deviations: Vec<f64>,
    decay: f64,
    area: f64,
}

impl Noise {
    pub(super) fn initial() -> Self {
        Self { speed: 0.05, ratio: 4.0, time: 5.0 }
    }

    /// The filter for pieces of up to `count` samples.
    pub(super) fn filter(&self, sample_time: f64, count: usize) -> Filter {
        let decay = (-sample_time / self.time).exp();
        let area = self.time * (1.0 - decay);
        let (r, stationary) = (self.speed.powi(2), (self.speed * self.ratio).powi(2));
        let q = stationary * (1.0 - decay * decay);
        // Covariance of (speed error, disturbance) before the measurement.
        let (mut vv, mut vd, mut dd) = (r * DIFFUSE * DIFFUSE, 0.0, stationary);
        let mut filter = Filter {
            gains: Vec::with_capacity(count),
            deviations: Vec::with_capacity(count),
            decay,
            area,
        };
        for _ in 0..count {
            let s = vv + r;
            let gain = [vv / s, vd / s];
            filter.gains.push(gain);
            filter.deviations.push(s.sqrt());
            // After the measurement; Joseph's form is not needed for two states.
            let (a, b, c) = (vv * r / s, vd * r / s, dd - gain[1] * vd);
            vv = a + 2.0 * area * b + area * area * c;
            vd = decay * (b + area * c);
            dd = decay * decay * c + q;
        }
        filter
    }
}

impl Filter {
    /// Prediction errors over their deviations, from the errors of a simulation that begins anywhere; the first
    /// determines the initial speed.
    #[inline]
    pub(super) fn errors<S: Scalar>(
        &self,
        simulation_errors: impl Iterator<Item = S>,
        mut each: impl FnMut(usize, S),
    ) {
        let (mut speed, mut disturbance) = (S::constant(0.0), S::constant(0.0));
        for (i, error) in simulation_errors.enumerate() {
            let innovation = error - speed;
            if i > 0 {
                each(i, innovation.times(1.0 / self.deviations[i]));
            }
            let [of_speed, of_disturbance] = self.gains[i];
            let d = disturbance + innovation.times(of_disturbance);
            speed = speed + innovation.times(of_speed) + d.times(self.area);
            disturbance = d.times(self.decay);
        }
    }

    /// Logarithms of the deviations of the first `count` samples but for the first, summed.
    fn sum_of_logarithms(&self, count: usize) -> f64 {
        self.deviations[1..count.max(1)].iter().map(|s| s.ln()).sum()
    }
}

/// The noise of greatest likelihood for errors of a simulation, by a search along the two logarithms.
pub(super) fn estimate(
    errors: &[f64],
    pieces: &[Piece],
    sample_time: f64,
    resolution: f64,
    from: Noise,
) -> Noise {
    let longest = pieces.iter().map(|piece| piece.range.len()).max().unwrap_or(0);
    let evaluate = |at: &[f64; 2]| {
        let unit = Noise { speed: 1.0, ratio: at[0].exp(), time: at[1].exp() };
        let filter = unit.filter(sample_time, longest);
        let (mut squares, mut count, mut logarithms) = (0.0, 0.0, 0.0);
        for piece in pieces {
            filter.errors(errors[piece.range.clone()].iter().copied(), |_, e: f64| {
                squares += e * e;
                count += 1.0;
            });
            logarithms += filter.sum_of_logarithms(piece.range.len());
        }
        let variance = squares / f64::max(count, 1.0);
        (0.5 * count * variance.max(1e-18).ln() + logarithms, variance.sqrt())
    };
    let mut at = [from.ratio.ln(), from.time.ln()];
    for (x, [low, high]) in at.iter_mut().zip(BOUNDS) {
        *x = x.clamp(low, high);
    }
    let (mut cost, mut speed) = evaluate(&at);
    let mut step = STEPS[0];
    while step >= STEPS[1] {
        let mut has_moved = false;
        for [a, b] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, -1.0], [-1.0, 1.0]] {
            let next = [
                (at[0] + a * step).clamp(BOUNDS[0][0], BOUNDS[0][1]),
                (at[1] + b * step).clamp(BOUNDS[1][0], BOUNDS[1][1]),
            ];
            let (now, deviation) = evaluate(&next);
            if now < cost - 1e-6 {
                (at, cost, speed, has_moved) = (next, now, deviation, true);
            }
        }
        if !has_moved {
            step *= 0.5;
        }
    }
    // A speed that changes by whole quanta has their noise at least.
    let speed = speed.max(resolution / 12.0_f64.sqrt()).max(1e-6);
    Noise { speed, ratio: at[0].exp(), time: at[1].exp() }
}
