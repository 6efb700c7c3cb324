//! States as variables: reading, setting and description.

use super::host::{ERROR, OK, STATES};
use super::plant::*;
use crate::calls::State;
use crate::describe;
use crate::resources::Resources;
use model_description::{Causality, DependencyKind as Kind, Initial, Unknown, Variability};

#[test]
fn read_and_set_by_state_of_the_machine() {
    for (reference, get, set) in
        [(X1, "MCTE", "IM"), (X2, "MCTE", ""), (DX1, "MCTE", ""), (DX2, "MCTE", "")]
    {
        for (state, letter) in STATES {
            let rig = Rig::in_state(state);
            let mut value = 7.0;
            // A legal access logs no debug line.
            assert_eq!(on!(rig, set_debug_logging(1, 0, std::ptr::null())), OK);
            let expected = |legal: &str| if legal.contains(letter) { OK } else { ERROR };
            let status = on!(rig, get_real(&reference, 1, &mut value));
            assert_eq!(status, expected(get), "reading {reference:x} in {letter}");
            assert_eq!(rig.take_lines().len(), usize::from(status == ERROR));
            let rig = Rig::in_state(state);
            assert_eq!(rig.set(reference, 3.0), expected(set), "setting {reference:x} in {letter}");
        }
    }
}

#[test]
fn the_simulation_starts_at_the_state_that_is_set() {
    let rig = Rig::in_state(State::Initialization);
    assert_eq!(rig.set(X1, 4.0), OK);
    assert_eq!(rig.set(Z0, 7.0), OK);
    assert_eq!((rig.real(X1), rig.real(X2), rig.real(Y)), (4.0, 7.0, 4.0));
    assert_eq!((rig.real(DX1), rig.real(DX2)), (-2.0, 4.0));
    assert_eq!(on!(rig, exit_initialization_mode()), OK);
    assert_eq!((rig.real(X1), rig.real(X2)), (4.0, 7.0));
    // Derivatives refer to the present input.
    assert_eq!(rig.set(U, 3.0), OK);
    assert_eq!(rig.real(DX1), 2.0 * 3.0 - 0.5 * 4.0);
    let before = rig.real(X1);
    let slope = rig.real(DX1);
    assert_eq!(on!(rig, do_step(0.0, 1e-6, 1)), OK);
    assert!(((rig.real(X1) - before) / 1e-6 - slope).abs() < 1e-5);
}

#[test]
fn a_rejected_call_changes_nothing() {
    for (references, value) in [
        ([X1, X1], f64::NAN),
        ([X1, X1], f64::INFINITY),
        // Variables without limits, none of them a state.
        ([B, B], f64::NAN),
        ([B, Z0], f64::INFINITY),
        ([B, Z0], f64::NEG_INFINITY),
        ([X1, DX1], 1.0),
        ([X1, X2], 1.0),
        ([X1, DX2 + 1], 1.0),
        ([X1, N], 1.0),
        ([U, u32::MAX], 1.0),
    ] {
        let rig = Rig::in_state(State::Initialization);
        let before = (*rig.instance().core.unit).clone();
        assert_eq!(on!(rig, set_real(references.as_ptr(), 2, [9.0, value].as_ptr())), ERROR);
        assert_eq!(*rig.instance().core.unit, before, "{references:x?} {value}");
        let lines = rig.take_lines();
        assert_eq!((lines.len(), lines[0].2.as_str()), (1, "logStatusError"), "{lines:?}");
    }
    // States are Real, and a failed read writes nothing.
    let rig = Rig::in_state(State::StepComplete);
    assert_eq!(on!(rig, get_integer(&X1, 1, &mut 0)), ERROR);
    assert!(rig.take_lines()[0].3.contains("`state[1]`"));
    let rig = Rig::in_state(State::StepComplete);
    let mut values = [0.5; 2];
    let references = [X1, DX2 + 1];
    assert_eq!(on!(rig, get_real(references.as_ptr(), 2, values.as_mut_ptr())), ERROR);
    assert_eq!(values, [0.5; 2]);
}

fn unknown(index: u32, dependencies: &[(u32, Kind)]) -> Unknown {
    let (list, kinds): (Vec<_>, Vec<_>) = dependencies.iter().copied().unzip();
    Unknown { index, dependencies: Some(list), kinds: (!kinds.is_empty()).then_some(kinds) }
}

/// Indices: u 1, a 2, b 3, z0 4, y 5, z 6, twice 7, held 8, n 9, gate 10, then state[1] 11,
/// der(state[1]) 12, state[2] 13, der(state[2]) 14.
#[test]
fn the_description() {
    let description = describe::<Plant>(&Resources::default(), None).unwrap();
    assert_eq!(description.findings(), []);
    let (d, f) = (Kind::Dependent, Kind::Fixed);
    assert_eq!(
        description.outputs,
        [unknown(5, &[(1, f), (11, f)]), unknown(6, &[(13, f)]), unknown(8, &[(10, d)])]
    );
    assert_eq!(description.derivatives, [unknown(12, &[(1, d), (11, d)]), unknown(14, &[(11, f)])]);
    assert_eq!(
        description.initial_unknowns,
        [
            unknown(5, &[(1, d), (11, d)]),
            unknown(6, &[(4, d)]),
            unknown(7, &[(4, d)]),
            unknown(8, &[(10, d)]),
            unknown(12, &[(1, d), (2, d), (3, d), (11, d)]),
            unknown(13, &[(4, d)]),
            unknown(14, &[(11, d)]),
        ]
    );
    let rows: Vec<_> = description.variables[10..]
        .iter()
        .map(|v| (v.name.as_str(), v.reference, v.initial, v.derivative, v.unit.as_deref()))
        .collect();
    let (exact, calculated) = (Some(Initial::Exact), Some(Initial::Calculated));
    assert_eq!(
        rows,
        [
            ("state[1]", 0x1000_0000, exact, None, Some("m/s")),
            ("der(state[1])", 0x1000_0001, calculated, Some(11), Some("m/s2")),
            ("state[2]", 0x1000_0002, calculated, None, Some("m")),
            ("der(state[2])", 0x1000_0003, calculated, Some(13), Some("m/s")),
        ]
    );
    for v in &description.variables[10..] {
        assert_eq!((v.causality, v.variability), (Causality::Local, Variability::Continuous));
        assert_eq!(v.start.is_some(), v.initial == exact);
    }
    assert_eq!(description.variable("state[1]").unwrap().start, Some(1.0.into()));
    let read = model_description::ModelDescription::from_xml(&description.to_xml()).unwrap();
    assert_eq!(read, description);
    let c = description.co_simulation.unwrap();
    assert!(c.can_serialize_fmu_state && c.can_get_and_set_fmu_state && c.can_interpolate_inputs);
    assert!(c.provides_directional_derivative && c.max_output_derivative_order == 1);
}

/// Exactly the flags of the unit's capabilities are set.
#[test]
fn the_flags_are_those_of_the_unit() {
    let c = describe::<Plant<None_>>(&Resources::default(), None).unwrap().co_simulation.unwrap();
    assert!(c.can_get_and_set_fmu_state && !c.can_serialize_fmu_state);
    assert!(!c.can_interpolate_inputs && !c.provides_directional_derivative);
    assert_eq!(c.max_output_derivative_order, 0);
}
