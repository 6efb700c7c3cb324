//! `NonlinearVehicle` as the FMI layer sees it.
#![allow(clippy::unwrap_used)]

use crate::common::{self, get, set, start, step};
use fmi2_export::{CoSimulationUnit, Known, Log, Resources, Unknown};
use model_description::{Causality, Value};
use steerwright_units::{Fmu, NonlinearVehicle};

type Variable = <NonlinearVehicle as CoSimulationUnit>::Variable;

const FILE: &str = include_str!("../../../examples/drives/multibody/vehicle.json");
const TABLE: &model_description::Table = <NonlinearVehicle as CoSimulationUnit>::TABLE;

fn resources(file: Option<&str>) -> Resources {
    let files = file.map(|text| ("vehicle.json".to_owned(), text.as_bytes().to_vec()));
    Resources::from(files.into_iter().collect::<Vec<_>>())
}

fn open() -> NonlinearVehicle {
    NonlinearVehicle::open(&resources(Some(FILE))).unwrap()
}

fn variable(name: &str) -> Variable {
    common::variable::<NonlinearVehicle>(name)
}

fn started(mut unit: NonlinearVehicle) -> NonlinearVehicle {
    start(&mut unit);
    unit
}

/// Everything that can be read, to the bit.
fn all(unit: &mut NonlinearVehicle) -> Vec<u64> {
    let mut numbers: Vec<f64> = TABLE.variables.iter().map(|row| get(unit, row.name)).collect();
    for index in 0..unit.states().len() {
        numbers.extend([unit.state(index), unit.state_derivative(index)]);
    }
    numbers.into_iter().map(f64::to_bits).collect()
}

#[test]
fn every_variable_that_can_be_set_reads_as_it_was_set() {
    let mut unit = open();
    for (k, row) in TABLE.variables.iter().enumerate() {
        if row.causality == Causality::Output {
            continue;
        }
        let (min, max) = (row.min.unwrap_or(-5.0), row.max.unwrap_or(50.0));
        let value = min + (max - min) * (0.3 + 0.01 * k as f64);
        set(&mut unit, row.name, value);
        assert_eq!(get(&mut unit, row.name), value, "{}", row.name);
    }
}

#[test]
fn the_file_is_the_compiled_in_car_and_its_numbers_arrive() {
    let mut without = NonlinearVehicle::open(&resources(None)).unwrap();
    assert_eq!(all(&mut open()), all(&mut without));
    let heavy = FILE.replacen("1093.2952", "2000.0", 1).replacen(
        "\"speed_mps\": 15.0",
        "\"speed_mps\": 9",
        1,
    );
    let mut heavy = NonlinearVehicle::open(&resources(Some(&heavy))).unwrap();
    assert_eq!((get(&mut heavy, "mass"), get(&mut heavy, "speed")), (2000.0, 9.0));
    // A vehicle that the file's checks let pass and the model does not.
    let short = FILE.replacen("\"time_constant_s\": 0.05", "\"time_constant_s\": 1e-6", 1);
    let error = NonlinearVehicle::open(&resources(Some(&short))).unwrap_err();
    assert!(error.contains("vehicle.json") && error.contains("time constant"), "{error}");
    let description = Fmu::NonlinearVehicle
        .describe(vec![("vehicle.json".into(), FILE.into())], Default::default())
        .unwrap();
    assert_eq!(description.model_name, "NonlinearVehicle");
}

#[test]
fn until_the_start_outputs_are_those_of_a_start() {
    let mut unit = open();
    set(&mut unit, "initial_yaw", 0.5);
    set(&mut unit, "initial_x", -3.0);
    unit.set_state(1, 0.25);
    unit.set_state(2, 0.1);
    let before = all(&mut unit);
    assert_eq!(get(&mut unit, "yaw_rate"), 0.25);
    assert_eq!((unit.state(4), unit.state(5), unit.state(6)), (0.5, -3.0, 0.0));
    assert!(get(&mut unit, "lateral_acceleration") > 1.0);
    assert_eq!(all(&mut started(unit)), before);
    // A start that cannot be.
    let mut unit = open();
    unit.set_state(2, 1.4);
    let error = unit.exit_initialization(0.0, &mut Log::default()).unwrap_err();
    assert!(error.contains("road-wheel angle"), "{error}");
}

