//! `Excitation` against its document: the signals at their times, and what interrupts them.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::{excitation, get, set, start, step, variable};
use fmi2_export::CoSimulationUnit;
use fmi2_export::model_description::Value;
use steerwright_formats::{Document, Manoeuvre};
use steerwright_units::Excitation;

const TS: f64 = 0.05;

fn document() -> Manoeuvre {
    Manoeuvre::from_json(include_str!("../../excitation/example.json"), "it").unwrap()
}

fn enable(unit: &mut Excitation, enabled: bool) {
    unit.set(variable::<Excitation>("enabled"), &Value::Boolean(enabled));
}

/// The steering angles of the manoeuvre at its samples.
fn signal() -> Vec<f64> {
    let file = document();
    let of_block = |block| (0..file.block_samples()).map(move |k| (block, k));
    let all = file.schedule.iter().flat_map(of_block);
    all.map(|(block, k)| file.steering_rad(block, k)).collect()
}

/// The angle at tick 0 and after each of so many ticks more.
fn angles(unit: &mut Excitation, ticks: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for _ in 0..ticks {
        step(unit, TS);
        all.push(get(unit, "steering_angle"));
    }
    all
}

#[test]
fn the_blocks_follow_each_other_as_in_the_document() {
    let signal = signal();
    let mut unit = excitation();
    start(&mut unit);
    let mut found = vec![get(&mut unit, "steering_angle")];
    found.extend(angles(&mut unit, signal.len() - 1));
    assert_eq!(found, signal);
    assert_eq!([get(&mut unit, "active"), get(&mut unit, "finished")], [1.0, 0.0]);
    assert_eq!(angles(&mut unit, 2), [0.0, 0.0]);
    assert_eq!([get(&mut unit, "active"), get(&mut unit, "finished")], [0.0, 1.0]);

    // In steps of a fifth of a sample, and with a wait for the speed before the second block.
    let mut unit = excitation();
    start(&mut unit);
    let per_block = signal.len() / 2;
    let mut found = Vec::new();
    for k in 0..signal.len() + 20 {
        found.push(get(&mut unit, "steering_angle"));
        let is_slow = (per_block - 1..per_block + 19).contains(&k);
        set(&mut unit, "speed", if is_slow { 12.0 } else { 15.0 });
        for _ in 0..5 {
            step(&mut unit, TS / 5.0);
        }
    }
    assert_eq!(found[..per_block], signal[..per_block]);
    assert_eq!(found[per_block..per_block + 20], [0.0; 20]);
    assert_eq!(found[per_block + 20..], signal[per_block..]);
    assert_eq!(get(&mut unit, "interruption"), 0.0);
}

#[test]
fn a_limit_interrupts_a_block_which_is_driven_again() {
    let signal = signal();
    let limit = document().limits.max_lateral_acceleration_mps2;
    let most = 0.04 * TS;
    for (cause, code) in [("lateral_acceleration", 1.0), ("speed", 2.0), ("enabled", 3.0)] {
        let mut unit = excitation();
        set(&mut unit, "return_rate", 0.04);
        start(&mut unit);
        // Just below each limit nothing happens.
        set(&mut unit, "lateral_acceleration", 0.99 * limit);
        assert_eq!(angles(&mut unit, 9), signal[1..10], "{cause}");
        match cause {
            "lateral_acceleration" => set(&mut unit, "lateral_acceleration", -limit),
            "speed" => set(&mut unit, "speed", 13.4),
            _ => enable(&mut unit, false),
        }
        let mut angle = get(&mut unit, "steering_angle");
        assert!(angle.abs() > 2.0 * most, "{angle} {most}");
        for next in angles(&mut unit, 20) {
            assert!(next == 0.0 || (angle - next).abs() <= most * (1.0 + 1e-9), "{angle} {next}");
            assert!(next.abs() <= angle.abs(), "{angle} {next}");
            angle = next;
        }
        assert_eq!(angle, 0.0);
        assert_eq!(get(&mut unit, "interruption"), code, "{cause}");
        set(&mut unit, "lateral_acceleration", 0.0);
        set(&mut unit, "speed", 15.0);
        // Only what was disabled is driven again.
        if cause != "enabled" {
            assert_eq!(angles(&mut unit, 3), [0.0; 3], "{cause}");
            enable(&mut unit, false);
            assert_eq!(angles(&mut unit, 3), [0.0; 3], "{cause}");
        }
        enable(&mut unit, true);
        assert_eq!(angles(&mut unit, signal.len()), signal, "{cause}");
        assert_eq!(get(&mut unit, "interruption"), 0.0);
        assert_eq!(get(&mut unit, "block"), 2.0);
    }
}
