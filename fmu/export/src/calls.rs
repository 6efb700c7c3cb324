//! Legal calls by state: table 4.2.4 of FMI 2.0.5 as data, with the accepted deviations.
//!
//! [`Call::ALL`] with [`Call::is_legal_in`] is the table. Its footnotes, which restrict reading and
//! setting of variables, are [`RULES`], one for each [`Class`] of variables; [`Class::from_row`] is the class
//! of a row. [`Class::is_unknown_in`] and [`Class::is_known_in`] define the variables that
//! `fmi2GetDirectionalDerivative` accepts. A test of a built library can check all of it. A call that a
//! [`Leniency`] accepts returns `fmi2OK`; the first one of an instance logs a debug line.
//!
//! The table has the calls of optional capabilities for every unit; without the capability they
//! return `fmi2Error` in every state.
//!
//! The states "step in progress", "step failed" and "step canceled" are missing because they cannot be
//! reached: no step is asynchronous, and a step is completed or fails.

pub use crate::access_rules::{Access, Class, Leniency, RULES, Rule, set_access};

/// The state of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After `fmi2Terminate`.
    Terminated,
    /// After an `fmi2Error`.
    Error,
    /// After a panic: only `fmi2FreeInstance` is legal.
    Fatal,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 6] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::Terminated,
        Self::Error,
        Self::Fatal,
    ];

    const fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The standard's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::StepComplete => "step complete",
            Self::Terminated => "terminated",
            Self::Error => "error",
            Self::Fatal => "fatal",
        }
    }
}

const I: u8 = State::Instantiated.bit();
const M: u8 = State::Initialization.bit();
const C: u8 = State::StepComplete.bit();
const T: u8 = State::Terminated.bit();
const E: u8 = State::Error.bit();
const F: u8 = State::Fatal.bit();

/// Declares the calls and their rows of the table in one place.
macro_rules! calls {
    ($($call:ident: $name:literal in $states:expr;)*) => {
        /// The functions of FMI 2.0 for Co-Simulation.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Call { $(#[doc = concat!("`", $name, "`.")] $call,)* }

        impl Call {
            /// Every function.
            pub const ALL: &'static [Self] = &[$(Self::$call),*];

            /// The C name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$call => $name),* }
            }

            #[inline]
            const fn states(self) -> u8 {
                match self { $(Self::$call => $states),* }
            }

            /// Whether the standard allows this call in that state.
            #[must_use]
            #[inline]
            pub const fn is_legal_in(self, state: State) -> bool {
                self.states() & state.bit() != 0
            }
        }
    };
}

calls! {
    GetTypesPlatform: "fmi2GetTypesPlatform" in I | M | C | T | E | F;
    GetVersion: "fmi2GetVersion" in I | M | C | T | E | F;
    SetDebugLogging: "fmi2SetDebugLogging" in I | M | C | T | E;
    Instantiate: "fmi2Instantiate" in I | M | C | T | E | F;
    FreeInstance: "fmi2FreeInstance" in I | M | C | T | E | F;
    SetupExperiment: "fmi2SetupExperiment" in I;
    EnterInitializationMode: "fmi2EnterInitializationMode" in I;
    ExitInitializationMode: "fmi2ExitInitializationMode" in M;
    Terminate: "fmi2Terminate" in C;
    Reset: "fmi2Reset" in I | M | C | T | E;
    GetReal: "fmi2GetReal" in M | C | T | E;
    GetInteger: "fmi2GetInteger" in M | C | T | E;
    GetBoolean: "fmi2GetBoolean" in M | C | T | E;
    GetString: "fmi2GetString" in M | C | T | E;
    SetReal: "fmi2SetReal" in I | M | C;
    SetInteger: "fmi2SetInteger" in I | M | C;
    SetBoolean: "fmi2SetBoolean" in I | M | C;
    SetString: "fmi2SetString" in I | M | C;
    GetFmuState: "fmi2GetFMUstate" in I | M | C | T | E;
    SetFmuState: "fmi2SetFMUstate" in I | M | C | T | E;
    FreeFmuState: "fmi2FreeFMUstate" in I | M | C | T | E;
    SerializedFmuStateSize: "fmi2SerializedFMUstateSize" in I | M | C | T | E;
    SerializeFmuState: "fmi2SerializeFMUstate" in I | M | C | T | E;
    DeSerializeFmuState: "fmi2DeSerializeFMUstate" in I | M | C | T | E;
    GetDirectionalDerivative: "fmi2GetDirectionalDerivative" in M | C | T | E;
    SetRealInputDerivatives: "fmi2SetRealInputDerivatives" in I | M | C;
    GetRealOutputDerivatives: "fmi2GetRealOutputDerivatives" in C | T | E;
    DoStep: "fmi2DoStep" in C;
    CancelStep: "fmi2CancelStep" in 0;
    GetStatus: "fmi2GetStatus" in C | T;
    GetRealStatus: "fmi2GetRealStatus" in C | T;
    GetIntegerStatus: "fmi2GetIntegerStatus" in C | T;
    GetBooleanStatus: "fmi2GetBooleanStatus" in C | T;
    GetStringStatus: "fmi2GetStringStatus" in C | T;
}
