//! Subspace identification: block Hankel matrices → LQ → weighted SVD → A, C (shift structure or eq
//! 12) → B, D → K (P. Van Overschee and B. De Moor, *A unifying theorem for three subspace system
//! identification algorithms*, Automatica 31, 1995; docs/methods/subspace.md). Everything after the
//! LQ factorisation works on the small matrix L. Shapes: U_f is s·nu by j, Y_f s·ny by j, for s
//! block rows of past and of future.

mod accumulator;
pub mod closed_loop;
mod conditioning;
mod factor;
mod gram;
mod lags;
mod noise;
mod realization;
mod refit;
mod state;
mod structured;
mod tall;
mod weights;

pub use crate::subspace::accumulator::Accumulator;
pub use crate::subspace::conditioning::{Conditioning, Decomposition};
pub use crate::subspace::factor::Factor;
pub use crate::subspace::noise::{NoiseModel, noise_model};
pub use crate::subspace::realization::{
    Projections, Realization, eq12, shift_realization, stable_eq12,
};
pub use crate::subspace::refit::{Refit, refit_output};
pub use crate::subspace::structured::structured_bd;
pub use crate::subspace::weights::{Subspace, Weighting, subspace};
