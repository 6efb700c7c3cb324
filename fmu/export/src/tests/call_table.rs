//! Every function in every state, compared with a second copy of table 4.2.4.

use super::host::{DISCARD, ERROR, FATAL, Host, OK, STATES, call};
use super::probe::{FAULT, GAIN, GRAVITY, GUESS, N, OFFSET, PANIC_IN_SET, SCALE, U, Y};
use crate::calls::{Call, State};

/// The standard's rows without the states that cannot be reached: I instantiated,
/// M initialization mode, C step complete, T terminated, E error.
const STANDARD: &str = "
fmi2GetTypesPlatform IMCTE
fmi2GetVersion IMCTE
fmi2SetDebugLogging IMCTE
fmi2Instantiate IMCTE
fmi2FreeInstance IMCTE
fmi2SetupExperiment I
fmi2EnterInitializationMode I
fmi2ExitInitializationMode M
fmi2Terminate C
fmi2Reset IMCTE
fmi2GetReal MCTE
fmi2GetInteger MCTE
fmi2GetBoolean MCTE
fmi2GetString MCTE
fmi2SetReal IMC
fmi2SetInteger IMC
fmi2SetBoolean IMC
fmi2SetString IMC
fmi2GetFMUstate IMCTE
fmi2SetFMUstate IMCTE
fmi2FreeFMUstate IMCTE
fmi2SerializedFMUstateSize IMCTE where supported
fmi2SerializeFMUstate IMCTE where supported
fmi2DeSerializeFMUstate IMCTE where supported
fmi2GetDirectionalDerivative MCTE where supported
fmi2SetRealInputDerivatives IMC where supported
fmi2GetRealOutputDerivatives CTE where supported
fmi2DoStep C
fmi2CancelStep unsupported
fmi2GetStatus CT
fmi2GetRealStatus CT
fmi2GetIntegerStatus CT
fmi2GetBooleanStatus CT
fmi2GetStringStatus CT";

#[test]
fn every_function_in_every_state() {
    let rows: Vec<(&str, &str)> =
        STANDARD.lines().filter_map(|line| line.split_once(' ')).collect();
    assert_eq!(rows.len(), 34);
    assert_eq!(Call::ALL.len(), 34);
    for &call in Call::ALL {
        let (_, legal) = rows.iter().find(|(name, _)| *name == call.name()).unwrap();
        for (state, letter) in STATES {
            let host = Host::in_state(state);
            let before = host.values();
            let status = host.make(call);
            let place = format!("{} in {letter}", call.name());
            let (legal, condition) = legal.split_once(' ').unwrap_or((legal, ""));
            let is_legal = legal.contains(letter) && legal != "unsupported";
            assert_eq!(call.is_legal_in(state), is_legal, "{place}");
            // This unit has no optional capabilities.
            if is_legal && condition.is_empty() {
                let discarded = matches!(
                    call,
                    Call::GetStatus | Call::GetIntegerStatus | Call::GetStringStatus
                );
                assert_eq!(status, if discarded { DISCARD } else { OK }, "{place}");
            } else {
                assert_eq!(status, ERROR, "{place}");
                assert_eq!(host.state(), State::Error, "{place}");
                let lines = host.take_lines();
                assert_eq!(lines.len(), 1, "{place}: {lines:?}");
                assert!(lines[0].3.starts_with(call.name()), "{lines:?}");
                assert_eq!(host.values(), before, "{place}");
            }
        }
    }
}

/// The six calls of optional capabilities, for a unit that has all of them.
#[test]
fn every_optional_function_in_every_state() {
    use super::plant::{self, Rig, on};
    use std::ptr::null_mut;
    for line in STANDARD.lines().filter_map(|line| line.strip_suffix(" where supported")) {
        let (name, legal) = line.split_once(' ').unwrap();
        for (state, letter) in STATES {
            let rig = Rig::in_state(state);
            let (mut saved, mut loaded, mut size, mut value) = (null_mut(), null_mut(), 0, 0.0);
            assert_eq!(on!(rig, get_fmu_state(&mut saved)), OK);
            assert_eq!(on!(rig, serialized_fmu_state_size(saved, &mut size)), OK);
            let mut bytes = vec![0; size];
            assert_eq!(on!(rig, serialize_fmu_state(saved, bytes.as_mut_ptr(), size)), OK);
            let status = match name {
                "fmi2SerializedFMUstateSize" => {
                    on!(rig, serialized_fmu_state_size(saved, &mut size))
                }
                "fmi2SerializeFMUstate" => {
                    on!(rig, serialize_fmu_state(saved, bytes.as_mut_ptr(), size))
                }
                "fmi2DeSerializeFMUstate" => {
                    on!(rig, de_serialize_fmu_state(bytes.as_ptr(), size, &mut loaded))
                }
                "fmi2GetDirectionalDerivative" => {
                    let (y, u) = (plant::Y, plant::U);
                    on!(rig, get_directional_derivative(&y, 1, &u, 1, &1.0, &mut value))
                }
                "fmi2SetRealInputDerivatives" => {
                    on!(rig, set_real_input_derivatives(&plant::U, 1, &1, &1.0))
                }
                _ => on!(rig, get_real_output_derivatives(&plant::Y, 1, &1, &mut value)),
            };
            let expected = if legal.contains(letter) { OK } else { ERROR };
            assert_eq!(status, expected, "{name} in {letter}");
            assert_eq!(rig.take_lines().len(), usize::from(expected == ERROR));
            for mut state in [saved, loaded] {
                assert_eq!(on!(rig, free_fmu_state(&mut state)), OK);
            }
        }
    }
}

