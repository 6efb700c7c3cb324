//! Impulse responses of a delayed continuous model under a held input: `ẋ = F x + G u(t − τ)`, `y =
//! H x` in observer form, time in samples. With the whole samples d and the fraction f of τ, Ψ(t) =
//! ∫₀ᵗ e^{Fs} ds, `g_{d+1} = H Ψ(1−f) G`, `g_{d+2+m} = H e^{Fm} e^{F(1−f)} Ψ(1) G`, and zero
//! before. A basis of n columns of G spans the responses of all models with the poles of F.

pub(super) const MOST: usize = 5;
/// The largest order, with an additional lag, and zeros up to whole vectors.
const SIZE: usize = (MOST + 1).next_multiple_of(4);

type Square = [[f64; SIZE]; SIZE];

const ZERO: Square = [[0.0; SIZE]; SIZE];

/// Coefficients a_1 … a_n of the product of s² + e^{p₀} s + e^{p₁} for each pair of parameters, and
/// of s + e^{p} for an odd one.
pub(super) fn polynomial(parameters: &[f64]) -> Vec<f64> {
    let mut a = vec![1.0];
    for pair in parameters.chunks(2) {
        let section: Vec<f64> = std::iter::once(1.0).chain(pair.iter().map(|p| p.exp())).collect();
        let mut product = vec![0.0; a.len() + section.len() - 1];
        for (i, x) in a.iter().enumerate() {
            for (j, y) in section.iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        a = product;
    }
    a.remove(0);
    a
}

/// The coefficients with another root at −p: those of (sⁿ + a_1 sⁿ⁻¹ + …)(s + p).
pub(super) fn with_pole(a: &[f64], p: f64) -> Vec<f64> {
    let before = std::iter::once(1.0).chain(a.iter().copied());
    let own = a.iter().copied().chain([0.0]);
    own.zip(before).map(|(x, b)| x + p * b).collect()
}

/// The basis: column j is the response of `count` samples from sample 1 with G = e_j.
#[inline(always)]
pub(super) fn basis(a: &[f64], delay: f64, count: usize) -> Vec<Vec<f64>> {
    let n = a.len().min(SIZE);
    let mut f = ZERO;
    for i in 0..n {
        f[i][0] = -a[i];
        if i + 1 < n {
            f[i][i + 1] = 1.0;
        }
    }
    let whole = delay.floor().max(0.0);
    let rest = 1.0 - (delay - whole);
    let (e, psi) = exponential(&f, n, 1.0);
    let (e_rest, psi_rest) = if rest == 1.0 { (e, psi) } else { exponential(&f, n, rest) };
    let later = product(&e_rest, &psi, n);
    let mut columns = vec![vec![0.0; count]; n];
    let whole = whole as usize;
    if whole < count {
        for (column, x) in columns.iter_mut().zip(psi_rest[0]) {
            column[whole] = x;
        }
    }
    // H e^{Fm}, a row.
    let mut h = [0.0; SIZE];
    h[0] = 1.0;
    for k in whole + 1..count {
        for (column, x) in columns.iter_mut().zip(row_times(&h, &later, n)) {
            column[k] = x;
        }
        h = row_times(&h, &e, n);
    }
    columns
}

#[inline(always)]
fn row_times(row: &[f64; SIZE], m: &Square, n: usize) -> [f64; SIZE] {
    let mut sums = [0.0; SIZE];
    for (x, row) in row.iter().zip(m).take(n) {
        for j in 0..SIZE {
            sums[j] += x * row[j];
        }
    }
    sums
}

/// e^{Ft} and Ψ(t), by Taylor series on a short time and doubling: Ψ(2t) = (e^{Ft} + I) Ψ(t).
#[inline(always)]
fn exponential(f: &Square, n: usize, t: f64) -> (Square, Square) {
    let norm = t * (0..n).map(|j| (0..n).map(|i| f[i][j].abs()).sum::<f64>()).fold(0.0, f64::max);
    let doublings = if norm > 0.25 { (norm / 0.25).log2().ceil().min(60.0) as i32 } else { 0 };
    let t = t * 0.5_f64.powi(doublings);
    let mut psi = ZERO;
    let mut term = ZERO;
    for (i, row) in term.iter_mut().enumerate().take(n) {
        row[i] = t;
    }
    for k in 1..=12 {
        add(&mut psi, &term);
        term = product(f, &term, n);
        for x in term.as_flattened_mut() {
            *x *= t / f64::from(k + 1);
        }
    }
    let mut e = product(f, &psi, n);
    for (i, row) in e.iter_mut().enumerate().take(n) {
        row[i] += 1.0;
    }
    for _ in 0..doublings {
        let twice = product(&e, &psi, n);
        add(&mut psi, &twice);
        e = product(&e, &e, n);
    }
    (e, psi)
}

#[inline(always)]
fn product(a: &Square, b: &Square, n: usize) -> Square {
    let mut c = ZERO;
    for (row, a) in c.iter_mut().zip(a).take(n) {
        *row = row_times(a, b, n);
    }
    c
}

#[inline(always)]
fn add(to: &mut Square, m: &Square) {
    for (to, x) in to.as_flattened_mut().iter_mut().zip(m.as_flattened()) {
        *to += x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_order_response_is_the_closed_form() {
        // g_k = s(k − τ) − s(k − 1 − τ) with the step response s(t) = 1 − e^{−pt}.
        let p: f64 = 0.3;
        let step = |t: f64| if t > 0.0 { (1.0 - (-p * t).exp()) / p } else { 0.0 };
        for delay in [0.0, 0.25, 1.0, 2.7] {
            let g = &basis(&polynomial(&[p.ln()]), delay, 12)[0];
            for (k, x) in g.iter().enumerate() {
                let t = k as f64 + 1.0 - delay;
                assert!((x - (step(t) - step(t - 1.0))).abs() < 1e-13, "{delay} {k}");
            }
        }
    }

    #[test]
    fn a_third_order_response_sums_to_its_steady_state_gain() {
        // y = x₁, F x + G = 0 at rest: for G = e_3 the gain is 1/a₃.
        let a = polynomial(&[0.8_f64.ln(), 0.3_f64.ln(), 0.9_f64.ln()]);
        let sum: f64 = basis(&a, 1.4, 400)[2].iter().sum();
        assert!((sum * a[2] - 1.0).abs() < 1e-9, "{sum}");
    }
}
