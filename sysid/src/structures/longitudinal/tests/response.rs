//! The response that a file states, compared with that of the vehicle itself to a small sine of its pedal.

use super::car::{Car, Drive};
use super::{identify, lacks_the_gear_alone};
use crate::structures::longitudinal::model::{
    COUNT, DELAY, DRAG, LAG, PEDAL, Point, RESISTANCE_PER_SPEED, Schedule,
};
use crate::structures::longitudinal::{name, parameters};
use faer::c64;
use std::f64::consts::TAU;
use std::ops::Range;
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
    let acting = command + p[PEDAL] * command * (1.0 - command);
    let slope = (gain(speed + 0.5) - gain(speed - 0.5)) * acting;
    let damping = p[RESISTANCE_PER_SPEED] + 2.0 * p[DRAG] * speed - slope;
    let drive = c64::new(1.0, 0.0) / (c64::new(1.0, 0.0) + s * p[LAG]);
    let late = c64::new(0.0, -TAU * frequency_hz * p[DELAY]).exp();
    let pedal = 1.0 + p[PEDAL] * (1.0 - 2.0 * command);
    drive * late * pedal * gain(speed) * s / (s + c64::new(damping, 0.0))
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

/// What was counted over vehicles.
#[derive(Debug, Default)]
struct Count {
    passes: usize,
    /// Those that pass, or would with the gear.
    usable: usize,
    /// Gains of models that pass which are wrong.
    wrong: usize,
    /// Engines without a gear in the log that pass.
    unnoticed: usize,
    /// Vehicles of one gear that are doubted to be.
    doubted: usize,
    /// Errors of the response, by frequency.
    errors: [Vec<f64>; 3],
}

/// Identifies vehicles from drives of 7 min, and prints what was found.
fn identify_usual(seeds: Range<u64>) -> Count {
    let mut count = Count::default();
    let mut inside = [0; 3];
    for seed in seeds.clone() {
        let car = Car::usual(seed);
        let model = identify(&car.drive(seed, 420.0));
        let e = &model.evidence;
        let is_pass = model.quality.grade == Grade::Pass;
        let is_unknown = model.quality.codes().contains("unknown-gear");
        count.passes += usize::from(is_pass);
        count.usable += usize::from(is_pass || lacks_the_gear_alone(&model));
        let kind = match car.drive {
            Drive::Engine { .. } => "engine",
            Drive::Motor { .. } => "motor",
            Drive::Linear(_) => "command",
        };
        if kind == "engine" && !car.logs_gear {
            count.unnoticed += usize::from(!is_unknown);
        } else {
            count.doubted += usize::from(is_unknown);
        }
        let mut text = String::new();
        for speed in SPEEDS_MPS {
            for (i, hz) in FREQUENCIES_HZ.into_iter().enumerate() {
                let (truth, gear, command) = car.response(speed, hz);
                let (ratio, is_inside) =
                    compare(&model, c64::new(truth[0], truth[1]), (speed, gear), command, hz);
                inside[i] += usize::from(is_inside);
                count.errors[i].push((ratio - c64::new(1.0, 0.0)).norm());
                let is_wrong = i == 0 && (ratio.norm() - 1.0).abs() > WRONG;
                count.wrong += usize::from(is_wrong && is_pass);
                let mark = if is_inside { "" } else { "*" };
                text += &format!(" {:.2}∠{:+.0}°{mark}", ratio.norm(), ratio.arg().to_degrees());
            }
            text += ";";
        }
        eprintln!(
            "{seed} {kind}: {} {}, fit {:.1} ± {:.1} %,{text} lag {:.2} of {:.2}, residuals {:.3?}, variation {:.3?}",
            model.quality.grade,
            model.quality.codes(),
            e.validation_fit,
            1.96 * e.validation_fit_standard_error.unwrap_or(f64::NAN),
            model.time_constant_s.value,
            car.lag_s,
            e.residual_correlation,
            e.gain_variation.map(|variation| [variation.deviation, variation.largest]),
        );
    }
    for (i, hz) in FREQUENCIES_HZ.into_iter().enumerate() {
        let errors = &mut count.errors[i];
        errors.sort_by(f64::total_cmp);
        let rows = errors.len();
        eprintln!(
            "{hz} Hz: {} of {rows} bands contain the truth; errors {:.1} % in the middle, {:.1} % at most",
            inside[i],
            100.0 * errors[rows / 2],
            100.0 * errors[rows - 1],
        );
    }
    let Count { passes, usable, wrong, unnoticed, doubted, .. } = &count;
    eprintln!(
        "{passes} of {} pass, {usable} have no other reason than a log without the gear; {wrong} gains of those that pass are wrong \
         at 0.1 Hz by more than 20 %; {unnoticed} engines without a gear are not noticed, {doubted} others are doubted",
        seeds.count(),
    );
    count
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn responses_of_usual_vehicles_are_those_of_the_files() {
    let count = identify_usual(0..24);
    assert!(count.passes >= 19 && count.usable >= 20, "{count:?}");
    assert_eq!((count.wrong, count.unnoticed, count.doubted), (0, 0, 0));
    for errors in &count.errors {
        assert!(errors[errors.len() / 2] < 0.08, "{errors:?}");
    }
}

/// Vehicles that no bound was chosen with.
#[test]
#[ignore = "slow: cargo xtask test"]
fn gears_of_other_vehicles_are_noticed() {
    let count = identify_usual(144..192);
    assert!(count.passes >= 38 && count.wrong <= 1, "{count:?}");
    assert!(count.unnoticed <= 1 && count.doubted <= 1, "{count:?}");
}
