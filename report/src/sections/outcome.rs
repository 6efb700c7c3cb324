//! The summary at the head, the tracking, and where everything came from.

use super::value;
use crate::figures::{self, DEG};
use crate::read::Track;
use crate::report::Report;
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{Model, Path, Provenance};

/// The conclusions of the files, before the numbers.
pub(crate) fn summary(report: &Report<'_>) -> Section {
    let mut blocks = Vec::new();
    if let Some(model) = report.model {
        let quality = model.quality();
        blocks.push(super::quality_note(quality));
        for (heading, list) in
            [("Limits of the model", &quality.remarks), ("What to do next", &quality.advice)]
        {
            if !list.is_empty() {
                blocks.push(Block::Heading(heading.into()));
                blocks.push(Block::List(list.clone()));
            }
        }
    }
    let warnings: Vec<String> = report
        .model
        .map_or(&[][..], Model::warnings)
        .iter()
        .chain(&report.remarks)
        .cloned()
        .collect();
    if !warnings.is_empty() {
        blocks.push(Block::Heading("Warnings".into()));
        blocks.push(Block::List(warnings));
    }
    let mut table = Table::new(["what", "result", "requirements"]);
    if let Some(model) = report.model {
        let [_, validated] = model.fits();
        let fit = super::optional(validated, 2, "%", "–");
        table.push([super::model::name(model), format!("validation fit {fit}"), String::new()]);
    }
    if let Some(fit) = report.bicycle_fit {
        table.push(["bicycle model".into(), format!("fit {}", value(fit, 2, "%")), String::new()]);
    }
    for c in &report.controllers {
        let step = c.in_loop.map_or(&c.pid.evidence.step, |l| l.metrics);
        let overshoot = value(step.overshoot_percent, 2, "%");
        let settled = super::optional(step.settling_time_s, 3, "s", "never");
        let text = format!("overshoot {overshoot}, settled {settled}");
        table.push([format!("controller: {}", c.name), text, super::controller::in_short(c)]);
    }
    for (name, track) in &report.tracks {
        let rms = super::length(track.errors().cross_track_rms_m);
        table.push([format!("track: {name}"), format!("cross-track RMS {rms}"), String::new()]);
    }
    // A model alone has its fits below.
    if table.rows().len() > 1 || report.model.is_none() {
        blocks.push(Block::Heading("At a glance".into()));
        blocks.push(Block::Table(table));
    }
    Section::new("Summary", blocks)
}

/// The road, the tracks and their errors.
pub(crate) fn tracking(path: Option<&Path>, tracks: &[(&str, &Track)]) -> Section {
    let mut blocks = Vec::new();
    if let Some(path) = path {
        let length = path.points.last().map_or(0.0, |p| p.distance_m);
        let tightest = path.points.iter().fold(0.0, |m: f64, p| m.max(p.curvature_per_m.abs()));
        let radius = if tightest > 0.0 { value(1.0 / tightest, 1, "m") } else { "∞".into() };
        blocks.push(Block::Text(format!(
            "{}: {} long{}, tightest radius {radius}, made for {}.",
            path.name,
            value(length, 1, "m"),
            if path.closed { ", closed" } else { "" },
            value(path.speed_mps, 2, "m/s"),
        )));
    }
    let points = path.map_or(&[][..], |p| &p.points);
    let caption = "Both axes have the same scale.";
    let figure = figures::reference_road(points, path.is_some_and(|p| p.closed), tracks);
    let height = figures::road_height(crate::WIDTH, points, tracks);
    blocks.push(Block::figure(figure, height, caption));
    if !tracks.is_empty() {
        let headers = ["track", "cross-track RMS", "cross-track largest", "yaw RMS", "yaw largest"];
        let mut table = Table::new(headers);
        for (name, track) in tracks {
            let e = track.errors();
            table.push([
                (*name).to_owned(),
                super::length(e.cross_track_rms_m),
                super::length(e.cross_track_max_m),
                value(e.heading_rms_rad * DEG, 3, "deg"),
                value(e.heading_max_rad * DEG, 3, "deg"),
            ]);
        }
        blocks.push(Block::Table(table));
        let caption = "Positive errors are to the left of the road. Yaw error is yaw against the \
                       road's heading; in a bend a steady part of it is sideslip, not a fault.";
        blocks.push(Block::figure(figures::tracking_errors(tracks), 660, caption));
    }
    Section::new("Following the reference road", blocks)
}

/// Names, hashes and options.
pub(crate) fn provenance(report: &Report<'_>) -> Section {
    let mut blocks = Vec::new();
    if !report.files.is_empty() {
        let mut table = Table::new(["file written", "SHA-256"]);
        report.files.iter().for_each(|f| table.push([f.name.as_str(), &f.sha256]));
        blocks.push(Block::Table(table));
    }
    let identified = report.model.and_then(Model::provenance);
    let identified = identified.map(|p| ("Identified model".to_owned(), p));
    let bicycle = report.bicycle.map(|b| ("Bicycle model".to_owned(), &b.provenance));
    let pids =
        report.controllers.iter().map(|c| (format!("Controller: {}", c.name), &c.pid.provenance));
    let path = report.path.map(|p| ("Reference road".to_owned(), &p.provenance));
    for (name, p) in identified.into_iter().chain(bicycle).chain(pids).chain(path) {
        push_provenance(&mut blocks, name, p);
    }
    Section { folded: true, ..Section::new("Provenance", vec![Block::Details(blocks)]) }
}

fn push_provenance(blocks: &mut Vec<Block>, name: String, p: &Provenance) {
    blocks.push(Block::Heading(name));
    blocks.push(Block::Text(format!("Written by steerwright {}.", p.version)));
    if !p.sources.is_empty() {
        let mut table = Table::new(["file read", "SHA-256"]);
        p.sources.iter().for_each(|f| table.push([f.name.as_str(), &f.sha256]));
        blocks.push(Block::Table(table));
    }
    if !p.options.is_empty() {
        let mut table = Table::new(["option", "value"]);
        p.options.iter().for_each(|(k, v)| table.push([k, v]));
        blocks.push(Block::Table(table));
    }
}
