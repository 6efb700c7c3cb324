//! Subspace models of one order from every horizon, weighting and realization, stabilised where
//! they are unstable, with B, D and the initial states by least squares on the simulated output:
//! the initial estimates of the refinement. All have equally many parameters, so the one that
//! simulates the estimation data best is taken.

use crate::Error;
use crate::data::DataSet;
use crate::linalg::dense::dot;
use crate::model::StateSpace;
use crate::model::stability::{radius_of_slowest, stable_shift};
use crate::selection::candidate::{Candidate, Stabilised};
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::options::{IdentifyOptions, Method};
use crate::selection::order::{fit, fit_of, sum_of_squares};
use crate::subspace::{
    Factor, Projections, Realization, Subspace, Weighting, eq12, refit_output, shift_realization,
    stable_eq12, subspace,
};
use faer::Mat;
use steerwright_formats::interruption::check;

/// Horizons that are tried where none is given.
const HORIZONS: [usize; 4] = [10, 15, 20, 30];

/// Block rows below which records of several channels make do with fewer columns.
const LEAST_OF_SEVERAL: usize = 6;

/// What initial estimates are fitted to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fitted<'a> {
    pub(crate) data: &'a DataSet,
    /// Number of samples that the data represent.
    pub(crate) samples: usize,
    /// Unit of the data's outputs in that of the factor's.
    pub(crate) output_scale: f64,
    pub(crate) offset: bool,
}

/// The factors of the data at every horizon to be tried, with what does not depend on the order.
pub(crate) struct InitialEstimates<'a> {
    fitted: Fitted<'a>,
    horizons: Vec<Horizon>,
    realizations: Vec<Realization>,
    time_constants: f64,
}

struct Horizon {
    factor: Factor,
    projections: Projections,
    subspaces: Vec<(Weighting, Subspace)>,
}

impl<'a> InitialEstimates<'a> {
    pub(crate) fn new(data: &'a DataSet, options: &IdentifyOptions) -> Result<Self, Error> {
        let horizons = horizons(data, options)?;
        let full = Factor::new(data, horizons.iter().copied().max().unwrap_or(2))?;
        let offset = options.has_output_offset();
        let fitted = Fitted { data, samples: data.samples(), output_scale: 1.0, offset };
        Self::of_factor(&full, horizons, fitted, options)
    }

    pub(crate) fn of_factor(
        factor: &Factor,
        horizons: Vec<usize>,
        fitted: Fitted<'a>,
        options: &IdentifyOptions,
    ) -> Result<Self, Error> {
        let methods = match options.method {
            Some(Method::OpenLoop(method)) => vec![method],
            _ => Weighting::ALL.to_vec(),
        };
        let of = |s: usize| -> Result<Horizon, Error> {
            let factor = factor.with_horizon(s)?;
            let subspaces = methods
                .iter()
                .map(|&m| Ok((m, subspace(&factor, m)?)))
                .collect::<Result<_, Error>>()?;
            Ok(Horizon { projections: Projections::new(&factor)?, factor, subspaces })
        };
        Ok(Self {
            fitted,
            horizons: horizons.into_iter().map(of).collect::<Result<_, _>>()?,
            realizations: options.realization.map_or(Realization::ALL.to_vec(), |r| vec![r]),
            time_constants: options.time_constants,
        })
    }

    pub(crate) fn largest_order(&self) -> usize {
        self.horizons.iter().map(|h| largest_order(&h.factor)).max().unwrap_or(0)
    }

    pub(crate) fn into_factor(self, horizon: usize) -> Option<Factor> {
        self.horizons.into_iter().map(|h| h.factor).find(|f| f.horizon == horizon)
    }

    pub(crate) fn best(&self, order: usize, feedthrough: bool) -> Result<Candidate, Error> {
        let mut all = Vec::new();
        for horizon in self.horizons.iter().filter(|h| largest_order(&h.factor) >= order) {
            for (method, sub) in &horizon.subspaces {
                let of = |r: &Realization| {
                    self.estimate(horizon, (*method, sub), *r, order, feedthrough)
                };
                all.extend(self.realizations.iter().map(of));
            }
        }
        self.least(at_least_one(all.into_iter())?).ok_or_else(|| Error::NotExciting {
            problem: format!(
                "it allows an order of {} at most with the horizons tried, not {order}",
                self.largest_order()
            ),
        })
    }

