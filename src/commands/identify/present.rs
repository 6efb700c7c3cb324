//! What was identified: written, drawn and printed, by its structure.

use crate::failure::{Failure, Outcome};
use crate::output::{Files, Output, OutputKind, Outputs};
use crate::terminal::console;
use crate::terminal::evidence::{
    actuator_in_words, channel_table, channels, conclusion, evidence, plots, sideslip_in_words,
    traces_csv, validation_data, with_error,
};
use crate::terminal::multivariable;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use steerwright_formats::{
    Bicycle, BicycleEvidence, Longitudinal, Model, ReasonCode, SimulationFit, Torque, Vehicle,
    VehicleEvidence, correlated, too_few_blocks,
};
use steerwright_report::figures::{OF_CHANNELS, OF_IDENTIFICATION, of_channels, of_identification};
use steerwright_sysid::IdentifiedModel;
use steerwright_sysid::multivariable::ChannelTraces;

/// Writes, draws and prints a model, with the table of the structures that it was chosen from.
pub(super) fn present(
    identified: &IdentifiedModel,
    choice: Option<&str>,
    out: &Output,
    traces: Option<&Output>,
    shown: &Shown<'_>,
) -> Result<Outcome, Failure> {
    let model = &identified.model;
    out.model(model)?;
    let mut drawn = String::new();
    if let Some(signals) = &identified.traces
        && (traces.is_some() || shown.is_wanted())
    {
        // The signals as text are several times the log in memory.
        let csv = traces_csv(signals, None);
        if let Some(traces) = traces {
            traces.write(csv.as_bytes())?;
        }
        drawn = shown.write(model, &csv)?;
    }
    if let Some(signals) = &identified.channels {
        if let Some(traces) = traces {
            traces.write(multivariable::traces_csv(signals).as_bytes())?;
        }
        drawn = shown.write_channels(model, signals)?;
    }
    let text = evidence_text(model);
    let text = match choice {
        Some(table) if console::is_json() => {
            console::note(table);
            text
        }
        Some(table) => format!("{table}\n\n{text}"),
        None => text,
    };
    console::result(&text, model)?;
    console::note(format!("written to {out}{drawn}"));
    Ok(Outcome::from_quality(model.quality()))
}

/// Reasons of a drive that determines too little.
const WEAK: [ReasonCode; 7] = [
    ReasonCode::WeakSteering,
    ReasonCode::NarrowBand,
    ReasonCode::NoisyYawRate,
    ReasonCode::UncertainGain,
    ReasonCode::UncertainPhase,
    ReasonCode::ShortValidation,
    ReasonCode::UninformativeValidation,
];

/// The command that designs the drive to record next, where this one determines too little.
pub(super) fn next_drive(model: &Model, out: &Output, logs: &[PathBuf]) -> Option<String> {
    if !model.quality().reasons.iter().any(|reason| WEAK.contains(&reason.code)) {
        return None;
    }
    let command = match model {
        Model::Bicycle(_) | Model::SingleTrack(_) => format!("steerwright excite {out}"),
        // The bicycle needs the speed of each sample.
        Model::StateSpace(plant) if plant.operating_point.speed_mps > 0.0 => {
            let logs: Vec<String> = logs.iter().map(|log| log.display().to_string()).collect();
            format!(
                "steerwright identify {} --structure bicycle, with the same options, then steerwright excite bicycle.json",
                logs.join(" ")
            )
        }
        _ => return None,
    };
    Some(format!("the log determines too little; design the drive to record: {command}"))
}

/// The evidence behind a model, for people.
pub(crate) fn evidence_text(model: &Model) -> String {
    let tables = steerwright_report::parameter_tables(model);
    let tables: String = tables.iter().map(|table| console::table(table) + "\n").collect();
    match model {
        Model::StateSpace(plant) => evidence(plant),
        Model::Bicycle(bicycle) => bicycle_text(bicycle, &tables),
        Model::SingleTrack(vehicle) => vehicle_text(vehicle, &tables),
        Model::Multivariable(plant) => multivariable::evidence(plant, &tables),
        other => text_of_tables(other, &tables),
    }
}

