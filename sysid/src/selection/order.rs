//! How many states the data require: by BIC (G. Schwarz, *Estimating the dimension of a model*,
//! Annals of Statistics 6, 1978), `N·Σ_i ln V_i + d·ln(N·ny)` with V_i the mean squared error of
//! output i and d the number of parameters. It takes the errors for independent over time, so it is
//! applied to the errors of one-step prediction by plant and noise model together
//! ([`search`](crate::selection::search)).

use crate::data::{DataSet, Signals};
use crate::linalg::dense::dot;
use crate::model::{StateSpace, simulate};

/// Errors of the simulation, ny by N of each segment.
pub(crate) type Errors = Vec<Signals>;

/// `y − ŷ` of each segment from its initial state.
pub(crate) fn errors(model: &StateSpace, x0: &[Vec<f64>], data: &DataSet) -> Errors {
    let segments = data.segments().iter().zip(x0);
    segments.map(|(s, x0)| &s.y - simulate(model, s.u.as_ref(), x0)).collect()
}

pub(crate) fn sum_of_squares(errors: &Errors) -> f64 {
    errors.iter().map(|e| squares(e.values())).sum()
}

fn squares(x: &[f64]) -> f64 {
    dot(x, x)
}

/// Errors of a smaller share of an output of unit spread are rounding.
const ROUNDING: f64 = 1e-8;

/// Σ_i ln V_i over the outputs, which are of unit spread; ∞ where an error is not finite.
pub(crate) fn log_square(errors: &Errors) -> f64 {
    let outputs = errors.first().map_or(0, Signals::nrows);
    let samples: usize = errors.iter().map(Signals::ncols).sum();
    (0..outputs)
        .map(|i| {
            let sum: f64 = errors.iter().map(|e| squares(e.row(i))).sum();
            if sum.is_finite() {
                (sum / samples.max(1) as f64).max(ROUNDING * ROUNDING).ln()
            } else {
                f64::INFINITY
            }
        })
        .sum()
}

/// Parameters of a model up to the basis of its state: n(nu + ny), and nu·ny of D.
pub(crate) fn parameters(order: usize, inputs: usize, outputs: usize, feedthrough: bool) -> usize {
    order * (inputs + outputs) + if feedthrough { inputs * outputs } else { 0 }
}

/// BIC (Schwarz's criterion) for `log_square` = Σ_i ln V_i from so many samples.
pub(crate) fn bic(log_square: f64, outputs: usize, parameters: usize, samples: f64) -> f64 {
    samples * log_square + parameters as f64 * (samples * outputs as f64).max(2.0).ln()
}

/// Weights of models by BIC and number of parameters: `exp(−Δ/2)` over the sum of all, Δ the difference of a criterion in
/// which a parameter costs so much less.
pub(crate) fn weights(models: &[(f64, usize)], less: f64) -> Vec<f64> {
    let criterion = |&(bic, parameters): &(f64, usize)| bic - less * parameters as f64;
    let least = models.iter().map(criterion).fold(f64::INFINITY, f64::min);
    let likelihood = |model| (-0.5 * (criterion(model) - least)).exp();
    let likelihoods: Vec<f64> = models.iter().map(likelihood).collect();
    let sum: f64 = likelihoods.iter().filter(|w| w.is_finite()).sum();
    likelihoods.iter().map(|w| w / sum).collect()
}

/// A difference of the criterion that is no strong evidence (Kass and Raftery 1995).
pub(crate) const AS_LIKELY: f64 = 6.0;

/// Of (criterion, has a real logarithm) the least, or one about as likely that has one.
pub(crate) fn likeliest(models: &[(f64, bool)]) -> usize {
    let least = |of: &dyn Fn(&(f64, bool)) -> bool| {
        let some = (0..models.len()).filter(|i| of(&models[*i]));
        some.min_by(|a, b| models[*a].0.total_cmp(&models[*b].0))
    };
    let best = least(&|_| true).unwrap_or(0);
    let Some(most) = models.get(best).map(|m| m.0 + AS_LIKELY) else { return best };
    least(&|(criterion, has_logarithm)| *has_logarithm && *criterion <= most).unwrap_or(best)
}

/// The model of a vehicle, which has two states: order 1 is kept only where order 2 explains no
/// more than chance by Akaike's criterion. Models are (order, criterion, has a real logarithm).
pub(crate) fn of_a_vehicle(chosen: usize, models: &[(usize, f64, bool)], samples: f64) -> usize {
    let order = |n: usize| models.iter().position(|m| m.0 == n && m.2);
    let (1, Some(second)) = (models[chosen].0, order(2)) else { return chosen };
    let more = parameters(2, 1, 1, false) - parameters(1, 1, 1, false);
    let fallen = more as f64 * samples.max(2.0).ln() - (models[second].1 - models[chosen].1);
    if fallen > 2.0 * more as f64 { second } else { chosen }
}

/// `100·(1 − ‖Y − Ŷ‖/‖Y − mean(Y)‖)` over all outputs; −∞ where an error is not finite.
pub(crate) fn fit(data: &DataSet, errors: &Errors) -> f64 {
    fit_of(data, sum_of_squares(errors))
}

/// [`fit`] of errors by their sum of squares.
pub(crate) fn fit_of(data: &DataSet, squares: f64) -> f64 {
    let n = data.samples() as f64;
    let spread: f64 = (0..data.outputs())
        .map(|i| {
            let rows = || data.segments().iter().flat_map(|s| s.y.row(i).iter());
            let m = rows().sum::<f64>() / n;
            rows().map(|y| (y - m) * (y - m)).sum::<f64>()
        })
        .sum();
    if !squares.is_finite() || spread <= 0.0 {
        return f64::NEG_INFINITY;
    }
    100.0 * (1.0 - (squares / spread).sqrt())
}

#[cfg(test)]
mod tests {
    use super::weights;

    /// Of 1,000 samples two more parameters cost 13.8 by BIC, and 4 by Akaike's criterion.
    #[test]
    fn a_larger_order_that_bic_refuses_keeps_its_weight() {
        let less = 1000_f64.ln() - 2.0;
        let models = [(0.0, 2), (2.0 * less, 4), (60.0, 6)];
        let akaike = weights(&models, less);
        assert!((akaike[0] - 0.5).abs() < 1e-9 && (akaike[1] - 0.5).abs() < 1e-9, "{akaike:?}");
        assert!(akaike[2] < 1e-9);
        assert!(weights(&models, 0.0)[1] < 0.01);
        // One without a finite criterion counts for nothing.
        assert_eq!(weights(&[(0.0, 2), (f64::INFINITY, 4)], less), [1.0, 0.0]);
    }
}
