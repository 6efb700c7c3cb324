//! Paths from recorded positions.
//!
//! Repeated points and outliers are left out (`outliers`), a penalised spline (`spline`) is laid through x
//! and y, and its parameter is found by iteration (`curve`): first the distance from point to point, which
//! noise lengthens, then the arc length at each point's foot. See `docs/methods/path.md`.

mod curve;
pub(crate) mod options;
mod outliers;
mod spline;

use crate::Error;
use crate::error::require;
use crate::paths::compose::document;
use crate::paths::recording::read_points;
use curve::{Curve, Deviation};
use options::{PointOptions, RecordedPath};
use outliers::{Cleaned, LEAST_POINTS, clean};
use steerwright_formats::{Document, PathPoint, SourceFile};

/// Most points of a path.
const MOST_POINTS: f64 = 1e6;
/// Longest smoothing that is tried to keep the curvature, m.
const LONGEST_SMOOTHING: f64 = 200.0;
/// Shortest smoothing that is tried to stay on the points, m.
const SHORTEST_SMOOTHING: f64 = 1.0;
/// Ratio of the smoothing lengths that are tried one after the other.
const RATIO: f64 = 1.3;

/// Reads recorded points and makes a path of them.
///
/// # Errors
/// As [`read_points`] and [`from_points`].
pub fn path_from_recording(
    text: &str,
    file: &str,
    options: &PointOptions,
) -> Result<RecordedPath, Error> {
    let points = read_points(text, file, &options.fixes)?;
    let mut recorded = from_points(&points.x_m, &points.y_m, options)?;
    recorded.warnings.splice(0..0, points.warnings);
    recorded.path.provenance.sources =
        vec![SourceFile::from_bytes(std::path::Path::new(file), text.as_bytes())];
    Ok(recorded)
}

