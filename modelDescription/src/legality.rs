//! Which combinations of causality, variability and `initial` FMI 2.0 allows, and which variables
//! have a start value: the two tables of section 2.2.7.

use crate::vocabulary::{Causality, Initial, Variability};

/// The five groups of the standard's table of `initial`.
#[derive(Clone, Copy)]
enum Group {
    /// exact only.
    A,
    /// approx or calculated (default calculated).
    B,
    /// exact, approx or calculated (default calculated).
    C,
    /// Inputs: `initial` is not given, a start value is.
    D,
    /// The independent variable: neither is given.
    E,
}

/// The group of a combination, `None` where the standard has a dash.
const fn group(causality: Causality, variability: Variability) -> Option<Group> {
    use {Causality as C, Variability as V};
    match (causality, variability) {
        (C::Output | C::Local, V::Constant) | (C::Parameter, V::Fixed | V::Tunable) => {
            Some(Group::A)
        }
        (C::CalculatedParameter | C::Local, V::Fixed | V::Tunable) => Some(Group::B),
        (C::Output | C::Local, V::Discrete | V::Continuous) => Some(Group::C),
        (C::Input, V::Discrete | V::Continuous) => Some(Group::D),
        (C::Independent, V::Continuous) => Some(Group::E),
        _ => None,
    }
}

/// Whether the standard allows this combination; `initial: None` is an absent attribute.
#[must_use]
pub const fn is_legal(
    causality: Causality,
    variability: Variability,
    initial: Option<Initial>,
) -> bool {
    match (group(causality, variability), initial) {
        (None, _) | (Some(Group::D | Group::E), Some(_)) => false,
        (Some(_), None) => true,
        (Some(Group::A), Some(initial)) => matches!(initial, Initial::Exact),
        (Some(Group::B), Some(initial)) => matches!(initial, Initial::Approx | Initial::Calculated),
        (Some(Group::C), Some(_)) => true,
    }
}

/// The default of `initial`; `None` for inputs, the independent variable and what is illegal.
#[must_use]
pub const fn default_initial(causality: Causality, variability: Variability) -> Option<Initial> {
    match group(causality, variability) {
        Some(Group::A) => Some(Initial::Exact),
        Some(Group::B | Group::C) => Some(Initial::Calculated),
        Some(Group::D | Group::E) | None => None,
    }
}

/// Whether a start value must be given, for an `initial` that is given or the default.
#[must_use]
pub const fn needs_start(causality: Causality, initial: Option<Initial>) -> bool {
    matches!(causality, Causality::Input)
        || matches!(initial, Some(Initial::Exact | Initial::Approx))
}

/// Whether a start value may be given, for an `initial` that is given or the default.
#[must_use]
pub const fn allows_start(causality: Causality, initial: Option<Initial>) -> bool {
    !matches!(causality, Causality::Independent) && !matches!(initial, Some(Initial::Calculated))
}
