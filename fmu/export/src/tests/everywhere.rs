//! Panics in any function of a unit, including `clone` and `drop`, with payloads whose destructors
//! panic too: no panic crosses the boundary, and other instances continue.

mod panicking;

use super::host::{FATAL, Line, Lines, OK, callbacks};
use crate::boundary as c;
use panicking::{ALIVE, AT, At, DROPS, Panicking, TABLE, arm};
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

struct Field {
    component: *mut c_void,
    state: *mut c_void,
    bytes: Vec<u8>,
    lines: Box<Lines>,
}

/// Calls a function of the boundary on that instance.
macro_rules! on {
    ($field:expr, $function:ident($($argument:expr),*)) => {{
        let component = $field.component;
        // SAFETY: a live instance of the unit above, good arguments.
        unsafe { c::$function::<Panicking>(component, $($argument),*) }
    }};
}

const STATE: u32 = crate::state_reference(0);
const SLOPE: u32 = crate::derivative_reference(0);

impl Field {
    fn instantiate() -> Self {
        let lines = Box::new(Lines::default());
        let callbacks = callbacks(&lines);
        let guid = CString::new(model_description::guid(&TABLE, &[])).unwrap();
        // SAFETY: valid strings and callbacks.
        let component = unsafe {
            c::instantiate::<Panicking>(
                c"panicking".as_ptr(),
                1,
                guid.as_ptr(),
                null(),
                &callbacks,
                0,
                0,
            )
        };
        Self { component, state: null_mut(), bytes: Vec::new(), lines }
    }

    /// In initialization mode or at a communication point, with a state and its bytes.
    fn new(initialized: bool) -> Self {
        let mut field = Self::instantiate();
        assert!(!field.component.is_null());
        assert_eq!(on!(field, setup_experiment(0, 0.0, 0.0, 0, 0.0)), OK);
        assert_eq!(on!(field, enter_initialization_mode()), OK);
        if initialized {
            assert_eq!(on!(field, exit_initialization_mode()), OK);
        }
        let (mut state, mut size) = (null_mut(), 0);
        assert_eq!(on!(field, get_fmu_state(&mut state)), OK);
        assert_eq!(on!(field, serialized_fmu_state_size(state, &mut size)), OK);
        let mut bytes = vec![0; size];
        assert_eq!(on!(field, serialize_fmu_state(state, bytes.as_mut_ptr().cast(), size)), OK);
        (field.state, field.bytes) = (state, bytes);
        field
    }

    fn lines(&self) -> Vec<Line> {
        self.lines.take()
    }

    /// Frees the instance and its state, by another instance, since this one may be unusable.
    fn free(mut self) {
        // SAFETY: created above, freed once.
        unsafe { c::free_instance::<Panicking>(self.component) };
        if !self.state.is_null() {
            AT.set(At::Nowhere);
            let dropping = DROPS.replace(false);
            let other = Self::instantiate();
            DROPS.set(dropping);
            let status = on!(other, free_fmu_state(&mut self.state));
            assert_eq!(status, if dropping { FATAL } else { OK });
            assert!(self.state.is_null());
            // SAFETY: created above, freed once.
            unsafe { c::free_instance::<Panicking>(other.component) };
        }
    }
}

