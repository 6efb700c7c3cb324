//! A stable state matrix from the shift structure of Γ or from state sequences, whatever the data
//! (T. Van Gestel, J. Suykens, P. Van Dooren, B. De Moor, IEEE Trans. Automatic Control 46, 2001):
//! `A(c) = (Γ↑ᵀΓ↑ + c·I)⁻¹ Γ↑ᵀ Γ↓` → 0 for growing c. The paper computes the least c from a
//! generalised eigenvalue problem; here it is bisected, which finds *a* c with the radius sought.
//! Γ↑ and Γ↓ may as well be the transposes of the state sequences of eq 12, with Aᵀ in place of A.

use crate::linalg::dense::{solve, spectral_radius};
use faer::{Mat, MatRef};

/// A state matrix of spectral radius at most `radius` (below 1) from the `order` first columns of
/// the basis of Γ; `None` only where Γ is not finite.
#[must_use]
pub fn stable_shift(
    basis: MatRef<'_, f64>,
    order: usize,
    outputs: usize,
    radius: f64,
) -> Option<Mat<f64>> {
    let rows = basis.nrows();
    let up = basis.get(..rows - outputs, ..order);
    stable_fit(up, basis.get(outputs.., ..order), radius)
}

/// The A of least ‖up·A − down‖² + c·‖A‖², c such that its spectral radius is `radius` at most.
pub(crate) fn stable_fit(
    up: MatRef<'_, f64>,
    down: MatRef<'_, f64>,
    radius: f64,
) -> Option<Mat<f64>> {
    let order = up.ncols();
    let gram = up.transpose() * up;
    let cross = up.transpose() * down;
    let size = gram.norm_l2();
    if !(size.is_finite() && size > 0.0) {
        return None;
    }
    let at = |log_c: f64| {
        let c = size * log_c.exp();
        let regular =
            Mat::from_fn(order, order, |i, j| gram[(i, j)] + if i == j { c } else { 0.0 });
        solve(regular.as_ref(), cross.as_ref())
    };
    let fits = |a: &Mat<f64>| spectral_radius(a.as_ref()) <= radius;
    // From no regularisation to speak of to one that surely suffices: ‖A(c)‖ ≤ ‖Γ↑ᵀΓ↓‖/c.
    let (mut low, mut high) = (-37.0, 5.0);
    while !fits(&at(high)) {
        high += 5.0;
        if high > 100.0 {
            return None;
        }
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if fits(&at(middle)) { high = middle } else { low = middle }
    }
    Some(at(high))
}

/// Length of a vehicle's record over the time constant of its slowest mode, at least: a slower one is no dynamics but a trend.
pub(crate) const TIME_CONSTANTS: f64 = 10.0;

/// The largest spectral radius of a model of so many samples: the time constant of its slowest mode
/// is a tenth of the record, as a slower one is no dynamics but a trend.
#[must_use]
pub fn largest_radius(samples: usize) -> f64 {
    radius_of_slowest(samples, TIME_CONSTANTS)
}

/// The spectral radius of a mode of which so many time constants are as long as a record of so many samples.
pub(crate) fn radius_of_slowest(samples: usize, time_constants: f64) -> f64 {
    (-time_constants / samples.max(100) as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense::spectral_radius;
    use crate::model::simulation::free_response;
    use crate::model::state_space::StateSpace;

    /// The shift is by all outputs: a mode that is stable already stays where it is.
    #[test]
    fn of_two_outputs_the_stable_mode_hardly_moves() {
        let model = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| if i == j { [1.0005, 0.5][i] } else { 0.0 }),
            b: Mat::zeros(2, 1),
            c: Mat::from_fn(2, 2, |i, j| [[1.0, 2.0], [-0.5, 1.0]][i][j]),
            d: Mat::zeros(2, 1),
        };
        let gamma = free_response(&model, 12);
        let a = stable_shift(gamma.as_ref(), 2, 2, 0.9999).unwrap();
        let poles = StateSpace { a, ..model }.poles().unwrap();
        let near = |want: f64| poles.iter().any(|p| (p.0 - want).abs() < 0.01 && p.1 == 0.0);
        assert!(near(0.9999) && near(0.5), "{poles:?}");
    }

    #[test]
    fn growing_and_oscillating_modes_are_brought_in() {
        let growing = StateSpace {
            a: Mat::from_fn(3, 3, |i, j| {
                [[1.05, 0.3, 0.0], [-0.3, 1.05, 0.1], [0.0, 0.0, 1.2]][i][j]
            }),
            b: Mat::zeros(3, 1),
            c: Mat::from_fn(1, 3, |_, j| [1.0, 0.2, 0.5][j]),
            d: Mat::zeros(1, 1),
        };
        let gamma = free_response(&growing, 12);
        for radius in [0.99, 0.9999] {
            let a = stable_shift(gamma.as_ref(), 3, 1, radius).unwrap();
            let got = spectral_radius(a.as_ref());
            assert!(got <= radius && got > radius - 0.05, "{got}");
        }
    }
}
