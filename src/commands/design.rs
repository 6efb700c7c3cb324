//! `steerwright design`: a PID controller to a specification.

use crate::documents::feasibility;
use crate::documents::gate::GateArguments;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::quantity::SpeedRange;
use crate::options::specification::{SpecificationArguments, Specified};
use crate::output::{Files, OutputKind, Outputs};
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::path::{Path, PathBuf};
use steerwright_control::{DesignPlant, SpeedDesignOptions};
use steerwright_formats::{Longitudinal, Pid, SourceFile, SpeedController};
use steerwright_report::figures::{self, OpenLoop, SpeedResponse};
use steerwright_report::{
    Controller, Figure, StepResponse, WIDTH, controller_section, speed_controller_section,
};

/// Points of the loop's frequency response.
const POINTS: usize = 600;

/// The figure of a speed controller, and its height, px.
const SPEED_PLOT: &str = "speed-steps.svg";
const SPEED_HEIGHT: u32 = 760;

const PLOTS: [&str; 4] = ["bode.svg", "nyquist.svg", "step.svg", "step-with-offset.svg"];

/// Design a PID steering controller (eq 14) on a plant, bicycle or vehicle file, or a speed controller on a longitudinal
/// file
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json, bicycle.json, vehicle.json or longitudinal.json
    #[arg(value_name = "MODEL.json")]
    plant: PathBuf,
    /// Write the controller here; by default pid.json, or speed_controller.json of a longitudinal model
    #[arg(long = "output", short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// Design for a range of speeds, such as 5..30 (m/s) or 18..108km/h: a table of gains and guidance over
    /// speed. Requires a model that holds at other speeds, such as bicycle.json or
    /// vehicle.json. Of longitudinal.json the range is by default that of its drive
    #[arg(long, value_name = "RANGE")]
    pub(crate) speeds: Option<SpeedRange>,
    /// Write plots (SVG) into this folder: Bode, Nyquist and step; of a speed controller its steps and the grade
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) gate: GateArguments,
    #[command(flatten)]
    pub(crate) specification: SpecificationArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let inputs = std::iter::once(&arguments.plant).chain(arguments.specification.files());
    let mut outputs = Outputs::new(global.force, inputs);
    let (model, source, document) = arguments.gate.read(&arguments.plant)?;
    if let Some(longitudinal) = model.longitudinal() {
        return speed(arguments, longitudinal, &source, &mut outputs);
    }
    let place = arguments.out.clone().unwrap_or_else(|| "pid.json".into());
    let out = outputs.file(place, OutputKind::for_document::<Pid>())?;
    let decided = |folder| outputs.files(folder, PLOTS, OutputKind::Svg);
    let files = arguments.plots.as_deref().map(decided).transpose()?;
    let specified = arguments.specification.read()?;
    let plant = DesignPlant::from_model(&model)
        .map_err(|e| Failure::in_file(&arguments.plant, &e, e.hint()))?;
    let progress = Progress::start("designing");
    let pid = designed(&document, &plant, &source, arguments.speeds, &specified, |what| {
        progress.now(what);
    })?;
    drop(progress);
    out.document(&pid)?;
    let mut written = vec![format!("written to {out}")];
    if let Some(files) = &files {
        for file in plots(files, &plant, &pid)? {
            written.push(format!("written to {}", file.display()));
        }
    }
    let warnings = feasibility::on_standard_road(&pid, &model)?;
    let by_all = pid.evidence.robustness.as_ref().is_none_or(|r| r.met);
    let met = pid.evidence.over_speed.as_ref().map_or(pid.evidence.met, |o| o.met);
    let next = if met && pid.designed_for.quality.allows_design() {
        Some(format!("steerwright package {} {out}", arguments.plant.display()))
    } else {
        None
    };
    let section = controller_section(&Controller { name: &pid.name, pid: &pid, in_loop: None });
    console::result(&console::page(&[section], next.as_deref()), &pid)?;
    warnings.iter().for_each(console::warning);
    written.iter().for_each(console::note);
    Ok(Outcome::when(met && (by_all || !specified.must_be_robust)))
}

/// A speed controller on a longitudinal model.
fn speed(
    arguments: &Arguments,
    model: &Longitudinal,
    source: &SourceFile,
    outputs: &mut Outputs,
) -> Result<Outcome, Failure> {
    let place = arguments.out.clone().unwrap_or_else(|| "speed_controller.json".into());
    let out = outputs.file(place, OutputKind::for_document::<SpeedController>())?;
    let decided = |folder| outputs.files(folder, [SPEED_PLOT], OutputKind::Svg);
    let files = arguments.plots.as_deref().map(decided).transpose()?;
    let specified = arguments.specification.read_speed(arguments.speeds.map(|range| range.0))?;
    let progress = Progress::start("designing");
    let controller = speed_controller(model, source, &specified.design, |what| progress.now(what))?;
    drop(progress);
    out.document(&controller)?;
    let next = if controller.quality.allows_design() {
        Some(format!("steerwright package {} {out}", arguments.plant.display()))
    } else {
        None
    };
    let section = speed_controller_section(&controller);
    console::result(&console::page(&[section], next.as_deref()), &controller)?;
    console::note(format!("written to {out}"));
    if let Some(files) = &files {
        let figure = speed_figure(&controller)?.to_svg(WIDTH, SPEED_HEIGHT)?;
        let file = files.write(SPEED_PLOT, figure.as_bytes())?;
        console::note(format!("written to {}", file.display()));
    }
    let by_all = controller.evidence.ensemble.is_none_or(|e| e.keeping == e.vehicles);
    Ok(Outcome::when(controller.evidence.met && (by_all || !specified.must_be_robust)))
}

