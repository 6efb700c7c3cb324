//! Numbers that a study states, or that each run draws.

/// A number, or the place of a varied quantity among a run's draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    Fixed(f64),
    Drawn(usize),
}

impl Number {
    /// Its value in a run.
    pub(crate) fn of(self, draws: &[f64]) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Drawn(index) => draws[index],
        }
    }
}

/// `factor · value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Linear {
    pub(crate) factor: f64,
    pub(crate) offset: f64,
}

impl Linear {
    pub(crate) const SAME: Self = Self { factor: 1.0, offset: 0.0 };

    pub(crate) fn of(self, value: f64) -> f64 {
        self.factor * value + self.offset
    }

    pub(crate) fn inverse(self) -> Self {
        Self { factor: 1.0 / self.factor, offset: -self.offset / self.factor }
    }
}

/// A float in the shortest decimal that reads back as the same float.
pub(crate) fn shortest(value: f64) -> String {
    format!("{value:?}")
}
