//! The binary of the test corpus, an integrator x' = u with y = (gain·x, x + u): the C functions of
//! FMI 2.0 for co-simulation, written without any of the project's code. The GUID selects a fault
//! ("base-crash" and so on). Built with `rustc`, without the standard library.
#![no_std]

mod states;
mod variables;

use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr::null_mut;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

type Status = c_int;
type Logger = unsafe extern "C" fn(
    *mut c_void,
    *const c_char,
    Status,
    *const c_char,
    *const c_char,
    *const c_char,
);
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;

#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate: *const c_void,
    free: *const c_void,
    finished: *const c_void,
    environment: *mut c_void,
}

#[derive(Clone, Copy)]
struct State {
    time: f64,
    u: f64,
    gain: f64,
    x: f64,
    integers: [c_int; 2],
    label: [u8; 32],
    steps: usize,
}

const FRESH: State = State {
    time: 0.0,
    u: 0.0,
    gain: 1.0,
    x: 0.0,
    integers: [1, 3],
    label: [b'a', 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    steps: 0,
};

struct Instance {
    used: bool,
    state: State,
    fault: [u8; 32],
}

impl Instance {
    fn has(&self, fault: &str) -> bool {
        let end = self.fault.iter().position(|b| *b == 0).unwrap_or(32);
        &self.fault[..end] == fault.as_bytes()
    }
}

const FREE: Instance = Instance { used: false, state: FRESH, fault: [0; 32] };
static mut INSTANCES: [Instance; 8] = [FREE; 8];
/// The fault of the latest instantiation, for functions without an instance.
static mut NULL_CRASHES: bool = false;

fn instance<'a>(component: *mut c_void) -> &'a mut Instance {
    // SAFETY: importers pass a pointer of `fmi2Instantiate`, one thread at a time.
    unsafe { &mut *component.cast::<Instance>() }
}

fn crash() -> ! {
    // SAFETY: none; this is the fault.
    unsafe {
        core::ptr::without_provenance_mut::<u32>(8).write_volatile(1);
    }
    loop {}
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetDebugLogging(_: *mut c_void, _: c_int, _: usize, _: *const *const c_char) -> Status {
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _: c_int,
    _: c_int,
) -> *mut c_void {
    // SAFETY: the standard's contract with importers.
    unsafe {
        let callbacks = &*callbacks;
        let guid = CStr::from_ptr(guid).to_bytes();
        let log = |category: &CStr, message: &CStr| {
            if let Some(logger) = callbacks.logger {
                let (c, m) = (category.as_ptr(), message.as_ptr());
                logger(callbacks.environment, name, ERROR, c, c"%s".as_ptr(), m);
            }
        };
        let fault = match guid.strip_prefix(b"base") {
            Some(rest) => rest.strip_prefix(b"-").unwrap_or(rest),
            None if NULL_CRASHES => b"",
            None => {
                log(c"logStatusError", c"the GUID differs");
                return null_mut();
            }
        };
        if fault == b"path" {
            if let Some(logger) = callbacks.logger {
                logger(callbacks.environment, name, ERROR, c"logAll".as_ptr(), c"%s".as_ptr(), resources);
            }
            return null_mut();
        }
        if kind != 1 || fault == b"refuse" {
            return null_mut();
        }
        if fault == b"log" {
            log(c"logSomething", c"a category that is not declared");
        }
        // "any-guid" is stored, since the wrong GUID of the next call selects no fault.
        NULL_CRASHES = fault == b"any-guid";
        let instances = &raw mut INSTANCES;
        for slot in &mut *instances {
            if !slot.used {
                *slot = Instance { used: true, ..FREE };
                let length = fault.len().min(32);
                slot.fault[..length].copy_from_slice(&fault[..length]);
                if slot.has("gain") {
                    slot.state.gain = 2.0;
                }
                if slot.has("null") {
                    FREE_CRASHES = true;
                }
                return (slot as *mut Instance).cast();
            }
        }
    }
    null_mut()
}

static mut FREE_CRASHES: bool = false;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    if c.is_null() {
        // SAFETY: one thread at a time.
        if unsafe { FREE_CRASHES } {
            crash();
        }
        return;
    }
    instance(c).used = false;
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetupExperiment(c: *mut c_void, _: c_int, _: f64, start: f64, _: c_int, _: f64) -> Status {
    instance(c).state.time = start;
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2EnterInitializationMode(_: *mut c_void) -> Status {
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> Status {
    if instance(c).has("initialization") { ERROR } else { OK }
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2Terminate(_: *mut c_void) -> Status {
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2Reset(c: *mut c_void) -> Status {
    let i = instance(c);
    let x = i.state.x;
    i.state = FRESH;
    if i.has("gain") {
        i.state.gain = 2.0;
    }
    if i.has("reset") {
        i.state.x = x;
    }
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2DoStep(c: *mut c_void, time: f64, step: f64, _: c_int) -> Status {
    let i = instance(c);
    if i.has("crash") {
        crash();
    }
    if i.has("late") && time >= 6.0 {
        crash();
    }
    if i.has("hang-late") && time >= 6.0 {
        loop {}
    }
    if i.has("error-late") && time >= 6.0 {
        return ERROR;
    }
    if i.has("hang") {
        loop {}
    }
    if i.has("step") && i.state.steps > 3 {
        return ERROR;
    }
    if i.has("step-size") && step != 0.125 {
        return ERROR;
    }
    #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
    if i.has("output") && i.state.steps == 0 {
        let text = b"hello\n";
        // SAFETY: write(1, text, length).
        unsafe {
            core::arch::asm!("syscall", inlateout("rax") 1_usize => _, in("rdi") 1, in("rsi") text.as_ptr(),
                in("rdx") text.len(), out("rcx") _, out("r11") _);
        }
    }
    if i.has("discard") && i.state.steps > 2 {
        return DISCARD;
    }
    i.state.x += step * i.state.u;
    i.state.time = time + step;
    i.state.steps += 1;
    OK
}

/// Functions of capabilities that the FMU does not support.
macro_rules! absent {
    ($($name:ident),*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> Status {
            ERROR
        }
    )*};
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: *mut c_void,
    unknown: *const u32,
    unknowns: usize,
    known: *const u32,
    knowns: usize,
    change: *const f64,
    value: *mut f64,
) -> Status {
    let gain = instance(c).state.gain;
    let is_wrong = instance(c).has("derivative");
    for k in 0..unknowns {
        let mut sum = 0.0;
        for l in 0..knowns {
            // SAFETY: arrays of these lengths.
            let (u, v, d) = unsafe { (*unknown.add(k), *known.add(l), *change.add(l)) };
            sum += d * match (u, v) {
                (5, 2) if is_wrong => f64::NAN,
                (2, 2) | (3, 0) | (5, 0) | (5, 2) => 1.0,
                (4, 2) => gain,
                _ => 0.0,
            };
        }
        // SAFETY: as above.
        unsafe { *value.add(k) = sum };
    }
    OK
}

absent!(
    fmi2SetRealInputDerivatives,
    fmi2GetRealOutputDerivatives,
    fmi2CancelStep,
    fmi2GetStatus,
    fmi2GetRealStatus,
    fmi2GetIntegerStatus,
    fmi2GetBooleanStatus,
    fmi2GetStringStatus
);
