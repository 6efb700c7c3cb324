//! The plant of named channels: any number of inputs and outputs, on the grid of its sample time.
//!
//! The equations are those of eq 3–5 as the file states them, `x⁺ = A x + B u(k − d) + K e`, `y = C x + D u(k − d) + e`,
//! with u and y about their offsets and a delay of d samples for each input. Nothing is converted: at the grid points
//! `t0 + k·Ts` the outputs are those of the identified model, bit by bit, whatever the communication step. Between them
//! the outputs are held. An input acts as it is when a grid point is left. Before the start every input was at its offset,
//! where the states are zero.

use crate::Error;
use crate::noise::gaussian;
use crate::ticks::Ticks;
use nalgebra::{DMatrix, SymmetricEigen};
use std::collections::VecDeque;
use std::sync::Arc;
use steerwright_formats::{Matrix, MultivariablePlant};

mod saved;

pub use saved::SavedSampledSystem;

/// Most grid points in one step: ten hours at 100 Hz.
const MOST_POINTS: f64 = 3_600_000.0;

/// A system that moves by a [`MultivariablePlant`]. Its clone is its whole state.
#[derive(Debug, Clone)]
pub struct SampledSystem {
    /// The inputs, in the units of their channels.
    pub inputs: Vec<f64>,
    /// Noise relative to the identified; 0 for none. Read at the start.
    pub noise_scale: f64,
    /// Names the noise sequence. Read at the start.
    pub noise_seed: i32,
    plant: Arc<MultivariablePlant>,
    /// A factor F of the innovations' covariance F Fᵀ, ny by ny.
    noise_factor: Arc<DMatrix<f64>>,
    states: Vec<f64>,
    /// Of each input, its deviations at the grid points before the last, the oldest first; as many as its delay has samples.
    past: Vec<VecDeque<f64>>,
    /// The deviations of the inputs at the last grid point.
    latest: Vec<f64>,
    /// The outputs without noise at the last grid point.
    held: Vec<f64>,
    grid: Ticks,
    scale: f64,
    seed: i32,
    drawn: u64,
    /// e of the present grid interval, times the scale.
    innovation: Vec<f64>,
}

impl SampledSystem {
    /// The system of a document that was checked, at rest, with the inputs at their offsets, started.
    #[must_use]
    pub fn new(plant: Arc<MultivariablePlant>) -> Self {
        let p = plant.outputs.len();
        let covariance = DMatrix::from_fn(p, p, |i, j| plant.innovation_covariance.entry(i, j));
        // Not Cholesky's, since the covariance of an output without noise has none.
        let eigen = SymmetricEigen::new(covariance);
        let mut factor = eigen.eigenvectors;
        for (mut column, value) in factor.column_iter_mut().zip(&eigen.eigenvalues) {
            column *= value.max(0.0).sqrt();
        }
        let mut system = Self {
            inputs: plant.inputs.iter().map(|input| input.offset).collect(),
            noise_scale: 0.0,
            noise_seed: 0,
            noise_factor: Arc::new(factor),
            states: vec![0.0; plant.order()],
            past: vec![VecDeque::new(); plant.inputs.len()],
            latest: vec![0.0; plant.inputs.len()],
            held: vec![0.0; p],
            grid: Ticks::new(),
            scale: 0.0,
            seed: 0,
            drawn: 0,
            innovation: vec![0.0; p],
            plant,
        };
        system.start();
        system
    }

    /// The document.
    #[must_use]
    pub fn plant(&self) -> &Arc<MultivariablePlant> {
        &self.plant
    }

    /// Puts the system at rest.
    pub fn start(&mut self) {
        self.states.fill(0.0);
        for (past, delay) in self.past.iter_mut().zip(delays(&self.plant)) {
            *past = std::iter::repeat_n(0.0, delay).collect();
        }
        self.grid = Ticks::new();
        self.scale = self.noise_scale;
        self.seed = self.noise_seed;
        self.drawn = 0;
        self.draw();
        self.read();
    }

