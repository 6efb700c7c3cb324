//! The speed profile as an optimisation problem.
//!
//! The square of the speed z = v² is a quadratic spline over the distance with the nodes of the grid as knots. Its unknowns
//! are the ordinates x of its control polygon, one in the middle of each interval and one at each free end. Then
//!
//! ```text
//! z at a node        = the control polygon there           between two neighbouring unknowns
//! a at a node        = ½·dz/ds, half the polygon's slope   of the same two; linear between nodes
//! q in an interval   = da/ds                               of three unknowns; constant; the jerk is q·√z
//! time               = Σ 2·h/(√zₖ + √zₖ₊₁)                 convex in x
//! ```
//!
//! and each limit is a condition c(x) > 0 on z and a of one node, or on z of a node and q of an interval beside it:
//!
//! ```text
//! speed, lateral acceleration, steering angle        1 − z/z_max
//! acceleration, deceleration                         1 − a/A,  1 + a/D
//! friction                                           1 − ((κ·z)² + a²)/(μ·g)²
//! steering rate, to either side                      1 ∓ √z·((L + K·z)·κ′ + 2·K·κ·a)/ω
//! jerk, to either side                               1 ∓ √z·q/j
//! ```
//!
//! A start from standstill with a limited jerk j has the first interval of its own, with z proportional to the distance to
//! the power of 4/3; it bounds z and states a = ⅔·z/h at the first node of the spline. An end at standstill mirrors it.
//! With a limited jerk the acceleration is 0 at an end that is not at standstill.

use crate::profile::grid::Grid;
use crate::profile::pointwise::{GRAVITY, largest_square};
use steerwright_formats::{ProfileLimits, ProfilePoint, SteeringLimits};

/// A linear combination of neighbouring unknowns.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Form {
    pub(super) at: [usize; 3],
    pub(super) weights: [f64; 3],
}

impl Form {
    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.weights[0] * x[self.at[0]]
            + self.weights[1] * x[self.at[1]]
            + self.weights[2] * x[self.at[2]]
    }

    /// Adds a multiple of another combination of the same or fewer unknowns.
    pub(super) fn plus(mut self, other: &Self, factor: f64) -> Self {
        for (at, weight) in other.at.into_iter().zip(other.weights) {
            if weight == 0.0 {
                continue;
            }
            let place = (0..3)
                .find(|k| self.weights[*k] != 0.0 && self.at[*k] == at)
                .or_else(|| (0..3).find(|k| self.weights[*k] == 0.0));
            // Three unknowns are the most that an interval and its neighbours have.
            if let Some(place) = place {
                self.at[place] = at;
                self.weights[place] += factor * weight;
            }
        }
        self
    }
}

/// A condition c > 0 on two combinations of unknowns, with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condition<'a> {
    pub(super) value: f64,
    pub(super) forms: [&'a Form; 2],
    pub(super) gradient: [f64; 2],
    /// Second derivatives of −c by each form, where c is concave. Those of other conditions are left out: the matrix of
    /// Newton's method must be positive definite.
    pub(super) curvature: [f64; 2],
}

/// A node of the spline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) z: Form,
    pub(super) a: Form,
    /// Largest z by all limits that depend on it alone, m²/s².
    largest: f64,
    curvature: f64,
    slopes: [f64; 2],
}

/// See the module.
#[derive(Debug)]
pub(super) struct Problem<'a> {
    grid: &'a Grid,
    limits: &'a ProfileLimits,
    /// The nodes of the grid that are nodes of the spline, first and last.
    span: [usize; 2],
    pub(super) nodes: Vec<Node>,
    /// The middle of each interval, where the control polygon, which lies above a spline that is concave, has to keep the
    /// limits.
    middles: Vec<Node>,
    /// q of each interval of the spline.
    bends: Vec<Form>,
    pub(super) unknowns: usize,
}

