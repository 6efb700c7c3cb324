//! Matrices: helpers over faer, R factors of many rows, elimination of what only one segment has, and
//! nonlinear least squares.

pub(crate) mod blocks;
pub(crate) mod bounded_step;
pub(crate) mod columns;
pub(crate) mod dense;
pub(crate) mod dual;
pub(crate) mod elimination;
pub(crate) mod levenberg_marquardt;
pub(crate) mod r_factor;
pub(crate) mod sandwich;
