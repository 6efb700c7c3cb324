//! The bicycle plant: the body-frame form of eq 13 with yaw and position.
//!
//! States (v_y, r, ψ, δ, X, Y); steering and speed are held within a step. With
//! `ẇ = F(V)·w + G·u` for w = (v_y, r, δ) as in [`crate::bicycle`],
//!
//! ```text
//! ψ̇  = r
//! X' = v cos ψ − v_y sin ψ,   Y' = v sin ψ + v_y cos ψ
//! ```
//!
//! **Exact for every step and speed.** The matrix exponential acts on the states through its
//! Taylor series, `w(τ) = w + Σ τᵏ/k!·Fᵏ⁻¹·ẇ`, summed to the last bit over panels shorter than the
//! fastest time constant. Three states make a term cheaper than looking up a cached matrix would
//! pay for, and a speed that changes at every step costs the same as a constant one. The same
//! terms give v_y and ψ at the quadrature's nodes.
//!
//! **Below 1 m/s** ([`BLEND_SPEED`]) the rates ∝ 1/V would grow without bound. There the states
//! approach the steady turn of the present speed with the dynamics of 1 m/s:
//!
//! ```text
//! (v̇_y, ṙ) = F(1 m/s)·((v_y, r) − s(v)·δ),   s(v) = (Lr − m·Lf·v²/(Cr·L), 1)·v/(L + K·v²)
//! ```
//!
//! At 1 m/s this is the model itself, since `F(v)·s(v)` is minus the column of δ; towards standstill
//! s becomes the kinematic `r = v·δ/L`, `v_y = Lr·r`, and at v = 0 the vehicle stands. It is
//! continuous in v, and divides by nothing that can be zero.

use crate::bicycle::{BLEND_SPEED, BicycleParameters, Coefficients};
use crate::error::Error;
use crate::identified_plant::LONGEST_STEP;
use crate::quadrature::{LONGEST_PANEL, NODE, NODES, Pose, WEIGHT, panels, sin_cos_small};

/// More terms than the series ever needs where the panel is shorter than the time constants.
const MOST_TERMS: usize = 60;

