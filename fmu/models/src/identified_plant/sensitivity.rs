//! The identified plant's derivatives by time, states and inputs, at a communication point: those of the
//! equations in the README of `fmu/identified-plant`. A delay leaves no dependency on the present inputs.

use super::IdentifiedPlant;
use crate::noise::gaussian;
use crate::sensitivity::{Factor, Known, Unknown};
use crate::trigonometry::sin_cos;

impl IdentifiedPlant {
    /// Continuous states of the model: its order, or none without a continuous form; yaw, x, y come after.
    #[must_use]
    pub fn model_states(&self) -> usize {
        if self.model.continuous().is_some() { self.model.order() } else { 0 }
    }

    /// A state: the model's, then yaw (rad), x, y (m).
    #[must_use]
    pub fn state(&self, index: usize) -> f64 {
        let n = self.model_states();
        match index.checked_sub(n) {
            None => self.states[index],
            Some(0) => self.pose.yaw,
            Some(1) => self.pose.x,
            Some(_) => self.pose.y,
        }
    }

    /// The derivative of a state by time, at the present inputs.
    #[must_use]
    pub fn state_rate(&self, index: usize) -> f64 {
        let (sin, cos) = sin_cos(self.pose.yaw);
        match (index.checked_sub(self.model_states()), self.model.continuous()) {
            (None, Some(model)) => model.derivative(index, self.states(), self.delayed_input().0),
            (None, None) => 0.0,
            (Some(0), _) => self.noise_free_yaw_rate(),
            (Some(1), _) => self.speed * (cos - self.sideslip() * sin),
            (Some(_), _) => self.speed * (sin + self.sideslip() * cos),
        }
    }

    /// Sideslip β: lateral over longitudinal velocity.
    fn sideslip(&self) -> f64 {
        let here = self.model.data().sideslip.at_speed(self.speed);
        if [here.per_yaw_rate, here.growth, here.per_yaw_acceleration] == [0.0; 3] {
            return 0.0;
        }
        let rate = self.noise_free_yaw_rate();
        let lead = match here.per_yaw_acceleration {
            0.0 => 0.0,
            c => c * self.yaw_acceleration(),
        };
        here.in_turn(self.speed * rate) * rate + lead
    }

    /// Derivative of the yaw rate without noise, rad/s²; zero where it is held.
    #[must_use]
    pub fn yaw_acceleration(&self) -> f64 {
        let Some(model) = self.model.continuous() else { return 0.0 };
        let (u, slope) = self.delayed_input();
        let states = (0..model.order()).map(|i| model.h[i] * model.derivative(i, self.states(), u));
        states.sum::<f64>() + model.d * slope
    }

    /// `∂unknown/∂known` at the present values; `None` where it is zero whatever they are.
    #[must_use]
    pub fn partial(&self, unknown: Unknown, known: Known) -> Option<Factor> {
        let n = self.model_states();
        match unknown {
            Unknown::YawRate if known == Known::NoiseScale => {
                let std = self.model.data().innovation_std;
                let number = gaussian(self.noise_seed, 0);
                if std != 0.0 { Some(Factor::Dependent(std * number)) } else { None }
            }
            Unknown::YawRate => self.yaw_rate_by(known),
            Unknown::LateralAcceleration => None,
            Unknown::State(i) => {
                if known == Known::State(i) {
                    Some(Factor::Constant(1.0))
                } else {
                    None
                }
            }
            Unknown::Rate(i) if i < n => self.model_rate_by(i, known),
            Unknown::Rate(i) if i == n => self.yaw_rate_by(known),
            Unknown::Rate(i) => self.velocity_by(i == n + 1, known),
        }
    }

    /// Of `v·(direction + β·turned)`, the velocity along x or y.
    fn velocity_by(&self, is_x: bool, known: Known) -> Option<Factor> {
        let n = self.model_states();
        let (sin, cos) = sin_cos(self.pose.yaw);
        let (direction, turned) = if is_x { (cos, -sin) } else { (sin, cos) };
        let slip = self.sideslip();
        let own = match known {
            Known::Speed => Some(direction + slip * turned),
            Known::State(j) if j == n => Some(self.speed * (turned - slip * direction)),
            _ => None,
        };
        let by_sideslip = self.sideslip_by(known).map(|beta| self.speed * turned * beta);
        match (own, by_sideslip) {
            (None, None) => None,
            (own, other) => Some(Factor::Dependent(own.unwrap_or(0.0) + other.unwrap_or(0.0))),
        }
    }

