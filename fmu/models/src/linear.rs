//! Exact stepping of linear states by the matrix exponential.
//!
//! `ẋ = F x + G u` with u held over a step h has the solution of eq 9–10,
//! `x(t+h) = e^{Fh} x(t) + ∫₀ʰ e^{Fτ} G dτ · u`. Both matrices are blocks of one exponential of
//! the augmented matrix `[F G; 0 0]·h` (Van Loan 1978), which also yields, with the output's row
//! added, the exact integral of the output. An input that grows by u̇ within the step (first-order
//! hold) is one more row, `d/dt (u, u̇) = (u̇, 0)`: just as exact.

use crate::error::Error;
use crate::quadrature::{NODE, NODES, panels};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Largest column sum of a matrix whose exponential is computed: beyond it the relative error,
/// about the norm times 1e-16, leaves little, and far beyond it the number of squarings overflows.
const LARGEST_NORM: f64 = 1e12;

/// `e^A` of a square matrix, by Padé approximation with scaling and squaring; NaN throughout where
/// a column of A sums to more than 1e12, which no double resolves.
#[must_use]
pub fn exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    let largest = a.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max);
    // `max` ignores NaN, the sum does not.
    if largest <= LARGEST_NORM && a.sum().is_finite() { a.exp() } else { a.map(|_| f64::NAN) }
}

/// Eq 9–10: `(A, B)` of `x⁺ = A x + B u` for `ẋ = F x + G u` with u held for `step` seconds.
///
/// F is n by n, G is n by m; so are A and B.
///
/// # Errors
/// Where the shapes do not fit, an entry is not finite, or the step is not positive.
pub fn discretize(
    f: &DMatrix<f64>,
    g: &DMatrix<f64>,
    step: f64,
) -> Result<(DMatrix<f64>, DMatrix<f64>), Error> {
    let (n, m) = (f.nrows(), g.ncols());
    if f.ncols() != n {
        return Err(Error::Shape { name: "F", got: f.len(), need: n * n });
    }
    if g.nrows() != n {
        return Err(Error::Shape { name: "G", got: g.len(), need: n * m });
    }
    for (matrix, name) in [(f, "F"), (g, "G")] {
        if let Some(&value) = matrix.iter().find(|v| !v.is_finite()) {
            return Err(Error::NotFinite { name, value });
        }
    }
    if !(step > 0.0 && step.is_finite()) {
        return Err(Error::NotPositive { name: "the step", value: step });
    }
    let mut augmented = DMatrix::zeros(n + m, n + m);
    augmented.view_mut((0, 0), (n, n)).copy_from(f);
    augmented.view_mut((0, n), (n, m)).copy_from(g);
    let e = exponential(&(augmented * step));
    Ok((e.view((0, 0), (n, n)).into_owned(), e.view((0, n), (n, m)).into_owned()))
}

/// `ẋ = F x + G u`, `y = H x + D u + offset` (eq 6–7 without noise), one input, one output, in
/// flat row-major storage.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuousModel {
    /// State matrix, n·n entries, row by row.
    pub f: Vec<f64>,
    /// Input matrix, n entries.
    pub g: Vec<f64>,
    /// Output matrix, n entries.
    pub h: Vec<f64>,
    /// Feedthrough.
    pub d: f64,
    /// Constant part of the output.
    pub offset: f64,
}

impl ContinuousModel {
    /// Order n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.g.len()
    }

    /// Largest magnitude of an eigenvalue of F, 1/s.
    #[must_use]
    pub fn fastest_rate(&self) -> f64 {
        let n = self.order();
        let f = DMatrix::from_row_slice(n, n, &self.f);
        f.complex_eigenvalues().iter().map(|l| l.re.hypot(l.im)).fold(0.0, f64::max)
    }

    /// `ẋ_i = F_i x + G_i u`.
    #[must_use]
    pub fn derivative(&self, i: usize, x: &[f64], u: f64) -> f64 {
        let n = self.order();
        let fx: f64 = self.f[i * n..(i + 1) * n].iter().zip(x).map(|(f, x)| f * x).sum();
        fx + self.g[i] * u
    }

    /// The map from `z = (x, u, 1, u̇)` to x after `time` and to the integral of y until then:
    /// n + 1 rows of n + 3 entries, from one exponential of the model augmented by input, constant,
    /// the input's derivative and integral.
    fn propagate(&self, time: f64) -> DMatrix<f64> {
        let n = self.order();
        let mut m = DMatrix::zeros(n + 4, n + 4);
        for i in 0..n {
            for j in 0..n {
                m[(i, j)] = self.f[i * n + j] * time;
            }
            m[(i, n)] = self.g[i] * time;
            m[(n + 3, i)] = self.h[i] * time;
        }
        m[(n + 3, n)] = self.d * time;
        m[(n + 3, n + 1)] = self.offset * time;
        m[(n, n + 2)] = time;
        let e = exponential(&m);
        DMatrix::from_fn(n + 1, n + 3, |i, j| e[(if i < n { i } else { n + 3 }, j)])
    }
}

