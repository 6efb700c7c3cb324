//! A servo that its command outruns, with its largest rate, and servos that follow.

use super::{DRIVE, Drive, T, at_end, car, drive, estimated, evidence, known, parameters};
use steerwright_models::{BicycleParameters, BicyclePlant};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};

/// The road wheels of the drive would turn by up to 0.19 rad/s.
#[test]
fn a_largest_rate_is_found_where_the_drive_shows_it() {
    for (rate, seed) in [(0.05, 31), (0.09, 32)] {
        let slow = BicycleParameters { actuator_rate_max: rate, ..car() };
        let found = identify_bicycle(&drive(slow, Drive { noise: 0.003, seed, ..DRIVE }), &known());
        let found = found.unwrap();
        let e = evidence(&found);
        let written = found.bicycle.vehicle.actuator_rate_max_radps.unwrap();
        let (value, error) = estimated(e, "actuator_rate_max");
        assert_eq!(written, value);
        assert!((value / rate - 1.0).abs() < 0.03 && error < 0.03 * rate, "{value} ± {error}");
        assert!((value - rate).abs() < 4.5 * error, "{rate}: {value} ± {error}");
        // It is taken for no lag and no understeer.
        let lag = found.bicycle.vehicle.actuator_time_constant_s + e.with_delay.input_delay_s;
        assert!((lag - car().actuator_time_constant).abs() < 0.02, "{rate}: {lag}");
        let gradient = estimated(e, "understeer_gradient").0 / car().understeer_gradient();
        assert!((gradient - 1.0).abs() < 0.1, "{rate}: {gradient}");
        assert!(e.validation_fit > 95.0, "{rate}: {}", e.validation_fit);
        assert!(found.bicycle.quality.allows_design(), "{:?}", found.bicycle.quality);
    }
}

/// Reached in one sample of fifty, and behind a delay that a limit could stand for.
#[test]
fn a_largest_rate_that_is_seldom_reached_is_found_and_its_delay_is_a_delay() {
    for (rate, delay, seed) in [(0.14, 0, 33), (0.1, 3, 34), (0.14, 8, 35), (0.12, 12, 36)] {
        let slow = BicycleParameters { actuator_rate_max: rate, ..car() };
        let log = drive(slow, Drive { noise: 0.003, delay, seed, ..DRIVE });
        let found = identify_bicycle(&log, &known()).unwrap();
        let e = evidence(&found);
        let (value, error) = estimated(e, "actuator_rate_max");
        assert!((value - rate).abs() < 4.5 * error && error < 0.05 * rate, "{value} ± {error}");
        let lag = found.bicycle.vehicle.actuator_time_constant_s + e.with_delay.input_delay_s;
        let expected = car().actuator_time_constant + delay as f64 * T;
        assert!((lag - expected).abs() < 0.02, "{rate}: {lag} {expected}");
    }
}

#[test]
fn a_servo_that_follows_has_no_largest_rate() {
    for (noise, noise_pole, delay, seed) in
        [(0.003, 0.0, 0, 41), (0.01, 0.9, 0, 42), (0.003, 0.0, 3, 43), (0.0, 0.0, 0, 44)]
    {
        let log = drive(car(), Drive { noise, noise_pole, delay, seed, ..DRIVE });
        let found = identify_bicycle(&log, &known()).unwrap();
        assert_eq!(found.bicycle.vehicle.actuator_rate_max_radps, None, "{seed}");
    }
}

#[test]
fn the_plant_of_the_fmu_follows_the_traces_of_a_limited_servo() {
    let slow = BicycleParameters { actuator_rate_max: 0.06, ..car() };
    let log = drive(slow, Drive { noise: 0.003, fastest: 20.0, ..DRIVE });
    let options = BicycleOptions { validation: at_end(), ..BicycleOptions::default() };
    let found = identify_bicycle(&log, &options).unwrap();
    let e = evidence(&found);
    let mut plant = BicyclePlant::new(parameters(&found.bicycle)).unwrap();
    assert!(plant.parameters.actuator_rate_max < 0.07);
    let mut squares = [0.0; 2];
    for k in 0..log.len() / 2 {
        if k > 500 {
            let simulated = found.traces.simulated_yaw_rate_radps[k];
            squares[0] += (plant.yaw_rate() + e.yaw_rate_offset_radps - simulated).powi(2);
            squares[1] += simulated.powi(2);
        }
        plant.steering_angle = log.input[k] - e.steering_offset_rad;
        plant.speed = log.speed.as_ref().unwrap()[k];
        plant.step(T).unwrap();
    }
    // The estimator takes the mean of the wheel over a sample.
    let ratio = (squares[0] / squares[1]).sqrt();
    assert!(ratio < 1e-3, "{ratio}");
}
