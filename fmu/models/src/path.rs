//! The geometry of a reference path: points in arc length, what lies between them, and the foot
//! of a perpendicular on it.
//!
//! Between two points the position is the quintic that has the positions, unit tangents
//! `(cos ψ, sin ψ)` and curvature vectors `κ·(−sin ψ, cos ψ)` of both (error of sixth order in the
//! angle turned; below 1e-5 m where 5 m lie between points of a 10 m radius); the heading is the
//! cubic with the headings and curvatures of both; the curvature is linear. Before the first and
//! beyond the last point an open path goes on straight. A closed path has no end: distances go on
//! from lap to lap, and so does the heading.
//!
//! The foot s of a position p solves `f(s) = (p − q(s))·t(s) = 0`, t the unit tangent. From a known
//! distance it is sought in the direction in which f points and the first zero is taken, at most
//! [`WINDOW`] away: so progress moves along the path and never jumps to another branch where the
//! path crosses or touches itself, and a step costs the same however long the path is. So does the path
//! at a distance, whose segment is looked up (`stretches`).

use crate::angle::wrap_angle;
use crate::error::Error;
use crate::stretches::Stretches;
use std::f64::consts::{FRAC_PI_2, TAU};

/// How far from the last progress the foot is sought, m.
pub const WINDOW: f64 = 50.0;

/// Branches whose distances from the vehicle differ by less than this are equally near, m.
const SAME_PLACE: f64 = 1e-3;

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathPoint {
    /// Arc length, m.
    pub distance: f64,
    /// Position, m.
    pub x: f64,
    /// Position, m.
    pub y: f64,
    /// Heading ψ, rad.
    pub heading: f64,
    /// Curvature κ, 1/m, positive to the left.
    pub curvature: f64,
}

/// A point with the tangent at it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    point: PathPoint,
    cos: f64,
    sin: f64,
}

/// A validated path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathGeometry {
    nodes: Vec<Node>,
    stretches: Stretches,
    closed: bool,
    /// Heading gained in a lap of a closed path, a whole number of turns.
    turn: f64,
}

/// The foot of a position on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// The foot; its distance goes on from lap to lap.
    pub foot: PathPoint,
    /// Cross-track error, m, positive to the left of the path.
    pub cross_track_error: f64,
}

