//! The states in which a variable may be read or set: the footnotes of table 4.2.4 as data, with the
//! accepted deviations from the standard.

use crate::calls::State;
use model_description::{Causality, Initial, Variability, VariableSpec};

/// Whether a variable may be read or set in a state in which the call itself is legal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The standard allows it.
    Legal,
    /// The standard forbids it; it is accepted because a widespread importer does it.
    Lenient(Leniency),
    /// The standard forbids it, and the call is an error.
    Illegal,
}

/// An accepted deviation from the standard, logged once as a debug line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Leniency {
    /// FMPy's `start_values` sets inputs in the state "instantiated".
    InputSetBeforeInitialization,
    /// libcosim reads every variable in initialization mode and terminates the process on an error.
    AnyReadInInitialization,
    /// FMU containers read variables between setting others and the next step; the values follow at once.
    ReadAfterSet,
}

impl Leniency {
    /// Every leniency.
    pub const ALL: [Self; 3] =
        [Self::InputSetBeforeInitialization, Self::AnyReadInInitialization, Self::ReadAfterSet];

    /// The line that is logged.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::InputSetBeforeInitialization => {
                "an input was set before fmi2EnterInitializationMode: accepted, although the standard \
                 forbids it"
            }
            Self::AnyReadInInitialization => {
                "a variable that is not an initial unknown was read in initialization mode: accepted, \
                 although the standard forbids it"
            }
            Self::ReadAfterSet => {
                "a variable was read after another was set, with no fmi2DoStep between them: \
                 accepted, although the standard forbids it; the value follows from the one set"
            }
        }
    }
}

/// The classes of variables that the rules distinguish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)] // named by variability, causality and initial
pub enum Class {
    Constant,
    Input,
    Tunable,
    /// Anything else with initial exact: a fixed parameter, an output or local variable.
    Exact,
    /// A local variable with initial approx.
    Approx,
    /// A local variable with initial calculated.
    Calculated,
    ApproxParameter,
    CalculatedParameter,
    ExactOutput,
    ApproxOutput,
    CalculatedOutput,
    ConstantOutput,
    /// `state[i]` with initial exact.
    SettableState,
    /// `state[i]` with initial calculated.
    CalculatedState,
    /// `der(state[i])`.
    Derivative,
}

impl Class {
    /// The class of a table's row.
    #[must_use]
    #[inline]
    pub const fn from_row(row: &VariableSpec) -> Self {
        // First in the match, since inputs are set at every step.
        if matches!(row.causality, Causality::Input) {
            return Self::Input;
        }
        let initial = row.effective_initial();
        match (row.causality, row.variability) {
            (Causality::Output, Variability::Constant) => Self::ConstantOutput,
            (_, Variability::Constant) => Self::Constant,
            (Causality::Parameter, Variability::Tunable) => Self::Tunable,
            (Causality::Output, _) => match initial {
                Some(Initial::Exact) => Self::ExactOutput,
                Some(Initial::Approx) => Self::ApproxOutput,
                _ => Self::CalculatedOutput,
            },
            (Causality::CalculatedParameter, _) => match initial {
                Some(Initial::Approx) => Self::ApproxParameter,
                _ => Self::CalculatedParameter,
            },
            _ => match initial {
                Some(Initial::Exact) => Self::Exact,
                Some(Initial::Approx) => Self::Approx,
                _ => Self::Calculated,
            },
        }
    }
}

/// One row of the rules: the states in which a class of variables may be read and set.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// The class.
    pub class: Class,
    /// States in which the standard allows setting it.
    pub set: &'static [State],
    /// States in which setting it is accepted as a deviation.
    pub set_leniently: &'static [(State, Leniency)],
    /// States in which the standard allows reading it.
    pub get: &'static [State],
    /// States in which reading it is accepted as a deviation.
    pub get_leniently: &'static [(State, Leniency)],
}

use State::{
    Error as E, Initialization as M, Instantiated as I, StepComplete as C, Terminated as T,
};

const LATER: &[State] = &[C, T, E];
const FROM_M: &[State] = &[M, C, T, E];
const EARLY: &[(State, Leniency)] = &[(I, Leniency::InputSetBeforeInitialization)];
const ANY_IN_M: &[(State, Leniency)] = &[(M, Leniency::AnyReadInInitialization)];

const fn rule(class: Class, set: &'static [State], get: &'static [State]) -> Rule {
    // Variables that may be read only after initialization are read leniently during it.
    let get_leniently = if get.len() == LATER.len() { ANY_IN_M } else { &[] };
    let set_leniently = if matches!(class, Class::Input) { EARLY } else { &[] };
    Rule { class, set, set_leniently, get, get_leniently }
}

