//! Whole models with the input held, or joined by straight lines, between the samples.
//!
//! Zero-order hold: eq 9–10, with C = H and D as it is. First-order (triangle) hold (Franklin,
//! Powell and Workman, *Digital Control of Dynamic Systems*, 3rd ed. 1998, section 6.3.2): with
//!
//! `exp([F G 0; 0 0 I/T; 0 0 0]·T) = [A Γ₁ Γ₂; 0 I I; 0 0 I]`,
//!
//! `x(k+1) = A x + Γ₁ u(k) + Γ₂ (u(k+1) − u(k))`. The state x − Γ₂u makes it causal:
//! `B = Γ₁ + (A − I)Γ₂`, `C = H`, `D + HΓ₂` instead of D. Since `Γ₁ = Tφ₁(FT)G`, `Γ₂ = Tφ₂(FT)G`
//! and `φ₁(z) = 1 + zφ₂(z)`, that is `B = Tφ₁(FT)²G`: the inverse takes φ₁ off twice, each time as the
//! zero-order hold's does once.
//!
//! The first-order hold suits inputs that move smoothly, as a steering angle does: a model identified
//! between samples of such an input is biased by half a sample's delay if read as held.

use crate::linalg::dense::relative_difference;
use crate::model::StateSpace;
use crate::model::conversion::{exponential, to_continuous};
use faer::Mat;

/// What the input does between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// It stays as it was at the earlier one.
    Zero,
    /// It moves along a straight line.
    First,
}

/// `ẋ = F x + G u`, `y = H x + D u`.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuousStateSpace {
    /// F, n by n, 1/s.
    pub f: Mat<f64>,
    /// G, n by nu, per second.
    pub g: Mat<f64>,
    /// H, ny by n.
    pub h: Mat<f64>,
    /// D, ny by nu.
    pub d: Mat<f64>,
}

/// The discrete model whose samples are those of `continuous` under the hold.
#[must_use]
pub fn discretize_held(
    continuous: &ContinuousStateSpace,
    sample_time: f64,
    hold: Hold,
) -> StateSpace {
    let ContinuousStateSpace { f, g, h, d } = continuous;
    let (n, m) = (f.nrows(), g.ncols());
    let joined = Mat::from_fn(n + 2 * m, n + 2 * m, |i, j| {
        if i < n && j < n {
            f[(i, j)] * sample_time
        } else if i < n && j < n + m {
            g[(i, j - n)] * sample_time
        } else if (n..n + m).contains(&i) && j == i + m {
            1.0
        } else {
            0.0
        }
    });
    let e = exponential(joined.as_ref());
    let a = e.get(..n, ..n).to_owned();
    let held = e.get(..n, n..n + m).to_owned();
    match hold {
        Hold::Zero => StateSpace { a, b: held, c: h.clone(), d: d.clone() },
        Hold::First => {
            let ramp = e.get(..n, n + m..);
            let b = held + &a * ramp - ramp;
            StateSpace { a, b, c: h.clone(), d: d + h * ramp }
        }
    }
}

/// The continuous model that [`discretize_held`] brings back to `model`, with the largest relative
/// error of A, B and D on the way there and back.
///
/// # Errors
/// The reason in words where A has no real principal logarithm, or none within 1e-10 of it.
pub fn to_continuous_held(
    model: &StateSpace,
    sample_time: f64,
    hold: Hold,
) -> Result<(ContinuousStateSpace, f64), String> {
    let once = to_continuous(model.a.as_ref(), model.b.as_ref(), sample_time)?;
    let (g, d) = match hold {
        Hold::Zero => (once.g, model.d.clone()),
        Hold::First => {
            // φ₁⁻¹B, of which φ₁ is taken off once more.
            let half =
                Mat::from_fn(once.g.nrows(), once.g.ncols(), |i, j| once.g[(i, j)] * sample_time);
            let g = to_continuous(model.a.as_ref(), half.as_ref(), sample_time)?.g;
            let (p, m) = (model.outputs(), model.inputs());
            let bare = ContinuousStateSpace {
                f: once.f.clone(),
                g: g.clone(),
                h: model.c.clone(),
                d: Mat::zeros(p, m),
            };
            let fed = discretize_held(&bare, sample_time, Hold::First).d;
            (g, &model.d - fed)
        }
    };
    let continuous = ContinuousStateSpace { f: once.f, g, h: model.c.clone(), d };
    let back = discretize_held(&continuous, sample_time, hold);
    let d_size = model.d.norm_l2().max((&model.d - &continuous.d).norm_l2());
    let d_error = (&back.d - &model.d).norm_l2() / if d_size > 0.0 { d_size } else { 1.0 };
    let round_trip = relative_difference(back.a.as_ref(), model.a.as_ref())
        .max(relative_difference(back.b.as_ref(), model.b.as_ref()))
        .max(d_error);
    if round_trip <= crate::model::conversion::WORST_ROUND_TRIP {
        Ok((continuous, round_trip))
    } else {
        Err(format!("the logarithm of A is inexact (round trip {round_trip:.1e})"))
    }
}
