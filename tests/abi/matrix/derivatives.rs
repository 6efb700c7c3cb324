//! Derivatives of inputs and outputs by time, and directional derivatives.

use super::Case;
use crate::api::{ERROR, OK, Status};
use crate::samples::Sample;
use crate::unit::Unit;
use model_description::{Causality, Kind, Variable};
use std::ptr::{null, null_mut};

const NOWHERE: u32 = 0x0fff_ffff;

pub(super) fn cases(sample: &Sample) -> Vec<Case<'_>> {
    let mut cases = of_inputs(sample);
    cases.extend(of_outputs(sample));
    cases.extend(directional(sample));
    cases
}

/// The status where the flag is set; without it everything is refused.
fn where_supported(flag: bool, status: Status) -> Status {
    if flag { status } else { ERROR }
}

const SET: &str = "fmi2SetRealInputDerivatives";

fn set(unit: &Unit<'_>, references: &[u32], orders: &[i32], values: &[f64]) -> Status {
    let (r, o, v) = (references.as_ptr(), orders.as_ptr(), values.as_ptr());
    // SAFETY: a live instance, as many elements as declared.
    unsafe { (unit.api.set_real_input_derivatives)(unit.component, r, references.len(), o, v) }
}

fn of_inputs(sample: &Sample) -> Vec<Case<'_>> {
    let flag = sample.flags().can_interpolate_inputs;
    let input = sample.continuous(Causality::Input)[0].reference;
    let mut cases = vec![Case::new(SET, "no elements, NULL", where_supported(flag, OK), |unit| {
        // SAFETY: a live instance; without elements pointers are not read.
        unsafe { (unit.api.set_real_input_derivatives)(unit.component, null(), 0, null(), null()) }
    })];
    for variable in sample.continuous(Causality::Input) {
        let class = variable.name.clone();
        cases.push(Case::new(SET, class, where_supported(flag, OK), |unit| {
            let status = set(unit, &[variable.reference], &[1], &[0.01]);
            // Back, for it is no part of what the cases compare.
            if status == OK {
                assert_eq!(set(unit, &[variable.reference], &[1], &[0.0]), OK);
            }
            status
        }));
    }
    let not_inputs = sample
        .variables()
        .iter()
        .filter(|v| v.causality != Causality::Input || v.kind != Kind::Real);
    for variable in not_inputs {
        let class = format!("{}, which is no Real input", variable.name);
        cases.push(Case::new(SET, class, ERROR, |unit| {
            set(unit, &[variable.reference], &[1], &[0.01])
        }));
    }
    for order in [0, 2, -1, i32::MAX, i32::MIN] {
        let class = format!("order {order}");
        cases
            .push(Case::new(SET, class, ERROR, move |unit| set(unit, &[input], &[order], &[0.01])));
    }
    for value in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
        let class = format!("{value}");
        cases.push(Case::new(SET, class, ERROR, move |unit| set(unit, &[input], &[1], &[value])));
    }
    cases.push(Case::new(SET, "an unknown reference", ERROR, |unit| {
        set(unit, &[NOWHERE], &[1], &[0.01])
    }));
    cases.push(Case::new(SET, "good, then unknown", ERROR, move |unit| {
        set(unit, &[input, NOWHERE], &[1, 1], &[0.01, 0.01])
    }));
    for null_at in 0..3 {
        let class = format!("argument {null_at} NULL");
        cases.push(Case::new(SET, class, ERROR, move |unit| {
            let r = if null_at == 0 { null() } else { &raw const input };
            let o = if null_at == 1 { null() } else { &raw const ONE };
            let v = if null_at == 2 { null() } else { &raw const ZERO };
            // SAFETY: a live instance, one element each; null is refused.
            unsafe { (unit.api.set_real_input_derivatives)(unit.component, r, 1, o, v) }
        }));
    }
    cases
}

static ONE: i32 = 1;
static ZERO: f64 = 0.0;

const GET: &str = "fmi2GetRealOutputDerivatives";

/// What must not be there after a call that succeeded, nor change in one that failed.
const UNTOUCHED: f64 = 1.234_567e300;

fn get(unit: &Unit<'_>, references: &[u32], orders: &[i32]) -> Status {
    let mut values = vec![UNTOUCHED; references.len()];
    let (r, o, v) = (references.as_ptr(), orders.as_ptr(), values.as_mut_ptr());
    // SAFETY: a live instance, as many elements as declared.
    let status = unsafe {
        (unit.api.get_real_output_derivatives)(unit.component, r, references.len(), o, v)
    };
    for value in values {
        assert!(if status == OK { value.abs() < 1e9 } else { value == UNTOUCHED }, "{value}");
    }
    status
}

