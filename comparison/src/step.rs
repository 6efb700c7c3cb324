//! The specification's yaw step in the loop of packed FMUs.

use crate::Error;
use crate::packed::archive;
use crate::track::add;
use steerwright_control::{DesignPlant, model_behind};
use steerwright_formats::{Document, FmuLoop, LoopCoupling, Model, Pid, Plant, StepMetrics};
use steerwright_host::{Archive, Coupling, InputTable, Recording, System};
use steerwright_report::StepResponse;

/// How long the loop holds its course before the step, s: the integral action takes up the plant's
/// steering offset meanwhile, as it would on the road.
const BEFORE_STEP_S: f64 = 10.0;

/// A step in the loop.
pub struct LoopStep {
    /// All outputs and free inputs.
    pub csv: String,
    /// Yaw and steering from the step on.
    pub response: StepResponse,
    /// Compared with the specification.
    pub metrics: StepMetrics,
}

/// The step of plant and controller under a coupling, after a straight course on which the integral
/// action has taken up the steering offset.
///
/// # Errors
/// Those of opening and running the FMUs.
pub fn yaw_step(
    plant: &Archive,
    controller: &Archive,
    pid: &Pid,
    coupling: Coupling,
) -> Result<LoopStep, Error> {
    step(plant, controller, pid, ticks_before_step(pid), coupling)
}

/// The step at the moment at which the specification's steering offset appears; `None` for a model whose FMU has no
/// steering offset.
///
/// # Errors
/// Those of packing and running the FMUs.
pub fn yaw_step_with_offset(
    model: &Model,
    controller: &Archive,
    pid: &Pid,
    coupling: Coupling,
) -> Result<Option<LoopStep>, Error> {
    let Some(plant) = model.plant() else { return Ok(None) };
    let offset = -steering_offset(pid, plant.steering_ratio);
    step(&with_offset(plant, offset)?, controller, pid, 0, coupling).map(Some)
}

/// Of the specification's second step, in steering coordinates, rad.
fn steering_offset(pid: &Pid, steering_ratio: f64) -> f64 {
    pid.specification.steering_offset_within(pid.largest_angle_rad(), steering_ratio)
}

/// Samples of a straight course before the step.
pub(crate) fn ticks_before_step(pid: &Pid) -> usize {
    (BEFORE_STEP_S / pid.sample_time_s).round() as usize
}

/// The archive of an identified plant with another steering offset, in steering coordinates.
fn with_offset(plant: &Plant, steering_offset_rad: f64) -> Result<Archive, Error> {
    let mut plant = plant.clone();
    plant.operating_point.steering_offset_rad = steering_offset_rad;
    plant.operating_point.yaw_rate_offset_radps = 0.0;
    archive(&plant.to_json(), "the plant with a steering offset")
}

/// The step at tick `first`.
fn step(
    plant: &Archive,
    controller: &Archive,
    pid: &Pid,
    first: usize,
    coupling: Coupling,
) -> Result<LoopStep, Error> {
    let mut system = System::new();
    let name = &plant.model().description().model_name;
    add(&mut system, plant, name)?;
    add(&mut system, controller, &controller.model().description().model_name)?;
    system.connect_by_name(&steerwright_packaging::ssp::MEASUREMENTS)?;
    step_of(system, name, pid, first, coupling)
}

/// The step in a system that is wired already, with a controller `LateralPid` and a plant of that
/// name.
pub(crate) fn step_of(
    mut system: System,
    plant: &str,
    pid: &Pid,
    first: usize,
    coupling: Coupling,
) -> Result<LoopStep, Error> {
    let s = &pid.specification;
    let ts = pid.sample_time_s;
    let steps = first + (s.steady_state_time_s / ts).round() as usize;
    // A value of one communication point is used by the tick at the next one.
    let mut table =
        format!("time,LateralPid.yaw_reference\n0,{}\n", if first == 0 { s.step_rad } else { 0.0 });
    if first > 0 {
        table.push_str(&format!("{},{}\n", (first as f64 - 1.0) * ts, s.step_rad));
    }
    system.feed(InputTable::read(table.as_bytes(), "the step")?);
    let recording = system.run(coupling, 0.0, steps as f64 * ts, ts)?;
    let yaw = column(&recording, &format!("{plant}.yaw"))?;
    let steering = column(&recording, "LateralPid.steering_angle")?;
    let trace = steerwright_control::Trace {
        time: recording.times[first..].iter().map(|t| t - recording.times[first]).collect(),
        yaw_reference: vec![s.step_rad; recording.times.len() - first],
        yaw: yaw[first..].iter().map(|y| y - yaw[first]).collect(),
        steering: steering[first..].to_vec(),
        steering_before: first.checked_sub(1).map_or(0.0, |before| steering[before]),
    };
    let metrics = steerwright_control::metrics_of(&trace, s.step_rad, s.settling_band_percent)
        .ok_or_else(|| Error::NotRecorded { variable: "a sample of the step".into() })?
        .step;
    let response =
        StepResponse { time_s: trace.time, yaw_rad: trace.yaw, steering_rad: trace.steering };
    Ok(LoopStep { csv: recording.to_csv(), response, metrics })
}

/// Writes into a controller's evidence what it reaches in the loop of the packed FMUs, under both
/// couplings, each with its own delay, behind the actuator that it was designed for. `document` is that of the model, and
/// `plant` the model of the design.
///
/// # Errors
/// Those of packing and running the FMUs.
pub fn verify(pid: &mut Pid, document: &str, plant: &DesignPlant) -> Result<(), Error> {
    let actuator = pid.designed_for.actuator;
    let plant = &plant.behind(actuator);
    let controller = archive(&pid.to_json(), "the controller")?;
    let offset = -steering_offset(pid, plant.steering_ratio);
    let model = model_behind(&Model::from_json(document, "the plant")?, actuator);
    let (straight, off) = match model.plant() {
        Some(model) => (with_offset(model, 0.0)?, Some(with_offset(model, offset)?)),
        // A bicycle has no parameter for a steering offset.
        None => (archive(&model.to_json(), "the plant")?, None),
    };
    pid.evidence.fmu_loops.clear();
    for coupling in LoopCoupling::ALL {
        let delay = coupling.loop_delay_s(pid.sample_time_s);
        let run = |plant: &Archive| {
            step(plant, &controller, pid, 0, coupling_of_host(coupling)).map(|s| s.metrics)
        };
        let found = FmuLoop {
            coupling,
            loop_delay_s: delay,
            step: run(&straight)?,
            predicted: steerwright_control::step_metrics(plant, pid, delay)?,
            step_with_offset: off.as_ref().map(run).transpose()?,
        };
        pid.evidence.fmu_loops.push(found);
    }
    Ok(())
}

/// The same coupling for the host, which knows no documents.
pub(crate) fn coupling_of_host(coupling: LoopCoupling) -> Coupling {
    match coupling {
        LoopCoupling::GaussSeidel => Coupling::GaussSeidel,
        LoopCoupling::Jacobi => Coupling::Jacobi,
    }
}

fn column(recording: &Recording, name: &str) -> Result<Vec<f64>, Error> {
    recording.column(name).ok_or_else(|| Error::NotRecorded { variable: name.into() })
}
