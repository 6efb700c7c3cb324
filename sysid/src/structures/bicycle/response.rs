//! The response of eq 13 with its actuator, and its standard errors.

use crate::structures::bicycle::parameters::{
    Coefficients, DELAY, FRONT, INDEX, LAG, PARAMETERS, REAR, STEERING_FACTOR, WHEELBASE,
    of_vehicle,
};
use crate::validation::response::uncertain_response::ResponseError;
use faer::c64;
use std::f64::consts::TAU;
use steerwright_formats::{VehicleData, VehicleDirection};

/// Share of a standard deviation over which derivatives are taken.
const STEP: f64 = 1e-3;

/// Yaw rate over road-wheel angle, 1/s, at a frequency in Hz: eq 13 with the actuator's lag and delay.
pub(super) fn response(p: &[f64; PARAMETERS], front_share: f64, speed_mps: f64, hz: f64) -> c64 {
    let c = Coefficients::new(p, front_share);
    let ([f11, f12, f21, f22], [b1, b2]) = c.at_speed(speed_mps);
    let s = c64::new(0.0, TAU * hz);
    let numerator = (s - f11) * b2 + f21 * b1;
    numerator / ((s - f11) * (s - f22) - f12 * f21) / (s / c.rate + 1.0)
        * c64::cis(-TAU * hz * c.delay)
}

/// Yaw rate over road-wheel angle of a vehicle in gentle driving, 1/s, at a frequency in Hz.
pub(crate) fn response_in_gentle_driving(
    vehicle: &VehicleData,
    speed_mps: f64,
) -> impl Fn(f64) -> (f64, f64) + use<> {
    let p = of_vehicle(vehicle, vehicle.steering_ratio);
    let front_share =
        vehicle.distance_rear_m / (vehicle.distance_front_m + vehicle.distance_rear_m);
    move |hz| {
        let g = response(&p, front_share, speed_mps, hz);
        (g.re, g.im)
    }
}

/// Standard errors of the response of a vehicle in gentle driving from the covariance factor of its data.
pub(crate) fn response_errors(
    vehicle: &VehicleData,
    directions: &[VehicleDirection],
    speed_mps: f64,
) -> Vec<ResponseError> {
    let p = of_vehicle(vehicle, vehicle.steering_ratio);
    let front_share =
        vehicle.distance_rear_m / (vehicle.distance_front_m + vehicle.distance_rear_m);
    ResponseError::all(|hz| {
        if directions.is_empty() {
            return None;
        }
        let mut squares = [0.0; 2];
        for direction in directions {
            let moved = |step: f64| {
                let p = displaced(&p, direction, step);
                // A factor on the angle is one on the gain.
                response(&p, front_share, speed_mps, hz) * p[STEERING_FACTOR].exp()
            };
            let ratio = moved(STEP) / moved(-STEP);
            squares[0] += (ratio.re.hypot(ratio.im).ln() / (2.0 * STEP)).powi(2);
            squares[1] += (ratio.im.atan2(ratio.re) / (2.0 * STEP)).powi(2);
        }
        Some(squares.map(f64::sqrt))
    })
}

/// The parameters of a vehicle that is displaced by a multiple of a direction of its uncertainty.
fn displaced(p: &[f64; PARAMETERS], by: &VehicleDirection, times: f64) -> [f64; PARAMETERS] {
    let mut moved = *p;
    for (parameter, change) in [
        (FRONT, by.wheelbase + by.cornering_stiffness_front - by.yaw_inertia),
        (REAR, by.wheelbase + by.cornering_stiffness_rear - by.yaw_inertia),
        (WHEELBASE, by.wheelbase),
        (INDEX, by.yaw_inertia - 2.0 * by.wheelbase),
        (LAG, by.actuator_time_constant),
        (DELAY, by.actuator_delay_s),
        (STEERING_FACTOR, -by.steering_ratio),
    ] {
        moved[parameter] += times * change;
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> VehicleData {
        VehicleData {
            name: "car".into(),
            mass_kg: 1500.0,
            yaw_inertia_kgm2: 2500.0,
            distance_front_m: 1.2,
            distance_rear_m: 1.5,
            cornering_stiffness_front_npr: 80e3,
            cornering_stiffness_rear_npr: 100e3,
            actuator_time_constant_s: 0.05,
            steering_ratio: 15.0,
            speed_mps: 20.0,
            ..VehicleData::default()
        }
    }

    /// A ratio of one part in ten acts on the gain alone, a delay of 20 ms on the phase alone, and independent
    /// directions add by their squares.
    #[test]
    fn standard_errors_of_known_directions() {
        let none = VehicleDirection::default();
        let ratio = VehicleDirection { steering_ratio: 0.1, ..none };
        let delay = VehicleDirection { actuator_delay_s: 0.02, ..none };
        for error in response_errors(&car(), &[ratio, delay, ratio], 20.0) {
            let late = TAU * error.frequency_hz * 0.02;
            assert!((error.gain - 0.1 * 2_f64.sqrt()).abs() < 1e-6, "{error:?}");
            assert!((error.phase_rad - late).abs() < 1e-6, "{error:?}");
        }
        assert!(response_errors(&car(), &[], 20.0).iter().all(|e| e.gain.is_infinite()));
    }
}
