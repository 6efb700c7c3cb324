//! The sections and tables of an identified model, by its structure.

use super::{evidence, identification};
use crate::figures;
use crate::read::Traces;
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    BicycleEvidence, Longitudinal, Model, MultivariablePlant, NORMAL_95, Sideslip, SideslipTerm,
    Torque, VehicleEvidence, VehicleParameter,
};

/// What was recorded, the model and the evidence for it.
pub(crate) fn sections(
    model: &Model,
    traces: Option<&Traces>,
    bicycle_fit: Option<f64>,
) -> Vec<Section> {
    let mut log = identification::log(model, traces);
    if let Some(plant) = model.plant() {
        log.blocks.extend(identification::information(&plant.evidence.excitation));
        let mut all = vec![log, identification::model(plant, traces, bicycle_fit)];
        all[1].blocks.extend(sideslip(model));
        all[1].blocks.extend(actuator(model));
        all.extend(evidence::evidence(plant));
        return all;
    }
    let [estimation, validation] = model.fits().map(|fit| super::optional(fit, 1, "%", "–"));
    let mut blocks = vec![Block::Text(format!(
        "The {} of {}: its simulation fits the {} of the estimation data by {estimation}, of the validation data by {validation}.",
        name(model),
        model.name(),
        output(model)
    ))];
    blocks.extend(parameter_tables(model).into_iter().map(Block::Table));
    blocks.extend(sideslip(model));
    blocks.extend(actuator(model));
    if let Some(traces) = traces {
        let caption = "Simulation from steering and speed alone: the measured yaw rate is no input of \
                       the model. The shaded part is validation data.";
        let figure = figures::comparison(traces, model.fits(), bicycle_fit);
        blocks.push(Block::figure(figure, 720, caption));
    }
    vec![log, Section::new("The identified model", blocks)]
}

/// The sideslip that fixes determined.
fn sideslip(model: &Model) -> Option<Block> {
    let stated = model.stated_sideslip()?;
    let lines = sideslip_in_words(stated, model.speed_mps().unwrap_or_default());
    Some(Block::Text(format!("Sideslip: {}.", lines.join("; "))))
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

/// The actuator between the steering command and the measured angle.
fn actuator(model: &Model) -> Option<Block> {
    let a = model.identified_actuator()?;
    let lag_error = NORMAL_95 * a.time_constant_standard_error_s;
    let delay_error = NORMAL_95 * a.delay_standard_error_s;
    let mut table = Table::new(["actuator", "value", "95 % band", "unit"])
        .row([
            "time constant".into(),
            format!("{:.4}", a.time_constant_s),
            band(a.time_constant_s, lag_error, true),
            "s".into(),
        ])
        .row([
            "delay".into(),
            format!("{:.4}", a.delay_s),
            band(a.delay_s, delay_error, true),
            "s".into(),
        ])
        .row(["angle over command".into(), format!("{:.3}", a.gain), "–".into(), "1".into()])
        .row(["fit of the measured angle".into(), format!("{:.1}", a.fit), "–".into(), "%".into()]);
    if let Some(rate) = a.max_rate_radps {
        table.push(["largest rate".into(), format!("{rate:.3}"), "–".into(), "rad/s".into()]);
    }
    Some(Block::Table(table))
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
            "identified model of order {} with {} inputs",
            plant.order(),
            plant.inputs.len()
        ),
    }
}

/// What the fits of a model are of.
fn output(model: &Model) -> &'static str {
    match model {
        Model::StateSpace(_) | Model::Bicycle(_) | Model::SingleTrack(_) => "yaw rate",
        Model::Torque(_) => "lateral acceleration",
        Model::Longitudinal(_) => "change of the speed",
        Model::Multivariable(_) => "outputs",
    }
}

/// The identified parameters with their uncertainty, and those that the drive does not determine; none of a plant in
/// state space, or of a model that was not identified.
#[must_use]
pub fn parameter_tables(model: &Model) -> Vec<Table> {
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

/// The sideslip that fixes determine, in lines; `speed_mps` is that of the model, for a sideslip that states none.
#[must_use]
pub fn sideslip_in_words(s: &Sideslip, speed_mps: f64) -> Vec<String> {
    let (value, error) = (s.sideslip_per_yaw_rate_s, 2.0 * s.standard_error_s);
    let latency = match s.gnss_latency_standard_error_s {
        Some(e) => not_negative(s.gnss_latency_s, 2.0 * e, 3, ""),
        None => s.gnss_latency_s.to_string(),
    };
    let mut lines =
        vec![format!("{value:.4} ± {error:.4} s per yaw rate, with fixes {latency} s old")];
    if let Some(SideslipTerm { value, standard_error }) = s.sideslip_growth_s5pm2 {
        let (value, error) = (1e3 * value, 2e3 * standard_error);
        lines
            .push(format!("{value:+.2} ± {error:.2} ms of it per (m/s²)² of lateral acceleration"));
    }
    if let Some(SideslipTerm { value, standard_error }) = s.sideslip_per_yaw_acceleration_s2 {
        let error = 2.0 * standard_error;
        lines.push(format!("{value:.4} ± {error:.4} s2 per yaw acceleration"));
    }
    if let Some(SideslipTerm { value, standard_error }) = s.distance_rear_m {
        let (speed, error) = (s.speed_mps.unwrap_or(speed_mps), 2.0 * standard_error);
        lines.push(format!(
            "all at {speed:.1} m/s; {value:.2} ± {error:.2} m from centre of gravity to rear axle"
        ));
    }
    lines
}

/// A quantity that should not be negative with its error; where the error reaches zero, the upper end alone.
#[must_use]
pub fn not_negative(value: f64, error: f64, digits: usize, unit: &str) -> String {
    if value.abs() > error {
        format!("{value:.digits$} ± {error:.digits$}{unit}")
    } else {
        format!("at most {:.digits$}{unit}", value + error)
    }
}
