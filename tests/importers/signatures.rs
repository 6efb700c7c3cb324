//! The C types of the exported functions against those of the official headers.
//!
//! rust-fmi has the headers of FMI 2.0.4 translated by bindgen; nobody of this project wrote them
//! down. What is proven, all of it by the compiler, without a cast:
//!
//! 1. Each row of [`functions!`], read with the headers' types, is the header's type of that
//!    function (`fmi2DoStepTYPE`), and the type with which rust-fmi calls it.
//! 2. The same row, read with our types, is the type of the very function that
//!    [`fmi2_export::export!`] exports under that name: the check stands among the macro's items.
//! 3. Type by type, the two readings are the same: the numbers, pointers and strings are identical
//!    types. The three enumerations are integers of 32 bits on both sides, with the same values
//!    (bindgen's may be unsigned, as the C compiler has them; ours are `i32`). The callback
//!    structs have the same size, alignment, offsets and, by rows as in 1 and 2, members.
//!
//! Left to run time: that no function is forgotten, and the two strings of the headers. That the
//! binaries export these names, and that calls through them do what they should, is proven in
//! `closed_loop.rs`.
#![allow(dead_code, non_snake_case)] // the proofs are never called; C has its own style

mod functions;

use fmi2_export::calls::Call;
use fmi2_export::model_description::{Table, Value, VariableSpec};
use fmi2_export::{Log, Resources, CoSimulationUnit, VariableId, types};
use functions::functions;
use std::mem::offset_of;

/// The types as the headers have them.
mod header {
    pub(crate) use fmi::fmi2::binding::{
        Fmi2Binding, fmi2Boolean as Boolean, fmi2Byte as Byte,
        fmi2CallbackFunctions as CallbackFunctions, fmi2Component as Component,
        fmi2ComponentEnvironment as Environment, fmi2FMUstate as FmuState, fmi2Integer as Integer,
        fmi2Real as Real, fmi2Status as Status, fmi2StatusKind as StatusKind, fmi2String as Text,
        fmi2Type as Type, fmi2ValueReference as ValueReference,
    };
}

/// The types as `fmi2-export` has them: see the page of its module `types`.
mod ours {
    pub(crate) use fmi2_export::types::CallbackFunctions;
    use std::ffi::{c_char, c_void};

    pub(crate) type Boolean = i32;
    pub(crate) type Byte = c_char;
    pub(crate) type Component = *mut c_void;
    pub(crate) type Environment = *mut c_void;
    pub(crate) type FmuState = *mut c_void;
    pub(crate) type Integer = i32;
    pub(crate) type Real = f64;
    pub(crate) type Status = i32;
    pub(crate) type StatusKind = i32;
    pub(crate) type Text = *const c_char;
    pub(crate) type Type = i32;
    pub(crate) type ValueReference = u32;
}

/// 1: the rows are the header's.
macro_rules! as_in_the_header {
    ($($name:ident $kind:ident($($parameter:ty),*) -> $result:ty;)*) => {
        const _: () = {
            use fmi::fmi2::binding;
            use header::*;
            // The header's types are nullable function pointers.
            $(const _: fn(unsafe extern "C" fn($($parameter),*) -> $result) -> binding::$kind = Some;)*
            const _: fn(&Fmi2Binding) = |binding| {$(
                let _: &Result<unsafe extern "C" fn($($parameter),*) -> $result, _> = &binding.$name;
            )*};
        };
    };
}
functions!(as_in_the_header);

/// 2: the rows are what [`fmi2_export::export!`] makes; gives their number.
macro_rules! as_exported {
    ($($name:ident $kind:ident($($parameter:ty),*) -> $result:ty;)*) => {{
        use $crate::ours::*;
        let mut count = 0;
        $(
            let _: unsafe extern "C" fn($($parameter),*) -> $result = $name;
            count += 1;
        )*
        count
    }};
}
// The exported functions have no path: they are in a block of the macro. So is the type it is
// given, and with it the block that is that type's argument.
fmi2_export::export!(Nothing<{ functions!(as_exported) }>);

/// 3: a type is itself. What converts one type to another does not compile here.
macro_rules! the_same_type {
    ($($name:ident)*) => { $(const _: fn(header::$name) -> ours::$name = std::convert::identity;)* };
}
the_same_type!(Boolean Byte Component Environment FmuState Integer Real Text ValueReference);

/// The integers that a C enumeration of 32 bits may be.
trait Enumeration {}
impl Enumeration for i32 {}
impl Enumeration for u32 {}

const fn enumerations<Theirs: Enumeration, Ours: Enumeration>() {
    assert!(size_of::<Theirs>() == size_of::<Ours>() && align_of::<Theirs>() == align_of::<Ours>());
}

