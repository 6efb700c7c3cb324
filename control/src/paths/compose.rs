//! Paths composed of straights, arcs and clothoids.
//!
//! The curvature is linear in arc length along each segment; the position ∫(cos ψ, sin ψ) ds is taken by
//! five-point Gauss–Legendre quadrature on panels over which the heading turns little: the error stays
//! below 1e-9 m over kilometres. Lengths in m, angles in rad, curvature in 1/m, positive to the left.

use crate::Error;
use steerwright_formats::{Document, Guidance, Path, PathPoint, Provenance};

/// Default of the largest distance between points, m.
pub(super) const DEFAULT_SPACING: f64 = 0.5;
/// Largest turn over one quadrature panel, rad; the error of a panel is below 1e-15 of its length.
const PANEL_TURN: f64 = 0.1;
/// Distance before a jump of curvature at which the old curvature is stated, m.
const JUMP: f64 = 1e-3;

/// Composes a path segment by segment, starting at the origin along x.
#[derive(Debug, Clone)]
pub struct PathComposer {
    end: PathPoint,
    points: Vec<PathPoint>,
    spacing: f64,
    problem: Option<String>,
}

impl Default for PathComposer {
    fn default() -> Self {
        Self::new()
    }
}

impl PathComposer {
    /// An empty path at the origin, heading along x.
    #[must_use]
    pub fn new() -> Self {
        Self::from_pose(0.0, 0.0, 0.0)
    }

    /// An empty path at a pose.
    #[must_use]
    pub fn from_pose(x: f64, y: f64, heading: f64) -> Self {
        let end = PathPoint {
            distance_m: 0.0,
            x_m: x,
            y_m: y,
            heading_rad: heading,
            curvature_per_m: 0.0,
        };
        Self { end, points: Vec::new(), spacing: DEFAULT_SPACING, problem: None }
    }

    /// Sets the largest distance between points, m.
    #[must_use]
    pub fn spacing(mut self, spacing: f64) -> Self {
        if !(spacing.is_finite() && spacing >= 2.0 * JUMP) {
            self.fault(format!("a spacing of {spacing} m between points is too small"));
        } else {
            self.spacing = spacing;
        }
        self
    }

    /// The end of the path so far.
    #[must_use]
    pub fn end(&self) -> PathPoint {
        self.end
    }

    /// Goes straight.
    #[must_use]
    pub fn straight(self, length: f64) -> Self {
        self.clothoid(0.0, 0.0, length)
    }

    /// Follows a circle.
    #[must_use]
    pub fn arc(self, curvature: f64, length: f64) -> Self {
        self.clothoid(curvature, curvature, length)
    }

    /// Changes curvature linearly from one value to another.
    #[must_use]
    pub fn clothoid(mut self, from: f64, to: f64, length: f64) -> Self {
        if !(from.is_finite() && to.is_finite() && length.is_finite() && length >= 0.0) {
            self.fault(format!("no segment from {from} to {to} 1/m is {length} m long"));
        }
        if self.problem.is_some() || length == 0.0 {
            return self;
        }
        self.start_segment(from);
        let start = self.end;
        let rate = (to - from) / length;
        let pieces = (length / self.spacing - 1e-9).ceil().max(1.0) as usize;
        for i in 1..=pieces {
            // From the segment's start each time: rounding of the arc length does not add up.
            let s = length * i as f64 / pieces as f64;
            let (dx, dy) = displacement(self.end.heading_rad, self.end.curvature_per_m, rate, {
                s - length * (i - 1) as f64 / pieces as f64
            });
            self.end = PathPoint {
                distance_m: start.distance_m + s,
                x_m: self.end.x_m + dx,
                y_m: self.end.y_m + dy,
                heading_rad: start.heading_rad + (from + 0.5 * rate * s) * s,
                curvature_per_m: from + rate * s,
            };
            self.points.push(self.end);
        }
        self
    }

    /// Adds the first point, or changes the curvature to `from` at the end of the last segment.
    fn start_segment(&mut self, from: f64) {
        let jump = (from - self.end.curvature_per_m).abs() > 1e-12;
        self.end.curvature_per_m = from;
        let Some(last) = self.points.last_mut() else {
            self.points.push(self.end);
            return;
        };
        if jump {
            // Curvature is interpolated linearly between points: the old value holds until just before.
            let old = *last;
            let (dx, dy) = displacement(old.heading_rad, old.curvature_per_m, 0.0, -JUMP);
            *last = PathPoint {
                distance_m: old.distance_m - JUMP,
                x_m: old.x_m + dx,
                y_m: old.y_m + dy,
                heading_rad: old.heading_rad - JUMP * old.curvature_per_m,
                curvature_per_m: old.curvature_per_m,
            };
            self.points.push(self.end);
        }
    }

