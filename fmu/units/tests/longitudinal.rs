//! The response of the speed: the same for every communication step, at rest where nothing moves it, and what its inputs do.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::{get, longitudinal, longitudinal_file, set, start, step, variable};
use fmi2_export::model_description::{Causality, Kind, Value};
use fmi2_export::{CoSimulationUnit, Known, Log, Unknown, VariableId};
use steerwright_formats::{Estimate, GearGain, Longitudinal};
use steerwright_units::LongitudinalPlant;

/// Inputs that are held for half a second: accelerator, brake, grade.
fn inputs(k: usize) -> [f64; 3] {
    let wave = (0.9 * k as f64).sin();
    // From 10 s to 15 s a full stop.
    let braking = if (20..30).contains(&k) { 0.9 } else { 0.3 * (-wave).max(0.0) };
    let accelerator = if (20..30).contains(&k) { 0.0 } else { wave.max(0.0) };
    [accelerator, braking, 0.05 * (0.3 * k as f64).cos()]
}

/// Speed, acceleration and distance every half a second, for 20 s in steps of `h`.
fn trajectory(h: f64) -> Vec<[f64; 3]> {
    let mut plant = longitudinal();
    set(&mut plant, "initial_speed", 12.0);
    start(&mut plant);
    let steps = (0.5 / h).round() as usize;
    let mut rows = Vec::new();
    for k in 0..40 {
        for (name, value) in ["accelerator", "brake", "grade"].into_iter().zip(inputs(k)) {
            set(&mut plant, name, value);
        }
        for _ in 0..steps {
            step(&mut plant, h);
        }
        rows.push(["speed", "acceleration", "distance"].map(|name| get(&mut plant, name)));
    }
    rows
}

#[test]
fn the_trajectory_does_not_depend_on_the_communication_step() {
    let expected = trajectory(0.01);
    let stands = expected.iter().filter(|row| row[0] == 0.0).count();
    assert!((4..12).contains(&stands), "{stands}");
    assert!(expected.iter().any(|row| row[0] > 8.0), "{expected:?}");
    for h in [0.001, 0.02, 0.1, 0.25, 0.5, 0.0125] {
        let mut largest = [0.0_f64; 3];
        for (row, other) in trajectory(h).iter().zip(&expected) {
            for i in 0..3 {
                largest[i] = largest[i].max((row[i] - other[i]).abs());
            }
        }
        println!("steps of {h} s: differences of {largest:?} (m/s, m/s2, m)");
        // The distance in the sample in which the vehicle stops or starts is that of straight lines.
        assert!(largest[0] < 1e-9 && largest[1] < 1e-9 && largest[2] < 1e-3, "{h}: {largest:?}");
    }
}

/// Against the equations in steps of 10 µs, with gain and resistances of the present speed.
#[test]
fn the_grid_follows_the_equations() {
    let file = longitudinal_file();
    let h = 1e-5;
    let (mut speed, mut drive, mut brake, mut distance) = (12.0_f64, 0.0, 0.0, 0.0);
    let late = |delay: f64| (delay / h).round() as usize;
    let own_brake = file.brake.unwrap();
    let (delay, brake_delay) = (late(file.delay_s.value), late(own_brake.delay_s.value));
    let per_row = 50_000;
    let at =
        |n: usize, delay: usize| if n < delay { [0.0; 3] } else { inputs((n - delay) / per_row) };
    let mut largest = 0.0_f64;
    for (k, row) in trajectory(0.02).iter().enumerate().take(19) {
        for n in k * per_row..(k + 1) * per_row {
            let pedal = at(n, delay)[0];
            let curved = pedal + file.pedal_curvature.unwrap().value * pedal * (1.0 - pedal);
            let target = file.gain_at(speed) * curved;
            let braking = -own_brake.gain_mps2.value * at(n, brake_delay)[1];
            let slowing = file.resistance_mps2.value
                + file.resistance_per_speed.unwrap().value * speed
                + file.drag_per_m.value * speed * speed
                + file.grade_coefficient.unwrap().value * 9.80665 * inputs(k)[2].sin();
            drive += h * (target - drive) / file.time_constant_s.value;
            brake += h * (braking - brake) / own_brake.time_constant_s.value;
            distance += h * speed;
            speed = (speed + h * (drive + brake - slowing)).max(0.0);
        }
        largest = largest.max((row[0] - speed).abs());
        assert!((row[2] - distance).abs() < 0.05, "{k}: {row:?} {distance}");
    }
    println!("largest difference of the speed {largest:.1e} m/s");
    assert!(largest < 0.02, "{largest}");
}

#[test]
fn a_vehicle_that_nothing_moves_stands() {
    for (grade, accelerator, brake) in
        [(0.0, 0.0, 0.0), (0.0, 0.03, 0.0), (0.3, 0.1, 0.0), (-0.2, 0.0, 1.0), (0.0, 0.0, 1.0)]
    {
        for h in [0.001, 0.02, 0.3] {
            let mut plant = longitudinal();
            for (name, value) in [
                ("initial_speed", 0.0),
                ("grade", grade),
                ("accelerator", accelerator),
                ("brake", brake),
            ] {
                set(&mut plant, name, value);
            }
            start(&mut plant);
            for _ in 0..50 {
                step(&mut plant, h);
                for name in ["speed", "acceleration", "distance"] {
                    assert_eq!(get(&mut plant, name), 0.0, "{name}: {grade} {accelerator} {brake}");
                }
            }
        }
    }
    // And drives off, forwards alone, when the drive overcomes the resistance.
    let mut plant = longitudinal();
    set(&mut plant, "initial_speed", 0.0);
    start(&mut plant);
    set(&mut plant, "accelerator", 0.5);
    step(&mut plant, 3.0);
    assert!(get(&mut plant, "speed") > 2.0 && get(&mut plant, "distance") > 2.0);
}

