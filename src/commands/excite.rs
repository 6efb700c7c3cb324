//! `steerwright excite`: the manoeuvre that identifies a vehicle best.

use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::quantity::{self, FrequencyRange, SpeedRange};
use crate::output::{OutputKind, Outputs};
use crate::terminal::console;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use steerwright_formats::{
    Bicycle, Manoeuvre, ManoeuvreGoal, ManoeuvreLimits, Model, SourceFile, Vehicle,
};
use steerwright_report::{manoeuvre_page, manoeuvre_sections};
use steerwright_sysid::{ExcitationOptions, excite, excite_vehicle};

/// Standard deviation of a gyro where no model states its noise, rad/s: 0.1 °/s.
const USUAL_NOISE_RADPS: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Largest lateral acceleration where none is stated, m/s².
const USUAL_ACCELERATION_MPS2: f64 = 3.0;
/// Standard deviation of the friction by the prior of the single-track model, relative.
const UNKNOWN_FRICTION: f64 = 0.3;
/// Speeds that are driven of a range.
const SPEEDS_OF_A_RANGE: usize = 3;
/// Names of the files in a folder.
const NAMES: [&str; 3] = ["excitation.json", "excitation.csv", "excitation.html"];

/// Design the manoeuvre to record: the steering that identifies the vehicle best, within limits
///
/// From a bicycle, a vehicle, or the vehicle data of `bicycle`, it computes the steering from which `identify --structure
/// bicycle` determines the response from steering angle to yaw rate or the understeer gradient best, or `identify --structure
/// single-track` the friction of the tyres, and the standard errors to expect. The manoeuvre is driven in blocks at steady speed,
/// each of which begins and ends straight. For a robot or drive-by-wire it is a multisine with optimised amplitudes and phases; for a
/// driver the best of sweep, slalom and lane changes; for the tyre limit the best of these, of a slalom that grows and of an
/// angle that rises slowly, each up to the largest lateral acceleration.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// bicycle.json or vehicle.json, also of a weak log, or vehicle data (TOML)
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Folder for excitation.json, excitation.csv (time_s, steering_rad, speed_mps) and excitation.html; or one of them, by
    /// its ending
    #[arg(long = "output", short = 'o', value_name = "FILE", default_value = "excitation")]
    out: PathBuf,
    /// What is to be known: the response in the band, the understeer gradient, or the friction of the tyres; the understeer gradient
    /// needs two speeds, the friction a large lateral acceleration
    #[arg(long, value_name = ManoeuvreGoal::WORDS, default_value = "response")]
    goal: ManoeuvreGoal,
    /// Who steers; at the tyre limit both steer the same
    #[arg(long, value_name = "WHO", default_value = "robot")]
    by: SteeredBy,
    /// Speed; by default that of the model, and half of it where the goal is the understeer gradient
    #[arg(long, value_name = "SPEED", conflicts_with = "speeds", allow_hyphen_values = true, value_parser = quantity::speed)]
    speed: Option<f64>,
    /// Range of speeds, of which the lowest, the middle (not of --goal understeer) and the highest are driven for equal times, such as
    /// 10..25
    #[arg(long, value_name = "RANGE")]
    speeds: Option<SpeedRange>,
    /// Time of the recording, of which the first half estimates and the second validates
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "120s")]
    time: f64,
    /// Length of a block: its signal and 2 s straight
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "20s")]
    block: f64,
    /// Band in which the response is to be known; of other goals that of the steering
    #[arg(long, value_name = "RANGE", default_value = "0.2..2Hz")]
    band: FrequencyRange,
    /// Largest error of the response in the band, as two standard errors of the gain (relative) and of the phase (100% are
    /// 1 rad); the exit status is 1 if it is not reached in the time
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    response_error: Option<f64>,
    /// Largest error of the understeer gradient at the road wheel, as two standard errors, such as 0.1deg/g; of --goal understeer,
    /// with the same exit status
    #[arg(long, value_name = "GRADIENT", allow_hyphen_values = true, value_parser = quantity::gradient)]
    understeer_error: Option<f64>,
    /// Largest error of the friction coefficients of both axles, as two standard errors, relative; of --goal tyre-limit, with the
    /// same exit status
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    friction_error: Option<f64>,
    /// Largest lateral acceleration [default: 3m/s2; to be stated for --goal tyre-limit]
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true, value_parser = quantity::acceleration)]
    max_lateral_acceleration: Option<f64>,
    /// Largest steering angle, in steering coordinates
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_angle: Option<f64>,
    /// Largest rate of the steering angle, in steering coordinates
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    max_rate: Option<f64>,
    /// Width of the road, within which the vehicle stays
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = quantity::length)]
    road_width: Option<f64>,
    /// Width of the vehicle
    #[arg(long, value_name = "LENGTH", requires = "road_width", allow_hyphen_values = true, value_parser = quantity::length, default_value = "2m")]
    vehicle_width: f64,
    /// Standard deviation of the yaw rate's noise at each sample; by default that of the log which the model is from,
    /// otherwise 0.1deg/s
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    noise: Option<f64>,
    /// Standard deviation of each axle's cornering stiffness where the model states no uncertainty, and of a vehicle's friction; the
    /// limits leave room for it
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent, default_value = "10%")]
    uncertainty: f64,
    /// Time from one sample to the next, of the steering and of the log
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "10ms")]
    sample_time: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum SteeredBy {
    /// A steering robot or drive-by-wire: a multisine
    Robot,
    /// A driver with a metronome: sweep, slalom or lane changes
    Driver,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let mut outputs = Outputs::new(global.force, [&arguments.model]);
    let ending = arguments.out.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let place = |k: usize| -> Option<PathBuf> {
        match ending {
            "json" | "csv" | "html" if NAMES[k].ends_with(ending) => Some(arguments.out.clone()),
            "json" | "csv" | "html" => None,
            _ => Some(arguments.out.join(NAMES[k])),
        }
    };
    let document = outputs.optional(place(0).as_ref(), OutputKind::for_document::<Manoeuvre>())?;
    let table = outputs.optional(place(1).as_ref(), OutputKind::Manoeuvre)?;
    let page = outputs.optional(place(2).as_ref(), OutputKind::Html)?;
    let Subject { bicycle, vehicle, source } = model(&arguments.model)?;
    let options = options(arguments, &bicycle, vehicle.as_ref())?;
    let mut manoeuvre = match &vehicle {
        Some(vehicle) if arguments.goal == ManoeuvreGoal::TyreLimit => {
            excite_vehicle(vehicle, &options)?
        }
        _ => excite(&bicycle, &options)?,
    };
    manoeuvre.provenance.sources = vec![source];
    if let Some(out) = &document {
        out.document(&manoeuvre)?;
    }
    if let Some(out) = &table {
        out.write(csv(&manoeuvre).as_bytes())?;
    }
    if let Some(out) = &page {
        out.write(manoeuvre_page(&manoeuvre).as_bytes())?;
    }
    if let Some(warning) = uncertain(&manoeuvre) {
        console::warning(warning);
    }
    // Half a second is no block.
    if manoeuvre.time_s() + 0.5 < arguments.time {
        console::warning(format!(
            "{:.0} s of the {:.0} s are used: each half has the same number of blocks of {:.0} s at each speed (--block)",
            manoeuvre.time_s(),
            arguments.time,
            manoeuvre.block_s
        ));
    }
    for note in hints(&manoeuvre, vehicle.is_some()) {
        console::note(note);
    }
    if bicycle.ensemble_dimension() == 0 {
        console::note(format!(
            "the model states no uncertainty: {:.0} % of each cornering stiffness are assumed (--uncertainty)",
            arguments.uncertainty
        ));
    }
    let structure = match arguments.goal {
        ManoeuvreGoal::TyreLimit => "single-track",
        ManoeuvreGoal::Response | ManoeuvreGoal::Understeer => "bicycle",
    };
    // Blocks that are shared by excitation would put a speed into one part only.
    let place = if options.speeds_mps.len() > 1 { " --validation-place end" } else { "" };
    let next = format!(
        "drive it, record steering angle, yaw rate and speed, then steerwright identify LOG --structure {structure}{place}"
    );
    let page = console::page(&manoeuvre_sections(&manoeuvre), Some(&next));
    console::result(&page, &manoeuvre)?;
    console::note(format!("written to {}", arguments.out.display()));
    Ok(Outcome::when(manoeuvre.expected.met))
}