    fn fault(&mut self, problem: String) {
        self.problem.get_or_insert(problem);
    }

    /// The finished path for a speed, with default guidance.
    ///
    /// # Errors
    /// [`Error::Road`] where a segment was impossible, [`Error::Document`] where the path has no
    /// length or the speed is not positive.
    pub fn finish(self, name: &str, speed: f64) -> Result<Path, Error> {
        if let Some(problem) = self.problem {
            return Err(Error::Road { road: "composed path", problem });
        }
        let path = document(name, speed, false, self.points, Provenance::default());
        path.checked(name)?;
        Ok(path)
    }
}

/// A path document around points, made by this version.
pub(crate) fn document(
    name: &str,
    speed: f64,
    closed: bool,
    points: Vec<PathPoint>,
    mut provenance: Provenance,
) -> Path {
    provenance.version = env!("CARGO_PKG_VERSION").into();
    Path {
        schema: Path::SCHEMA.into(),
        name: name.into(),
        closed,
        guidance: Guidance::default(),
        schedule: vec![],
        speed_mps: speed,
        points,
        profile: None,
        provenance,
    }
}

/// ∫(cos ψ, sin ψ) ds over `length` from heading and curvature at the start.
pub(crate) fn displacement(heading: f64, curvature: f64, rate: f64, length: f64) -> (f64, f64) {
    let end_curvature = curvature + rate * length;
    let turn = curvature.abs().max(end_curvature.abs()) * length.abs();
    let panels = (turn / PANEL_TURN).ceil().max(1.0) as usize;
    let half = 0.5 * length / panels as f64;
    let (mut x, mut y) = (0.0, 0.0);
    for panel in 0..panels {
        let middle = half * (2 * panel + 1) as f64;
        for (node, weight) in GAUSS {
            let s = middle + half * node;
            let (sin, cos) = (heading + (curvature + 0.5 * rate * s) * s).sin_cos();
            x += weight * half * cos;
            y += weight * half * sin;
        }
    }
    (x, y)
}

/// Nodes and weights of five-point Gauss–Legendre quadrature on [−1, 1].
pub(crate) const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_lies_on_its_circle() {
        let radius = 20.0;
        let path =
            PathComposer::new().arc(1.0 / radius, 300.0).finish("circle", 10.0).expect("a path");
        for p in &path.points {
            let r = p.x_m.hypot(p.y_m - radius);
            assert!((r - radius).abs() < 1e-9, "{r}");
            assert!((p.x_m - radius * (p.distance_m / radius).sin()).abs() < 1e-9);
            assert!((p.heading_rad - p.distance_m / radius).abs() < 1e-12);
        }
    }

    /// Fresnel integrals by their power series: x = Σ (−1)ⁿ a²ⁿ s⁴ⁿ⁺¹/((4n+1)(2n)!), a = κ′/2.
    #[test]
    fn a_clothoid_agrees_with_the_fresnel_series() {
        let (length, end) = (60.0, 0.08);
        let a = 0.5 * end / length;
        let path = PathComposer::new().clothoid(0.0, end, length).finish("clothoid", 10.0).unwrap();
        for p in &path.points {
            let s = p.distance_m;
            let (mut x, mut y, mut term) = (0.0, 0.0, s);
            for k in 0..40 {
                let n = f64::from(2 * k + 1);
                let sign = if (k / 2) % 2 == 0 { 1.0 } else { -1.0 };
                *(if k % 2 == 0 { &mut x } else { &mut y }) += sign * term / n;
                term *= a * s * s / f64::from(k + 1);
            }
            assert!((p.x_m - x).hypot(p.y_m - y) < 1e-9, "at {s}: {} {x}, {} {y}", p.x_m, p.y_m);
        }
    }

    #[test]
    fn a_jump_of_curvature_keeps_both_values() {
        let path = PathComposer::new().straight(10.0).arc(0.05, 10.0).finish("jump", 5.0).unwrap();
        let i = path.points.iter().position(|p| p.curvature_per_m != 0.0).unwrap();
        assert_eq!(path.points[i].distance_m, 10.0);
        assert_eq!(path.points[i - 1].curvature_per_m, 0.0);
        assert!((path.points[i - 1].distance_m - (10.0 - JUMP)).abs() < 1e-12);
    }

    #[test]
    fn impossible_segments_are_rejected() {
        let error = PathComposer::new().straight(-1.0).finish("bad", 5.0).unwrap_err();
        assert!(error.to_string().contains("-1 m long"), "{error}");
        assert!(!error.hint().is_empty());
        assert!(PathComposer::new().finish("empty", 5.0).is_err());
        assert!(PathComposer::new().straight(5.0).finish("speed", 0.0).is_err());
    }
}
