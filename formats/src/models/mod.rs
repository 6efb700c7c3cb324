//! The models that are identified, one file for the document of each structure, and [`Model`], which is any of them.
//!
//! A structure is a variant of [`Structure`] and of [`Model`]. What another crate does for each of them stands in one
//! `match`, in the file `model.rs` of that crate.

mod bicycle;
mod bicycle_evidence;
mod evidence;
mod longitudinal;
pub mod multivariable;
mod plant;
mod sideslip;
mod state_space;
mod torque;
mod uncertainty;
mod vehicle;
mod vehicle_evidence;

use crate::Error;
use crate::document::{Document, schema_of};
use crate::provenance::Provenance;
use crate::quality::Quality;
use crate::words::alternatives;

pub use bicycle::{Bicycle, BicycleCoefficients, VehicleData};
pub use bicycle_evidence::{
    BicycleEvidence, Estimated, LEAST_SPREAD, SpeedSummary, Stated, VehicleDirection, WithDelay,
};
pub use evidence::{
    BLOCK_S, BandDeparture, ChannelSummary, CoherencePoint, DataFactor, DelayEstimate, Evidence,
    Excitation, ExcitationBand, FactorMethod, Fits, FrequencyResponse, HeldOut, IdentifiedActuator,
    Information, Intersample, LEAST_BLOCKS, LimitCycle, Mode, OrderRow, Persistence, PoleZeroMap,
    PredictionFit, ResidualCorrelation, ResidualTest, ResponsePoint, Spread, SteeringPlay,
    too_few_blocks,
};
pub use longitudinal::{
    Brake, GainVariation, GearGain, Longitudinal, LongitudinalEvidence, LongitudinalNoise,
    SpeedGain,
};
pub use multivariable::{
    MeasuredPoint, MultivariableEvidence, MultivariablePlant, MultivariableUncertainty,
    OutputEvidence, PairDelay, PairEvidence, PlantInput, PlantOutput, variable_name,
};
pub use plant::{InputKind, Noise, OperatingPoint, Plant};
pub use sideslip::{Sideslip, SideslipTerm};
pub use state_space::{Continuous, Discrete};
pub use torque::{Torque, TorqueEvidence};
pub use uncertainty::{
    Estimate, EstimationFocus, FrequencyBand, NORMAL_95, StepBand, UncertainPole, Uncertainty,
};
pub use vehicle::{Body, SteeringActuator, Tyres, Vehicle};
pub use vehicle_evidence::{Prior, SimulationFit, VehicleEvidence, VehicleParameter, correlated};

/// The structure of a model; simpler ones first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Structure {
    /// Linear at one speed, in state space.
    StateSpace,
    /// The bicycle of eq 13, scheduled by the speed.
    Bicycle,
    /// A vehicle up to the limit of its grip.
    SingleTrack,
    /// The response to a steering torque.
    Torque,
    /// The response of the speed to the pedals.
    Longitudinal,
}

crate::words!(Structure {
    StateSpace = "state-space",
    Bicycle = "bicycle",
    SingleTrack = "single-track",
    Torque = "torque",
    Longitudinal = "longitudinal",
});

impl Structure {
    /// The usual name of a model's file, which is that of its schema.
    #[must_use]
    pub fn file_name(self) -> String {
        format!("{}.json", self.kind())
    }

    /// The schema of a model's file.
    #[must_use]
    pub fn schema(self) -> &'static str {
        match self {
            Self::StateSpace => Plant::SCHEMA,
            Self::Bicycle => Bicycle::SCHEMA,
            Self::SingleTrack => Vehicle::SCHEMA,
            Self::Torque => Torque::SCHEMA,
            Self::Longitudinal => Longitudinal::SCHEMA,
        }
    }

    /// The kind of document in its schema.
    fn kind(self) -> &'static str {
        kind(self.schema())
    }

    /// The one whose documents have a schema, of any version.
    fn from_schema(schema: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|structure| structure.kind() == kind(schema))
    }

    /// Whether its models are of the lateral dynamics, from a steering angle to the yaw rate: `auto` chooses one of these,
    /// controllers of the steering are designed on them, and one replaces another.
    #[must_use]
    pub fn is_lateral(self) -> bool {
        matches!(self, Self::StateSpace | Self::Bicycle | Self::SingleTrack)
    }
}

