//! `steerwright path`: a reference path from recorded points or from a standard road.

use crate::documents::feasibility::Feasibility;
use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::profile::ProfileArguments;
use crate::options::quantity;
use crate::output::{OutputKind, Outputs};
use crate::terminal::{console, profile_summary};
use std::path::{Path, PathBuf};
use steerwright_control::Sideslip;
use steerwright_control::paths::{self, FixOptions, PointOptions, PoorFixes};
use steerwright_formats::{Document, Model, Path as PathFile, Pid, SourceFile};
use steerwright_report::{WIDTH, figures};

/// Height of the figure of a profile, px.
const PLOT_HEIGHT: u32 = 760;

/// Make a reference path from recorded points (CSV: x_m, y_m or latitude_deg, longitude_deg; GPX;
/// NMEA: GGA, RMC) or from segments (TOML)
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Points of the track; without it the standard road: a double lane change and an S-curve
    #[arg(value_name = "TRACK")]
    track: Option<PathBuf>,
    /// Write the path here
    #[arg(long = "output", short = 'o', value_name = "FILE", default_value = "path.json")]
    out: PathBuf,
    /// Speed along the path
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = quantity::speed, default_value = "15m/s")]
    speed: f64,
    /// Largest lateral acceleration of the standard road
    #[arg(long, value_name = "ACCELERATION", conflicts_with = "track", allow_hyphen_values = true, value_parser = quantity::acceleration, default_value = "4m/s2")]
    lateral_acceleration: f64,
    /// Connect the last point of the track with its first
    #[arg(long, requires = "track")]
    closed: bool,
    /// Largest distance of a recorded point from the path; by default the noise of the points,
    /// and 0.1 m for the mean of neighbours. Smoothing is reduced to stay within it; the exit status is 1
    /// if it is exceeded
    #[arg(long, value_name = "LENGTH", requires = "track", allow_hyphen_values = true, value_parser = quantity::length)]
    max_deviation: Option<f64>,
    /// Use of fixes with fewer than 5 satellites or without correction, if GPX or NMEA report both
    #[arg(long, value_name = "WHAT", requires = "track", default_value = "refuse")]
    poor_fixes: PoorFixesName,
    /// Controller that will follow the path: sets feedforward and preview. A road that needs more than 0.9 of its
    /// lateral acceleration, steering angle or steering rate is reported, with the place and the speed at which it needs no more
    #[arg(long, value_name = "PID.json")]
    pid: Option<PathBuf>,
    /// plant.json, bicycle.json or vehicle.json of the vehicle that will follow the path: sets its
    /// sideslip, with its growth in tight turns and its lead in changing turns
    #[arg(long, value_name = "FILE.json")]
    plant: Option<PathBuf>,
    /// Sideslip angle per yaw rate of the vehicle in a steady turn, such as -40ms: course minus yaw;
    /// by default that of --plant, otherwise 0
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    sideslip_per_yaw_rate: Option<f64>,
    /// Gain of the integral of the cross-track error, such as 0.05/s; none by default
    #[arg(long, value_name = "PER_SECOND", allow_hyphen_values = true, value_parser = quantity::rate, default_value = "0/s")]
    cross_track_integral: f64,
    /// Draw the speed profile here (SVG): speed and accelerations over the distance, and which limit binds where
    #[arg(long, value_name = "FILE", requires = "profile")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    profile: ProfileArguments,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum PoorFixesName {
    /// They are excluded
    Refuse,
    /// They are used, and reported
    Mark,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let speed_controller = &arguments.profile.speed_controller;
    let inputs = [&arguments.track, &arguments.pid, &arguments.plant, speed_controller];
    let inputs = inputs.into_iter().flatten();
    let mut outputs = Outputs::new(global.force, inputs);
    let out = outputs.file(&arguments.out, OutputKind::for_document::<PathFile>())?;
    let plot =
        arguments.plot.as_ref().map(|file| outputs.file(file, OutputKind::Svg)).transpose()?;
    let mut outcome = Outcome::Done;
    let (mut path, mut notes) = match &arguments.track {
        None => (paths::reference_road(arguments.speed, arguments.lateral_acceleration)?, vec![]),
        Some(track) if track.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) => {
            if arguments.max_deviation.is_some() {
                let hint = "omit --max-deviation, or use recorded points";
                return Err(Failure::in_file(track, "segments are kept exactly", hint.into()));
            }
            if arguments.closed {
                let hint = "omit --closed, or record the points of a lap";
                return Err(Failure::in_file(track, "a road of segments has ends", hint.into()));
            }
            let text = files::read_text(track)?;
            let path = paths::path_from_road(&text, &track.display().to_string(), arguments.speed)?;
            (of_this_version(path, track, &text), vec![])
        }
        Some(track) => {
            let (path, notes, excess) = recorded(arguments, track)?;
            if let Some(excess) = excess {
                console::warning(excess);
                outcome = Outcome::RequirementNotMet;
            }
            (path, notes)
        }
    };
    let mut controller = None;
    if let Some(file) = &arguments.pid {
        let (pid, source) = files::read_document::<Pid>(file)?;
        path.guidance = steerwright_control::guidance_for(&pid, arguments.speed);
        path.schedule = steerwright_control::guidance_schedule(&pid);
        path.provenance.sources.push(source);
        controller = Some(pid);
    } else {
        notes.push("no feedforward: --pid sets it for a controller".into());
    }
    let (model, sideslip) = vehicle(arguments, &mut path, &mut notes)?;
    path.guidance = steerwright_control::with_sideslip(path.guidance, &sideslip, arguments.speed);
    path.guidance.cross_track_integral_gain_per_s = arguments.cross_track_integral;
    if arguments.profile.profile {
        let limited = arguments.profile.limits(
            arguments.speed,
            path.closed,
            controller.as_ref(),
            model.as_ref(),
        )?;
        path.provenance.sources.extend(limited.sources);
        notes.extend(limited.notes);
        let [of_drive, of_brake] = limited.preview_s;
        path.guidance.speed_preview_time_s = of_drive;
        path.guidance.brake_preview_time_s = of_brake;
        path.profile = Some(steerwright_control::speed_profile(&path, &limited.limits)?);
    }
    path.checked("the path's guidance")?;
    if let Some(pid) = &controller {
        let feasibility = Feasibility::new(&path, pid, model.as_ref())?;
        feasibility.warnings.iter().for_each(console::warning);
        notes.extend(feasibility.note);
    }
    out.document(&path)?;
    notes.iter().for_each(console::note);
    let profile = path.profile.as_ref().map(profile_summary::summary);
    let text: Vec<String> = [Some(extent(&path)), profile].into_iter().flatten().collect();
    console::result(&text.join("\n"), &path)?;
    console::note(format!("written to {out}"));
    if let (Some(plot), Some(profile)) = (&plot, &path.profile) {
        let figure = figures::speed_profile(&path, profile);
        plot.write(figure.to_svg(WIDTH, PLOT_HEIGHT)?.as_bytes())?;
        console::note(format!("written to {plot}"));
    }
    Ok(outcome)
}