/// An unknown moves only with what it is said to depend on, and with all of that.
#[test]
fn dependencies_are_those_of_the_equations() {
    let names = ["yaw_rate", "yaw", "x", "y", "lateral_velocity", "lateral_acceleration"];
    let read = |unit: &mut NonlinearVehicle| -> Vec<f64> {
        let mut all: Vec<f64> = names.iter().map(|name| get(unit, name)).collect();
        all.extend((0..7).map(|i| unit.state_derivative(i)));
        all.extend((4..7).map(|i| unit.state(i)));
        all
    };
    let unknowns: Vec<Unknown<Variable>> = names
        .iter()
        .map(|name| Unknown::Variable(variable(name)))
        .chain((0..7).map(Unknown::Derivative))
        .chain((4..7).map(Unknown::State))
        .collect();
    // Below and above 1 m/s, within the actuator's rate and beyond it, between its stops and beyond.
    let settings = [(0.4, 0.101, 0.8), (20.0, 0.101, 0.8), (20.0, 0.6, 0.8), (20.0, 3.0, 0.11)];
    let base = |(speed, steering, stop): (f64, f64, f64)| {
        let mut unit = open();
        set(&mut unit, "speed", speed);
        set(&mut unit, "steering_angle", steering);
        set(&mut unit, "crosswind", 8.0);
        set(&mut unit, "initial_yaw", 0.3);
        set(&mut unit, "road_wheel_angle_max", stop);
        for (index, value) in [0.3, 0.2, 0.1, 3.0].into_iter().enumerate() {
            unit.set_state(index, value);
        }
        unit
    };
    let mut knowns: Vec<(String, Known<Variable>)> =
        (0..4).map(|i| (format!("state {i}"), Known::State(i))).collect();
    for row in TABLE.variables {
        if row.causality != Causality::Output {
            knowns.push((row.name.into(), Known::Variable(variable(row.name))));
        }
    }
    for (name, known) in knowns {
        let mut moved = vec![false; unknowns.len()];
        for setting in settings {
            let before = read(&mut base(setting));
            let mut unit = base(setting);
            match known {
                Known::State(index) => {
                    let value = unit.state(index);
                    unit.set_state(index, value * 1.01);
                }
                Known::Variable(variable) => {
                    let Value::Real(value) = unit.get(variable) else { unreachable!() };
                    unit.set(variable, &Value::Real(value * 1.01 + 1e-4));
                }
            }
            for (moved, (a, b)) in moved.iter_mut().zip(before.iter().zip(read(&mut unit))) {
                *moved |= *a != b;
            }
        }
        for (unknown, moved) in unknowns.iter().zip(moved) {
            let said = open().dependency(*unknown, known).is_some();
            assert_eq!(said, moved, "{unknown:?} by {name}");
        }
    }
}

/// What the layer needs for differences, and what it cannot take them by.
#[test]
fn partial_derivatives_in_the_middle_of_a_drive() {
    let mut unit = driven();
    for index in 0..4 {
        let value = unit.state(index);
        let mut other = unit.clone();
        other.set_state(index, value + 0.01);
        for i in 0..7 {
            let moved = if i == index { value + 0.01 } else { unit.state(i) };
            assert_eq!(other.state(i), moved, "state {i} when state {index} is moved");
        }
    }
    // Yaw cannot be set, but the vehicle could have started elsewhere.
    let turned = |more: f64| {
        let mut unit = open();
        set(&mut unit, "initial_yaw", 0.4 + more);
        unit.set_state(0, 0.7);
        started(unit)
    };
    let h = 1e-6;
    for i in 0..7 {
        let mut unit = turned(0.0);
        let expected = (turned(h).state_derivative(i) - turned(-h).state_derivative(i)) / (2.0 * h);
        let partial = unit.partial_derivative(Unknown::Derivative(i), Known::State(4));
        assert!((partial.unwrap() - expected).abs() < 1e-7, "{i}: {partial:?} {expected}");
    }
    for (name, state) in [("yaw", 4), ("x", 5), ("y", 6)] {
        for other in 4..7 {
            let unknown = Unknown::Variable(variable(name));
            let expected = if other == state { 1.0 } else { 0.0 };
            assert_eq!(unit.partial_derivative(unknown, Known::State(other)), Some(expected));
        }
    }
    assert_eq!(unit.partial_derivative(Unknown::Derivative(0), Known::State(1)), None);
}

/// A vehicle in the middle of a drive, with commands in its delay.
fn driven() -> NonlinearVehicle {
    let mut unit = open();
    set(&mut unit, "actuator_delay", 0.035);
    set(&mut unit, "steering_play", 0.005);
    set(&mut unit, "crosswind", -6.0);
    set(&mut unit, "initial_y", 2.0);
    let mut unit = started(unit);
    for k in 0..30 {
        set(&mut unit, "steering_angle", 0.05 * f64::from(k).sin());
        set(&mut unit, "speed", 15.0 + f64::from(k % 7));
        unit.set_input_derivative(variable("steering_angle"), 0.2 * f64::from(k).cos());
        step(&mut unit, 0.01);
        unit.set_input_derivative(variable("steering_angle"), 0.0);
    }
    unit
}

#[test]
fn a_wind_without_an_area_is_said_to_have_no_effect() {
    for (area, warnings) in [(0.0, 1), (4.0, 0)] {
        let mut unit = open();
        set(&mut unit, "side_force_area", area);
        let mut unit = started(unit);
        set(&mut unit, "crosswind", 10.0);
        let mut log = Log::default();
        for _ in 0..3 {
            unit.step(0.0, 0.01, &mut log).unwrap();
        }
        let lines = log.lines();
        assert_eq!(lines.len(), warnings, "{lines:?}");
        assert!(lines.iter().all(|(_, text)| text.contains("side_force_area is 0")), "{lines:?}");
    }
}