/// The outputs that the evidence is drawn into.
pub(super) struct Shown<'a> {
    plots: Option<(&'a Path, Files)>,
    report: Option<Output>,
}

impl<'a> Shown<'a> {
    pub(super) fn decide(
        plots: Option<&'a Path>,
        report: Option<&PathBuf>,
        outputs: &mut Outputs,
    ) -> Result<Self, Failure> {
        let plots = plots.map(|folder| {
            // Which of them are drawn depends on the channels, which are read later.
            let names = [&OF_IDENTIFICATION[..], &OF_CHANNELS].concat();
            let names = names.into_iter().map(|name| format!("{name}.svg"));
            Ok::<_, Failure>((folder, outputs.files(folder, names, OutputKind::Svg)?))
        });
        let plots = plots.transpose()?;
        Ok(Self { plots, report: outputs.optional(report, OutputKind::Html)? })
    }

    fn is_wanted(&self) -> bool {
        self.plots.is_some() || self.report.is_some()
    }

    /// The same of a model whose inputs and outputs have names.
    fn write_channels(&self, model: &Model, signals: &ChannelTraces) -> Result<String, Failure> {
        let mut text = String::new();
        if !self.is_wanted() {
            return Ok(text);
        }
        let signals = steerwright_report::ChannelSignals {
            time_s: signals.time_s.clone(),
            outputs: signals.outputs.clone(),
            is_validation: signals.is_validation.clone(),
        };
        if let Some((folder, files)) = &self.plots {
            plots(of_channels(model, Some(&signals)), files)?;
            let _ = write!(text, "\nfigures in {}", folder.display());
        }
        if let Some(out) = &self.report {
            let page = steerwright_report::Report {
                title: format!("{}: the identified model", model.name()),
                model: Some(model),
                channels: Some(&signals),
                ..steerwright_report::Report::default()
            };
            out.write(page.to_html().as_bytes())?;
            let _ = write!(text, "\nreport in {out}");
        }
        Ok(text)
    }

    /// Draws the requested evidence; returns the places that it was written to, for people.
    fn write(&self, model: &Model, csv: &str) -> Result<String, Failure> {
        let mut text = String::new();
        if !self.is_wanted() {
            return Ok(text);
        }
        let traces = steerwright_report::Traces::from_csv(csv.as_bytes(), "traces")?;
        if let Some((folder, files)) = &self.plots {
            plots(of_identification(model, &traces, None), files)?;
            let _ = write!(text, "\nfigures in {}", folder.display());
        }
        if let Some(out) = &self.report {
            let page = steerwright_report::Report {
                title: format!("{}: the identified model", model.name()),
                model: Some(model),
                traces: Some(&traces),
                ..steerwright_report::Report::default()
            };
            out.write(page.to_html().as_bytes())?;
            let _ = write!(text, "\nreport in {out}");
        }
        Ok(text)
    }
}

fn bicycle_text(bicycle: &Bicycle, tables: &str) -> String {
    let text =
        bicycle.evidence.as_ref().map(|e| bicycle_evidence(e, bicycle, tables)).unwrap_or_default();
    text + &bicycle_data(bicycle)
}

fn bicycle_data(bicycle: &Bicycle) -> String {
    let v = &bicycle.vehicle;
    let [m, j, lf, lr] = [v.mass_kg, v.yaw_inertia_kgm2, v.distance_front_m, v.distance_rear_m];
    let [cf, cr] = [v.cornering_stiffness_front_npr, v.cornering_stiffness_rear_npr];
    let rate = v.actuator_rate_max_radps.map(|rate| format!(", at most {rate:.3} rad/s"));
    format!(
        "vehicle  m {m:.0} kg, J {j:.0} kg·m², Lf {lf:.3} m, Lr {lr:.3} m, Cf {cf:.0} N/rad, Cr {cr:.0} N/rad, Tn {:.4} s, delay {:.4} s{}, steering ratio {:.3}\n",
        v.actuator_time_constant_s,
        v.actuator_delay_s,
        rate.unwrap_or_default(),
        v.steering_ratio
    )
}

