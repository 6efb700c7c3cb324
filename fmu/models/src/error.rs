//! Errors in the data of a model.

/// An error of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{name} has {got} entries, expected {need}")]
    Shape { name: &'static str, got: usize, need: usize },
    #[error("{name} is {value}, expected a finite number")]
    NotFinite { name: &'static str, value: f64 },
    #[error("{name} is {value}, expected a positive number")]
    NotPositive { name: &'static str, value: f64 },
    #[error("{name} is {value}, expected zero or more")]
    Negative { name: &'static str, value: f64 },
    #[error("{name} is {value}, expected {min} to {max}")]
    Range { name: &'static str, value: f64, min: f64, max: f64 },
    /// `difference` is relative to the largest entry of the matrix.
    #[error(
        "the continuous model does not sample to the discrete one: {name} differs by {difference:e}"
    )]
    Inconsistent { name: &'static str, difference: f64 },
    #[error("the step is {step} s, expected more than 0 and at most {limit} s")]
    Step { step: f64, limit: f64 },
    #[error("the model's fastest rate is {rate:e} 1/s, expected at most {limit:e} 1/s")]
    TooFast { rate: f64, limit: f64 },
    #[error("the critical speed is {critical_speed} m/s, expected more than {limit} m/s")]
    CriticalSpeed { critical_speed: f64, limit: f64 },
    #[error("the model diverged: {name} is {value}")]
    Diverged { name: &'static str, value: f64 },
    #[error("the step of {step} s spans {points:.3e} grid points, at most {limit:e} are taken")]
    TooManyGridPoints { step: f64, points: f64, limit: f64 },
    #[error("{name} of the saved state is {value}, expected {expected}")]
    SavedState { name: &'static str, value: f64, expected: &'static str },
    #[error("{got} points, a path needs at least 2")]
    TooFewPoints { got: usize },
    #[error("point {index}: the distance {distance} m does not increase (before it {before} m)")]
    Distance { index: usize, distance: f64, before: f64 },
    #[error("point {index}: {chord} m from the point before, though only {arc} m along the path")]
    ShorterThanChord { index: usize, chord: f64, arc: f64 },
    #[error("point {index}: the heading is {heading} rad, but the path goes towards {chord} rad")]
    Heading { index: usize, heading: f64, chord: f64 },
    #[error("point {index}: {name} is {value}, expected a finite number")]
    Point { index: usize, name: &'static str, value: f64 },
}

/// Refuses the first of some states or outputs that is no number.
#[inline]
pub(crate) fn diverged(values: impl IntoIterator<Item = (&'static str, f64)>) -> Result<(), Error> {
    let found = values.into_iter().find(|(_, value)| !value.is_finite());
    found.map_or(Ok(()), |(name, value)| Err(Error::Diverged { name, value }))
}

/// Refuses the first of some numbers of a model's data that is none.
pub(crate) fn numbers(values: &[(&'static str, f64)]) -> Result<(), Error> {
    let found = values.iter().find(|(_, value)| !value.is_finite());
    found.map_or(Ok(()), |&(name, value)| Err(Error::NotFinite { name, value }))
}

/// Refuses a number of a saved state that is not finite.
pub(crate) fn finite(name: &'static str, values: &[f64]) -> Result<(), Error> {
    values.iter().find(|v| !v.is_finite()).map_or(Ok(()), |&value| {
        Err(Error::SavedState { name, value, expected: "a finite number" })
    })
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub const fn hint(&self) -> &'static str {
        match self {
            Self::Shape { .. } => "A is n by n in row-major order, B, C and K have n entries",
            Self::NotFinite { .. }
            | Self::NotPositive { .. }
            | Self::Negative { .. }
            | Self::Range { .. } => "correct the value in the model's file",
            Self::Inconsistent { .. } => {
                "identify again, or remove the continuous model from the file: the discrete one is then stepped on its own grid"
            }
            Self::Step { .. } | Self::TooManyGridPoints { .. } => {
                "choose a shorter communication step"
            }
            Self::SavedState { .. } => {
                "the state was saved by another model, after an error, or damaged on the way: save it again"
            }
            Self::TooFast { .. } => {
                "check the units: mass in kg, stiffness in N/rad an axle, time constants in s"
            }
            Self::CriticalSpeed { .. } => {
                "check the cornering stiffnesses (N/rad an axle) and which axle is the front one"
            }
            Self::Diverged { .. } => {
                "the model or the loop around it is unstable: check gains, signs and speed"
            }
            Self::TooFewPoints { .. } => "state at least a start and an end",
            Self::Distance { .. } => "remove repeated points and sort the path by distance",
            Self::ShorterThanChord { .. } => "check that distance, x and y are all in metres",
            Self::Heading { .. } => {
                "the heading is counter-clockwise from the x axis, in radians; reverse the points if they run backwards"
            }
            Self::Point { .. } => "correct or remove the point",
        }
    }
}
