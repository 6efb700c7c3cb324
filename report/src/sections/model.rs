//! The sections and tables of an identified model, by its structure.

use super::facts::{actuator_in_words, of_channels, of_plant};
use super::vehicle_facts::{
    bicycle_data, of_bicycle, of_longitudinal, of_torque, of_vehicle, vehicle_data,
};
use super::words::{Facts, percent, sideslip_in_words};
use super::{evidence, identification};
use crate::figures;
use crate::read::Traces;
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    BicycleEvidence, Longitudinal, Model, MultivariablePlant, NORMAL_95, Torque, VehicleEvidence,
    VehicleParameter,
};

/// What was recorded, the model and the evidence for it.
pub(crate) fn sections(
    model: &Model,
    traces: Option<&Traces>,
    bicycle_fit: Option<f64>,
) -> Vec<Section> {
    let mut log = identification::log(model, traces);
    let mut blocks = vec![Block::Facts(facts(model))];
    blocks.extend(parameter_tables(model).into_iter().map(Block::Table));
    if let Some(traces) = traces {
        let caption = "Simulation from what the driver does alone: the measured yaw rate is no input of the model. \
                       The shaded part is validation data.";
        let figure = figures::comparison(traces, model.fits(), bicycle_fit);
        blocks.push(Block::figure(figure, 720, caption));
    }
    let heading = format!("The {}", name(model));
    if let Some(plant) = model.plant() {
        log.blocks.extend(identification::information(&plant.evidence));
        blocks.extend(identification::orders(&plant.evidence.order_table, plant.order()));
        blocks.push(Block::Details(identification::details(plant)));
        let mut all = vec![log, Section::new(heading, blocks)];
        all.extend(evidence::evidence(plant));
        return all;
    }
    if let Some(plant) = model.multivariable() {
        blocks.push(Block::Details(vec![Block::Table(orders_of_channels(plant))]));
    }
    vec![log, Section::new(heading, blocks)]
}

/// The facts of a model.
fn facts(model: &Model) -> Facts {
    let mut facts = match model {
        Model::StateSpace(plant) => of_plant(plant),
        Model::Bicycle(bicycle) => {
            bicycle.evidence.as_ref().map(|e| of_bicycle(e, bicycle)).unwrap_or_default()
        }
        Model::SingleTrack(vehicle) => {
            vehicle.evidence.as_ref().map(of_vehicle).unwrap_or_default()
        }
        Model::Torque(torque) => of_torque(torque),
        Model::Longitudinal(longitudinal) => of_longitudinal(longitudinal),
        Model::Multivariable(plant) => of_channels(plant),
    };
    if let Some(actuator) = model.identified_actuator() {
        facts.push(Block::fact("actuator", actuator_in_words(&actuator)));
    }
    if let Some(sideslip) = model.stated_sideslip() {
        let lines = sideslip_in_words(sideslip, model.speed_mps().unwrap_or_default());
        facts.push(Block::fact("sideslip", lines.join("; ")));
    }
    match model {
        Model::Bicycle(bicycle) => facts.push(Block::fact("vehicle", bicycle_data(bicycle))),
        Model::SingleTrack(vehicle) => facts.push(Block::fact("vehicle", vehicle_data(vehicle))),
        _ => {}
    }
    facts
}

/// The orders of a plant of several channels.
fn orders_of_channels(plant: &MultivariablePlant) -> Table {
    let mut table = Table::new(["order", "estimation fit", "validation fit", "as estimated", ""]);
    for row in &plant.evidence.order_table {
        table.push([
            row.order.to_string(),
            percent(row.estimation_fit),
            percent(row.validation_fit),
            if row.stable { "stable" } else { "unstable" }.into(),
            if row.order == plant.order() { "chosen" } else { "" }.into(),
        ]);
    }
    table
}

/// Outputs over time, where the signals are there, and gains over frequency.
pub(crate) fn figures_of_channels(
    model: &Model,
    signals: Option<&figures::ChannelSignals>,
) -> Section {
    const OUTPUTS: &str = "Simulation from the inputs alone, from an initial state at the start of each part. The \
                           shaded part is validation data.";
    const GAINS: &str = "The gain of each pair with the 95 % band of the model, and the one that the spectra of the log show.";
    let [over_time, _] = figures::OF_CHANNELS;
    let figures = figures::of_channels(model, signals).into_iter();
    let blocks = figures.map(|(name, height, figure)| {
        Block::figure(figure, height, if name == over_time { OUTPUTS } else { GAINS })
    });
    let blocks = blocks.collect();
    Section::new("Outputs and responses", blocks)
}

