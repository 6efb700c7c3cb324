//! The origin of an FMU, from its document: source files, options, fit and quality, without a date. The
//! archive has it as `extra/io.github.steerwright/provenance.json`, as the vendor annotation of the model
//! description and as a section of the documentation page.

use crate::Error;
use model_description::VendorAnnotation;
use quick_xml::escape::escape;
use serde::Serialize;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::fmt::Write;
use steerwright_formats::{Document, Provenance, SourceFile, sha256_hex};
use steerwright_units::Fmu;

pub(crate) const TOOL: &str = concat!("steerwright ", env!("CARGO_PKG_VERSION"));

#[derive(Debug, Clone, Serialize)]
pub(crate) struct Origin {
    schema: &'static str,
    fmu: &'static str,
    /// The tool that wrote the archive.
    packed_by: &'static str,
    document: DocumentFacts,
    sources: Vec<SourceFile>,
    options: BTreeMap<String, String>,
    evidence: Vec<Fact>,
}

#[derive(Debug, Clone, Serialize)]
struct DocumentFacts {
    file: String,
    schema: &'static str,
    name: String,
    sha256: String,
    written_by: String,
}

#[derive(Debug, Clone, Serialize)]
struct Fact {
    key: &'static str,
    value: Json,
    #[serde(skip_serializing_if = "str::is_empty")]
    unit: &'static str,
}

fn fact(key: &'static str, value: impl Into<Json>, unit: &'static str) -> Fact {
    Fact { key, value: value.into(), unit }
}

impl Origin {
    pub(crate) fn new(fmu: Fmu, document: &str, file: &str) -> Result<Self, Error> {
        let (name, provenance, evidence) = match fmu {
            Fmu::IdentifiedPlant => plant(Document::from_json(document, file)?),
            Fmu::BicyclePlant => bicycle(Document::from_json(document, file)?),
            Fmu::NonlinearVehicle => vehicle(Document::from_json(document, file)?),
            Fmu::LongitudinalPlant => longitudinal(Document::from_json(document, file)?),
            Fmu::LateralPid => pid(Document::from_json(document, file)?),
            Fmu::ReferencePath => path(Document::from_json(document, file)?),
            Fmu::PoseEstimator => estimator(Document::from_json(document, file)?),
        };
        Ok(Self {
            schema: "steerwright/provenance/1",
            fmu: fmu.name(),
            packed_by: TOOL,
            document: DocumentFacts {
                file: format!("resources/{}", fmu.resource()),
                schema: fmu.schema(),
                name,
                sha256: sha256_hex(document.as_bytes()),
                written_by: provenance
                    .as_ref()
                    .map_or_else(|| "hand".into(), |p| format!("steerwright {}", p.version)),
            },
            sources: provenance.as_ref().map(|p| p.sources.clone()).unwrap_or_default(),
            options: provenance.map(|p| p.options).unwrap_or_default(),
            evidence,
        })
    }

    pub(crate) fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The vendor annotation of the model description: one element, as the schema allows.
    pub(crate) fn annotation(&self) -> VendorAnnotation {
        let mut xml = String::new();
        let DocumentFacts { file, schema, name, sha256, written_by } = &self.document;
        let _ = write!(xml, "<Provenance packedBy=\"{}\">", escape(self.packed_by));
        let _ = write!(
            xml,
            "\n        <Document file=\"{}\" schema=\"{}\" name=\"{}\" sha256=\"{sha256}\" \
             writtenBy=\"{}\"/>",
            attribute(file),
            attribute(schema),
            attribute(name),
            attribute(written_by)
        );
        for SourceFile { name, sha256, .. } in &self.sources {
            let _ = write!(
                xml,
                "\n        <Source name=\"{}\" sha256=\"{}\"/>",
                attribute(name),
                attribute(sha256)
            );
        }
        for Fact { key, value, unit } in &self.evidence {
            let _ = write!(
                xml,
                "\n        <Evidence key=\"{key}\" value=\"{}\"",
                attribute(&raw(value))
            );
            if !unit.is_empty() {
                let _ = write!(xml, " unit=\"{unit}\"");
            }
            xml.push_str("/>");
        }
        xml.push_str("\n      </Provenance>");
        VendorAnnotation { tool: "steerwright".into(), xml }
    }

