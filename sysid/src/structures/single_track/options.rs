//! How a single-track model is identified.

use crate::Error;
use crate::structures::single_track::parameters::{COUNT, Parameter};
use steerwright_formats::Prior;

/// Options of [`identify_single_track`](crate::structures::single_track::identify_single_track).
#[derive(Debug, Clone, PartialEq)]
pub struct SingleTrackOptions {
    /// Wheelbase, m. Stated, the steering ratio is identified in its place.
    pub wheelbase_m: Option<f64>,
    /// Priors that replace [`Parameter::default_prior`].
    pub priors: Vec<(Parameter, Prior)>,
    /// Whether the lateral acceleration of the drive, if it has one, is fitted too. Otherwise the simulated one is
    /// only compared with it.
    pub fit_lateral_acceleration: bool,
    /// Whether the lateral velocity of the drive is fitted too. Otherwise the simulated one is only
    /// compared with it.
    pub fit_lateral_velocity: bool,
}

impl Default for SingleTrackOptions {
    fn default() -> Self {
        Self {
            wheelbase_m: None,
            priors: Vec::new(),
            fit_lateral_acceleration: true,
            fit_lateral_velocity: false,
        }
    }
}

impl SingleTrackOptions {
    /// The priors of all parameters; those of zero deviation are fixed.
    pub(super) fn priors(&self, fits_lateral_acceleration: bool) -> Result<[Prior; COUNT], Error> {
        let mut all = Parameter::ALL.map(Parameter::default_prior);
        let fixed =
            |value: f64, prior: Prior| Prior { mean: value, standard_deviation: 0.0, ..prior };
        match self.wheelbase_m {
            Some(wheelbase) => {
                let prior = &mut all[Parameter::Wheelbase.index()];
                *prior = fixed(wheelbase, *prior);
            }
            None => {
                let prior = &mut all[Parameter::SteeringFactor.index()];
                *prior = fixed(1.0, *prior);
            }
        }
        if !fits_lateral_acceleration {
            for parameter in
                [Parameter::LateralAccelerationOffset, Parameter::AccelerometerPosition]
            {
                let prior = &mut all[parameter.index()];
                *prior = fixed(0.0, *prior);
            }
        }
        for (parameter, prior) in &self.priors {
            all[parameter.index()] = *prior;
        }
        for (parameter, prior) in Parameter::ALL.iter().zip(&all) {
            let ordered = prior.min <= prior.mean && prior.mean <= prior.max;
            let finite = prior.min.is_finite() && prior.max.is_finite();
            if !(ordered && finite && prior.standard_deviation >= 0.0) {
                let (mean, deviation) = (prior.mean, prior.standard_deviation);
                return Err(Error::option(
                    "prior",
                    format!("{}={mean},{deviation}", parameter.name()),
                    format!(
                        "a mean from {} to {} and a deviation of 0 or more",
                        prior.min, prior.max
                    ),
                ));
            }
        }
        Ok(all)
    }
}