/// Makes a path from positions in m, in driving order. A path that cannot be brought near enough to the
/// points is returned with its [`Excess`](super::Excess).
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::Jumps`], [`Error::Curvature`] and [`Error::Option`] where
/// the slices differ in length, hold something that is not a number, or an option cannot be.
pub fn from_points(xs: &[f64], ys: &[f64], options: &PointOptions) -> Result<RecordedPath, Error> {
    check(xs, ys, options)?;
    let cleaned = clean(xs, ys, options)?;
    let steps = cleaned.x.windows(2).zip(cleaned.y.windows(2));
    let length: f64 = steps.map(|(x, y)| (x[1] - x[0]).hypot(y[1] - y[0])).sum();
    let (option, must) = ("length of the path", "at most a million times its points' spacing");
    require(length <= MOST_POINTS * options.spacing, option, (length.round(), " m"), must)?;
    let mut warnings = warnings(&cleaned, xs.len(), options.closed);
    let found = smoothed(&cleaned, options)?;
    let (required, used) = (options.smoothing_length, found.smoothing);
    if used != required {
        let because = match used > required {
            true => format!("to keep the curvature below {} 1/m", options.max_curvature),
            false => "to stay on the points".to_owned(),
        };
        warnings.push(format!("smoothed over {used:.1} m instead of {required} m {because}"));
    }
    let mut path =
        document(&options.name, options.speed, options.closed, found.points, options.provenance());
    path.checked(&options.name)?;
    let Deviation { rms_m, largest_m, furthest_m, .. } = found.deviation;
    for (name, value) in [
        ("smoothing_length_used_m", used),
        ("deviation_rms_m", rms_m),
        ("deviation_largest_m", largest_m),
        ("noise_m", cleaned.noise),
    ] {
        let rounded = (value * 1e4).round() / 1e4;
        path.provenance.options.insert(name.into(), rounded.to_string());
    }
    Ok(RecordedPath {
        path,
        rms_distance_m: rms_m,
        largest_distance_m: largest_m,
        furthest_point_m: furthest_m,
        noise_m: cleaned.noise,
        excess: found.deviation.excess,
        smoothing_length_m: used,
        warnings,
    })
}

/// A curve that is smooth enough to drive, its points, and the distances of the recording from it.
struct Smoothed {
    smoothing: f64,
    points: Vec<PathPoint>,
    deviation: Deviation,
}

/// The longest smoothing that stays on the points; longer where the curvature requires it.
fn smoothed(cleaned: &Cleaned, options: &PointOptions) -> Result<Smoothed, Error> {
    let mut smoothing = options.smoothing_length;
    let mut best: Option<Smoothed> = None;
    loop {
        let curve = Curve::fit(cleaned, smoothing, options)?;
        let points = curve.points(options.spacing);
        let reached = curvature(&points);
        if reached > options.max_curvature {
            if let Some(best) = best {
                return Ok(best);
            }
            smoothing *= RATIO;
            if smoothing > LONGEST_SMOOTHING {
                return Err(Error::Curvature {
                    reached,
                    allowed: options.max_curvature,
                    smoothing_m: smoothing / RATIO,
                });
            }
            continue;
        }
        let deviation = curve.deviation(cleaned, smoothing, options.max_deviation);
        let is_longer = smoothing > options.smoothing_length;
        let is_off = deviation.excess.is_some();
        best = Some(Smoothed { smoothing, points, deviation });
        if is_longer || !is_off || smoothing / RATIO < SHORTEST_SMOOTHING {
            break;
        }
        smoothing /= RATIO;
    }
    best.ok_or(Error::TooFewPoints { got: cleaned.x.len(), need: LEAST_POINTS })
}

/// Largest curvature; infinite for a curve that has shrunk to a point or turns on the spot.
fn curvature(points: &[PathPoint]) -> f64 {
    let curvature = |p: &PathPoint| match p.curvature_per_m.abs() {
        k if k.is_finite() && p.distance_m.is_finite() => k,
        _ => f64::INFINITY,
    };
    let rises = points.windows(2).all(|w| w[1].distance_m > w[0].distance_m);
    if rises { points.iter().map(curvature).fold(0.0, f64::max) } else { f64::INFINITY }
}

fn check(xs: &[f64], ys: &[f64], options: &PointOptions) -> Result<(), Error> {
    require(xs.len() == ys.len(), "number of y", (ys.len() as f64, ""), "the number of x")?;
    for &v in xs.iter().chain(ys) {
        require(v.abs() < 1e8, "position", (v, " m"), "within 1e8 m")?;
    }
    options.check()
}

fn warnings(cleaned: &Cleaned, total: usize, closed: bool) -> Vec<String> {
    let mut out = Vec::new();
    if cleaned.repeated > 0 {
        out.push(format!(
            "left out {} of {total} points that repeat the one before",
            cleaned.repeated
        ));
    }
    for (i, jump) in &cleaned.outliers {
        out.push(format!("left out point {}: {jump:.2} m off its neighbours", i + 1));
    }
    // Rows may be missing: the spline bridges the gap, but the road there was not recorded.
    let points = cleaned.x.windows(2).zip(cleaned.y.windows(2));
    let steps: Vec<f64> = points.map(|(x, y)| (x[1] - x[0]).hypot(y[1] - y[0])).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let largest = (8.0 * usual).max(5.0);
    for (i, step) in steps.iter().enumerate().filter(|(_, s)| **s > largest) {
        out.push(format!(
            "a gap of {step:.1} m at x {:.1} m, y {:.1} m was bridged",
            cleaned.x[i], cleaned.y[i]
        ));
    }
    let last = cleaned.x.len() - 1;
    let closing = (cleaned.x[last] - cleaned.x[0]).hypot(cleaned.y[last] - cleaned.y[0]);
    if closed && closing > largest {
        out.push(format!(
            "the last point is {closing:.1} m from the first: the road that closes it was not recorded"
        ));
    }
    out
}
