//! Poles and transmission zeros, with natural frequency and damping. Zeros are the finite
//! generalised eigenvalues of the system pencil `P − z E`, P = [A B; C D], E = [I 0; 0 0], by shift
//! and invert: with μ an eigenvalue of (P − σE)⁻¹E, z = σ + 1/μ.

use crate::linalg::dense::{eigenvalues, solve};
use crate::model::StateSpace;
use crate::model::conversion::{ContinuousModel, to_continuous};
use crate::validation::response::modelled::rounded;
use crate::validation::response::spread::spreads;
use faer::{Mat, MatRef};
use steerwright_formats::{Mode, PoleZeroMap, Spread, Uncertainty};

/// Zeros further out than that many times the scale are at infinity but for rounding.
const FAR: f64 = 1e3;

/// Poles and zeros with their spreads where known; what cannot be computed is left out.
pub(crate) fn poles_and_zeros(
    model: &StateSpace,
    continuous: Option<&ContinuousModel>,
    sample_time_s: f64,
    uncertainty: Option<&Uncertainty>,
) -> PoleZeroMap {
    let spreads =
        |points: &[(f64, f64)], of: &dyn Fn(&StateSpace) -> Vec<(f64, f64)>| match uncertainty {
            Some(u) => spreads(model, &u.directions, points, of),
            None => vec![None; points.len()],
        };
    let upper = |of: &dyn Fn(&StateSpace) -> Vec<(f64, f64)>| -> Vec<Mode> {
        let values: Vec<(f64, f64)> = of(model).into_iter().filter(|z| z.1 >= 0.0).collect();
        let spreads = spreads(&values, of);
        let mut modes: Vec<Mode> =
            values.iter().zip(spreads).map(|(z, s)| mode(*z, s, sample_time_s)).collect();
        // Slowest first.
        modes.sort_by(|a, b| {
            let rank = |m: &Mode| m.natural_frequency_hz.unwrap_or(f64::INFINITY);
            rank(a).total_cmp(&rank(b)).then(a.discrete[1].total_cmp(&b.discrete[1]))
        });
        modes
    };
    let mut zeros = match continuous {
        Some(c) => continuous_zeros(c, model),
        None => Vec::new(),
    };
    zeros.sort_by(|a, b| a.0.hypot(a.1).total_cmp(&b.0.hypot(b.1)).then(a.1.total_cmp(&b.1)));
    let moved = |m: &StateSpace| {
        to_continuous(m.a.as_ref(), m.b.as_ref(), sample_time_s)
            .map_or_else(|_| Vec::new(), |c| continuous_zeros(&c, m))
    };
    let known: Option<Vec<Spread>> = spreads(&zeros, &moved).into_iter().collect();
    PoleZeroMap {
        poles: upper(&|m| m.poles().unwrap_or_default()),
        zeros: upper(&zeros_of),
        continuous_zeros: zeros.iter().map(|(re, im)| [rounded(*re), rounded(*im)]).collect(),
        continuous_zero_spreads: known.unwrap_or_default(),
    }
}

fn zeros_of(m: &StateSpace) -> Vec<(f64, f64)> {
    transmission_zeros(m.a.as_ref(), m.b.as_ref(), m.c.as_ref(), m.d.as_ref(), 1.0)
}

fn continuous_zeros(c: &ContinuousModel, model: &StateSpace) -> Vec<(f64, f64)> {
    let scale = eigenvalues(c.f.as_ref())
        .map_or(0.0, |p| p.iter().map(|p| p.0.hypot(p.1)).fold(0.0, f64::max));
    let [f, g] = [&c.f, &c.g].map(|m| m.as_ref());
    transmission_zeros(f, g, model.c.as_ref(), model.d.as_ref(), scale.max(1e-3))
}

fn mode((re, im): (f64, f64), spread: Option<Spread>, sample_time_s: f64) -> Mode {
    // No −0: a negative z on the axis is the upper one of its pair.
    let im = im.abs();
    let modulus = re.hypot(im);
    let mut mode = Mode {
        discrete: [rounded(re), rounded(im)],
        spread,
        continuous: None,
        natural_frequency_hz: None,
        damping: None,
        time_constant_s: None,
    };
    if modulus < 1e-12 {
        return mode;
    }
    let s = (modulus.ln() / sample_time_s, im.atan2(re) / sample_time_s);
    let magnitude = s.0.hypot(s.1);
    mode.continuous = Some([rounded(s.0), rounded(s.1)]);
    mode.natural_frequency_hz = Some(rounded(magnitude / std::f64::consts::TAU));
    mode.damping = if magnitude > 0.0 { Some(rounded(-s.0 / magnitude)) } else { None };
    mode.time_constant_s = if s.0 < 0.0 { Some(rounded(-1.0 / s.0)) } else { None };
    mode
}

