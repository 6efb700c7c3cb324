//! Reading and setting variables.

use super::{ERROR, Instance, OK, Status, instance};
use core::ffi::{CStr, c_char, c_int, c_void};

/// For the fault "chance": the number of readings.
static mut READINGS: usize = 0;
/// For the fault "global": the input of the instance that was set last.
static mut GLOBAL: f64 = 0.0;

/// Declares a getter and a setter of one type.
macro_rules! access {
    ($get:ident, $set:ident, $kind:ty, $read:expr, $write:expr) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(c: *mut c_void, r: *const u32, n: usize, v: *mut $kind) -> Status {
            for k in 0..n {
                // SAFETY: arrays of n.
                match unsafe { $read(&*instance(c), *r.add(k)) } {
                    Some(value) => unsafe { *v.add(k) = value },
                    None => return ERROR,
                }
            }
            OK
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(c: *mut c_void, r: *const u32, n: usize, v: *const $kind) -> Status {
            for k in 0..n {
                // SAFETY: arrays of n.
                if !unsafe { $write(instance(c), *r.add(k), *v.add(k)) } {
                    return ERROR;
                }
            }
            OK
        }
    };
}

fn read_real(i: &Instance, reference: u32) -> Option<f64> {
    let s = &i.state;
    Some(match reference {
        0 => s.u,
        1 if i.has("start") => 2.0,
        1 if i.has("rounded") => s.gain * 1.000_000_1,
        1 => s.gain,
        // SAFETY: one thread at a time.
        2 if i.has("chance") && s.steps > 0 => unsafe {
            READINGS += 1;
            READINGS as f64
        },
        // SAFETY: as above.
        5 if i.has("global") => s.x + unsafe { GLOBAL },
        4 if i.has("dependency") && s.steps > 0 => s.gain * s.x + s.u,
        2 if i.has("nan") && s.steps > 2 => f64::NAN,
        4 if i.has("nan-late") && s.time >= 6.0 => f64::NAN,
        2 => s.x,
        3 => s.u,
        4 => s.gain * s.x,
        5 => s.x + s.u,
        6 => s.time,
        _ => return None,
    })
}

fn write_real(i: &mut Instance, reference: u32, value: f64) -> bool {
    match reference {
        0 => {
            i.state.u = value;
            // SAFETY: one thread at a time.
            unsafe { GLOBAL = value };
        }
        1 => i.state.gain = value,
        2 => i.state.x = value,
        _ => return false,
    }
    true
}

fn read_integer(i: &Instance, reference: u32) -> Option<c_int> {
    i.state.integers.get(reference as usize).copied()
}

fn write_integer(i: &mut Instance, reference: u32, value: c_int) -> bool {
    i.state.integers.get_mut(reference as usize).map(|place| *place = value).is_some()
}

fn read_boolean(i: &Instance, reference: u32) -> Option<c_int> {
    (reference == 0).then_some(c_int::from(i.state.u != 0.0))
}

fn write_boolean(_: &mut Instance, _: u32, _: c_int) -> bool {
    false
}

fn read_string(i: &Instance, reference: u32) -> Option<*const c_char> {
    (reference == 0).then_some(i.state.label.as_ptr().cast())
}

fn write_string(i: &mut Instance, reference: u32, value: *const c_char) -> bool {
    // SAFETY: a C string.
    let text = unsafe { CStr::from_ptr(value) }.to_bytes();
    if reference != 0 || text.len() >= 32 {
        return false;
    }
    i.state.label = [0; 32];
    i.state.label[..text.len()].copy_from_slice(text);
    true
}

access!(fmi2GetReal, fmi2SetReal, f64, read_real, write_real);
access!(fmi2GetInteger, fmi2SetInteger, c_int, read_integer, write_integer);
access!(fmi2GetBoolean, fmi2SetBoolean, c_int, read_boolean, write_boolean);
access!(fmi2GetString, fmi2SetString, *const c_char, read_string, write_string);