    /// The one that simulates best. Those whose least squares leave more than the best simulation
    /// need not be run; it may do worse where B is so large that rounding shows.
    fn least(&self, mut initial_estimates: Vec<Candidate>) -> Option<Candidate> {
        initial_estimates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut best: Option<Candidate> = None;
        for mut start in initial_estimates {
            let least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
            if start.cost > least {
                break;
            }
            let cost =
                sum_of_squares(&start.initial_conditions.errors(&start.model, self.fitted.data));
            start.cost = if cost.is_finite() { cost } else { f64::INFINITY };
            if best.is_none() || start.cost < least {
                best = Some(start);
            }
        }
        best
    }

    /// The model that another was made of, with feedthrough or without.
    pub(crate) fn again(
        &self,
        (horizon, method, realization): (usize, Weighting, Realization),
        order: usize,
        feedthrough: bool,
    ) -> Option<Candidate> {
        let horizon = self.horizons.iter().find(|h| h.factor.horizon == horizon)?;
        let (method, sub) = horizon.subspaces.iter().find(|(m, _)| *m == method)?;
        self.estimate(horizon, (*method, sub), realization, order, feedthrough).ok()
    }

    fn estimate(
        &self,
        horizon: &Horizon,
        (method, sub): (Weighting, &Subspace),
        realization: Realization,
        order: usize,
        feedthrough: bool,
    ) -> Result<Candidate, Error> {
        check();
        let Fitted { data, samples, output_scale, offset } = self.fitted;
        let factor = &horizon.factor;
        let (a, c) = match realization {
            Realization::Shift => shift_realization(sub, order, factor.outputs)?,
            Realization::Eq12 => {
                let model = eq12(factor, &horizon.projections, sub, order, feedthrough)?;
                (model.a, model.c)
            }
        };
        let radius = crate::linalg::dense::spectral_radius(a.as_ref());
        let c = Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)] / output_scale);
        let refit = |a: &Mat<f64>| refit_about(a, &c, data, feedthrough, offset);
        let most = radius_of_slowest(samples, self.time_constants);
        let (found, stabilised) = if radius <= most {
            (refit(&a)?, None)
        } else {
            let stable = match realization {
                Realization::Shift => stable_shift(sub.basis.as_ref(), order, factor.outputs, most),
                Realization::Eq12 => stable_eq12(factor, &horizon.projections, sub, order, most)?,
            };
            let found = refit(&stable.ok_or(Error::Numerical { what: "stabilisation" })?)?;
            // About the means, as an output offset may be left out later. Rounding may leave more
            // than no output at all.
            let none: f64 = data.segments().iter().map(|s| dot(s.y.values(), s.y.values())).sum();
            let before = refit_about(&a, &c, data, feedthrough, false);
            let fit_before =
                before.map_or(f64::NEG_INFINITY, |(.., squares)| fit_of(data, squares.min(none)));
            let (model, initial_conditions, _) =
                refit_about(&found.0.a, &c, data, feedthrough, false)?;
            let fit_after = fit(data, &initial_conditions.errors(&model, data));
            let stabilised = Stabilised { radius, fit_before, fit_after };
            (found, if radius >= 1.0 { Some(stabilised) } else { None })
        };
        let (model, initial_conditions, cost) = found;
        let found = (model, initial_conditions);
        let values = &sub.singular_values;
        let new = Candidate::new(method, factor.horizon, values, found, feedthrough, cost);
        Ok(Candidate { realization, stabilised, time_constants: self.time_constants, ..new })
    }
}

/// B, D and initial conditions of the least simulation errors, and the sum of their squares.
pub(crate) fn refit_about(
    a: &Mat<f64>,
    c: &Mat<f64>,
    data: &DataSet,
    feedthrough: bool,
    offset: bool,
) -> Result<(StateSpace, InitialConditions, f64), Error> {
    let refit = refit_output(a.as_ref(), c.as_ref(), data, feedthrough, offset)?;
    let offsets = if offset { Some(refit.offset) } else { None };
    Ok((refit.model, InitialConditions { x0: refit.x0, offsets }, refit.squares))
}

/// Those that are there, or the last error.
pub(crate) fn at_least_one(
    all: impl Iterator<Item = Result<Candidate, Error>>,
) -> Result<Vec<Candidate>, Error> {
    let (mut initial_estimates, mut problem) = (Vec::new(), None);
    for start in all {
        match start {
            Ok(start) => initial_estimates.push(start),
            Err(error) => problem = Some(error),
        }
    }
    match problem {
        Some(error) if initial_estimates.is_empty() => Err(error),
        _ => Ok(initial_estimates),
    }
}