/// Finite transmission zeros (real, imaginary); `scale` is the size of the poles.
fn transmission_zeros(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    d: MatRef<'_, f64>,
    scale: f64,
) -> Vec<(f64, f64)> {
    let (n, m) = (a.nrows(), b.ncols());
    if c.nrows() != m {
        return Vec::new();
    }
    // Inputs and outputs of the size of the states: rounding is distinguished from zero by it.
    let unit = |m: MatRef<'_, f64>| {
        let norm = m.norm_l2();
        if norm > 0.0 { norm / scale.sqrt() } else { 1.0 }
    };
    let (ub, uc) = (unit(b), unit(c));
    // Right of and beyond all that is of interest, and no round number that a zero might be.
    let shift = 1.618_033 * scale;
    let pencil = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)] - if i == j { shift } else { 0.0 },
        (true, false) => b[(i, j - n)] / ub,
        (false, true) => c[(i - n, j)] / uc,
        (false, false) => d[(i - n, j - n)] / (ub * uc),
    });
    let right = Mat::from_fn(n + m, n, |i, j| if i == j { 1.0 } else { 0.0 });
    // Only the first n columns of (P − σE)⁻¹E are not zero: its upper left block has all μ ≠ 0.
    let solved = solve(pencil.as_ref(), right.as_ref());
    let Ok(values) = eigenvalues(solved.get(..n, ..)) else {
        return Vec::new();
    };
    values
        .into_iter()
        .filter_map(|(re, im)| {
            let square = re * re + im * im;
            let z = (shift + re / square, -im / square);
            if square * scale * scale > 1.0 / (FAR * FAR) && z.0.is_finite() && z.1.is_finite() {
                Some(z)
            } else {
                None
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f64]) -> Mat<f64> {
        Mat::from_fn(1, values.len(), |_, j| values[j])
    }

    /// The companion form of b(z)/a(z), a monic.
    fn companion(a: &[f64], b: &[f64], d: f64) -> StateSpace {
        let n = a.len();
        StateSpace {
            a: Mat::from_fn(n, n, |i, j| match i {
                0 => -a[j],
                _ if i == j + 1 => 1.0,
                _ => 0.0,
            }),
            b: Mat::from_fn(n, 1, |i, _| if i == 0 { 1.0 } else { 0.0 }),
            c: row(b),
            d: row(&[d]),
        }
    }

    fn zeros(model: &StateSpace) -> Vec<(f64, f64)> {
        let [a, b, c, d] = [&model.a, &model.b, &model.c, &model.d].map(|m| m.as_ref());
        let mut zeros = transmission_zeros(a, b, c, d, 1.0);
        zeros.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        zeros
    }

    fn near(got: &[(f64, f64)], expected: &[(f64, f64)]) {
        assert_eq!(got.len(), expected.len(), "{got:?}");
        for (g, e) in got.iter().zip(expected) {
            assert!((g.0 - e.0).hypot(g.1 - e.1) < 1e-6, "{got:?}");
        }
    }

    #[test]
    fn zeros_are_the_roots_of_the_numerator() {
        // a = (z − 0.5)(z² − 1.2 z + 0.72), b of every degree, with and without feedthrough.
        let a = [-1.7, 1.32, -0.36];
        near(&zeros(&companion(&a, &[0.0, 0.0, 3.0], 0.0)), &[]);
        near(&zeros(&companion(&a, &[0.0, 2.0, -0.6], 0.0)), &[(0.3, 0.0)]);
        // 4(z² − 0.4 z + 0.29), and (z + 2)(z − 0.9).
        near(&zeros(&companion(&a, &[4.0, -1.6, 1.16], 0.0)), &[(0.2, -0.5), (0.2, 0.5)]);
        near(&zeros(&companion(&a, &[1.0, 1.1, -1.8], 0.0)), &[(-2.0, 0.0), (0.9, 0.0)]);
        // d·a + b with d = 1: z³ + …, three zeros at the roots of (z − 0.1)(z² − 0.4 z + 0.29).
        let target = [-0.5, 0.33, -0.029];
        let b: Vec<f64> = target.iter().zip(&a).map(|(t, a)| t - a).collect();
        near(&zeros(&companion(&a, &b, 1.0)), &[(0.1, 0.0), (0.2, -0.5), (0.2, 0.5)]);
    }

    /// Units of input, output and state do not move a zero.
    #[test]
    fn zeros_do_not_depend_on_units() {
        let model = companion(&[-1.7, 1.32, -0.36], &[1.0, 1.1, -1.8], 0.0);
        for k in [1e-9, 1e9] {
            near(&zeros(&model.scaled(&[k], &[1.0 / k])), &zeros(&model));
            near(&zeros(&model.scaled(&[k], &[k])), &zeros(&model));
        }
    }

    #[test]
    fn modes_are_reported_in_continuous_terms() {
        // s = −3 ± 4j rad/s: 5 rad/s, damping 0.6, time constant 1/3 s.
        let (t, r) = (0.04, (-0.12_f64).exp());
        let map = poles_and_zeros(
            &companion(&[-2.0 * r * 0.16_f64.cos(), r * r], &[0.0, 1.0], 0.0),
            None,
            t,
            None,
        );
        let [pair] = map.poles.as_slice() else { panic!("{map:?}") };
        let close = |got: Option<f64>, expected: f64| (got.unwrap() - expected).abs() < 1e-4;
        assert!(close(pair.natural_frequency_hz, 5.0 / std::f64::consts::TAU));
        assert!(close(pair.damping, 0.6) && close(pair.time_constant_s, 1.0 / 3.0));
        // A dead beat has no continuous counterpart, an integrator no time constant.
        let map = poles_and_zeros(&companion(&[-1.0, 0.0], &[0.0, 1.0], 0.0), None, t, None);
        assert!(map.poles.iter().any(|p| p.discrete == [1.0, 0.0] && p.time_constant_s.is_none()));
        assert!(map.poles.iter().any(|p| p.discrete[0].abs() < 1e-6));
    }
}
