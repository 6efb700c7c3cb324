//! Roads of straights, arcs and clothoids in a file: `road.toml`.
//!
//! ```toml
//! name = "bend to the left"
//! start = { x_m = 0.0, y_m = 0.0, heading_rad = 0.0 }      # may be left out
//!
//! [[segments]]
//! length_m = 50.0                                          # a straight
//! [[segments]]
//! length_m = 30.0                                          # a clothoid
//! end_curvature_per_m = 0.02
//! [[segments]]
//! length_m = 80.0                                          # an arc to the left
//! curvature_per_m = 0.02
//! ```
//!
//! A segment's curvature changes linearly from `curvature_per_m` (default 0) to `end_curvature_per_m`
//! (default the former). Positive is to the left.

use super::compose::PathComposer;
use crate::Error;
use crate::bicycle::place;
use serde::Deserialize;
use steerwright_formats::{Path, SourceFile};

/// Longest road, m.
const LONGEST: f64 = 5e5;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Road {
    name: String,
    #[serde(default)]
    start: Start,
    segments: Vec<toml::Spanned<Segment>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Start {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Segment {
    length_m: f64,
    #[serde(default)]
    curvature_per_m: f64,
    end_curvature_per_m: Option<f64>,
}

/// Reads a road and returns its path for a speed, m/s. `file` is named in errors.
///
/// # Errors
/// [`Error::RoadFile`] with line and column of an invalid value; [`Error::Document`] where the road has
/// no length or the speed is not positive.
pub fn path_from_road(text: &str, file: &str, speed: f64) -> Result<Path, Error> {
    let fault = |byte: usize, problem: String| {
        let (line, column) = place(text, byte);
        Error::RoadFile { file: file.into(), line, column, problem }
    };
    let road: Road = toml::from_str(text).map_err(|e| {
        fault(e.span().map_or(0, |span| span.start), e.message().replace('\n', "; "))
    })?;
    let Start { x_m, y_m, heading_rad } = road.start;
    if !(x_m.abs() < 1e8 && y_m.abs() < 1e8 && heading_rad.is_finite()) {
        return Err(fault(
            0,
            "the start is invalid: x_m and y_m must be below 1e8 m, heading_rad finite".into(),
        ));
    }
    let mut composer = PathComposer::from_pose(x_m, y_m, heading_rad);
    let mut total = 0.0;
    for spanned in &road.segments {
        let at = spanned.span().start;
        let &Segment { length_m, curvature_per_m: from, end_curvature_per_m } = spanned.as_ref();
        let to = end_curvature_per_m.unwrap_or(from);
        if !(length_m > 0.0 && length_m.is_finite()) {
            return Err(fault(at, format!("length_m is {length_m}: it must be greater than 0")));
        }
        // A car turns within metres; a larger curvature is a wrong unit.
        if let Some(curvature) = [from, to].into_iter().find(|k| !(-1.0..=1.0).contains(k)) {
            return Err(fault(at, format!("a curvature of {curvature} 1/m: it must be within ±1")));
        }
        total += length_m;
        if total > LONGEST {
            return Err(fault(
                at,
                format!("the road is {total} m long: it must be at most {LONGEST} m"),
            ));
        }
        composer = composer.clothoid(from, to, length_m);
    }
    if road.segments.is_empty() {
        return Err(fault(0, "the road has no segments".into()));
    }
    let mut path = composer.finish(&road.name, speed)?;
    path.provenance.sources =
        vec![SourceFile::from_bytes(std::path::Path::new(file), text.as_bytes())];
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROAD: &str = "name = \"bend\"\nstart = { x_m = 3.0, y_m = -1.0, heading_rad = 1.5707963267948966 }\n\
        [[segments]]\nlength_m = 20.0\n[[segments]]\nlength_m = 30.0\nend_curvature_per_m = 0.02\n\
        [[segments]]\nlength_m = 50.0\ncurvature_per_m = 0.02\n";

    #[test]
    fn a_road_is_its_segments() {
        let path = path_from_road(ROAD, "road.toml", 10.0).unwrap();
        let last = path.points[path.points.len() - 1];
        assert!((last.distance_m - 100.0).abs() < 1e-9);
        // A clothoid turns by half the angle of an arc with its end curvature.
        let turned = 0.5 * 0.02 * 30.0 + 0.02 * 50.0;
        assert!((last.heading_rad - std::f64::consts::FRAC_PI_2 - turned).abs() < 1e-9);
        let straight = path.points.iter().find(|p| p.distance_m == 20.0).unwrap();
        assert!((straight.x_m - 3.0).hypot(straight.y_m - 19.0) < 1e-9, "{straight:?}");
        assert_eq!(path.provenance.sources.len(), 1);
        assert_eq!((path.name.as_str(), path.speed_mps), ("bend", 10.0));
    }

    #[test]
    fn faults_name_file_line_and_column() {
        for (from, to, expected) in [
            ("length_m = 30.0", "length_m = -30.0", "r.toml:5:1: length_m is -30"),
            ("length_m = 30.0", "length = 30.0", "r.toml:6:1: unknown field `length`"),
            ("length_m = 30.0", "length_m = nan", "length_m is NaN"),
            ("length_m = 30.0", "length_m = 1e9", "it must be at most 500000 m"),
            ("= 0.02\n[[", "= 20\n[[", "a curvature of 20 1/m"),
            ("x_m = 3.0, ", "", "missing field `x_m`"),
            ("x_m = 3.0", "x_m = inf", "the start is invalid"),
            ("name = \"bend\"", "name = bend", "r.toml:1:8: "),
        ] {
            assert!(ROAD.contains(from), "{from}");
            let error = path_from_road(&ROAD.replacen(from, to, 1), "r.toml", 10.0).unwrap_err();
            assert!(error.to_string().contains(expected), "{from} -> {to}: {error}");
            assert!(error.hint().contains("[[segments]]"), "{}", error.hint());
        }
        let error = path_from_road("name = \"a\"\nsegments = []\n", "r.toml", 10.0).unwrap_err();
        assert!(error.to_string().contains("no segments"), "{error}");
        assert!(path_from_road(ROAD, "r.toml", 0.0).is_err());
    }
}