/// The one of least cost, or the last error; `none` where nothing was tried.
pub(crate) fn least_cost(
    all: impl Iterator<Item = Result<Candidate, Error>>,
    none: Error,
) -> Result<Candidate, Error> {
    at_least_one(all)?.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or(none)
}

/// The largest order that the shift of a factor's observability matrix shows.
fn largest_order(factor: &Factor) -> usize {
    (factor.horizon - 1) * factor.outputs
}

/// The horizons that are tried of a factor that is there.
pub(crate) fn horizons_of(factor: &Factor, options: &IdentifyOptions) -> Vec<usize> {
    if let Some(horizon) = options.horizon {
        return vec![horizon];
    }
    let least = options.order.map_or(2, |order| order + 1);
    let fitting = HORIZONS.into_iter().filter(|s| (least..=factor.horizon).contains(s));
    let fitting: Vec<usize> = fitting.collect();
    if fitting.is_empty() { vec![factor.horizon] } else { fitting }
}

fn horizons(data: &DataSet, options: &IdentifyOptions) -> Result<Vec<usize>, Error> {
    if let Some(horizon) = options.horizon {
        return Ok(vec![horizon]);
    }
    // At least twice as many columns as rows, N − 2s + 1 ≥ 4s(nu + ny), in all segments together.
    let (channels, n) = (data.inputs() + data.outputs(), data.samples());
    let mut most = n / (4 * channels + 2);
    // Each block row of p outputs shows p states.
    let least = options.order.map_or(2, |order| order.div_ceil(data.outputs()) + 2);
    if channels > 2 && most < LEAST_OF_SEVERAL.max(least) {
        // Half as many columns more than rows are enough for a few block rows of many channels.
        most = (n / (3 * channels + 2)).min(LEAST_OF_SEVERAL.max(least));
    }
    let mut fitting: Vec<usize> =
        HORIZONS.into_iter().filter(|s| (least..=most).contains(s)).collect();
    if fitting.is_empty() {
        if least > most {
            return Err(Error::too_few(n, (4 * channels + 2) * least, data.sample_time_s()));
        }
        fitting.push(least.max(most.min(10)));
    }
    Ok(fitting)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Yaw rate by road-wheel angle of a car of two states behind a servo, steered to random angles.
    fn drive(noise: f64) -> DataSet {
        let mut seed = 3_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 31)
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let (mut level, mut command, mut wheel, mut x) = (0.0, 0.0, 0.0, [0.0, 0.0]);
        let (mut steering, mut yaw_rate) = (Vec::new(), Vec::new());
        for k in 0..1200 {
            if k % 15 == 0 {
                level = 0.03 * normal();
            }
            command += 0.234 * (level - command);
            steering.push(command);
            yaw_rate.push(x[0] + noise * normal());
            for _ in 0..80 {
                wheel += 0.01 * (command - wheel);
                let slope = [x[1] + 25.0 * wheel - 9.6 * x[0], 180.0 * wheel - 36.0 * x[0]];
                x = [x[0] + 5e-4 * slope[0], x[1] + 5e-4 * slope[1]];
            }
        }
        DataSet::single(0.04, steering, yaw_rate).unwrap()
    }

    /// The one that is taken is the best of all as they are simulated, on a drive with noise and on one
    /// that some orders reproduce to rounding.
    #[test]
    fn no_initial_estimate_simulates_better_than_the_one_taken() {
        for noise in [0.01, 0.0] {
            let data = drive(noise);
            let initial_estimates =
                InitialEstimates::new(&data, &IdentifyOptions::default()).unwrap();
            let rounding = 1e-26 * sum_of_squares(&vec![data.segments()[0].y.clone()]);
            for order in 1..=7 {
                let taken = initial_estimates.best(order, false).unwrap();
                let simulated = |start: &Candidate| {
                    sum_of_squares(&start.initial_conditions.errors(&start.model, &data))
                };
                assert_eq!(taken.cost, simulated(&taken));
                for horizon in HORIZONS {
                    for method in Weighting::ALL {
                        for realization in Realization::ALL {
                            let key = (horizon, method, realization);
                            let Some(other) = initial_estimates.again(key, order, false) else {
                                continue;
                            };
                            let cost = simulated(&other);
                            let least = taken.cost - rounding;
                            assert!(least <= cost, "{noise}, {order}, {key:?}: {cost}, {least}");
                        }
                    }
                }
            }
        }
    }
}
