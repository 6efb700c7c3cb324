//! Errors in the data of a model.

/// An error of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A matrix or vector of a model has the wrong number of entries.
    #[error("{name} has {got} entries, expected {need}")]
    Shape {
        /// The matrix.
        name: &'static str,
        /// Entries given.
        got: usize,
        /// Entries needed.
        need: usize,
    },
    /// A number is NaN or infinite.
    #[error("{name} is {value}, expected a finite number")]
    NotFinite {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number that must be positive is not.
    #[error("{name} is {value}, expected a positive number")]
    NotPositive {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number that must not be negative is.
    #[error("{name} is {value}, expected zero or more")]
    Negative {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number outside the range that a model takes.
    #[error("{name} is {value}, expected {min} to {max}")]
    Range {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Least value taken.
        min: f64,
        /// Largest value taken.
        max: f64,
    },
    /// The continuous model is not the one the discrete model was sampled from.
    #[error(
        "the continuous model does not sample to the discrete one: {name} differs by {difference:e}"
    )]
    Inconsistent {
        /// The matrix of the discrete model.
        name: &'static str,
        /// Largest difference, relative to the matrix's norm.
        difference: f64,
    },
    /// A step that is not in (0, `limit`].
    #[error("the step is {step} s, expected more than 0 and at most {limit} s")]
    Step {
        /// The step.
        step: f64,
        /// The longest one taken.
        limit: f64,
    },
    /// A model too fast to be stepped in a reasonable time.
    #[error("the model's fastest rate is {rate:e} 1/s, expected at most {limit:e} 1/s")]
    TooFast {
        /// Rate of the fastest mode.
        rate: f64,
        /// Largest rate taken.
        limit: f64,
    },
    /// A vehicle that is unstable even at walking pace.
    #[error("the critical speed is {critical_speed} m/s, expected more than {limit} m/s")]
    CriticalSpeed {
        /// Speed above which the vehicle is unstable.
        critical_speed: f64,
        /// Least speed accepted.
        limit: f64,
    },
    /// The states grew beyond all numbers.
    #[error("the model diverged: {name} is {value}")]
    Diverged {
        /// The state.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A step over more grid points than are walked in a reasonable time.
    #[error("the step of {step} s spans {points:.3e} grid points, at most {limit:e} are taken")]
    TooManyGridPoints {
        /// The step.
        step: f64,
        /// Grid points in it.
        points: f64,
        /// Most grid points taken.
        limit: f64,
    },
    /// A saved state that the model cannot be in.
    #[error("{name} of the saved state is {value}, expected {expected}")]
    SavedState {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The valid range.
        expected: &'static str,
    },
    /// A path needs two points.
    #[error("{got} points, a path needs at least 2")]
    TooFewPoints {
        /// Points given.
        got: usize,
    },
    /// The distance along a path does not increase.
    #[error("point {index}: the distance {distance} m does not increase (before it {before} m)")]
    Distance {
        /// The point, from 0.
        index: usize,
        /// Its distance.
        distance: f64,
        /// The one before.
        before: f64,
    },
    /// Two points lie further apart than the distance between them.
    #[error("point {index}: {chord} m from the point before, though only {arc} m along the path")]
    ShorterThanChord {
        /// The second of the points, from 0.
        index: usize,
        /// Straight distance between them.
        chord: f64,
        /// Distance along the path.
        arc: f64,
    },
    /// The path does not go where its heading points.
    #[error("point {index}: the heading is {heading} rad, but the path goes towards {chord} rad")]
    Heading {
        /// The first point of the segment, from 0.
        index: usize,
        /// Heading in the middle of the segment.
        heading: f64,
        /// Direction to the next point.
        chord: f64,
    },
    /// A number of a path's point is NaN or infinite.
    #[error("point {index}: {name} is {value}, expected a finite number")]
    Point {
        /// The point, from 0.
        index: usize,
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Refuses the first of some states or outputs that is no number.
#[inline]
pub(crate) fn diverged(values: impl IntoIterator<Item = (&'static str, f64)>) -> Result<(), Error> {
    match values.into_iter().find(|(_, value)| !value.is_finite()) {
        None => Ok(()),
        Some((name, value)) => Err(Error::Diverged { name, value }),
    }
}

/// Refuses the first of some numbers of a model's data that is none.
pub(crate) fn numbers(values: &[(&'static str, f64)]) -> Result<(), Error> {
    match values.iter().find(|(_, value)| !value.is_finite()) {
        None => Ok(()),
        Some(&(name, value)) => Err(Error::NotFinite { name, value }),
    }
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