    /// Of β, by way of r, of ṙ and of the speed itself.
    fn sideslip_by(&self, known: Known) -> Option<f64> {
        let law = self.model.data().sideslip;
        let here = law.at_speed(self.speed);
        let rate = self.noise_free_yaw_rate();
        let turning = here.by_yaw_rate(self.speed * rate);
        let turns = law.per_yaw_rate != 0.0 || law.growth != 0.0 || law.distance_rear != 0.0;
        let leads = law.per_yaw_acceleration != 0.0;
        let steady = turns.then(|| self.yaw_rate_by(known)).flatten();
        let lead = leads.then(|| self.yaw_acceleration_by(known)).flatten();
        let varies = law.growth != 0.0 || law.distance_rear != 0.0;
        let by_speed = if varies && known == Known::Speed {
            let yaw_acceleration = if leads { self.yaw_acceleration() } else { 0.0 };
            Some(law.by_speed(self.speed, rate, yaw_acceleration))
        } else {
            None
        };
        let parts = [
            steady.map(|r| turning * r.value()),
            lead.map(|r| here.per_yaw_acceleration * r),
            by_speed,
        ];
        let zero = parts.iter().all(Option::is_none);
        if zero { None } else { Some(parts.into_iter().flatten().sum()) }
    }

    /// Row of H·F, H·G and, for a product that the speed is a factor of, of D.
    fn yaw_acceleration_by(&self, known: Known) -> Option<f64> {
        let model = self.model.continuous()?;
        let n = model.order();
        let data = self.model.data();
        match known {
            Known::State(j) if j < n => {
                let entry: f64 = (0..n).map(|i| model.h[i] * model.f[i * n + j]).sum();
                if entry != 0.0 { Some(entry) } else { None }
            }
            _ => {
                let gain: f64 = model.h.iter().zip(&model.g).map(|(h, g)| h * g).sum();
                let by_input = self.input_by(known, gain).map(Factor::value);
                let product = self.model.input_is_product() && data.delay == 0.0;
                let by_slope = if known == Known::Speed && product && data.d != 0.0 {
                    Some(data.d * self.steering_rate)
                } else {
                    None
                };
                match (by_input, by_slope) {
                    (None, None) => None,
                    (a, b) => Some(a.unwrap_or(0.0) + b.unwrap_or(0.0)),
                }
            }
        }
    }

    /// Row of H and D.
    fn yaw_rate_by(&self, known: Known) -> Option<Factor> {
        let d = self.model.data().d;
        match (known, self.model.continuous()) {
            (Known::State(j), Some(model)) if j < model.order() => Factor::constant(model.h[j]),
            (_, Some(_)) => self.input_by(known, d),
            (_, None) => {
                // The input acts where it is sampled.
                let factor = self.input_by(known, d)?.value();
                Some(Factor::Dependent(if self.is_held() { 0.0 } else { factor }))
            }
        }
    }

    /// Row of F and G.
    fn model_rate_by(&self, i: usize, known: Known) -> Option<Factor> {
        let model = self.model.continuous()?;
        let n = model.order();
        match known {
            Known::State(j) if j < n => Factor::constant(model.f[i * n + j]),
            _ => self.input_by(known, model.g[i]),
        }
    }

    /// `gain·∂u/∂known`, u the model's input as of now.
    fn input_by(&self, known: Known, gain: f64) -> Option<Factor> {
        if gain == 0.0 || self.model.data().delay > 0.0 {
            return None;
        }
        let product = self.model.input_is_product();
        match known {
            Known::SteeringAngle if product => Some(Factor::Dependent(gain * self.speed)),
            Known::SteeringAngle => Some(Factor::Constant(gain)),
            Known::Speed if product => {
                let steering = self.steering_angle - self.model.data().steering_offset;
                Some(Factor::Dependent(gain * steering))
            }
            _ => None,
        }
    }
}
