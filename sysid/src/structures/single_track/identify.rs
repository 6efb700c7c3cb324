//! From a drive to a single-track model with its evidence.

use crate::Error;
use crate::linalg::bounded_step::Normal;
use crate::structures::rate_limit;
use crate::structures::single_track::drive::Drive;
use crate::structures::single_track::margin::{Moved, with_margin};
use crate::structures::single_track::model::SingleTrackModel;
use crate::structures::single_track::options::SingleTrackOptions;
use crate::structures::single_track::parameters::{COUNT, Parameter, Scale};
use crate::structures::single_track::prepared::prepare;
use crate::structures::single_track::problem::Problem;
use crate::structures::single_track::rate_limit::rate_limited;
use crate::structures::single_track::search::{result_run, solve};
use crate::structures::single_track::uncertainty::covariance;
use steerwright_formats::{Prior, SimulationFit, VehicleParameter};

/// A parameter whose posterior deviation is this share of its prior's or less is determined by the drive.
const DETERMINED: f64 = 0.5;
/// Standard normal quantile of a two-sided band of 95 %.
const Z975: f64 = 1.959_963_984_540_054;

/// A parameter with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterEstimate {
    /// Which.
    pub parameter: Parameter,
    /// Value in [`Parameter::unit`].
    pub value: f64,
    /// Standard error in that unit; 0 where the parameter is fixed.
    pub standard_error: f64,
    /// Ends of the 95 % band, within the bounds.
    pub band_95: [f64; 2],
    /// Posterior over prior standard deviation: about 1 where the value is that of the prior; 0 where the
    /// parameter is fixed.
    pub posterior_per_prior: f64,
    /// Whether the drive determines it: a ratio of 0.5 or less. A fixed parameter is not determined.
    pub is_determined: bool,
    /// Whether the value is at one of its bounds.
    pub is_at_bound: bool,
    /// The prior that was used.
    pub prior: Prior,
}

/// An identified single-track model with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleTrack {
    /// The model.
    pub model: SingleTrackModel,
    /// Its parameters in the order of [`Parameter::ALL`].
    pub parameters: Vec<ParameterEstimate>,
    /// Covariance of the coordinates ([`Parameter::scale`]), in the order of [`Parameter::ALL`]; zero for
    /// those that are fixed.
    pub covariance: [[f64; COUNT]; COUNT],
    /// Free simulation on the estimation data.
    pub estimation: SimulationFit,
    /// Free simulation on the validation data.
    pub validation: Option<SimulationFit>,
    /// How much less friction the rear axle can have, relative, before the free simulation of estimation or validation
    /// data spins: at most 0.2, in steps of 0.005 near 0, where the model may spin on another drive.
    pub spin_margin: f64,
    /// Deviation of white errors of yaw rate (rad/s), lateral acceleration (m/s²) and lateral velocity
    /// (m/s) with the density that the outputs were weighted by; `None` for those that were not fitted.
    pub noise: [Option<f64>; 3],
    /// Initial estimates that were refined to the end, those that followed the drive without a spin, and
    /// those that reached the result.
    pub initial_estimates: [usize; 3],
}

/// Identifies the single-track model on a drive. Validation data take no part in the estimate of least cost; of the
/// estimates along its band that fit them as well, the one that is farthest from a spin is returned.
///
/// # Errors
/// [`Error`] where drive or options allow no model, or where every model spins. A poor model is no error:
/// the evidence shows it.
pub fn identify_single_track(
    estimation: &Drive,
    validation: Option<&Drive>,
    options: &SingleTrackOptions,
) -> Result<SingleTrack, Error> {
    identify_near(None, estimation, validation, options)
}

