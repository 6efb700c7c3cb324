//! What is delivered is what was validated: the plant of the file, run once over the whole drive from rest, has the fit on
//! the validation data that its identification simulated. Cars with the magic formula follow steering of three
//! frequencies at a speed that varies, so that a linear model has errors which a slow mode could follow within a block.

use crate::known::Random;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::sync::Arc;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_formats::Grade;
use steerwright_models::IdentifiedPlant;
use steerwright_models::files::identified_model;
use steerwright_sysid::{IdentifyOptions, Traces, ValidationData, ValidationPlace, identify};

const SAMPLE_S: f64 = 0.02;
const SECONDS: f64 = 120.0;
/// From the start of each part, in which what the state before it left dies out.
const LEFT_OUT_S: f64 = 3.0;
/// Steps of the integration in a sample.
const STEPS: usize = 10;

/// A car of two axles and how it is driven.
struct Car {
    mass: f64,
    inertia: f64,
    /// Distances of the axles, m.
    distance: [f64; 2],
    stiffness: [f64; 2],
    friction: f64,
    /// The logged command is ahead of the angle by this, s.
    ahead_s: f64,
    speed: [f64; 3],
    amplitude: f64,
    /// Frequency, Hz, and phase of each sine.
    sines: [[f64; 2]; 3],
}

impl Car {
    fn random(random: &mut Random) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        let mass = between(1200.0, 1900.0);
        let mean = between(10.0, 26.0);
        Self {
            mass,
            inertia: mass * between(1.4, 1.9),
            distance: [between(1.1, 1.4), between(1.3, 1.6)],
            stiffness: [mass * between(54.0, 75.0), mass * between(71.0, 100.0)],
            friction: between(0.8, 1.0),
            ahead_s: between(0.03, 0.12),
            speed: [mean, mean * between(0.1, 0.35), between(0.08, 0.2)],
            amplitude: between(0.7, 1.6),
            sines: [0.12, 0.31, 0.7].map(|hz| [hz * between(0.7, 1.4), between(0.0, TAU)]),
        }
    }

    fn speed_at(&self, t: f64) -> f64 {
        let [mean, amplitude, omega] = self.speed;
        mean + amplitude * (omega * t).sin()
    }

    fn angle_at(&self, t: f64) -> f64 {
        let sum: f64 = self.sines.iter().map(|[hz, phase]| (TAU * hz * t + phase).sin()).sum();
        let per_curvature = (self.distance[0] + self.distance[1]) / self.speed_at(t).powi(2);
        self.amplitude * (1.0 + 0.5 * (0.09 * t).sin()) * sum * (per_curvature + 5e-4)
    }

    fn command_at(&self, t: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let rate = (self.angle_at(t + STEP) - self.angle_at(t - STEP)) / (2.0 * STEP);
        self.angle_at(t) + self.ahead_s * rate
    }

    /// Slopes of lateral velocity and yaw rate.
    fn rates(&self, t: f64, [vy, r]: [f64; 2]) -> [f64; 2] {
        const SHAPE: f64 = 1.3;
        let [lf, lr] = self.distance;
        let (v, delta) = (self.speed_at(t), self.angle_at(t));
        let force = |stiffness: f64, share: f64, slip: f64| {
            let peak = self.friction * self.mass * 9.81 * share / (lf + lr);
            peak * (SHAPE * (stiffness / (SHAPE * peak) * slip).atan()).sin()
        };
        let front = force(self.stiffness[0], lr, delta - ((vy + lf * r) / v).atan());
        let rear = force(self.stiffness[1], lf, -((vy - lr * r) / v).atan());
        [(front * delta.cos() + rear) / self.mass - v * r, (lf * front - lr * rear) / self.inertia]
    }

    fn csv(&self, random: &mut Random) -> String {
        let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
        let (mut x, h) = ([0.0; 2], SAMPLE_S / STEPS as f64);
        for k in 0..(SECONDS / SAMPLE_S) as usize {
            let t = k as f64 * SAMPLE_S;
            let yaw_rate = x[1] + 0.001 * random.normal();
            let (command, speed) = (self.command_at(t), self.speed_at(t));
            writeln!(csv, "{t:.2},{command:.9},{yaw_rate:.9},{speed:.6}").unwrap();
            for step in 0..STEPS {
                let t = t + step as f64 * h;
                let add = |d: [f64; 2], h: f64| [x[0] + h * d[0], x[1] + h * d[1]];
                let a = self.rates(t, x);
                let b = self.rates(t + 0.5 * h, add(a, 0.5 * h));
                let c = self.rates(t + 0.5 * h, add(b, 0.5 * h));
                let d = self.rates(t + h, add(c, h));
                x = std::array::from_fn(|i| {
                    x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i])
                });
            }
        }
        csv
    }
}