/// The rules, one for each [`Class`], in their order.
///
/// For every class, reading at a communication point after setting is [`Leniency::ReadAfterSet`].
pub const RULES: [Rule; 15] = [
    rule(Class::Constant, &[], LATER),
    rule(Class::Input, &[M, C], LATER),
    rule(Class::Tunable, &[I, M, C], LATER),
    rule(Class::Exact, &[I, M], LATER),
    rule(Class::Approx, &[I], LATER),
    rule(Class::Calculated, &[], LATER),
    rule(Class::ApproxParameter, &[I], FROM_M),
    rule(Class::CalculatedParameter, &[], FROM_M),
    rule(Class::ExactOutput, &[I, M], FROM_M),
    rule(Class::ApproxOutput, &[I], FROM_M),
    rule(Class::CalculatedOutput, &[], FROM_M),
    rule(Class::ConstantOutput, &[], FROM_M),
    rule(Class::SettableState, &[I, M], FROM_M),
    rule(Class::CalculatedState, &[], FROM_M),
    rule(Class::Derivative, &[], FROM_M),
];

/// The rules by class, side (set, get) and state: every call looks its access up here.
const ACCESS: [[[Access; State::ALL.len()]; 2]; RULES.len()] = {
    let mut access = [[[Access::Illegal; State::ALL.len()]; 2]; RULES.len()];
    let mut class = 0;
    while class < RULES.len() {
        let rule = &RULES[class];
        assert!(rule.class as usize == class, "the rules are not in the order of the classes");
        let sides = [(rule.set, rule.set_leniently), (rule.get, rule.get_leniently)];
        let mut side = 0;
        while side < 2 {
            let (legal, lenient) = sides[side];
            let mut k = 0;
            while k < lenient.len() {
                access[class][side][lenient[k].0 as usize] = Access::Lenient(lenient[k].1);
                k += 1;
            }
            let mut k = 0;
            while k < legal.len() {
                access[class][side][legal[k] as usize] = Access::Legal;
                k += 1;
            }
            side += 1;
        }
        class += 1;
    }
    access
};

/// For each state, whether the standard allows reading every variable.
pub(crate) const EVERYTHING_READ: [bool; State::ALL.len()] = {
    let mut everything = [true; State::ALL.len()];
    let mut class = 0;
    while class < RULES.len() {
        let mut state = 0;
        while state < everything.len() {
            if !matches!(ACCESS[class][1][state], Access::Legal) {
                everything[state] = false;
            }
            state += 1;
        }
        class += 1;
    }
    everything
};

impl Class {
    /// Whether a variable of this class may be set in a state.
    #[must_use]
    #[inline]
    pub const fn set_access(self, state: State) -> Access {
        ACCESS[self as usize][0][state as usize]
    }

    /// Whether a variable of this class may be read in a state.
    #[must_use]
    #[inline]
    pub const fn get_access(self, state: State) -> Access {
        ACCESS[self as usize][1][state as usize]
    }

    /// Whether it may be an unknown of `fmi2GetDirectionalDerivative`: the InitialUnknowns in
    /// initialization mode, then outputs and derivatives of states.
    #[must_use]
    pub const fn is_unknown_in(self, state: State) -> bool {
        match self {
            Self::Derivative | Self::ApproxOutput | Self::CalculatedOutput => true,
            Self::ApproxParameter | Self::CalculatedParameter | Self::CalculatedState => {
                matches!(state, State::Initialization)
            }
            Self::ExactOutput | Self::ConstantOutput => !matches!(state, State::Initialization),
            _ => false,
        }
    }

    /// Whether it may be a known of `fmi2GetDirectionalDerivative`: inputs and, in initialization
    /// mode, variables with initial exact that are not constant, then the states.
    #[must_use]
    pub const fn is_known_in(self, state: State) -> bool {
        match self {
            Self::Input | Self::SettableState => true,
            Self::Tunable | Self::Exact | Self::ExactOutput => {
                matches!(state, State::Initialization)
            }
            Self::CalculatedState => !matches!(state, State::Initialization),
            _ => false,
        }
    }
}

/// Whether the variable of a row may be set: [`RULES`] by row.
#[must_use]
#[inline]
pub const fn set_access(state: State, row: &VariableSpec) -> Access {
    Class::from_row(row).set_access(state)
}
