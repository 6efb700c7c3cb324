//! The specification's yaw step in the loop of packed FMUs.

use crate::failure::Failure;
use crate::package;
use crate::simulate::system_of;
use control::DesignPlant;
use fmi2_host::{Archive, Coupling, InputTable, Recording, System};
use formats::{Document, FmuLoop, Pid, Plant, StepMetrics};

/// A step in the loop.
pub(crate) struct LoopStep {
    pub(crate) csv: String,
    pub(crate) trace: control::Trace,
    pub(crate) metrics: StepMetrics,
}

/// The step at tick `first` of plant and controller under a master.
pub(crate) fn step(
    plant: &Archive,
    controller: &Archive,
    pid: &Pid,
    first: usize,
    master: Coupling,
) -> Result<LoopStep, Failure> {
    let mut system = system_of([plant, controller])?;
    system.connect_by_name(&packaging::ssp::MEASUREMENTS)?;
    step_of(system, &plant.model().description().model_name, pid, first, master)
}

/// The same in a system that is wired already, with a controller `LateralPid` and a plant of that
/// name.
pub(crate) fn step_of(
    mut system: System,
    plant: &str,
    pid: &Pid,
    first: usize,
    master: Coupling,
) -> Result<LoopStep, Failure> {
    let s = &pid.specification;
    let ts = pid.sample_time_s;
    let steps = first + (s.steady_state_time_s / ts).round() as usize;
    // What holds from one communication point on is what the tick at the next one sees.
    let mut table =
        format!("time,LateralPid.yaw_reference\n0,{}\n", if first == 0 { s.step_rad } else { 0.0 });
    if first > 0 {
        table.push_str(&format!("{},{}\n", (first as f64 - 1.0) * ts, s.step_rad));
    }
    system.feed(InputTable::read(table.as_bytes(), "the step")?);
    let recording = system.run(master, 0.0, steps as f64 * ts, ts)?;
    let yaw = column(&recording, &format!("{plant}.yaw"))?;
    let steering = column(&recording, "LateralPid.steering_angle")?;
    let trace = control::Trace {
        time: recording.times[first..].iter().map(|t| t - recording.times[first]).collect(),
        yaw_reference: vec![s.step_rad; recording.times.len() - first],
        yaw: yaw[first..].iter().map(|y| y - yaw[first]).collect(),
        steering: steering[first..].to_vec(),
        steering_before: first.checked_sub(1).map_or(0.0, |before| steering[before]),
    };
    let metrics = control::metrics_of(&trace, s.step_rad, s.settling_band_percent)
        .ok_or_else(|| Failure::new("the step has no samples", "report this as a fault"))?
        .step;
    Ok(LoopStep { csv: recording.to_csv(), trace, metrics })
}

/// Writes into a controller's evidence what it reaches in the loop of the packed FMUs, under both
/// masters, each with its own delay. `document` is the plant's or the bicycle's.
pub(crate) fn prove(pid: &mut Pid, document: &str, plant: &DesignPlant) -> Result<(), Failure> {
    let controller = archive(&pid.to_json(), "the controller")?;
    let s = pid.specification;
    let offset = -s.steering_offset_rad * plant.steering_ratio;
    let (straight, off) = match Plant::from_json(document, "the plant") {
        Ok(model) => {
            let with = |offset: f64| {
                let mut model = model.clone();
                model.operating_point.steering_offset_rad = offset;
                model.operating_point.yaw_rate_offset_radps = 0.0;
                archive(&model.to_json(), "the plant")
            };
            (with(0.0)?, Some(with(offset)?))
        }
        // A bicycle has no steering offset to be given.
        Err(_) => (archive(document, "the plant")?, None),
    };
    pid.evidence.fmu_loops.clear();
    for (name, master, delay) in [
        ("gauss-seidel", Coupling::GaussSeidel, 0.0),
        ("jacobi", Coupling::Jacobi, pid.sample_time_s),
    ] {
        let run = |plant: &Archive| step(plant, &controller, pid, 0, master).map(|s| s.metrics);
        let found = FmuLoop {
            master: name.into(),
            loop_delay_s: delay,
            step: run(&straight)?,
            predicted: control::step_metrics(plant, pid, delay)?,
            step_with_offset: off.as_ref().map(run).transpose()?,
        };
        pid.evidence.fmu_loops.push(found);
    }
    Ok(())
}

fn archive(document: &str, name: &str) -> Result<Archive, Failure> {
    Ok(Archive::from_bytes(&package::pack(document, name, None)?.bytes, name)?)
}

fn column(recording: &Recording, name: &str) -> Result<Vec<f64>, Failure> {
    recording
        .column(name)
        .ok_or_else(|| Failure::new(format!("{name} was not recorded"), "report this as a fault"))
}
