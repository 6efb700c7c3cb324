//! The states of an instance and their legal calls: table 4.2.4 of FMI 2.0.5, to the letter.

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
    /// A call returned error: only reset or an earlier FMU state restores the instance.
    Error,
    /// A call returned fatal, here or in another instance of the FMU: nothing is legal.
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

/// Some phases: those in which a call is legal.
#[derive(Clone, Copy)]
pub(crate) struct Phases(u8);

impl Phases {
    pub(crate) const fn new(phases: &[Phase]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < phases.len() {
            bits |= 1 << phases[i] as u8;
            i += 1;
        }
        Self(bits)
    }

    #[inline]
    pub(crate) const fn contain(self, phase: Phase) -> bool {
        self.0 & 1 << phase as u8 != 0
    }
}

pub(crate) const INSTANTIATED: Phases = Phases::new(&[I]);
pub(crate) const INITIALIZATION: Phases = Phases::new(&[M]);
pub(crate) const STEP: Phases = Phases::new(&[C]);
pub(crate) const TERMINATE: Phases = Phases::new(&[C, F]);
pub(crate) const ANY: Phases = Phases::new(&[I, M, C, F, X, T, E]);
pub(crate) const GET: Phases = Phases::new(&[M, C, T, F, X, E]);
pub(crate) const SET: Phases = Phases::new(&[I, M, C]);
pub(crate) const GET_OUTPUT_DERIVATIVES: Phases = Phases::new(&[C, X, T, F, E]);
/// After an error.
pub(crate) const ERROR: Phases = Phases::new(&[E]);