impl<'a> Problem<'a> {
    pub(super) fn new(grid: &'a Grid, limits: &'a ProfileLimits) -> Self {
        let at_rest = limits.end_speeds_mps.map(|speeds| speeds.map(|speed| speed == 0.0));
        let is_soft = limits.max_jerk_mps3.is_some();
        let span = match at_rest {
            Some([start, end]) if is_soft => {
                [usize::from(start), grid.intervals() - usize::from(end)]
            }
            _ => [0, grid.intervals()],
        };
        let polygon = Polygon::new(grid, limits, span);
        let nodes = if grid.is_closed { grid.intervals() } else { span[1] - span[0] + 1 };
        let nodes: Vec<Node> = (0..nodes)
            .map(|k| {
                let node = span[0] + k;
                let (z, a) = polygon.node(k);
                let place = grid.place(node);
                let mut largest = largest_square(&place, limits);
                if let Some(ends) = limits.end_speeds_mps {
                    for (end, speed) in [0, grid.intervals()].into_iter().zip(ends) {
                        if node == end && speed > 0.0 {
                            largest = largest.min(speed * speed);
                        }
                    }
                }
                if let Some(jerk) = limits.max_jerk_mps3 {
                    for (edge, interval) in [(span[0], 0), (span[1], grid.intervals() - 1)] {
                        let is_beside_rest = edge != 0 && edge != grid.intervals();
                        if node == edge && is_beside_rest && !grid.is_closed {
                            largest = largest.min(square_from_rest(jerk, grid.length(interval)));
                        }
                    }
                }
                Node { z, a, largest, curvature: place.curvature, slopes: place.slopes }
            })
            .collect();
        let bends = (0..span[1] - span[0])
            .map(|k| {
                let length = grid.length(span[0] + k);
                let next = if grid.is_closed { (k + 1) % nodes.len() } else { k + 1 };
                let bend = Form::default().plus(&nodes[k].a, -1.0 / length);
                bend.plus(&nodes[next].a, 1.0 / length)
            })
            .collect();
        let middles = (0..span[1] - span[0])
            .map(|k| {
                let interval = span[0] + k;
                let (z, _) = polygon.ordinate(k as isize);
                let next = if grid.is_closed { (k + 1) % nodes.len() } else { k + 1 };
                let a = Form::default().plus(&nodes[k].a, 0.5).plus(&nodes[next].a, 0.5);
                let place = grid.middle(interval);
                Node {
                    z,
                    a,
                    largest: largest_square(&place, limits),
                    curvature: place.curvature,
                    slopes: place.slopes,
                }
            })
            .collect();
        Self { grid, limits, span, nodes, middles, bends, unknowns: polygon.unknowns }
    }

    /// Whether the path is closed.
    pub(super) fn is_ring(&self) -> bool {
        self.grid.is_closed
    }

    /// The node at the end of the interval that begins at a node.
    pub(super) fn next(&self, node: usize) -> usize {
        (node + 1) % self.nodes.len()
    }

