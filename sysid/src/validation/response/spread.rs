//! How uncertain poles and zeros are: the delta method, with central differences of a thousandth of
//! a standard deviation along the columns of the estimate's covariance factor.

use crate::model::StateSpace;
use crate::validation::response::modelled::rounded;
use faer::Mat;
use steerwright_formats::{Matrix, Spread};

/// Step along each direction, standard deviations.
const STEP: f64 = 1e-3;

/// The spreads of `points`, which `of` computes, under moves of the entries of A, B, C, D, … in the
/// rows of `covariance_factor`; `None` where a point cannot be followed.
pub(crate) fn spreads(
    model: &StateSpace,
    covariance_factor: &Matrix,
    points: &[(f64, f64)],
    of: impl Fn(&StateSpace) -> Vec<(f64, f64)>,
) -> Vec<Option<Spread>> {
    let mut sums: Vec<Option<[f64; 3]>> = vec![Some([0.0; 3]); points.len()];
    for row in &covariance_factor.0 {
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
    let finite = |sum: [f64; 3]| if sum.iter().all(|s| s.is_finite()) { Some(sum) } else { None };
    let spread = |[re, im, both]: [f64; 3]| Spread {
        variance_re: rounded(re),
        variance_im: rounded(im),
        covariance: rounded(both),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense::eigenvalues;
    use crate::validation::residuals::correlation::tests::noise;

    fn row(values: &[f64]) -> Mat<f64> {
        Mat::from_fn(1, values.len(), |_, j| values[j])
    }

    /// Covariance of poles and zeros of models drawn at random, and the share in the 95 % ellipse.
    #[test]
    fn a_spread_is_the_scatter_of_drawn_models() {
        let model = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.8, 0.3], [-0.2, 0.7]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [0.5, 1.0][i]),
            c: row(&[1.0, -0.4]),
            d: row(&[0.7]),
        };
        let entries = 4 + 2 + 2 + 1;
        let covariance_factor =
            Matrix::from_fn(3, entries, |i, j| 4e-3 * f64::sin((7 * i + j * j) as f64));
        let poles = |m: &StateSpace| m.poles().unwrap_or_default();
        // y = 0: the poles of A − B C/D.
        let zeros = |m: &StateSpace| {
            let a = &m.a - &m.b * &m.c * (1.0 / m.d[(0, 0)]);
            eigenvalues(a.as_ref()).unwrap_or_default()
        };
        let mut state = 5_u64;
        for of in [&poles as &dyn Fn(&StateSpace) -> Vec<(f64, f64)>, &zeros] {
            let points: Vec<(f64, f64)> = of(&model).into_iter().filter(|z| z.1 >= 0.0).collect();
            for (at, spread) in points.iter().zip(spreads(&model, &covariance_factor, &points, of))
            {
                let s = spread.unwrap();
                let mut sums = [0.0; 3];
                const DRAWN: usize = 4000;
                for _ in 0..DRAWN {
                    let xi = [0; 3].map(|_| noise(&mut state));
                    let row: Vec<f64> = (0..entries)
                        .map(|j| (0..3).map(|i| xi[i] * covariance_factor.entry(i, j)).sum())
                        .collect();
                    let of_drawn = of(&moved(&model, &row, 1.0));
                    let d = of_drawn
                        .iter()
                        .map(|z| (z.0 - at.0, z.1 - at.1))
                        .min_by(|a, b| a.0.hypot(a.1).total_cmp(&b.0.hypot(b.1)))
                        .unwrap();
                    for (sum, x) in sums.iter_mut().zip([d.0 * d.0, d.1 * d.1, d.0 * d.1]) {
                        *sum += x / DRAWN as f64;
                    }
                }
                let size = s.variance_re + s.variance_im;
                for (got, stated) in sums.iter().zip([s.variance_re, s.variance_im, s.covariance]) {
                    assert!((got - stated).abs() < 0.06 * size, "{at:?}: {sums:?} {s:?}");
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_followed_has_no_spread() {
        let model = StateSpace { a: row(&[0.5]), b: row(&[1.0]), c: row(&[1.0]), d: row(&[0.0]) };
        let covariance_factor = Matrix::from_fn(1, 4, |_, _| 0.1);
        let none = |_: &StateSpace| Vec::new();
        assert_eq!(spreads(&model, &covariance_factor, &[(0.1, 0.0)], none), [None]);
    }
}
