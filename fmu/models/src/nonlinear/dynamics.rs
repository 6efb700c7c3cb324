//! The right-hand sides.

use super::actuator::Actuator;
use super::parameters::NonlinearParameters;
use super::tyre::{Axle, TyreParameters};
use crate::bicycle::BicycleParameters;
use crate::limits::BLEND_SPEED;
use crate::trigonometry::{atan, sin_cos};
use steerwright_formats::BicycleCoefficients;

/// Acceleration of free fall, m/s².
pub(super) const GRAVITY: f64 = 9.81;

/// Most of its static load that an axle gains or loses by braking and driving, of both the more.
const MOST_GAINED: f64 = 0.8;
/// Most of the square of an axle's friction that driving and braking use.
const MOST_USED: f64 = 0.9;

/// Density of the air, kg/m³, at 15 °C and sea level.
const AIR_DENSITY: f64 = 1.225;

/// v_y, r, a_φ.
pub(super) type Lateral = [f64; 3];

/// What follows from the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Constants {
    pub(super) actuator: Actuator,
    /// Road-wheel angle over steering angle.
    pub(super) n: f64,
    bicycle: BicycleParameters,
    coefficients: BicycleCoefficients,
    front: Axle,
    rear: Axle,
    /// Load transfer of the axles per a_φ, relative to the static wheel load, s²/m.
    transfer: [f64; 2],
    /// Load that the axles gain per longitudinal acceleration, relative to the static load, s²/m.
    gain: [f64; 2],
    /// Acceleration beyond which no more load moves along, m/s².
    most_along: f64,
    /// Peak forces of the axles at their static loads over the mass, m/s².
    peak: [f64; 2],
    /// Of driving and of braking, the shares of the axles in the force that friction bears.
    shares: [[f64; 2]; 2],
    /// Acceleration and yaw acceleration per dynamic pressure and angle of the air, m/s² and rad/s² per Pa.
    wind: [f64; 2],
    /// 1/T_φ.
    pub(super) roll: f64,
}

/// What driving and braking do to the axles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    /// Load gained over the static one.
    gained: [f64; 2],
    /// Share of the lateral force that the friction ellipse leaves.
    left: [f64; 2],
}

/// The right-hand sides at one speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dynamics<'a> {
    pub(super) constants: &'a Constants,
    pub(super) speed: f64,
    /// Acceleration to the left and yaw acceleration by the wind, m/s² and rad/s².
    wind: [f64; 2],
    /// 1/v, at least that of 1 m/s.
    inverse_speed: f64,
    /// How far the states' target is from that of 1 m/s, per tan δ; below 1 m/s alone.
    blend: Option<Blend>,
}

/// The road-wheel angle δ, rad, with its sine and cosine.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoadWheel {
    pub(super) angle: f64,
    pub(super) sin: f64,
    pub(super) cos: f64,
}

impl RoadWheel {
    pub(super) fn from_angle(angle: f64) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { angle, sin, cos }
    }
}

#[derive(Debug, Clone, Copy)]
struct Blend {
    /// s(v) for (v_y, r).
    target: [f64; 2],
    /// s(1 m/s) − s(v).
    shift: [f64; 2],
    /// F(1 m/s), row by row.
    linear: [f64; 4],
}

impl Constants {
    pub(super) fn new(p: &NonlinearParameters) -> Self {
        let wheelbase = p.body.distance_front_m + p.body.distance_rear_m;
        let weight = p.body.mass_kg * GRAVITY;
        let (front, rear) = (
            weight * p.body.distance_rear_m / wheelbase,
            weight * p.body.distance_front_m / wheelbase,
        );
        let tyre = |balance: f64| TyreParameters {
            friction: p.tyres.friction_coefficient * balance,
            shape: p.tyres.shape_factor,
            curvature: p.tyres.curvature_factor,
            friction_sensitivity: p.tyres.friction_load_sensitivity,
            stiffness_sensitivity: p.tyres.stiffness_load_sensitivity,
        };
        // ΔF = share·m·h·a_φ/track, over half the axle's load.
        let transfer = |share: f64, load: f64| {
            share * p.body.mass_kg * p.body.centre_of_gravity_height_m
                / p.body.track_width_m
                / (load / 2.0)
        };
        // ΔF = m·h·a_x/L.
        let gained =
            |load: f64| p.body.mass_kg * p.body.centre_of_gravity_height_m / wheelbase / load;
        let gain = [-gained(front), gained(rear)];
        let bicycle = p.bicycle();
        Self {
            actuator: Actuator {
                time_constant: p.actuator.time_constant_s,
                rate: p.actuator.road_wheel_rate_max_radps,
                stop: p.actuator.road_wheel_angle_max_rad,
            },
            n: 1.0 / p.actuator.steering_ratio,
            bicycle,
            coefficients: bicycle.coefficients(),
            front: Axle::new(p.tyres.cornering_stiffness_front_npr, front, &tyre(1.0)),
            rear: Axle::new(
                p.tyres.cornering_stiffness_rear_npr,
                rear,
                &tyre(p.tyres.friction_balance_rear),
            ),
            transfer: [
                transfer(p.body.roll_stiffness_front, front),
                transfer(1.0 - p.body.roll_stiffness_front, rear),
            ],
            gain,
            most_along: MOST_GAINED / gain[0].abs().max(gain[1]).max(f64::MIN_POSITIVE),
            peak: [front, rear * p.tyres.friction_balance_rear]
                .map(|load| p.tyres.friction_coefficient * load / p.body.mass_kg),
            shares: [p.body.drive_share_front, p.body.brake_share_front].map(|front| {
                [front * p.tyres.combined_slip, (1.0 - front) * p.tyres.combined_slip]
            }),
            wind: [
                p.body.side_force_area_m2 / p.body.mass_kg,
                p.body.side_force_area_m2 * p.body.side_force_arm_m / p.body.yaw_inertia_kgm2,
            ],
            roll: 1.0 / p.body.roll_time_constant_s,
        }
    }

