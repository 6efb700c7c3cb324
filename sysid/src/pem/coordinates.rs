//! Local coordinates of a model: its moves without those that only change the basis of the state
//! (McKelvey, Helmersson and Ribarits, Automatica 40, 2004; docs/methods/refinement.md). A change
//! of basis moves (A, B, C) by (EA − AE, EB, −CE); a complement of these is `dA = X Vᵀ, dC = Y Vᵀ,
//! dB = W`, with `AᵀX + CᵀY = 0` in a basis where `AᵀA + CᵀC = I`, (X; Y) orthonormal and (V, W)
//! free. The outputs are weighted as their errors are, so that units do not matter.
//!
//! `Y + C(zI − A)⁻¹X` is all-pass, which keeps the coordinates well scaled, and its entries are
//! scalar filters, which makes the derivatives cheap (see `rows`).

use crate::Error;
use crate::linalg::dense::{identity, is_finite, solve, spectral_radius, vcat};
use crate::model::StateSpace;
use faer::{Mat, MatRef, Side};

/// A is shrunk to this spectral radius for its basis, so that an integrator has one too.
const LARGEST_RADIUS: f64 = 0.999_999;

/// A model in a basis for its local coordinates.
#[derive(Debug, Clone)]
pub(crate) struct Coordinates {
    pub(super) model: StateSpace,
    pub(super) x: Mat<f64>,
    pub(super) y: Mat<f64>,
    /// The state there is `basis · x` of the state that was given.
    pub(super) basis: Mat<f64>,
    /// Whether D may move, for each input.
    pub(super) feedthrough: Vec<bool>,
}

/// A move of (A, B, C, D).
pub(super) type Move = StateSpace;

impl Coordinates {
    /// About `model`, its outputs weighted by `weight`; D moves for the inputs of `feedthrough`.
    pub(crate) fn new(
        model: &StateSpace,
        weight: &Mat<f64>,
        feedthrough: &[bool],
    ) -> Result<Self, Error> {
        let (n, p) = (model.order(), model.outputs());
        let basis = output_normal(model, weight)?;
        let model = in_basis(model, basis.as_ref());
        let seen = weight * &model.c;
        let tall = vcat(&[model.a.as_ref(), seen.as_ref()]);
        let q = tall.qr().compute_Q();
        Self {
            x: q.get(..n, n..).to_owned(),
            y: solve(weight.as_ref(), q.get(n.., n..)),
            basis,
            model,
            feedthrough: feedthrough.to_vec(),
        }
        .checked(p)
    }

    fn checked(self, p: usize) -> Result<Self, Error> {
        let finite = is_finite(self.x.as_ref()) && is_finite(self.model.a.as_ref());
        if finite && self.y.ncols() == p {
            Ok(self)
        } else {
            Err(Error::Numerical { what: "local coordinates of the model" })
        }
    }

    /// Number of parameters: V and W row by row, then D's columns that may move, row by row.
    pub(crate) fn count(&self) -> usize {
        let (n, m, p) = (self.model.order(), self.model.inputs(), self.model.outputs());
        n * (p + m) + p * self.feedthrough.iter().filter(|moves| **moves).count()
    }

    pub(super) fn direction(&self, step: &[f64]) -> Move {
        let (n, m, p) = (self.model.order(), self.model.inputs(), self.model.outputs());
        let vt = Mat::from_fn(p, n, |j, k| step[k * p + j]);
        let mut rest = step[n * (p + m)..].iter().copied();
        let mut d = Mat::zeros(p, m);
        for i in 0..p {
            for l in (0..m).filter(|l| self.feedthrough[*l]) {
                d[(i, l)] = rest.next().unwrap_or(0.0);
            }
        }
        Move {
            a: &self.x * &vt,
            b: Mat::from_fn(n, m, |k, l| step[n * p + k * m + l]),
            c: &self.y * &vt,
            d,
        }
    }

    pub(crate) fn moved(&self, step: &[f64]) -> StateSpace {
        let delta = self.direction(step);
        StateSpace {
            a: &self.model.a + delta.a,
            b: &self.model.b + delta.b,
            c: &self.model.c + delta.c,
            d: &self.model.d + delta.d,
        }
    }
}

/// L = chol(G) with G = AᵀGA + CᵀC, the weighted outputs' observability Gramian.
fn output_normal(model: &StateSpace, weight: &Mat<f64>) -> Result<Mat<f64>, Error> {
    const MOST_DOUBLINGS: usize = 60;
    let n = model.order();
    let shrink = (LARGEST_RADIUS / spectral_radius(model.a.as_ref())).min(1.0);
    let mut power = Mat::from_fn(n, n, |i, j| shrink * model.a[(i, j)]);
    let seen = weight * &model.c;
    let mut gramian = seen.transpose() * &seen;
    for _ in 0..MOST_DOUBLINGS {
        let more = power.transpose() * &gramian * &power;
        let done = more.norm_l2() <= 1e-17 * gramian.norm_l2();
        gramian += more;
        power = &power * &power;
        if done {
            break;
        }
    }
    if !is_finite(gramian.as_ref()) {
        return Err(Error::Numerical { what: "observability of the model" });
    }
    // A mode that the output does not show has no scale of its own.
    let floor = 1e-13 * (0..n).map(|i| gramian[(i, i)]).sum::<f64>().max(1e-300);
    let mut more = 0.0;
    loop {
        let g = Mat::from_fn(n, n, |i, j| {
            0.5 * (gramian[(i, j)] + gramian[(j, i)]) + if i == j { more } else { 0.0 }
        });
        if let Ok(cholesky) = g.llt(Side::Lower) {
            return Ok(cholesky.L().transpose().to_owned());
        }
        more = if more > 0.0 { 100.0 * more } else { floor };
        if !more.is_finite() || more > 1e300 {
            return Err(Error::Numerical { what: "observability of the model" });
        }
    }
}

pub(super) fn in_basis(model: &StateSpace, l: MatRef<'_, f64>) -> StateSpace {
    let over = |m: MatRef<'_, f64>| solve(l.transpose(), m.transpose()).transpose().to_owned();
    StateSpace {
        a: over((l * &model.a).as_ref()),
        b: l * &model.b,
        c: over(model.c.as_ref()),
        d: model.d.clone(),
    }
}

pub(super) fn inverse(l: MatRef<'_, f64>) -> Mat<f64> {
    solve(l, identity(l.nrows()).as_ref())
}