    /// An output, in the unit of its channel, with the noise; `None` where there is none of that number, from 0.
    #[must_use]
    pub fn output(&self, index: usize) -> Option<f64> {
        let noise = self.innovation.get(index)?;
        let held = *self.held.get(index)?;
        Some(noise + if self.grid.phase() == 0.0 { self.present_output(index) } else { held })
    }

    /// Advances by `step` (s) with the inputs held.
    ///
    /// # Errors
    /// Where the step is longer than ten hours at 100 Hz in grid points, or a state grows beyond all numbers.
    pub fn step(&mut self, step: f64) -> Result<(), Error> {
        let points = step / self.plant.discrete.sample_time_s;
        if points > MOST_POINTS {
            return Err(Error::TooManyGridPoints { step, points, limit: MOST_POINTS });
        }
        if self.grid.phase() == 0.0 {
            self.read();
        }
        for _ in 0..self.grid.advance(points) {
            self.advance();
            self.read();
        }
        crate::error::diverged(self.states.iter().map(|x| ("a state", *x)))
    }

    /// Takes the inputs and outputs of the grid point that is left.
    fn read(&mut self) {
        for (j, input) in self.plant.inputs.iter().enumerate() {
            self.latest[j] = self.inputs[j] - input.offset;
        }
        for i in 0..self.held.len() {
            self.held[i] = self.present_output(i);
        }
    }

    /// Moves from a grid point to the next.
    fn advance(&mut self) {
        let d = &self.plant.discrete;
        let mut input = Vec::with_capacity(self.latest.len());
        for (past, latest) in self.past.iter_mut().zip(&self.latest) {
            past.push_back(*latest);
            input.push(past.pop_front().unwrap_or(*latest));
        }
        let next: Vec<f64> = (0..self.states.len())
            .map(|i| {
                row_times(&d.a, i, &self.states)
                    + row_times(&d.b, i, &input)
                    + row_times(&d.k, i, &self.innovation)
            })
            .collect();
        self.states = next;
        self.draw();
    }

    /// The output without noise of a grid point, for the present inputs.
    fn present_output(&self, index: usize) -> f64 {
        let d = &self.plant.discrete;
        let deviation = |j: usize| self.inputs[j] - self.plant.inputs[j].offset;
        let delayed = |j: usize| self.past[j].front().copied().unwrap_or_else(|| deviation(j));
        let through: f64 = d.d.0[index].iter().enumerate().map(|(j, d)| d * delayed(j)).sum();
        row_times(&d.c, index, &self.states) + through + self.plant.outputs[index].offset
    }

    /// Draws e of the grid interval that begins.
    fn draw(&mut self) {
        self.innovation = self.innovation_at(self.drawn);
        self.drawn = self.drawn.wrapping_add(1);
    }

    fn innovation_at(&self, index: u64) -> Vec<f64> {
        let p = self.noise_factor.nrows();
        if self.scale == 0.0 {
            return vec![0.0; p];
        }
        let first = index.wrapping_mul(p as u64);
        let normal: Vec<f64> =
            (0..p as u64).map(|i| gaussian(self.seed, first.wrapping_add(i))).collect();
        let rows = self.noise_factor.row_iter();
        rows.map(|row| self.scale * row.iter().zip(&normal).map(|(f, e)| f * e).sum::<f64>())
            .collect()
    }
}

/// Delays of the inputs in samples.
fn delays(plant: &MultivariablePlant) -> impl Iterator<Item = usize> {
    let sample_time = plant.discrete.sample_time_s;
    // Whole numbers of samples, as the document was checked for.
    plant.inputs.iter().map(move |input| (input.delay_s / sample_time).round() as usize)
}

fn row_times(matrix: &Matrix, row: usize, vector: &[f64]) -> f64 {
    matrix.0[row].iter().zip(vector).map(|(entry, x)| entry * x).sum()
}