/// The model of the vehicle, and the sideslip: the stated one, otherwise that of the model, otherwise none.
fn vehicle(
    arguments: &Arguments,
    path: &mut PathFile,
    notes: &mut Vec<String>,
) -> Result<(Option<Model>, Sideslip), Failure> {
    let given = arguments
        .sideslip_per_yaw_rate
        .map(|per_yaw_rate| Sideslip { per_yaw_rate, ..Sideslip::default() });
    let Some(file) = &arguments.plant else {
        return Ok((None, given.unwrap_or_default()));
    };
    let text = files::read_text(file)?;
    let name = file.display().to_string();
    if !Model::is_in(&text) {
        let hint = "use a plant.json, bicycle.json or vehicle.json";
        return Err(Failure::in_file(file, "no plant, bicycle or vehicle", hint.into()));
    }
    let model = Model::from_json(&text, &name)?;
    let other = if model.multivariable().is_some() {
        Some("a plant of named channels follows no path")
    } else if model.longitudinal().is_some() {
        Some("a model of the speed has no steering to follow a path with")
    } else if !model.structure().is_lateral() {
        Some("the model's input is no steering angle, which follows a path")
    } else {
        None
    };
    if let Some(problem) = other {
        let hint = "use a plant.json from steering to yaw rate, bicycle.json or vehicle.json";
        return Err(Failure::in_file(file, problem, hint.into()));
    }
    let stated = steerwright_control::sideslip(&text, &name, Some(arguments.speed))?;
    path.provenance.sources.push(SourceFile::from_bytes(file, text.as_bytes()));
    let sideslip = match (given, stated) {
        (Some(given), _) => given,
        (None, Some(stated)) => {
            notes.push(format!("{}, from {name}", in_words(&stated)));
            stated
        }
        (None, None) => {
            notes.push(format!("{name} states no sideslip: 0 is used"));
            Sideslip::default()
        }
    };
    Ok((Some(model), sideslip))
}

