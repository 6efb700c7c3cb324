//! Models compared with a drive, controllers with each other (the paper's Fig. 3, 5, 6 and 7), and the
//! loops of packed FMUs in which they run.
//!
//! Each model is validated on a drive; a controller is read or designed for each; every controller
//! follows one road on the plant of every model and on the truth, all as packed FMUs under the
//! coupling. What is the same for all: the specification, the road, the rule by which look-ahead,
//! preview and feedforward follow from a controller, and the sideslip that the path follower uses,
//! which is read for each plant in a turn.

mod channels;
mod compare;
mod drive;
mod error;
mod figures;
mod json;
mod model;
mod models;
mod outcome;
mod packed;
mod page;
mod plants;
mod runs;
mod speed;
mod step;
mod tables;
mod track;
mod truth;
mod vehicle;
mod verdict;

pub use channels::{
    ChannelOverview, SimulatedPlant, channel_files, channel_json, channel_text, simulated_plants,
};
pub use compare::{Comparison, Job, Road, Shape, compare};
pub use drive::{ComparedDrive, OnDrive};
pub use error::Error;
pub use json::{Overview, json};
pub use models::{ComparedModel, Controller, ControllerFile, models};
pub use outcome::Outcome;
pub use packed::{
    BehindActuator, Named, PackedLoop, behind_stated_actuator, fmu_of, pack, pack_loop,
};
pub use page::{OutputFile, PAGE, files};
pub use plants::Plant;
pub use runs::{ComparedRun, Effort};
pub use speed::verify_speed;
pub use step::{LoopStep, verify, yaw_step, yaw_step_with_offset};
pub use tables::text;
pub use track::Loop;
pub use truth::Truth;
pub use verdict::{Figure, Verdict};
