//! The states of an instance and the calls that are legal in them: table 4.2.4 of FMI 2.0.5,
//! to the letter.

/// Where an instance is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated,
    /// Between entering and leaving initialization mode.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// The last step was discarded.
    StepFailed,
    /// The last step was canceled.
    StepCanceled,
    /// After terminating.
    Terminated,
    /// A call answered error: only reset or an earlier FMU state brings the instance back.
    Error,
    /// A call answered fatal, here or in another instance of the FMU: nothing is legal.
    Fatal,
}

impl Phase {
    /// The phase in a sentence: "… is not legal *before initialization*".
    pub(crate) fn when(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization mode",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "after initialization mode",
            Self::StepFailed => "after a discarded step",
            Self::StepCanceled => "after a canceled step",
            Self::Terminated => "after termination",
            Self::Error => "after an error",
            Self::Fatal => "after a fatal error",
        }
    }
}

use Phase::{
    Error as E, Initialization as M, Instantiated as I, StepCanceled as X, StepComplete as C,
    StepFailed as F, Terminated as T,
};

pub(crate) const INSTANTIATED: &[Phase] = &[I];
pub(crate) const INITIALIZATION: &[Phase] = &[M];
pub(crate) const STEP: &[Phase] = &[C];
pub(crate) const TERMINATE: &[Phase] = &[C, F];
pub(crate) const ANY: &[Phase] = &[I, M, C, F, X, T, E];
pub(crate) const GET: &[Phase] = &[M, C, T, F, X, E];
pub(crate) const SET: &[Phase] = &[I, M, C];
/// GetFMUstate. Canceled and failed steps are for debugging, as the error state is.
pub(crate) const GET_STATE: &[Phase] = ANY;
pub(crate) const SET_INPUT_DERIVATIVES: &[Phase] = &[I, M, C];
pub(crate) const GET_OUTPUT_DERIVATIVES: &[Phase] = &[C, X, T, F, E];
