//! Symmetric positive definite systems in which an unknown meets its two neighbours to either side, on a line or on a ring.
//!
//! On a line it is the LDLᵀ factorisation of a pentadiagonal matrix. On a ring the last two unknowns are solved for last, by
//! the Schur complement of the others.

/// The diagonal and the two above it: `entries[i][k]` is that of i and i + k, around the ring where it is one.
#[derive(Debug, Clone)]
pub(super) struct Pentadiagonal {
    pub(super) entries: Vec<[f64; 3]>,
    is_ring: bool,
}

/// Smallest pivot over the diagonal that is taken for positive.
const LEAST_PIVOT: f64 = 1e-14;

impl Pentadiagonal {
    /// Of zeros, with at least five unknowns.
    pub(super) fn zeros(count: usize, is_ring: bool) -> Self {
        Self { entries: vec![[0.0; 3]; count], is_ring }
    }

    /// Adds to the entry of two unknowns and, where they differ, to the one that mirrors it.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let count = self.entries.len();
        let (low, high) = (i.min(j), i.max(j));
        let apart = high - low;
        if apart <= 2 {
            self.entries[low][apart] += value;
        } else if self.is_ring && count - apart <= 2 {
            self.entries[high][count - apart] += value;
        }
    }

    /// The solution; `None` where the matrix is not positive definite.
    pub(super) fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        if !self.is_ring {
            let mut solution = right.to_vec();
            Factor::new(&self.entries)?.solve(&mut solution);
            return Some(solution);
        }
        let count = self.entries.len();
        let inner = count - 2;
        let e = &self.entries;
        let factor = Factor::new(&e[..inner])?;
        // The columns of the last two unknowns, above them and around the ring.
        let mut columns = [vec![0.0; inner], vec![0.0; inner]];
        columns[0][inner - 2] = e[inner - 2][2];
        columns[0][inner - 1] = e[inner - 1][1];
        columns[0][0] = e[inner][2];
        columns[1][inner - 1] = e[inner - 1][2];
        columns[1][0] += e[inner + 1][1];
        columns[1][1] += e[inner + 1][2];
        let mut solved = columns.clone();
        solved.iter_mut().for_each(|column| factor.solve(column));
        let mut solution = right[..inner].to_vec();
        factor.solve(&mut solution);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let s00 = e[inner][0] - dot(&columns[0], &solved[0]);
        let s01 = e[inner][1] - dot(&columns[0], &solved[1]);
        let s11 = e[inner + 1][0] - dot(&columns[1], &solved[1]);
        let determinant = s00 * s11 - s01 * s01;
        if !(s00 > LEAST_PIVOT * e[inner][0] && determinant > LEAST_PIVOT * s00 * s11) {
            return None;
        }
        let r0 = right[inner] - dot(&columns[0], &solution);
        let r1 = right[inner + 1] - dot(&columns[1], &solution);
        let last = [(s11 * r0 - s01 * r1) / determinant, (s00 * r1 - s01 * r0) / determinant];
        for (i, value) in solution.iter_mut().enumerate() {
            *value -= solved[0][i] * last[0] + solved[1][i] * last[1];
        }
        solution.extend(last);
        Some(solution)
    }
}

/// L without its diagonal of ones, and D.
struct Factor {
    pivots: Vec<f64>,
    lower: Vec<[f64; 2]>,
}

impl Factor {
    fn new(entries: &[[f64; 3]]) -> Option<Self> {
        let count = entries.len();
        let (mut pivots, mut lower) = (Vec::with_capacity(count), vec![[0.0; 2]; count]);
        for i in 0..count {
            let mut pivot = entries[i][0];
            let mut next = entries[i][1];
            if i >= 1 {
                pivot -= lower[i - 1][0] * lower[i - 1][0] * pivots[i - 1];
                next -= lower[i - 1][0] * lower[i - 1][1] * pivots[i - 1];
            }
            if i >= 2 {
                pivot -= lower[i - 2][1] * lower[i - 2][1] * pivots[i - 2];
            }
            if !(pivot > LEAST_PIVOT * entries[i][0] && pivot.is_finite()) {
                return None;
            }
            lower[i] = [next / pivot, entries[i][2] / pivot];
            pivots.push(pivot);
        }
        Some(Self { pivots, lower })
    }

    fn solve(&self, x: &mut [f64]) {
        let count = x.len();
        for i in 0..count {
            if i >= 1 {
                x[i] -= self.lower[i - 1][0] * x[i - 1];
            }
            if i >= 2 {
                x[i] -= self.lower[i - 2][1] * x[i - 2];
            }
        }
        for i in (0..count).rev() {
            x[i] /= self.pivots[i];
            if i + 1 < count {
                x[i] -= self.lower[i][0] * x[i + 1];
            }
            if i + 2 < count {
                x[i] -= self.lower[i][1] * x[i + 2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// A line and a ring of some sizes, compared with a dense solution.
    #[test]
    fn solutions_are_those_of_the_dense_matrix() {
        for (count, is_ring) in [(5, false), (6, true), (7, true), (40, false), (41, true)] {
            let mut banded = Pentadiagonal::zeros(count, is_ring);
            let mut dense = DMatrix::zeros(count, count);
            let right: Vec<f64> = (0..count).map(|i| (1.7 * i as f64).sin()).collect();
            for i in 0..count {
                for apart in 0..=2 {
                    let j = (i + apart) % count;
                    if !is_ring && i + apart >= count {
                        continue;
                    }
                    let diagonal = if apart == 0 { 4.0 } else { 0.0 };
                    let value = diagonal + (0.9 * (3 * i + 5 * apart) as f64).sin();
                    banded.add(i, j, value);
                    dense[(i, j)] += value;
                    if apart > 0 {
                        dense[(j, i)] += value;
                    }
                }
            }
            let expected = dense.lu().solve(&DVector::from_column_slice(&right)).unwrap();
            let solution = banded.solve(&right).unwrap();
            for (a, b) in solution.iter().zip(expected.iter()) {
                assert!((a - b).abs() < 1e-12, "{count} {is_ring}: {a} {b}");
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_rejected() {
        for is_ring in [false, true] {
            let mut banded = Pentadiagonal::zeros(9, is_ring);
            (0..9).for_each(|i| banded.add(i, i, if i == 8 { -1.0 } else { 1.0 }));
            assert_eq!(banded.solve(&[1.0; 9]), None);
        }
    }
}