fn bicycle_evidence(e: &BicycleEvidence, bicycle: &Bicycle, tables: &str) -> String {
    let channels = channels(&e.channels, Some(&bicycle.provenance));
    let mut text = format!("{channels}\n{tables}");
    let fit = match &e.held_out {
        Some(h) => with_error(e.validation_fit, h.fit_standard_error, h.without_standard_error()),
        None => format!("{:.2} %", e.validation_fit),
    };
    let _ = writeln!(
        text,
        "fit      {fit} simulated on validation data, {:.2} % on estimation data",
        e.estimation_fit
    );
    text.extend(e.held_out.as_ref().map(validation_data));
    let d = &e.with_delay;
    let _ = writeln!(
        text,
        "delay    {}; with it the fits are {:.2} % and {:.2} %; {}",
        steerwright_report::not_negative(1e3 * d.input_delay_s, 2e3 * d.standard_error_s, 1, " ms"),
        d.validation_fit,
        d.estimation_fit,
        if bicycle.vehicle.actuator_delay_s > 0.0 { "in the file" } else { "not in the file" }
    );
    let _ = writeln!(
        text,
        "offsets  {:.3}° of the steering angle, {:.3}°/s of the yaw rate; in the file as evidence, not part of the model",
        e.steering_offset_rad.to_degrees(),
        e.yaw_rate_offset_radps.to_degrees()
    );
    text.extend(e.actuator.as_ref().map(actuator_in_words));
    if let Some(sideslip) = &bicycle.sideslip {
        text += &sideslip_in_words(sideslip, bicycle.vehicle.speed_mps);
    }
    text + &conclusion(&e.warnings, &bicycle.quality)
}

fn vehicle_text(vehicle: &Vehicle, tables: &str) -> String {
    let evidence = vehicle.evidence.as_ref();
    let text = evidence.map(|e| vehicle_evidence(e, vehicle, tables)).unwrap_or_default();
    text + &vehicle_data(vehicle)
}

fn vehicle_data(vehicle: &Vehicle) -> String {
    let (b, t, a) = (&vehicle.body, &vehicle.tyres, &vehicle.actuator);
    format!(
        "vehicle  m {:.0} kg, J {:.0} kg·m², Lf {:.3} m, Lr {:.3} m, Cf {:.0} N/rad, Cr {:.0} N/rad, friction {:.3}, Tn {:.4} s, delay {:.4} s, steering ratio {:.3}\n",
        b.mass_kg,
        b.yaw_inertia_kgm2,
        b.distance_front_m,
        b.distance_rear_m,
        t.cornering_stiffness_front_npr,
        t.cornering_stiffness_rear_npr,
        t.friction_coefficient,
        a.time_constant_s,
        a.delay_s,
        a.steering_ratio
    )
}

fn vehicle_evidence(e: &VehicleEvidence, vehicle: &Vehicle, tables: &str) -> String {
    let channels = channels(&e.channels, vehicle.provenance.as_ref());
    let mut text = format!("{channels}\n{tables}");
    for (a, b, correlation) in correlated(e) {
        let (a, b) = (a.replace('_', " "), b.replace('_', " "));
        let _ = writeln!(text, "         correlation {correlation:+.2} of {a} and {b}");
    }
    let _ = writeln!(text, "fitted   {}", e.fitted.join(", ").replace('_', " "));
    let seconds = |samples: usize| samples as f64 * e.sample_time_s;
    let _ = writeln!(
        text,
        "data     {:.0} s estimation data, {:.0} s validation data, {:.1} to {:.1} m/s, to {:.1} m/s²",
        seconds(e.estimation_samples),
        seconds(e.validation_samples),
        e.speed.min_mps,
        e.speed.max_mps,
        e.lateral_acceleration_mps2
    );
    for (fit, of) in [(e.validation, "validation"), (Some(e.estimation), "estimation")] {
        let Some(fit) = fit else { continue };
        let _ = writeln!(text, "fit      {} simulated on {of} data", fit_text(&fit));
    }
    let _ = writeln!(
        text,
        "spin     not with {:.0} % less friction at the rear axle, on this drive",
        100.0 * e.spin_margin
    );
    text.extend(e.actuator.as_ref().map(actuator_in_words));
    if let Some(sideslip) = &vehicle.sideslip {
        text += &sideslip_in_words(sideslip, vehicle.speed_mps);
    }
    text + &conclusion(&e.warnings, &vehicle.quality)
}

