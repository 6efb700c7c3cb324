//! The results of builds in one table, and as JSON.

use crate::pipeline::{Basis, Built, Controller, PAGE, RECORDED_ROAD, STANDARD_ROAD};
use crate::terminal::console;
use serde::Serialize;
use std::fmt::Write;
use steerwright_formats::{
    DesignEvidence, Model, PidGains, Plant, Quality, SourceFile, Specification, StepMetrics,
};
use steerwright_report::Table;

#[derive(Serialize)]
pub(crate) struct Overview<'a> {
    name: &'a str,
    structure: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<usize>,
    speed_mps: f64,
    held_out_fit_percent: Option<f64>,
    bicycle_held_out_fit_percent: Option<f64>,
    quality: &'a Quality,
    controllers: Vec<ControllerOverview<'a>>,
    remarks: &'a [String],
    folder: String,
    files: &'a [SourceFile],
}

#[derive(Serialize)]
struct ControllerOverview<'a> {
    basis: &'static str,
    gains: &'a PidGains,
    specification: &'a Specification,
    met: bool,
    on_the_model: &'a DesignEvidence,
    in_the_loop_of_fmus: &'a StepMetrics,
    #[serde(skip_serializing_if = "Option::is_none")]
    in_the_loop_of_fmus_with_offset: Option<&'a StepMetrics>,
    tracks: Vec<TrackOverview>,
}

#[derive(Serialize)]
struct TrackOverview {
    road: &'static str,
    cross_track_rms_m: f64,
    cross_track_largest_m: f64,
}

/// A build for scripts.
pub(crate) fn overview(built: &Built) -> Overview<'_> {
    let model = &built.model;
    Overview {
        name: model.name(),
        structure: model.structure().name(),
        order: model.plant().map(Plant::order),
        speed_mps: model.speed_mps().unwrap_or_default(),
        held_out_fit_percent: validation_fit(model),
        bicycle_held_out_fit_percent: built.bicycle_fit,
        quality: model.quality(),
        controllers: built
            .controllers
            .iter()
            .map(|c| ControllerOverview {
                basis: c.basis.name(),
                gains: &c.pid.gains,
                specification: &c.pid.specification,
                met: c.pid.evidence.met && c.step_meets(),
                on_the_model: &c.pid.evidence,
                in_the_loop_of_fmus: &c.step_metrics,
                in_the_loop_of_fmus_with_offset: c.offset_metrics.as_ref(),
                tracks: c
                    .runs
                    .iter()
                    .map(|run| TrackOverview {
                        road: run.road,
                        cross_track_rms_m: run.errors.cross_track_rms_m,
                        cross_track_largest_m: run.errors.cross_track_max_m,
                    })
                    .collect(),
            })
            .collect(),
        remarks: &built.remarks,
        folder: built.out.display().to_string(),
        files: &built.files,
    }
}

