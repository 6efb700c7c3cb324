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

mod controllers;
mod document;
mod estimator;
mod excitation;
mod facts;
pub mod interruption;
mod matrix;
mod models;
mod path;
mod provenance;
mod quality;
mod r_factor;
mod speed_profile;
mod start;
mod unit;
mod words;

pub use controllers::*;
pub use document::{Checker, Document, Error, schema_of};
pub use estimator::{Estimator, Gnss, InitialUncertainty, Ranged, SensorNoise};
pub use excitation::{
    Alternative, ExpectedErrors, ExpectedResponse, Manoeuvre, ManoeuvreBlock, ManoeuvreGoal,
    ManoeuvreKind, ManoeuvreLimits, ManoeuvrePurpose, SignalPeaks, SteeringSignal,
};
pub use facts::{Described, Fact, Facts};
pub use matrix::Matrix;
pub use models::*;
pub use path::{Guidance, Path, PathPoint};
pub use provenance::{HashingReader, Provenance, SampleHash, SourceFile, sha256_hex};
pub use quality::{Grade, Quality, Reason, ReasonCode};
pub use r_factor::{AccumulatedDrives, AccumulatedSpeed};
pub use speed_profile::{
    BindingSegment, ProfileLimit, ProfileLimits, ProfilePoint, SpeedProfile, SteeringLimits,
};
pub use start::Start;
pub use unit::PhysicalUnit;
pub use words::{UnknownWord, alternatives};

/// Of a number that a file need not state.
#[allow(clippy::trivially_copy_pass_by_ref)] // the signature that serde requires
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
