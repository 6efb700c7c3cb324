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
//! at a distance, whose segment is looked up (`intervals`).

use crate::angle::wrap_angle;
use crate::error::Error;
use crate::intervals::Intervals;
use crate::trigonometry::sin_cos;
use std::f64::consts::{FRAC_PI_2, TAU};

/// How far from the last progress the foot is sought, m.
pub const WINDOW: f64 = 50.0;

/// A Newton step of this length is the last, m: it leaves less than 1e-13 m.
const NEAR: f64 = 1e-8;

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

/// The path from a node to the next, as polynomials in the share s of the way, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    /// 1/m.
    inverse_length: f64,
    /// Coefficients of s … s⁵ of x − x₀ and y − y₀.
    position: [[f64; 2]; 5],
    /// Coefficients of s, s², s³ of ψ − ψ₀.
    heading: [f64; 3],
    /// κ₁ − κ₀.
    curvature: f64,
}

/// A validated path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathGeometry {
    nodes: Vec<Node>,
    segments: Vec<Segment>,
    intervals: Intervals,
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
        let intervals = Intervals::of(&distances);
        let nodes: Vec<Node> = points
            .into_iter()
            .map(|point| {
                let (sin, cos) = point.heading.sin_cos();
                Node { point, cos, sin }
            })
            .collect();
        let segments = nodes.windows(2).map(|pair| Segment::new(&pair[0], &pair[1])).collect();
        Ok(Self { nodes, segments, intervals, closed, turn })
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

    /// The heading of the path at a distance, which may lie beyond its ends.
    #[must_use]
    pub fn heading(&self, distance: f64) -> f64 {
        let (lap, local) = self.lap(distance);
        let heading = if local < self.start() {
            self.nodes[0].point.heading
        } else if local >= self.end() {
            self.nodes[self.nodes.len() - 1].point.heading
        } else {
            let segment = self.segment(local);
            let from = &self.nodes[segment].point;
            let piece = &self.segments[segment];
            piece.heading(from, (local - from.distance) * piece.inverse_length)
        };
        heading + lap * self.turn
    }

    /// The foot of a position, sought from a distance known to be near it.
    #[must_use]
    pub fn project(&self, x: f64, y: f64, from: f64) -> Projection {
        match self.seek(x, y, from) {
            // The end belongs to what is beyond it.
            Sought::Within(lap, foot) if foot.distance < self.end() => {
                let length = self.end() - self.start();
                let foot = PathPoint {
                    distance: foot.distance + lap * length,
                    heading: foot.heading + lap * self.turn,
                    ..foot
                };
                foot.projection(x, y)
            }
            Sought::Within(lap, foot) => {
                self.at(foot.distance + lap * (self.end() - self.start())).projection(x, y)
            }
            Sought::At(distance) => self.at(distance).projection(x, y),
        }
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
        self.intervals.count(local).saturating_sub(1).min(self.nodes.len() - 2)
    }

    /// The path within a segment.
    fn within(&self, segment: usize, local: f64) -> PathPoint {
        let (from, piece) = (&self.nodes[segment].point, &self.segments[segment]);
        let s = (local - from.distance) * piece.inverse_length;
        let (s2, p) = (s * s, &piece.position);
        let moved = |i: usize| {
            let (low, high) = (p[0][i] + p[1][i] * s, p[2][i] + p[3][i] * s);
            s * (low + s2 * (high + s2 * p[4][i]))
        };
        PathPoint {
            distance: local,
            x: from.x + moved(0),
            y: from.y + moved(1),
            heading: piece.heading(from, s),
            curvature: from.curvature + s * piece.curvature,
        }
    }

    /// How far ahead a position lies as seen from a node.
    fn ahead_of(&self, node: usize, x: f64, y: f64) -> f64 {
        let n = &self.nodes[node];
        (x - n.point.x) * n.cos + (y - n.point.y) * n.sin
    }

    /// The foot, from a distance near it.
    fn seek(&self, x: f64, y: f64, from: f64) -> Sought {
        let last = self.nodes.len() - 1;
        let length = self.end() - self.start();
        let window = if self.closed { WINDOW.min(length / 2.0) } else { WINDOW };
        let (mut lap, local) = self.lap(from);
        if !self.closed && (local < self.start() || local >= self.end()) {
            let node = if local < self.start() { 0 } else { last };
            let ahead = self.ahead_of(node, x, y);
            if (node == 0) == (ahead < 0.0) {
                return Sought::At(self.nodes[node].point.distance + ahead);
            }
        }
        let local = local.clamp(self.start(), self.end());
        let mut segment = self.segment(local);
        let here = self.within(segment, local);
        let (f, slope) = ahead(&here, x, y);
        let forward = f >= 0.0;
        // Newton's step from here; most steps of a vehicle end near it.
        let guess = local - f / slope;
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
                let local = self.foot_between(segment, (low, high), guess, x, y);
                return Sought::Within(lap, self.within(segment, local));
            }
            let walked = lap * length + border - from;
            if walked.abs() >= window {
                return Sought::At(from + walked.clamp(-window, window));
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
                (true, n) if n == last => return Sought::At(border + ahead),
                (false, 0) => return Sought::At(border + ahead),
                (true, _) => segment += 1,
                (false, _) => segment -= 1,
            }
        }
    }

    /// The zero of f within a part of a segment at whose ends it has opposite signs: Newton's
    /// method, `f' = κ·e − 1`, with bisection where that leaves the bracket.
    fn foot_between(
        &self,
        segment: usize,
        (mut low, mut high): (f64, f64),
        guess: f64,
        x: f64,
        y: f64,
    ) -> f64 {
        let mut s = if guess >= low && guess <= high { guess } else { 0.5 * (low + high) };
        for _ in 0..60 {
            let point = self.within(segment, s);
            let (f, slope) = ahead(&point, x, y);
            if f > 0.0 {
                low = s;
            } else {
                high = s;
            }
            let newton = s - f / slope;
            let inside = newton >= low && newton <= high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            // Away from the centre of curvature a step leaves at most 1e-5 of the distance to the
            // zero, by which the slope of the quintic is not quite that of f.
            let near = if inside && slope < -0.5 { NEAR } else { 0.0 };
            if (next - s).abs() <= near.max(1e-12 * (1.0 + s.abs())) {
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
                // Not `hypot`: what it saves, overflow, is far beyond any path.
                away: {
                    let (dx, dy) = (a.x + s * cx - x, a.y + s * cy - y);
                    (dx * dx + dy * dy).sqrt()
                },
                distance: a.distance + s * (b.distance - a.distance),
                heading: a.heading + s * (b.heading - a.heading),
            }
        })
    }
}

