//! Whether the output depends on the input of its own sample.

use crate::Error;
use crate::selection::candidate::{Candidate, ROUGH, refine};
use crate::selection::comparison::Comparison;
use crate::selection::initial_estimates::{Starts, refit_about};
use crate::selection::method::Approach;
use crate::selection::options::IdentifyOptions;

/// Whether a direct gain, estimated along with B for the poles of a subspace model, lowers the
/// criterion, at the chosen order or the one before: it was chosen without, which may have cost a
/// state.
pub(crate) fn wants_feedthrough(
    compare: &Comparison<'_>,
    starts: &Starts<'_>,
    candidates: &[Candidate],
    chosen: usize,
) -> bool {
    candidates[chosen.saturating_sub(1)..=chosen].iter().any(|c| {
        let criterion = |feedthrough: bool| {
            let Approach::OpenLoop(method) = c.approach else { return None };
            let order = c.model.order();
            let start = starts.again((c.horizon, method, c.realization), order, feedthrough)?;
            let mut start = Candidate::new(start, feedthrough);
            compare.weigh(&mut start, None, false).ok()?;
            Some(compare.criterion(&start))
        };
        matches!((criterion(true), criterion(false)), (Some(a), Some(b)) if a < b)
    })
}

/// The model with D taken out, fitted anew.
pub(crate) fn without_feedthrough(
    compare: &Comparison<'_>,
    options: &IdentifyOptions,
    from: &Candidate,
) -> Result<Candidate, Error> {
    let m = &from.model;
    let (model, conditions, _) = refit_about(&m.a, &m.c, compare.data, false, compare.level)?;
    let mut rival = Candidate { feedthrough: false, model, conditions, ..from.clone() };
    if options.refine {
        refine(compare.data, &mut rival, ROUGH)?;
    }
    compare.weigh(&mut rival, None, options.refine)?;
    Ok(rival)
}
