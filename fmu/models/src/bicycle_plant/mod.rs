//! The bicycle plant: the body-frame form of eq 13 ([`crate::bicycle`]) with yaw and position.
//!
//! States (v_y, r, δ), then ψ, X, Y, and the steering angle of the last `actuator_delay` seconds; the README of `fmu/bicycle-plant` has the equations. Within a step the
//! speed is held, and the steering angle held or ramped. The matrix exponential acts on the states through
//! its Taylor series, `w(τ) = w + τ·ẇ + Σ τᵏ/k!·Fᵏ⁻²·ẅ` from k = 2 with `ẅ = F·ẇ + G·u̇`, summed to the last
//! bit over panels shorter than the fastest time constant. Three states make a term cheaper than looking
//! up a cached matrix, and a speed that changes at every step costs the same as a constant one.
//!
//! Below 1 m/s ([`BLEND_SPEED`](crate::limits::BLEND_SPEED)) the rates ∝ 1/V would grow without bound.
//! There the states approach the steady turn of the present speed with the dynamics of 1 m/s:
//!
//! ```text
//! (v̇_y, ṙ) = F(1 m/s)·((v_y, r) − s(v)·δ),   s(v) = (Lr − m·Lf·v²/(Cr·L), 1)·v/(L + K·v²)
//! ```
//!
//! This is continuous in v, since `F(v)·s(v)` at 1 m/s is minus the column of δ.

use crate::Error;
use crate::bicycle::BicycleParameters;
use crate::delay::DelayLine;
use crate::quadrature::{Pose, pose_getters};
use steerwright_formats::BicycleCoefficients;

mod dynamics;
mod saved;
mod sensitivity;
mod stepping;

pub use saved::SavedBicyclePlant;

/// A vehicle that moves by eq 13. Its clone is its whole state.
#[derive(Debug, Clone, PartialEq)]
pub struct BicyclePlant {
    /// The vehicle. Read at the start.
    pub parameters: BicycleParameters,
    /// Input: steering angle, rad, at the beginning of a step.
    pub steering_angle: f64,
    /// Its derivative within a step, rad/s; 0 holds it.
    pub steering_rate: f64,
    /// Input: speed, m/s.
    pub speed: f64,
    /// Position at the start, m.
    pub initial_x: f64,
    /// Position at the start, m.
    pub initial_y: f64,
    /// Yaw at the start, rad.
    pub initial_yaw: f64,
    /// v_y (m/s), r (rad/s) and δ (rad) at the start.
    pub initial_states: [f64; 3],
    started: BicycleParameters,
    coefficients: BicycleCoefficients,
    delay: DelayLine,
    pose: Pose,
    /// v_y, r, δ.
    w: [f64; 3],
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
            steering_rate: 0.0,
            speed: 15.0,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            initial_states: [0.0; 3],
            started: parameters,
            coefficients: parameters.coefficients(),
            delay: DelayLine::new(parameters.actuator_delay, 0.0),
            pose: Pose::default(),
            w: [0.0; 3],
        })
    }

    /// Takes over the parameters and puts the vehicle at its initial pose and in its initial states.
    ///
    /// # Errors
    /// Where the parameters are not those of a vehicle.
    pub fn start(&mut self) -> Result<(), Error> {
        self.parameters.check()?;
        self.started = self.parameters;
        self.coefficients = self.parameters.coefficients();
        self.pose = Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw };
        self.w = self.initial_states;
        // The wheel has rested where it is.
        let angle = self.w[2] * self.started.steering_ratio;
        self.delay = DelayLine::new(self.started.actuator_delay, angle);
        Ok(())
    }

    /// Yaw rate r, rad/s.
    #[inline]
    #[must_use]
    pub fn yaw_rate(&self) -> f64 {
        self.w[1]
    }

    pose_getters!();

    /// Lateral velocity v_y of the centre of gravity, m/s.
    #[inline]
    #[must_use]
    pub fn lateral_velocity(&self) -> f64 {
        self.w[0]
    }

    /// Lateral acceleration of the centre of gravity, `v̇_y + v·r`, m/s², at the present speed.
    #[must_use]
    pub fn lateral_acceleration(&self) -> f64 {
        self.dynamics().lateral_rate(&self.w) + self.speed * self.w[1]
    }

    /// Road-wheel angle δ behind the actuator's lag, rad.
    #[must_use]
    pub fn road_wheel_angle(&self) -> f64 {
        self.w[2]
    }
}
