//! The options of `cargo xtask evaluate coverage`.

use clap::{Parser, ValueEnum};
use steerwright_evaluation::Steering;
use steerwright_sysid::Intersample;

/// Prints in how many simulated drives each stated 95 % band holds the truth.
#[derive(Parser)]
pub(super) struct Arguments {
    /// Drives, each of a car of its own
    #[arg(long, default_value_t = 240)]
    pub(super) drives: usize,
    /// Seed of cars and drives
    #[arg(long, default_value_t = 9)]
    pub(super) seed: u64,
    /// What is left out of every drive
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(super) without: Vec<Disturbance>,
    /// Sample time to bring the logs to, s, in place of the automatic one
    #[arg(long)]
    pub(super) sample_time: Option<f64>,
    /// Order of the state-space model, in place of the automatic one
    #[arg(long)]
    pub(super) order: Option<usize>,
    /// Delay of the input, s, in place of the automatic one
    #[arg(long)]
    pub(super) delay: Option<f64>,
    /// Rows of the logs a second
    #[arg(long, default_value_t = 100.0)]
    pub(super) rate: f64,
    /// Length of the drives, s
    #[arg(long, default_value_t = 120.0)]
    pub(super) seconds: f64,
    /// What is driven
    #[arg(long, value_enum, default_value_t = Kind::Realistic)]
    pub(super) kind: Kind,
    /// What the log has of the steering
    #[arg(long, value_enum, default_value_t = Column::Measured)]
    pub(super) steering: Column,
    /// What is stated about the steering between its samples; without it, nothing is stated
    #[arg(long, value_enum)]
    pub(super) intersample: Option<Stated>,
    /// Print a line for each drive
    #[arg(long)]
    pub(super) list: bool,
    /// Folder to write the logs to
    #[arg(long, value_name = "DIR")]
    pub(super) write: Option<std::path::PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Kind {
    /// `LinearDrive::realistic`
    Realistic,
    /// `LinearDrive::ideal`
    Ideal,
    /// `LinearDrive::clean_sweep`
    Sweep,
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
pub(super) enum Stated {
    /// It moves on: band-limited
    Bl,
    /// It is held
    Zoh,
}

impl From<Stated> for Intersample {
    fn from(stated: Stated) -> Self {
        match stated {
            Stated::Bl => Self::Bl,
            Stated::Zoh => Self::Zoh,
        }
    }
}
