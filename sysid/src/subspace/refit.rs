//! B, D and initial states for given A and C by least squares on the simulated output.

use crate::Error;
use crate::data::{DataSet, Segment};
use crate::linalg::columns::Columns;
use crate::linalg::dense::{is_finite, rows, spectral_radius};
use crate::linalg::elimination::{Elimination, Solution};
use crate::linalg::r_factor::RFactor;
use crate::model::StateSpace;
use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};

/// What [`refit_output`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Refit {
    /// The model with B and D refitted.
    pub model: StateSpace,
    /// Initial state of each segment.
    pub x0: Vec<Vec<f64>>,
    /// Constant added to each output; zeros unless requested.
    pub offset: Vec<f64>,
    /// Sum of the squared errors of the simulation, as it follows from the least-squares problem: exact
    /// up to rounding of the output's own squares.
    pub squares: f64,
}

/// B, D, the initial states and, where requested, a constant on each output that make the
/// *simulated* output of a stable (A, C) fit best, by linear least squares: output i answers to
/// column j of B by the state of `z⁺ = Aᵀ z + c_iᵀ u_j`.
///
/// # Errors
/// [`Error::Numerical`] where the regressors are not finite.
pub fn refit_output(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    data: &DataSet,
    feedthrough: bool,
    offset: bool,
) -> Result<Refit, Error> {
    let (n, m, p) = (a.nrows(), data.inputs(), data.outputs());
    let unstable = Error::Numerical { what: "simulation of an unstable model" };
    if !spectral_radius(a).is_finite() {
        return Err(unstable);
    }
    let (d_start, o_start) = (n * m, n * m + if feedthrough { p * m } else { 0 });
    let shared = o_start + if offset { p } else { 0 };
    let mut elimination = Elimination::new(shared, n);
    for segment in data.segments() {
        let [own, rest] = Arch::new().dispatch(Reduction { a, c, segment, feedthrough, offset });
        if !(is_finite(own.as_ref()) && is_finite(rest.as_ref())) {
            return Err(unstable);
        }
        elimination.segment(own.as_ref());
        elimination.rest(rest.as_ref());
    }
    let Solution { shared: solution, own: x0, squares } = elimination.solve(0.0)?;
    let at = |k: usize| solution[k];
    Ok(Refit {
        model: StateSpace {
            a: a.to_owned(),
            b: Mat::from_fn(n, m, |k, j| at(j * n + k)),
            c: c.to_owned(),
            d: Mat::from_fn(p, m, |i, j| if feedthrough { at(d_start + i * m + j) } else { 0.0 }),
        },
        x0,
        offset: (0..p).map(|i| if offset { at(o_start + i) } else { 0.0 }).collect(),
        squares,
    })
}

struct Reduction<'a> {
    a: MatRef<'a, f64>,
    c: MatRef<'a, f64>,
    segment: &'a Segment,
    feedthrough: bool,
    offset: bool,
}

impl WithSimd for Reduction<'_> {
    type Output = [Mat<f64>; 2];

    /// R factors of the rows that the initial state shows in (columns x0, B column by column, D,
    /// offset, output), and of those after it has died out, without x0. The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { a, c, segment, feedthrough, offset } = self;
        let (n, m, p) = (a.nrows(), segment.u.nrows(), segment.y.nrows());
        let d_start = n + n * m;
        let o_start = d_start + if feedthrough { p * m } else { 0 };
        let target = o_start + if offset { p } else { 0 };
        let (at, c) = (Columns::new(a.transpose()), rows(c));
        let mut own = RFactor::new(target + 1);
        let mut rest = RFactor::new(target + 1 - n);
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let gone = 1e-18 * size(&c);
        // Rows begin with the states of the transposed system, which the next row follows from.
        let mut outputs: Vec<[Vec<f64>; 2]> = Vec::new();
        for (i, ci) in c.chunks_exact(n).enumerate() {
            let mut row = vec![0.0; target + 1];
            row[..n].copy_from_slice(ci);
            if offset {
                row[o_start + i] = 1.0;
            }
            outputs.push([row.clone(), row]);
        }
        let mut is_free = true;
        for t in 0..segment.len() {
            is_free = is_free && outputs.iter().any(|[row, _]| size(&row[..n]) > gone);
            for (i, ([row, next], ci)) in outputs.iter_mut().zip(c.chunks_exact(n)).enumerate() {
                for j in 0..m {
                    let (u, states) = (segment.u[(j, t)], n * (j + 1)..n * (j + 2));
                    if feedthrough {
                        row[d_start + i * m + j] = u;
                    }
                    at.product_and(&row[states.clone()], u, ci, &mut next[states]);
                }
                row[target] = segment.y[(i, t)];
                if is_free {
                    own.push(row);
                    at.product(&row[..n], &mut next[..n]);
                } else {
                    rest.push(&row[n..]);
                }
                std::mem::swap(row, next);
            }
        }
        [own.finish(), rest.finish()]
    }
}
