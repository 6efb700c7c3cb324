//! Derivatives of inputs and outputs, and directional derivatives.

use super::host::{ERROR, OK, STATES};
use super::plant::*;
use crate::calls::State;
use std::ptr::{null, null_mut};

#[test]
fn an_input_derivative_acts_within_one_step() {
    // der(x1) = -x1/2 + 2 u with u = 3 + 4 t is met by Heun's method up to its order.
    let rig = Rig::in_state(State::StepComplete);
    assert_eq!(rig.set(U, 3.0), OK);
    assert_eq!(on!(rig, set_real_input_derivatives(&U, 1, &1, &4.0)), OK);
    assert_eq!(on!(rig, do_step(0.0, 0.5, 1)), OK);
    let slope = (2.0 * 3.0 - 0.5, 2.0 * (3.0 + 0.5 * 4.0) - 0.5 * (1.0 + 0.5 * 5.5));
    assert_eq!(rig.real(X1), 1.0 + 0.25 * (slope.0 + slope.1));
    // The input keeps its value, and its derivative is zero.
    assert_eq!(rig.real(U), 3.0);
    let x = rig.real(X1);
    assert_eq!(on!(rig, do_step(0.5, 0.5, 1)), OK);
    let rate = |x: f64| 6.0 - 0.5 * x;
    let second = rate(x + 0.5 * rate(x));
    assert_eq!(rig.real(X1), x + 0.25 * (rate(x) + second));
}

#[test]
fn a_derivative_is_zero_again_after_one_step_and_after_a_reset() {
    let growth = |rig: &Rig| rig.instance().core.input_derivatives.clone();
    let rig = Rig::in_state(State::StepComplete);
    // The last one counts.
    let set = || {
        let (references, orders, values) = ([U, U], [1, 1], [1.0, 2.0]);
        let (r, o, v) = (references.as_ptr(), orders.as_ptr(), values.as_ptr());
        assert_eq!(on!(rig, set_real_input_derivatives(r, 2, o, v)), OK);
        assert_eq!(growth(&rig), [(U, 2.0)]);
    };
    set();
    assert_eq!(on!(rig, do_step(0.0, 0.5, 1)), OK);
    assert_eq!(growth(&rig), []);
    set();
    assert_eq!(on!(rig, reset()), OK);
    assert_eq!(growth(&rig), []);
    assert_eq!(*rig.instance().core.unit, *Rig::new().instance().core.unit);
}

#[test]
fn wrong_arguments_of_input_derivatives_change_nothing() {
    let try_it = |reference: u32, order: i32, value: f64| {
        let rig = Rig::in_state(State::StepComplete);
        let before = (*rig.instance().core.unit).clone();
        // The first one is valid.
        let (references, orders, values) = ([U, reference], [1, order], [1.0, value]);
        let (r, o, v) = (references.as_ptr(), orders.as_ptr(), values.as_ptr());
        assert_eq!(on!(rig, set_real_input_derivatives(r, 2, o, v)), ERROR);
        assert_eq!(*rig.instance().core.unit, before, "{reference} {order} {value}");
        assert_eq!(rig.instance().core.input_derivatives, []);
        assert_eq!((rig.state(), rig.take_lines().len()), (State::Error, 1));
    };
    for order in [0, 2, -1, i32::MAX, i32::MIN] {
        try_it(U, order, 1.0);
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        try_it(U, 1, value);
    }
    // An output, a parameter, an Integer, a discrete input, a state, nothing.
    for reference in [Y, A, N, GATE, X1, 99, u32::MAX] {
        try_it(reference, 1, 1.0);
    }
    let fresh = || Rig::in_state(State::StepComplete);
    assert_eq!(on!(fresh(), set_real_input_derivatives(null(), 1, &1, &1.0)), ERROR);
    assert_eq!(on!(fresh(), set_real_input_derivatives(&U, 1, null(), &1.0)), ERROR);
    assert_eq!(on!(fresh(), set_real_input_derivatives(&U, 1, &1, null())), ERROR);
    assert_eq!(on!(fresh(), set_real_input_derivatives(null(), 0, null(), null())), OK);
}

#[test]
fn output_derivatives() {
    let rig = Rig::in_state(State::StepComplete);
    assert_eq!(rig.set(U, 3.0), OK);
    let mut values = [0.0; 2];
    let (references, orders) = ([Y, Z], [1, 1]);
    let (r, o) = (references.as_ptr(), orders.as_ptr());
    assert_eq!(on!(rig, get_real_output_derivatives(r, 2, o, values.as_mut_ptr())), OK);
    assert_eq!(values, [5.5, 1.0]);
    for (reference, order) in
        [(Y, 0), (Y, 2), (Y, -1), (U, 1), (HELD, 1), (TWICE, 1), (X1, 1), (DX1, 1), (99, 1)]
    {
        let rig = Rig::in_state(State::StepComplete);
        let mut values = [7.0; 2];
        let (references, orders) = ([Y, reference], [1, order]);
        let (r, o) = (references.as_ptr(), orders.as_ptr());
        let status = on!(rig, get_real_output_derivatives(r, 2, o, values.as_mut_ptr()));
        assert_eq!((status, values), (ERROR, [7.0; 2]), "{reference} {order}");
    }
    let fresh = || Rig::in_state(State::StepComplete);
    let mut value = 0.0;
    assert_eq!(on!(fresh(), get_real_output_derivatives(null(), 1, &1, &mut value)), ERROR);
    assert_eq!(on!(fresh(), get_real_output_derivatives(&Y, 1, null(), &mut value)), ERROR);
    assert_eq!(on!(fresh(), get_real_output_derivatives(&Y, 1, &1, null_mut())), ERROR);
    assert_eq!(on!(fresh(), get_real_output_derivatives(null(), 0, null(), null_mut())), OK);
}

