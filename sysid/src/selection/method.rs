//! Which family of methods a model is estimated by.

use crate::subspace;
use crate::subspace::closed_loop;

/// A method of identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// For data whose input does not depend on past outputs: a weighting of the open-loop subspace
    /// methods, refined by the simulation error.
    OpenLoop(subspace::Method),
    /// For data with feedback from output to input: a predictor-based method, refined by the
    /// one-step prediction error.
    ClosedLoop(closed_loop::Method),
}

impl Approach {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::OpenLoop(subspace::Method::N4sid),
        Self::OpenLoop(subspace::Method::Moesp),
        Self::OpenLoop(subspace::Method::Cva),
        Self::ClosedLoop(closed_loop::Method::Ssarx),
        Self::ClosedLoop(closed_loop::Method::Pbsid),
    ];

    /// The name in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenLoop(method) => method.name(),
            Self::ClosedLoop(method) => method.name(),
        }
    }
}

impl From<subspace::Method> for Approach {
    fn from(method: subspace::Method) -> Self {
        Self::OpenLoop(method)
    }
}

impl From<closed_loop::Method> for Approach {
    fn from(method: closed_loop::Method) -> Self {
        Self::ClosedLoop(method)
    }
}
