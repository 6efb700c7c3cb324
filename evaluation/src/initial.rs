//! The initial estimate of a refinement.

use steerwright_sysid::model::stability::{largest_radius, stable_shift};
use steerwright_sysid::subspace::{Factor, noise_model, refit_output, shift_realization, subspace};
use steerwright_sysid::{DataSet, Error, Innovation, Weighting};

/// MOESP with 15 block rows, stabilised, and the initial state of each segment.
///
/// # Errors
/// As its stages.
pub fn initial_estimate(
    data: &DataSet,
    order: usize,
) -> Result<(Innovation, Vec<Vec<f64>>), Error> {
    let factor = Factor::new(data, 15)?;
    let sub = subspace(&factor, Weighting::Moesp)?;
    let (mut a, c) = shift_realization(&sub, order, data.outputs())?;
    let radius = largest_radius(data.samples());
    // Where A is stable already, this leaves it as it is.
    if let Some(stable) = stable_shift(sub.basis.as_ref(), order, data.outputs(), radius) {
        a = stable;
    }
    let refit = refit_output(a.as_ref(), c.as_ref(), data, false, false)?;
    let gain = noise_model(&factor, &refit.model)?.gain;
    Ok((Innovation { model: refit.model, gain }, refit.x0))
}
