//! What a design writes: controllers, the requirements that they are designed to and the evidence that they keep them.

mod design;
mod gains;
mod loop_metrics;
mod over_speed;
mod pid;
mod requirement;
mod schedule;
mod speed_controller;

pub use design::{
    Breaking, DesignEvidence, Engagement, EngagementRow, FmuLoop, HeightStep, LoopCoupling,
    OverEnsemble, Robustness, Specification, TradeOff,
};
pub use gains::{GuidanceAdvice, PidGains};
pub use loop_metrics::{Margins, OnACurve, Shortfall, StepMetrics};
pub use over_speed::{FrozenSpeed, OverSpeed, SpeedRamp, SpeedRampKind};
pub use pid::{DesignedFor, LargeErrors, LateralAcceleration, Limits, Pid, StatedActuator};
pub use requirement::Requirement;
pub(crate) use schedule::check_speeds;
pub use schedule::{GuidanceEntry, ScheduleEntry};
pub use speed_controller::{
    SpeedController, SpeedEnsemble, SpeedEvidence, SpeedGains, SpeedLimits, SpeedResponses,
    SpeedSpecification, SpeedStep,
};