/// The kind of document of a schema such as `steerwright/plant/1`, empty where it is another program's.
fn kind(schema: &str) -> &str {
    let own = schema.strip_prefix("steerwright/").and_then(|rest| rest.split('/').next());
    own.unwrap_or_default()
}

/// A model: the document of its structure.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Model {
    /// `plant.json`.
    StateSpace(Box<Plant>),
    /// `bicycle.json`.
    Bicycle(Box<Bicycle>),
    /// `vehicle.json`.
    SingleTrack(Box<Vehicle>),
    /// `torque.json`.
    Torque(Box<Torque>),
    /// `longitudinal.json`.
    Longitudinal(Box<Longitudinal>),
    /// `plant.json`, version 2: of any system.
    Multivariable(Box<MultivariablePlant>),
}

impl Model {
    /// Whether a JSON text states the schema of a model, of any version.
    #[must_use]
    pub fn is_in(text: &str) -> bool {
        Structure::from_schema(&schema_of(text).unwrap_or_default()).is_some()
    }

    /// Reads a model; `file` is its name in errors.
    ///
    /// # Errors
    /// [`Error`] with the place of the first fault; [`Error::NoModel`] for a document of another kind.
    pub fn from_json(text: &str, file: &str) -> Result<Self, Error> {
        // Of any version, so that another version is rejected as such.
        let schema = schema_of(text).unwrap_or_default();
        let structure = match Structure::from_schema(&schema) {
            Some(structure) => structure,
            // It may be no JSON.
            None if schema.is_empty() => Structure::StateSpace,
            None => {
                let kinds = alternatives(&Structure::ALL.map(Structure::kind));
                return Err(Error::NoModel { file: file.into(), schema, kinds });
            }
        };
        Ok(match structure {
            Structure::StateSpace if schema == MultivariablePlant::SCHEMA => {
                Self::Multivariable(Box::new(MultivariablePlant::from_json(text, file)?))
            }
            Structure::StateSpace => Self::StateSpace(Box::new(Plant::from_json(text, file)?)),
            Structure::Bicycle => Self::Bicycle(Box::new(Bicycle::from_json(text, file)?)),
            Structure::SingleTrack => Self::SingleTrack(Box::new(Vehicle::from_json(text, file)?)),
            Structure::Torque => Self::Torque(Box::new(Torque::from_json(text, file)?)),
            Structure::Longitudinal => {
                Self::Longitudinal(Box::new(Longitudinal::from_json(text, file)?))
            }
        })
    }

    /// The document as text.
    #[must_use]
    pub fn to_json(&self) -> String {
        match self {
            Self::StateSpace(plant) => plant.to_json(),
            Self::Bicycle(bicycle) => bicycle.to_json(),
            Self::SingleTrack(vehicle) => vehicle.to_json(),
            Self::Torque(torque) => torque.to_json(),
            Self::Longitudinal(model) => model.to_json(),
            Self::Multivariable(plant) => plant.to_json(),
        }
    }

    /// The actuator between a steering command and the measured angle of the drive.
    #[must_use]
    pub fn identified_actuator(&self) -> Option<IdentifiedActuator> {
        match self {
            Self::StateSpace(plant) => plant.evidence.actuator,
            Self::Bicycle(bicycle) => bicycle.evidence.as_ref()?.actuator,
            Self::SingleTrack(vehicle) => vehicle.evidence.as_ref()?.actuator,
            Self::Torque(_) | Self::Longitudinal(_) | Self::Multivariable(_) => None,
        }
    }

    /// As [`Document::checked`].
    ///
    /// # Errors
    /// [`Error::Value`] with the JSON path of the first fault.
    pub fn checked(&self, file: &str) -> Result<(), Error> {
        match self {
            Self::StateSpace(plant) => plant.checked(file),
            Self::Bicycle(bicycle) => bicycle.checked(file),
            Self::SingleTrack(vehicle) => vehicle.checked(file),
            Self::Torque(torque) => torque.checked(file),
            Self::Longitudinal(model) => model.checked(file),
            Self::Multivariable(plant) => plant.checked(file),
        }
    }

