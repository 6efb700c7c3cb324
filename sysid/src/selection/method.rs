//! Which family of methods a model is estimated by.

use crate::subspace;
use crate::subspace::closed_loop;

/// A method of identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// For data whose input does not depend on past outputs: a weighting of the open-loop subspace
    /// methods, refined by the simulation error.
    OpenLoop(subspace::Weighting),
    /// For data with feedback from output to input: a predictor-based method, refined by the
    /// one-step prediction error.
    ClosedLoop(closed_loop::ClosedLoopMethod),
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::OpenLoop(subspace::Weighting::N4sid),
        Self::OpenLoop(subspace::Weighting::Moesp),
        Self::OpenLoop(subspace::Weighting::Cva),
        Self::ClosedLoop(closed_loop::ClosedLoopMethod::Ssarx),
        Self::ClosedLoop(closed_loop::ClosedLoopMethod::Pbsid),
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

impl From<subspace::Weighting> for Method {
    fn from(method: subspace::Weighting) -> Self {
        Self::OpenLoop(method)
    }
}

impl From<closed_loop::ClosedLoopMethod> for Method {
    fn from(method: closed_loop::ClosedLoopMethod) -> Self {
        Self::ClosedLoop(method)
    }
}