/// The responses of a speed controller at the speeds of its evidence.
fn speed_figure(controller: &SpeedController) -> Result<Figure, Failure> {
    let s = &controller.specification;
    let mut responses = Vec::new();
    for row in &controller.evidence.speeds {
        let speed = row.speed_mps;
        let [up, down, on_grade] = steerwright_control::speed_traces(controller, speed)?;
        let change = |speeds: Vec<f64>, from: f64| speeds.iter().map(|v| v - from).collect();
        responses.push(SpeedResponse {
            speed_mps: speed,
            up_mps: change(up, speed),
            down_mps: change(down, speed + s.step_mps),
            on_grade_mps: change(on_grade, speed),
        });
    }
    Ok(figures::speed_steps(s, controller.sample_time_s, &responses))
}

/// The speed controller, verified in the loop of FMUs. `now` is called with what is being done.
pub(crate) fn speed_controller(
    model: &Longitudinal,
    source: &SourceFile,
    options: &SpeedDesignOptions,
    now: impl Fn(&str),
) -> Result<SpeedController, Failure> {
    let mut controller = steerwright_control::design_speed(model, source, options)?;
    now("running the loop of FMUs");
    steerwright_comparison::verify_speed(&mut controller)?;
    Ok(controller)
}

/// The controller, verified in the loop of FMUs. `now` is called with what is being done.
pub(crate) fn designed(
    document: &str,
    plant: &DesignPlant,
    source: &SourceFile,
    speeds: Option<SpeedRange>,
    specified: &Specified,
    now: impl Fn(&str),
) -> Result<Pid, Failure> {
    let Some(SpeedRange(speeds)) = speeds else {
        let mut pid = steerwright_control::design(plant, source, &specified.design)?;
        now("running the loop of FMUs");
        steerwright_comparison::verify(&mut pid, document, plant)?;
        return Ok(pid);
    };
    let options = specified.over_speeds();
    let mut pid =
        steerwright_control::design_over_speeds(plant, source, &options, speeds, &|what| {
            now(what)
        })?;
    now("running the loop of FMUs");
    // The FMU of a model outside the range is run at the speed of the design.
    let plant = plant.at_speed(pid.designed_for.speed_mps)?;
    let document = plant.document().unwrap_or_else(|| document.to_owned());
    steerwright_comparison::verify(&mut pid, &document, &plant)?;
    Ok(pid)
}

/// Writes the plots; where they are.
fn plots<'a>(files: &'a Files, plant: &DesignPlant, pid: &Pid) -> Result<Vec<&'a Path>, Failure> {
    figures(plant, pid)?
        .iter()
        .map(|(name, figure, height)| files.write(name, figure.to_svg(WIDTH, *height)?.as_bytes()))
        .collect()
}

/// The figures of a controller, behind the actuator that it was designed for, each with the name of its file and its height, px.
pub(crate) fn figures(
    plant: &DesignPlant,
    pid: &Pid,
) -> Result<[(&'static str, Figure, u32); 4], Failure> {
    let plant = &plant.behind(pid.designed_for.actuator);
    let points = steerwright_control::loop_response(plant, pid, POINTS)?;
    let open = OpenLoop {
        frequency_hz: points.iter().map(|p| p.frequency_hz).collect(),
        real: points.iter().map(|p| p.real).collect(),
        imaginary: points.iter().map(|p| p.imaginary).collect(),
        margins: pid.evidence.margins,
        required_modulus_margin: pid.specification.modulus_margin,
    };
    let until = pid.specification.settling_time_s.unwrap_or(1.0);
    let until = (3.0 * until).min(pid.specification.steady_state_time_s);
    let step = |with_offset: bool, until: f64| -> Result<StepResponse, Failure> {
        let trace = steerwright_control::step_response(plant, pid, with_offset, until)?;
        Ok(StepResponse { time_s: trace.time, yaw_rad: trace.yaw, steering_rad: trace.steering })
    };
    let s = &pid.specification;
    let figure = |title: &str, response: &StepResponse, reached| {
        figures::yaw_step(title, response, s, reached, pid.largest_angle_rad())
    };
    let e = &pid.evidence;
    let [bode, nyquist, plain, offset] = PLOTS;
    let title = "Yaw step on the model with a steering offset";
    Ok([
        (bode, figures::bode(&open), 620),
        (nyquist, figures::nyquist(&open), 620),
        (plain, figure("Yaw step on the model", &step(false, until)?, &e.step), 680),
        (offset, figure(title, &step(true, s.steady_state_time_s)?, &e.step_with_offset), 680),
    ])
}
