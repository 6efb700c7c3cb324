//! The two-wheel bicycle model of eq 13, and its body-frame form; coefficients and equations are in
//! `docs/methods/bicycle.md`.
//!
//! Eq 13 has the states `X = (y, ẏ, ψ, ψ̇, δ)`, y and ψ in a frame fixed to a straight road, δ the
//! steering angle behind an actuator lag `Tn`. The body-frame form has the states (v_y, r, δ), δ at the
//! road wheel. With `v_y = ẏ − V·ψ` and `r = ψ̇` it is eq 13 at constant speed, and unlike eq 13 it stays
//! right when the speed changes, since ẏ of eq 13 would leak into v_y.

use crate::Error;
use crate::limits::{BLEND_SPEED, FASTEST_RATE};
use crate::numbers::as_numbers;
use crate::sideslip::Sideslip;
use nalgebra::{SMatrix, SVector};
use steerwright_formats::{BicycleCoefficients, VehicleData};

/// Longest delay of the steering actuator, s.
pub const LONGEST_DELAY: f64 = 10.0;

/// A rate of the road wheels that nothing reaches, rad/s.
pub const UNLIMITED_RATE: f64 = 1e6;

/// A vehicle as the bicycle model sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BicycleParameters {
    /// Mass m, kg.
    pub mass: f64,
    /// Yaw inertia J, kg·m².
    pub yaw_inertia: f64,
    /// Centre of gravity to front axle Lf, m.
    pub distance_front: f64,
    /// Centre of gravity to rear axle Lr, m.
    pub distance_rear: f64,
    /// Cornering stiffness of the front axle Cf, N/rad.
    pub cornering_stiffness_front: f64,
    /// Cornering stiffness of the rear axle Cr, N/rad.
    pub cornering_stiffness_rear: f64,
    /// Time constant of the steering actuator Tn, s.
    pub actuator_time_constant: f64,
    /// Pure delay of the steering angle before the actuator, s.
    pub actuator_delay: f64,
    /// Largest rate of the road wheels, rad/s; [`UNLIMITED_RATE`] where none is known.
    pub actuator_rate_max: f64,
    /// Steering angle over road-wheel angle, 1/n.
    pub steering_ratio: f64,
}

as_numbers!(BicycleParameters: mass yaw_inertia distance_front distance_rear cornering_stiffness_front
    cornering_stiffness_rear actuator_time_constant actuator_delay actuator_rate_max steering_ratio);

impl Default for BicycleParameters {
    /// The parameters of [`VehicleData::default`].
    fn default() -> Self {
        Self::from(&VehicleData::default())
    }
}

impl From<&VehicleData> for BicycleParameters {
    /// The vehicle of `bicycle.json`. Its speed is no parameter but an input of the plant.
    fn from(vehicle: &VehicleData) -> Self {
        Self {
            mass: vehicle.mass_kg,
            yaw_inertia: vehicle.yaw_inertia_kgm2,
            distance_front: vehicle.distance_front_m,
            distance_rear: vehicle.distance_rear_m,
            cornering_stiffness_front: vehicle.cornering_stiffness_front_npr,
            cornering_stiffness_rear: vehicle.cornering_stiffness_rear_npr,
            actuator_time_constant: vehicle.actuator_time_constant_s,
            actuator_delay: vehicle.actuator_delay_s,
            actuator_rate_max: vehicle.actuator_rate_max_radps.unwrap_or(UNLIMITED_RATE),
            steering_ratio: vehicle.steering_ratio,
        }
    }
}

impl BicycleParameters {
    /// Checks that this can be a vehicle: positive values, stable and not absurdly fast at walking pace.
    ///
    /// # Errors
    /// Names the value that is wrong.
    pub fn check(&self) -> Result<(), Error> {
        for (name, value) in [
            ("the mass", self.mass),
            ("the yaw inertia", self.yaw_inertia),
            ("the distance to the front axle", self.distance_front),
            ("the distance to the rear axle", self.distance_rear),
            ("the front cornering stiffness", self.cornering_stiffness_front),
            ("the rear cornering stiffness", self.cornering_stiffness_rear),
            ("the actuator's time constant", self.actuator_time_constant),
            ("the actuator's largest rate", self.actuator_rate_max),
            ("the steering ratio", self.steering_ratio),
        ] {
            if !value.is_finite() {
                return Err(Error::NotFinite { name, value });
            }
            if value <= 0.0 {
                return Err(Error::NotPositive { name, value });
            }
        }
        let (name, value) = ("the actuator's delay", self.actuator_delay);
        if !(0.0..=LONGEST_DELAY).contains(&value) {
            return Err(Error::Range { name, value, min: 0.0, max: LONGEST_DELAY });
        }
        if let Some(critical_speed) = self.critical_speed()
            && critical_speed <= BLEND_SPEED
        {
            return Err(Error::CriticalSpeed { critical_speed, limit: BLEND_SPEED });
        }
        let rate = self.coefficients().fastest_rate(BLEND_SPEED);
        // A NaN, of parameters that overflow, is too fast as well.
        if rate.is_nan() || rate > FASTEST_RATE {
            return Err(Error::TooFast { rate, limit: FASTEST_RATE });
        }
        Ok(())
    }

