//! `steerwright demo`: everything, on the recorded drives that this program carries.

use crate::console;
use crate::failure::{Failure, Outcome};
use crate::gate::GateArguments;
use crate::output::Outputs;
use crate::pipeline::{self, Job, Text};
use crate::{Global, overview};
use control::DesignOptions;
use std::path::PathBuf;
use sysid::{IdentifyOptions, LogOptions};

/// Everything, on two recorded drives that come with this program
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder for everything
    #[arg(long, short, value_name = "DIR", default_value = "out")]
    out: PathBuf,
}

/// A file of `tests/data`, carried in the program.
macro_rules! data {
    ($name:literal) => {
        ($name, include_str!(concat!("../tests/data/", $name)))
    };
}

type File = (&'static str, &'static str);

/// A recorded drive and what one has to know to read it.
struct Drive {
    name: &'static str,
    logs: &'static [File],
    input: &'static str,
    output: &'static str,
    steering_ratio: Option<f64>,
    /// What the steering servo can follow, rad/s, where it is known.
    servo_rate_radps: Option<f64>,
    vehicle: File,
    track: File,
}

const DRIVES: [Drive; 2] = [
    Drive {
        name: "multibody",
        logs: &[data!("multibody/drive.csv")],
        input: "steering_command_rad",
        output: "yaw_rate_radps",
        steering_ratio: Some(1.0),
        servo_rate_radps: Some(0.4),
        vehicle: data!("multibody/vehicle.toml"),
        track: data!("multibody/position.csv"),
    },
    Drive {
        name: "comma2k19",
        logs: &[
            data!("comma2k19/steering_wheel_angle.csv"),
            data!("comma2k19/speed.csv"),
            data!("comma2k19/gyro.csv"),
        ],
        input: "steering_wheel_angle_deg",
        // The gyro's axes are forward, right, down: yaw rate to the left is the opposite.
        output: "-gyro_down_radps",
        steering_ratio: Some(16.88),
        servo_rate_radps: None,
        vehicle: data!("comma2k19/vehicle.toml"),
        track: data!("comma2k19/gnss_pose.csv"),
    },
];

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let nothing: [PathBuf; 0] = [];
    let folder = Outputs::new(global.force, nothing).folder(&arguments.out, "demo")?;
    let mut built = Vec::new();
    for drive in &DRIVES {
        let files: Vec<(String, Vec<u8>)> =
            drive.logs.iter().map(|(name, text)| ((*name).into(), (*text).into())).collect();
        let mut log = sysid::read_log(
            &files,
            &LogOptions {
                input: Some(drive.input.into()),
                output: Some(drive.output.into()),
                speed: Some("speed_mps".into()),
                steering_ratio: drive.steering_ratio,
                ..LogOptions::default()
            },
        )?;
        log.name = drive.name.into();
        let text = |(name, text): File| Text { name: name.into(), text: text.into() };
        built.push(pipeline::build(&Job {
            log,
            identify: IdentifyOptions::default(),
            design: DesignOptions {
                max_rate_radps: drive.servo_rate_radps,
                ..DesignOptions::default()
            },
            vehicle: Some(text(drive.vehicle)),
            track: Some(text(drive.track)),
            lateral_acceleration: 4.0,
            folder: folder.stage().join(drive.name),
            out: arguments.out.join(drive.name),
            gate: GateArguments::default(),
        })?);
    }
    folder.commit()?;
    let all: Vec<_> = built.iter().map(overview::of).collect();
    console::result(&overview::table(&built), &all)?;
    // A weakly excited drive is there to show that no controller is designed on its model.
    Ok(Outcome::Done)
}
