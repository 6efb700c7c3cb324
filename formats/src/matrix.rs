//! A matrix in a file: an array of rows.

use serde::{Deserialize, Serialize};

/// Rows of numbers; [`Matrix::columns`] detects rows of different lengths.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Matrix(pub Vec<Vec<f64>>);

impl Matrix {
    /// Builds a matrix from a function of row and column.
    #[must_use]
    pub fn from_fn(rows: usize, columns: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        Self((0..rows).map(|i| (0..columns).map(|j| f(i, j)).collect()).collect())
    }

    /// One column of numbers.
    #[must_use]
    pub fn column(values: &[f64]) -> Self {
        Self(values.iter().map(|v| vec![*v]).collect())
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.0.len()
    }

    /// Number of columns, or `None` if the rows differ in length or there are none.
    #[must_use]
    pub fn columns(&self) -> Option<usize> {
        let first = self.0.first()?.len();
        if self.0.iter().all(|row| row.len() == first) { Some(first) } else { None }
    }

    /// The entry in row `i`, column `j`.
    ///
    /// # Panics
    /// The entry does not exist; documents are checked when they are read.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.0[i][j]
    }

    pub(crate) fn shape_text(&self) -> String {
        match self.columns() {
            Some(columns) => format!("{} by {columns}", self.rows()),
            None => {
                if self.0.is_empty() {
                    "empty".into()
                } else {
                    "ragged".into()
                }
            }
        }
    }
}
