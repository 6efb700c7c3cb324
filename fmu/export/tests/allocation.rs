//! The layer's allocations: none during steps, and all memory is freed.
#![allow(clippy::unwrap_used)] // helpers of tests are not seen as tests

use fmi2_export::{Resources, boundary as c};
use integrator::Integrator;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};

#[path = "../examples/integrator.rs"]
mod integrator;

thread_local! {
    /// Number of allocations of this thread, and bytes that it has not freed.
    static COUNT: Cell<(u64, isize)> = const { Cell::new((0, 0)) };
}

struct Counting;

fn count(allocations: u64, bytes: isize) {
    let (made, live) = COUNT.get();
    COUNT.set((made + allocations, live + bytes));
}

// SAFETY: the system's allocator and a counter that does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(1, layout.size() as isize);
        // SAFETY: the caller's contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(0, -(layout.size() as isize));
        // SAFETY: the caller's contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn instantiate(guid: &CStr) -> *mut c_void {
    // SAFETY: valid strings, no callbacks.
    unsafe {
        let component =
            c::instantiate::<Integrator>(c"a".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        assert!(!component.is_null());
        assert_eq!(c::setup_experiment::<Integrator>(component, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(c::enter_initialization_mode::<Integrator>(component), 0);
        assert_eq!(c::exit_initialization_mode::<Integrator>(component), 0);
        component
    }
}

fn guid() -> CString {
    CString::new(fmi2_export::guid::<Integrator>(&Resources::default())).unwrap()
}

#[test]
fn stepping_allocates_nothing() {
    let component = instantiate(&guid());
    let (before, _) = COUNT.get();
    let (mut time, mut y) = (0.0, 0.0);
    for _ in 0..1000 {
        // SAFETY: a live instance, good arguments.
        unsafe {
            assert_eq!(c::set_real::<Integrator>(component, &0, 1, &1.0), 0);
            assert_eq!(c::do_step::<Integrator>(component, time, 0.01, 1), 0);
            assert_eq!(c::get_real::<Integrator>(component, &2, 1, &mut y), 0);
        }
        time += 0.01;
    }
    assert_eq!(COUNT.get().0, before);
    // SAFETY: made above.
    unsafe { c::free_instance::<Integrator>(component) };
}

#[test]
fn every_byte_is_freed() {
    let guid = guid();
    let cycle = || {
        let component = instantiate(&guid);
        let mut state = null_mut();
        // SAFETY: a live instance, good arguments; the second step panics.
        unsafe {
            assert_eq!(c::get_fmu_state::<Integrator>(component, &mut state), 0);
            assert_eq!(c::free_fmu_state::<Integrator>(component, &mut state), 0);
            assert_eq!(c::do_step::<Integrator>(component, 0.0, -1.0, 1), 3);
            assert_eq!(c::reset::<Integrator>(component), 0);
            assert_eq!(c::set_real::<Integrator>(component, &0, 1, &2e6), 0);
            assert_eq!(c::setup_experiment::<Integrator>(component, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(c::enter_initialization_mode::<Integrator>(component), 0);
            assert_eq!(c::exit_initialization_mode::<Integrator>(component), 0);
            assert_eq!(c::do_step::<Integrator>(component, 0.0, 1.0, 1), 4);
            c::free_instance::<Integrator>(component);
            assert!(
                c::instantiate::<Integrator>(
                    c"a".as_ptr(),
                    1,
                    c"wrong".as_ptr(),
                    null(),
                    null(),
                    0,
                    0
                )
                .is_null()
            );
        }
    };
    // From the first cycle on, since the library may be unloaded after it.
    let (_, live) = COUNT.get();
    (0..1000).for_each(|_| cycle());
    assert_eq!(COUNT.get().1, live);
}
