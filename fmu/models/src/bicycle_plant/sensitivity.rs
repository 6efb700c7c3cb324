//! The bicycle plant's derivatives by time, states and inputs, at a communication point.
//!
//! States: v_y (m/s), r (rad/s), δ (rad), ψ (rad), X, Y (m). F and G depend on the speed, so the
//! partial derivatives by it are `∂F/∂v·w`.

use super::BicyclePlant;
use crate::sensitivity::{Factor, Known, Unknown};
use crate::trigonometry::sin_cos;

/// Index of yaw among the states.
const YAW: usize = 3;

impl BicyclePlant {
    /// A state: v_y, r, δ, ψ, X, Y.
    #[must_use]
    pub fn state(&self, index: usize) -> f64 {
        match index {
            0..YAW => self.w[index],
            YAW => self.pose.yaw,
            4 => self.pose.x,
            _ => self.pose.y,
        }
    }

    /// The derivative of a state by time, at the present inputs.
    #[must_use]
    pub fn state_rate(&self, index: usize) -> f64 {
        let (sin, cos) = sin_cos(self.pose.yaw);
        match index {
            0..YAW => self.rates()[index],
            YAW => self.w[1],
            4 => self.speed * cos - self.w[0] * sin,
            _ => self.speed * sin + self.w[0] * cos,
        }
    }

    /// Derivative of the lateral acceleration `v̇_y + v·r` at held speed, m/s³.
    #[must_use]
    pub fn lateral_jerk(&self) -> f64 {
        let rates = self.rates();
        self.dynamics().lateral_rate(&rates) + self.speed * rates[1]
    }

    /// `∂unknown/∂known` at the present values; `None` where it is zero whatever they are.
    #[must_use]
    pub fn partial(&self, unknown: Unknown, known: Known) -> Option<Factor> {
        match unknown {
            Unknown::YawRate => self.partial(Unknown::State(1), known),
            Unknown::State(i) => {
                if known == Known::State(i) {
                    Some(Factor::Constant(1.0))
                } else {
                    None
                }
            }
            Unknown::LateralAcceleration => {
                let rate = self.partial(Unknown::Rate(0), known)?.value();
                let through_yaw_rate = match known {
                    Known::State(1) => self.speed,
                    Known::Speed => self.w[1],
                    _ => 0.0,
                };
                Some(Factor::Dependent(rate + through_yaw_rate))
            }
            Unknown::Rate(0) => self.lateral_by(0, known),
            Unknown::Rate(1) => self.lateral_by(1, known),
            Unknown::Rate(2) => {
                // At its largest rate the wheel depends on nothing.
                let is_free = self.wheel_rate().abs() < self.started.actuator_rate_max;
                let slope = match known {
                    Known::State(2) => -1.0 / self.coefficients.tn,
                    // A delay leaves no dependency on the present angle.
                    Known::SteeringAngle if self.started.actuator_delay == 0.0 => {
                        self.dynamics().gain
                    }
                    Known::SteeringAngle => 0.0,
                    _ => return None,
                };
                Some(Factor::Dependent(if is_free { slope } else { 0.0 }))
            }
            Unknown::Rate(YAW) => {
                if known == Known::State(1) {
                    Some(Factor::Constant(1.0))
                } else {
                    None
                }
            }
            Unknown::Rate(i) => {
                let (sin, cos) = sin_cos(self.pose.yaw);
                let (ahead, left) = if i == 4 { (cos, -sin) } else { (sin, cos) };
                match known {
                    Known::Speed => Some(Factor::Dependent(ahead)),
                    Known::State(0) => Some(Factor::Dependent(left)),
                    // Turning the vehicle turns ahead to the left, and left to the back.
                    Known::State(YAW) => {
                        Some(Factor::Dependent(self.speed * left - self.w[0] * ahead))
                    }
                    _ => None,
                }
            }
        }
    }

    /// Row of F, and its derivative by the speed.
    fn lateral_by(&self, row: usize, known: Known) -> Option<Factor> {
        let dynamics = self.dynamics();
        Some(Factor::Dependent(match known {
            Known::State(column @ (0 | 1)) => dynamics.lateral[2 * row + column],
            Known::State(2) => dynamics.steer[row],
            Known::Speed => self.rate_by_speed()[row],
            _ => return None,
        }))
    }

    /// ẇ.
    fn rates(&self) -> [f64; 3] {
        let [lateral, yaw, _] = self.dynamics().times(&self.w);
        [lateral, yaw, self.wheel_rate()]
    }

    /// δ̇.
    fn wheel_rate(&self) -> f64 {
        let dynamics = self.dynamics();
        let (steering, _) = self.delay.output(self.steering_angle, self.steering_rate);
        let rate = dynamics.times(&self.w)[2] + dynamics.gain * steering;
        let most = self.started.actuator_rate_max;
        rate.clamp(-most, most)
    }
}
