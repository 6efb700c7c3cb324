//! Drives of a linear car with an actuator, whose steering moves on or is held between its samples.

use crate::known::Random;
use std::f64::consts::TAU;
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, Intersample, LogOptions, VehicleClass, read_log};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pattern {
    /// From 0.2 Hz upwards, 0.014 Hz a second.
    Chirp,
    Multisine,
    /// The same about a turn to the left.
    LeftTurns,
}

/// A drive and how it is recorded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinearCar {
    pub(crate) seed: u64,
    pub(crate) pattern: Pattern,
    pub(crate) wheelbase_m: f64,
    /// Steering ratio.
    pub(crate) ratio: f64,
    /// Time constant of the actuator, s.
    pub(crate) lag_s: f64,
    pub(crate) mean_mps: f64,
    /// Amplitude of the speed about its mean, m/s.
    pub(crate) varies_mps: f64,
    pub(crate) rate_hz: f64,
    pub(crate) seconds: f64,
    /// Whether the steering is held from row to row.
    pub(crate) is_held: bool,
    /// Of the speed in the log: 3.6 of km/h in a column of m/s.
    pub(crate) speed_factor: f64,
    pub(crate) class: Option<VehicleClass>,
    pub(crate) intersample: Option<Intersample>,
}

pub(crate) const CAR: LinearCar = LinearCar {
    seed: 0,
    pattern: Pattern::Chirp,
    wheelbase_m: 2.75,
    ratio: 15.0,
    lag_s: 0.04,
    mean_mps: 18.0,
    varies_mps: 10.0,
    rate_hz: 50.0,
    seconds: 120.0,
    is_held: false,
    speed_factor: 1.0,
    class: None,
    intersample: None,
};

impl LinearCar {
    fn csv(&self) -> String {
        let size = self.wheelbase_m / 2.75;
        let (m, inertia, lf, lr) = (1650.0, 2900.0 * size * size, 1.25 * size, 1.5 * size);
        let (cf, cr) = (85e3, 110e3);
        let steps = (1e-3 * self.rate_hz).recip().round() as usize;
        let dt = 1.0 / (self.rate_hz * steps as f64);
        let mut random = Random(self.seed + 1);
        let phases: [f64; 7] = std::array::from_fn(|_| TAU * random.uniform());
        let speed = |t: f64| self.mean_mps + self.varies_mps * (TAU * t / 60.0).sin();
        let road_wheel = |t: f64| {
            let sines = [0.13_f64, 0.29, 0.47, 0.71, 1.03, 1.39, 1.83].into_iter().zip(phases);
            let multisine: f64 =
                sines.map(|(f, p)| 8.0 / (1.0 + 2.0 * f).sqrt() * (TAU * f * t + p).sin()).sum();
            let degrees = match self.pattern {
                Pattern::Chirp => 20.0 * (TAU * (0.2 * t + 0.007 * t * t)).sin(),
                Pattern::Multisine => multisine,
                Pattern::LeftTurns => 20.0 + multisine,
            };
            degrees.to_radians() * size / speed(t)
        };
        let mut csv = String::from("time_s,steering_wheel_angle_rad,yaw_rate_radps,speed_mps\n");
        let (mut vy, mut r, mut wheel) = (0.0, 0.0, 0.0);
        for k in 0..(self.seconds * self.rate_hz) as usize {
            let at = |step: f64| (k * steps) as f64 * dt + step * dt;
            let (u, v) = (road_wheel(at(0.0)), speed(at(0.0)));
            let (steering, yaw_rate) = (self.ratio * u, r + 0.002 * random.normal());
            let logged = self.speed_factor * v;
            writeln!(csv, "{:.4},{steering:.9},{yaw_rate:.9},{logged:.6}", at(0.0)).unwrap();
            for step in 0..steps {
                let steered = if self.is_held { u } else { road_wheel(at(step as f64 + 0.5)) };
                // The actuator and, twice as fine, the car.
                let before = wheel;
                wheel += (1.0 - (-dt / self.lag_s).exp()) * (steered - wheel);
                for half in [0.25, 0.75] {
                    let wheel = before + half * (wheel - before);
                    let (front, rear) = (wheel - (vy + lf * r) / v, -(vy - lr * r) / v);
                    vy += 0.5 * dt * ((cf * front + cr * rear) / m - v * r);
                    r += 0.5 * dt * (lf * cf * front - lr * cr * rear) / inertia;
                }
            }
        }
        csv
    }

    pub(crate) fn log(&self) -> DriveLog {
        let options = LogOptions {
            steering_ratio: Some(self.ratio),
            vehicle_class: self.class,
            intersample: self.intersample,
            ..LogOptions::default()
        };
        read_log(&[("drive.csv".into(), self.csv().into_bytes())], &options).unwrap()
    }
}