/// What a file states of a vehicle.
struct Subject {
    bicycle: Bicycle,
    /// Up to the limit of grip, where the file has it.
    vehicle: Option<Vehicle>,
    source: SourceFile,
}

fn model(path: &Path) -> Result<Subject, Failure> {
    let text = files::read_text(path)?;
    let name = path.display().to_string();
    let source = SourceFile::from_bytes(path, text.as_bytes());
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let bicycle = steerwright_control::bicycle_from_toml(&text, &name)?;
        return Ok(Subject { bicycle, vehicle: None, source });
    }
    let model = Model::from_json(&text, &name)?;
    if let Some(bicycle) = steerwright_control::model_bicycle(&model)? {
        let vehicle = steerwright_control::model_vehicle(&model).cloned();
        return Ok(Subject { bicycle, vehicle, source });
    }
    let (what, hint) = if model.plant().is_some() {
        (
            "the manoeuvre is designed by the parameters of a bicycle, which a plant in state space has not",
            "identify a bicycle from the same log: steerwright identify LOG --structure bicycle; or use vehicle data (TOML)",
        )
    } else {
        (
            "the manoeuvre is designed by the parameters of a bicycle, and this model is none",
            "use a bicycle.json, a vehicle.json, or vehicle data (TOML)",
        )
    };
    Err(Failure::in_file(path, what, hint.into()))
}

