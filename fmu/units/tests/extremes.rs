//! Inputs, parameters and steps at the ends of the numbers: an answer or an error that names what
//! went wrong, never a panic, and never a state that is not finite without an error.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::{
    bicycle, excitation, get, identified, kinds, longitudinal, nonlinear, path, pid, pose,
    speed_controller,
};
use fmi2_export::model_description::{Causality, Kind, Value};
use fmi2_export::{CoSimulationUnit, Log, VariableId};
use proptest::prelude::*;

fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0_f64,
        1 => prop::sample::select(vec![
            0.0, -0.0, f64::MIN_POSITIVE, 5e-324, -5e-324, 1e-300, f64::EPSILON, 1e6, -1e6,
            1e154, -1e154, 1e155, 1e300, f64::MAX, f64::MIN,
        ]),
        1 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
    ]
}

fn step_size() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 1e-3..0.1_f64,
        1 => prop::sample::select(vec![5e-324, 1e-300, 1e-18, 1e-9, 2.0, 30.0]),
    ]
}

/// What the layer lets through of a row: within its limits.
fn allowed(row: &model_description::VariableSpec, value: f64) -> f64 {
    value.max(row.min.unwrap_or(f64::MIN)).min(row.max.unwrap_or(f64::MAX))
}

fn survive<S: CoSimulationUnit>(
    mut unit: S,
    parameters: &[(usize, f64)],
    steps: &[(f64, [f64; 5])],
) -> Result<(), TestCaseError> {
    let real = |row: &&model_description::VariableSpec| row.kind == Kind::Real;
    let of = |causality| {
        let rows = S::TABLE.variables.iter().filter(move |row| row.causality == causality);
        rows.filter(real).collect::<Vec<_>>()
    };
    let (knowns, inputs) = (of(Causality::Parameter), of(Causality::Input));
    let assign = |unit: &mut S, row: &model_description::VariableSpec, value: f64| {
        let variable = S::Variable::from_reference(row.reference).unwrap();
        unit.set(variable, &Value::Real(allowed(row, value)));
    };
    let n = unit.states().len();
    for &(place, value) in parameters {
        let row = knowns[place % knowns.len()];
        assign(&mut unit, row, value);
        if n > 0 {
            unit.set_state(place % n, value);
        }
        S::TABLE.variables.iter().for_each(|row| {
            get(&mut unit, row.name);
        });
    }
    let refused = |error: &str| !error.is_empty() && error.contains("hint:");
    if let Err(error) = unit.exit_initialization(0.0, &mut Log::default()) {
        prop_assert!(refused(&error), "{error}");
        return Ok(());
    }
    for (h, values) in steps {
        for (row, &value) in inputs.iter().zip(values) {
            assign(&mut unit, row, value);
            let variable = S::Variable::from_reference(row.reference).unwrap();
            unit.set_input_derivative(variable, if n > 0 { values[4] } else { 0.0 });
        }
        // Whatever counts events counts one, more or less.
        for row in S::TABLE.variables.iter().filter(|row| row.kind == Kind::Integer) {
            let variable = S::Variable::from_reference(row.reference).unwrap();
            unit.set(variable, &Value::Integer(i32::from(*h < 0.05)));
        }
        let result = unit.step(0.0, *h, &mut Log::default());
        let states: Vec<f64> = (0..n).map(|i| unit.state(i)).collect();
        // Everything can be asked for, whatever it is.
        (0..n).for_each(|i| {
            unit.state_derivative(i);
        });
        let variables: Vec<f64> =
            S::TABLE.variables.iter().map(|row| get(&mut unit, row.name)).collect();
        let loaded = unit.clone().load(&unit.save());
        match result {
            Ok(()) => {
                prop_assert!(loaded.is_ok(), "{loaded:?}");
                prop_assert!(states.iter().all(|x| x.is_finite()), "{states:?}");
                // Of a plant, speed times yaw rate may still overflow.
                prop_assert!(n > 0 || variables.iter().all(|x| x.is_finite()), "{variables:?}");
            }
            Err(error) => {
                prop_assert!(refused(&error), "{error}");
                return Ok(());
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn nothing_panics(
        parameters in prop::collection::vec((any::<usize>(), extreme()), 0..6),
        steps in prop::collection::vec((step_size(), prop::array::uniform5(extreme())), 1..8),
        kind in prop::sample::select(kinds()),
    ) {
        survive(identified(kind), &parameters, &steps)?;
        survive(bicycle(), &parameters, &steps)?;
        survive(nonlinear(), &parameters, &steps)?;
        survive(longitudinal(), &parameters, &steps)?;
        survive(pid(), &parameters, &steps)?;
        survive(speed_controller(), &parameters, &steps)?;
        survive(excitation(), &parameters, &steps)?;
        survive(pose(), &parameters, &steps)?;
        for closed in [false, true] {
            survive(path(closed), &parameters, &steps)?;
        }
    }
}

/// Each parameter and each state at the ends of the numbers, along with each other one.
#[test]
fn the_largest_numbers_of_a_vehicle() {
    let steps = [(1e-3, [0.0; 5])];
    for (first, second) in (0..40).flat_map(|first| (0..40).map(move |second| (first, second))) {
        for largest in [f64::MAX, f64::MIN] {
            survive(nonlinear(), &[(first, largest), (second, 4.9)], &steps).unwrap();
        }
    }
}

/// A step over more grid points than can be walked is refused, not walked.
#[test]
fn too_many_grid_points() {
    let mut file = common::plant_file(common::PLAIN);
    file.continuous = None;
    file.discrete.sample_time_s = 1e-9;
    let bytes = steerwright_formats::Document::to_json(&file).into_bytes();
    let resources = fmi2_export::Resources::from(vec![("plant.json".into(), bytes)]);
    let mut plant = steerwright_units::IdentifiedPlant::open(&resources).unwrap();
    common::start(&mut plant);
    let error = plant.step(0.0, 1.0, &mut Log::default()).unwrap_err();
    assert!(error.contains("1.000e9 grid points") && error.contains("shorter"), "{error}");
    plant.step(0.0, 1e-6, &mut Log::default()).unwrap();
}
