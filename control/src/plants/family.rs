//! The plants that may stand in place of the nominal one: drawn from the identified uncertainty,
//! and at other speeds where the model holds there.

use crate::Error;
use crate::plants::{DesignPlant, Dynamics};
use formats::{Bicycle, InputKind, Plant};

/// Where a design plant came from, for making its relatives.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) enum Family {
    /// None but itself.
    #[default]
    Alone,
    /// An identified model; at other speeds where the product of steering and speed drives it.
    Identified(Box<Plant>),
    /// Eq 13 holds at any speed; its evidence says that it was identified.
    Bicycle(Box<Bicycle>),
}

impl DesignPlant {
    /// Numbers that [`DesignPlant::member`] takes; 0 where no uncertainty is stated.
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
    /// `None` where what is drawn is no plant to steer.
    #[must_use]
    pub fn member(&self, xi: &[f64]) -> Option<Self> {
        let mut drawn = match &self.family {
            Family::Identified(plant) => {
                Self::drawn(&plant.ensemble_member(xi)?, self.is_discrete()).ok()?
            }
            Family::Bicycle(bicycle) => {
                let mut drawn = bicycle.as_ref().clone();
                drawn.vehicle = bicycle.ensemble_member(xi)?;
                Self::from_bicycle(&drawn).ok()?
            }
            Family::Alone => return None,
        };
        drawn.input_delay = self.input_delay;
        Some(drawn)
    }

    /// Steering angle of a steady turn: per curvature, rad·m, and what comes to it per lateral acceleration,
    /// rad·s²/m. A model of one speed cannot tell the two apart: all is taken for the first, which is as
    /// the speed designed for has it, and less than an understeering vehicle needs beyond.
    #[must_use]
    pub fn steady_turn(&self) -> [f64; 2] {
        let gradient = match &self.family {
            Family::Bicycle(bicycle) => {
                let parameters = model_loading::bicycle_parameters(&bicycle.vehicle);
                // What oversteers counts as at its own speed.
                (parameters.steering_ratio * parameters.understeer_gradient()).max(0.0)
            }
            _ => 0.0,
        };
        let v = self.speed;
        [v / self.gain() - gradient * v * v, gradient]
    }

    /// Fastest steering of the drive that it was identified from, rad/s in steering coordinates; `None`
    /// where there was none, or its file does not state it.
    #[must_use]
    pub fn fastest_steering(&self) -> Option<f64> {
        match &self.family {
            Family::Identified(plant) => plant.evidence.excitation.largest_steering_rate_radps,
            Family::Bicycle(bicycle) => bicycle.evidence.as_ref()?.largest_steering_rate_radps,
            Family::Alone => None,
        }
        .filter(|rate| *rate > 0.0)
    }

    /// The same plant with a gain that many times its own.
    pub(crate) fn with_gain(&self, times: f64) -> Self {
        let mut other = self.clone();
        let (Dynamics::Continuous(m) | Dynamics::Discrete { matrices: m, .. }) =
            &mut other.dynamics;
        m.input *= times;
        m.feedthrough *= times;
        other
    }

    /// The same plant at another speed, where its structure holds there.
    ///
    /// # Errors
    /// [`Error::NotScheduled`], and where no controller can be designed at that speed.
    pub fn at_speed(&self, speed: f64) -> Result<Self, Error> {
        let mut moved = match &self.family {
            Family::Bicycle(bicycle) => {
                let mut bicycle = bicycle.as_ref().clone();
                bicycle.vehicle.speed_mps = speed;
                Self::from_bicycle(&bicycle)?
            }
            Family::Identified(plant) if plant.input == InputKind::SteeringTimesSpeed => {
                let mut plant = plant.as_ref().clone();
                plant.operating_point.speed_mps = speed;
                Self::from_plant(&plant)?
            }
            _ => return Err(Error::NotScheduled { model: self.name.clone() }),
        };
        moved.input_delay = self.input_delay;
        Ok(moved)
    }
}
