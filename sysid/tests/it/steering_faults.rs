//! Faults between steering and yaw rate, over cars, speeds and kinds of steering: none is made up, and what is
//! there is named.

use crate::known::Random;
use std::f64::consts::TAU;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_formats::{Plant, Quality, ReasonCode};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::{IdentifyOptions, identify};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Steering {
    Sweep,
    Multisine,
    Noise,
}

/// A drive of a linear car.
#[derive(Debug, Clone, Copy)]
struct Drive {
    seed: u64,
    steering: Steering,
    mean_mps: f64,
    /// Amplitude of the speed over its mean.
    varies: f64,
    /// Time constant of the actuator, s.
    lag_s: f64,
    /// Play at the road wheel, deg.
    play_deg: f64,
    /// By how much later the yaw rate is stamped than it was, s.
    late_s: f64,
}

const SOUND: Drive = Drive {
    seed: 1,
    steering: Steering::Noise,
    mean_mps: 18.0,
    varies: 0.0,
    lag_s: 0.03,
    play_deg: 0.0,
    late_s: 0.0,
};
const SECONDS: f64 = 120.0;
const STEP_S: f64 = 2e-3;
/// Steps from one row of the log to the next.
const STEPS: usize = 10;

impl Drive {
    /// Road-wheel angle that is steered, rad: as much lateral acceleration at each mean speed.
    fn steered(&self, random: &mut Random) -> Vec<f64> {
        let size = 0.06 * 8.0 / self.mean_mps;
        let phases: [f64; 7] = std::array::from_fn(|_| TAU * random.uniform());
        let mut smooth = [0.0; 2];
        (0..(SECONDS / STEP_S) as usize)
            .map(|k| {
                let t = k as f64 * STEP_S;
                smooth[0] += STEP_S / 0.15 * (3.0 * random.normal() - smooth[0]);
                smooth[1] += STEP_S / 0.15 * (smooth[0] - smooth[1]);
                let sines = [0.13, 0.29, 0.47, 0.71, 1.03, 1.39, 1.83].into_iter().zip(phases);
                size * match self.steering {
                    Steering::Sweep => (TAU * (0.2 * t + 0.007 * t * t)).sin(),
                    Steering::Multisine => {
                        0.4 * sines.map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>()
                    }
                    Steering::Noise => 5.0 * smooth[1],
                }
            })
            .collect()
    }

    fn log(&self) -> DriveLog {
        let mut random = Random(self.seed);
        let mut of = |low: f64, high: f64| low + (high - low) * random.uniform();
        let (m, front, rear) = (of(1100.0, 2200.0), of(1.1, 1.4), of(1.3, 1.6));
        let inertia = m * front * rear * of(0.9, 1.1);
        let (cf, cr) = (m * of(42.0, 60.0), m * of(58.0, 75.0));
        let steered = self.steered(&mut random);
        let half = 0.5 * self.play_deg.to_radians();
        let (mut wheel, mut reached, mut vy, mut r) = (0.0_f64, 0.0, 0.0, 0.0);
        let (mut yaw_rate, mut speed) = (Vec::new(), Vec::new());
        for (k, u) in steered.iter().enumerate() {
            let t = k as f64 * STEP_S;
            let v = self.mean_mps * (1.0 + self.varies * (TAU * t / 60.0).sin());
            speed.push(v);
            yaw_rate.push(r);
            wheel = wheel.clamp(u - half, u + half);
            reached += STEP_S / self.lag_s * (wheel - reached);
            let (af, ar) = (reached - (vy + front * r) / v, -(vy - rear * r) / v);
            vy += STEP_S * ((cf * af + cr * ar) / m - v * r);
            r += STEP_S * (front * cf * af - rear * cr * ar) / inertia;
        }
        let shift = (self.late_s / STEP_S).round() as isize;
        let mut csv = String::from("time_s,steering_wheel_angle_rad,yaw_rate_radps,speed_mps\n");
        for k in (0..steered.len()).step_by(STEPS) {
            let at = (k as isize - shift).clamp(0, steered.len() as isize - 1) as usize;
            let measured = yaw_rate[at] + 0.002 * random.normal();
            let t = k as f64 * STEP_S;
            csv += &format!("{t:.3},{:.8},{measured:.8},{:.6}\n", 15.0 * steered[k], speed[k]);
        }
        let options = LogOptions { steering_ratio: Some(15.0), ..LogOptions::default() };
        read_log(&[("drive.csv".to_owned(), csv.into_bytes())], &options).unwrap()
    }

    /// What the default structure of one speed, and the bicycle, say.
    fn qualities(&self) -> (Plant, Quality) {
        let log = self.log();
        let bicycle = identify_bicycle(&log, &BicycleOptions::default()).unwrap().bicycle;
        (identify(&log, &IdentifyOptions::default()).unwrap().plant, bicycle.quality)
    }
}

fn of_steering(quality: &Quality) -> Vec<ReasonCode> {
    let codes = [ReasonCode::SteeringPlay, ReasonCode::EarlyYawRate, ReasonCode::LateYawRate];
    quality.reasons.iter().map(|r| r.code).filter(|c| codes.contains(c)).collect()
}