impl PathGeometry {
    /// Checks the points and makes a path of them. Headings may be wrapped. Of a closed path the
    /// last point may repeat the first; where it does not, a last segment is added.
    ///
    /// # Errors
    /// Names the point that is wrong.
    pub fn new(points: &[PathPoint], closed: bool) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::TooFewPoints { got: points.len() });
        }
        let mut points = points.to_vec();
        for (index, p) in points.iter().enumerate() {
            for (name, value) in [
                ("the distance", p.distance),
                ("x", p.x),
                ("y", p.y),
                ("the heading", p.heading),
                ("the curvature", p.curvature),
            ] {
                if !value.is_finite() {
                    return Err(Error::Point { index, name, value });
                }
            }
        }
        for i in 1..points.len() {
            let before = points[i - 1].heading;
            points[i].heading = before + wrap_angle(points[i].heading - before);
        }
        let turn = if closed { close(&mut points) } else { 0.0 };
        for (i, pair) in points.windows(2).enumerate() {
            check_segment(i, &pair[0], &pair[1])?;
        }
        let distances: Vec<f64> = points.iter().map(|p| p.distance).collect();
        let stretches = Stretches::of(&distances);
        let nodes = points
            .into_iter()
            .map(|point| {
                let (sin, cos) = point.heading.sin_cos();
                Node { point, cos, sin }
            })
            .collect();
        Ok(Self { nodes, stretches, closed, turn })
    }

    /// Distance of the first point, m.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.nodes[0].point.distance
    }

    /// Distance of the last point, m; of a closed path, where the second lap begins.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.nodes[self.nodes.len() - 1].point.distance
    }

    /// Whether the path has no end.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The path at a distance, which may lie beyond its ends.
    #[must_use]
    pub fn at(&self, distance: f64) -> PathPoint {
        let (lap, local) = self.lap(distance);
        let mut point = if local < self.start() {
            extend(&self.nodes[0], local)
        } else if local >= self.end() {
            extend(&self.nodes[self.nodes.len() - 1], local)
        } else {
            self.within(self.segment(local), local)
        };
        point.distance = distance;
        point.heading += lap * self.turn;
        point
    }

    /// The foot of a position, sought from a distance known to be near it.
    #[must_use]
    pub fn project(&self, x: f64, y: f64, from: f64) -> Projection {
        let foot = self.at(self.seek(x, y, from));
        let (sin, cos) = foot.heading.sin_cos();
        Projection { foot, cross_track_error: (y - foot.y) * cos - (x - foot.x) * sin }
    }

    /// The foot of a position anywhere on the path, for a vehicle that heads `yaw`: of all
    /// branches that come within 1 m of the nearest, those are preferred that go the vehicle's
    /// way, then the nearest, then the first.
    #[must_use]
    pub fn locate(&self, x: f64, y: f64, yaw: f64) -> Projection {
        let nearest = self.chords(x, y).map(|c| c.away).fold(f64::INFINITY, f64::min);
        // Against the vehicle's way, how far away, distance along the path.
        let mut best: Option<(bool, f64, f64)> = None;
        for chord in self.chords(x, y).filter(|c| c.away <= nearest + 1.0) {
            let against = wrap_angle(yaw - chord.heading).abs() > FRAC_PI_2;
            let better = best.is_none_or(|b| {
                if against == b.0 { chord.away < b.1 - SAME_PLACE } else { !against }
            });
            if better {
                best = Some((against, chord.away, chord.distance));
            }
        }
        self.project(x, y, best.map_or(self.start(), |b| b.2))
    }

    /// Laps done at a distance, and the distance within the lap.
    fn lap(&self, distance: f64) -> (f64, f64) {
        if !self.closed {
            return (0.0, distance);
        }
        let length = self.end() - self.start();
        let lap = ((distance - self.start()) / length).floor();
        (lap, (distance - lap * length).clamp(self.start(), self.end()))
    }

    /// The segment a distance lies in.
    fn segment(&self, local: f64) -> usize {
        let near = self.stretches.around(local);
        let after = near.start + self.nodes[near].partition_point(|n| n.point.distance <= local);
        after.saturating_sub(1).min(self.nodes.len() - 2)
    }

    /// The path within a segment.
    fn within(&self, segment: usize, local: f64) -> PathPoint {
        let (a, b) = (&self.nodes[segment], &self.nodes[segment + 1]);
        let length = b.point.distance - a.point.distance;
        let s = (local - a.point.distance) / length;
        let (s2, s3) = (s * s, s * s * s);
        // Hermite polynomials of fifth degree: end position, slopes, second derivatives.
        let to_b = s3 * (10.0 - s * (15.0 - 6.0 * s));
        let slope_a = s - s3 * (6.0 - s * (8.0 - 3.0 * s));
        let slope_b = -s3 * (4.0 - s * (7.0 - 3.0 * s));
        let bend_a = 0.5 * s2 * (1.0 - s * (3.0 - s * (3.0 - s)));
        let bend_b = 0.5 * s3 * (1.0 - s * (2.0 - s));
        let (ta, tb) = (slope_a * length, slope_b * length);
        let (na, nb) = (
            bend_a * length * length * a.point.curvature,
            bend_b * length * length * b.point.curvature,
        );
        let x = a.point.x + to_b * (b.point.x - a.point.x) + ta * a.cos + tb * b.cos
            - na * a.sin
            - nb * b.sin;
        let y = a.point.y
            + to_b * (b.point.y - a.point.y)
            + ta * a.sin
            + tb * b.sin
            + na * a.cos
            + nb * b.cos;
        // And of third degree for the heading.
        let heading = a.point.heading
            + s2 * (3.0 - 2.0 * s) * (b.point.heading - a.point.heading)
            + (s - 2.0 * s2 + s3) * length * a.point.curvature
            + (s3 - s2) * length * b.point.curvature;
        let curvature = a.point.curvature + s * (b.point.curvature - a.point.curvature);
        PathPoint { distance: local, x, y, heading, curvature }
    }

    /// How far ahead a position lies as seen from a node.
    fn ahead_of(&self, node: usize, x: f64, y: f64) -> f64 {
        let n = &self.nodes[node];
        (x - n.point.x) * n.cos + (y - n.point.y) * n.sin
    }

    /// The distance of the foot, from a distance near it.
    fn seek(&self, x: f64, y: f64, from: f64) -> f64 {
        let last = self.nodes.len() - 1;
        let length = self.end() - self.start();
        let window = if self.closed { WINDOW.min(length / 2.0) } else { WINDOW };
        let (mut lap, local) = self.lap(from);
        if !self.closed && (local < self.start() || local >= self.end()) {
            let node = if local < self.start() { 0 } else { last };
            let ahead = self.ahead_of(node, x, y);
            if (node == 0) == (ahead < 0.0) {
                return self.nodes[node].point.distance + ahead;
            }
        }
        let local = local.clamp(self.start(), self.end());
        let mut segment = self.segment(local);
        let here = self.within(segment, local);
        let forward = ahead(&here, x, y) >= 0.0;
        let (mut low, mut high) = (local, local);
        loop {
            let node = if forward { segment + 1 } else { segment };
            let border = self.nodes[node].point.distance;
            let ahead = self.ahead_of(node, x, y);
            if forward {
                high = border
            } else {
                low = border
            }
            if forward == (ahead <= 0.0) || ahead == 0.0 {
                return lap * length + self.foot_between(segment, low, high, x, y);
            }
            let walked = lap * length + border - from;
            if walked.abs() >= window {
                return from + walked.clamp(-window, window);
            }
            if forward {
                low = border
            } else {
                high = border
            }
            match (forward, node) {
                (true, n) if n == last && self.closed => {
                    (lap, segment) = (lap + 1.0, 0);
                    low = self.start();
                }
                (false, 0) if self.closed => {
                    (lap, segment) = (lap - 1.0, last - 1);
                    high = self.end();
                }
                (true, n) if n == last => return border + ahead,
                (false, 0) => return border + ahead,
                (true, _) => segment += 1,
                (false, _) => segment -= 1,
            }
        }
    }

    /// The zero of f within a part of a segment at whose ends it has opposite signs: Newton's
    /// method, `f' = κ·e − 1`, with bisection where that leaves the bracket.
    fn foot_between(&self, segment: usize, low: f64, high: f64, x: f64, y: f64) -> f64 {
        let (mut low, mut high) = (low, high);
        let mut s = 0.5 * (low + high);
        for _ in 0..60 {
            let point = self.within(segment, s);
            let (sin, cos) = point.heading.sin_cos();
            let (dx, dy) = (x - point.x, y - point.y);
            let f = dx * cos + dy * sin;
            if f > 0.0 {
                low = s;
            } else {
                high = s;
            }
            let slope = point.curvature * (dy * cos - dx * sin) - 1.0;
            let newton = s - f / slope;
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            if (next - s).abs() <= 1e-12 * (1.0 + s.abs()) {
                return next;
            }
            s = next;
        }
        s
    }

    /// The nearest point of each chord.
    fn chords(&self, x: f64, y: f64) -> impl Iterator<Item = ChordFoot> {
        self.nodes.windows(2).map(move |pair| {
            let (a, b) = (&pair[0].point, &pair[1].point);
            let (cx, cy) = (b.x - a.x, b.y - a.y);
            let square = cx * cx + cy * cy;
            let s = if square > 0.0 {
                (((x - a.x) * cx + (y - a.y) * cy) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            ChordFoot {
                away: (a.x + s * cx - x).hypot(a.y + s * cy - y),
                distance: a.distance + s * (b.distance - a.distance),
                heading: a.heading + s * (b.heading - a.heading),
            }
        })
    }
}

struct ChordFoot {
    away: f64,
    distance: f64,
    heading: f64,
}

/// How far ahead a position lies as seen from a point of the path.
fn ahead(point: &PathPoint, x: f64, y: f64) -> f64 {
    let (sin, cos) = point.heading.sin_cos();
    (x - point.x) * cos + (y - point.y) * sin
}

/// The straight line through an end.
fn extend(end: &Node, distance: f64) -> PathPoint {
    let beyond = distance - end.point.distance;
    PathPoint {
        distance,
        x: end.point.x + beyond * end.cos,
        y: end.point.y + beyond * end.sin,
        heading: end.point.heading,
        curvature: 0.0,
    }
}

/// Makes the last point meet the first; returns the heading gained in a lap.
fn close(points: &mut Vec<PathPoint>) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    let gap = (first.x - last.x).hypot(first.y - last.y);
    let rest = wrap_angle(first.heading - last.heading);
    let spacing = (last.distance - first.distance) / (points.len() - 1) as f64;
    let end = if gap > 0.01 * spacing {
        // The arc over the chord, for a turn of `rest` on the way.
        let half = 0.5 * rest;
        let arc = if half.abs() < 1e-6 { gap } else { gap * half / half.sin() };
        last.distance + arc
    } else {
        points.pop();
        last.distance
    };
    let turn = TAU * ((last.heading + rest - first.heading) / TAU).round();
    points.push(PathPoint { distance: end, heading: first.heading + turn, ..first });
    turn
}

fn check_segment(i: usize, a: &PathPoint, b: &PathPoint) -> Result<(), Error> {
    let arc = b.distance - a.distance;
    if arc <= 0.0 {
        return Err(Error::Distance { index: i + 1, distance: b.distance, before: a.distance });
    }
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let chord = dx.hypot(dy);
    if chord > 1.05 * arc + 0.02 {
        return Err(Error::ShorterThanChord { index: i + 1, chord, arc });
    }
    let heading = 0.5 * (a.heading + b.heading);
    // Points nearer than this may be out of order by measurement noise alone.
    if chord > 0.1 && dx * heading.cos() + dy * heading.sin() < 0.0 {
        return Err(Error::Heading { index: i, heading, chord: dy.atan2(dx) });
    }
    Ok(())
}