fn of_outputs(sample: &Sample) -> Vec<Case<'_>> {
    let flag = sample.flags().max_output_derivative_order > 0;
    let mut cases = vec![Case::new(GET, "no elements, NULL", where_supported(flag, OK), |unit| {
        let (c, get) = (unit.component, unit.api.get_real_output_derivatives);
        // SAFETY: a live instance; without elements pointers are not read.
        unsafe { get(c, null(), 0, null(), null_mut()) }
    })];
    for variable in sample.continuous(Causality::Output) {
        let reference = variable.reference;
        let name = &variable.name;
        cases.push(Case::new(GET, name, where_supported(flag, OK), move |unit| {
            get(unit, &[reference], &[1])
        }));
        for order in [0, -1, 9, i32::MAX, i32::MIN] {
            cases.push(Case::new(GET, format!("{name}, order {order}"), ERROR, move |unit| {
                get(unit, &[reference], &[order])
            }));
        }
        cases.push(Case::new(GET, format!("{name}, then unknown"), ERROR, move |unit| {
            get(unit, &[reference, NOWHERE], &[1, 1])
        }));
        for null_at in 0..3 {
            let class = format!("{name}, argument {null_at} NULL");
            cases.push(Case::new(GET, class, ERROR, move |unit| {
                let mut value = UNTOUCHED;
                let r = if null_at == 0 { null() } else { &raw const reference };
                let o = if null_at == 1 { null() } else { &raw const ONE };
                let v = if null_at == 2 { null_mut() } else { &raw mut value };
                // SAFETY: a live instance, one element each; null is refused.
                unsafe { (unit.api.get_real_output_derivatives)(unit.component, r, 1, o, v) }
            }));
        }
    }
    let not_outputs = sample
        .variables()
        .iter()
        .filter(|v| v.causality != Causality::Output || v.kind != Kind::Real);
    for variable in not_outputs {
        let class = format!("{}, which is no Real output", variable.name);
        cases.push(Case::new(GET, class, ERROR, |unit| get(unit, &[variable.reference], &[1])));
    }
    cases.push(Case::new(GET, "an unknown reference", ERROR, |unit| get(unit, &[NOWHERE], &[1])));
    cases
}

const DIRECTIONAL: &str = "fmi2GetDirectionalDerivative";

fn seed(unit: &Unit<'_>, unknowns: &[u32], knowns: &[u32], seeds: &[f64]) -> Status {
    let mut values = vec![UNTOUCHED; unknowns.len()];
    let function = unit.api.get_directional_derivative;
    let (u, k, s, v) = (unknowns.as_ptr(), knowns.as_ptr(), seeds.as_ptr(), values.as_mut_ptr());
    // SAFETY: a live instance, as many elements as declared.
    let status = unsafe { function(unit.component, u, unknowns.len(), k, knowns.len(), s, v) };
    for value in values {
        assert!(if status == OK { value.is_finite() } else { value == UNTOUCHED }, "{value}");
    }
    status
}

fn directional(sample: &Sample) -> Vec<Case<'_>> {
    let flag = sample.flags().provides_directional_derivative;
    let supported = where_supported(flag, OK);
    let inputs = sample.continuous(Causality::Input);
    let outputs: Vec<&Variable> = sample.continuous(Causality::Output);
    let input = inputs[0].reference;
    let mut cases = vec![Case::new(DIRECTIONAL, "no elements, NULL", supported, |unit| {
        let (c, function) = (unit.component, unit.api.get_directional_derivative);
        // SAFETY: a live instance; without elements pointers are not read.
        unsafe { function(c, null(), 0, null(), 0, null(), null_mut()) }
    })];
    for output in &outputs {
        for input in &inputs {
            let (output, input) = (output.reference, input.reference);
            cases.push(Case::new(
                DIRECTIONAL,
                format!("{output} by {input}"),
                supported,
                move |u| seed(u, &[output], &[input], &[1.0]),
            ));
        }
    }
    // States and their derivatives, where they are exposed. A state that cannot be set is no known
    // in initialization mode; these are left to the layer's own tests.
    for unknown in &sample.description.derivatives {
        let derivative = sample.description.variable_at(unknown.index).unwrap();
        let state = sample.description.variable_at(derivative.derivative.unwrap()).unwrap();
        let (d, x) = (derivative.reference, state.reference);
        if crate::samples::is_exact(state) {
            let class = format!("{} by {}", derivative.name, state.name);
            cases.push(Case::new(DIRECTIONAL, class, supported, move |unit| {
                seed(unit, &[d], &[x], &[1.0])
            }));
        }
    }
    let Some(output) = outputs.first().map(|v| v.reference) else { return cases };
    for (class, unknowns, knowns, seeds) in [
        ("an unknown unknown", vec![NOWHERE], vec![input], vec![1.0]),
        ("an unknown known", vec![output], vec![NOWHERE], vec![1.0]),
        ("good, then an unknown unknown", vec![output, NOWHERE], vec![input], vec![1.0]),
        ("good, then an unknown known", vec![output], vec![input, NOWHERE], vec![1.0, 1.0]),
        ("an output by itself", vec![output], vec![output], vec![1.0]),
        ("an input by itself", vec![input], vec![input], vec![1.0]),
        ("a seed NaN", vec![output], vec![input], vec![f64::NAN]),
        ("a seed infinite", vec![output], vec![input], vec![f64::INFINITY]),
    ] {
        cases.push(Case::new(DIRECTIONAL, class, ERROR, move |unit| {
            seed(unit, &unknowns, &knowns, &seeds)
        }));
    }
    for null_at in 0..4 {
        let class = format!("argument {null_at} NULL");
        cases.push(Case::new(DIRECTIONAL, class, ERROR, move |unit| {
            let mut value = UNTOUCHED;
            let u = if null_at == 0 { null() } else { &raw const output };
            let k = if null_at == 1 { null() } else { &raw const input };
            let s = if null_at == 2 { null() } else { &raw const ZERO };
            let v = if null_at == 3 { null_mut() } else { &raw mut value };
            // SAFETY: a live instance, one element each; null is refused.
            unsafe { (unit.api.get_directional_derivative)(unit.component, u, 1, k, 1, s, v) }
        }));
    }
    cases
}