/// The model in a table of results.
pub(crate) fn name(model: &Model) -> String {
    match model {
        Model::StateSpace(plant) => format!("identified model of order {}", plant.order()),
        Model::Bicycle(_) => "identified bicycle".into(),
        Model::SingleTrack(_) => "identified vehicle".into(),
        Model::Torque(_) => "identified response to the steering torque".into(),
        Model::Longitudinal(_) => "identified response of the speed".into(),
        Model::Multivariable(plant) => format!(
            "identified model of order {}, inputs: {}, outputs: {}",
            plant.order(),
            plant.inputs.len(),
            plant.outputs.len()
        ),
    }
}

/// The identified parameters with their uncertainty, and those that the drive does not determine; none of a plant in
/// state space, or of a model that was not identified.
fn parameter_tables(model: &Model) -> Vec<Table> {
    match model {
        Model::StateSpace(_) => Vec::new(),
        Model::Bicycle(bicycle) => match bicycle.evidence.as_ref() {
            Some(value) => parameters_of_bicycle(value),
            None => Vec::new(),
        },
        Model::SingleTrack(vehicle) => vehicle.evidence.iter().map(parameters_of_vehicle).collect(),
        Model::Torque(torque) => vec![parameters_of_torque(torque)],
        Model::Longitudinal(model) => vec![parameters_of_longitudinal(model)],
        Model::Multivariable(plant) => tables_of_channels(plant),
    }
}

fn parameters_of_bicycle(e: &BicycleEvidence) -> Vec<Table> {
    let mut identified = Table::new(["identified", "value", "95 % band", "unit"]);
    for q in &e.identified {
        // Only the gradient and the offsets have either sign.
        let is_positive = q.name != "understeer_gradient" && !q.name.contains("offset");
        identified = identified.row([
            q.name.replace('_', " "),
            format!("{:.5}", q.value),
            band(q.value, 2.0 * q.standard_error, is_positive),
            q.unit.clone(),
        ]);
    }
    let mut stated = Table::new(["not identified", "value", "origin"]);
    for s in &e.stated {
        stated = stated.row([s.name.clone(), format!("{}", s.value), s.origin.clone()]);
    }
    vec![identified, stated]
}

fn parameters_of_torque(torque: &Torque) -> Table {
    let command = &torque.command_unit;
    let estimates = [
        (
            "lateral acceleration per command",
            Some(torque.acceleration_per_command),
            format!("m/s² per {command}"),
        ),
        ("friction", Some(torque.friction), command.clone()),
        ("roll coefficient", torque.roll_coefficient, "1".into()),
        ("offset", Some(torque.offset_mps2), "m/s²".into()),
        ("delay", Some(torque.delay_s), "s".into()),
    ];
    let mut table = Table::new(["identified", "value", "95 % band", "unit"]);
    for (name, estimate, unit) in estimates {
        let Some(estimate) = estimate else { continue };
        let is_positive = matches!(name, "friction" | "delay");
        table = table.row([
            name.into(),
            format!("{:.5}", estimate.value),
            band(estimate.value, NORMAL_95 * estimate.standard_error, is_positive),
            unit,
        ]);
    }
    table
}

/// The channels, and the gains at rest and delays of all pairs.
fn tables_of_channels(plant: &MultivariablePlant) -> Vec<Table> {
    let mut channels = Table::new(["channel", "unit", "about", "deviation"]);
    let inputs =
        plant.inputs.iter().map(|i| ("input", &i.name, &i.unit, i.offset, i.standard_deviation));
    let outputs =
        plant.outputs.iter().map(|o| ("output", &o.name, &o.unit, o.offset, o.standard_deviation));
    for (kind, name, unit, offset, deviation) in inputs.chain(outputs) {
        channels = channels.row([
            format!("{kind} {name}"),
            unit.clone(),
            format!("{offset:.5}"),
            format!("{deviation:.5}"),
        ]);
    }
    let mut pairs = Table::new(["from", "to", "gain at rest", "95 % band", "delay seen"]);
    for pair in &plant.evidence.pairs {
        let dash = || String::from("–");
        let gain = pair.steady_state_gain;
        pairs = pairs.row([
            pair.input.clone(),
            pair.output.clone(),
            match gain {
                Some(g) => format!("{:.5}", g.value),
                None => dash(),
            },
            match gain {
                Some(g) => band(g.value, NORMAL_95 * g.standard_error, false),
                None => dash(),
            },
            match pair.delay {
                Some(d) => format!("{} s", d.estimate_s),
                None => dash(),
            },
        ]);
    }
    vec![channels, pairs]
}

