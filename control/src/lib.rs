//! Bicycle models, PID design to a specification, reference paths.
//!
//! ```text
//! vehicle.toml ──▶ bicycle ──▶ bicycle.json ─┐
//!                            plant.json ─────┴▶ DesignPlant ──▶ design ──▶ pid.json
//! points, or a shape ──▶ paths ──▶ path.json         │              │
//!                                                    └─▶ evaluate, step_response, track
//! ```
//!
//! | function | purpose |
//! |---|---|
//! | [`bicycle_from_toml`], [`bicycle()`], [`bicycle_of_vehicle`] | vehicle data → eq 13 |
//! | [`DesignPlant`] | steering → yaw rate, identified or bicycle |
//! | [`design()`] | eq 14 to a specification, with evidence |
//! | [`design_speed`] | a controller of the speed to a specification, with evidence |
//! | [`design_over_speeds`] | the same for a range of speeds |
//! | [`evaluate()`], [`step_response`], [`step_metrics`], [`metrics_of`] | any controller on any plant |
//! | [`guidance_for`], [`sideslip`], [`plant_sideslip`], [`with_sideslip`] | the path follower around the loop |
//! | [`demands`], [`OtherSpeed`] | what a path needs of a controller, before it is driven |
//! | [`speed_profile`], [`steering_limits`] | the time-optimal speed over a path within limits |
//! | [`track()`], [`track_with`] | plant, path and controller in one process |
//! | [`paths`] | composed, standard and recorded paths |
//!
//! Nothing here reads files or clocks: text and documents come in, documents go out, and the same
//! input gives the same output. SI units and radians; ISO 8855 axes. Steering angles are in the
//! plant's own steering coordinates unless a name states the road wheel.

mod bicycle;
mod closed_loop;
mod design;
mod error;
mod guidance;
mod model;
pub mod paths;
mod plants;
mod profile;
mod requirement;
mod speed;

#[cfg(test)]
mod tests;

pub use bicycle::{bicycle, bicycle_from_toml, bicycle_of_vehicle};
pub use closed_loop::evaluate::{LoopPoint, evaluate, loop_response, step_metrics, step_response};
pub use closed_loop::metrics::{Metrics, metrics_of};
pub use closed_loop::simulate::Trace;
pub use design::design;
pub use design::limits::usual_max_angle_rad;
pub use design::options::{DesignOptions, RobustOptions};
pub use design::over_speed::design_over_speeds;
pub use error::Error;
pub use guidance::demand::{Demand, OtherSpeed, Quantity, demands};
pub use guidance::track::{TrackTrace, track, track_with};
pub use guidance::{guidance_for, guidance_schedule, sideslip, with_sideslip};
pub use model::{
    evidence_acceleration, model_behind, model_bicycle, model_sideslip, model_vehicle, no_steering,
    plant_sideslip,
};
pub use plants::design_plant::DesignPlant;
pub use plants::plant_model::PlantModel;
pub use profile::{
    lateral_acceleration_limit, speed_preview_times, speed_profile, steering_limits,
    unlimited_steering,
};
pub use speed::design::design_speed;
pub use speed::options::SpeedDesignOptions;
pub use speed::simulate::{responses_of as speed_responses, speed_traces, step as speed_step};
pub use steerwright_models::Sideslip;