/// The same, from another model of the drive instead of the priors.
pub(super) fn identify_near(
    near: Option<&SingleTrackModel>,
    estimation: &Drive,
    validation: Option<&Drive>,
    options: &SingleTrackOptions,
) -> Result<SingleTrack, Error> {
    estimation.check()?;
    validation.map_or(Ok(()), Drive::check)?;
    let has = |signal: fn(&crate::structures::single_track::DriveSegment) -> bool| {
        estimation.segments.iter().all(signal)
    };
    let fits_lateral_acceleration =
        options.fit_lateral_acceleration && has(|s| s.lateral_acceleration_mps2.is_some());
    let fits_lateral_velocity =
        options.fit_lateral_velocity && has(|s| s.lateral_velocity_mps.is_some());
    let mut priors = options.priors(fits_lateral_acceleration)?;
    let mut problem = Problem {
        segments: prepare(estimation),
        sample_time: estimation.sample_time_s,
        priors: std::array::from_fn(|i| Normal::new(Parameter::ALL[i], &priors[i])),
        free: (0..COUNT).filter(|&i| priors[i].standard_deviation > 0.0).collect(),
        fitted: [true, fits_lateral_acceleration, fits_lateral_velocity],
    };
    let near = near.map(|model| problem.with_fixed_parameters(&model.point()));
    let mut found = solve(&problem, near.as_ref())?;
    // One that is stated is not looked for.
    let is_stated = options.priors.iter().any(|(parameter, _)| *parameter == Parameter::RateMax);
    if !is_stated && let Some(limited) = rate_limited(&problem, &found) {
        priors[Parameter::RateMax.index()] = rate_limit::PRIOR;
        (problem, found) = limited;
    }
    let run = result_run(estimation.sample_time_s);
    let covariance = covariance(&problem, &found.point, &found.densities, &found.run)?;
    let validating = validation.map(|drive| Problem {
        segments: prepare(drive),
        fitted: [true, false, false],
        ..problem.clone()
    });
    let drives: Vec<&Problem<'_>> = std::iter::once(&problem).chain(&validating).collect();
    let Moved { point, margin } = with_margin(&drives, &found.point, &covariance, &run, |point| {
        SingleTrackModel::of_point(point).validate(validation.unwrap_or(estimation))
    })?;
    let model = SingleTrackModel::of_point(&point);
    let parameters = Parameter::ALL
        .iter()
        .map(|&parameter| {
            let i = parameter.index();
            let deviation = covariance[i][i].max(0.0).sqrt();
            estimate(parameter, [point[i], found.point[i]], deviation, priors[i])
        })
        .collect();
    Ok(SingleTrack {
        model,
        parameters,
        covariance,
        estimation: model.validate(estimation)?,
        validation: validation.map(|drive| model.validate(drive)).transpose()?,
        spin_margin: margin,
        noise: std::array::from_fn(|i| {
            if problem.fitted[i] {
                Some((found.densities[i] / estimation.sample_time_s).sqrt())
            } else {
                None
            }
        }),
        initial_estimates: found.initial_estimates,
    })
}

/// The result of a coordinate and where its band has its middle, with its standard deviation.
fn estimate(
    parameter: Parameter,
    [coordinate, middle]: [f64; 2],
    deviation: f64,
    prior: Prior,
) -> ParameterEstimate {
    let value = parameter.value(coordinate);
    let end = |z: f64| parameter.value(middle + z * deviation).clamp(prior.min, prior.max);
    let ratio =
        if prior.standard_deviation > 0.0 { deviation / prior.standard_deviation } else { 0.0 };
    // Beyond rounding of the logarithm.
    let near = 1e-9 * (prior.max - prior.min);
    ParameterEstimate {
        parameter,
        // A fixed one as it was stated, not by its logarithm.
        value: if prior.standard_deviation > 0.0 { value } else { prior.mean },
        standard_error: match parameter.scale() {
            Scale::Linear => deviation,
            Scale::Logarithmic => value * deviation,
        },
        band_95: [end(-Z975), end(Z975)],
        posterior_per_prior: ratio,
        is_determined: prior.standard_deviation > 0.0 && ratio <= DETERMINED,
        is_at_bound: value <= prior.min + near || value >= prior.max - near,
        prior,
    }
}

impl SingleTrack {
    /// A parameter with its uncertainty.
    #[must_use]
    pub fn parameter(&self, parameter: Parameter) -> &ParameterEstimate {
        &self.parameters[parameter.index()]
    }

    /// Correlation of two parameters' errors; 0 where one is fixed.
    #[must_use]
    pub fn correlation(&self, a: Parameter, b: Parameter) -> f64 {
        let (i, j) = (a.index(), b.index());
        let product = self.covariance[i][i] * self.covariance[j][j];
        if product > 0.0 { self.covariance[i][j] / product.sqrt() } else { 0.0 }
    }
}

impl From<&ParameterEstimate> for VehicleParameter {
    fn from(p: &ParameterEstimate) -> Self {
        let [coordinate, mean] = [p.value, p.prior.mean].map(|x| p.parameter.coordinate(x));
        let deviation = p.prior.standard_deviation;
        let unit = p.parameter.unit();
        Self {
            name: p.parameter.name().into(),
            unit: if unit == "1" { String::new() } else { unit.into() },
            value: p.value,
            standard_error: p.standard_error,
            band_95: p.band_95,
            is_logarithmic: p.parameter.scale() == Scale::Logarithmic,
            prior: p.prior,
            posterior_per_prior: p.posterior_per_prior,
            moved_deviations: if deviation > 0.0 { (coordinate - mean) / deviation } else { 0.0 },
            is_determined: p.is_determined,
            is_at_bound: p.is_at_bound,
        }
    }
}
