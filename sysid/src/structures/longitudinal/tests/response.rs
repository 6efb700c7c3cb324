//! The response that a file states, compared with that of the vehicle itself to a small sine of its pedal.

use super::car::{Car, Drive};
use super::identify;
use crate::structures::longitudinal::model::{
    COUNT, DELAY, DRAG, LAG, Point, RESISTANCE_PER_SPEED, Schedule,
};
use crate::structures::longitudinal::{name, parameters};
use faer::c64;
use std::f64::consts::TAU;
use steerwright_formats::{Grade, Longitudinal};

const FREQUENCIES_HZ: [f64; 3] = [0.1, 0.3, 1.0];
const SPEEDS_MPS: [f64; 2] = [9.0, 18.0];
/// Error of the gain at the lowest frequency from which a model that passes is wrong.
const WRONG: f64 = 0.2;
/// Quantile of χ² with two degrees of freedom: 95 %.
const BAND: f64 = 5.99;

/// From the command to the acceleration, of a model in a gear at a speed with a steady command.
fn response(
    (schedule, p): (&Schedule, &Point),
    (speed, gear): (f64, i64),
    command: f64,
    frequency_hz: f64,
) -> c64 {
    let gain = |speed: f64| {
        let (low, high, share) = schedule.weights(speed, Some(gear));
        (1.0 - share) * p[low] + share * p[high]
    };
    let s = c64::new(0.0, TAU * frequency_hz);
    let slope = (gain(speed + 0.5) - gain(speed - 0.5)) * command;
    let damping = p[RESISTANCE_PER_SPEED] + 2.0 * p[DRAG] * speed - slope;
    let drive = c64::new(1.0, 0.0) / (c64::new(1.0, 0.0) + s * p[LAG]);
    let late = c64::new(0.0, -TAU * frequency_hz * p[DELAY]).exp();
    drive * late * gain(speed) * s / (s + c64::new(damping, 0.0))
}

/// Ratio of the model's response to that of the vehicle, and whether the 95 % band contains the truth.
fn compare(
    model: &Longitudinal,
    truth: c64,
    place: (f64, i64),
    command: f64,
    hz: f64,
) -> (c64, bool) {
    let (schedule, point) = parameters(model);
    let of_model = response((&schedule, &point), place, command, hz);
    let places: Vec<usize> = model
        .parameters
        .iter()
        .filter_map(|key| (0..COUNT).find(|i| name(&schedule, *i) == *key))
        .collect();
    assert_eq!(places.len(), model.parameters.len());
    let by: Vec<c64> = places
        .iter()
        .map(|i| {
            let mut moved = point;
            let step = 1e-5 * point[*i].abs().max(0.01);
            moved[*i] += step;
            (response((&schedule, &moved), place, command, hz) - of_model) * (1.0 / step)
        })
        .collect();
    let [mut rr, mut ri, mut ii] = [0.0; 3];
    for (a, x) in by.iter().enumerate() {
        for (b, y) in by.iter().enumerate() {
            let c = model.covariance.0[a][b];
            rr += c * x.re * y.re;
            ri += c * x.re * y.im;
            ii += c * x.im * y.im;
        }
    }
    let error = of_model - truth;
    let determinant = (rr * ii - ri * ri).max(1e-30);
    let square = (ii * error.re.powi(2) - 2.0 * ri * error.re * error.im + rr * error.im.powi(2))
        / determinant;
    (of_model / truth, square < BAND)
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn responses_of_usual_vehicles_are_those_of_the_files() {
    let mut rows = 0;
    let mut inside = [0; 3];
    let mut errors: [Vec<f64>; 3] = [const { Vec::new() }; 3];
    let (mut passes, mut wrong) = (0, 0);
    for seed in 0..24 {
        let car = Car::usual(seed);
        let model = identify(&car.drive(seed, 420.0));
        let is_pass = model.quality.grade == Grade::Pass;
        passes += usize::from(is_pass);
        let mut text = String::new();
        for speed in SPEEDS_MPS {
            rows += 1;
            for (i, hz) in FREQUENCIES_HZ.into_iter().enumerate() {
                let (truth, gear, command) = car.response(speed, hz);
                let (ratio, is_inside) =
                    compare(&model, c64::new(truth[0], truth[1]), (speed, gear), command, hz);
                inside[i] += usize::from(is_inside);
                errors[i].push((ratio - c64::new(1.0, 0.0)).norm());
                let is_wrong = i == 0 && (ratio.norm() - 1.0).abs() > WRONG;
                wrong += usize::from(is_wrong && is_pass);
                let mark = if is_inside { "" } else { "*" };
                text += &format!(" {:.2}∠{:+.0}°{mark}", ratio.norm(), ratio.arg().to_degrees());
            }
            text += ";";
        }
        let kind = match car.drive {
            Drive::Engine { .. } => "engine",
            Drive::Motor { .. } => "motor",
            Drive::Linear(_) => "command",
        };
        eprintln!(
            "{seed} {kind}: {} {},{text} lag {:.2} of {:.2}, residuals {:.3?}, {:.1}",
            model.quality.grade,
            model.quality.codes(),
            model.time_constant_s.value,
            car.lag_s,
            model.evidence.residual_correlation,
            model.evidence.residual_correlation[1] / model.evidence.correlation_standard_error,
        );
    }
    for (i, hz) in FREQUENCIES_HZ.into_iter().enumerate() {
        errors[i].sort_by(f64::total_cmp);
        eprintln!(
            "{hz} Hz: {} of {rows} bands contain the truth; errors {:.1} % in the middle, {:.1} % at most",
            inside[i],
            100.0 * errors[i][errors[i].len() / 2],
            100.0 * errors[i][errors[i].len() - 1],
        );
    }
    eprintln!("{passes} of 24 pass; {wrong} of their gains at 0.1 Hz are wrong by more than 20 %");
    assert_eq!(wrong, 0);
}
