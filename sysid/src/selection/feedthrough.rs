//! Whether the output depends on the input of its own sample.

use crate::Error;
use crate::selection::candidate::{Candidate, ROUGH, refine};
use crate::selection::comparison::Comparison;
use crate::selection::initial_estimates::{InitialEstimates, refit_about};
use crate::selection::method::Method;
use crate::selection::options::IdentifyOptions;

/// Whether a direct gain, estimated along with B for the poles of a subspace model, lowers the
/// criterion, at the chosen order or the one before: it was chosen without, which may have cost a
/// state.
pub(crate) fn wants_feedthrough(
    compare: &Comparison<'_>,
    initial_estimates: &InitialEstimates<'_>,
    candidates: &[Candidate],
    chosen: usize,
) -> bool {
    candidates[chosen.saturating_sub(1)..=chosen].iter().any(|c| {
        let criterion = |feedthrough: bool| {
            let Method::OpenLoop(method) = c.method else { return None };
            let order = c.model.order();
            let start =
                initial_estimates.again((c.horizon, method, c.realization), order, feedthrough)?;
            let mut start = Candidate::new(start, feedthrough);
            compare.weigh(&mut start, None, false).ok()?;
            Some(compare.criterion(&start))
        };
        matches!((criterion(true), criterion(false)), (Some(a), Some(b)) if a < b)
    })
}

/// The model with D taken out, fitted again.
pub(crate) fn without_feedthrough(
    compare: &Comparison<'_>,
    options: &IdentifyOptions,
    from: &Candidate,
) -> Result<Candidate, Error> {
    let m = &from.model;
    let (model, initial_conditions, _) =
        refit_about(&m.a, &m.c, compare.data, false, compare.offset)?;
    let mut rival = Candidate { feedthrough: false, model, initial_conditions, ..from.clone() };
    if options.refine {
        refine(compare.data, &mut rival, ROUGH)?;
    }
    compare.weigh(&mut rival, None, options.refine)?;
    Ok(rival)
}
