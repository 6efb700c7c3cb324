//! The continuous model behind a sampled one: the logarithm of a matrix.
//!
//! With the input held, `e^{[F G; 0 0]·T} = [A B; 0 I]` (eq 9): square roots by Denman and Beavers (1976) until
//! the rest is near the identity, then `log X = 2·artanh((X − I)(X + I)⁻¹)` (Higham, *Functions of Matrices*).

use nalgebra::{DMatrix, DVector};

/// Square roots taken at most; the rest is then as near the identity as rounding leaves it.
const ROOTS: u32 = 40;
/// Iterations of one square root.
const ITERATIONS: usize = 40;
/// How near the identity the series is used.
const NEAR: f64 = 0.05;
/// Largest relative error with which the exponential must return the sampled model.
const TRUSTED: f64 = 1e-8;

/// F and G of A and B at sample time T; `None` where A has no real logarithm.
pub(crate) fn continuous(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    sample_time: f64,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let n = b.len();
    let mut whole = DMatrix::identity(n + 1, n + 1);
    whole.view_mut((0, 0), (n, n)).copy_from(a);
    whole.view_mut((0, n), (n, 1)).copy_from(b);
    // An eigenvalue on the negative real axis, or 0, has no real logarithm.
    let on_the_cut = |l: &nalgebra::Complex<f64>| l.re <= 0.0 && l.im.abs() <= 1e-9 * l.re.abs();
    if a.complex_eigenvalues().iter().any(on_the_cut) {
        return None;
    }
    let log = logarithm(whole.clone())? / sample_time;
    let back = steerwright_models::linear::exponential(&(&log * sample_time));
    let error = (back - &whole).norm() / whole.norm();
    if error.is_nan() || error > TRUSTED {
        return None;
    }
    Some((log.view((0, 0), (n, n)).into_owned(), log.view((0, n), (n, 1)).column(0).into_owned()))
}

fn logarithm(mut x: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let identity = DMatrix::identity(x.nrows(), x.nrows());
    let mut scale = 1.0;
    for _ in 0..ROOTS {
        if (&x - &identity).norm() <= NEAR {
            break;
        }
        x = root(&x)?;
        scale *= 2.0;
    }
    let ratio = (&x + &identity).lu().solve(&(&x - &identity))?;
    let square = &ratio * &ratio;
    let mut power = ratio.clone();
    let mut sum = ratio;
    for k in 1..12 {
        power = &power * &square;
        sum += &power / (2.0 * f64::from(k) + 1.0);
    }
    Some(sum * (2.0 * scale))
}

fn root(x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut y = x.clone();
    let mut z = DMatrix::identity(x.nrows(), x.nrows());
    for _ in 0..ITERATIONS {
        let (inverse_y, inverse_z) = (y.clone().try_inverse()?, z.clone().try_inverse()?);
        let next = 0.5 * (&y + inverse_z);
        z = 0.5 * (&z + inverse_y);
        let change = (&next - &y).norm();
        y = next;
        if change <= 1e-15 * y.norm() {
            return Some(y);
        }
    }
    if y.iter().all(|v| v.is_finite()) { Some(y) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use steerwright_models::linear::discretize;

    #[test]
    fn undoes_sampling() {
        let f = DMatrix::from_row_slice(3, 3, &[-6.0, 11.0, 0.3, -9.0, -5.0, 1.0, 0.0, 0.2, -40.0]);
        let g = DMatrix::from_row_slice(3, 1, &[3.0, 8.0, -1.0]);
        for sample_time in [0.001, 0.01, 0.04, 0.1] {
            let (a, b) = discretize(&f, &g, sample_time).unwrap();
            let (back, input) = continuous(&a, &b.column(0).into_owned(), sample_time).unwrap();
            assert!((&back - &f).norm() < 1e-8 * f.norm(), "{sample_time}: {back}");
            assert!((input - g.column(0)).norm() < 1e-8, "{sample_time}");
        }
    }

    #[test]
    fn a_negative_pole_has_none() {
        let a = DMatrix::from_row_slice(2, 2, &[0.5, 0.0, 0.0, -0.3]);
        assert!(continuous(&a, &DVector::from_vec(vec![1.0, 1.0]), 0.04).is_none());
    }
}
