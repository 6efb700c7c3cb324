//! The geometry of a reference path: points in arc length, what lies between them, feet of positions.
//!
//! Between two points the position is the quintic with the positions, tangents and curvature vectors of
//! both (below 1e-5 m off where 5 m lie between points of a 10 m radius), the heading the cubic with the
//! headings and curvatures of both, the curvature linear. An open path goes on straight beyond its ends;
//! on a closed path distance and heading go on from lap to lap.
//!
//! The foot s of a position p solves `f(s) = (p − q(s))·t(s) = 0`, t the unit tangent. From a known
//! distance it is sought in the direction in which f points and the first zero is taken, at most
//! [`WINDOW`] away: so progress never jumps to another branch of a path that crosses itself, and a step
//! costs the same however long the path is.

mod profile;
mod projection;
mod segment;

pub use profile::SpeedReference;
pub use projection::{Projection, WINDOW};

use crate::Error;
use crate::angle::wrap_angle;
use crate::intervals::Intervals;
use segment::{Node, Segment, extend};
use std::f64::consts::TAU;
use steerwright_formats::PathPoint;

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
                ("the distance", p.distance_m),
                ("x", p.x_m),
                ("y", p.y_m),
                ("the heading", p.heading_rad),
                ("the curvature", p.curvature_per_m),
            ] {
                if !value.is_finite() {
                    return Err(Error::Point { index, name, value });
                }
            }
        }
        for i in 1..points.len() {
            let before = points[i - 1].heading_rad;
            points[i].heading_rad = before + wrap_angle(points[i].heading_rad - before);
        }
        let turn = if closed { close(&mut points) } else { 0.0 };
        for (i, pair) in points.windows(2).enumerate() {
            check_segment(i, &pair[0], &pair[1])?;
        }
        let distances: Vec<f64> = points.iter().map(|p| p.distance_m).collect();
        let intervals = Intervals::from_distances(&distances);
        let nodes: Vec<Node> = points
            .into_iter()
            .map(|point| {
                let (sin, cos) = point.heading_rad.sin_cos();
                Node { point, cos, sin }
            })
            .collect();
        let segments = nodes.windows(2).map(|pair| Segment::new(&pair[0], &pair[1])).collect();
        Ok(Self { nodes, segments, intervals, closed, turn })
    }

    /// Distance of the first point, m.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.nodes[0].point.distance_m
    }

    /// Distance of the last point, m; of a closed path, where the second lap begins.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.nodes[self.nodes.len() - 1].point.distance_m
    }

    /// Whether the path has no end.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The path at a distance, which may lie beyond its ends.
    #[must_use]
    pub fn point_at(&self, distance: f64) -> PathPoint {
        let (lap, local) = self.lap(distance);
        let mut point = if local < self.start() {
            extend(&self.nodes[0], local)
        } else if local >= self.end() {
            extend(&self.nodes[self.nodes.len() - 1], local)
        } else {
            self.within(self.segment(local), local)
        };
        point.distance_m = distance;
        point.heading_rad += lap * self.turn;
        point
    }

    /// Heading (rad) and curvature (1/m) of the path at a distance, which may lie beyond its ends.
    #[must_use]
    pub(crate) fn direction(&self, distance: f64) -> [f64; 2] {
        let (lap, local) = self.lap(distance);
        let [heading, curvature] = if local < self.start() {
            [self.nodes[0].point.heading_rad, 0.0]
        } else if local >= self.end() {
            [self.nodes[self.nodes.len() - 1].point.heading_rad, 0.0]
        } else {
            let segment = self.segment(local);
            self.segments[segment].direction(&self.nodes[segment].point, local)
        };
        [heading + lap * self.turn, curvature]
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
        self.segments[segment].point_at(&self.nodes[segment].point, local)
    }
}

/// Makes the last point meet the first; returns the heading gained in a lap.
fn close(points: &mut Vec<PathPoint>) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    let gap = (first.x_m - last.x_m).hypot(first.y_m - last.y_m);
    let rest = wrap_angle(first.heading_rad - last.heading_rad);
    let spacing = (last.distance_m - first.distance_m) / (points.len() - 1) as f64;
    let end = if gap > 0.01 * spacing {
        // The arc over the chord, for a turn of `rest` on the way.
        let half = 0.5 * rest;
        let arc = if half.abs() < 1e-6 { gap } else { gap * half / half.sin() };
        last.distance_m + arc
    } else {
        points.pop();
        last.distance_m
    };
    let turn = TAU * ((last.heading_rad + rest - first.heading_rad) / TAU).round();
    points.push(PathPoint { distance_m: end, heading_rad: first.heading_rad + turn, ..first });
    turn
}

fn check_segment(i: usize, a: &PathPoint, b: &PathPoint) -> Result<(), Error> {
    let arc = b.distance_m - a.distance_m;
    if arc <= 0.0 {
        return Err(Error::Distance { index: i + 1, distance: b.distance_m, before: a.distance_m });
    }
    let (dx, dy) = (b.x_m - a.x_m, b.y_m - a.y_m);
    let chord = dx.hypot(dy);
    if chord > 1.05 * arc + 0.02 {
        return Err(Error::ShorterThanChord { index: i + 1, chord, arc });
    }
    let heading = 0.5 * (a.heading_rad + b.heading_rad);
    // Points nearer than this may be out of order by measurement noise alone.
    if chord > 0.1 && dx * heading.cos() + dy * heading.sin() < 0.0 {
        return Err(Error::Heading { index: i, heading, chord: dy.atan2(dx) });
    }
    Ok(())
}
