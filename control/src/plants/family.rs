//! Other plants of the same vehicle: drawn, with another gain, and at other speeds.

use crate::Error;
use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::dynamics::Dynamics;
use steerwright_formats::{Bicycle, InputKind, VehicleData};

/// The steering of a steady turn, `(L + K·v²)·κ`, in steering coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SteadyTurn {
    /// L, rad·m.
    pub(crate) slow: f64,
    /// K, rad·s²/m.
    pub(crate) understeer: f64,
}

impl DesignPlant {
    /// Number of random numbers that [`DesignPlant::member`] requires; 0 where no uncertainty is stated.
    #[must_use]
    pub fn ensemble_dimension(&self) -> usize {
        match &self.family {
            Family::Identified(plant) => plant.ensemble_dimension(),
            Family::Bicycle(bicycle) => bicycle.ensemble_dimension(),
            Family::Alone => 0,
        }
    }

    /// Whether the model was identified in a structure that holds at other speeds than its own.
    #[must_use]
    pub fn is_speed_scheduled(&self) -> bool {
        match &self.family {
            Family::Identified(plant) => plant.input == InputKind::SteeringTimesSpeed,
            Family::Bicycle(bicycle) => bicycle.evidence.is_some(),
            Family::Alone => false,
        }
    }

    /// The plant that standard normal numbers draw from the identified uncertainty, at its own speed.
    /// `None` where no controller can be designed on it.
    #[must_use]
    pub fn member(&self, xi: &[f64]) -> Option<Self> {
        let mut drawn = match &self.family {
            Family::Identified(plant) => {
                Self::drawn(&plant.ensemble_member(xi)?, self.is_discrete()).ok()?
            }
            Family::Bicycle(bicycle) => {
                let mut drawn = bicycle.as_ref().clone();
                drawn.vehicle = bicycle.ensemble_member(xi)?;
                let mut drawn = Self::from_bicycle(&drawn).ok()?;
                // With the latency of the loop, if it has been added.
                let change = drawn.input_delay - bicycle.vehicle.actuator_delay_s;
                drawn.input_delay = (self.input_delay + change).max(0.0);
                return Some(drawn.with_actuator_of(self));
            }
            Family::Alone => return None,
        };
        drawn.input_delay = self.input_delay;
        Some(drawn.with_actuator_of(self))
    }

    /// The steering of a steady turn. A model of one speed does not separate its two numbers: the gradient is 0, which is
    /// exact at that speed and less than an understeering vehicle needs above it.
    pub(crate) fn steady_turn(&self) -> SteadyTurn {
        let understeer = match &self.family {
            Family::Bicycle(bicycle) => {
                let parameters = steerwright_models::files::bicycle_parameters(&bicycle.vehicle);
                // An oversteering vehicle is treated like a model of one speed.
                (parameters.steering_ratio * parameters.understeer_gradient()).max(0.0)
            }
            _ => 0.0,
        };
        let v = self.speed;
        SteadyTurn { slow: v / self.gain() - understeer * v * v, understeer }
    }

    /// Fastest steering of the drive that the plant was identified from, rad/s in steering coordinates; `None`
    /// without a drive, or where the file does not state it.
    #[must_use]
    pub fn fastest_steering(&self) -> Option<f64> {
        match &self.family {
            Family::Identified(plant) => plant.evidence.excitation.largest_steering_rate_radps,
            Family::Bicycle(bicycle) => bicycle.evidence.as_ref()?.largest_steering_rate_radps,
            Family::Alone => None,
        }
        .filter(|rate| *rate > 0.0)
    }

    /// Largest rate of the actuator, rad/s in steering coordinates; `None` where the model knows none.
    #[must_use]
    pub fn largest_rate(&self) -> Option<f64> {
        let Family::Bicycle(bicycle) = &self.family else { return None };
        bicycle.largest_rate().map(|(rate, _)| rate * self.steering_ratio)
    }

    /// The same plant with its gain multiplied by a factor.
    pub(crate) fn with_gain(&self, factor: f64) -> Self {
        let mut other = self.clone();
        let (Dynamics::Continuous(m) | Dynamics::Discrete { matrices: m, .. }) =
            &mut other.dynamics;
        m.input *= factor;
        m.feedthrough *= factor;
        other
    }

    /// The same plant at another speed, where its structure holds there.
    ///
    /// # Errors
    /// [`Error::NotScheduled`], and where no controller can be designed at that speed.
    pub fn at_speed(&self, speed: f64) -> Result<Self, Error> {
        let mut moved = match &self.family {
            Family::Bicycle(bicycle) => {
                let bicycle = bicycle.as_ref().clone();
                // Its matrices are those at its speed.
                let own = Bicycle::new(VehicleData { speed_mps: speed, ..bicycle.vehicle });
                Self::from_bicycle(&Bicycle {
                    vehicle: own.vehicle,
                    state_matrix: own.state_matrix,
                    input_matrix: own.input_matrix,
                    ..bicycle
                })?
            }
            Family::Identified(plant) if plant.input == InputKind::SteeringTimesSpeed => {
                let mut plant = plant.as_ref().clone();
                plant.operating_point.speed_mps = speed;
                Self::from_plant(&plant)?
            }
            _ => return Err(Error::NotScheduled { model: self.name.clone() }),
        };
        moved.input_delay = self.input_delay;
        moved.vehicle.clone_from(&self.vehicle);
        Ok(moved.with_actuator_of(self))
    }
}
