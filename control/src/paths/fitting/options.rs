//! How recorded positions become a path, and the path with its distance from them.

use crate::Error;
use crate::error::positive;
use crate::paths::recording::fixes::FixOptions;
use steerwright_formats::{Path, Provenance};

/// How recorded points become a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PointOptions {
    /// A readable name.
    pub name: String,
    /// Speed the path is made for, m/s.
    pub speed: f64,
    /// Whether the last point leads to the first.
    pub closed: bool,
    /// Points nearer than this to the one before count as repeated, m.
    pub minimum_spacing: f64,
    /// Waves in the road shorter than this are smoothed away, m.
    pub smoothing_length: f64,
    /// Largest curvature of the path, 1/m: smoothing is lengthened until it is kept.
    pub max_curvature: f64,
    /// A point further than this from the curve through its neighbours is an outlier, m.
    pub largest_jump: f64,
    /// Largest distance of a point from the path, m. `None`: the distance that the points' noise explains.
    pub max_deviation: Option<f64>,
    /// Distance between the path's points, m.
    pub spacing: f64,
    /// Which fixes of a satellite receiver are used.
    pub fixes: FixOptions,
}

impl Default for PointOptions {
    fn default() -> Self {
        Self {
            name: "recorded path".into(),
            speed: 10.0,
            closed: false,
            minimum_spacing: 0.1,
            smoothing_length: 20.0,
            max_curvature: 0.2,
            largest_jump: 1.0,
            max_deviation: None,
            spacing: 0.5,
            fixes: FixOptions::default(),
        }
    }
}

impl PointOptions {
    pub(crate) fn check(&self) -> Result<(), Error> {
        positive([
            ("minimum spacing", self.minimum_spacing, " m"),
            ("smoothing length", self.smoothing_length, " m"),
            ("largest curvature", self.max_curvature, " 1/m"),
            ("largest jump", self.largest_jump, " m"),
            ("spacing", self.spacing, " m"),
            ("speed", self.speed, " m/s"),
            ("largest deviation", self.max_deviation.unwrap_or(1.0), " m"),
        ])
    }

    pub(crate) fn provenance(&self) -> Provenance {
        let numbers = [
            ("minimum_spacing_m", Some(self.minimum_spacing)),
            ("smoothing_length_m", Some(self.smoothing_length)),
            ("max_curvature_per_m", Some(self.max_curvature)),
            ("largest_jump_m", Some(self.largest_jump)),
            ("max_deviation_m", self.max_deviation),
            ("spacing_m", Some(self.spacing)),
        ];
        let stated = |(key, value): (&str, Option<f64>)| Some((key.to_owned(), value?.to_string()));
        let mut options: std::collections::BTreeMap<_, _> =
            numbers.into_iter().filter_map(stated).collect();
        options.insert("closed".into(), self.closed.to_string());
        Provenance { options, ..Provenance::default() }
    }
}

/// A path, and how it relates to the points it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedPath {
    /// The path.
    pub path: Path,
    /// Root mean square of the points' distances from the path, m.
    pub rms_distance_m: f64,
    /// Largest distance of a point from the path, m.
    pub largest_distance_m: f64,
    /// That point, m.
    pub furthest_point_m: [f64; 2],
    /// The points' noise in each direction, as a standard deviation, m.
    pub noise_m: f64,
    /// The deviation that exceeds its limit, if any does: the path is off the points.
    pub excess: Option<Excess>,
    /// Smoothing length used, m; longer than that of the options where the curvature required it, shorter
    /// where the points did.
    pub smoothing_length_m: f64,
    /// Warnings about points that were left out and changes of the options.
    pub warnings: Vec<String>,
}

/// The deviation of a path that is further off its points than allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Distance of a point, or the mean distance of neighbours to one side, m.
    pub deviation_m: f64,
    /// The limit, m.
    pub limit_m: f64,
    /// Whether it is the mean of neighbours.
    pub is_mean: bool,
    /// The point, m.
    pub at_m: [f64; 2],
}

impl std::fmt::Display for Excess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.at_m;
        let what = if self.is_mean { "neighbouring points are on average" } else { "a point is" };
        let (deviation, limit) = (self.deviation_m, self.limit_m);
        write!(
            f,
            "{what} {deviation:.2} m off the path at x {x:.1} m, y {y:.1} m, allowed {limit:.2} m"
        )
    }
}
