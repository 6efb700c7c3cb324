//! `steerwright demo`: all stages, on the recorded drives in this program.

use crate::commands::identify::Wanted;
use crate::documents::gate::GateArguments;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::output::Outputs;
use crate::pipeline::{self, Job, Text};
use crate::terminal::{console, overview};
use std::path::PathBuf;
use steerwright_control::DesignOptions;
use steerwright_drivelog::LogOptions;
use steerwright_sysid::ChoiceOptions;
use steerwright_sysid::bicycle::BicycleOptions;
use steerwright_sysid::single_track::IdentifyVehicleOptions;
use steerwright_sysid::{IdentifyOptions, ValidationData};

/// Run all stages on the three recorded drives in this program
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder for all results
    #[arg(long, short, value_name = "DIR", default_value = "out")]
    out: PathBuf,
}

/// A file of `examples/drives`, carried in the program.
macro_rules! data {
    ($name:literal) => {
        ($name, include_str!(concat!("../../examples/drives/", $name)))
    };
}

type File = (&'static str, &'static str);

/// A recorded drive, with the options to read it.
struct DemoDrive {
    name: &'static str,
    logs: &'static [File],
    time: Option<&'static str>,
    input: &'static str,
    output: &'static str,
    speed: &'static str,
    /// Units of columns whose names do not state them.
    units: &'static [(&'static str, &'static str)],
    steering_ratio: Option<f64>,
    /// Steering angle at a command of 1, rad, where the command has no unit.
    steering_full_scale_rad: Option<f64>,
    /// The share of validation data.
    validation_fraction: f64,
    /// Largest rate of the steering servo, rad/s, if it is known.
    servo_rate_radps: Option<f64>,
    /// Of the standard road, m/s².
    lateral_acceleration: f64,
    vehicle: Option<File>,
    track: Option<File>,
}

const DRIVES: [DemoDrive; 3] = [
    DemoDrive {
        name: "multibody",
        logs: &[data!("multibody/drive.csv")],
        time: None,
        input: "steering_command_rad",
        output: "yaw_rate_radps",
        speed: "speed_mps",
        units: &[],
        steering_ratio: Some(1.0),
        steering_full_scale_rad: None,
        validation_fraction: 0.5,
        servo_rate_radps: Some(0.4),
        lateral_acceleration: 4.0,
        vehicle: Some(data!("multibody/vehicle.toml")),
        track: Some(data!("multibody/position.csv")),
    },
    DemoDrive {
        name: "comma2k19",
        logs: &[
            data!("comma2k19/steering_wheel_angle.csv"),
            data!("comma2k19/speed.csv"),
            data!("comma2k19/gyro.csv"),
        ],
        time: None,
        input: "steering_wheel_angle_deg",
        // The gyro's axes are forward, right, down: yaw rate to the left is the opposite.
        output: "-gyro_down_radps",
        speed: "speed_mps",
        units: &[],
        steering_ratio: Some(16.88),
        steering_full_scale_rad: None,
        validation_fraction: 0.5,
        servo_rate_radps: None,
        lateral_acceleration: 4.0,
        vehicle: Some(data!("comma2k19/vehicle.toml")),
        track: Some(data!("comma2k19/gnss_pose.csv")),
    },
    // Estimated on the first drive of this car, validated on the second.
    DemoDrive {
        name: "dart",
        logs: &[data!("dart/estimation.csv"), data!("dart/validation.csv")],
        time: Some("vicon time"),
        input: "steering",
        output: "vicon yaw",
        speed: "vel encoder",
        units: &[
            ("vicon time", "s"),
            ("steering", "1"),
            ("vicon yaw", "rad"),
            ("vel encoder", "m/s"),
        ],
        steering_ratio: None,
        steering_full_scale_rad: Some(0.375),
        validation_fraction: 0.4085,
        servo_rate_radps: None,
        // A lane change of 3.5 m is wide for a car of this size.
        lateral_acceleration: 1.0,
        vehicle: None,
        track: None,
    },
];

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let nothing: [PathBuf; 0] = [];
    let folder = Outputs::new(global.force, nothing).folder(&arguments.out, "demo")?;
    let mut built = Vec::new();
    for drive in &DRIVES {
        let files: Vec<(String, Vec<u8>)> =
            drive.logs.iter().map(|(name, text)| ((*name).into(), (*text).into())).collect();
        let mut log = steerwright_drivelog::read_log(
            &files,
            &LogOptions {
                input: Some(drive.input.into()),
                output: Some(drive.output.into()),
                speed: Some(drive.speed.into()),
                time: drive.time.map(Into::into),
                units: drive.units.iter().map(|(c, u)| ((*c).into(), (*u).into())).collect(),
                steering_ratio: drive.steering_ratio,
                steering_full_scale_rad: drive.steering_full_scale_rad,
                ..LogOptions::default()
            },
        )?;
        log.name = drive.name.into();
        let text = |(name, text): File| Text { name: name.into(), text: text.into() };
        let validation =
            ValidationData { fraction: drive.validation_fraction, ..ValidationData::default() };
        let state_space = IdentifyOptions { validation, ..IdentifyOptions::default() };
        built.push(pipeline::build(&Job {
            log,
            wanted: Wanted::Auto(Box::new(ChoiceOptions {
                state_space: state_space.clone(),
                bicycle: BicycleOptions { validation, ..BicycleOptions::default() },
                single_track: IdentifyVehicleOptions {
                    validation,
                    ..IdentifyVehicleOptions::default()
                },
            })),
            validation: state_space,
            design: DesignOptions {
                max_rate_radps: drive.servo_rate_radps,
                ..DesignOptions::default()
            },
            vehicle: drive.vehicle.map(text),
            track: drive.track.map(text),
            lateral_acceleration: drive.lateral_acceleration,
            folder: folder.stage().join(drive.name),
            out: arguments.out.join(drive.name),
            gate: GateArguments::default(),
        })?);
    }
    folder.commit()?;
    let all: Vec<_> = built.iter().map(overview::overview).collect();
    console::result(&overview::table(&built), &all)?;
    // A weakly excited drive is there to show that no controller is designed on its model.
    Ok(Outcome::Done)
}
