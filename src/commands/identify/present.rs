//! What was identified: written, drawn and printed, by its structure.

use crate::failure::{Failure, Outcome};
use crate::output::traces::{channels_csv, traces_csv};
use crate::output::{Files, Output, OutputKind, Outputs};
use crate::terminal::console;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use steerwright_formats::{Model, ReasonCode};
use steerwright_report::figures::{OF_CHANNELS, OF_IDENTIFICATION, of_channels, of_identification};
use steerwright_report::{Figure, Report};
use steerwright_sysid::IdentifiedModel;
use steerwright_sysid::multivariable::ChannelTraces;

/// Writes, draws and prints a model, with the table of the structures that it was chosen from.
pub(super) fn present(
    identified: &IdentifiedModel,
    choice: Option<&str>,
    logs: &[PathBuf],
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
            traces.write(channels_csv(signals).as_bytes())?;
        }
        drawn = shown.write_channels(model, signals)?;
    }
    let next = next_drive(model, out, logs).or_else(|| design_of(model, out));
    let sections = Report { model: Some(model), ..Report::default() }.sections();
    let mut text = console::page(&sections, next.as_deref());
    if let Some(table) = choice {
        if console::is_json() {
            console::note(table);
        }
        text += &format!("\nThe structures\n{table}");
    }
    console::result(&text, model)?;
    console::note(format!("written to {out}{drawn}"));
    Ok(Outcome::from_quality(model.quality()))
}

/// The command that designs a controller on a model, if its quality allows that.
pub(super) fn design_of(model: &Model, out: &Output) -> Option<String> {
    let is_designed_on = match model {
        Model::StateSpace(_)
        | Model::Bicycle(_)
        | Model::SingleTrack(_)
        | Model::Longitudinal(_) => model.quality().allows_design(),
        Model::Torque(_) | Model::Multivariable(_) => false,
    };
    if is_designed_on { Some(format!("steerwright design {out}")) } else { None }
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
fn next_drive(model: &Model, out: &Output, logs: &[PathBuf]) -> Option<String> {
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
    Some(command)
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
            let page = Report {
                title: format!("{}: the identified model", model.name()),
                model: Some(model),
                channels: Some(&signals),
                ..Report::default()
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
            let page = Report {
                title: format!("{}: the identified model", model.name()),
                model: Some(model),
                traces: Some(&traces),
                ..Report::default()
            };
            out.write(page.to_html().as_bytes())?;
            let _ = write!(text, "\nreport in {out}");
        }
        Ok(text)
    }
}

/// Writes figures, each with a name and a height in pixels.
fn plots(figures: Vec<(&'static str, u32, Figure)>, files: &Files) -> Result<(), Failure> {
    for (name, height, figure) in figures {
        match figure.to_svg(steerwright_report::WIDTH, height) {
            Ok(svg) => {
                files.write(&format!("{name}.svg"), svg.as_bytes())?;
            }
            // A short log leaves some of them empty.
            Err(steerwright_report::Error::NoData { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}
