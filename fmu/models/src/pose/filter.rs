//! The filter itself: mean and covariance of (X, Y, ψ, b, σ), moved over an interval along the exact arc
//! (`docs/methods/estimator.md`) and corrected by a fix.
//!
//! The covariance moves by the Jacobian of the arc, and grows by `∫ e^{Aτ}·(Σ g·q²·gᵀ)·e^{Aᵀτ} dτ` with the
//! velocity d/T and the heading ψ + θ/2 held:
//!
//! ```text
//! A = [0, J·d/T, −S·v·n, v·r·n; 0, 0, −1, 0; 0, 0, 0, 0; 0, 0, 0, 0]      J turns by 90°, u along the heading, n = J·u
//! g_r = (S·v·n, 1, 0, 0),  g_b = (0, 0, 1, 0),  g_v = (u, 0, 0, 0),  g_l = (n, 0, 0, 0),  g_σ = (0, 0, 0, 1)
//! ```
//!
//! While the speed is at most [`STANDSTILL_MPS`] the vehicle stands: it does not turn, so the yaw stays and the gyro's mean
//! reading over the interval T is a measurement of its bias with the variance q²/T. A reading that is more than four
//! standard deviations off the bias is that of a vehicle that turns without turning its wheels.
//!
//! σ is added to the sideslip per yaw rate. A fix that is older than stated by Δ has the same effect in a steady turn as
//! σ = −Δ, so σ stands for that, too.

use super::history::Interval;
use super::parameters::PoseParameters;
use crate::quadrature::mean_direction_of_arc;
use crate::trigonometry::sin_cos;
use nalgebra::{Matrix2, Matrix2x5, Matrix5, Vector2, Vector5};

/// Number of states.
pub const STATES: usize = 5;
/// Place of the yaw among the states; x and y come before it.
pub const YAW: usize = 2;
/// Place of the gyro's bias.
pub const BIAS: usize = 3;
/// Place of what is added to the sideslip per yaw rate.
pub const SIDESLIP: usize = 4;

/// Largest speed of a vehicle that stands, m/s: a vehicle turns by at most some 0.2 rad a metre.
pub const STANDSTILL_MPS: f64 = 0.01;
/// Standard deviations from which on a vehicle without a speed turns.
const TURNS: f64 = 4.0;

/// Mean and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// X, Y, ψ, b, σ.
    pub mean: Vector5<f64>,
    /// Their covariance.
    pub covariance: Matrix5<f64>,
}

/// A fix held against the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// How far the fix is from where the antenna was expected, m.
    pub difference: Vector2<f64>,
    /// Its square over its covariance: χ² with two degrees of freedom where filter and fix agree.
    pub normalised_square: f64,
    inverse: Matrix2<f64>,
    h: Matrix2x5<f64>,
    variance: f64,
}

impl Filter {
    /// The filter at the start, with the initial covariance.
    #[must_use]
    pub fn start(p: &PoseParameters) -> Self {
        let std = Vector5::new(
            p.initial.position_std_m,
            p.initial.position_std_m,
            p.initial.yaw_std_rad,
            p.initial.yaw_rate_bias_std_radps,
            p.initial.sideslip_per_yaw_rate_std_s,
        );
        Self {
            mean: Vector5::new(p.initial_pose.x, p.initial_pose.y, p.initial_pose.yaw, 0.0, 0.0),
            covariance: Matrix5::from_diagonal(&std.component_mul(&std)),
        }
    }