    /// The intervals of the spline: how long each is, m; between node k and the next.
    pub(super) fn lengths(&self) -> impl Iterator<Item = f64> + '_ {
        (self.span[0]..self.span[1]).map(|interval| self.grid.length(interval))
    }

    /// The lengths of the intervals beside a standstill with a limited jerk, and the node at their end.
    pub(super) fn rest_intervals(&self) -> Vec<(f64, usize)> {
        let mut all = Vec::new();
        if self.span[0] > 0 {
            all.push((self.grid.length(0), 0));
        }
        if self.span[1] < self.grid.intervals() {
            all.push((self.grid.length(self.span[1]), self.nodes.len() - 1));
        }
        all
    }

    /// The nodes at stated speeds above 0, which shall be reached: node, z.
    pub(super) fn stated_ends(&self) -> Vec<(usize, f64)> {
        let mut all = Vec::new();
        if let Some([start, end]) = self.limits.end_speeds_mps {
            if start > 0.0 {
                all.push((0, start * start));
            }
            if end > 0.0 {
                all.push((self.nodes.len() - 1, end * end));
            }
        }
        all
    }

    /// Visits every condition, always in the same order.
    pub(super) fn visit(&self, x: &[f64], mut visit: impl FnMut(Condition<'_>)) {
        let l = self.limits;
        let none = Form::default();
        for node in self.nodes.iter().chain(&self.middles) {
            let (z, a) = (node.z.value(x), node.a.value(x));
            let forms = [&node.z, &node.a];
            let mut of_node = |value: f64, gradient: [f64; 2], curvature: [f64; 2]| {
                visit(Condition { value, forms, gradient, curvature });
            };
            of_node(1.0 - z / node.largest, [-1.0 / node.largest, 0.0], [0.0; 2]);
            let (most, least) = (l.max_acceleration_mps2, l.max_deceleration_mps2);
            of_node(1.0 - a / most, [0.0, -1.0 / most], [0.0; 2]);
            of_node(1.0 + a / least, [0.0, 1.0 / least], [0.0; 2]);
            if let Some(friction) = l.friction {
                let square = (friction * GRAVITY).powi(2);
                let lateral = node.curvature * node.curvature / square;
                let value = 1.0 - lateral * z * z - a * a / square;
                let gradient = [-2.0 * lateral * z, -2.0 * a / square];
                of_node(value, gradient, [2.0 * lateral, 2.0 / square]);
            }
            // Without understeer the rate bounds z alone.
            if let Some(steering) = &l.steering
                && steering.understeer_gradient_rads2pm != 0.0
                && let Some(largest) = steering.max_rate_radps
            {
                let [before, after] = node.slopes;
                for slope in if before == after { &node.slopes[..1] } else { &node.slopes[..] } {
                    if *slope == 0.0 && node.curvature == 0.0 {
                        continue;
                    }
                    let (rate, gradient) = steering_rate(steering, node.curvature, *slope, z, a);
                    let gradient = gradient.map(|derivative| derivative / largest);
                    of_node(1.0 - rate / largest, gradient.map(|g| -g), [0.0; 2]);
                    of_node(1.0 + rate / largest, gradient, [0.0; 2]);
                }
            }
        }
        if let Some(largest) = l.max_jerk_mps3 {
            for (k, bend) in self.bends.iter().enumerate() {
                let q = bend.value(x);
                for node in [&self.nodes[k], &self.nodes[self.next(k)]] {
                    let root = node.z.value(x).max(0.0).sqrt();
                    let jerk = root * q / largest;
                    let gradient = [0.5 * q / (root * largest), root / largest];
                    let forms = [&node.z, bend];
                    let curvature = [0.0; 2];
                    let opposite = gradient.map(|g| -g);
                    visit(Condition { value: 1.0 - jerk, forms, gradient: opposite, curvature });
                    visit(Condition { value: 1.0 + jerk, forms, gradient, curvature });
                }
            }
        }
        for (i, value) in x.iter().enumerate() {
            let form = Form { at: [i; 3], weights: [1.0, 0.0, 0.0] };
            let forms = [&form, &none];
            let (gradient, curvature) = ([1.0, 0.0], [0.0; 2]);
            visit(Condition { value: *value, forms, gradient, curvature });
        }
    }

    /// The profile of the unknowns.
    pub(super) fn points(&self, x: &[f64]) -> Vec<ProfilePoint> {
        let count = self.grid.distances.len();
        let mut points = Vec::with_capacity(count);
        for (i, distance_m) in self.grid.distances.iter().enumerate() {
            if i < self.span[0] || i > self.span[1] {
                let rest = ProfilePoint {
                    distance_m: *distance_m,
                    speed_mps: 0.0,
                    acceleration_mps2: 0.0,
                };
                points.push(rest);
                continue;
            }
            let node = &self.nodes[(i - self.span[0]) % self.nodes.len()];
            points.push(ProfilePoint {
                distance_m: *distance_m,
                speed_mps: node.z.value(x).max(0.0).sqrt(),
                acceleration_mps2: node.a.value(x),
            });
        }
        points
    }
}

/// z at the end of an interval that begins at standstill, at constant jerk: v = ½·j·t², s = j·t³/6.
fn square_from_rest(jerk: f64, length: f64) -> f64 {
    let time = (6.0 * length / jerk).cbrt();
    (0.5 * jerk * time * time).powi(2)
}

