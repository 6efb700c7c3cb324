//! How uncertain poles and zeros are: the delta method, with derivatives along the directions of the
//! estimate's covariance by central differences.
//!
//! A step of a thousandth of a standard deviation is small against every curvature that a first-order
//! statement can bear, and large against the rounding of eigenvalues.

use crate::model::StateSpace;
use faer::Mat;
use formats::{Matrix, Spread};

/// Step along each direction, standard deviations.
const STEP: f64 = 1e-3;

/// The spreads of `points` (of the upper half plane, or all), which `of` computes of a model, under
/// the moves of its matrices in the rows of `directions`: entries of A, B, C, D, each row by row, and
/// more that does not matter. `None` where a point cannot be followed or its spread is not finite.
pub(crate) fn spreads(
    model: &StateSpace,
    directions: &Matrix,
    points: &[(f64, f64)],
    of: impl Fn(&StateSpace) -> Vec<(f64, f64)>,
) -> Vec<Option<Spread>> {
    let mut sums: Vec<Option<[f64; 3]>> = vec![Some([0.0; 3]); points.len()];
    for row in &directions.0 {
        let sides = [STEP, -STEP].map(|step| of(&moved(model, row, step)));
        for (sum, point) in sums.iter_mut().zip(points) {
            let Some([forth, back]) = followed(&sides, *point, points.len()) else {
                *sum = None;
                continue;
            };
            if let Some(sum) = sum {
                let re = (forth.0 - back.0) / (2.0 * STEP);
                let im = (forth.1 - back.1) / (2.0 * STEP);
                sum[0] += re * re;
                sum[1] += im * im;
                sum[2] += re * im;
            }
        }
    }
    let finite = |sum: [f64; 3]| sum.iter().all(|s| s.is_finite()).then_some(sum);
    let spread = |[re, im, both]: [f64; 3]| Spread {
        variance_re: super::rounded(re),
        variance_im: super::rounded(im),
        covariance: super::rounded(both),
    };
    sums.into_iter().map(|sum| sum.and_then(finite).map(spread)).collect()
}

/// Where a point has gone on either side: the nearest there, if there are as many as were.
fn followed(
    sides: &[Vec<(f64, f64)>; 2],
    point: (f64, f64),
    least: usize,
) -> Option<[(f64, f64); 2]> {
    let apart = |z: &(f64, f64)| (z.0 - point.0).hypot(z.1 - point.1);
    let near = |side: &Vec<(f64, f64)>| {
        let nearest = side.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.filter(|_| side.len() >= least)
    };
    Some([near(&sides[0])?, near(&sides[1])?])
}

fn moved(model: &StateSpace, row: &[f64], step: f64) -> StateSpace {
    let mut at = 0;
    let mut take = |m: &Mat<f64>| {
        let from = at;
        at += m.nrows() * m.ncols();
        Mat::from_fn(m.nrows(), m.ncols(), |i, j| {
            m[(i, j)] + step * row.get(from + i * m.ncols() + j).copied().unwrap_or(0.0)
        })
    };
    StateSpace { a: take(&model.a), b: take(&model.b), c: take(&model.c), d: take(&model.d) }
}