    /// Moves on over an interval.
    pub fn predict(&mut self, p: &PoseParameters, interval: &Interval) {
        let Interval { duration: t, yaw_rate, yaw_acceleration, speed: v } = *interval;
        let rate = yaw_rate - self.mean[BIAS];
        if v.abs() <= STANDSTILL_MPS && t > 0.0 {
            let variance = p.noise.yaw_rate_density.powi(2) / t;
            let whole = self.covariance[(BIAS, BIAS)] + variance;
            if variance.is_finite() && rate * rate <= TURNS * TURNS * whole {
                self.stand(p, interval, variance);
                return;
            }
        }
        let turn = rate * t;
        let sideslip = p.sideslip.at_speed(v);
        let leading = sideslip.per_yaw_acceleration * yaw_acceleration;
        let added = self.mean[SIDESLIP];
        let lateral = v * ((sideslip.in_turn(v * rate) + added) * rate + leading);
        // Its derivative by the yaw rate, for gyro noise and bias.
        let slip = v * (sideslip.by_yaw_rate(v * rate) + added);
        let (s, c) = mean_direction_of_arc(turn);
        let (s_slope, c_slope) = slopes_of_arc(turn, s, c);
        let world = rotation(self.mean[YAW]);
        let d = world * Vector2::new(t * (v * s - lateral * c), t * (v * c + lateral * s));
        let by_bias = world
            * Vector2::new(
                t * (t * (lateral * c_slope - v * s_slope) + slip * c),
                -t * (t * (v * c_slope + lateral * s_slope) + slip * s),
            );
        let by_sideslip = world * Vector2::new(-turn * v * c, turn * v * s);
        let mut f = Matrix5::identity();
        (f[(0, YAW)], f[(1, YAW)]) = (-d.y, d.x);
        (f[(0, BIAS)], f[(1, BIAS)]) = (by_bias.x, by_bias.y);
        (f[(0, SIDESLIP)], f[(1, SIDESLIP)]) = (by_sideslip.x, by_sideslip.y);
        f[(YAW, BIAS)] = -t;
        let noise = process_noise(p, t, &d, self.mean[YAW] + 0.5 * turn, slip, v * rate);
        self.covariance = f * self.covariance * f.transpose() + noise;
        self.bound_covariance();
        self.mean[0] += d.x;
        self.mean[1] += d.y;
        self.mean[YAW] += turn;
    }

    /// Moves on over an interval in which the vehicle stands; `variance` is that of the mean reading of the gyro.
    fn stand(&mut self, p: &PoseParameters, interval: &Interval, variance: f64) {
        let Interval { duration: t, yaw_rate, speed, .. } = *interval;
        let d = rotation(self.mean[YAW]) * Vector2::new(speed * t, 0.0);
        let mut f = Matrix5::identity();
        (f[(0, YAW)], f[(1, YAW)]) = (-d.y, d.x);
        self.covariance = f * self.covariance * f.transpose();
        let axes = rotation(self.mean[YAW]);
        let noise = &p.noise;
        let along = axes.column(0) * noise.speed_density;
        let across = axes.column(1) * noise.lateral_velocity_density;
        let grown = (along * along.transpose() + across * across.transpose()) * t;
        let mut position = self.covariance.fixed_view_mut::<2, 2>(0, 0);
        position += grown;
        self.covariance[(BIAS, BIAS)] += noise.yaw_rate_bias_density.powi(2) * t;
        self.covariance[(SIDESLIP, SIDESLIP)] += noise.sideslip_per_yaw_rate_density.powi(2) * t;
        self.mean[0] += d.x;
        self.mean[1] += d.y;

        let whole = self.covariance[(BIAS, BIAS)] + variance;
        // A bias and a gyro without noise leave nothing to correct.
        if whole > 0.0 {
            let gain = self.covariance.column(BIAS) / whole;
            self.mean += gain * (yaw_rate - self.mean[BIAS]);
            let mut kept = Matrix5::identity();
            kept.column_mut(BIAS).axpy(-1.0, &gain, 1.0);
            self.covariance =
                kept * self.covariance * kept.transpose() + gain * gain.transpose() * variance;
        }
        self.bound_covariance();
    }

    /// Where the antenna is expected, m.
    #[must_use]
    pub fn antenna(&self, p: &PoseParameters) -> Vector2<f64> {
        self.mean.xy()
            + rotation(self.mean[YAW]) * Vector2::new(p.gnss.antenna_x_m, p.gnss.antenna_y_m)
    }

