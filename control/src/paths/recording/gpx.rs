//! Recorded points from GPX 1.0 and 1.1: the points of a track, else those of a route.
//!
//! The segments of the first track that has points are joined in order; `sat` and `fix` are used where given.

use super::fixes::{Fix, Quality, check_position};
use crate::Error;
use crate::error::point_fault;
use roxmltree::{Document, Node};

pub(crate) fn fixes(text: &str, file: &str) -> Result<(Vec<Fix>, Vec<String>), Error> {
    let fault = point_fault(file);
    let document = Document::parse(text).map_err(|e| {
        let at = e.pos();
        // The parser's text ends with the place, which the error states at its start.
        let text = e.to_string();
        let problem = text.rsplit_once(" at ").map_or(text.as_str(), |(text, _)| text).to_owned();
        fault(u64::from(at.row), at.col as usize, problem)
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "gpx" {
        let problem = format!("the document is a `{}`, not a `gpx`", root.tag_name().name());
        return Err(fault(1, 1, problem));
    }
    let points_of = |way: Node<'_, '_>, name: &str| -> Vec<roxmltree::NodeId> {
        way.descendants().filter(|n| n.tag_name().name() == name).map(|n| n.id()).collect()
    };
    let ways = |name: &str, point: &str| -> Vec<Vec<roxmltree::NodeId>> {
        let all = root.children().filter(|n| n.tag_name().name() == name);
        all.map(|way| points_of(way, point)).filter(|points| !points.is_empty()).collect()
    };
    let (mut all, mut kind) = (ways("trk", "trkpt"), "tracks");
    if all.is_empty() {
        (all, kind) = (ways("rte", "rtept"), "routes");
    }
    let mut warnings = Vec::new();
    if all.len() > 1 {
        warnings.push(format!("used the first of {} {kind}", all.len()));
    }
    let Some(points) = all.into_iter().next() else {
        return Err(fault(1, 1, "no track and no route with points".into()));
    };
    let mut fixes = Vec::with_capacity(points.len());
    let mut places = Places::new(text);
    for node in points.into_iter().filter_map(|id| document.get_node(id)) {
        let start = node.range().start;
        let line = places.line(start);
        let fault = |problem: String| {
            let at = document.text_pos_at(start);
            fault(u64::from(at.row), at.col as usize, problem)
        };
        let degrees = |name: &str| {
            let text =
                node.attribute(name).ok_or_else(|| fault(format!("the point has no {name}")))?;
            let value = text.trim().parse::<f64>();
            value.map_err(|_| fault(format!("{name} is `{text}`, not a number")))
        };
        let (latitude, longitude) = (degrees("lat")?, degrees("lon")?);
        check_position(latitude, longitude).map_err(&fault)?;
        let child = |name: &str| {
            let element = node.children().find(|n| n.tag_name().name() == name)?;
            element.text().map(str::trim)
        };
        let number = |name: &str| match child(name).map(str::parse::<f64>) {
            None => Ok(None),
            Some(Ok(value)) if value.is_finite() && value.abs() < 1e6 => Ok(Some(value)),
            Some(_) => Err(fault(format!("`{name}` is not a number"))),
        };
        let quality = match child("fix") {
            None => None,
            Some("none") => Some(Quality::Invalid),
            Some("2d" | "3d" | "pps") => Some(Quality::Alone),
            Some("dgps") => Some(Quality::Corrected),
            Some(other) => {
                return Err(fault(format!("`fix` is `{other}`, not none, 2d, 3d, dgps or pps")));
            }
        };
        let satellites = number("sat")?.map(|n| n as u32);
        let altitude = number("ele")?;
        fixes.push(Fix { line, latitude, longitude, altitude, quality, satellites });
    }
    Ok((fixes, warnings))
}

/// Line numbers of places in a text, which must come in order: one pass for all.
struct Places<'a> {
    text: &'a str,
    at: usize,
    line: u64,
}

impl<'a> Places<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, at: 0, line: 1 }
    }

    fn line(&mut self, place: usize) -> u64 {
        let between = self.text.as_bytes().get(self.at..place).unwrap_or_default();
        self.line += between.iter().filter(|b| **b == b'\n').count() as u64;
        self.at = self.at.max(place);
        self.line
    }
}