/// The pairs of unknown and known in each state, with their partial derivative if they are legal.
#[test]
fn partial_derivatives_by_state_of_the_machine() {
    let close = |got: f64, need: f64| (got - need).abs() <= 1e-9 * need.abs().max(1.0);
    let later = [
        (Y, U, D),
        (Y, X1, 1.0),
        (Y, X2, 0.0),
        (Z, X2, 1.0),
        (Z, U, 0.0),
        (HELD, GATE, 1.0),
        (DX1, U, 2.0),
        (DX1, X1, -0.5),
        (DX2, X1, 1.0),
        (DX2, GATE, 0.0),
    ];
    let initially = [
        (Y, U, D),
        (Y, X1, 1.0),
        (Y, A, 0.0),
        (Z, Z0, 1.0),
        (TWICE, Z0, 2.0),
        (TWICE, X1, 0.0),
        (X2, Z0, 1.0),
        (X2, U, 0.0),
        (DX1, U, 2.0),
        (DX1, A, -1.0),
        (DX1, B, 3.0),
        (DX1, X1, -0.5),
    ];
    for (state, _) in STATES {
        let pairs: &[_] = match state {
            State::Instantiated => &[],
            State::Initialization => &initially,
            _ => &later,
        };
        let make = || {
            let rig = Rig::in_state(state);
            if matches!(state, State::Initialization | State::StepComplete) {
                assert_eq!(rig.set(U, 3.0), OK);
            }
            rig
        };
        for unknown in [U, A, B, Z0, Y, Z, TWICE, HELD, N, GATE, X1, DX1, X2, DX2, 99] {
            for known in [U, A, B, Z0, Y, Z, TWICE, HELD, N, GATE, X1, DX1, X2, DX2, 99] {
                let place = format!("∂{unknown:x}/∂{known:x} in {state:?}");
                let unknowns: &[u32] = match state {
                    State::Instantiated => &[],
                    State::Initialization => &[Y, Z, TWICE, HELD, X2, DX1, DX2],
                    _ => &[Y, Z, HELD, DX1, DX2],
                };
                let knowns: &[u32] = match state {
                    // The derivative with respect to an Integer is zero.
                    State::Initialization => &[U, GATE, A, B, Z0, N, X1],
                    _ => &[U, GATE, X1, X2],
                };
                let rig = make();
                let before = (*rig.instance().core.unit).clone();
                let got = rig.partial(unknown, known);
                assert_eq!(*rig.instance().core.unit, before, "{place}");
                if !unknowns.contains(&unknown) || !knowns.contains(&known) {
                    assert_eq!(got, Err(ERROR), "{place}");
                    assert_eq!(rig.take_lines().len(), 1, "{place}");
                    continue;
                }
                let got = got.unwrap_or_else(|_| panic!("{place}: {:?}", rig.take_lines()));
                if let Some((.., need)) =
                    pairs.iter().find(|(u, k, _)| (*u, *k) == (unknown, known))
                {
                    // The limits of `a` leave a one-sided difference of 1e-9.
                    let need_close =
                        if known == A { (got - need).abs() < 1e-5 } else { close(got, *need) };
                    assert!(need_close, "{place}: {got} instead of {need}");
                }
            }
        }
    }
}

#[test]
fn a_direction_sums_over_the_knowns() {
    let rig = Rig::in_state(State::StepComplete);
    let (unknowns, knowns, seed) = ([DX1, Y, DX2, Y], [U, X1, U], [10.0, 4.0, 0.0]);
    let mut result = [f64::NAN; 4];
    let status = on!(
        rig,
        get_directional_derivative(
            unknowns.as_ptr(),
            4,
            knowns.as_ptr(),
            3,
            seed.as_ptr(),
            result.as_mut_ptr()
        )
    );
    assert_eq!(status, OK);
    for (got, need) in result.iter().zip([18.0, 6.5, 4.0, 6.5]) {
        assert!((got - need).abs() < 1e-8, "{result:?}");
    }
    // Without knowns the derivatives are zero; without unknowns nothing is written.
    let mut value = 7.0;
    assert_eq!(on!(rig, get_directional_derivative(&Y, 1, null(), 0, null(), &mut value)), OK);
    assert_eq!(value, 0.0);
    assert_eq!(on!(rig, get_directional_derivative(null(), 0, &U, 1, &1.0, null_mut())), OK);
}