    /// Holds a fix against the filter.
    #[must_use]
    pub fn innovation(&self, p: &PoseParameters, fix: Vector2<f64>, variance: f64) -> Innovation {
        let antenna = self.antenna(p);
        let arm = antenna - self.mean.xy();
        let mut h = Matrix2x5::zeros();
        (h[(0, 0)], h[(1, 1)]) = (1.0, 1.0);
        (h[(0, YAW)], h[(1, YAW)]) = (-arm.y, arm.x);
        let covariance = h * self.covariance * h.transpose() + Matrix2::identity() * variance;
        // One that is singular by rounding agrees with nothing.
        let inverse = covariance.try_inverse().unwrap_or(Matrix2::repeat(f64::NAN));
        let difference = fix - antenna;
        let normalised_square = difference.dot(&(inverse * difference));
        Innovation { difference, normalised_square, inverse, h, variance }
    }

    /// Corrects by a fix (Joseph's form, which keeps the covariance one).
    pub fn correct(&mut self, innovation: &Innovation) {
        let Innovation { difference, inverse, h, variance, .. } = innovation;
        let gain = self.covariance * h.transpose() * inverse;
        self.mean += gain * difference;
        let kept = Matrix5::identity() - gain * h;
        self.covariance =
            kept * self.covariance * kept.transpose() + gain * gain.transpose() * *variance;
        self.bound_covariance();
    }

    /// Standard deviation of the position in the direction in which it is largest, m.
    #[must_use]
    pub fn position_std(&self) -> f64 {
        let p = &self.covariance;
        let (mean, half) = (0.5 * (p[(0, 0)] + p[(1, 1)]), 0.5 * (p[(0, 0)] - p[(1, 1)]));
        (mean + half.hypot(p[(0, 1)])).max(0.0).sqrt()
    }

    /// Whether every number is one.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.mean.iter().chain(self.covariance.iter()).all(|value| value.is_finite())
    }

    /// Makes a covariance of what rounding has left of one: symmetric, no variance below zero, and no covariance
    /// beyond Schwarz's bound. Of numbers of very different sizes rounding is more than the small ones.
    fn bound_covariance(&mut self) {
        let c = &mut self.covariance;
        *c = (*c + c.transpose()) * 0.5;
        for i in 0..STATES {
            // One that is no number stays so, and is refused.
            if c[(i, i)] < 0.0 {
                c[(i, i)] = 0.0;
            }
            for j in 0..i {
                let (value, most) = (c[(i, j)], c[(i, i)] * c[(j, j)]);
                if value * value > most {
                    let bound = most.sqrt().copysign(value);
                    (c[(i, j)], c[(j, i)]) = (bound, bound);
                }
            }
        }
    }
}

/// R(angle).
#[must_use]
pub fn rotation(angle: f64) -> Matrix2<f64> {
    let (sin, cos) = sin_cos(angle);
    Matrix2::new(cos, -sin, sin, cos)
}

/// Derivatives of `sin θ/θ` and `(1 − cos θ)/θ`, whose values are s and c.
fn slopes_of_arc(turn: f64, s: f64, c: f64) -> (f64, f64) {
    let q = turn * turn;
    if turn.abs() <= 0.125 {
        let s_slope = turn * (-1.0 / 3.0 + q * (1.0 / 30.0 - q * (1.0 / 840.0 - q / 45_360.0)));
        let c_slope =
            0.5 - q * (1.0 / 8.0 - q * (1.0 / 144.0 - q * (1.0 / 5760.0 - q / 403_200.0)));
        return (s_slope, c_slope);
    }
    // cos θ is 1 − θ·c, sin θ is θ·s.
    ((1.0 - s) / turn - c, s - c / turn)
}

