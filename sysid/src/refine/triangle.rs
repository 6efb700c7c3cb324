//! R of a tall matrix whose rows come block by block: `R ← R of (R; block)`, so that the rows are
//! never together in memory.

use crate::dense::triangle;
use faer::{Mat, MatRef};

/// Rows gathered before they are reduced; few enough to stay in the cache.
const BLOCK: usize = 256;

/// An upper triangle that absorbs rows.
#[derive(Debug, Clone)]
pub(super) struct Triangle {
    /// The triangle above, the rows gathered since below.
    stack: Mat<f64>,
    gathered: usize,
}

impl Triangle {
    pub(super) fn new(columns: usize) -> Self {
        Self { stack: Mat::zeros(columns + BLOCK.max(2 * columns), columns), gathered: 0 }
    }

    /// Takes one row, zero beyond its length.
    pub(super) fn push(&mut self, row: &[f64]) {
        let columns = self.stack.ncols();
        if columns + self.gathered == self.stack.nrows() {
            self.reduce();
        }
        let at = columns + self.gathered;
        for (j, value) in row.iter().enumerate() {
            self.stack[(at, j)] = *value;
        }
        self.gathered += 1;
    }

    /// Takes the rows of another triangle.
    pub(super) fn absorb(&mut self, rows: MatRef<'_, f64>) {
        for i in 0..rows.nrows() {
            let row: Vec<f64> = rows.row(i).iter().copied().collect();
            self.push(&row);
        }
    }

    fn reduce(&mut self) {
        let columns = self.stack.ncols();
        let r = triangle(self.stack.get(..columns + self.gathered, ..));
        self.stack.get_mut(..columns, ..).copy_from(&r);
        self.gathered = 0;
    }

    /// The triangle of all rows, square.
    pub(super) fn finish(mut self) -> Mat<f64> {
        self.reduce();
        let columns = self.stack.ncols();
        self.stack.get(..columns, ..).to_owned()
    }
}
