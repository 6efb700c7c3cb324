//! Zeros of a plant in the right half-plane, which no controller can remove.
//!
//! With input u, output r and the relative degree q, the smallest with `h = H·F^{q−1}·G ≠ 0`, the
//! zeros of (F, G, H) are the eigenvalues of `(I − G·H·F^{q−1}/h)·F` but for q at the origin; with a
//! feedthrough those of `F − G·H/D`. A zero at z in the right half-plane keeps the crossover below
//! about z/2 (Skogestad and Postlethwaite, *Multivariable Feedback Control*, 5.6).

use crate::plants::{DesignPlant, Dynamics, Matrices};
use nalgebra::{Complex, DMatrix};

/// Below this share of what it could be, a product is rounding.
const ROUNDING: f64 = 1e-9;

/// The modulus of the right half-plane zero nearest to the origin, rad/s.
pub(crate) fn nearest_right_half_plane(plant: &DesignPlant) -> Option<f64> {
    let right: Vec<f64> = match &plant.dynamics {
        Dynamics::Continuous(m) => {
            zeros(m).into_iter().filter(|z| z.re > 0.0).map(|z| z.re.hypot(z.im)).collect()
        }
        // Sampling itself makes zeros on the negative axis, which mean nothing.
        Dynamics::Discrete { sample_time, matrices } => zeros(matrices)
            .into_iter()
            .filter(|z| z.re > 0.0 && z.re.hypot(z.im) > 1.0)
            .map(|z| z.re.hypot(z.im).ln().hypot(z.im.atan2(z.re)) / sample_time)
            .collect(),
    };
    right.into_iter().min_by(f64::total_cmp)
}

fn zeros(m: &Matrices) -> Vec<Complex<f64>> {
    let n = m.input.len();
    let scale = m.output.norm() * m.input.norm();
    if m.feedthrough.abs() > ROUNDING * scale {
        let inverse = &m.state - &m.input * m.output.transpose() / m.feedthrough;
        return inverse.complex_eigenvalues().iter().copied().collect();
    }
    let mut row = m.output.transpose();
    for degree in 1..=n {
        let h = (&row * &m.input)[0];
        if h.abs() > ROUNDING * row.norm() * m.input.norm() {
            let projected = (DMatrix::identity(n, n) - &m.input * &row / h) * &m.state;
            let mut all: Vec<_> = projected.complex_eigenvalues().iter().copied().collect();
            all.sort_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
            return all.split_off(degree);
        }
        row *= &m.state;
    }
    Vec::new()
}
