//! The foot of a position on a path.

use super::PathGeometry;
use crate::angle::wrap_angle;
use crate::trigonometry::{sin_cos, sin_cos_small};
use std::f64::consts::FRAC_PI_2;
use steerwright_formats::PathPoint;

/// How far from the last progress the foot is sought, m.
pub const WINDOW: f64 = 50.0;

/// A Newton step is the last where it is at most this long and leaves at most [`REST`], m.
const NEAR: f64 = 1e-4;
/// What the last Newton step may leave, by the second derivative of f, m.
const REST: f64 = 1e-13;

/// Branches whose distances from the vehicle differ by less than this are equally near, m.
const SAME_PLACE: f64 = 1e-3;

/// The foot of a position on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// The foot; its distance goes on from lap to lap.
    pub foot: PathPoint,
    /// Cross-track error, m, positive to the left of the path.
    pub cross_track_error: f64,
}

impl PathGeometry {
    /// The foot of a position, sought from a distance known to be near it.
    #[must_use]
    pub fn project(&self, x: f64, y: f64, from: f64) -> Projection {
        match self.seek(x, y, from) {
            // The end belongs to what is beyond it.
            Sought::Within(lap, seen) if seen.point.distance_m < self.end() => {
                let length = self.end() - self.start();
                let foot = PathPoint {
                    distance_m: seen.point.distance_m + lap * length,
                    heading_rad: seen.point.heading_rad + lap * self.turn,
                    ..seen.point
                };
                Projection { foot, cross_track_error: seen.aside }
            }
            Sought::Within(lap, seen) => {
                let distance = seen.point.distance_m + lap * (self.end() - self.start());
                Projection::from_foot(self.point_at(distance), x, y)
            }
            Sought::At(distance) => Projection::from_foot(self.point_at(distance), x, y),
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

    /// How far ahead a position lies as seen from a node.
    fn ahead_of(&self, node: usize, x: f64, y: f64) -> f64 {
        let n = &self.nodes[node];
        (x - n.point.x_m) * n.cos + (y - n.point.y_m) * n.sin
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
                return Sought::At(self.nodes[node].point.distance_m + ahead);
            }
        }
        let local = local.clamp(self.start(), self.end());
        let mut segment = self.segment(local);
        let here = self.seen(segment, local, x, y);
        let forward = here.ahead >= 0.0;
        // Newton's step from here; most steps of a vehicle end near it.
        let guess = local - here.ahead / here.slope;
        let (mut low, mut high) = (local, local);
        loop {
            let node = if forward { segment + 1 } else { segment };
            let border = self.nodes[node].point.distance_m;
            let ahead = self.ahead_of(node, x, y);
            *(if forward { &mut high } else { &mut low }) = border;
            if forward == (ahead <= 0.0) || ahead == 0.0 {
                return Sought::Within(lap, self.foot_between(segment, (low, high), guess, x, y));
            }
            let walked = lap * length + border - from;
            if walked.abs() >= window {
                return Sought::At(from + walked.clamp(-window, window));
            }
            *(if forward { &mut low } else { &mut high }) = border;
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
    /// method, with bisection where that leaves the bracket.
    fn foot_between(
        &self,
        segment: usize,
        (mut low, mut high): (f64, f64),
        guess: f64,
        x: f64,
        y: f64,
    ) -> Seen {
        let mut s = if guess >= low && guess <= high { guess } else { 0.5 * (low + high) };
        let mut seen = self.seen(segment, s, x, y);
        for _ in 0..60 {
            if seen.ahead > 0.0 {
                low = s;
            } else {
                high = s;
            }
            let newton = s - seen.ahead / seen.slope;
            let inside = newton >= low && newton <= high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            let step = (next - s).abs();
            let near = inside
                && step <= NEAR
                && seen.slope < -0.5
                && 0.5 * (seen.bend * step * step).abs() <= REST * -seen.slope;
            if near || step <= 1e-12 * (1.0 + s.abs()) {
                return seen.moved(self.within(segment, next), x, y);
            }
            s = next;
            seen = self.seen(segment, s, x, y);
        }
        seen
    }

    /// A position as seen from a point within a segment.
    #[inline]
    fn seen(&self, segment: usize, local: f64, x: f64, y: f64) -> Seen {
        let (node, piece) = (&self.nodes[segment], &self.segments[segment]);
        let point = piece.point_at(&node.point, local);
        let ([vx, vy], turn, curving) =
            piece.derivatives((local - node.point.distance_m) * piece.inverse_length);
        let ([s], [c]) = sin_cos_small(&[point.heading_rad - node.point.heading_rad]);
        let (sin, cos) = (node.sin * c + node.cos * s, node.cos * c - node.sin * s);
        let (dx, dy) = (x - point.x_m, y - point.y_m);
        let (ahead, aside) = (dx * cos + dy * sin, dy * cos - dx * sin);
        let slope = turn * aside - (vx * cos + vy * sin);
        Seen { point, sin, cos, ahead, aside, slope, bend: curving * aside - turn * turn * ahead }
    }

    /// The nearest point of each chord.
    fn chords(&self, x: f64, y: f64) -> impl Iterator<Item = ChordFoot> {
        self.nodes.windows(2).map(move |pair| {
            let (a, b) = (&pair[0].point, &pair[1].point);
            let (cx, cy) = (b.x_m - a.x_m, b.y_m - a.y_m);
            let square = cx * cx + cy * cy;
            let s = if square > 0.0 {
                (((x - a.x_m) * cx + (y - a.y_m) * cy) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            ChordFoot {
                // Not `hypot`: what it saves, overflow, is far beyond any path.
                away: {
                    let (dx, dy) = (a.x_m + s * cx - x, a.y_m + s * cy - y);
                    (dx * dx + dy * dy).sqrt()
                },
                distance: a.distance_m + s * (b.distance_m - a.distance_m),
                heading: a.heading_rad + s * (b.heading_rad - a.heading_rad),
            }
        })
    }
}

/// Where the foot of a position is.
enum Sought {
    /// After so many laps, at a point within the lap.
    Within(f64, Seen),
    /// At a distance, which may be beyond the ends.
    At(f64),
}

impl Projection {
    /// The projection of a position with this foot.
    fn from_foot(foot: PathPoint, x: f64, y: f64) -> Self {
        let (sin, cos) = sin_cos(foot.heading_rad);
        Self { foot, cross_track_error: (y - foot.y_m) * cos - (x - foot.x_m) * sin }
    }
}

/// A position as seen from a point of the path.
struct Seen {
    point: PathPoint,
    sin: f64,
    cos: f64,
    /// How far ahead it lies, f, m, and aside, m, positive to the left.
    ahead: f64,
    aside: f64,
    /// f', exactly, and f'', but for what the quintic's tangent is off the heading, 1/m.
    slope: f64,
    bend: f64,
}

impl Seen {
    /// The same from a point at most [`NEAR`] away, without its derivatives.
    fn moved(self, point: PathPoint, x: f64, y: f64) -> Self {
        // Of the series of sine and cosine, what is beyond is below 1e-16.
        let turned = point.heading_rad - self.point.heading_rad;
        let half = 0.5 * turned * turned;
        let sin = self.sin + turned * self.cos - half * self.sin;
        let cos = self.cos - turned * self.sin - half * self.cos;
        let (dx, dy) = (x - point.x_m, y - point.y_m);
        Self { point, sin, cos, ahead: 0.0, aside: dy * cos - dx * sin, ..self }
    }
}

struct ChordFoot {
    away: f64,
    distance: f64,
    heading: f64,
}