/// Covariance added by the noises over an interval.
fn process_noise(
    p: &PoseParameters,
    t: f64,
    d: &Vector2<f64>,
    heading: f64,
    slip: f64,
    acceleration: f64,
) -> Matrix5<f64> {
    if t <= 0.0 {
        return Matrix5::zeros();
    }
    let square = |x: f64| x * x;
    let (yaw_rate, bias) =
        (square(p.noise.yaw_rate_density), square(p.noise.yaw_rate_bias_density));
    let (along, across) = (square(p.noise.speed_density), square(p.noise.lateral_velocity_density));
    let sideslip = square(p.noise.sideslip_per_yaw_rate_density);
    let axes = rotation(heading);
    let (u, n) = (axes.column(0), axes.column(1));
    // e^{Aτ}·g_r = (a + c·τ, 1, 0) and e^{Aτ}·g_b = −(a·τ + c·τ²/2, τ, −1).
    // e^{Aτ}·g_σ = (w·τ, 0, 0, 1), w the acceleration v·r along n.
    let (a, c) = (n * slip, Vector2::new(-d.y, d.x) / t);
    let w = n * acceleration;
    let (aa, cc) = (a * a.transpose(), c * c.transpose());
    let ac = a * c.transpose() + c * a.transpose();
    let (t2, t3, t4, t5) = (t * t, t.powi(3), t.powi(4), t.powi(5));
    let position = (aa * t + ac * (t2 / 2.0) + cc * (t3 / 3.0)) * yaw_rate
        + (aa * (t3 / 3.0) + ac * (t4 / 8.0) + cc * (t5 / 20.0)) * bias
        + (u * u.transpose() * along + n * n.transpose() * across) * t
        + w * w.transpose() * (t3 / 3.0 * sideslip);
    let with_yaw = (a * t + c * (t2 / 2.0)) * yaw_rate + (a * (t3 / 3.0) + c * (t4 / 8.0)) * bias;
    let with_bias = -(a * (t2 / 2.0) + c * (t3 / 6.0)) * bias;
    let with_sideslip = w * (t2 / 2.0 * sideslip);
    let mut q = Matrix5::zeros();
    q.fixed_view_mut::<2, 2>(0, 0).copy_from(&position);
    q.fixed_view_mut::<2, 1>(0, YAW).copy_from(&with_yaw);
    q.fixed_view_mut::<1, 2>(YAW, 0).copy_from(&with_yaw.transpose());
    q.fixed_view_mut::<2, 1>(0, BIAS).copy_from(&with_bias);
    q.fixed_view_mut::<1, 2>(BIAS, 0).copy_from(&with_bias.transpose());
    q[(YAW, YAW)] = t * yaw_rate + t3 / 3.0 * bias;
    (q[(YAW, BIAS)], q[(BIAS, YAW)]) = (-t2 / 2.0 * bias, -t2 / 2.0 * bias);
    q[(BIAS, BIAS)] = t * bias;
    q.fixed_view_mut::<2, 1>(0, SIDESLIP).copy_from(&with_sideslip);
    q.fixed_view_mut::<1, 2>(SIDESLIP, 0).copy_from(&with_sideslip.transpose());
    q[(SIDESLIP, SIDESLIP)] = t * sideslip;
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sideslip::Sideslip;
    use steerwright_formats::SensorNoise;

    fn parameters() -> PoseParameters {
        PoseParameters {
            sideslip: Sideslip {
                per_yaw_rate: 0.07,
                growth: -0.0007,
                per_yaw_acceleration: 0.005,
                reference_speed: 10.0,
                distance_rear: 1.4,
            },
            ..PoseParameters::default()
        }
    }

    /// The Jacobian is that of the move: seen in how a covariance without noise is carried.
    #[test]
    fn jacobian_against_differences() {
        let quiet = PoseParameters {
            noise: SensorNoise {
                yaw_rate_density: 0.0,
                yaw_rate_bias_density: 0.0,
                speed_density: 0.0,
                lateral_velocity_density: 0.0,
                sideslip_per_yaw_rate_density: 0.0,
            },
            ..parameters()
        };
        for yaw_rate in [0.0, 0.4, -3.0] {
            let interval = Interval { duration: 0.3, yaw_rate, yaw_acceleration: 0.7, speed: 12.0 };
            let moved = |mean: Vector5<f64>| {
                let mut filter = Filter { mean, covariance: Matrix5::zeros() };
                filter.predict(&quiet, &interval);
                filter.mean
            };
            let mean = Vector5::new(3.0, -2.0, 0.8, 0.02, -0.03);
            for i in 0..STATES {
                let mut unit = Vector5::zeros();
                unit[i] = 1.0;
                let mut filter = Filter { mean, covariance: unit * unit.transpose() };
                filter.predict(&quiet, &interval);
                let h = 1e-5;
                let slope = (moved(mean + unit * h) - moved(mean - unit * h)) / (2.0 * h);
                let expected = slope * slope.transpose();
                let off = (filter.covariance - expected).amax();
                assert!(off < 1e-7 * (1.0 + expected.amax()), "{yaw_rate}, state {i}: {off}");
            }
        }
    }

    /// An interval is the sum of its parts: exactly in the mean, nearly so in the covariance.
    #[test]
    fn intervals_can_be_cut() {
        let mut whole = Filter::start(&parameters());
        let mut parts = whole;
        let interval =
            |duration| Interval { duration, yaw_rate: 0.3, yaw_acceleration: -0.5, speed: 15.0 };
        whole.predict(&parameters(), &interval(0.01));
        parts.predict(&parameters(), &interval(0.003));
        parts.predict(&parameters(), &interval(0.007));
        assert!((whole.mean - parts.mean).amax() < 1e-14);
        assert!((whole.covariance - parts.covariance).amax() < 1e-9);
    }

    /// The process noise by the definition, summed over many short pieces.
    #[test]
    fn noise_is_the_integral() {
        let p = PoseParameters {
            noise: SensorNoise {
                yaw_rate_bias_density: 0.02,
                sideslip_per_yaw_rate_density: 0.03,
                ..parameters().noise
            },
            ..parameters()
        };
        let (t, d, slip, acceleration) = (0.5, Vector2::new(5.0, 3.0), 0.9, 3.0);
        let heading: f64 = 0.4;
        let closed = process_noise(&p, t, &d, heading, slip, acceleration);
        let n = Vector2::new(-heading.sin(), heading.cos());
        let mut a = Matrix5::zeros();
        (a[(0, YAW)], a[(1, YAW)]) = (-d.y / t, d.x / t);
        (a[(0, BIAS)], a[(1, BIAS)]) = (-slip * n.x, -slip * n.y);
        a[(YAW, BIAS)] = -1.0;
        (a[(0, SIDESLIP)], a[(1, SIDESLIP)]) = (acceleration * n.x, acceleration * n.y);
        let g = |v: Vector5<f64>, q: f64| v * v.transpose() * (q * q);
        let density =
            g(Vector5::new(slip * n.x, slip * n.y, 1.0, 0.0, 0.0), p.noise.yaw_rate_density)
                + g(Vector5::new(0.0, 0.0, 0.0, 1.0, 0.0), p.noise.yaw_rate_bias_density)
                + g(Vector5::new(0.0, 0.0, 0.0, 0.0, 1.0), p.noise.sideslip_per_yaw_rate_density)
                + g(Vector5::new(n.y, -n.x, 0.0, 0.0, 0.0), p.noise.speed_density)
                + g(Vector5::new(n.x, n.y, 0.0, 0.0, 0.0), p.noise.lateral_velocity_density);
        let pieces = 20_000;
        let h = t / f64::from(pieces);
        let mut sum = Matrix5::zeros();
        for k in 0..pieces {
            let at = a * ((f64::from(k) + 0.5) * h);
            let e = Matrix5::identity() + at + at * at * 0.5;
            sum += e * density * e.transpose() * h;
        }
        assert!((closed - sum).amax() < 1e-9, "{closed} {sum}");
    }

    #[test]
    fn slopes_meet_where_their_formulas_change() {
        for turn in [0.124_999_9, 0.125_000_1, -2.0, 0.05] {
            let (s, c) = mean_direction_of_arc(turn);
            let (s_slope, c_slope) = slopes_of_arc(turn, s, c);
            let h = 1e-5;
            let (high, low) = (mean_direction_of_arc(turn + h), mean_direction_of_arc(turn - h));
            assert!((s_slope - (high.0 - low.0) / (2.0 * h)).abs() < 1e-9, "{turn}");
            assert!((c_slope - (high.1 - low.1) / (2.0 * h)).abs() < 1e-9, "{turn}");
        }
    }
}