// More cars of each kind, all of which are to be judged right; a test for each kind, which run beside each other.

#[test]
#[ignore = "slow: cargo xtask test"]
fn many_sound_drives_are_judged_right() {
    none_in(&drives(Drive { seed: 1000, ..SOUND }, 12));
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn many_sound_drives_of_slow_cars_are_judged_right() {
    none_in(&drives(Drive { seed: 77_000, lag_s: 0.06, ..SOUND }, 12));
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn many_drives_with_play_are_judged_right() {
    let mut missed = Vec::new();
    for drive in drives(Drive { seed: 2000, play_deg: 0.6, ..SOUND }, 12) {
        let (plant, bicycle) = drive.qualities();
        let [width, error] = plant.evidence.play.map_or([0.0; 2], |play| {
            [play.road_wheel_rad, play.standard_error_rad].map(f64::to_degrees)
        });
        println!("play of 0.6°: {width:.3} ± {error:.3}");
        if of_steering(&bicycle) != [ReasonCode::SteeringPlay] {
            missed.push((drive, of_steering(&bicycle)));
        }
        assert!((width - 0.6).abs() < 2.5 * error, "{drive:?}: {width} ± {error}");
        // Noise moves on between the samples by some of the play.
        let is_near = (0.9..1.1).contains(&(width / 0.6)) && error < 0.06;
        assert!(drive.steering == Steering::Noise || is_near, "{drive:?}: {width} ± {error}");
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn many_drives_with_an_early_yaw_rate_are_judged_right() {
    many_have(-0.1, ReasonCode::EarlyYawRate);
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn many_drives_with_a_late_yaw_rate_are_judged_right() {
    many_have(0.12, ReasonCode::LateYawRate);
}

/// Drives whose yaw rate is late name it, in every structure.
fn many_have(late_s: f64, code: ReasonCode) {
    for drive in drives(Drive { seed: 3000, late_s, ..SOUND }, 12) {
        let (plant, bicycle) = drive.qualities();
        for quality in [&plant.quality, &bicycle] {
            assert_eq!(of_steering(quality), [code], "{drive:?}");
        }
    }
}

/// Cars, mean speeds, speeds that vary and all kinds of steering, numbered.
fn drives(of: Drive, count: u64) -> Vec<Drive> {
    let mean = [18.0, 6.5, 11.0, 27.0];
    let varies = [0.0, 0.5, 0.25];
    let steering = [Steering::Sweep, Steering::Multisine, Steering::Noise];
    (0..count)
        .map(|k| Drive {
            seed: of.seed + 7919 * k,
            mean_mps: mean[(k % 4) as usize],
            varies: varies[(k / 3 % 3) as usize],
            steering: steering[(k % 3) as usize],
            ..of
        })
        .collect()
}

fn none_in(drives: &[Drive]) {
    for drive in drives {
        let (plant, bicycle) = drive.qualities();
        let found = [of_steering(&plant.quality), of_steering(&bicycle)];
        assert!(found.iter().all(Vec::is_empty), "{drive:?}: {found:?}");
    }
}

#[test]
fn a_sound_drive_has_no_fault_of_its_steering() {
    none_in(&drives(SOUND, 6));
    // Much of a car's own lag is no late clock.
    none_in(&[Drive { lag_s: 0.06, steering: Steering::Sweep, ..SOUND }]);
}

#[test]
fn play_is_found_at_its_width_whatever_the_speed() {
    for drive in drives(Drive { play_deg: 0.6, seed: 71, ..SOUND }, 5) {
        let (plant, bicycle) = drive.qualities();
        assert_eq!(of_steering(&bicycle), [ReasonCode::SteeringPlay], "{drive:?}");
        let play = plant.evidence.play.as_ref().unwrap();
        let (width, error) =
            (play.road_wheel_rad.to_degrees(), play.standard_error_rad.to_degrees());
        println!("{drive:?}: {width:.3} ± {error:.3}");
        assert!((width - 0.6).abs() < 2.5 * error, "{drive:?}: {width} ± {error}");
    }
}

#[test]
fn an_early_yaw_rate_is_named_and_stated_as_the_least() {
    for drive in drives(Drive { late_s: -0.1, seed: 131, ..SOUND }, 5) {
        let (plant, bicycle) = drive.qualities();
        let lead = plant.evidence.yaw_rate_lead_s.unwrap_or_default();
        println!("{drive:?}: {lead:.3}");
        assert_eq!(of_steering(&bicycle), [ReasonCode::EarlyYawRate], "{drive:?}");
        assert!((0.05..=0.105).contains(&lead), "{drive:?}: {lead}");
    }
}

#[test]
fn a_late_yaw_rate_is_named() {
    for drive in drives(Drive { late_s: 0.12, seed: 177, ..SOUND }, 5) {
        let (plant, bicycle) = drive.qualities();
        println!("{drive:?}: {:?}", plant.evidence.yaw_rate_lag_s);
        let found = [of_steering(&plant.quality), of_steering(&bicycle)];
        assert!(found.iter().all(|f| *f == [ReasonCode::LateYawRate]), "{drive:?}: {found:?}");
    }
}
