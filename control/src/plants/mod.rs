//! The plant as the design sees it: yaw rate from steering, one input and one output.
//!
//! `ẋ = F x + G u(t − τ)`, `r = H x + D u(t − τ)`, `ψ̇ = r`, with the steering angle u in steering
//! coordinates as deviation from driving straight. Where an identified model has no continuous
//! form, its discrete one moves on its own grid and the output is held between, as in the FMU.

pub(crate) mod family;
pub(crate) mod logarithm;
pub(crate) mod sampled;
pub(crate) mod zeros;

use crate::Error;
use crate::plants::family::Family;
use formats::{Bicycle, Continuous, InputKind, Matrix, Plant, Quality};
use model_loading::identified_model;
use nalgebra::{DMatrix, DVector};
use vehicle_models::bicycle_body_frame;

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
    gain: f64,
}

/// The states' motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Dynamics {
    /// F, G, H, D.
    Continuous(Matrices),
    /// A, B, C, D on a grid of `sample_time`.
    Discrete { sample_time: f64, matrices: Matrices },
}

/// State matrix n by n, input n by 1, output 1 by n (as a column), feedthrough.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matrices {
    pub(crate) state: DMatrix<f64>,
    pub(crate) input: DVector<f64>,
    pub(crate) output: DVector<f64>,
    pub(crate) feedthrough: f64,
}

/// What a [`DesignPlant`] is called and where it holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlantInfo {
    pub(crate) model: String,
    pub(crate) name: String,
    pub(crate) speed: f64,
    pub(crate) steering_ratio: f64,
    pub(crate) input_delay: f64,
    pub(crate) quality: Quality,
}

impl DesignPlant {
    /// The plant of an identified model, at the speed of its identification.
    ///
    /// # Errors
    /// [`Error::Identified`] where the file contradicts itself, [`Error::NoSpeed`],
    /// [`Error::UnstablePlant`] and [`Error::SteadyStateGain`].
    pub fn from_plant(plant: &Plant) -> Result<Self, Error> {
        // What the FMU would refuse is not designed on.
        identified_model(plant)
            .map_err(|source| Error::Identified { model: plant.name.clone(), source })?;
        let family = Family::Identified(Box::new(plant.clone()));
        Ok(Self { family, ..Self::drawn(plant, plant.continuous.is_none())? })
    }

