//! The method of K. Levenberg and D. W. Marquardt (*An algorithm for least-squares estimation of
//! nonlinear parameters*, J. SIAM 11, 1963), the one loop of all refinements. What a step is, over which
//! coordinates and which trials are refused, is the caller's: coordinates may change with every step, and
//! the rows of derivatives need not be in memory together.

use steerwright_formats::interruption::check;

/// How the damping of the steps changes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Damping {
    pub(crate) first: f64,
    /// Factor after a step that lowers the cost, and what it does not fall below.
    pub(crate) fall: f64,
    pub(crate) least: f64,
    /// Factor after one that does not, and how many are tried in a row.
    pub(crate) rise: f64,
    pub(crate) tries: usize,
}

/// For models whose columns are of about one length.
pub(crate) const USUAL: Damping =
    Damping { first: 1e-4, fall: 0.2, least: 1e-12, rise: 8.0, tries: 8 };

pub(crate) struct Reached<P> {
    pub(crate) point: P,
    pub(crate) cost: f64,
    pub(crate) steps: usize,
}

/// Lowers the cost from a point by at most `steps` steps. `linearise` makes the problem of a step, `None`
/// where there is none, and may change the cost that trials are compared with; `trial` its solution under a damping with the cost there, `None` where it is
/// refused. A step after which `goes_on(before, now)` is false is the last.
pub(crate) fn lower<P, L, E>(
    (mut point, mut cost): (P, f64),
    steps: usize,
    rule: Damping,
    goes_on: impl Fn(f64, f64) -> bool,
    mut linearise: impl FnMut(&P, &mut f64) -> Result<Option<L>, E>,
    mut trial: impl FnMut(&P, &L, f64) -> Result<Option<(P, f64)>, E>,
) -> Result<Reached<P>, E> {
    let (mut damping, mut taken) = (rule.first, 0);
    'steps: for _ in 0..steps {
        if !(cost.is_finite() && cost > 0.0) {
            break;
        }
        let Some(linear) = linearise(&point, &mut cost)? else { break };
        for _ in 0..rule.tries {
            check();
            if let Some((next, now)) = trial(&point, &linear, damping)?
                && now < cost
            {
                let before = cost;
                (point, cost) = (next, now);
                damping = (damping * rule.fall).max(rule.least);
                taken += 1;
                if goes_on(before, now) {
                    continue 'steps;
                }
                break 'steps;
            }
            damping *= rule.rise;
        }
        break;
    }
    Ok(Reached { point, cost, steps: taken })
}

pub(crate) fn by_more_than(share: f64) -> impl Fn(f64, f64) -> bool {
    move |before, now| 1.0 - now / before > share
}