    /// Its structure.
    #[must_use]
    pub fn structure(&self) -> Structure {
        match self {
            Self::StateSpace(_) | Self::Multivariable(_) => Structure::StateSpace,
            Self::Bicycle(_) => Structure::Bicycle,
            Self::SingleTrack(_) => Structure::SingleTrack,
            Self::Torque(_) => Structure::Torque,
            Self::Longitudinal(_) => Structure::Longitudinal,
        }
    }

    /// The plant of a vehicle in state space; `None` of another structure and of any other system.
    #[must_use]
    pub fn plant(&self) -> Option<&Plant> {
        match self {
            Self::StateSpace(plant) => Some(plant),
            _ => None,
        }
    }

    /// The plant of any system, from named inputs to named outputs; `None` of a vehicle's model.
    #[must_use]
    pub fn multivariable(&self) -> Option<&MultivariablePlant> {
        match self {
            Self::Multivariable(plant) => Some(plant),
            _ => None,
        }
    }

    /// The response of the speed; `None` of another structure.
    #[must_use]
    pub fn longitudinal(&self) -> Option<&Longitudinal> {
        match self {
            Self::Longitudinal(model) => Some(model),
            _ => None,
        }
    }

    /// The name of the vehicle or of the log.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::StateSpace(plant) => &plant.name,
            Self::Bicycle(bicycle) => &bicycle.vehicle.name,
            Self::SingleTrack(vehicle) => &vehicle.name,
            Self::Torque(torque) => &torque.name,
            Self::Longitudinal(model) => &model.name,
            Self::Multivariable(plant) => &plant.name,
        }
    }

    /// Whether a controller may be designed on it.
    #[must_use]
    pub fn quality(&self) -> &Quality {
        match self {
            Self::StateSpace(plant) => &plant.quality,
            Self::Bicycle(bicycle) => &bicycle.quality,
            Self::SingleTrack(vehicle) => &vehicle.quality,
            Self::Torque(torque) => &torque.quality,
            Self::Longitudinal(model) => &model.quality,
            Self::Multivariable(plant) => &plant.quality,
        }
    }

    /// The sources of the file, where it states them.
    #[must_use]
    pub fn provenance(&self) -> Option<&Provenance> {
        match self {
            Self::StateSpace(plant) => Some(&plant.provenance),
            Self::Bicycle(bicycle) => Some(&bicycle.provenance),
            Self::SingleTrack(vehicle) => vehicle.provenance.as_ref(),
            Self::Torque(torque) => Some(&torque.provenance),
            Self::Longitudinal(model) => Some(&model.provenance),
            Self::Multivariable(plant) => Some(&plant.provenance),
        }
    }

    /// The sideslip that fixes determined.
    #[must_use]
    pub fn stated_sideslip(&self) -> Option<&Sideslip> {
        match self {
            Self::StateSpace(plant) => plant.sideslip.as_ref(),
            Self::Bicycle(bicycle) => bicycle.sideslip.as_ref(),
            Self::SingleTrack(vehicle) => vehicle.sideslip.as_ref(),
            Self::Torque(_) | Self::Longitudinal(_) | Self::Multivariable(_) => None,
        }
    }

    /// Speed at which it was identified or is stated, m/s; `None` where the log had none.
    #[must_use]
    pub fn speed_mps(&self) -> Option<f64> {
        let speed = match self {
            Self::StateSpace(plant) => plant.operating_point.speed_mps,
            Self::Bicycle(bicycle) => bicycle.vehicle.speed_mps,
            Self::SingleTrack(vehicle) => vehicle.speed_mps,
            Self::Torque(torque) => torque.evidence.mean_speed_mps,
            Self::Longitudinal(model) => model.evidence.speed_mps[1],
            Self::Multivariable(_) => return None,
        };
        Some(speed).filter(|speed| *speed > 0.0)
    }

    /// Fit on the estimation data and on the validation data, %, where it was identified and these exist.
    #[must_use]
    pub fn fits(&self) -> [Option<f64>; 2] {
        let validated = |fit: f64, samples: usize| if samples > 0 { Some(fit) } else { None };
        match self {
            Self::StateSpace(plant) => {
                let e = &plant.evidence;
                [Some(e.fit.estimation), validated(e.fit.validation, e.validation_samples)]
            }
            Self::Bicycle(bicycle) => match &bicycle.evidence {
                Some(e) => {
                    [Some(e.estimation_fit), validated(e.validation_fit, e.validation_samples)]
                }
                None => [None; 2],
            },
            Self::SingleTrack(vehicle) => match &vehicle.evidence {
                Some(e) => [Some(e.estimation.yaw_rate), e.validation.map(|fit| fit.yaw_rate)],
                None => [None; 2],
            },
            Self::Torque(torque) => {
                let e = &torque.evidence;
                [Some(e.estimation_fit), validated(e.validation_fit, e.validation_samples)]
            }
            Self::Longitudinal(model) => {
                let e = &model.evidence;
                [Some(e.estimation_fit), validated(e.validation_fit, e.validation_samples)]
            }
            Self::Multivariable(plant) => {
                let e = &plant.evidence;
                [Some(e.fit.estimation), validated(e.fit.validation, e.validation_samples)]
            }
        }
    }

    /// The channels of the log.
    #[must_use]
    pub fn channels(&self) -> &[ChannelSummary] {
        match self {
            Self::StateSpace(plant) => &plant.evidence.channels,
            Self::Bicycle(bicycle) => bicycle.evidence.as_ref().map_or(&[], |e| &e.channels),
            Self::SingleTrack(vehicle) => vehicle.evidence.as_ref().map_or(&[], |e| &e.channels),
            Self::Torque(torque) => &torque.evidence.channels,
            Self::Longitudinal(model) => &model.evidence.channels,
            Self::Multivariable(plant) => &plant.evidence.channels,
        }
    }

    /// Warnings of the log reader and of the identification.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::StateSpace(plant) => &plant.evidence.warnings,
            Self::Bicycle(bicycle) => bicycle.evidence.as_ref().map_or(&[], |e| &e.warnings),
            Self::SingleTrack(vehicle) => vehicle.evidence.as_ref().map_or(&[], |e| &e.warnings),
            Self::Torque(torque) => &torque.evidence.warnings,
            Self::Longitudinal(model) => &model.evidence.warnings,
            Self::Multivariable(plant) => &plant.evidence.warnings,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_read_by_its_schema_and_other_documents_are_none() {
        let read =
            |schema: &str| Model::from_json(&format!("{{\"schema\": \"{schema}\"}}"), "m.json");
        let kinds = Structure::ALL.map(|structure| (structure.kind(), false));
        for (kind, rejected) in kinds.into_iter().chain([("pid", true)]) {
            let schema = format!("steerwright/{kind}/1");
            let error = read(&schema).unwrap_err();
            assert_eq!(matches!(error, Error::NoModel { .. }), rejected, "{error}");
            assert_eq!(Model::is_in(&format!("{{\"schema\": \"{schema}\"}}")), !rejected);
            // Of a later version, which is named.
            let later = read(&format!("steerwright/{kind}/99")).unwrap_err().to_string();
            assert!(later.contains("/99`"), "{later}");
        }
        let pid = read("steerwright/pid/1").unwrap_err().to_string();
        let kinds = "is no plant, bicycle, vehicle, torque or longitudinal model";
        assert!(pid.ends_with(kinds), "{pid}");
        assert!(matches!(read("plant"), Err(Error::NoModel { .. })));
        assert!(matches!(Model::from_json("{", "m.json"), Err(Error::Syntax { .. })));
        assert!(matches!(Model::from_json("{}", "m.json"), Err(Error::Schema { .. })));
    }

    #[test]
    fn structures_are_read_by_their_names() {
        for structure in Structure::ALL {
            assert_eq!(structure.name().parse(), Ok(structure));
        }
        let unknown = "auto".parse::<Structure>().unwrap_err();
        assert_eq!(
            unknown.expected(),
            "state-space, bicycle, single-track, torque or longitudinal"
        );
    }
}