/// 1/k, since a division costs ten multiplications.
const RECIPROCAL: [f64; MOST_TERMS + 1] = {
    let mut table = [1.0; MOST_TERMS + 1];
    let mut k = 2;
    while k <= MOST_TERMS {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// A vehicle that moves by eq 13. Its clone is its whole state.
#[derive(Debug, Clone, PartialEq)]
pub struct BicyclePlant {
    /// The vehicle. Read at the start.
    pub parameters: BicycleParameters,
    /// Input: steering angle, rad.
    pub steering_angle: f64,
    /// Input: speed, m/s.
    pub speed: f64,
    /// Position at the start, m.
    pub initial_x: f64,
    /// Position at the start, m.
    pub initial_y: f64,
    /// Yaw at the start, rad.
    pub initial_yaw: f64,
    started: BicycleParameters,
    coefficients: Coefficients,
    pose: Pose,
    /// v_y, r, δ.
    w: [f64; 3],
}

/// `ẇ = F w + G u` at one speed.
struct Dynamics {
    lateral: [f64; 4],
    /// Column of δ.
    steer: [f64; 2],
    /// 1/Tn.
    lag: f64,
    fastest_rate: f64,
}

impl Dynamics {
    #[inline]
    fn times(&self, w: &[f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = self.lateral;
        [
            a * w[0] + b * w[1] + self.steer[0] * w[2],
            c * w[0] + d * w[1] + self.steer[1] * w[2],
            -self.lag * w[2],
        ]
    }
}

impl BicyclePlant {
    /// A vehicle at the origin, at 15 m/s, driving straight, started.
    ///
    /// # Errors
    /// Where the parameters are not those of a vehicle.
    pub fn new(parameters: BicycleParameters) -> Result<Self, Error> {
        parameters.check()?;
        Ok(Self {
            parameters,
            steering_angle: 0.0,
            speed: 15.0,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            started: parameters,
            coefficients: parameters.coefficients(),
            pose: Pose::default(),
            w: [0.0; 3],
        })
    }

    /// Takes over the parameters and puts the vehicle at its initial pose, driving straight.
    ///
    /// # Errors
    /// Where the parameters are not those of a vehicle.
    pub fn start(&mut self) -> Result<(), Error> {
        self.parameters.check()?;
        self.started = self.parameters;
        self.coefficients = self.parameters.coefficients();
        self.pose = Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw };
        self.w = [0.0; 3];
        Ok(())
    }

    /// Advances by `h` seconds with the inputs as they are.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]], or the states grow beyond all numbers, as they do
    /// far above the critical speed of an oversteering vehicle.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        if !(h > 0.0 && h <= LONGEST_STEP) {
            return Err(Error::Step { step: h, limit: LONGEST_STEP });
        }
        let dynamics = self.dynamics();
        let longest = if dynamics.fastest_rate * LONGEST_PANEL > 1.0 {
            1.0 / dynamics.fastest_rate
        } else {
            LONGEST_PANEL
        };
        let (count, panel) = panels(h, longest);
        for _ in 0..count {
            self.move_exactly(&dynamics, panel);
        }
        if self.pose.x.is_finite() && self.pose.y.is_finite() {
            Ok(())
        } else {
            Err(Error::Diverged { name: "yaw rate", value: self.w[1] })
        }
    }

    /// Yaw rate r, rad/s.
    #[inline]
    #[must_use]
    pub fn yaw_rate(&self) -> f64 {
        self.w[1]
    }

    /// Yaw ψ, rad, not wrapped.
    #[inline]
    #[must_use]
    pub fn yaw(&self) -> f64 {
        self.pose.yaw
    }

    /// Position of the centre of gravity, m.
    #[inline]
    #[must_use]
    pub fn x(&self) -> f64 {
        self.pose.x
    }

    /// Position of the centre of gravity, m.
    #[inline]
    #[must_use]
    pub fn y(&self) -> f64 {
        self.pose.y
    }

    /// Lateral velocity v_y of the centre of gravity, m/s.
    #[inline]
    #[must_use]
    pub fn lateral_velocity(&self) -> f64 {
        self.w[0]
    }

    /// Lateral acceleration of the centre of gravity, `v̇_y + v·r`, m/s², at the present speed.
    #[must_use]
    pub fn lateral_acceleration(&self) -> f64 {
        self.dynamics().times(&self.w)[0] + self.speed * self.w[1]
    }

    /// Road-wheel angle δ behind the actuator's lag, rad.
    #[must_use]
    pub fn road_wheel_angle(&self) -> f64 {
        self.w[2]
    }

    /// The dynamics at the present speed.
    fn dynamics(&self) -> Dynamics {
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
            let [a, b, c, d] = lateral;
            [-(a * lateral_velocity + b * yaw_rate), -(c * lateral_velocity + d * yaw_rate)]
        };
        Dynamics { lateral, steer, lag: 1.0 / k.tn, fastest_rate: k.fastest_rate(speed) }
    }

    /// One panel, by the Taylor series of the matrix exponential.
    fn move_exactly(&mut self, dynamics: &Dynamics, panel: f64) {
        let mut rate = dynamics.times(&self.w);
        rate[2] += self.steering_angle * self.coefficients.n * dynamics.lag;

        let mut end = self.w;
        let mut yaw_increment = panel * self.w[1];
        let mut yaw_at = NODE.map(|s| yaw_increment * s);
        let mut lateral_at = [self.w[0]; NODES];
        let mut power = NODE;
        let mut term = rate.map(|x| x * panel);
        for reciprocal in &RECIPROCAL[2..] {
            // For k = 1, 2, …, term is τᵏ/k!·Fᵏ⁻¹·ẇ at the panel's end, at a node that times nodeᵏ;
            // `reciprocal` is 1/(k+1).
            let to_yaw = panel * term[1] * reciprocal;
            for i in 0..NODES {
                lateral_at[i] += power[i] * term[0];
                power[i] *= NODE[i];
                yaw_at[i] += power[i] * to_yaw;
            }
            yaw_increment += to_yaw;
            let mut changed = false;
            for (sum, term) in end.iter_mut().zip(term) {
                let before = *sum;
                *sum += term;
                changed |= *sum != before;
            }
            if !changed {
                break;
            }
            let scale = panel * reciprocal;
            term = dynamics.times(&term).map(|x| x * scale);
        }

        let (mut along, mut across) = (0.0, 0.0);
        for i in 0..NODES {
            let (sin, cos) = sin_cos_small(yaw_at[i]);
            along += WEIGHT[i] * (self.speed * cos - lateral_at[i] * sin);
            across += WEIGHT[i] * (self.speed * sin + lateral_at[i] * cos);
        }
        self.pose.advance(panel * along, panel * across, yaw_increment);
        self.w = end;
    }
}