fn fit_text(fit: &SimulationFit) -> String {
    let error = fit.yaw_rate_standard_error;
    let mut text =
        format!("{} of yaw rate", with_error(fit.yaw_rate, error, too_few_blocks(fit.blocks)));
    if let Some(lateral) = fit.lateral_acceleration {
        let _ = write!(text, ", {lateral:.2} % of lateral acceleration");
    }
    if let Some([error, size]) =
        fit.sideslip_rms_error_rad.zip(fit.sideslip_rms_rad).map(<[f64; 2]>::from)
    {
        let (error, size) = (error.to_degrees(), size.to_degrees());
        let _ = write!(text, ", {error:.2}° RMS of {size:.2}° of sideslip");
    }
    let _ = write!(text, ", at worst {:.3} rad/s RMS in 5 s,", fit.worst_window_radps);
    text
}

/// Channels, tables, what a structure adds to them, and the conclusion.
fn text_of_tables(model: &Model, tables: &str) -> String {
    let channels = console::table(&channel_table(model.channels()));
    let mut text = format!("{channels}\n{tables}");
    match model {
        Model::Torque(torque) => torque_text(&mut text, torque),
        Model::Longitudinal(longitudinal) => longitudinal_text(&mut text, longitudinal),
        _ => {}
    }
    text + &conclusion(model.warnings(), model.quality())
}

fn torque_text(text: &mut String, torque: &Torque) {
    let e = &torque.evidence;
    let _ = writeln!(
        text,
        "fit      {:.2} % on validation data, {:.2} % on estimation data; errors of {:.3} m/s²",
        e.validation_fit, e.estimation_fit, e.error_mps2
    );
    let samples = |n: usize| n as f64 * e.sample_time_s;
    let _ = writeln!(
        text,
        "data     {:.0} s estimation data at {:.1} m/s on average, {:.0} s validation data, above {} m/s",
        samples(e.estimation_samples),
        e.mean_speed_mps,
        samples(e.validation_samples),
        e.least_speed_mps
    );
}

fn longitudinal_text(text: &mut String, model: &Longitudinal) {
    let e = &model.evidence;
    let without = "too few windows".into();
    let fit = with_error(e.validation_fit, e.validation_fit_standard_error, without);
    let _ = writeln!(
        text,
        "fit      {fit} of the change of the speed in {:.0} s, simulated on validation data, {:.2} % on estimation data",
        e.window_s, e.estimation_fit
    );
    let samples = |n: usize| n as f64 * e.sample_time_s;
    let [low, mean, high] = e.speed_mps;
    let _ = writeln!(
        text,
        "data     {:.0} s estimation data from {low:.1} to {high:.1} m/s, {mean:.1} m/s on average, {:.0} s validation data, above {} m/s",
        samples(e.estimation_samples),
        samples(e.validation_samples),
        e.least_speed_mps
    );
    let grade = match model.grade_source.as_str() {
        "none" => "not in the log, part of the disturbance",
        "grade" => "from the channel of the grade",
        "pitch" => "from the pitch",
        _ => "from altitude and distance",
    };
    let _ = writeln!(text, "grade    {grade}");
    let n = &model.noise;
    let _ = writeln!(
        text,
        "noise    {:.4} m/s of the speed; a disturbance of {:.3} m/s² that lasts {:.1} s; prediction errors on validation data are {:.2} times those",
        n.speed_mps, n.disturbance_mps2, n.disturbance_time_constant_s, e.prediction_error_ratio
    );
}