    pub(crate) fn markdown(&self) -> String {
        let DocumentFacts { file, name, sha256, written_by, .. } = &self.document;
        let mut text = String::from("| fact | value |\n|---|---|\n");
        let mut row = |label: &str, value: &str| {
            let _ = writeln!(text, "| {} | {} |", cell(label), value);
        };
        row("model", &cell(name));
        row("file", &format!("`{file}`, SHA-256 `{sha256}`, written by {}", cell(written_by)));
        for SourceFile { name, sha256, .. } in &self.sources {
            row("made from", &format!("{}, SHA-256 `{}`", cell(name), cell(sha256)));
        }
        for Fact { key, value, unit } in &self.evidence {
            row(&key.replace('_', " "), &cell(format!("{} {unit}", shown(value)).trim_end()));
        }
        row("packed by", self.packed_by);
        if !self.options.is_empty() {
            let options = self.options.iter().map(|(k, v)| format!("{k} = {v}"));
            row("options", &cell(&options.collect::<Vec<_>>().join(", ")));
        }
        text
    }
}

/// Text inside an attribute: characters illegal in XML become U+FFFD, line ends become spaces.
fn attribute(text: &str) -> String {
    let clean: String = text
        .chars()
        .map(|c| match c {
            '\n' | '\r' | '\t' => ' ',
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
            c => c,
        })
        .collect();
    escape(clean).into_owned()
}

/// Text inside a cell of a Markdown table, taken as it stands.
pub(crate) fn cell(text: &str) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        match c {
            '\n' | '\r' => cell.push(' '),
            '\\' | '|' | '<' | '>' | '&' | '*' | '_' | '`' | '[' | ']' | '#' | '~' | '!' => {
                cell.push('\\');
                cell.push(c);
            }
            c => cell.push(c),
        }
    }
    cell
}

fn raw(value: &Json) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// A number to four digits, a truth as yes or no.
fn shown(value: &Json) -> String {
    match value {
        Json::Bool(value) => if *value { "yes" } else { "no" }.into(),
        Json::Number(number) if number.is_f64() => shortened(number.as_f64().unwrap_or_default()),
        value => raw(value),
    }
}

