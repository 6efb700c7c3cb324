//! The plant as the design sees it: yaw rate from steering, one input and one output.
//!
//! `ẋ = F x + G u(t − τ)`, `r = H x + D u(t − τ)`, `ψ̇ = r`, with the steering angle u in steering
//! coordinates as deviation from driving straight. Where an identified model has no continuous
//! form, its discrete one moves on its own grid and the output is held between, as in the FMU.

use crate::Error;
use crate::plants::dynamics::{Dynamics, Matrices, steady_state_gain, unstable_mode};
use crate::plants::logarithm;
use nalgebra::{DMatrix, DVector};
use steerwright_formats::{
    Bicycle, Document, InputKind, Matrix, Plant, Quality, StatedActuator, Vehicle,
};
use steerwright_models::bicycle_body_frame;
use steerwright_models::files::identified_model;

/// Yaw rate from steering, at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignPlant {
    /// `plant` or `bicycle`.
    pub model: String,
    /// A name for people.
    pub name: String,
    /// Speed, m/s.
    pub speed: f64,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Delay of the input τ, s.
    pub input_delay: f64,
    /// The quality of the model.
    pub quality: Quality,
    pub(crate) dynamics: Dynamics,
    pub(crate) family: Family,
    /// The vehicle with its tyres, where the bicycle of the family is that of its gentle driving.
    pub(crate) vehicle: Option<Box<Vehicle>>,
    /// What was put before the model of the document.
    pub(crate) actuator: Option<StatedActuator>,
    gain: f64,
}

/// The document of a plant, from which others of its uncertainty and speeds are made.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) enum Family {
    /// None: the plant alone.
    #[default]
    Alone,
    /// An identified model; at other speeds where the product of steering and speed drives it.
    Identified(Box<Plant>),
    /// Eq 13, at any speed; it has evidence where it was identified.
    Bicycle(Box<Bicycle>),
}

impl DesignPlant {
    /// The plant of an identified model, at the speed of its identification.
    ///
    /// # Errors
    /// [`Error::Identified`] where the file is inconsistent, [`Error::NoSpeed`],
    /// [`Error::UnstablePlant`] and [`Error::SteadyStateGain`].
    pub fn from_plant(plant: &Plant) -> Result<Self, Error> {
        // The FMU rejects the same models.
        identified_model(plant)
            .map_err(|source| Error::Identified { model: plant.name.clone(), source })?;
        let drawn = Self::drawn(plant, plant.continuous.is_none())?;
        Ok(Self { family: Family::Identified(Box::new(plant.clone())), ..drawn })
    }

    /// The plant of a consistent model: on its own grid, or continuous where it has a logarithm.
    pub(crate) fn drawn(plant: &Plant, on_its_grid: bool) -> Result<Self, Error> {
        let speed = plant.operating_point.speed_mps;
        if speed == 0.0 {
            return Err(Error::NoSpeed { model: plant.name.clone() });
        }
        let scale = match plant.input {
            InputKind::Steering => 1.0,
            InputKind::SteeringTimesSpeed => speed,
        };
        let d = &plant.discrete;
        let matrices = |state: &Matrix, input: &Matrix, output: &Matrix| {
            let n = state.rows();
            Matrices {
                state: DMatrix::from_fn(n, n, |i, j| state.entry(i, j)),
                input: DVector::from_fn(n, |i, _| scale * input.entry(i, 0)),
                output: DVector::from_fn(n, |i, _| output.entry(0, i)),
                feedthrough: scale * d.d.entry(0, 0),
            }
        };
        let dynamics = match &plant.continuous {
            Some(c) => Dynamics::Continuous(matrices(&c.f, &c.g, &c.h)),
            None => {
                let m = matrices(&d.a, &d.b, &d.c);
                let continuous = (!on_its_grid)
                    .then(|| logarithm::continuous(&m.state, &m.input, d.sample_time_s))
                    .flatten();
                match continuous {
                    Some((state, input)) => Dynamics::Continuous(Matrices { state, input, ..m }),
                    None => Dynamics::Discrete { sample_time: d.sample_time_s, matrices: m },
                }
            }
        };
        Self {
            model: "plant".into(),
            name: plant.name.clone(),
            speed,
            steering_ratio: plant.steering_ratio,
            input_delay: plant.input_delay_s,
            quality: plant.quality.clone(),
            family: Family::Alone,
            vehicle: None,
            actuator: None,
            gain: steady_state_gain(&dynamics),
            dynamics,
        }
        .checked()
    }

