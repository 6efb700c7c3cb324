//! The initial conditions of a simulation: the state at the first sample of each segment, and the
//! offset of the outputs.
//!
//! The means that are removed from the data leave a constant in the simulation errors
//! ([`tapered_mean`](crate::data::scaled::tapered_mean)), found along with the initial states
//! wherever a model is evaluated by the errors of its simulation; it then counts as part of the
//! output's mean, for the validation data too. Where it is no more than what the noise would make
//! of it, by BIC, it is left out: an output that drifts would else be followed.

use crate::Error;
use crate::data::DataSet;
use crate::data::dataset::without;
use crate::linalg::dense::{dot, hcat};
use crate::linalg::elimination::{Elimination, Solution};
use crate::model::{StateSpace, free_response, initial_state, memory, simulate};
use crate::selection::noise_model::AutoregressiveNoise;
use crate::selection::order::{Errors, errors};
use faer::Mat;

/// Initial states and output offsets.
#[derive(Debug, Clone)]
pub(crate) struct InitialConditions {
    pub(crate) x0: Vec<Vec<f64>>,
    /// Constant on each output; `None` where the data are to be taken as they are.
    pub(crate) offsets: Option<Vec<f64>>,
}

impl InitialConditions {
    /// Those that make the simulation errors of a model least; with an output offset or without.
    pub(crate) fn new(model: &StateSpace, data: &DataSet, offset: bool) -> Result<Self, Error> {
        if !offset {
            let segments = data.segments().iter();
            let x0 = segments.map(|s| initial_state(model, s.u.as_ref(), s.y.as_ref()));
            return Ok(Self { x0: x0.collect::<Result<_, _>>()?, offsets: None });
        }
        let (n, p) = (model.order(), model.outputs());
        let shown = memory(model);
        let mut elimination = Elimination::new(p, n);
        for s in data.segments() {
            let left = &s.y - simulate(model, s.u.as_ref(), &vec![0.0; n]);
            // Samples after the free response has died out determine the offset alone, by their mean.
            let early = shown.min(s.len());
            let free = free_response(model, early);
            let rest = Mat::from_fn(p * early, p + 1, |r, j| {
                if j == p { left[(r % p, r / p)] } else { f64::from(u8::from(r % p == j)) }
            });
            elimination.segment(hcat(&[free.as_ref(), rest.as_ref()]).as_ref());
            let count = (s.len() - early) as f64;
            if count > 0.0 {
                let mean = |i: usize| left.row(i)[early..].iter().sum::<f64>() / count;
                let late = Mat::from_fn(p, p + 1, |i, j| {
                    let value = if j == p { mean(i) } else { f64::from(u8::from(i == j)) };
                    count.sqrt() * value
                });
                elimination.rest(late.as_ref());
            }
        }
        let Solution { shared, own, .. } = elimination.solve(0.0)?;
        Ok(Self { x0: own, offsets: Some(shared) })
    }

    /// `y − ŷ` of each segment of other data from their own initial conditions, with an offset where
    /// these have one.
    pub(crate) fn errors_on(&self, model: &StateSpace, data: &DataSet) -> Result<Errors, Error> {
        Ok(Self::new(model, data, self.offsets.is_some())?.errors(model, data))
    }

    pub(crate) fn errors(&self, model: &StateSpace, data: &DataSet) -> Errors {
        let mut all = errors(model, &self.x0, data);
        for e in &mut all {
            for (i, offset) in self.offsets.iter().flatten().enumerate() {
                e.row_mut(i).iter_mut().for_each(|e| *e -= offset);
            }
        }
        all
    }

    pub(crate) fn about_output_offset(&self, data: &DataSet) -> Result<DataSet, Error> {
        match &self.offsets {
            Some(offsets) => without(data, offsets),
            None => Ok(data.clone()),
        }
    }
}

/// Whether the offsets in the errors of a model are more than noise.
pub(crate) fn needs_output_offset(model: &StateSpace, data: &DataSet) -> Result<bool, Error> {
    let initial_conditions = InitialConditions::new(model, data, true)?;
    let errors = initial_conditions.errors(model, data);
    let (count, outputs) = (data.samples(), data.outputs());
    let fitted = AutoregressiveNoise::fitted(&errors, AutoregressiveNoise::order(&errors, data));
    let square = |(i, offset): (usize, &f64)| {
        let variance = errors.iter().map(|e| dot(e.row(i), e.row(i))).sum::<f64>() / count as f64;
        fitted.square_of_mean(*offset, variance, count)
    };
    let sum: f64 = initial_conditions.offsets.iter().flatten().enumerate().map(square).sum();
    Ok(sum > outputs as f64 * ((count * outputs) as f64).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// States and offsets of several segments and outputs are those that the data were made with.
    #[test]
    fn states_and_offsets_are_found_together() {
        let model = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.9, 0.3], [-0.3, 0.8]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [1.0, -0.4][i]),
            c: Mat::from_fn(2, 2, |i, j| [[1.0, 0.2], [0.0, 1.0]][i][j]),
            d: Mat::zeros(2, 1),
        };
        let (states, offsets) = ([[1.0, 2.0], [-3.0, 0.5]], [0.7, -40.0]);
        let segments = [(900, &states[0]), (40, &states[1])].map(|(count, x0)| {
            let u = Mat::from_fn(1, count, |_, t| (0.3 * (t * t) as f64).sin());
            let y = simulate(&model, u.as_ref(), x0);
            let y = Mat::from_fn(2, count, |i, t| y[(i, t)] + offsets[i]);
            crate::data::Segment::new(&u, y)
        });
        let data = DataSet::new(1.0, segments.to_vec()).unwrap();
        let found = InitialConditions::new(&model, &data, true).unwrap();
        for (got, expected) in found.x0.iter().zip(&states) {
            assert!(got.iter().zip(expected).all(|(g, e)| (g - e).abs() < 1e-9), "{found:?}");
        }
        let got = found.offsets.clone().unwrap();
        assert!(got.iter().zip(offsets).all(|(g, e)| (g - e).abs() < 1e-9), "{got:?}");
        let largest = |errors: &Errors| {
            errors.iter().flat_map(|e| e.values()).fold(0.0_f64, |m, e| m.max(e.abs()))
        };
        assert!(largest(&found.errors(&model, &data)) < 1e-9);
        let centred = found.about_output_offset(&data).unwrap();
        assert!(largest(&errors(&model, &found.x0, &centred)) < 1e-9);
    }
}