/// Where the foot of a position is.
enum Sought {
    /// After so many laps, at a point within the lap.
    Within(f64, PathPoint),
    /// At a distance, which may be beyond the ends.
    At(f64),
}

impl PathPoint {
    /// The projection of a position whose foot this is.
    fn projection(self, x: f64, y: f64) -> Projection {
        let (sin, cos) = sin_cos(self.heading);
        Projection { foot: self, cross_track_error: (y - self.y) * cos - (x - self.x) * sin }
    }
}

struct ChordFoot {
    away: f64,
    distance: f64,
    heading: f64,
}

/// How far ahead a position lies as seen from a point of the path, f, and how that changes along the
/// path, f'.
#[inline]
fn ahead(point: &PathPoint, x: f64, y: f64) -> (f64, f64) {
    let (sin, cos) = sin_cos(point.heading);
    let (dx, dy) = (x - point.x, y - point.y);
    (dx * cos + dy * sin, point.curvature * (dy * cos - dx * sin) - 1.0)
}

impl Segment {
    fn new(a: &Node, b: &Node) -> Self {
        let length = b.point.distance - a.point.distance;
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
        let (ka, kb) = (a.point.curvature, b.point.curvature);
        let x = position(b.point.x - a.point.x, [a.cos, b.cos], [-ka * a.sin, -kb * b.sin]);
        let y = position(b.point.y - a.point.y, [a.sin, b.sin], [ka * a.cos, kb * b.cos]);
        // And of third degree for the heading.
        let turn = b.point.heading - a.point.heading;
        let heading =
            [length * ka, 3.0 * turn - length * (2.0 * ka + kb), -2.0 * turn + length * (ka + kb)];
        Self {
            inverse_length: 1.0 / length,
            position: std::array::from_fn(|i| [x[i], y[i]]),
            heading,
            curvature: kb - ka,
        }
    }

    #[inline]
    fn heading(&self, from: &PathPoint, s: f64) -> f64 {
        from.heading + s * (self.heading[0] + s * (self.heading[1] + s * self.heading[2]))
    }
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
