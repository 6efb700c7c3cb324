//! The variable tables.

pub(crate) mod bicycle_plant;
pub(crate) mod identified_plant;
pub(crate) mod lateral_pid;
pub(crate) mod nonlinear_vehicle;
pub(crate) mod pose_estimator;
pub(crate) mod reference_path;

pub(crate) use fmi2_export::variables;
