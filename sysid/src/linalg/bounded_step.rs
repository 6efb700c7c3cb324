//! Steps of least squares within bounds, with a normal prior for each parameter.

use crate::linalg::dense::is_finite;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Largest step in priors' deviations.
const LARGEST_STEP: f64 = 2.0;

/// A prior in coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal {
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
    pub(crate) bounds: [f64; 2],
}

/// A damped step of the parameters in `free` by gradient and Gauss–Newton Hessian. Parameters at a bound that the step
/// would leave stay there.
pub(crate) fn bounded_step<const N: usize>(
    free: &[usize],
    priors: &[Normal; N],
    gradient: &[f64; N],
    hessian: &[[f64; N]; N],
    at: &[f64; N],
    damping: f64,
) -> Option<[f64; N]> {
    let mut moving = free.to_vec();
    while !moving.is_empty() {
        let n = moving.len();
        let damped = Mat::from_fn(n, n, |i, j| {
            let h = hessian[moving[i]][moving[j]];
            if i == j { h * (1.0 + damping) } else { h }
        });
        let descent = Mat::from_fn(n, 1, |i, _| -gradient[moving[i]]);
        let solution = damped.llt(Side::Lower).ok()?.solve(&descent);
        if !is_finite(solution.as_ref()) {
            return None;
        }
        let leaves = |(j, &i): (usize, &usize)| {
            let [low, high] = priors[i].bounds;
            let step = solution[(j, 0)];
            if (at[i] <= low && step < 0.0) || (at[i] >= high && step > 0.0) {
                Some(i)
            } else {
                None
            }
        };
        let held: Vec<usize> = moving.iter().enumerate().filter_map(leaves).collect();
        if !held.is_empty() {
            moving.retain(|i| !held.contains(i));
            continue;
        }
        let relative = |(j, &i): (usize, &usize)| (solution[(j, 0)] / priors[i].deviation).abs();
        let largest = moving.iter().enumerate().map(relative).fold(0.0, f64::max);
        let scale = if largest > LARGEST_STEP { LARGEST_STEP / largest } else { 1.0 };
        let mut next = *at;
        for (j, &i) in moving.iter().enumerate() {
            let [low, high] = priors[i].bounds;
            next[i] = (at[i] + scale * solution[(j, 0)]).clamp(low, high);
        }
        return Some(next);
    }
    None
}
