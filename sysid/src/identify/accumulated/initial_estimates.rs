//! Subspace models of one order from the R factor: the initial estimates of the refinement.
//!
//! As the [initial estimates](crate::identify) of a log, with the windows in place of the log's own
//! samples.

use crate::Error;
use crate::identify::accumulated::windows::Windows;
use crate::model::StateSpace;
use crate::model::stability::{largest_radius, stable_shift};
use crate::selection::method::Method;
use crate::selection::options::IdentifyOptions;
use crate::subspace::{
    Factor, Projections, Realization, Subspace, Weighting, closed_loop, eq12, refit_output,
    shift_realization, stable_eq12, subspace,
};
use faer::Mat;

/// Horizons that are tried where none is given.
const HORIZONS: [usize; 4] = [10, 15, 20, 30];

/// A stable model in the units of the windows.
#[derive(Debug, Clone)]
pub(crate) struct InitialEstimate {
    pub(crate) method: Method,
    pub(crate) realization: Realization,
    pub(crate) horizon: usize,
    pub(crate) singular_value: f64,
    pub(crate) model: StateSpace,
    /// State at the beginning of each window; none of a model from a loop.
    pub(crate) x0s: Vec<Vec<f64>>,
    pub(crate) stabilised_from: Option<f64>,
}

/// Decompositions of the factor of which models of all orders are read.
pub(crate) enum InitialEstimates {
    /// By the open-loop methods at every horizon.
    OpenLoop(Vec<Horizon>),
    /// By predictor-based methods, with their past horizon.
    ClosedLoop(usize, Vec<(closed_loop::ClosedLoopMethod, closed_loop::Decomposition)>),
}

/// A horizon with what does not depend on the order.
pub(crate) struct Horizon {
    factor: Factor,
    projections: Projections,
    subspaces: Vec<(Weighting, Subspace)>,
}

impl InitialEstimates {
    pub(crate) fn open_loop(factor: &Factor, options: &IdentifyOptions) -> Result<Self, Error> {
        let least = options.order.map_or(2, |order| order + 1);
        let mut horizons: Vec<usize> = match options.horizon {
            Some(horizon) => vec![horizon],
            None => HORIZONS.into_iter().filter(|s| (least..=factor.horizon).contains(s)).collect(),
        };
        if horizons.is_empty() {
            horizons.push(factor.horizon);
        }
        let methods = match options.method {
            Some(Method::OpenLoop(method)) => vec![method],
            _ => Weighting::ALL.to_vec(),
        };
        let of = |s: usize| -> Result<Horizon, Error> {
            let factor = factor.with_horizon(s)?;
            let subspaces = methods.iter().map(|&m| Ok((m, subspace(&factor, m)?)));
            let subspaces = subspaces.collect::<Result<_, Error>>()?;
            Ok(Horizon { projections: Projections::new(&factor)?, factor, subspaces })
        };
        Ok(Self::OpenLoop(horizons.into_iter().map(of).collect::<Result<_, _>>()?))
    }

    pub(crate) fn closed_loop(
        factor: &Factor,
        methods: &[closed_loop::ClosedLoopMethod],
        past: usize,
        future: usize,
    ) -> Result<Self, Error> {
        let of = |&m: &closed_loop::ClosedLoopMethod| {
            Ok((m, closed_loop::decompose(factor, m, past, future, false)?))
        };
        Ok(Self::ClosedLoop(past, methods.iter().map(of).collect::<Result<_, Error>>()?))
    }

    /// Largest order that some decomposition allows.
    pub(crate) fn largest_order(&self) -> usize {
        let of_each: Vec<usize> = match self {
            Self::OpenLoop(horizons) => horizons.iter().map(|h| h.factor.horizon - 1).collect(),
            Self::ClosedLoop(_, states) => states.iter().map(|(_, d)| d.largest_order()).collect(),
        };
        of_each.into_iter().max().unwrap_or(0)
    }

    /// The models of an order; `feedthrough` is for those of open loop.
    pub(crate) fn of_order(
        &self,
        windows: &Windows,
        order: usize,
        feedthrough: bool,
        samples: usize,
    ) -> Result<Vec<InitialEstimate>, Error> {
        let most = largest_radius(samples);
        let mut initial_estimates = Vec::new();
        let mut last_error =
            Error::NoModel { problem: format!("no horizon allows an order of {order}") };
        let mut add = |start: Result<InitialEstimate, Error>| match start {
            Ok(start) => initial_estimates.push(start),
            Err(error) => last_error = error,
        };
        match self {
            Self::OpenLoop(horizons) => {
                for horizon in horizons.iter().filter(|h| h.factor.horizon > order) {
                    for (method, subspace) in &horizon.subspaces {
                        for realization in Realization::ALL {
                            let what = (*method, subspace, realization);
                            add(horizon.estimate(windows, what, order, feedthrough, most));
                        }
                    }
                }
            }
            Self::ClosedLoop(past, states) => {
                for (method, states) in states.iter().filter(|(_, d)| d.largest_order() >= order) {
                    add(of_states(*method, *past, states, windows, order, most));
                }
            }
        }
        if initial_estimates.is_empty() { Err(last_error) } else { Ok(initial_estimates) }
    }
}

impl Horizon {
    fn estimate(
        &self,
        windows: &Windows,
        (method, subspace, realization): (Weighting, &Subspace, Realization),
        order: usize,
        feedthrough: bool,
        most: f64,
    ) -> Result<InitialEstimate, Error> {
        let factor = &self.factor;
        let (mut a, c) = match realization {
            Realization::Shift => shift_realization(subspace, order, 1)?,
            Realization::Eq12 => {
                let model = eq12(factor, &self.projections, subspace, order, feedthrough)?;
                (model.a, model.c)
            }
        };
        let radius = crate::linalg::dense::spectral_radius(a.as_ref());
        if radius > most || radius.is_nan() {
            let stable = match realization {
                Realization::Shift => stable_shift(subspace.basis.as_ref(), order, 1, most),
                Realization::Eq12 => stable_eq12(factor, &self.projections, subspace, order, most)?,
            };
            a = stable.ok_or(Error::Numerical { what: "stabilisation" })?;
        }
        let c = Mat::from_fn(1, order, |_, k| c[(0, k)] / windows.scales[1]);
        let refit = refit_output(a.as_ref(), c.as_ref(), &windows.data, feedthrough, false)?;
        Ok(InitialEstimate {
            method: method.into(),
            realization,
            horizon: factor.horizon,
            singular_value: subspace.singular_values[order - 1],
            model: refit.model,
            x0s: refit.x0,
            stabilised_from: (radius >= 1.0).then_some(radius),
        })
    }
}

fn of_states(
    method: closed_loop::ClosedLoopMethod,
    past: usize,
    states: &closed_loop::Decomposition,
    windows: &Windows,
    order: usize,
    most: f64,
) -> Result<InitialEstimate, Error> {
    let [u, y] = windows.scales;
    Ok(InitialEstimate {
        method: method.into(),
        realization: Realization::Eq12,
        horizon: past,
        singular_value: states.singular_values[order - 1],
        model: states.stable_model(order, most)?.model.scaled(&[1.0 / u], &[1.0 / y]),
        x0s: Vec::new(),
        stabilised_from: None,
    })
}
