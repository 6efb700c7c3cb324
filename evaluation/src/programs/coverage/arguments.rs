//! What the options of `cargo xtask evaluate coverage` choose from.

use clap::ValueEnum;
use steerwright_evaluation::Steering;
use steerwright_sysid::Intersample;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum DriveKind {
    /// `LinearDrive::realistic`
    Realistic,
    /// `LinearDrive::ideal`
    Ideal,
    /// `LinearDrive::clean_sweep`
    Sweep,
    /// `LinearDrive::held_steps`
    HeldSteps,
}

impl DriveKind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Realistic => "realistic",
            Self::Ideal => "ideal",
            Self::Sweep => "sweeps",
            Self::HeldSteps => "held steps behind a lag",
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Disturbance {
    /// The speed is constant
    Jitter,
    /// No gusts
    Gusts,
    /// The steering angle is logged as it is
    Quantisation,
    /// No play in the steering
    Lash,
    /// The gyro has no noise
    Gyro,
    /// No driver in the loop
    Driver,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Column {
    /// Samples of an angle that moves on between them
    Measured,
    /// A command that is held from row to row, with the name of a command
    Command,
    /// A command that is held from row to row, with the name of an angle
    HeldAngle,
}

impl From<Column> for Steering {
    fn from(column: Column) -> Self {
        match column {
            Column::Measured => Self::Measured,
            Column::Command => Self::Command,
            Column::HeldAngle => Self::HeldAngle,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StatedIntersample {
    /// It moves on: band-limited
    Bl,
    /// It is held
    Zoh,
}

impl From<StatedIntersample> for Intersample {
    fn from(stated: StatedIntersample) -> Self {
        match stated {
            StatedIntersample::Bl => Self::Bl,
            StatedIntersample::Zoh => Self::Zoh,
        }
    }
}
