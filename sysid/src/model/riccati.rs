//! The discrete algebraic Riccati equation of the stationary Kalman filter, `P = A P Aᵀ + Q − (A P
//! Cᵀ + S)(C P Cᵀ + R)⁻¹(A P Cᵀ + S)ᵀ`, by structure-preserving doubling (Chu, Fan, Lin and Wang,
//! Int. J. Control 77, 2004), which converges quadratically.

use crate::linalg::dense::{
    identity, is_finite, positive_part, relative_difference, solve, spectral_radius,
};
use faer::{Mat, MatRef};

/// The stationary filter.
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanFilter {
    /// Kalman gain K.
    pub gain: Mat<f64>,
    /// Covariance of the innovation C P Cᵀ + R.
    pub innovation: Mat<f64>,
}

/// Solves for the filter; `None` where no solution makes A − K C stable or the measurement noise
/// R is singular.
#[must_use]
pub fn kalman_filter(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    q: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
    s: MatRef<'_, f64>,
) -> Option<KalmanFilter> {
    const MOST_DOUBLINGS: usize = 60;
    let n = a.nrows();
    // Without cross-covariance: A − S R⁻¹ C, Q − S R⁻¹ Sᵀ.
    let r_inverse_c = solve(r, c);
    let r_inverse_st = solve(r, s.transpose());
    let ad = a - s * &r_inverse_c;
    let qd = positive_part((q - s * &r_inverse_st).as_ref()).ok()?;
    let mut ak = ad.transpose().to_owned();
    let mut g = c.transpose() * &r_inverse_c;
    let mut h = qd;
    if !(is_finite(ak.as_ref()) && is_finite(g.as_ref()) && is_finite(h.as_ref())) {
        return None;
    }
    for _ in 0..MOST_DOUBLINGS {
        let w = identity(n) + &g * &h;
        let wa = solve(w.as_ref(), ak.as_ref());
        let wg = solve(w.as_ref(), g.as_ref());
        let h_next = &h + ak.transpose() * &h * &wa;
        g = &g + &ak * wg * ak.transpose();
        ak = &ak * wa;
        if !is_finite(h_next.as_ref()) {
            return None;
        }
        let change = relative_difference(h_next.as_ref(), h.as_ref());
        h = Mat::from_fn(n, n, |i, j| 0.5 * (h_next[(i, j)] + h_next[(j, i)]));
        if change < 1e-15 {
            break;
        }
    }
    let innovation = c * &h * c.transpose() + r;
    let cross = a * &h * c.transpose() + s;
    let gain = solve(innovation.transpose(), cross.transpose()).transpose().to_owned();
    let closed = a - &gain * c;
    let residual = a * &h * a.transpose() + q - &gain * cross.transpose();
    let scale = 1e-300 + h.norm_l2() + q.norm_l2();
    let solved = (&residual - &h).norm_l2() < 1e-6 * scale;
    if solved && is_finite(gain.as_ref()) && spectral_radius(closed.as_ref()) < 1.0 {
        Some(KalmanFilter { gain, innovation })
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scalar_case_has_its_closed_form() {
        // p = a²p + q − (ap + s)²/(p + r) with c = 1.
        let (a, q, r, s) = (0.9, 0.3, 0.5, 0.1);
        let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
        let f = kalman_filter(
            one(a).as_ref(),
            one(1.0).as_ref(),
            one(q).as_ref(),
            one(r).as_ref(),
            one(s).as_ref(),
        )
        .unwrap();
        let b = r - a * a * r - q + 2.0 * a * s;
        let p = 0.5 * (-b + (b * b + 4.0 * (q * r - s * s)).sqrt());
        assert!((f.innovation[(0, 0)] - (p + r)).abs() < 1e-12);
        assert!((f.gain[(0, 0)] - (a * p + s) / (p + r)).abs() < 1e-12);
    }

    #[test]
    fn an_unstable_plant_gets_a_stable_filter() {
        let a = Mat::from_fn(2, 2, |i, j| [[1.2, 0.5], [0.0, 0.7]][i][j]);
        let c = Mat::from_fn(1, 2, |_, j| [1.0, 0.0][j]);
        let q = identity(2);
        let r = Mat::from_fn(1, 1, |_, _| 0.1);
        let s = Mat::zeros(2, 1);
        let f = kalman_filter(a.as_ref(), c.as_ref(), q.as_ref(), r.as_ref(), s.as_ref()).unwrap();
        assert!(spectral_radius((&a - &f.gain * &c).as_ref()) < 0.9);
    }

    #[test]
    fn an_unobservable_unstable_mode_has_none() {
        let a = Mat::from_fn(2, 2, |i, j| if i == j { [0.5, 1.1][i] } else { 0.0 });
        let c = Mat::from_fn(1, 2, |_, j| [1.0, 0.0][j]);
        let r = Mat::from_fn(1, 1, |_, _| 1.0);
        let s = Mat::zeros(2, 1);
        assert!(
            kalman_filter(a.as_ref(), c.as_ref(), identity(2).as_ref(), r.as_ref(), s.as_ref())
                .is_none()
        );
    }
}