const _: () = {
    use fmi::fmi2::binding::*;
    enumerations::<header::Status, ours::Status>();
    enumerations::<header::Type, ours::Type>();
    enumerations::<header::StatusKind, ours::StatusKind>();
    assert!(fmi2Status_fmi2OK as i64 == types::Status::Ok as i64);
    assert!(fmi2Status_fmi2Warning as i64 == types::Status::Warning as i64);
    assert!(fmi2Status_fmi2Discard as i64 == types::Status::Discard as i64);
    assert!(fmi2Status_fmi2Error as i64 == types::Status::Error as i64);
    assert!(fmi2Status_fmi2Fatal as i64 == types::Status::Fatal as i64);
    assert!(fmi2Type_fmi2CoSimulation as i64 == types::CO_SIMULATION as i64);
    assert!(fmi2StatusKind_fmi2LastSuccessfulTime as i64 == types::LAST_SUCCESSFUL_TIME as i64);
    assert!(fmi2StatusKind_fmi2Terminated as i64 == types::TERMINATED as i64);
    // Those that ours has no name for are others.
    assert!(fmi2Status_fmi2Pending as i64 == 5);
    assert!(fmi2Type_fmi2ModelExchange as i64 == 0);
    assert!(fmi2StatusKind_fmi2DoStepStatus as i64 == 0);
    assert!(fmi2StatusKind_fmi2PendingStatus as i64 == 1);
};

/// The members of the callback structs: the header's name, ours, and the type.
macro_rules! callbacks {
    ($($theirs:ident $ours:ident: $kind:ty;)*) => {
        const _: () = {
            assert!(size_of::<header::CallbackFunctions>() == size_of::<ours::CallbackFunctions>());
            assert!(align_of::<header::CallbackFunctions>() == align_of::<ours::CallbackFunctions>());
            $(assert!(
                offset_of!(header::CallbackFunctions, $theirs)
                    == offset_of!(ours::CallbackFunctions, $ours)
            );)*
        };
        // Taken apart without `..`: neither has a member more.
        const _: fn(header::CallbackFunctions) = |callbacks| {
            use header::*;
            let CallbackFunctions { $($theirs),* } = callbacks;
            $(let _: $kind = $theirs;)*
        };
        const _: fn(ours::CallbackFunctions) = |callbacks| {
            use ours::*;
            let CallbackFunctions { $($ours),* } = callbacks;
            $(let _: $kind = $ours;)*
        };
    };
}
callbacks! {
    logger logger: Option<unsafe extern "C" fn(Environment, Text, Status, Text, Text, ...)>;
    allocateMemory allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut std::ffi::c_void>;
    freeMemory free_memory: Option<unsafe extern "C" fn(*mut std::ffi::c_void)>;
    stepFinished step_finished: Option<unsafe extern "C" fn(Environment, Status)>;
    componentEnvironment component_environment: Environment;
}

/// A unit without variables; its argument is a place for code, see above.
#[derive(Clone)]
struct Nothing<const FUNCTIONS: usize>;

const TABLE: Table = Table::new("Nothing", "1.0.0", "Has no variables", &[]);

/// There is none.
#[derive(Clone, Copy)]
enum Variable {}

impl VariableId for Variable {
    fn from_reference(_: u32) -> Option<Self> {
        None
    }

    fn spec(self) -> &'static VariableSpec {
        match self {}
    }
}

impl<const FUNCTIONS: usize> CoSimulationUnit for Nothing<FUNCTIONS> {
    type Variable = Variable;
    const TABLE: &'static Table = &TABLE;

    fn open(_: &Resources) -> Result<Self, String> {
        Ok(Self)
    }

    fn get(&mut self, variable: Variable) -> Value {
        match variable {}
    }

    fn set(&mut self, variable: Variable, _: &Value) {
        match variable {}
    }

    fn exit_initialization(&mut self, _: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }
}

macro_rules! names {
    ($($name:ident $kind:ident($($parameter:ty),*) -> $result:ty;)*) => { [$(stringify!($name)),*] };
}

#[test]
fn every_function_has_the_type_of_the_header() {
    let mut proven = functions!(names).to_vec();
    let mut exported: Vec<&str> = Call::ALL.iter().map(|call| call.name()).collect();
    assert_eq!(exported.len(), 34);
    proven.sort_unstable();
    exported.sort_unstable();
    assert_eq!(proven, exported);
    println!("{} functions have the types of the official headers", proven.len());
}

#[test]
fn the_exported_strings_are_those_of_the_header() {
    assert_eq!(types::TYPES_PLATFORM.to_bytes_with_nul(), fmi::fmi2::binding::fmi2TypesPlatform);
    assert_eq!(types::VERSION.to_bytes_with_nul(), fmi::fmi2::binding::fmi2Version);
}