/// dδ/dt = √z·((L + K·z)·κ′ + 2·K·κ·a), and its derivatives by z and a.
pub(super) fn steering_rate(
    steering: &SteeringLimits,
    curvature: f64,
    slope: f64,
    z: f64,
    a: f64,
) -> (f64, [f64; 2]) {
    let (l, k) = (steering.steering_per_curvature_radm, steering.understeer_gradient_rads2pm);
    // At standstill z is no unknown, and its derivative not used.
    let root = z.max(f64::MIN_POSITIVE).sqrt();
    let per_distance = (l + k * z) * slope + 2.0 * k * curvature * a;
    let by_z = 0.5 * per_distance / root + root * k * slope;
    (root * per_distance, [by_z, root * 2.0 * k * curvature])
}

/// The control polygon: which unknown, with which factor, each of its ordinates is, and where.
struct Polygon<'a> {
    grid: &'a Grid,
    span: [usize; 2],
    /// Factor of the nearest unknown that the ordinate at an end is; `None` where it is an unknown of its own, and on a
    /// closed path, which has no ends.
    tied: [Option<f64>; 2],
    unknowns: usize,
}

impl<'a> Polygon<'a> {
    fn new(grid: &'a Grid, limits: &ProfileLimits, span: [usize; 2]) -> Self {
        let intervals = span[1] - span[0];
        let mut tied = [None; 2];
        let mut unknowns = intervals;
        if let Some(speeds) = limits.end_speeds_mps {
            let beside = [(span[0], 0), (span[1] - 1, grid.intervals() - 1)];
            for (end, (inner, outer)) in beside.into_iter().enumerate() {
                tied[end] = match (limits.max_jerk_mps3, speeds[end] == 0.0) {
                    // ⅔·z/h of the interval beside the standstill is the slope of the polygon, (x − z)/h of its own.
                    (Some(_), true) => {
                        Some(1.0 / (1.0 + 2.0 / 3.0 * grid.length(inner) / grid.length(outer)))
                    }
                    (Some(_), false) => Some(1.0),
                    (None, true) => Some(0.0),
                    (None, false) => None,
                };
            }
            unknowns += tied.iter().filter(|tied| tied.is_none()).count();
        }
        Self { grid, span, tied, unknowns }
    }

    /// Ordinate and abscissa of the polygon in the middle of an interval of the spline; at −1 and beyond the last at the
    /// ends.
    fn ordinate(&self, interval: isize) -> (Form, f64) {
        let count = (self.span[1] - self.span[0]) as isize;
        let first = isize::from(self.tied[0].is_none() && !self.grid.is_closed);
        let single =
            |at: isize, weight: f64| Form { at: [at as usize; 3], weights: [weight, 0.0, 0.0] };
        let d = &self.grid.distances;
        if self.grid.is_closed {
            let lap = d[d.len() - 1] - d[0];
            let (local, shift) =
                if interval < 0 { (interval + count, -lap) } else { (interval, 0.0) };
            let k = local as usize;
            return (single(local, 1.0), 0.5 * (d[k] + d[k + 1]) + shift);
        }
        if interval < 0 {
            let form = self.tied[0].map_or(single(0, 1.0), |factor| single(0, factor));
            return (form, d[self.span[0]]);
        }
        if interval >= count {
            let last = count - 1 + first;
            let form = self.tied[1].map_or(single(last + 1, 1.0), |factor| single(last, factor));
            return (form, d[self.span[1]]);
        }
        let k = self.span[0] + interval as usize;
        (single(interval + first, 1.0), 0.5 * (d[k] + d[k + 1]))
    }

    /// z and a at a node of the spline.
    fn node(&self, node: usize) -> (Form, Form) {
        let (before, from) = self.ordinate(node as isize - 1);
        let (after, to) = self.ordinate(node as isize);
        let share = (self.grid.distances[self.span[0] + node] - from) / (to - from);
        let z = Form::default().plus(&before, 1.0 - share).plus(&after, share);
        let slope = 0.5 / (to - from);
        (z, Form::default().plus(&before, -slope).plus(&after, slope))
    }
}