fn parameters_of_longitudinal(model: &Longitudinal) -> Table {
    let is_accelerator = model.command_unit == "1";
    let gain_unit = if is_accelerator { "m/s²" } else { "1" };
    let mut rows = Vec::new();
    if model.gear_gains.is_empty() {
        for row in &model.gains {
            let name = match model.gains.len() {
                1 => "gain".into(),
                _ => format!("gain at {:.1} m/s", row.speed_mps),
            };
            rows.push((name, Some(row.gain), gain_unit, false));
        }
    }
    for row in &model.gear_gains {
        rows.push((format!("gain in gear {}", row.gear), Some(row.gain), gain_unit, false));
    }
    rows.push(("curvature of the pedal".into(), model.pedal_curvature, "1", false));
    rows.push(("lag".into(), Some(model.time_constant_s), "s", true));
    rows.push(("delay".into(), Some(model.delay_s), "s", true));
    if let Some(brake) = &model.brake {
        rows.push(("deceleration at full brake".into(), Some(brake.gain_mps2), "m/s²", false));
        rows.push(("lag of the brake".into(), Some(brake.time_constant_s), "s", true));
        rows.push(("delay of the brake".into(), Some(brake.delay_s), "s", true));
    }
    rows.push(("resistance".into(), Some(model.resistance_mps2), "m/s²", false));
    rows.push(("resistance per speed".into(), model.resistance_per_speed, "1/s", false));
    rows.push(("drag".into(), Some(model.drag_per_m), "1/m", false));
    rows.push(("share of gravity on a grade".into(), model.grade_coefficient, "1", false));
    let mut table = Table::new(["identified", "value", "95 % band", "unit"]);
    for (name, estimate, unit, is_positive) in rows {
        let Some(estimate) = estimate else { continue };
        table = table.row([
            name,
            format!("{:.5}", estimate.value),
            band(estimate.value, NORMAL_95 * estimate.standard_error, is_positive),
            unit.into(),
        ]);
    }
    table
}

/// The band of a quantity by its error, from zero on where it cannot be negative.
fn band(value: f64, error: f64, is_positive: bool) -> String {
    let least = if is_positive { 0.0 } else { f64::NEG_INFINITY };
    format!("{:.5} to {:.5}", (value - error).max(least), value + error)
}

fn parameters_of_vehicle(e: &VehicleEvidence) -> Table {
    let columns = ["parameter", "value", "95 % band", "prior (68 %)", "moved by", "from"];
    let mut table = Table::new(columns);
    for p in &e.parameters {
        let is_stated = p.prior.standard_deviation == 0.0;
        let unless_stated = |text: String| if is_stated { "–".into() } else { text };
        let error = 0.5 * (p.band_95[1] - p.band_95[0]);
        let unit = if p.unit.is_empty() { String::new() } else { format!(", {}", p.unit) };
        table = table.row([
            p.name.replace('_', " ") + &unit,
            if is_stated { format!("{}", p.value) } else { as_its_error(p.value, error) },
            unless_stated(range_text(p.band_95)),
            unless_stated(range_text(prior_range(p))),
            unless_stated(format!("{:+.1}", p.moved_deviations)),
            origin(p).into(),
        ]);
    }
    table
}

/// Where the value of a parameter comes from.
fn origin(p: &VehicleParameter) -> &'static str {
    match (p.prior.standard_deviation > 0.0, p.is_determined, p.is_at_bound) {
        (false, ..) => "fixed",
        (_, _, true) => "bound",
        (_, true, _) => "drive",
        (..) if p.posterior_per_prior > 0.9 => "prior",
        _ => "both",
    }
}

/// With the digits that an error leaves two of.
fn as_its_error(value: f64, error: f64) -> String {
    let digits = (1.0 - error.abs().max(1e-9).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// From and to, with the digits that the width leaves two of.
fn range_text([low, high]: [f64; 2]) -> String {
    let half = 0.5 * (high - low);
    format!("{} to {}", as_its_error(low, half), as_its_error(high, half))
}

/// The prior to one standard deviation, within the bounds.
fn prior_range(p: &VehicleParameter) -> [f64; 2] {
    let prior = &p.prior;
    let end = |deviations: f64| {
        let by = deviations * prior.standard_deviation;
        let value = if p.is_logarithmic { prior.mean * by.exp() } else { prior.mean + by };
        value.clamp(prior.min, prior.max)
    };
    [end(-1.0), end(1.0)]
}
