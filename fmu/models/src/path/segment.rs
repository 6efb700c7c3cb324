//! The path between two points: polynomials of position, heading and curvature.

use steerwright_formats::PathPoint;

/// A point with the tangent at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub(super) point: PathPoint,
    pub(super) cos: f64,
    pub(super) sin: f64,
}

/// The path from a node to the next, as polynomials in the share s of the way, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    /// 1/m.
    pub(super) inverse_length: f64,
    /// Coefficients of s … s⁵ of x − x₀ and y − y₀.
    position: [[f64; 2]; 5],
    /// Coefficients of s, s², s³ of ψ − ψ₀.
    heading: [f64; 3],
    /// κ₁ − κ₀.
    curvature: f64,
}

impl Segment {
    pub(super) fn new(a: &Node, b: &Node) -> Self {
        let length = b.point.distance_m - a.point.distance_m;
        // Hermite polynomial of fifth degree: end position, slopes, second derivatives.
        let position = |way: f64, slopes: [f64; 2], bends: [f64; 2]| {
            let [ta, tb] = slopes.map(|slope| slope * length);
            let [na, nb] = bends.map(|bend| 0.5 * bend * length * length);
            [
                ta,
                na,
                10.0 * way - 6.0 * ta - 4.0 * tb - 3.0 * na + nb,
                -15.0 * way + 8.0 * ta + 7.0 * tb + 3.0 * na - 2.0 * nb,
                6.0 * way - 3.0 * (ta + tb) - na + nb,
            ]
        };
        let (ka, kb) = (a.point.curvature_per_m, b.point.curvature_per_m);
        let x = position(b.point.x_m - a.point.x_m, [a.cos, b.cos], [-ka * a.sin, -kb * b.sin]);
        let y = position(b.point.y_m - a.point.y_m, [a.sin, b.sin], [ka * a.cos, kb * b.cos]);
        // And of third degree for the heading.
        let turn = b.point.heading_rad - a.point.heading_rad;
        let heading =
            [length * ka, 3.0 * turn - length * (2.0 * ka + kb), -2.0 * turn + length * (ka + kb)];
        Self {
            inverse_length: 1.0 / length,
            position: std::array::from_fn(|i| [x[i], y[i]]),
            heading,
            curvature: kb - ka,
        }
    }

    /// The path at a distance within the segment, whose start is `from`.
    #[inline]
    pub(super) fn point_at(&self, from: &PathPoint, local: f64) -> PathPoint {
        let s = (local - from.distance_m) * self.inverse_length;
        let (s2, p) = (s * s, &self.position);
        let moved = |i: usize| {
            let (low, high) = (p[0][i] + p[1][i] * s, p[2][i] + p[3][i] * s);
            s * (low + s2 * (high + s2 * p[4][i]))
        };
        let [heading, curvature] = self.direction(from, local);
        PathPoint {
            distance_m: local,
            x_m: from.x_m + moved(0),
            y_m: from.y_m + moved(1),
            heading_rad: heading,
            curvature_per_m: curvature,
        }
    }

    /// Its heading and curvature alone.
    #[inline]
    pub(super) fn direction(&self, from: &PathPoint, local: f64) -> [f64; 2] {
        let s = (local - from.distance_m) * self.inverse_length;
        let [first, second, third] = self.heading;
        let turn = s * (first + s * (second + s * third));
        [from.heading_rad + turn, from.curvature_per_m + s * self.curvature]
    }

    /// Derivatives by the distance at a share s of the way: of position, of heading, and of curvature.
    #[inline]
    pub(super) fn derivatives(&self, s: f64) -> ([f64; 2], f64, f64) {
        let (s2, p) = (s * s, &self.position);
        let along = |i: usize| {
            let (low, high) = (p[0][i] + 2.0 * p[1][i] * s, 3.0 * p[2][i] + 4.0 * p[3][i] * s);
            self.inverse_length * (low + s2 * (high + s2 * (5.0 * p[4][i])))
        };
        let [first, second, third] = self.heading;
        let turn = first + s * (2.0 * second + s * (3.0 * third));
        ([along(0), along(1)], turn * self.inverse_length, self.curvature * self.inverse_length)
    }
}

/// The straight line through an end.
pub(super) fn extend(end: &Node, distance: f64) -> PathPoint {
    let beyond = distance - end.point.distance_m;
    PathPoint {
        distance_m: distance,
        x_m: end.point.x_m + beyond * end.cos,
        y_m: end.point.y_m + beyond * end.sin,
        heading_rad: end.point.heading_rad,
        curvature_per_m: 0.0,
    }
}
