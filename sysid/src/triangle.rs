//! R of a tall matrix whose rows come block by block: `R ← R of (R; block)`, so that the rows are
//! never together in memory.

use crate::dense::triangle;
use faer::{Mat, MatRef};

/// Rows gathered before they are reduced; few enough to stay in the cache.
const BLOCK: usize = 256;

/// An upper triangle that absorbs rows.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    columns: usize,
    /// Row by row: the triangle, then the rows gathered since.
    rows: Vec<f64>,
    most: usize,
}

impl Triangle {
    pub(crate) fn new(columns: usize) -> Self {
        let most = (columns + BLOCK.max(2 * columns)) * columns;
        let mut rows = Vec::with_capacity(most);
        rows.resize(columns * columns, 0.0);
        Self { columns, rows, most }
    }

    /// Takes one row.
    pub(crate) fn push(&mut self, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns);
        if self.rows.len() >= self.most {
            self.reduce();
        }
        self.rows.extend_from_slice(row);
    }

    /// Takes the rows of another triangle.
    pub(crate) fn absorb(&mut self, rows: MatRef<'_, f64>) {
        for i in 0..rows.nrows() {
            let row: Vec<f64> = rows.row(i).iter().copied().collect();
            self.push(&row);
        }
    }

    fn reduce(&mut self) {
        let columns = self.columns;
        let height = self.rows.len() / columns;
        let r = triangle(MatRef::from_row_major_slice(&self.rows, height, columns));
        self.rows.clear();
        for i in 0..columns {
            self.rows.extend(r.row(i).iter());
        }
    }

    /// The triangle of all rows, square.
    pub(crate) fn finish(mut self) -> Mat<f64> {
        self.reduce();
        let columns = self.columns;
        Mat::from_fn(columns, columns, |i, j| self.rows[i * columns + j])
    }
}
