//! The versioned JSON files that pass between Steerwright's stages.
//!
//! Each file is one type here: [`Plant`], [`Bicycle`], [`Vehicle`], [`Pid`], [`SpeedController`], [`Path`],
//! [`Estimator`], [`Start`]; [`Model`] is any of those that are identified. Every type has a schema name (`steerwright/plant/1` …), is read by
//! [`Document::from_json`], which rejects unknown versions, wrong shapes and non-finite numbers with the
//! JSON path of the fault, and is written by [`Document::to_json`], which returns the same bytes for the
//! same content.
//!
//! Units are SI and radians; a key names its unit where it is not obvious. Signs are ISO 8855:
//! x forward, y left, z up; yaw, yaw rate, steering and curvature positive to the left.
//!
//! This crate is independent of identification, design and FMUs.

/// The same check of several fields, whose names are their keys after a prefix.
macro_rules! check_fields {
    ($c:ident.$check:ident($of:expr, $at:expr): $($field:ident)+) => {
        $($c.$check($of.$field, &format!("{}{}", $at, stringify!($field)));)+
    };
}

mod bicycle;
mod bicycle_evidence;
mod design;
mod document;
mod estimator;
mod evidence;
mod excitation;
mod facts;
mod gains;
pub mod interruption;
mod longitudinal;
mod loop_metrics;
mod matrix;
mod model;
pub mod multivariable;
mod over_speed;
mod path;
mod pid;
mod plant;
mod provenance;
mod quality;
mod r_factor;
mod schedule;
mod sideslip;
mod speed_controller;
mod speed_profile;
mod start;
mod state_space;
mod torque;
mod uncertainty;
mod unit;
mod vehicle;
mod vehicle_evidence;
mod words;

pub use bicycle::{Bicycle, BicycleCoefficients, VehicleData};
pub use bicycle_evidence::{
    BicycleEvidence, Estimated, LEAST_SPREAD, SpeedSummary, Stated, VehicleDirection, WithDelay,
};
pub use design::{
    Breaking, DesignEvidence, Engagement, EngagementRow, FmuLoop, HeightStep, LoopCoupling,
    OverEnsemble, Robustness, Specification, TradeOff,
};
pub use document::{Checker, Document, Error, schema_of};
pub use estimator::{Estimator, Gnss, InitialUncertainty, Ranged, SensorNoise};
pub use evidence::{
    BLOCK_S, BandDeparture, ChannelSummary, CoherencePoint, DataFactor, DelayEstimate, Evidence,
    Excitation, ExcitationBand, FactorMethod, Fits, FrequencyResponse, HeldOut, IdentifiedActuator,
    Information, Intersample, LEAST_BLOCKS, LimitCycle, Mode, OrderRow, Persistence, PoleZeroMap,
    PredictionFit, ResidualCorrelation, ResidualTest, ResponsePoint, Spread, SteeringPlay,
    too_few_blocks,
};
pub use excitation::{
    Alternative, ExpectedErrors, ExpectedResponse, Manoeuvre, ManoeuvreBlock, ManoeuvreGoal,
    ManoeuvreKind, ManoeuvreLimits, ManoeuvrePurpose, SignalPeaks, SteeringSignal,
};
pub use facts::{Described, Fact, Facts};
pub use gains::{GuidanceAdvice, PidGains};
pub use longitudinal::{
    Brake, GainVariation, GearGain, Longitudinal, LongitudinalEvidence, LongitudinalNoise,
    SpeedGain,
};
pub use loop_metrics::{Margins, OnACurve, Shortfall, StepMetrics};
pub use matrix::Matrix;
pub use model::{Model, Structure};
pub use multivariable::{
    MeasuredPoint, MultivariableEvidence, MultivariablePlant, MultivariableUncertainty,
    OutputEvidence, PairDelay, PairEvidence, PlantInput, PlantOutput, variable_name,
};
pub use over_speed::{FrozenSpeed, OverSpeed, SpeedRamp, SpeedRampKind};
pub use path::{Guidance, Path, PathPoint};
pub use pid::{DesignedFor, LargeErrors, LateralAcceleration, Limits, Pid, StatedActuator};
pub use plant::{InputKind, Noise, OperatingPoint, Plant};
pub use provenance::{HashingReader, Provenance, SampleHash, SourceFile, sha256_hex};
pub use quality::{Grade, Quality, Reason, ReasonCode};
pub use r_factor::{AccumulatedDrives, AccumulatedSpeed};
pub use schedule::{GuidanceEntry, ScheduleEntry};
pub use sideslip::{Sideslip, SideslipTerm};
pub use speed_controller::{
    SpeedController, SpeedEnsemble, SpeedEvidence, SpeedGains, SpeedLimits, SpeedResponses,
    SpeedSpecification, SpeedStep,
};
pub use speed_profile::{
    BindingSegment, ProfileLimit, ProfileLimits, ProfilePoint, SpeedProfile, SteeringLimits,
};
pub use start::Start;
pub use state_space::{Continuous, Discrete};
pub use torque::{Torque, TorqueEvidence};
pub use uncertainty::{
    Estimate, EstimationFocus, FrequencyBand, NORMAL_95, StepBand, UncertainPole, Uncertainty,
};
pub use unit::PhysicalUnit;
pub use vehicle::{Body, SteeringActuator, Tyres, Vehicle};
pub use vehicle_evidence::{Prior, SimulationFit, VehicleEvidence, VehicleParameter, correlated};
pub use words::{UnknownWord, alternatives};

/// Of a number that a file need not state.
#[allow(clippy::trivially_copy_pass_by_ref)] // the signature that serde requires
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
