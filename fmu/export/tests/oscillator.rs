//! The example with all optional capabilities, loaded as by an importer: a state that is restored after
//! the library was unloaded, and the matrices A, B, C, D from directional derivatives.
#![allow(clippy::unwrap_used)] // helpers of tests are not seen as tests

mod common;

use common::{Component, DoStep, Free, GetReal, SetReal, load, start, symbol};
use fmi2_export::{Resources, derivative_reference, describe, state_reference};
use libloading::{Library, Symbol};
use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::ptr::null_mut;

#[path = "../examples/oscillator.rs"]
mod oscillator;
use oscillator::Oscillator;

type Derivatives =
    unsafe extern "C" fn(Component, *const u32, usize, *const i32, *const f64) -> i32;
type Directional = unsafe extern "C" fn(
    Component,
    *const u32,
    usize,
    *const u32,
    usize,
    *const f64,
    *mut f64,
) -> i32;
type GetState = unsafe extern "C" fn(Component, *mut *mut c_void) -> i32;
type SetState = unsafe extern "C" fn(Component, *mut c_void) -> i32;
type Size = unsafe extern "C" fn(Component, *mut c_void, *mut usize) -> i32;
type Serialize = unsafe extern "C" fn(Component, *mut c_void, *mut c_char, usize) -> i32;
type DeSerialize = unsafe extern "C" fn(Component, *const c_char, usize, *mut *mut c_void) -> i32;

const FORCE: u32 = 0;
const MASS: u32 = 1;
const POSITION: u32 = 3;

/// The library and one instance of it, freed and unloaded together.
struct Unit {
    library: Library,
    component: Component,
}

impl Unit {
    /// Loads the library and initializes an instance.
    fn load() -> Self {
        let library = load("oscillator");
        let component = start::<Oscillator>(&library);
        Self { library, component }
    }

    fn symbol<T>(&self, name: &str) -> Symbol<'_, T> {
        symbol(&self.library, name)
    }

    fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: a live instance, good arguments.
        let status = unsafe {
            self.symbol::<GetReal>("fmi2GetReal")(self.component, &reference, 1, &mut value)
        };
        assert_eq!(status, 0);
        value
    }

    fn step(&self, time: f64, step: f64) {
        let do_step = self.symbol::<DoStep>("fmi2DoStep");
        // SAFETY: a live instance.
        let status = unsafe { do_step(self.component, time, step, 1) };
        assert_eq!(status, 0);
    }

    /// Steps with a force and its derivative; returns the bits of both states after each step.
    fn run(&self, from: i32, count: i32) -> Vec<[u64; 2]> {
        let set = self.symbol::<SetReal>("fmi2SetReal");
        let grow = self.symbol::<Derivatives>("fmi2SetRealInputDerivatives");
        (from..from + count)
            .map(|k| {
                let time = f64::from(k) * 0.1;
                // SAFETY: a live instance, good arguments.
                unsafe {
                    assert_eq!(set(self.component, &FORCE, 1, &time.sin()), 0);
                    assert_eq!(grow(self.component, &FORCE, 1, &1, &time.cos()), 0);
                }
                self.step(time, 0.1);
                [0, 1].map(|state| self.get(state_reference(state)).to_bits())
            })
            .collect()
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        let free = self.symbol::<Free>("fmi2FreeInstance");
        // SAFETY: created by `load`, freed once.
        unsafe { free(self.component) };
    }
}

#[test]
fn a_state_outlives_the_library() {
    let (bytes, expected) = {
        let unit = Unit::load();
        unit.run(0, 20);
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: a live instance, good arguments.
        let bytes = unsafe {
            let p = unit.component;
            assert_eq!(unit.symbol::<GetState>("fmi2GetFMUstate")(p, &mut state), 0);
            assert_eq!(unit.symbol::<Size>("fmi2SerializedFMUstateSize")(p, state, &mut size), 0);
            let mut bytes = vec![0_u8; size];
            let serialize = unit.symbol::<Serialize>("fmi2SerializeFMUstate");
            assert_eq!(serialize(p, state, bytes.as_mut_ptr().cast(), size), 0);
            assert_eq!(unit.symbol::<GetState>("fmi2FreeFMUstate")(p, &mut state), 0);
            bytes
        };
        (bytes, unit.run(20, 20))
    };
    let unit = Unit::load();
    let mut state = null_mut();
    // SAFETY: a live instance, good arguments.
    unsafe {
        let p = unit.component;
        let load = unit.symbol::<DeSerialize>("fmi2DeSerializeFMUstate");
        assert_eq!(load(p, bytes.as_ptr().cast(), bytes.len(), &mut state), 0);
        assert_eq!(unit.symbol::<SetState>("fmi2SetFMUstate")(p, state), 0);
        assert_eq!(unit.symbol::<GetState>("fmi2FreeFMUstate")(p, &mut state), 0);
    }
    assert_eq!(unit.run(20, 20), expected);
}

/// With m = 1 and k = 4: A = [0 1; -4 0], B = [0; 1], C = [1 0], D = 0.
#[test]
fn the_linear_model_can_be_read() {
    let unit = Unit::load();
    unit.run(0, 7);
    let unknowns = [derivative_reference(0), derivative_reference(1), POSITION];
    let partial = unit.symbol::<Directional>("fmi2GetDirectionalDerivative");
    for (known, column) in [
        (state_reference(0), [0.0, -4.0, 1.0]),
        (state_reference(1), [1.0, 0.0, 0.0]),
        (FORCE, [0.0, 1.0, 0.0]),
    ] {
        let mut got = [f64::NAN; 3];
        // SAFETY: a live instance, good arguments.
        let status = unsafe {
            let (r, v) = (unknowns.as_ptr(), got.as_mut_ptr());
            partial(unit.component, r, 3, &known, 1, &1.0, v)
        };
        assert_eq!(status, 0);
        for (got, need) in got.iter().zip(column) {
            assert!((got - need).abs() < 1e-8, "{known:x}: {got} instead of {need}");
        }
    }
    // A parameter is not a known at a communication point.
    // SAFETY: as above.
    let status = unsafe { partial(unit.component, &POSITION, 1, &MASS, 1, &1.0, &mut 0.0) };
    assert_eq!(status, 3);
}

/// A step with a force that is linear in time is exact: one step of 0.5 s compared with the solution
/// for `F = t`, `x = t/4 − sin(2 t)/8 + cos(2 t)`.
#[test]
fn a_step_with_a_linear_force_is_exact() {
    let unit = Unit::load();
    let grow = unit.symbol::<Derivatives>("fmi2SetRealInputDerivatives");
    // SAFETY: a live instance, good arguments.
    assert_eq!(unsafe { grow(unit.component, &FORCE, 1, &1, &1.0) }, 0);
    unit.step(0.0, 0.5);
    let exact = 0.5 / 4.0 - 1.0_f64.sin() / 8.0 + 1.0_f64.cos();
    assert!((unit.get(POSITION) - exact).abs() < 1e-15);
}

/// The description is written next to the tests, to try importers by hand.
#[test]
fn its_description_has_no_faults() {
    let description = describe::<Oscillator>(&Resources::default(), None).unwrap();
    assert_eq!(description.findings(), []);
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("Oscillator.xml");
    std::fs::write(path, description.to_xml()).unwrap();
}