    /// The plant of a model that needs no checking, on its own grid only or, where there is a
    /// logarithm, moving all the time.
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
                state: DMatrix::from_fn(n, n, |i, j| state.at(i, j)),
                input: DVector::from_fn(n, |i, _| scale * input.at(i, 0)),
                output: DVector::from_fn(n, |i, _| output.at(0, i)),
                feedthrough: scale * d.d.at(0, 0),
            }
        };
        let dynamics = match &plant.continuous {
            Some(c) => Dynamics::Continuous(matrices(&c.f, &c.g, &c.h)),
            None => {
                let m = matrices(&d.a, &d.b, &d.c);
                let moving = (!on_its_grid)
                    .then(|| logarithm::continuous(&m.state, &m.input, d.sample_time_s))
                    .flatten();
                match moving {
                    Some((state, input)) => Dynamics::Continuous(Matrices { state, input, ..m }),
                    None => Dynamics::Discrete { sample_time: d.sample_time_s, matrices: m },
                }
            }
        };
        let info = PlantInfo {
            model: "plant".into(),
            name: plant.name.clone(),
            speed,
            steering_ratio: plant.steering_ratio,
            input_delay: plant.input_delay_s,
            quality: plant.quality.clone(),
        };
        Self::checked(info, dynamics)
    }

    /// The plant of a bicycle model at its speed, with the actuator's lag.
    ///
    /// # Errors
    /// [`Error::UnstablePlant`] above the critical speed of an oversteering vehicle.
    pub fn from_bicycle(bicycle: &Bicycle) -> Result<Self, Error> {
        let vehicle = &bicycle.vehicle;
        let parameters = model_loading::bicycle_parameters(vehicle);
        let (f, g) = bicycle_body_frame(&parameters, vehicle.speed_mps);
        let info = PlantInfo {
            model: "bicycle".into(),
            name: vehicle.name.clone(),
            speed: vehicle.speed_mps,
            steering_ratio: vehicle.steering_ratio,
            input_delay: 0.0,
            quality: bicycle.quality.clone(),
        };
        let matrices = Matrices {
            state: DMatrix::from_fn(3, 3, |i, j| f[(i, j)]),
            input: DVector::from_fn(3, |i, _| g[i]),
            output: DVector::from_vec(vec![0.0, 1.0, 0.0]),
            feedthrough: 0.0,
        };
        let family = Family::Bicycle(Box::new(bicycle.clone()));
        Ok(Self { family, ..Self::checked(info, Dynamics::Continuous(matrices))? })
    }

    /// A plant from its matrices: `f` n by n row by row, `g` and `h` n long.
    #[cfg(test)]
    pub(crate) fn from_matrices(
        info: PlantInfo,
        f: &[f64],
        g: &[f64],
        h: &[f64],
        d: f64,
    ) -> Result<Self, Error> {
        let n = g.len();
        let matrices = Matrices {
            state: DMatrix::from_row_slice(n, n, f),
            input: DVector::from_row_slice(g),
            output: DVector::from_row_slice(h),
            feedthrough: d,
        };
        Self::checked(info, Dynamics::Continuous(matrices))
    }

    /// F, G, H from steering angle to yaw rate, where there is a continuous form without delay and
    /// feedthrough.
    #[must_use]
    pub fn continuous(&self) -> Option<Continuous> {
        match &self.dynamics {
            Dynamics::Continuous(m) if self.input_delay == 0.0 && m.feedthrough == 0.0 => {
                let n = m.state.nrows();
                Some(Continuous {
                    f: Matrix::from_fn(n, n, |i, j| m.state[(i, j)]),
                    g: Matrix::from_fn(n, 1, |i, _| m.input[i]),
                    h: Matrix::from_fn(1, n, |_, j| m.output[j]),
                })
            }
            _ => None,
        }
    }

    /// Yaw rate per steering angle in steady state G₀, 1/s.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.gain
    }

    pub(crate) fn is_discrete(&self) -> bool {
        matches!(self.dynamics, Dynamics::Discrete { .. })
    }

    fn checked(info: PlantInfo, dynamics: Dynamics) -> Result<Self, Error> {
        let (Dynamics::Continuous(m) | Dynamics::Discrete { matrices: m, .. }) = &dynamics;
        let finite = m.state.iter().chain(&m.input).chain(&m.output).all(|v| v.is_finite())
            && [m.feedthrough, info.speed, info.input_delay].iter().all(|v| v.is_finite());
        if !finite || info.input_delay < 0.0 {
            let problem = "the model holds numbers that are not finite, or a negative delay".into();
            return Err(Error::Model { model: info.name, problem });
        }
        if let Some(text) = unstable_mode(&dynamics) {
            return Err(Error::UnstablePlant { model: info.name, speed_mps: info.speed, text });
        }
        let gain = steady_state_gain(&dynamics);
        if !(gain.is_finite() && gain > 0.0) {
            return Err(Error::SteadyStateGain { model: info.name, gain });
        }
        let PlantInfo { model, name, speed, steering_ratio, input_delay, quality } = info;
        let family = Family::Alone;
        Ok(Self {
            model,
            name,
            speed,
            steering_ratio,
            input_delay,
            quality,
            dynamics,
            family,
            gain,
        })
    }
}

/// The fastest growing mode in words, where one does not decay.
fn unstable_mode(dynamics: &Dynamics) -> Option<String> {
    match dynamics {
        Dynamics::Continuous(m) => m
            .state
            .complex_eigenvalues()
            .iter()
            .map(|l| l.re)
            .max_by(f64::total_cmp)
            .filter(|rate| *rate >= -1e-9)
            .map(|rate| {
                let limit = 2.0 * rate.max(0.0);
                format!(
                    "grows at a rate of {rate:.3} 1/s, which only a crossover above about \
                     {limit:.3} rad/s would hold"
                )
            }),
        Dynamics::Discrete { matrices, .. } => matrices
            .state
            .complex_eigenvalues()
            .iter()
            .map(|l| l.re.hypot(l.im))
            .max_by(f64::total_cmp)
            .filter(|modulus| *modulus >= 1.0 - 1e-9)
            .map(|modulus| format!("grows by {modulus:.6} in a sample")),
    }
}

/// H·(−F)⁻¹·G + D, or C·(I − A)⁻¹·B + D; not finite where that does not exist.
fn steady_state_gain(dynamics: &Dynamics) -> f64 {
    let (matrix, m) = match dynamics {
        Dynamics::Continuous(m) => (-&m.state, m),
        Dynamics::Discrete { matrices: m, .. } => {
            (DMatrix::identity(m.state.nrows(), m.state.nrows()) - &m.state, m)
        }
    };
    matrix.lu().solve(&m.input).map_or(f64::NAN, |x| m.output.dot(&x) + m.feedthrough)
}
