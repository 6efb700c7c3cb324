//! A vehicle whose servo its held command outruns: what is packed has the fit that the identification states.

use crate::known::Random;
use std::fmt::Write;
use steerwright_drivelog::{LogOptions, Response, read_log};
use steerwright_models::files::nonlinear_parameters;
use steerwright_models::{NonlinearParameters, NonlinearVehicle};
use steerwright_sysid::single_track::{IdentifyVehicleOptions, identify_vehicle};

const SECONDS: f64 = 120.0;
const RATE_RADPS: f64 = 0.12;
const TIME_CONSTANT_S: f64 = 0.05;
const DELAY_S: f64 = 0.06;
/// From the start, s, in which what was before dies out.
const LEFT_OUT_S: f64 = 3.0;

fn car() -> NonlinearParameters {
    let mut car = NonlinearParameters::default();
    car.actuator.road_wheel_rate_max_radps = RATE_RADPS;
    car.actuator.time_constant_s = TIME_CONSTANT_S;
    car.actuator.delay_s = DELAY_S;
    car.actuator.steering_ratio = 1.0;
    car
}

fn speed_at(t: f64) -> f64 {
    14.0 + 4.0 * (0.13 * t).sin()
}

/// Held commands, a tenth of a second each.
fn commands(random: &mut Random) -> Vec<f64> {
    let mut slow = 0.0;
    let all = (0..=(10.0 * SECONDS) as usize).map(|_| {
        slow += 0.25 * (random.normal() - slow);
        (0.1 * slow).clamp(-0.08, 0.08)
    });
    all.collect()
}

/// Yaw rates of a vehicle at the samples.
fn driven(parameters: NonlinearParameters, commands: &[f64], sample_s: f64) -> Vec<f64> {
    let mut vehicle = NonlinearVehicle::new(parameters).unwrap();
    let count = (SECONDS / sample_s).round() as usize;
    let yaw_rates = (0..count).map(|k| {
        let t = k as f64 * sample_s;
        vehicle.steering_angle = commands[(10.0 * t + 1e-9) as usize];
        vehicle.speed = speed_at(t);
        let yaw_rate = vehicle.yaw_rate();
        vehicle.step(sample_s).unwrap();
        yaw_rate
    });
    yaw_rates.collect()
}

#[test]
fn the_vehicle_of_the_file_has_the_stated_fit_behind_a_held_command() {
    for (sample_s, seed) in [(0.1, 51), (0.05, 52), (0.01, 53)] {
        let mut random = Random(seed);
        let commands = commands(&mut random);
        let truth = driven(car(), &commands, sample_s);
        let mut csv = String::from("time_s,steering_command_rad,yaw_rate_radps,speed_mps\n");
        for (k, yaw_rate) in truth.iter().enumerate() {
            let t = k as f64 * sample_s;
            let (command, noisy) =
                (commands[(10.0 * t + 1e-9) as usize], yaw_rate + 0.002 * random.normal());
            writeln!(csv, "{t:.2},{command:.9},{noisy:.9},{:.6}", speed_at(t)).unwrap();
        }
        let options = LogOptions {
            response: Response::Motion,
            steering_ratio: Some(1.0),
            ..LogOptions::default()
        };
        let log = read_log(&[("drive.csv".into(), csv.into_bytes())], &options).unwrap();
        let found = identify_vehicle(&log, &IdentifyVehicleOptions::default()).unwrap();

        let actuator = found.vehicle.actuator;
        let rate = actuator.road_wheel_rate_max_radps;
        assert!((rate / RATE_RADPS - 1.0).abs() < 0.03, "{sample_s}: {rate}");
        // In a sample of a tenth of a second the wheel turns as far with another lag and delay.
        let lag_s = actuator.time_constant_s + actuator.delay_s;
        assert!((lag_s - TIME_CONSTANT_S - DELAY_S).abs() < 0.012, "{sample_s}: {lag_s}");

        let traces = &found.traces;
        let offset = found.vehicle.evidence.as_ref().unwrap();
        let offset = offset.parameters.iter().find(|p| p.name == "steering_offset").unwrap().value;
        let shifted: Vec<f64> = commands.iter().map(|c| c + offset).collect();
        let packed = driven(nonlinear_parameters(&found.vehicle), &shifted, sample_s);
        let mut squares = [0.0; 2];
        for (k, time) in traces.time_s.iter().enumerate() {
            if *time < LEFT_OUT_S || !traces.is_validation[k] {
                continue;
            }
            let delivered = packed[(time / sample_s).round() as usize];
            squares[0] += (delivered - traces.simulated_yaw_rate_radps[k]).powi(2);
            squares[1] += traces.yaw_rate_radps[k].powi(2);
        }
        // Errors that are 2 % of the signal and as likely of either sign as not move a fit of 97 % by less than 0.1 points.
        let share = (squares[0] / squares[1]).sqrt();
        println!("{sample_s}: {rate:.4} rad/s, {lag_s:.4} s, {:.3} % apart", 100.0 * share);
        assert!(share < 0.01, "{sample_s}: {share}");
    }
}