#[test]
fn gears_have_their_gains_and_commands_their_input() {
    let estimate = |value| Estimate { value, standard_error: 0.1 };
    let base = longitudinal_file();
    let gears = Longitudinal {
        gear_gains: vec![
            GearGain { gear: 1, gain: estimate(5.0) },
            GearGain { gear: 4, gain: estimate(2.0) },
        ],
        gains: base.gains[1..2].to_vec(),
        ..base.clone()
    };
    let accelerations = [(1, 5.0), (4, 2.0), (0, 3.1), (-3, 3.1)].map(|(gear, gain)| {
        let mut plant = common::open_longitudinal(&gears);
        set(&mut plant, "initial_speed", 0.0);
        set(&mut plant, "accelerator", 1.0);
        plant.set(variable::<LongitudinalPlant>("gear"), &Value::Integer(gear));
        start(&mut plant);
        (get(&mut plant, "acceleration"), gain - 0.18)
    });
    for (acceleration, expected) in accelerations {
        assert!((acceleration - expected).abs() < 1e-12, "{accelerations:?}");
    }
    let commanded =
        Longitudinal { command_unit: "m/s2".into(), pedal_curvature: None, brake: None, ..base };
    let mut plant = common::open_longitudinal(&commanded);
    set(&mut plant, "accelerator", 1.0);
    set(&mut plant, "brake", 1.0);
    set(&mut plant, "initial_speed", 0.0);
    start(&mut plant);
    let mut log = Log::default();
    plant.step(0.0, 0.1, &mut log).unwrap();
    plant.step(0.1, 0.1, &mut log).unwrap();
    assert_eq!(get(&mut plant, "speed"), 0.0);
    let lines = format!("{log:?}");
    assert_eq!(lines.matches("accelerator has no effect").count(), 1, "{lines}");
    assert!(lines.contains("brake has no effect: the model has no brake"), "{lines}");
    set(&mut plant, "acceleration_command", 1.0);
    step(&mut plant, 2.0);
    assert!(get(&mut plant, "speed") > 1.0);
}

/// A pedal in percent drives a plant away, so that its unit is doubted.
#[test]
fn a_pedal_beyond_its_ends_is_reported_once() {
    for (pedal, value) in [("accelerator", 30.0), ("accelerator", -1.0), ("brake", 30.0)] {
        let mut plant = longitudinal();
        start(&mut plant);
        let mut log = Log::default();
        set(&mut plant, pedal, 1.05);
        plant.step(0.0, 0.1, &mut log).unwrap();
        assert_eq!(format!("{log:?}").matches("beyond").count(), 0);
        set(&mut plant, pedal, value);
        plant.step(0.1, 0.1, &mut log).unwrap();
        plant.step(0.2, 0.1, &mut log).unwrap();
        let lines = format!("{log:?}");
        assert_eq!(lines.matches("beyond 0 and 1").count(), 1, "{lines}");
        assert!(lines.contains(&format!("{pedal} is {value}")), "{lines}");
    }
}

/// Whatever changes an unknown is among its dependencies, before the start and at a communication point.
#[test]
fn dependencies_are_complete() {
    let n = longitudinal().states().len();
    let real = |causality| {
        let rows = LongitudinalPlant::TABLE.variables.iter();
        rows.filter(move |row| row.causality == causality && row.kind == Kind::Real)
    };
    let mut unknowns: Vec<_> = (0..n).map(Unknown::Derivative).collect();
    unknowns.extend(
        real(Causality::Output)
            .map(|row| Unknown::Variable(variable::<LongitudinalPlant>(row.name))),
    );
    let value = |unit: &LongitudinalPlant, unknown| {
        let mut unit = unit.clone();
        match unknown {
            Unknown::Variable(v) => get(&mut unit, VariableId::spec(v).name),
            Unknown::Derivative(i) => unit.state_derivative(i),
            Unknown::State(i) => unit.state(i),
        }
    };
    for steps in [0, 7] {
        let mut unit = longitudinal();
        for (name, value) in [("accelerator", 0.4), ("brake", 0.1), ("grade", 0.02), ("delay", 0.0)]
        {
            set(&mut unit, name, value);
        }
        if steps > 0 {
            start(&mut unit);
        }
        (0..steps).for_each(|_| step(&mut unit, 0.013));
        let rows = real(Causality::Input).chain(real(Causality::Parameter).filter(|_| steps == 0));
        for row in rows {
            let mut varied = unit.clone();
            let before = get(&mut varied, row.name);
            set(&mut varied, row.name, before + 1e-3);
            let known = Known::Variable(variable::<LongitudinalPlant>(row.name));
            for unknown in &unknowns {
                let is_listed = unit.dependency(*unknown, known).is_some()
                    || matches!(unknown, Unknown::Variable(_)) && steps == 0;
                let changes = value(&varied, *unknown) != value(&unit, *unknown);
                assert!(is_listed || !changes, "{unknown:?} by {}, {steps} steps", row.name);
            }
        }
        for i in 0..if steps > 0 { n } else { 0 } {
            for unknown in &unknowns {
                let is_listed = unit.dependency(*unknown, Known::State(i)).is_some();
                let partial = unit.partial_derivative(*unknown, Known::State(i)).unwrap();
                assert_eq!(is_listed, partial != 0.0, "{unknown:?} by state {i}");
            }
        }
    }
}
