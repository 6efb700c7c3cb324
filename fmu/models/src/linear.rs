//! Exact stepping of linear states by the matrix exponential.
//!
//! `ẋ = F x + G u` with u held over a step h has the solution of eq 9–10; both matrices are blocks of one
//! exponential of the augmented matrix `[F G; 0 0]·h` (Van Loan 1978), which also yields, with the output's
//! row added, the exact integral of the output. An input that grows by u̇ within the step (first-order
//! hold) is one more row, `d/dt (u, u̇) = (u̇, 0)`: just as exact.

use crate::Error;
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

/// `ẋ = F x + G u`, `y = H x + D u + offset` (eq 6–7 without noise), one input, one output; row-major.
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

    /// By one entry j of `z = (x, u, 1, u̇)` at the beginning, the output and its derivative after
    /// `time`, of the states' dependence on that entry.
    fn output_by(&self, j: usize, states: &[f64], time: f64) -> (f64, f64) {
        let n = self.order();
        // u and u̇ for 1 in that entry.
        let (u, slope) = match j.checked_sub(n) {
            Some(0) => (1.0, 0.0),
            Some(2) => (time, 1.0),
            _ => (0.0, 0.0),
        };
        let constant = if j == n + 1 { self.offset } else { 0.0 };
        let value: f64 = self.h.iter().zip(states).map(|(h, x)| h * x).sum();
        let moved = (0..n).map(|i| self.h[i] * self.derivative(i, states, u));
        (value + self.d * u + constant, moved.sum::<f64>() + self.d * slope)
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

/// The integral of the output since a panel's start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integral {
    /// At the quadrature's nodes.
    pub at_nodes: [f64; NODES],
    /// At the panel's end.
    pub end: f64,
}

impl Integral {
    /// For a map that does not match the states, which cannot occur.
    const NONE: Self = Self { at_nodes: [f64::NAN; NODES], end: f64::NAN };
}

/// Rows of a [`StepMap`] besides those of the states.
const INTEGRALS: usize = NODES + 1;

/// Columns of a [`StepMap`] before those of the states: constant, input, the input's derivative.
const DRIVES: usize = 3;

/// One panel of a step of a [`ContinuousModel`]: the states at its end, and the integral of the
/// output at its end and at the quadrature's nodes, all linear in `(1, u, u̇, x)`.
#[derive(Debug, Clone, PartialEq)]
pub struct StepMap {
    /// The step this is for.
    step: f64,
    /// Panels in the step.
    panels: u64,
    /// Length of a panel, s.
    panel: f64,
    /// Column by column, so that the inner loop runs over the rows: the integral at the nodes, the
    /// states, the integral at the end. Pairs that are read together lie in one aligned pair.
    columns: Vec<f64>,
    /// Likewise the output at the nodes, then its derivative.
    outputs: Vec<f64>,
}

/// The output and its derivative at the quadrature's nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// The output.
    pub value: [f64; NODES],
    /// Its derivative by time.
    pub rate: [f64; NODES],
}

impl StepMap {
    /// The map of `model` for a step, in panels of at most `longest` seconds.
    #[must_use]
    pub fn new(model: &ContinuousModel, step: f64, longest: f64) -> Self {
        let n = model.order();
        let (panels, panel) = panels(step, longest);
        let end = model.propagate(panel);
        let nodes = NODE.map(|node| model.propagate(panel * node));
        let mut columns = Vec::with_capacity((INTEGRALS + n) * (DRIVES + n));
        for j in [n + 1, n, n + 2].into_iter().chain(0..n) {
            columns.extend(nodes.iter().map(|node| node[(n, j)]));
            columns.extend((0..=n).map(|i| end[(i, j)]));
        }
        let mut outputs = Vec::with_capacity(2 * NODES * (DRIVES + n));
        for j in [n + 1, n, n + 2].into_iter().chain(0..n) {
            let at_nodes = nodes.iter().zip(NODE).map(|(states, node)| {
                let states: Vec<f64> = (0..n).map(|i| states[(i, j)]).collect();
                model.output_by(j, &states, node * panel)
            });
            let (value, rate): (Vec<f64>, Vec<f64>) = at_nodes.unzip();
            outputs.extend(value.into_iter().chain(rate));
        }
        Self { step, panels, panel, columns, outputs }
    }

