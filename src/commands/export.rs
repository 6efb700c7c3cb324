//! `steerwright export`: the parameters of a driving stack.

use crate::documents::gate::GateArguments;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::quantity;
use crate::output::{OutputKind, Outputs};
use crate::terminal::console;
use std::path::PathBuf;
use steerwright_formats::{Model, Torque};
use steerwright_stacks::{Export, Lateral, Stack, StatedValues};

/// Write the parameters that a driving stack requires, with standard errors and conventions as comments
///
/// Delay, lag, effective wheelbase and offsets are those of the model, at its speed. What a drive does not
/// determine is listed with the way to obtain it.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json, bicycle.json or vehicle.json; for openpilot also torque.json
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,
    /// The driving stack
    #[arg(long = "for", value_name = Stack::WORDS)]
    stack: Stack,
    /// Write the parameters here; by default they are printed
    #[arg(long = "output", short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// Largest steering angle, in steering coordinates
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_angle: Option<f64>,
    /// Largest rate of the steering angle that the actuator reaches, in steering coordinates
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    max_rate: Option<f64>,
    /// Wheelbase, m; by default that of a bicycle or vehicle
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    wheelbase: Option<f64>,
    #[command(flatten)]
    gate: GateArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let mut outputs = Outputs::new(global.force, [&arguments.model]);
    let out = arguments
        .out
        .as_ref()
        .map(|path| outputs.file(path, OutputKind::Parameters))
        .transpose()?;
    let (model, ..) = arguments.gate.read(&arguments.model)?;
    let export = exported(arguments, &model)?;
    let text = export.text();
    if let Some(out) = &out {
        out.write(text.as_bytes())?;
    }
    for missing in &export.missing {
        console::warning(format!("{} is left out: {}", missing.key, missing.reason));
    }
    match &out {
        _ if console::is_json() => console::result(&text, &export)?,
        Some(out) => console::note(format!("written to {out}")),
        None => console::bytes(text.as_bytes()).map_err(console::NoOutput)?,
    }
    Ok(Outcome::Done)
}

fn exported(arguments: &Arguments, model: &Model) -> Result<Export, Failure> {
    let failed = |e: steerwright_stacks::Error| Failure::in_file(&arguments.model, &e, e.hint());
    if let Some(actuator) = model.identified_actuator() {
        let [lag, delay] = [actuator.time_constant_s, actuator.delay_s].map(|s| 1e3 * s);
        console::warning(format!(
            "lags and delays count from the measured steering angle: the actuator before it, with a lag of {lag:.0} ms and a delay of {delay:.0} ms, is not among them"
        ));
    }
    let lateral = match model {
        Model::StateSpace(plant) => Lateral::of_plant(plant),
        Model::Bicycle(bicycle) => Lateral::of_bicycle(bicycle),
        Model::SingleTrack(vehicle) => {
            Lateral::of_bicycle(&steerwright_control::bicycle_of_vehicle(vehicle)?)
        }
        Model::Torque(torque) => return of_torque(arguments, torque),
        Model::Multivariable(_) => {
            return Err(Failure::new(
                format!(
                    "{}: a plant of named channels has no parameters of a steering",
                    arguments.model.display()
                ),
                "export a plant from steering to yaw rate, a bicycle, a vehicle or a torque",
            ));
        }
        other => {
            return Err(Failure::new(
                format!(
                    "{}: a model of the structure {} has no parameters of a steering",
                    arguments.model.display(),
                    other.structure()
                ),
                "export a plant, a bicycle, a vehicle or a torque",
            ));
        }
    }
    .map_err(failed)?;
    let at_road_wheel = |limit: Option<f64>| limit.map(|l| l / lateral.steering_ratio.value);
    let stated = StatedValues {
        max_angle_rad: at_road_wheel(arguments.max_angle),
        max_rate_radps: at_road_wheel(arguments.max_rate),
        wheelbase_m: arguments.wheelbase,
    };
    steerwright_stacks::export(arguments.stack, &lateral, &stated).map_err(|e| {
        Failure::new(&e, format!("{} (--max-angle, --max-rate, --wheelbase)", e.hint()))
    })
}

/// The parameters of a car steered by torque.
fn of_torque(arguments: &Arguments, torque: &Torque) -> Result<Export, Failure> {
    let stated = [
        ("--max-angle", arguments.max_angle),
        ("--max-rate", arguments.max_rate),
        ("--wheelbase", arguments.wheelbase),
    ];
    if let Some((option, _)) = stated.iter().find(|(_, value)| value.is_some()) {
        let message = format!("{option} is no parameter of a car that is steered by torque");
        return Err(Failure::new(message, "omit it"));
    }
    steerwright_stacks::export_torque(arguments.stack, torque)
        .map_err(|e| Failure::in_file(&arguments.model, &e, e.hint()))
}
