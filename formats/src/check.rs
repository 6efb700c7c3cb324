//! Collects faults with their JSON paths.

use crate::Matrix;

/// Collects the faults of a document.
#[derive(Debug, Default)]
pub struct Checker {
    faults: Vec<(String, String)>,
}

impl Checker {
    /// Notes a fault at `path` unless `ok`.
    pub fn require(&mut self, ok: bool, path: &str, problem: impl FnOnce() -> String) {
        if !ok {
            self.faults.push((path.to_owned(), problem()));
        }
    }

    /// The number must be finite.
    pub fn finite(&mut self, value: f64, path: &str) {
        self.require(value.is_finite(), path, || format!("{value} is not a finite number"));
    }

    /// The number must be finite and above zero.
    pub fn positive(&mut self, value: f64, path: &str) {
        self.require(value.is_finite() && value > 0.0, path, || {
            format!("{value} must be greater than 0")
        });
    }

    /// The number must be finite and not below zero.
    pub fn not_negative(&mut self, value: f64, path: &str) {
        self.require(value.is_finite() && value >= 0.0, path, || {
            format!("{value} must not be negative")
        });
    }

    /// The matrix must have that shape and hold finite numbers.
    pub fn shape(&mut self, matrix: &Matrix, rows: usize, columns: usize, path: &str) {
        self.require(matrix.rows() == rows && matrix.columns() == Some(columns), path, || {
            format!("the matrix is {}, expected {rows} by {columns}", matrix.shape_text())
        });
        for (i, row) in matrix.0.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                self.finite(*value, &format!("{path}[{i}][{j}]"));
            }
        }
    }

    pub(crate) fn into_first(self) -> Option<(String, String)> {
        self.faults.into_iter().next()
    }
}