/// The terms that are not 0.
fn in_words(sideslip: &Sideslip) -> String {
    let mut text = format!("sideslip {:.1} ms per yaw rate", 1e3 * sideslip.per_yaw_rate);
    if sideslip.growth != 0.0 {
        let grown = 1e3 * sideslip.growth;
        text += &format!(" and {grown:.2} ms more per (m/s²)² of lateral acceleration");
    }
    if sideslip.per_yaw_acceleration != 0.0 {
        text += &format!(", {:.4} s2 per yaw acceleration", sideslip.per_yaw_acceleration);
    }
    if sideslip.distance_rear != 0.0 {
        let (speed, distance) = (sideslip.reference_speed, sideslip.distance_rear);
        text += &format!(
            ", all at {speed:.1} m/s; rear axle {distance:.2} m behind the centre of gravity"
        );
    }
    text
}

/// The path of recorded points, its notes, and whether it is further off the points than it may be.
fn recorded(
    arguments: &Arguments,
    track: &Path,
) -> Result<(PathFile, Vec<String>, Option<String>), Failure> {
    let text = files::read_text(track)?;
    let poor = match arguments.poor_fixes {
        PoorFixesName::Refuse => PoorFixes::Refuse,
        PoorFixesName::Mark => PoorFixes::Mark,
    };
    let options = PointOptions {
        speed: arguments.speed,
        closed: arguments.closed,
        max_deviation: arguments.max_deviation,
        fixes: FixOptions { poor, ..FixOptions::default() },
        ..PointOptions::default()
    };
    let recorded = paths::path_from_recording(&text, &track.display().to_string(), &options)
        .map_err(|e| match e {
            steerwright_control::Error::PointFile { .. }
            | steerwright_control::Error::PoorFixes { .. } => e.into(),
            e => Failure::in_file(track, &e, e.hint()),
        })?;
    recorded.warnings.iter().for_each(console::warning);
    let notes = vec![format!(
        "smoothed over {:.1} m; the points are {:.3} m (RMS) and at most {:.3} m off (at x {:.1} m, y {:.1} m), their noise is {:.3} m",
        recorded.smoothing_length_m,
        recorded.rms_distance_m,
        recorded.largest_distance_m,
        recorded.furthest_point_m[0],
        recorded.furthest_point_m[1],
        recorded.noise_m,
    )];
    let excess = recorded.excess.map(|excess| {
        format!(
            "deviation exceeded: {excess}; allow more with --max-deviation, or record more points there"
        )
    });
    Ok((of_this_version(recorded.path, track, &text), notes, excess))
}

/// The path with the file that it was made from.
fn of_this_version(mut path: PathFile, track: &Path, text: &str) -> PathFile {
    path.provenance.version = env!("CARGO_PKG_VERSION").into();
    path.provenance.sources = vec![SourceFile::from_bytes(track, text.as_bytes())];
    path
}

/// Length, points, curvature and lateral acceleration.
fn extent(path: &PathFile) -> String {
    let length = path.points.last().map_or(0.0, |p| p.distance_m);
    let curvature = path.points.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max);
    format!(
        "{}: {length:.1} m, {} points, curvature up to {curvature:.4} 1/m, {:.2} m/s² at {:.1} m/s",
        path.name,
        path.points.len(),
        curvature * path.speed_mps * path.speed_mps,
        path.speed_mps
    )
}
