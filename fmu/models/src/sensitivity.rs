//! How fast a plant's outputs and states react to its states and inputs: the entries of A, B, C
//! and D, and the pattern of those that are always zero.
//!
//! A plant's states are counted from 0: those of its lateral model, then yaw, x, y.

/// The numerator of a partial derivative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// The yaw rate, rad/s.
    YawRate,
    /// The lateral acceleration, m/s².
    LateralAcceleration,
    /// A state.
    State(usize),
    /// The derivative of a state by time.
    Rate(usize),
}

/// The denominator of a partial derivative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// The steering angle, rad.
    SteeringAngle,
    /// The speed, m/s.
    Speed,
    /// A state.
    State(usize),
    /// The scale of the noise; it acts at the start alone.
    NoiseScale,
}

/// A partial derivative at the present values; the variant names the quantities that change it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Factor {
    /// Nothing: the same number for ever.
    Constant(f64),
    /// Parameters of the vehicle: the same number from the start on.
    Fixed(f64),
    /// States, inputs or time.
    Dependent(f64),
}

impl Factor {
    /// The partial derivative.
    #[must_use]
    pub const fn value(self) -> f64 {
        match self {
            Self::Constant(value) | Self::Fixed(value) | Self::Dependent(value) => value,
        }
    }

    /// A constant, where it is not zero.
    #[must_use]
    pub(crate) fn constant(value: f64) -> Option<Self> {
        if value != 0.0 { Some(Self::Constant(value)) } else { None }
    }
}