type Export = (&'static str, fn(&mut Field) -> i32);

/// Every export that reaches the unit, at a communication point or, the second list, in
/// initialization mode; with the functions that each calls.
const LATER: &[(Export, &[At])] = &[
    (("fmi2Reset", |f| on!(f, reset())), &[At::Clone, At::Drop]),
    (("fmi2GetReal", |f| on!(f, get_real(&1, 1, &mut 0.0))), &[At::Reference, At::Get]),
    (("fmi2GetReal", |f| on!(f, get_real(&STATE, 1, &mut 0.0))), &[At::Reference, At::State]),
    (("fmi2GetReal", |f| on!(f, get_real(&SLOPE, 1, &mut 0.0))), &[At::StateDerivative]),
    (("fmi2GetInteger", |f| on!(f, get_integer(&2, 1, &mut 0))), &[At::Reference, At::Get]),
    (("fmi2GetBoolean", |f| on!(f, get_boolean(&3, 1, &mut 0))), &[At::Reference, At::Get]),
    (("fmi2GetString", |f| on!(f, get_string(&4, 1, &mut null()))), &[At::Reference, At::Get]),
    (("fmi2SetReal", |f| on!(f, set_real(&0, 1, &0.0))), &[At::Reference, At::Set]),
    (("fmi2SetInteger", |f| on!(f, set_integer(&2, 1, &0))), &[At::Reference, At::Set]),
    (("fmi2SetBoolean", |f| on!(f, set_boolean(&3, 1, &0))), &[At::Reference, At::Set]),
    (("fmi2SetString", |f| on!(f, set_string(&4, 1, &c"".as_ptr()))), &[At::Reference, At::Set]),
    (("fmi2GetFMUstate", |f| on!(f, get_fmu_state(&mut null_mut()))), &[At::Clone]),
    (("fmi2GetFMUstate", |f| on!(f, get_fmu_state(&mut f.state))), &[At::Clone, At::Drop]),
    (("fmi2SetFMUstate", |f| on!(f, set_fmu_state(f.state))), &[At::Clone, At::Drop]),
    (("fmi2FreeFMUstate", |f| on!(f, free_fmu_state(&mut f.state))), &[At::Drop]),
    (
        ("fmi2SerializedFMUstateSize", |f| on!(f, serialized_fmu_state_size(f.state, &mut 0))),
        &[At::Save],
    ),
    (
        ("fmi2SerializeFMUstate", |f| {
            let (bytes, size) = (f.bytes.as_mut_ptr().cast(), f.bytes.len());
            on!(f, serialize_fmu_state(f.state, bytes, size))
        }),
        &[At::Save],
    ),
    (
        ("fmi2DeSerializeFMUstate", |f| {
            let mut state = null_mut();
            let (bytes, size) = (f.bytes.as_ptr().cast(), f.bytes.len());
            let status = on!(f, de_serialize_fmu_state(bytes, size, &mut state));
            assert!(state.is_null());
            status
        }),
        &[At::Clone, At::Load],
    ),
    (
        ("fmi2GetDirectionalDerivative", |f| {
            on!(f, get_directional_derivative(&1, 1, &0, 1, &1.0, &mut 0.0))
        }),
        &[
            At::Reference,
            At::Dependency,
            At::PartialDerivative,
            At::Clone,
            At::Get,
            At::Set,
            At::Drop,
        ],
    ),
    (
        ("fmi2GetDirectionalDerivative", |f| {
            on!(f, get_directional_derivative(&SLOPE, 1, &STATE, 1, &1.0, &mut 0.0))
        }),
        &[At::State, At::SetState, At::StateDerivative, At::Drop],
    ),
    (
        ("fmi2SetRealInputDerivatives", |f| on!(f, set_real_input_derivatives(&0, 1, &1, &1.0))),
        &[At::Reference, At::SetInputDerivative],
    ),
    (
        ("fmi2GetRealOutputDerivatives", |f| {
            on!(f, get_real_output_derivatives(&1, 1, &1, &mut 0.0))
        }),
        &[At::Reference, At::OutputDerivative],
    ),
    (("fmi2DoStep", |f| on!(f, do_step(0.0, 0.1, 1))), &[At::Step]),
];
const INITIALLY: &[(Export, &[At])] = &[
    (("fmi2ExitInitializationMode", |f| on!(f, exit_initialization_mode())), &[At::Exit]),
    (("fmi2SetReal", |f| on!(f, set_real(&STATE, 1, &0.0))), &[At::Reference, At::SetState]),
];

#[test]
fn every_export_contains_every_panic() {
    let bystander = Field::new(true);
    for (initialized, exports) in [(true, LATER), (false, INITIALLY)] {
        for ((name, export), places) in exports {
            for &place in *places {
                // Without and with destructors that panic while others unwind.
                for drops in [false, true] {
                    let mut field = Field::new(initialized);
                    arm(place, drops);
                    let status = export(&mut field);
                    assert_eq!(status, FATAL, "{name} {place:?} {drops}");
                    let lines = field.lines();
                    assert_eq!(lines.len(), 1, "{name} {place:?}: {lines:?}");
                    assert_eq!((lines[0].1, lines[0].2.as_str()), (FATAL, "logStatusFatal"));
                    assert!(lines[0].3.starts_with(&format!("{name}: ")), "{lines:?}");
                    assert_eq!(on!(field, do_step(0.0, 0.1, 1)), FATAL);
                    assert_eq!(field.lines(), []);
                    field.free();
                    arm(At::Nowhere, false);
                }
            }
        }
    }
    assert_eq!(on!(bystander, do_step(0.0, 0.1, 1)), OK);
    bystander.free();
    assert_eq!(ALIVE.get(), 0, "every unit was dropped once");
}

#[test]
fn instantiation_contains_every_panic() {
    for place in [At::Open, At::States, At::Clone] {
        for drops in [false, true] {
            arm(place, drops);
            let field = Field::instantiate();
            assert!(field.component.is_null(), "{place:?}");
            let lines = field.lines();
            assert_eq!((lines.len(), lines[0].1), (1, FATAL), "{place:?} {lines:?}");
            arm(At::Nowhere, false);
        }
    }
    assert_eq!(ALIVE.get(), 0);
}

/// Freeing it: two units in one instance, both of which panic when they are dropped.
#[test]
fn freeing_contains_every_panic() {
    for place in [At::Drop, At::Nowhere] {
        let field = Field::new(true);
        arm(place, place == At::Nowhere);
        field.free();
        arm(At::Nowhere, false);
    }
    assert_eq!(ALIVE.get(), 0);
}