    /// The coefficients of eq 13.
    #[must_use]
    pub fn coefficients(&self) -> BicycleCoefficients {
        BicycleCoefficients::new(
            [self.mass, self.yaw_inertia],
            [self.distance_front, self.distance_rear],
            self.axle_stiffness(),
            self.steering_ratio,
            self.actuator_time_constant,
        )
    }

    /// Lateral force over slip of the front and the rear axle at small slip, N/rad.
    #[must_use]
    pub fn axle_stiffness(&self) -> [f64; 2] {
        [self.cornering_stiffness_front, self.cornering_stiffness_rear]
    }

    /// Wheelbase L, m.
    #[must_use]
    pub fn wheelbase(&self) -> f64 {
        self.distance_front + self.distance_rear
    }

    /// Understeer gradient K in `road-wheel angle = L/R + K·a_y`, rad per m/s²; positive understeers.
    #[must_use]
    pub fn understeer_gradient(&self) -> f64 {
        let [cf, cr] = self.axle_stiffness();
        self.mass * (self.distance_rear * cr - self.distance_front * cf)
            / (cf * cr * self.wheelbase())
    }

    /// Speed above which an oversteering vehicle is unstable, m/s.
    #[must_use]
    pub fn critical_speed(&self) -> Option<f64> {
        let k = self.understeer_gradient();
        if k < 0.0 { Some((-self.wheelbase() / k).sqrt()) } else { None }
    }

    /// Steering angle per path curvature in a steady turn, `ratio·(L + K·v²)`, rad·m: the
    /// feedforward gain of a path follower.
    #[must_use]
    pub fn steering_per_curvature(&self, speed: f64) -> f64 {
        self.steering_ratio * (self.wheelbase() + self.understeer_gradient() * speed * speed)
    }

    /// Yaw rate per steering angle in a steady turn, `v/(ratio·(L + K·v²))`, 1/s.
    #[must_use]
    pub fn yaw_rate_gain(&self, speed: f64) -> f64 {
        speed / self.steering_per_curvature(speed)
    }

    /// Lateral velocity over yaw rate in a steady turn, `Lr − m·Lf·v²/(Cr·L)`, m.
    #[must_use]
    pub fn lateral_velocity_per_yaw_rate(&self, speed: f64) -> f64 {
        let [_, rear] = self.axle_stiffness();
        self.distance_rear
            - self.mass * self.distance_front * speed * speed / (rear * self.wheelbase())
    }

    /// Sideslip angle over yaw rate in a steady turn, s, for a speed above zero.
    #[must_use]
    pub fn sideslip_per_yaw_rate(&self, speed: f64) -> f64 {
        self.lateral_velocity_per_yaw_rate(speed) / speed
    }

    /// Sideslip angle per yaw acceleration, to first order, s², for a speed above zero.
    ///
    /// The rear axle carries `Fr·L = m·Lf·v·(β̇ + r) − J·ṙ` and slips by `β − Lr·r/v = −Fr/Cr`, hence with
    /// `β = S·r + C·ṙ + …` C is `(J − m·Lf·v·S)/(Cr·L)`.
    #[must_use]
    pub fn sideslip_per_yaw_acceleration(&self, speed: f64) -> f64 {
        let carried = self.mass * self.distance_front * speed * self.sideslip_per_yaw_rate(speed);
        let [_, rear] = self.axle_stiffness();
        (self.yaw_inertia - carried) / (rear * self.wheelbase())
    }

    /// The sideslip referred to a speed; exact in steady turns at all speeds from 1 m/s.
    #[must_use]
    pub fn sideslip(&self, speed: f64) -> Sideslip {
        let reference_speed = speed.max(BLEND_SPEED);
        Sideslip {
            per_yaw_rate: self.sideslip_per_yaw_rate(reference_speed),
            growth: 0.0,
            per_yaw_acceleration: self.sideslip_per_yaw_acceleration(reference_speed),
            reference_speed,
            distance_rear: self.distance_rear,
        }
    }
}

/// The body-frame form at a speed above zero: `(F, G)` for (v_y, r, δ), δ at the road wheel; the
/// input is the steering angle.
#[must_use]
pub fn bicycle_body_frame(
    parameters: &BicycleParameters,
    speed: f64,
) -> (SMatrix<f64, 3, 3>, SVector<f64, 3>) {
    let k = parameters.coefficients();
    let [a, b, c, d] = k.lateral(speed);
    #[rustfmt::skip]
    let f = SMatrix::<f64, 3, 3>::from_row_slice(&[
        a,   b,   k.b1,
        c,   d,   k.b2,
        0.0, 0.0, -1.0 / k.tn,
    ]);
    (f, SVector::<f64, 3>::from([0.0, 0.0, k.n / k.tn]))
}