#[test]
fn wrong_arguments_of_directional_derivatives_write_nothing() {
    let mut value = 7.0;
    for seed in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let rig = Rig::in_state(State::StepComplete);
        assert_eq!(on!(rig, get_directional_derivative(&Y, 1, &U, 1, &seed, &mut value)), ERROR);
        assert!(rig.take_lines()[0].3.contains("dvKnown"));
    }
    let fresh = || Rig::in_state(State::StepComplete);
    assert_eq!(on!(fresh(), get_directional_derivative(null(), 1, &U, 1, &1.0, &mut value)), ERROR);
    assert_eq!(on!(fresh(), get_directional_derivative(&Y, 1, null(), 1, &1.0, &mut value)), ERROR);
    assert_eq!(on!(fresh(), get_directional_derivative(&Y, 1, &U, 1, null(), &mut value)), ERROR);
    assert_eq!(on!(fresh(), get_directional_derivative(&Y, 1, &U, 1, &1.0, null_mut())), ERROR);
    // Too large to be a number.
    let rig = fresh();
    assert_eq!(on!(rig, get_directional_derivative(&DX1, 1, &U, 1, &1e308, &mut value)), ERROR);
    assert_eq!(value, 7.0);
}

/// Finite differences fit any magnitude.
#[test]
fn differences_at_large_and_small_values() {
    for (u, tolerance) in
        [(0.0, 1e-9), (1e-9, 1e-9), (1e3, 1e-9), (-1e3, 1e-9), (999.999_999, 1e-9)]
    {
        let rig = Rig::in_state(State::StepComplete);
        assert_eq!(rig.set(U, u), OK);
        let got = rig.partial(DX1, U).unwrap();
        assert!((got - 2.0).abs() < tolerance, "{got} at {u}");
    }
    let rig = Rig::in_state(State::Initialization);
    assert_eq!(rig.set(X1, 1e12), OK);
    assert!((rig.partial(DX1, X1).unwrap() + 0.5).abs() < 1e-9);
}

#[test]
fn without_the_capability_each_is_an_error() {
    type Poor = Plant<None_>;
    use crate::boundary as c;
    let rig = Rig::<None_>::instantiated(false);
    let (mut value, mut state) = (0.0, null_mut());
    // SAFETY: a live instance of that plant, good arguments.
    unsafe {
        let p = rig.component;
        let ready = || {
            assert_eq!(c::reset::<Poor>(p), OK);
            assert_eq!(c::setup_experiment::<Poor>(p, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(c::enter_initialization_mode::<Poor>(p), OK);
            assert_eq!(c::exit_initialization_mode::<Poor>(p), OK);
        };
        ready();
        assert_eq!(c::set_real_input_derivatives::<Poor>(p, &U, 1, &1, &1.0), ERROR);
        ready();
        assert_eq!(c::get_real_output_derivatives::<Poor>(p, &Y, 1, &1, &mut value), ERROR);
        ready();
        let status = c::get_directional_derivative::<Poor>(p, &Y, 1, &U, 1, &1.0, &mut value);
        assert_eq!(status, ERROR);
        ready();
        assert_eq!(c::get_fmu_state::<Poor>(p, &mut state), OK);
        assert_eq!(c::serialized_fmu_state_size::<Poor>(p, state, &mut 0), ERROR);
        ready();
        let mut bytes = [0; 500];
        assert_eq!(c::serialize_fmu_state::<Poor>(p, state, bytes.as_mut_ptr(), 500), ERROR);
        ready();
        let mut none = null_mut();
        assert_eq!(c::de_serialize_fmu_state::<Poor>(p, bytes.as_ptr(), 500, &mut none), ERROR);
        assert!(none.is_null());
        assert_eq!(c::free_fmu_state::<Poor>(p, &mut state), OK);
    }
    assert!(rig.take_lines().iter().all(|line| line.3.contains("not supported")));
}

/// A state can be set to a value for which an output is not finite: reading it is an error.
#[test]
fn a_value_that_is_not_finite_is_an_error() {
    let rig = Rig::in_state(State::Initialization);
    assert_eq!(rig.set(X1, f64::MAX), OK);
    assert_eq!(rig.set(U, 1e3), OK);
    let mut value = 7.0;
    assert_eq!(on!(rig, get_real(&DX1, 1, &mut value)), OK);
    let rig = Rig::in_state(State::Initialization);
    assert_eq!(rig.set(B, f64::MAX), OK);
    assert_eq!(rig.set(U, 1e3), OK);
    assert_eq!(on!(rig, get_real(&DX1, 1, &mut value)), ERROR);
    assert_ne!(value, f64::INFINITY);
    let rig = Rig::in_state(State::StepComplete);
    assert_eq!((rig.set(B, f64::MAX), rig.set(U, 1e3)), (OK, OK));
    let mut value = 7.0;
    assert_eq!(on!(rig, get_real_output_derivatives(&Y, 1, &1, &mut value)), ERROR);
    assert_eq!(value, 7.0);
}