/// One column a drive.
pub(crate) fn table(all: &[Built]) -> String {
    let headers =
        std::iter::once(String::new()).chain(all.iter().map(|b| b.model.name().to_owned()));
    let mut table = Table::new(headers);
    let mut row = |name: &str, cell: &dyn Fn(&Built) -> String| {
        push(&mut table, name.to_owned(), all.iter().map(cell).collect());
    };
    row("speed", &|b| match b.model.speed_mps() {
        Some(speed) => format!("{speed:.2} m/s"),
        None => none(),
    });
    row("model", &|b| match b.model.plant() {
        Some(plant) => format!("order {}", plant.order()),
        None => b.model.structure().to_string(),
    });
    row("quality", &|b| b.model.quality().grade.to_string());
    row("validation fit, identified", &|b| match validation_fit(&b.model) {
        Some(fit) => format!("{fit:.2} %"),
        None => none(),
    });
    row("validation fit, bicycle", &|b| match b.bicycle_fit {
        Some(fit) => format!("{fit:.2} %"),
        None => none(),
    });
    // A requirement of all is part of the name of the row, otherwise of each figure.
    let mut required = all.iter().flat_map(|b| &b.controllers).map(|c| &c.pid.specification);
    let first = required.next();
    let one = first.filter(|first| required.all(|other| other == *first));
    for basis in [Basis::Identified, Basis::Bicycle] {
        if !all.iter().flat_map(|b| &b.controllers).any(|c| c.basis == basis) {
            continue;
        }
        table.push(
            [vec![format!("{} controller", basis.name())], vec![String::new(); all.len()]].concat(),
        );
        let mut row = |name: &str, cell: &dyn Fn(&Controller) -> String| {
            let of = |b: &Built| match b.controllers.iter().find(|c| c.basis == basis) {
                Some(value) => cell(value),
                None => none(),
            };
            push(&mut table, format!("  {name}"), all.iter().map(of).collect());
        };
        row("kp", &|c| format!("{:.4}", c.pid.gains.kp));
        row("ki", &|c| format!("{:.4} 1/s", c.pid.gains.ki));
        row("kd", &|c| format!("{:.4} s", c.pid.gains.kd));
        row("modulus margin", &|c| format!("{:.3}", c.pid.evidence.margins.modulus_margin));
        for (place, in_loop) in [("own model", false), ("identified plant", true)] {
            let step = |c: &Controller| if in_loop { c.step_metrics } else { c.pid.evidence.step };
            let mut figure =
                |name: &str,
                 required: &dyn Fn(&Specification) -> Option<f64>,
                 (unit, absent): (&str, &str),
                 value: &dyn Fn(&Controller) -> Option<f64>| {
                    let shared = match one {
                        Some(one) => at_most(required(one), unit),
                        None => String::new(),
                    };
                    row(&format!("{name}, {place}{shared}"), &|c| {
                        let own = match one {
                            Some(_) => String::new(),
                            None => at_most(required(&c.pid.specification), unit),
                        };
                        value(c).map_or(absent.into(), |v| format!("{v:.3} {unit}{own}"))
                    });
                };
            let error = |s: &Specification| s.steady_state_error_percent;
            figure("overshoot", &|s| s.overshoot_percent, ("%", "-"), &|c| {
                Some(step(c).overshoot_percent)
            });
            figure("settling", &|s| s.settling_time_s, ("s", "never"), &|c| {
                step(c).settling_time_s
            });
            figure("error", &error, ("%", "-"), &|c| Some(step(c).steady_state_error_percent));
            let with_offset = |c: &Controller| {
                if in_loop { c.offset_metrics } else { Some(c.pid.evidence.step_with_offset) }
            };
            figure("error, steering off by 1°", &error, ("%", "-"), &|c| {
                with_offset(c).map(|m| m.steady_state_error_percent)
            });
        }
        row("largest steering rate", &|c| {
            let rate = c.step_metrics.largest_increment_rad / c.pid.sample_time_s;
            format!("{rate:.2} rad/s")
        });
        row("its limit", &|c| format!("{:.2} rad/s", c.pid.limits.max_rate_radps));
        row("overshoot of a tenth of the step", &|c| {
            let small = c.pid.evidence.small_step.as_ref();
            match small {
                Some(m) => format!("{:.3} %", m.overshoot_percent),
                None => none(),
            }
        });
        row("specification, own model", &|c| met(c.pid.evidence.met));
        row("specification, identified plant", &|c| met(c.step_meets()));
        for (road, name) in [(STANDARD_ROAD, "reference road"), (RECORDED_ROAD, "recorded road")] {
            row(&format!("off the {name}, RMS / largest"), &|c| match c
                .runs
                .iter()
                .find(|r| r.road == road)
            {
                Some(run) => {
                    let e = &run.errors;
                    format!("{:.4} / {:.4} m", e.cross_track_rms_m, e.cross_track_max_m)
                }
                None => none(),
            });
        }
    }
    let mut text = console::table(&table);
    for b in all {
        let quality = b.model.quality();
        let name = b.model.name();
        let _ = write!(text, "\n{name}: {}: {}\n", quality.grade, quality.summary);
        // The grade is the model's.
        for controller in &b.controllers {
            for missed in steerwright_report::shortfalls(&controller.pid.evidence) {
                let _ = writeln!(
                    text,
                    "{name}: {} controller: not met: {missed}",
                    controller.basis.name()
                );
            }
        }
        for remark in quality.remarks.iter().chain(&b.remarks) {
            let _ = writeln!(text, "  remark: {remark}");
        }
        for advice in &quality.advice {
            let _ = writeln!(text, "  advice: {advice}");
        }
    }
    // Last, where it is seen.
    text.push('\n');
    for b in all {
        let (folder, page) = (b.out.display(), b.out.join(PAGE));
        let _ = writeln!(text, "{} files in {folder}, to read: {}", b.files.len(), page.display());
    }
    text
}

fn validation_fit(model: &Model) -> Option<f64> {
    let [_, validation] = model.fits();
    validation
}

/// Adds a row, if a drive has a value in it.
fn push(table: &mut Table, name: String, cells: Vec<String>) {
    if cells.iter().any(|cell| *cell != none()) {
        table.push([vec![name], cells].concat());
    }
}

fn at_most(required: Option<f64>, unit: &str) -> String {
    match required {
        Some(required) => format!(" (≤ {required} {unit})"),
        None => String::new(),
    }
}

fn met(met: bool) -> String {
    if met { "met".into() } else { "not met".into() }
}

fn none() -> String {
    "-".into()
}
