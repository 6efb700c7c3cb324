//! Examples loaded as by an importer.

use fmi2_export::{CoSimulationUnit, Resources};
use libloading::{Library, Symbol};
use std::ffi::{CString, c_char, c_void};
use std::path::PathBuf;
use std::ptr::null;

pub(super) type Component = *mut c_void;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    i32,
    *const c_char,
    *const c_char,
    *const c_void,
    i32,
    i32,
) -> Component;
type OfComponent = unsafe extern "C" fn(Component) -> i32;
type Setup = unsafe extern "C" fn(Component, i32, f64, f64, i32, f64) -> i32;
pub(super) type Free = unsafe extern "C" fn(Component);
pub(super) type DoStep = unsafe extern "C" fn(Component, f64, f64, i32) -> i32;
pub(super) type SetReal = unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> i32;
pub(super) type GetReal = unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> i32;

/// The library of an example. Cargo builds the examples with the tests, in the folder next to theirs.
pub(super) fn path(example: &str) -> PathBuf {
    let mut path = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let path = path.join("examples").join(libloading::library_filename(example));
    assert!(path.exists(), "first run `cargo build -p fmi2-export --example {example}`");
    path
}

pub(super) fn load(example: &str) -> Library {
    // SAFETY: our own library; it has no initializers.
    unsafe { Library::new(path(example)) }.unwrap()
}

pub(super) fn symbol<'l, T>(library: &'l Library, name: &str) -> Symbol<'l, T> {
    // SAFETY: the types are those of the standard.
    unsafe { library.get(name.as_bytes()) }.unwrap()
}

/// An instance after initialization mode.
pub(super) fn start<S: CoSimulationUnit>(library: &Library) -> Component {
    let guid = CString::new(fmi2_export::guid::<S>(&Resources::default())).unwrap();
    // SAFETY: valid strings, no callbacks, then a live instance.
    unsafe {
        let make = symbol::<Instantiate>(library, "fmi2Instantiate");
        let component = make(c"a".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        assert!(!component.is_null());
        assert_eq!(symbol::<Setup>(library, "fmi2SetupExperiment")(component, 0, 0., 0., 0, 0.), 0);
        for name in ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"] {
            assert_eq!(symbol::<OfComponent>(library, name)(component), 0);
        }
        component
    }
}