#[test]
fn after_a_panic_only_freeing_is_legal() {
    for &call in Call::ALL {
        let host = Host::in_state(State::Fatal);
        let free =
            ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate", "fmi2FreeInstance"];
        let expected = if free.contains(&call.name()) { OK } else { FATAL };
        assert_eq!(host.make(call), expected, "{}", call.name());
    }
}

/// The states in which each variable may be set: "I" only instantiated, and so on.
#[test]
fn setting_by_variable() {
    let rows = [
        (U, "iMC"),
        (GAIN, "IMC"),
        (OFFSET, "IM"),
        (Y, ""),
        (SCALE, ""),
        (GRAVITY, ""),
        (GUESS, "I"),
    ];
    for (reference, states) in rows {
        for (state, letter) in STATES {
            let host = Host::in_state(state);
            call!(host, set_debug_logging(1, 0, std::ptr::null()));
            let status = host.set_real(reference, 1.5);
            let lines = host.take_lines();
            let place = format!("value reference {reference} in {letter}");
            if states.contains(letter) {
                assert_eq!((status, lines.len()), (OK, 0), "{place}: {lines:?}");
            } else if states.contains(letter.to_ascii_lowercase()) {
                // An accepted deviation from the standard: one debug line in total.
                assert_eq!(status, OK, "{place}");
                assert_eq!(host.set_real(reference, 1.6), OK);
                assert_eq!((lines.len(), host.take_lines().len()), (1, 0), "{place}: {lines:?}");
                assert_eq!((lines[0].1, lines[0].2.as_str()), (OK, "logEvents"));
            } else {
                assert_eq!((status, lines.len()), (ERROR, 1), "{place}: {lines:?}");
            }
        }
    }
}

#[test]
fn reading_anything_in_initialization_mode_is_accepted_and_noted() {
    let host = Host::in_state(State::Initialization);
    call!(host, set_debug_logging(1, 0, std::ptr::null()));
    assert_eq!(host.real(Y), 0.0);
    assert_eq!(host.take_lines(), []);
    assert_eq!(host.real(GAIN), 2.0);
    assert_eq!(host.integer(N), 0);
    assert_eq!(host.take_lines().len(), 1);
}

#[test]
fn values_set_at_a_communication_point_are_read_before_the_first_step() {
    let host = Host::in_state(State::StepComplete);
    assert_eq!(host.set_real(U, 3.0), OK);
    assert_eq!(host.real(U), 3.0);
}

#[test]
fn initialization_needs_an_experiment() {
    let host = Host::new(false);
    assert_eq!(call!(host, enter_initialization_mode()), ERROR);
    assert_eq!(host.state(), State::Error);
}

#[test]
fn reset_restores_a_new_instance() {
    let host = Host::in_state(State::StepComplete);
    let fresh = Host::new(false).values();
    assert_eq!(host.set_real(U, 20.0), super::host::WARNING);
    assert_eq!(host.do_step(0.0, 1.0), OK);
    assert_ne!(host.values(), fresh);
    assert_eq!(call!(host, reset()), OK);
    assert_eq!(host.values(), fresh);
    assert_eq!(host.state(), State::Instantiated);
    // The experiment is cleared too, and warnings are logged again.
    assert_eq!(host.set_real(U, 20.0), super::host::WARNING);
    assert_eq!(call!(host, enter_initialization_mode()), ERROR);
    // A reset recovers from an error, but not from a panic.
    assert_eq!(call!(host, reset()), OK);
    assert_eq!(host.set_integer(FAULT, PANIC_IN_SET), FATAL);
    assert_eq!(call!(host, reset()), FATAL);
}