/// A number to four digits.
pub(crate) fn shortened(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        let text = format!("{value:.3e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'));
    }
    #[allow(clippy::cast_possible_truncation)] // between −3 and 5
    let whole = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let digits = usize::try_from(3 - whole).unwrap_or(0);
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Name, provenance (`None` for a file written by hand) and evidence.
type Described = (String, Option<Provenance>, Vec<Fact>);

fn plant(plant: steerwright_formats::Plant) -> Described {
    let order = plant.order();
    let e = plant.evidence;
    let mut facts = quality(plant.quality);
    facts.extend(e.warnings.into_iter().map(|line| fact("warning", line, "")));
    facts.extend([
        fact("fit_held_out", e.fit.validation, "%"),
        fact("fit_held_out_one_step", e.fit.validation_one_step, "%"),
        fact("fit_estimation", e.fit.estimation, "%"),
        fact("method", e.method, ""),
        fact("order", order, ""),
        fact("horizon", e.horizon, ""),
        fact("estimation_samples", e.estimation_samples, ""),
        fact("held_out_samples", e.validation_samples, ""),
        fact("sample_time", plant.discrete.sample_time_s, "s"),
        fact("informative_up_to", e.excitation.informative_up_to_hz, "Hz"),
        fact("speed", plant.operating_point.speed_mps, "m/s"),
        fact("steering_ratio", plant.steering_ratio, ""),
        fact("input_delay", plant.input_delay_s, "s"),
    ]);
    (plant.name, Some(plant.provenance), facts)
}

fn bicycle(bicycle: steerwright_formats::Bicycle) -> Described {
    let vehicle = bicycle.vehicle;
    let mut facts = quality(bicycle.quality);
    facts.extend([
        fact("speed", vehicle.speed_mps, "m/s"),
        fact("steering_ratio", vehicle.steering_ratio, ""),
    ]);
    (vehicle.name, Some(bicycle.provenance), facts)
}

fn quality(quality: steerwright_formats::Quality) -> Vec<Fact> {
    let mut facts = vec![
        fact("quality", quality.grade.name(), ""),
        fact("quality_summary", quality.summary, ""),
    ];
    facts.extend(quality.reasons.into_iter().map(|reason| {
        let line = format!("{} ({}): {}", reason.grade, reason.code.name(), reason.message);
        fact("quality_reason", line, "")
    }));
    facts.extend(quality.remarks.into_iter().map(|line| fact("remark", line, "")));
    facts.extend(quality.advice.into_iter().map(|line| fact("advice", line, "")));
    facts
}

fn vehicle(vehicle: steerwright_formats::Vehicle) -> Described {
    // One that was written by hand has no quality of its own.
    let identified = vehicle.provenance.is_some();
    let mut facts = if identified { quality(vehicle.quality) } else { Vec::new() };
    facts.extend([
        fact("speed", vehicle.speed_mps, "m/s"),
        fact("steering_ratio", vehicle.actuator.steering_ratio, ""),
        fact("friction_coefficient", vehicle.tyres.friction_coefficient, ""),
    ]);
    (vehicle.name, vehicle.provenance, facts)
}

fn longitudinal(model: steerwright_formats::Longitudinal) -> Described {
    let e = model.evidence;
    let mut facts = quality(model.quality);
    facts.extend(e.warnings.into_iter().map(|line| fact("warning", line, "")));
    facts.extend([
        fact("fit_held_out", e.validation_fit, "%"),
        fact("fit_estimation", e.estimation_fit, "%"),
        fact("estimation_samples", e.estimation_samples, ""),
        fact("held_out_samples", e.validation_samples, ""),
        fact("sample_time", e.sample_time_s, "s"),
        fact("lowest_speed", e.speed_mps[0], "m/s"),
        fact("highest_speed", e.speed_mps[2], "m/s"),
        fact("command_unit", model.command_unit, ""),
        fact("grade_source", model.grade_source, ""),
    ]);
    (model.name, Some(model.provenance), facts)
}

fn estimator(estimator: steerwright_formats::Estimator) -> Described {
    let facts = vec![
        fact("gnss_latency", estimator.gnss.latency_s, "s"),
        fact("sideslip_per_yaw_rate", estimator.sideslip_per_yaw_rate_s, "s"),
        fact("speed", estimator.speed_mps, "m/s"),
    ];
    (estimator.name, None, facts)
}

fn pid(pid: steerwright_formats::Pid) -> Described {
    let (e, d) = (pid.evidence, pid.designed_for);
    let mut facts = quality(d.quality);
    facts.push(fact("specification_met", e.met, ""));
    facts.extend(e.shortfalls.into_iter().map(|s| {
        let line = format!("{}: {} required, {} reached", s.requirement, s.required, s.reached);
        fact("shortfall", line, "")
    }));
    facts.extend([
        fact("designed_for", d.name, ""),
        fact("designed_for_sha256", d.sha256, ""),
        fact("speed", d.speed_mps, "m/s"),
        fact("loop_delay", d.loop_delay_s, "s"),
        fact("overshoot", e.step.overshoot_percent, "%"),
    ]);
    facts.extend(e.step.settling_time_s.map(|time| fact("settling_time", time, "s")));
    facts.push(fact("steady_state_error", e.step.steady_state_error_percent, "%"));
    facts.push(fact("modulus_margin", e.margins.modulus_margin, ""));
    facts.extend(e.margins.phase_margin_deg.map(|margin| fact("phase_margin", margin, "deg")));
    (pid.name, Some(pid.provenance), facts)
}

fn path(path: steerwright_formats::Path) -> Described {
    let ends = path.points.first().zip(path.points.last());
    let length = ends.map_or(0.0, |(first, last)| last.distance_m - first.distance_m);
    let facts = vec![
        fact("length", length, "m"),
        fact("points", path.points.len(), ""),
        fact("closed", path.closed, ""),
        fact("speed", path.speed_mps, "m/s"),
    ];
    (path.name, Some(path.provenance), facts)
}