    /// The plant of a bicycle model at its speed, with the actuator's lag.
    ///
    /// # Errors
    /// [`Error::UnstablePlant`] above the critical speed of an oversteering vehicle.
    pub fn from_bicycle(bicycle: &Bicycle) -> Result<Self, Error> {
        let vehicle = &bicycle.vehicle;
        let parameters = steerwright_models::files::bicycle_parameters(vehicle);
        let (f, g) = bicycle_body_frame(&parameters, vehicle.speed_mps);
        let dynamics = Dynamics::Continuous(Matrices {
            state: DMatrix::from_fn(3, 3, |i, j| f[(i, j)]),
            input: DVector::from_fn(3, |i, _| g[i]),
            output: DVector::from_vec(vec![0.0, 1.0, 0.0]),
            feedthrough: 0.0,
        });
        Self {
            model: "bicycle".into(),
            name: vehicle.name.clone(),
            speed: vehicle.speed_mps,
            steering_ratio: vehicle.steering_ratio,
            input_delay: vehicle.actuator_delay_s,
            quality: bicycle.quality.clone(),
            family: Family::Bicycle(Box::new(bicycle.clone())),
            vehicle: None,
            actuator: None,
            gain: steady_state_gain(&dynamics),
            dynamics,
        }
        .checked()
    }

    /// A plant at 15 m/s from its matrices, `f` n by n row by row, `g` and `h` n long, and its delay, s.
    #[cfg(test)]
    pub(crate) fn from_matrices(
        f: &[f64],
        g: &[f64],
        h: &[f64],
        d: f64,
        input_delay: f64,
    ) -> Result<Self, Error> {
        let n = g.len();
        let dynamics = Dynamics::Continuous(Matrices {
            state: DMatrix::from_row_slice(n, n, f),
            input: DVector::from_row_slice(g),
            output: DVector::from_row_slice(h),
            feedthrough: d,
        });
        Self {
            model: "plant".into(),
            name: "test".into(),
            speed: 15.0,
            steering_ratio: 1.0,
            input_delay,
            quality: Quality::default(),
            family: Family::Alone,
            vehicle: None,
            actuator: None,
            gain: steady_state_gain(&dynamics),
            dynamics,
        }
        .checked()
    }

    /// Yaw rate per steering angle in steady state G₀, 1/s.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// The document of the model at this speed; `None` for a plant without one.
    #[must_use]
    pub fn document(&self) -> Option<String> {
        match &self.family {
            Family::Identified(plant) => Some(plant.to_json()),
            Family::Bicycle(bicycle) => Some(bicycle.to_json()),
            Family::Alone => None,
        }
    }

    pub(crate) fn is_discrete(&self) -> bool {
        matches!(self.dynamics, Dynamics::Discrete { .. })
    }

    fn checked(self) -> Result<Self, Error> {
        let (Dynamics::Continuous(m) | Dynamics::Discrete { matrices: m, .. }) = &self.dynamics;
        let finite = m.state.iter().chain(&m.input).chain(&m.output).all(|v| v.is_finite())
            && [m.feedthrough, self.speed, self.input_delay].iter().all(|v| v.is_finite());
        let model = self.name.clone();
        if !finite || self.input_delay < 0.0 {
            let problem =
                "the model contains numbers that are not finite, or a negative delay".into();
            return Err(Error::Model { model, problem });
        }
        if let Some(text) = unstable_mode(&self.dynamics) {
            return Err(Error::UnstablePlant { model, speed_mps: self.speed, text });
        }
        if !(self.gain.is_finite() && self.gain > 0.0) {
            return Err(Error::SteadyStateGain { model, gain: self.gain });
        }
        Ok(self)
    }
}
