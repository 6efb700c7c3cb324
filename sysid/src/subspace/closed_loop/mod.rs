//! Identification from closed-loop data: a driver or a controller steers by what the vehicle does
//! (docs/methods/subspace.md).
//!
//! Both methods begin with the VARX model ([`Predictor`]) `y(t) = D u(t) + Σ_{j=1..p} C Ã^{j−1} B̃
//! z(t−j) + e(t)`, Ã = A − K C, B̃ = [B − K D, K], z = [u; y], and differ in how they get the state
//! x = T·z_p of the p last samples. Their bias is what Ãᵖ leaves out, so it goes with a growing
//! past horizon p, which [`past_horizon`] picks; the variance grows with p.
//!
//! The feedback must use the *recorded* output. With feedthrough the loop must have a delay of a
//! sample somewhere, or D is biased; so D is off unless it is requested. Where the loop closes
//! around the true signals and both recordings have white sensor noise, [`errors_in_variables`]
//! holds and these two do not.
//!
//! Everything is computed from the R factor of the data in order of time ([`Factor`]), at a cost
//! that does not depend on the number of samples. Means are the caller's to remove, as for the
//! factor.

pub mod errors_in_variables;
mod feedback;
mod predictor;
mod states;
mod windows;

pub(crate) use crate::subspace::closed_loop::feedback::feedback_lags;
pub use crate::subspace::closed_loop::feedback::{Feedback, feedback, feedback_in};
pub use crate::subspace::closed_loop::predictor::{Predictor, past_horizon};
pub use crate::subspace::closed_loop::states::Decomposition;

use crate::Error;
use crate::data::DataSet;
use crate::model::Innovation;
use crate::subspace::closed_loop::windows::Windows;
use crate::subspace::factor::Factor;

/// A method for closed-loop data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ClosedLoopMethod {
    /// State-space modelling from a pre-estimated ARX model (Jansson 2003).
    Ssarx,
    /// Predictor-based subspace identification, optimised (Chiuso 2007).
    Pbsid,
}

impl ClosedLoopMethod {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Ssarx, Self::Pbsid];
}

/// The model of one order.
///
/// `past` is p, the order of the VARX model; `future` the number of block rows that are
/// predicted, at least n/ny and at most p.
///
/// # Errors
/// As [`factor`], [`decompose`] and [`Decomposition::model`].
pub fn identify(
    data: &DataSet,
    method: ClosedLoopMethod,
    past: usize,
    future: usize,
    order: usize,
    feedthrough: bool,
) -> Result<Innovation, Error> {
    decompose(&factor(data, past, future)?, method, past, future, feedthrough)?.model(order)
}

/// The factor of the data for these horizons; one of longer horizons serves as well.
///
/// # Errors
/// [`Error::TooFewSamples`] where the data are too few for the horizons, [`Error::Option`] where a
/// horizon is 0.
pub fn factor(data: &DataSet, past: usize, future: usize) -> Result<Factor, Error> {
    horizons(past, future)?;
    Factor::new(data, (past + future + 1).div_ceil(2))
}

/// States for all orders at once: one VARX model and one singular value decomposition.
///
/// # Errors
/// [`Error::Option`] where a horizon is 0 or `future` above `past`, [`Error::OrderAboveHorizon`]
/// where the factor has less than `past + future + 1` lags, [`Error::NoModel`] where a channel does
/// not move, [`Error::Numerical`] where the factor is not finite or a decomposition does not
/// converge.
pub fn decompose(
    factor: &Factor,
    method: ClosedLoopMethod,
    past: usize,
    future: usize,
    feedthrough: bool,
) -> Result<Decomposition, Error> {
    horizons(past, future)?;
    let windows = Windows::new(factor)?;
    windows.holds(past + future + 1)?;
    let predictor = Predictor::in_units(&windows, past, feedthrough)?;
    let (map, singular_values) = match method {
        ClosedLoopMethod::Pbsid => states::pbsid(&windows, &predictor, future)?,
        ClosedLoopMethod::Ssarx => states::ssarx(&windows, &predictor, future)?,
    };
    Decomposition::new(&windows, past, map.as_ref(), singular_values, feedthrough)
}

fn horizons(past: usize, future: usize) -> Result<(), Error> {
    // Beyond this a window of the data alone would fill the memory.
    const MOST: usize = 10_000;
    if past == 0 || past > MOST {
        return Err(Error::option("past horizon", past, format!("1 to {MOST}")));
    }
    if future == 0 || future > past {
        let expected = format!("1 to the past horizon, {past}");
        return Err(Error::option("future horizon", future, expected));
    }
    Ok(())
}
