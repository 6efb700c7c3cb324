//! Least squares with shared unknowns and some of each segment's own, such as its initial state:
//! each segment's rows are reduced to an R factor with its own unknowns first; the part below them
//! joins that of the other segments (Golub and Van Loan, 5.2.8, by blocks).

use crate::Error;
use crate::linalg::dense::{RANK_TOLERANCE, least_squares, r_factor, vcat};
use faer::{Mat, MatRef};

pub(crate) struct Elimination {
    shared: usize,
    own: usize,
    /// R factor over (shared, target).
    below: Mat<f64>,
    /// For each segment the rows of its own unknowns over (own, shared, target).
    above: Vec<Mat<f64>>,
}

pub(crate) struct Solution {
    pub(crate) shared: Vec<f64>,
    pub(crate) own: Vec<Vec<f64>>,
    /// Sum of squares that is left of the targets.
    pub(crate) squares: f64,
}

impl Elimination {
    pub(crate) fn new(shared: usize, own: usize) -> Self {
        Self { shared, own, below: Mat::zeros(0, shared + 1), above: Vec::new() }
    }

    /// Accumulates a segment; columns are its own unknowns, the shared ones, the target.
    pub(crate) fn segment(&mut self, rows: MatRef<'_, f64>) {
        let r = r_factor(rows);
        let cut = self.own.min(r.nrows());
        self.above.push(r.get(..cut, ..).to_owned());
        self.rest(r.get(cut.., self.own..));
    }

    /// Accumulates rows without own unknowns; columns are the shared ones and the target.
    pub(crate) fn rest(&mut self, rows: MatRef<'_, f64>) {
        self.below = r_factor(vcat(&[self.below.as_ref(), rows]).as_ref());
    }

    /// Least squares with `damping·‖column‖²` added for each shared unknown.
    pub(crate) fn solve(&self, damping: f64) -> Result<Solution, Error> {
        let (n, own) = (self.shared, self.own);
        let r = self.below.get(.., ..n);
        let shared = if damping > 0.0 {
            let sizes: Vec<f64> = (0..n).map(|j| damping.sqrt() * self.size(j)).collect();
            let ridge = Mat::from_fn(n, n, |i, j| if i == j { sizes[j] } else { 0.0 });
            let a = vcat(&[r, ridge.as_ref()]);
            let b = vcat(&[self.below.get(.., n..), Mat::zeros(n, 1).as_ref()]);
            least_squares(a.as_ref(), b.as_ref(), RANK_TOLERANCE)?
        } else {
            least_squares(r, self.below.get(.., n..), RANK_TOLERANCE)?
        };
        let mut squares = (self.below.get(.., n..) - r * &shared).squared_norm_l2();
        let of_segment = |rows: &Mat<f64>| -> Result<Vec<f64>, Error> {
            let rest = rows.get(.., own + n..) - rows.get(.., own..own + n) * &shared;
            let x = least_squares(rows.get(.., ..own), rest.as_ref(), RANK_TOLERANCE)?;
            squares += (rest - rows.get(.., ..own) * &x).squared_norm_l2();
            Ok((0..own).map(|i| x[(i, 0)]).collect())
        };
        let own = self.above.iter().map(of_segment).collect::<Result<_, _>>()?;
        Ok(Solution { shared: (0..n).map(|i| shared[(i, 0)]).collect(), own, squares })
    }

    /// Length of the column of a shared unknown over all rows accumulated.
    fn size(&self, column: usize) -> f64 {
        let above: f64 =
            self.above.iter().map(|r| r.col(self.own + column).squared_norm_l2()).sum();
        (above + self.below.col(column).squared_norm_l2()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The damping is relative to the columns: another unit of an unknown changes nothing but its number.
    #[test]
    fn damping_is_independent_of_units() {
        let value = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        let solution = |unit: f64| {
            let mut elimination = Elimination::new(2, 1);
            let rows = |from: usize| {
                Mat::from_fn(6, 4, |i, j| value(from + i * 4 + j) * if j == 2 { unit } else { 1.0 })
            };
            elimination.segment(rows(0).as_ref());
            elimination.segment(rows(100).as_ref());
            elimination.solve(0.3).unwrap().shared
        };
        let (one, other) = (solution(1.0), solution(1e4));
        assert!((one[0] - other[0]).abs() < 1e-12 && (one[1] - 1e4 * other[1]).abs() < 1e-9);
        let free = {
            let mut elimination = Elimination::new(1, 0);
            elimination.rest(Mat::from_fn(2, 2, |i, j| [[3.0, 6.0], [4.0, 8.0]][i][j]).as_ref());
            [elimination.solve(0.0).unwrap().shared[0], elimination.solve(1.0).unwrap().shared[0]]
        };
        // Twice the column; with a damping of 1 half of that.
        assert!((free[0] - 2.0).abs() < 1e-12 && (free[1] - 1.0).abs() < 1e-12, "{free:?}");
    }

    #[test]
    fn same_as_one_large_system() {
        // Two segments, two shared unknowns, one of each segment's own.
        let value = |seed: usize| ((seed * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        let rows = |segment: usize| Mat::from_fn(6, 4, |i, j| value(segment * 100 + i * 4 + j));
        let mut elimination = Elimination::new(2, 1);
        let mut large = Mat::zeros(12, 5);
        for s in 0..2 {
            let part = rows(s);
            elimination.segment(part.as_ref());
            for i in 0..6 {
                large[(6 * s + i, s)] = part[(i, 0)];
                for j in 1..4 {
                    large[(6 * s + i, 1 + j)] = part[(i, j)];
                }
            }
        }
        let expected = least_squares(large.get(.., ..4), large.get(.., 4..), 1e-14).unwrap();
        let got = elimination.solve(0.0).unwrap();
        let left = large.get(.., 4..) - large.get(.., ..4) * &expected;
        assert!((got.squares - left.squared_norm_l2()).abs() < 1e-13, "{}", got.squares);
        let got = [got.own[0][0], got.own[1][0], got.shared[0], got.shared[1]];
        for (i, x) in got.iter().enumerate() {
            assert!((x - expected[(i, 0)]).abs() < 1e-13, "{i}: {x} {}", expected[(i, 0)]);
        }
    }
}
