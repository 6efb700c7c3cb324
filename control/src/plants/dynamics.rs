//! A linear plant from steering to yaw rate: its matrices, stability, steady-state gain and zeros.
//!
//! **Zeros.** With input u, output r and the relative degree q, the smallest with `h = H·F^{q−1}·G ≠ 0`, the
//! zeros of (F, G, H) are the eigenvalues of `(I − G·H·F^{q−1}/h)·F` except for q at the origin; with a
//! feedthrough those of `F − G·H/D`. No controller removes a zero in the right half-plane; one at z keeps
//! the crossover below about z/2 (Skogestad and Postlethwaite, *Multivariable Feedback Control*, 5.6).

use nalgebra::{Complex, DMatrix, DVector};

/// Below this share of its largest possible value, a product counts as rounding.
const ROUNDING: f64 = 1e-9;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Dynamics {
    /// F, G, H, D.
    Continuous(Matrices),
    /// A, B, C, D on a grid of `sample_time`.
    Discrete { sample_time: f64, matrices: Matrices },
}

/// State matrix n by n, input n by 1, output 1 by n (as a column), feedthrough.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matrices {
    pub(crate) state: DMatrix<f64>,
    pub(crate) input: DVector<f64>,
    pub(crate) output: DVector<f64>,
    pub(crate) feedthrough: f64,
}

/// The fastest growing mode in words, where one does not decay.
pub(crate) fn unstable_mode(dynamics: &Dynamics) -> Option<String> {
    match dynamics {
        Dynamics::Continuous(m) => m
            .state
            .complex_eigenvalues()
            .iter()
            .map(|l| l.re)
            .max_by(f64::total_cmp)
            .filter(|rate| *rate >= -1e-9)
            .map(|rate| {
                let limit = 2.0 * rate.max(0.0);
                format!(
                    "grows at a rate of {rate:.3} 1/s, which only a crossover above about \
                     {limit:.3} rad/s would hold"
                )
            }),
        Dynamics::Discrete { matrices, .. } => matrices
            .state
            .complex_eigenvalues()
            .iter()
            .map(|l| l.re.hypot(l.im))
            .max_by(f64::total_cmp)
            .filter(|modulus| *modulus >= 1.0 - 1e-9)
            .map(|modulus| format!("grows by {modulus:.6} in a sample")),
    }
}

/// H·(−F)⁻¹·G + D, or C·(I − A)⁻¹·B + D; not finite where that does not exist.
pub(crate) fn steady_state_gain(dynamics: &Dynamics) -> f64 {
    let (matrix, m) = match dynamics {
        Dynamics::Continuous(m) => (-&m.state, m),
        Dynamics::Discrete { matrices: m, .. } => {
            (DMatrix::identity(m.state.nrows(), m.state.nrows()) - &m.state, m)
        }
    };
    matrix.lu().solve(&m.input).map_or(f64::NAN, |x| m.output.dot(&x) + m.feedthrough)
}

/// The modulus of the right half-plane zero nearest to the origin, rad/s.
pub(crate) fn nearest_right_half_plane_zero(dynamics: &Dynamics) -> Option<f64> {
    let right: Vec<f64> = match dynamics {
        Dynamics::Continuous(m) => {
            zeros(m).into_iter().filter(|z| z.re > 0.0).map(|z| z.re.hypot(z.im)).collect()
        }
        // Sampling itself creates zeros on the negative axis, which no plant has.
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