/// One panel of a step of a [`ContinuousModel`]: the states at its end, and the integral of the
/// output at its end and at the quadrature's nodes, all linear in `z = (x, u, 1, u̇)`.
#[derive(Debug, Clone, PartialEq)]
pub struct StepMap {
    /// The step this is for.
    step: f64,
    /// Panels in the step.
    panels: u64,
    /// Length of a panel, s.
    panel: f64,
    /// Column by column, so that the inner loop runs over outputs: integral at the end, at the
    /// nodes, then the states.
    columns: Vec<f64>,
}

/// Rows of a [`StepMap`] before the states: the integral at the end and at the nodes.
pub const INTEGRALS: usize = 1 + NODES;

impl StepMap {
    /// The map of `model` for a step, in panels of at most `longest` seconds.
    #[must_use]
    pub fn new(model: &ContinuousModel, step: f64, longest: f64) -> Self {
        let n = model.order();
        let (panels, panel) = panels(step, longest);
        let end = model.propagate(panel);
        let nodes = NODE.map(|node| model.propagate(panel * node));
        let mut columns = Vec::with_capacity((INTEGRALS + n) * (n + 3));
        for j in 0..n + 3 {
            columns.push(end[(n, j)]);
            columns.extend(nodes.iter().map(|node| node[(n, j)]));
            columns.extend((0..n).map(|i| end[(i, j)]));
        }
        Self { step, panels, panel, columns }
    }

    /// Panels in the step.
    #[must_use]
    pub fn panels(&self) -> u64 {
        self.panels
    }

    /// Length of a panel, s.
    #[must_use]
    pub fn panel(&self) -> f64 {
        self.panel
    }

    /// Applies the map of one panel to `z`, n + 3 entries, or n + 2 where the input is held; `out`
    /// takes [`INTEGRALS`] + n.
    #[inline]
    pub fn apply(&self, z: &[f64], out: &mut [f64]) {
        // Orders up to 6 with the sum in registers.
        match out.len() {
            6 => self.apply_fixed::<6>(z, out),
            7 => self.apply_fixed::<7>(z, out),
            8 => self.apply_fixed::<8>(z, out),
            9 => self.apply_fixed::<9>(z, out),
            10 => self.apply_fixed::<10>(z, out),
            11 => self.apply_fixed::<11>(z, out),
            _ => {
                out.fill(0.0);
                for (column, z) in self.columns.chunks_exact(out.len()).zip(z) {
                    for (out, entry) in out.iter_mut().zip(column) {
                        *out += entry * z;
                    }
                }
            }
        }
    }

    #[inline]
    fn apply_fixed<const ROWS: usize>(&self, z: &[f64], out: &mut [f64]) {
        let mut sum = [0.0; ROWS];
        for (column, z) in self.columns.as_chunks::<ROWS>().0.iter().zip(z) {
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum += entry * z;
            }
        }
        out.copy_from_slice(&sum);
    }
}

/// The maps of the last few step sizes. Steps are told apart bit by bit: a step that differs by an
/// ulp is another step.
#[derive(Debug, Clone, Default)]
pub struct StepCache {
    maps: Vec<Arc<StepMap>>,
    /// Where the map used last is, and where the next new one goes.
    recent: usize,
    oldest: usize,
}

/// Step sizes remembered.
const CACHED_STEPS: usize = 8;

impl StepCache {
    /// The map for a step, made where it is not remembered.
    #[inline]
    pub fn get(&mut self, model: &ContinuousModel, step: f64, longest: f64) -> &StepMap {
        let hit = self.maps.get(self.recent).is_some_and(|map| map.step == step);
        if !hit {
            self.recent = self.find_or_make(model, step, longest);
        }
        &self.maps[self.recent]
    }

    #[cold]
    fn find_or_make(&mut self, model: &ContinuousModel, step: f64, longest: f64) -> usize {
        if let Some(found) = self.maps.iter().position(|map| map.step == step) {
            return found;
        }
        let map = Arc::new(StepMap::new(model, step, longest));
        if self.maps.len() < CACHED_STEPS {
            self.maps.push(map);
            return self.maps.len() - 1;
        }
        let place = self.oldest;
        self.oldest = (place + 1) % CACHED_STEPS;
        self.maps[place] = map;
        place
    }
}
