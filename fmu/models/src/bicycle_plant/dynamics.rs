//! `ẇ = F(v)·w + G·u` for w = (v_y, r, δ) at one speed, blended below [`BLEND_SPEED`] (see [`super`]).

use super::BicyclePlant;
use crate::limits::BLEND_SPEED;

/// F and G at one speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dynamics {
    /// (v_y, r) by (v_y, r), row by row.
    pub(super) lateral: [f64; 4],
    /// Column of δ.
    pub(super) steer: [f64; 2],
    /// 1/Tn.
    pub(super) lag: f64,
    /// δ̇ by the steering angle: G.
    pub(super) gain: f64,
    pub(super) fastest_rate: f64,
}

impl Dynamics {
    /// `F w`.
    #[inline]
    pub(super) fn times(&self, w: &[f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = self.lateral;
        [
            a * w[0] + b * w[1] + self.steer[0] * w[2],
            c * w[0] + d * w[1] + self.steer[1] * w[2],
            -self.lag * w[2],
        ]
    }

    /// v̇_y.
    pub(super) fn lateral_rate(&self, w: &[f64; 3]) -> f64 {
        self.times(w)[0]
    }
}

impl BicyclePlant {
    /// The dynamics at the present speed.
    pub(super) fn dynamics(&self) -> Dynamics {
        let k = &self.coefficients;
        let speed = self.speed.max(BLEND_SPEED);
        let lateral = k.lateral(speed);
        let steer = if self.speed >= BLEND_SPEED {
            [k.b1, k.b2]
        } else {
            let p = &self.started;
            let v = self.speed;
            let yaw_rate = v / (p.wheelbase() + p.understeer_gradient() * v * v);
            let lateral_velocity = p.lateral_velocity_per_yaw_rate(v) * yaw_rate;
            // In the second row of F(1 m/s)·s(v) all but B2·v cancels.
            [-(lateral[0] * lateral_velocity + lateral[1] * yaw_rate), k.b2 * v]
        };
        let lag = 1.0 / k.tn;
        Dynamics { lateral, steer, lag, gain: k.n * lag, fastest_rate: k.fastest_rate(speed) }
    }

    /// `∂ẇ/∂v` for (v̇_y, ṙ); at [`BLEND_SPEED`] that from above.
    pub(super) fn rate_by_speed(&self) -> [f64; 2] {
        let k = &self.coefficients;
        let [lateral_velocity, yaw_rate, wheel] = self.w;
        let v = self.speed;
        if v >= BLEND_SPEED {
            // F(v) = 1/v·(A1 A2; A3 A4) − (0 v; 0 0).
            let by = -1.0 / (v * v);
            return [
                by * (k.a1 * lateral_velocity + k.a2 * yaw_rate) - yaw_rate,
                by * (k.a3 * lateral_velocity + k.a4 * yaw_rate),
            ];
        }
        // Only s(v) moves: s = (p·g, g) with g = v/(L + K·v²) and p = Lr − m·Lf·v²/(Cr·L).
        let p = &self.started;
        let (length, gradient) = (p.wheelbase(), p.understeer_gradient());
        let below = length + gradient * v * v;
        let (g, g_by_v) = (v / below, (length - gradient * v * v) / (below * below));
        let per_yaw_rate = p.lateral_velocity_per_yaw_rate(v);
        let [_, rear] = p.axle_stiffness();
        let per_yaw_rate_by_v = -2.0 * p.mass * p.distance_front * v / (rear * length);
        let s_by_v = [per_yaw_rate_by_v * g + per_yaw_rate * g_by_v, g_by_v];
        let [a, b, ..] = k.lateral(BLEND_SPEED);
        [-wheel * (a * s_by_v[0] + b * s_by_v[1]), wheel * k.b2]
    }
}
