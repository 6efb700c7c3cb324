//! The binary of the test corpus, an integrator x' = u with y = (gain·x, x + u): the C functions of
//! FMI 2.0 for co-simulation, written without any of the project's code, and with a fault where the
//! GUID asks for one ("base-crash" and so on). Built by `rustc` alone, with no standard library.
#![no_std]

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
static mut STATES: [(bool, State); 64] = [(false, FRESH); 64];
/// The fault of the latest instantiation, for functions without an instance.
static mut NULL_CRASHES: bool = false;

fn instance<'a>(component: *mut c_void) -> &'a mut Instance {
    // SAFETY: importers give what `fmi2Instantiate` returned, one thread at a time.
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
                log(c"logStatusError", c"the GUID is another");
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
        // "any-guid" is remembered: the wrong GUID names no fault.
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

static mut READINGS: usize = 0;
static mut GLOBAL: f64 = 0.0;
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

/// A getter and a setter: what a value reference means.
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

fn new_state(value: State) -> *mut c_void {
    // SAFETY: one thread at a time.
    unsafe {
        let states = &raw mut STATES;
        for slot in &mut *states {
            if !slot.0 {
                *slot = (true, value);
                return (slot as *mut (bool, State)).cast();
            }
        }
    }
    null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: a place for a pointer.
    unsafe { *state = new_state(instance(c).state) };
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> Status {
    // SAFETY: one of ours.
    let saved = unsafe { &*state.cast::<(bool, State)>() }.1;
    let i = instance(c);
    let x = i.state.x;
    i.state = saved;
    if i.has("state") {
        i.state.x = x;
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(_: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: a pointer to one of ours, or to NULL.
    unsafe {
        if let Some(slot) = (*state).cast::<(bool, State)>().as_mut() {
            slot.0 = false;
        }
        *state = null_mut();
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(_: *mut c_void, _: *mut c_void, size: *mut usize) -> Status {
    // SAFETY: a place for a size.
    unsafe { *size = size_of::<State>() };
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(_: *mut c_void, state: *mut c_void, bytes: *mut u8, _: usize) -> Status {
    // SAFETY: one of ours, and an array of the size told.
    unsafe {
        let value = &raw const (*state.cast::<(bool, State)>()).1;
        core::ptr::copy_nonoverlapping(value.cast::<u8>(), bytes, size_of::<State>());
    }
    OK
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(c: *mut c_void, bytes: *const u8, _: usize, state: *mut *mut c_void) -> Status {
    if instance(c).has("serialize") {
        return ERROR;
    }
    // SAFETY: the bytes of a state.
    unsafe { *state = new_state(bytes.cast::<State>().read_unaligned()) };
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2DoStep(c: *mut c_void, time: f64, step: f64, _: c_int) -> Status {
    let i = instance(c);
    if i.has("crash") {
        crash();
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

/// Functions of capabilities that the FMU does not have.
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