    /// What a longitudinal acceleration, m/s², does to the axles.
    #[inline]
    pub(super) fn along(&self, acceleration: f64) -> Along {
        let acceleration = acceleration.clamp(-self.most_along, self.most_along);
        let gained = self.gain.map(|gain| gain * acceleration);
        let shares = self.shares[usize::from(acceleration < 0.0)];
        let mut left = [1.0; 2];
        // At constant speed there is no force, and no root to take.
        if acceleration != 0.0 {
            for axle in 0..2 {
                let used = shares[axle] * acceleration / (self.peak[axle] * (1.0 + gained[axle]));
                left[axle] = (1.0 - (used * used).min(MOST_USED)).sqrt();
            }
        }
        Along { gained, left }
    }

    /// The rate of the fastest mode at a speed but for the actuator's, 1/s.
    pub(super) fn fastest_rate(&self, speed: f64) -> f64 {
        let k = BicycleCoefficients { tn: f64::INFINITY, ..self.coefficients };
        k.fastest_rate(speed.max(BLEND_SPEED)).max(self.roll)
    }

    /// The right-hand sides at a speed, in a crosswind to the left, both m/s.
    #[inline]
    pub(super) fn at_speed(&self, speed: f64, crosswind: f64) -> Dynamics<'_> {
        let inverse_speed = 1.0 / speed.max(BLEND_SPEED);
        let blend = if speed < BLEND_SPEED {
            let steady = |v: f64| {
                let yaw_rate = v / self.bicycle.steering_per_curvature(v) / self.n;
                [self.bicycle.lateral_velocity_per_yaw_rate(v) * yaw_rate, yaw_rate]
            };
            let (target, end) = (steady(speed), steady(BLEND_SPEED));
            Some(Blend {
                target,
                shift: [end[0] - target[0], end[1] - target[1]],
                linear: self.coefficients.lateral(BLEND_SPEED),
            })
        } else {
            None
        };
        let mut wind = [0.0; 2];
        if crosswind != 0.0 {
            let pressure = 0.5 * AIR_DENSITY * (speed * speed + crosswind * crosswind);
            let angle = (crosswind / speed.max(BLEND_SPEED)).atan();
            wind = self.wind.map(|per| per * pressure * angle);
        }
        Dynamics { constants: self, speed, wind, inverse_speed, blend }
    }
}

impl Dynamics<'_> {
    /// (v̇_y, ṙ, ȧ_φ) and a_y, with what driving and braking do to the axles.
    #[inline]
    pub(super) fn rates(&self, s: &Lateral, wheel: &RoadWheel, along: &Along) -> (Lateral, f64) {
        let [vy, r, roll] = *s;
        let [vy_rate, r_rate] = match &self.blend {
            None => self.forces(vy, r, roll, wheel, along),
            Some(b) => {
                let tan = wheel.sin / wheel.cos;
                let (vy_shifted, r_shifted) = (vy + b.shift[0] * tan, r + b.shift[1] * tan);
                let nonlinear = self.forces(vy_shifted, r_shifted, roll, wheel, along);
                let (vy, r) = (vy - b.target[0] * tan, r - b.target[1] * tan);
                let [a, b, c, d] = b.linear;
                let linear = [a * vy + b * r, c * vy + d * r];
                let mean = |nonlinear: f64, linear: f64| linear + self.speed * (nonlinear - linear);
                [mean(nonlinear[0], linear[0]), mean(nonlinear[1], linear[1])]
            }
        };
        let acceleration = vy_rate + self.speed * r;
        ([vy_rate, r_rate, (acceleration - roll) * self.constants.roll], acceleration)
    }

    /// (v̇_y, ṙ) of the forces of tyres and wind, at 1 m/s at least.
    #[inline]
    fn forces(&self, vy: f64, r: f64, roll: f64, wheel: &RoadWheel, along: &Along) -> [f64; 2] {
        let k = self.constants;
        let b = &k.bicycle;
        let [front, rear] = atan(&[
            (vy + b.distance_front * r) * self.inverse_speed,
            (vy - b.distance_rear * r) * self.inverse_speed,
        ]);
        let slip = [wheel.angle - front, -rear];
        let transfer = k.transfer.map(|transfer| transfer * roll);
        let [front, rear] = Axle::forces([&k.front, &k.rear], slip, transfer, along.gained);
        let front = front * along.left[0] * wheel.cos;
        let rear = rear * along.left[1];
        [
            (front + rear) / b.mass - self.speed.max(BLEND_SPEED) * r + self.wind[0],
            (b.distance_front * front - b.distance_rear * rear) / b.yaw_inertia + self.wind[1],
        ]
    }

    /// Of the front and the rear axle, whether a wheel is off the road.
    #[inline]
    pub(super) fn lifted(&self, s: &Lateral, along: &Along) -> [bool; 2] {
        let [front, rear] = self.constants.transfer.map(|transfer| (transfer * s[2]).abs());
        [front > 1.0 + along.gained[0], rear > 1.0 + along.gained[1]]
    }
}
