//! Linear cars whose response from steering to yaw rate is known: the linear single-track model (eq 13) in
//! lateral velocity and yaw rate, behind a servo's lag where it has one.

use crate::Random;
use std::f64::consts::TAU;

/// A linear single-track car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearCar {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Yaw inertia, kg m².
    pub yaw_inertia_kgm2: f64,
    /// Front axle to centre of gravity, m.
    pub front_m: f64,
    /// Rear axle to centre of gravity, m.
    pub rear_m: f64,
    /// Cornering stiffness of the front axle, N/rad.
    pub front_stiffness: f64,
    /// Cornering stiffness of the rear axle, N/rad.
    pub rear_stiffness: f64,
    /// Time constant between the recorded and the acting angle, s; 0 for none.
    pub servo_s: f64,
}

impl LinearCar {
    /// An understeering road car, without a servo.
    pub fn random(random: &mut Random) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        let mass = between(1100.0, 2100.0);
        let wheelbase = between(2.4, 3.0);
        let front = wheelbase * between(0.42, 0.52);
        let rear = wheelbase - front;
        let front_stiffness = mass * between(45.0, 65.0);
        // Of equal stiffness over load the car is neutral; more at the rear understeers.
        let neutral = front_stiffness * front / rear;
        Self {
            mass_kg: mass,
            yaw_inertia_kgm2: mass * front * rear * between(0.9, 1.15),
            front_m: front,
            rear_m: rear,
            front_stiffness,
            rear_stiffness: neutral * between(1.1, 1.6),
            servo_s: 0.0,
        }
    }

    /// `ẋ = F x + g δ` in lateral velocity and yaw rate, δ at the road wheel.
    #[must_use]
    pub fn lateral(&self, speed_mps: f64) -> ([[f64; 2]; 2], [f64; 2]) {
        let (m, i, v) = (self.mass_kg, self.yaw_inertia_kgm2, speed_mps);
        let (a, b) = (self.front_m, self.rear_m);
        let (cf, cr) = (self.front_stiffness, self.rear_stiffness);
        let coupling = cr * b - cf * a;
        let f = [
            [-(cf + cr) / (m * v), coupling / (m * v) - v],
            [coupling / (i * v), -(cf * a * a + cr * b * b) / (i * v)],
        ];
        (f, [cf / m, cf * a / i])
    }

    /// Response from the recorded angle at the road wheel to yaw rate, 1/s: real and imaginary part.
    #[must_use]
    pub fn response(&self, speed_mps: f64, hz: f64) -> (f64, f64) {
        let (f, g) = self.lateral(speed_mps);
        let w = TAU * hz;
        // (jω − F)⁻¹ g, second entry, over 1 + jω·servo.
        let numerator = (f[1][0] * g[0] - f[0][0] * g[1], w * g[1]);
        let determinant = (f[0][0] * f[1][1] - f[0][1] * f[1][0] - w * w, -w * (f[0][0] + f[1][1]));
        let lag = (1.0, w * self.servo_s);
        let by = (
            determinant.0 * lag.0 - determinant.1 * lag.1,
            determinant.0 * lag.1 + determinant.1 * lag.0,
        );
        let size = by.0 * by.0 + by.1 * by.1;
        (
            (numerator.0 * by.0 + numerator.1 * by.1) / size,
            (numerator.1 * by.0 - numerator.0 * by.1) / size,
        )
    }

    /// Yaw rate over steering angle in a steady turn, 1/s.
    #[must_use]
    pub fn steady_state_gain(&self, speed_mps: f64) -> f64 {
        self.response(speed_mps, 0.0).0
    }

    /// Poles of the lateral dynamics, 1/s: real and imaginary part of each.
    #[must_use]
    pub fn poles(&self, speed_mps: f64) -> [(f64, f64); 2] {
        let (f, _) = self.lateral(speed_mps);
        let (half, product) = (0.5 * (f[0][0] + f[1][1]), f[0][0] * f[1][1] - f[0][1] * f[1][0]);
        let under = half * half - product;
        let root = under.abs().sqrt();
        if under < 0.0 {
            [(half, root), (half, -root)]
        } else {
            [(half + root, 0.0), (half - root, 0.0)]
        }
    }

    /// Derivatives of lateral velocity, yaw rate and road-wheel angle.
    pub(crate) fn slope(&self, speed: f64, x: [f64; 3], steering: f64, gust: [f64; 2]) -> [f64; 3] {
        let (f, g) = self.lateral(speed);
        let wheel = if self.servo_s > 0.0 { x[2] } else { steering };
        let row = |i: usize| f[i][0] * x[0] + f[i][1] * x[1] + g[i] * wheel + gust[i];
        let lag = if self.servo_s > 0.0 { (steering - x[2]) / self.servo_s } else { 0.0 };
        [row(0), row(1), lag]
    }
}