/// Where the stated error is that of another goal.
fn max_error(arguments: &Arguments) -> Result<Option<f64>, Failure> {
    let mut stated = None;
    for (option, goal, error) in [
        ("--response-error", ManoeuvreGoal::Response, arguments.response_error.map(|x| 0.01 * x)),
        ("--understeer-error", ManoeuvreGoal::Understeer, arguments.understeer_error),
        ("--friction-error", ManoeuvreGoal::TyreLimit, arguments.friction_error.map(|x| 0.01 * x)),
    ] {
        if error.is_some() && goal != arguments.goal {
            let message =
                format!("{option}: the manoeuvre is designed with --goal {}", arguments.goal);
            return Err(Failure::new(
                message,
                format!("state --goal {goal}, or leave {option} out"),
            ));
        }
        stated = stated.or(error);
    }
    Ok(stated)
}

fn options(
    arguments: &Arguments,
    bicycle: &Bicycle,
    vehicle: Option<&Vehicle>,
) -> Result<ExcitationOptions, Failure> {
    let max_lateral_acceleration_mps2 = match (arguments.max_lateral_acceleration, arguments.goal) {
        (Some(stated), _) => stated,
        (None, ManoeuvreGoal::TyreLimit) => {
            return Err(Failure::new(
                "--goal tyre-limit: the largest lateral acceleration must be stated",
                "state what vehicle, tyres and place allow, such as --max-lateral-acceleration 7m/s2",
            ));
        }
        (None, _) => USUAL_ACCELERATION_MPS2,
    };
    let speeds_mps = match (&arguments.speeds, arguments.speed) {
        (Some(SpeedRange([low, high])), _) => {
            if low >= high {
                let message = format!("--speeds {low}..{high}: the first speed must be the lower");
                return Err(Failure::new(message, "name the lower speed first, such as 10..25"));
            }
            // The ends alone determine a steady gain over speed best.
            let count =
                if arguments.goal == ManoeuvreGoal::Understeer { 2 } else { SPEEDS_OF_A_RANGE };
            let at = |k: usize| low + (high - low) * k as f64 / (count - 1) as f64;
            (0..count).map(at).collect()
        }
        (None, Some(speed)) => vec![speed],
        // From one speed the gradient and the wheelbase are not determined apart.
        (None, None) if arguments.goal == ManoeuvreGoal::Understeer => {
            vec![0.5 * bicycle.vehicle.speed_mps, bicycle.vehicle.speed_mps]
        }
        (None, None) => vec![bicycle.vehicle.speed_mps],
    };
    let max_offset_m = match arguments.road_width {
        Some(road) if road <= arguments.vehicle_width => {
            let message =
                format!("--road-width {road} m: the vehicle is {} m wide", arguments.vehicle_width);
            return Err(Failure::new(
                message,
                "state a wider road, or the width of the vehicle with --vehicle-width",
            ));
        }
        Some(road) => Some(0.5 * (road - arguments.vehicle_width)),
        None => None,
    };
    let of_log = match vehicle {
        Some(vehicle) => vehicle.evidence.as_ref().and_then(|e| e.yaw_rate_noise_density),
        None => bicycle.evidence.as_ref().and_then(|e| e.noise_density()),
    };
    let noise_density = match (arguments.noise, of_log) {
        (Some(stated), _) => stated * stated * arguments.sample_time,
        (None, Some(density)) => density,
        (None, None) => USUAL_NOISE_RADPS * USUAL_NOISE_RADPS * arguments.sample_time,
    };
    Ok(ExcitationOptions {
        goal: arguments.goal,
        speeds_mps,
        time_s: arguments.time,
        block_s: arguments.block,
        band_hz: arguments.band.0,
        max_error: max_error(arguments)?,
        limits: ManoeuvreLimits {
            max_lateral_acceleration_mps2,
            max_angle_rad: arguments.max_angle,
            max_rate_radps: arguments.max_rate,
            max_offset_m,
        },
        noise_density,
        sample_time_s: arguments.sample_time,
        by_driver: arguments.by == SteeredBy::Driver,
        assumed_uncertainty: 0.01 * arguments.uncertainty,
    })
}