    /// The output at the nodes of the panel that begins with these states, under an input that is
    /// `u` and grows by `slope` a second.
    #[must_use]
    pub fn outputs(&self, states: &[f64], u: f64, slope: f64) -> Outputs {
        let mut out = Outputs { value: [0.0; NODES], rate: [0.0; NODES] };
        let (columns, _) = self.outputs.as_chunks::<{ 2 * NODES }>();
        for (column, z) in columns.iter().zip([1.0, u, slope].iter().chain(states)) {
            let (value, rate) = column.split_at(NODES);
            out.value.iter_mut().zip(value).for_each(|(sum, entry)| *sum += entry * z);
            out.rate.iter_mut().zip(rate).for_each(|(sum, entry)| *sum += entry * z);
        }
        out
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

    /// Moves the n states over one panel, under an input that is `u` and grows by `slope` a second.
    #[inline]
    pub fn advance(&self, states: &mut [f64], u: f64, slope: f64) -> Integral {
        // Orders up to 6 in registers, without loops whose length is not known.
        match states.len() {
            1 => self.advance_fixed::<1, { INTEGRALS + 1 }>(states, u, slope),
            2 => self.advance_fixed::<2, { INTEGRALS + 2 }>(states, u, slope),
            3 => self.advance_fixed::<3, { INTEGRALS + 3 }>(states, u, slope),
            4 => self.advance_fixed::<4, { INTEGRALS + 4 }>(states, u, slope),
            5 => self.advance_fixed::<5, { INTEGRALS + 5 }>(states, u, slope),
            6 => self.advance_fixed::<6, { INTEGRALS + 6 }>(states, u, slope),
            _ => self.advance_any(states, u, slope),
        }
    }

    /// `ROWS` is [`INTEGRALS`] + N.
    #[inline]
    fn advance_fixed<const N: usize, const ROWS: usize>(
        &self,
        states: &mut [f64],
        u: f64,
        slope: f64,
    ) -> Integral {
        let (columns, _) = self.columns.as_chunks::<ROWS>();
        let (Some((drives, columns)), Some(states)) =
            (columns.split_first_chunk::<DRIVES>(), states.first_chunk_mut::<N>())
        else {
            return Integral::NONE;
        };
        let Some(columns) = columns.first_chunk::<N>() else { return Integral::NONE };
        let mut sum = drives[0];
        let mut add = |column: &[f64; ROWS], z: f64| {
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum += entry * z;
            }
        };
        add(&drives[1], u);
        if slope != 0.0 {
            add(&drives[2], slope);
        }
        for (column, x) in columns.iter().zip(*states) {
            add(column, x);
        }
        states.copy_from_slice(&sum[NODES..NODES + N]);
        Integral { at_nodes: [sum[0], sum[1], sum[2], sum[3]], end: sum[NODES + N] }
    }

    fn advance_any(&self, states: &mut [f64], u: f64, slope: f64) -> Integral {
        let rows = INTEGRALS + states.len();
        let drives = [1.0, u, slope];
        let mut sum = vec![0.0; rows];
        for (column, z) in self.columns.chunks_exact(rows).zip(drives.iter().chain(&*states)) {
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum += entry * z;
            }
        }
        states.copy_from_slice(&sum[NODES..rows - 1]);
        Integral { at_nodes: [sum[0], sum[1], sum[2], sum[3]], end: sum[rows - 1] }
    }
}

/// The maps of the last few step sizes; steps are compared bit by bit.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The orders that have code of their own, and two that have not.
    #[test]
    fn all_orders_move_alike() {
        for n in 1..=8 {
            let entry = |k: usize| ((k * k + 7 * k + 3) % 11) as f64 - 5.0;
            let model = ContinuousModel {
                f: (0..n * n).map(entry).collect(),
                g: (0..n).map(entry).collect(),
                h: (1..=n).map(entry).collect(),
                d: 0.3,
                offset: 0.02,
            };
            let map = StepMap::new(&model, 0.01, 0.01);
            let start: Vec<f64> = (2..n + 2).map(entry).collect();
            for slope in [0.0, 2.0] {
                let (mut ours, mut expected) = (start.clone(), start.clone());
                let turned = map.advance(&mut ours, 0.7, slope);
                let slow = map.advance_any(&mut expected, 0.7, slope);
                let all = |states: Vec<f64>, integral: Integral| {
                    states.into_iter().chain(integral.at_nodes).chain([integral.end])
                };
                for (a, b) in all(ours, turned).zip(all(expected, slow)) {
                    assert!((a - b).abs() < 1e-14, "order {n}: {a} {b}");
                }
            }
        }
    }
}