/// Percent, without offsets.
fn fit(measured: &[f64], simulated: &[f64]) -> f64 {
    let count = measured.len() as f64;
    let [of_measured, of_simulated] = [measured, simulated].map(|x| x.iter().sum::<f64>() / count);
    let (mut errors, mut spread) = (0.0, 0.0);
    for (y, s) in measured.iter().zip(simulated) {
        errors += (y - of_measured - (s - of_simulated)).powi(2);
        spread += (y - of_measured).powi(2);
    }
    100.0 * (1.0 - (errors / spread).sqrt())
}

/// The validation samples without the first seconds of each part.
fn scored(traces: &Traces) -> Vec<usize> {
    let mut since = 0;
    let mut scored = Vec::new();
    for (k, is_validation) in traces.is_validation.iter().enumerate() {
        since = if *is_validation { since + 1 } else { 0 };
        if since > (LEFT_OUT_S / SAMPLE_S) as usize {
            scored.push(k);
        }
    }
    scored
}

/// Length of the block that a sample of the estimation data is in, on the mean, s.
fn block_s(traces: &Traces) -> f64 {
    let blocks = traces.is_validation.split(|is_validation| *is_validation);
    let lengths: Vec<f64> = blocks.map(|block| SAMPLE_S * block.len() as f64).collect();
    lengths.iter().map(|length| length * length).sum::<f64>() / lengths.iter().sum::<f64>()
}

/// Stated and delivered fit of a drive, percent, with the time constant of the slowest mode and the longest that the estimation
/// data show, s; `None` of a model that no command packs.
fn fits(seed: u64, place: ValidationPlace) -> Option<[f64; 4]> {
    let mut random = Random(seed);
    let car = Car::random(&mut random);
    let csv = car.csv(&mut random);
    let options = LogOptions { steering_ratio: Some(1.0), ..LogOptions::default() };
    let log = read_log(&[("drive.csv".into(), csv.into_bytes())], &options).unwrap();
    let validation = ValidationData { place, ..ValidationData::default() };
    let options = IdentifyOptions { validation, ..IdentifyOptions::default() };
    let found = identify(&log, &options).unwrap();
    if found.plant.quality.grade == Grade::Fail {
        return None;
    }
    let traces = &found.traces;

    let mut plant = IdentifiedPlant::new(Arc::new(identified_model(&found.plant).unwrap()));
    let step = SAMPLE_S / 8.0;
    let mut delivered = Vec::new();
    let mut at = 0;
    for time in &traces.time_s {
        let samples = (time / step).round() as usize;
        while at < samples {
            let t = at as f64 * step;
            // As in a tool that holds inputs over a step: that of its middle.
            plant.steering_angle = car.command_at(t + 0.5 * step);
            plant.speed = car.speed_at(t);
            plant.step(step).unwrap();
            at += 1;
        }
        plant.steering_angle = car.command_at(*time);
        delivered.push(plant.yaw_rate());
    }
    let scored = scored(traces);
    let of = |x: &[f64]| scored.iter().map(|k| x[*k]).collect::<Vec<_>>();
    let measured = of(&traces.yaw_rate_radps);
    let modes = &found.plant.evidence.poles_and_zeros.as_ref().unwrap().poles;
    Some([
        fit(&measured, &of(&traces.simulated_yaw_rate_radps)),
        fit(&measured, &of(&delivered)),
        modes.iter().filter_map(|mode| mode.time_constant_s).fold(0.0, f64::max),
        0.1 * block_s(traces),
    ])
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_plant_of_the_file_has_the_stated_fit() {
    let (mut failed, mut packed) = (Vec::new(), 0);
    for place in [ValidationPlace::Auto, ValidationPlace::End] {
        for seed in 1..=12 {
            let Some([stated, delivered, slowest_s, longest_s]) = fits(seed, place) else {
                continue;
            };
            packed += 1;
            println!(
                "{} {seed}: stated {stated:.2}, delivered {delivered:.2} %, slowest mode {slowest_s:.2} of {longest_s:.2} s",
                place.name()
            );
            if (stated - delivered).abs() >= 0.1 || slowest_s > 1.02 * longest_s {
                failed.push((place.name(), seed, stated, delivered, slowest_s));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
    assert!(packed >= 18, "{packed} of 24");
}