/// What would determine the goal better.
fn hints(manoeuvre: &Manoeuvre, is_vehicle: bool) -> Vec<String> {
    let mut hints = Vec::new();
    let error = manoeuvre.expected.largest_error;
    match manoeuvre.purpose.goal {
        ManoeuvreGoal::Response => {}
        ManoeuvreGoal::Understeer => {
            let first = manoeuvre.signals.first().map(|signal| signal.speed_mps);
            if manoeuvre.signals.iter().all(|signal| Some(signal.speed_mps) == first) {
                hints.push("one speed hardly determines the understeer gradient; state two with --speeds, such as 10..25".into());
            }
        }
        ManoeuvreGoal::TyreLimit => {
            if error > 0.5 * UNKNOWN_FRICTION {
                hints.push(format!(
                    "the manoeuvre hardly determines the friction, whose prior has a standard deviation of {:.0} %; more lateral acceleration does (--max-lateral-acceleration)",
                    100.0 * UNKNOWN_FRICTION
                ));
            }
            if !is_vehicle {
                hints.push("the model states no friction: 1.0 with a standard deviation of 30 % is assumed; design again on the vehicle.json of the first recording".into());
            }
        }
    }
    hints
}

/// Where the uncertainty of the model takes a third of a limit.
fn uncertain(manoeuvre: &Manoeuvre) -> Option<&'static str> {
    let is_uncertain = manoeuvre.signals.iter().any(|signal| {
        let [nominal, upper] = signal.peaks.lateral_acceleration_mps2;
        upper > 1.5 * nominal
    });
    if is_uncertain {
        Some(
            "within the uncertainty of the model the lateral acceleration may be more than 1.5 times that of the model, for which the limits leave room; design again on the model of the first recording",
        )
    } else {
        None
    }
}

/// A row for each sample: `time_s`, `steering_rad`, `speed_mps`.
fn csv(manoeuvre: &Manoeuvre) -> String {
    let mut text = String::from("time_s,steering_rad,speed_mps\n");
    let count = manoeuvre.block_samples();
    for (b, block) in manoeuvre.schedule.iter().enumerate() {
        let speed = manoeuvre.signals.get(block.signal).map_or(0.0, |signal| signal.speed_mps);
        for k in 0..count {
            let time = manoeuvre.sample_time_s * (b * count + k) as f64;
            let angle = manoeuvre.steering_rad(block, k);
            let _ = writeln!(text, "{time:.4},{angle:.7},{speed:.3}");
        }
    }
    text
}
