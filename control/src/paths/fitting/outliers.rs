//! Recorded positions that are left out: repeated points and jumps.
//!
//! A point is compared with the cubic through its four neighbours, which follows a bend, and the distance that a
//! bend between the directions before and after it may add is allowed.

use super::options::PointOptions;
use crate::Error;
use std::collections::BinaryHeap;

/// Fewest distinct points that make a path.
pub(crate) const LEAST_POINTS: usize = 4;
/// Squares of a point's weight and of its four neighbours', at equal distances: 1 + (1 + 16 + 16 + 1)/36.
const CUBIC_SQUARES: f64 = 70.0 / 36.0;
/// Median distance from the neighbours' cubic over the standard deviation of the noise in each direction:
/// that of a normal distribution to one side, 0.6745, times the root of [`CUBIC_SQUARES`]. Along the road
/// the point determines its place on the cubic.
const MEDIAN_OF_NOISE: f64 = 0.940_6;
/// Largest difference of the directions before and after a point on a road, rad.
const LARGEST_TURN: f64 = 2.0;

/// The points kept and those left out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cleaned {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) repeated: usize,
    /// Index of each outlier in the recording, and its distance from its neighbours.
    pub(crate) outliers: Vec<(usize, f64)>,
    /// Standard deviation of the points' noise in each direction, m.
    pub(crate) noise: f64,
}

/// Leaves out repeated points, then single points that lie off their neighbours.
///
/// A point is an outlier where its deviation (see [`Chain::deviation`]) is beyond both `largest_jump` and
/// eight times the median distance from the neighbours' cubic, which is that of noise. The worst is taken
/// out first, since it increases the deviation of its neighbours.
pub(crate) fn clean(xs: &[f64], ys: &[f64], options: &PointOptions) -> Result<Cleaned, Error> {
    let mut kept: Vec<usize> = Vec::with_capacity(xs.len());
    for i in 0..xs.len() {
        let far = kept
            .last()
            .is_none_or(|&k| (xs[i] - xs[k]).hypot(ys[i] - ys[k]) >= options.minimum_spacing);
        if far {
            kept.push(i);
        }
    }
    if kept.len() < LEAST_POINTS {
        return Err(Error::TooFewPoints { got: kept.len(), need: LEAST_POINTS });
    }
    let repeated = xs.len() - kept.len();
    let mut chain = Chain::new(kept.iter().map(|&i| (xs[i], ys[i])).collect());
    let mut sorted = chain.residuals.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let limit = options.largest_jump.max(8.0 * median);
    let (total, allowed) = (kept.len(), (kept.len() / 50).max(2));
    let mut outliers = Vec::new();
    while let Some((worst, size)) = chain.worst(limit) {
        outliers.push((kept[worst], size));
        if outliers.len() > allowed || chain.left <= LEAST_POINTS {
            let (first, jump_m) =
                outliers.iter().copied().min_by_key(|(i, _)| *i).unwrap_or((0, 0.0));
            return Err(Error::Jumps {
                dropped: outliers.len(),
                total,
                first: first + 1,
                jump_m,
                allowed,
            });
        }
        chain.remove(worst);
    }
    let kept: Vec<usize> =
        kept.iter().enumerate().filter(|(j, _)| !chain.removed[*j]).map(|(_, &i)| i).collect();
    let at = |i: usize| (xs[i], ys[i]);
    outliers.sort_by_key(|(i, _)| *i);
    reject_jump(&kept, at, limit)?;
    Ok(Cleaned {
        x: kept.iter().map(|&i| xs[i]).collect(),
        y: kept.iter().map(|&i| ys[i]).collect(),
        repeated,
        outliers,
        noise: median / MEDIAN_OF_NOISE,
    })
}

/// Points that are removed one after the other, the worst first, in a heap by deviation.
struct Chain {
    points: Vec<(f64, f64)>,
    /// Neighbours of each point among those that are left; none at the ends.
    before: Vec<Option<usize>>,
    after: Vec<Option<usize>>,
    removed: Vec<bool>,
    left: usize,
    deviations: Vec<f64>,
    /// Distances from the neighbours' cubic, whatever the bend.
    residuals: Vec<f64>,
    /// Deviations, some of them outdated, as bits: numbers that are not negative have the order of their bits.
    heap: BinaryHeap<(u64, usize)>,
}

impl Chain {
    fn new(points: Vec<(f64, f64)>) -> Self {
        let left = points.len();
        let mut chain = Self {
            before: (0..left).map(|j| j.checked_sub(1)).collect(),
            after: (0..left).map(|j| Some(j + 1).filter(|k| *k < left)).collect(),
            removed: vec![false; left],
            left,
            deviations: vec![0.0; left],
            residuals: vec![0.0; left],
            heap: BinaryHeap::with_capacity(left),
            points,
        };
        (0..left).for_each(|j| chain.measure(j));
        chain
    }

    fn measure(&mut self, j: usize) {
        (self.residuals[j], self.deviations[j]) = self.deviation(j);
        self.heap.push((self.deviations[j].to_bits(), j));
    }

    /// The distance of a point from the curve through its neighbours, and the part of it that no bend explains.
    ///
    /// Between two points the road lies in the triangle of their chord and the directions before and
    /// after it; the cubic may be off by half its height. An end is compared with the line of the two points
    /// next to it, from which it may bend as they do.
    fn deviation(&self, j: usize) -> (f64, f64) {
        let at = |k: usize| self.points[k];
        let second = |near: Option<usize>, on: &[Option<usize>]| near.and_then(|k| on[k]);
        let (before, after) = (self.before[j], self.after[j]);
        let (earlier, later) = (second(before, &self.before), second(after, &self.after));
        let (Some(a), Some(b)) = (before, after) else {
            let (near, next, on) = if before.is_none() {
                (after, later, &self.after)
            } else {
                (before, earlier, &self.before)
            };
            let (Some(near), Some(next)) = (near, next) else { return (0.0, 0.0) };
            let off = off_ray(at(j), at(near), at(next));
            let bend = on[next].map_or(0.0, |third| {
                let ((ax, ay), (bx, by), (cx, cy)) = (at(near), at(next), at(third));
                (ax - 2.0 * bx + cx).hypot(ay - 2.0 * by + cy)
            });
            return (0.0, (off - 1.5 * bend).max(0.0));
        };
        let direction =
            |from: usize, to: usize| (at(to).1 - at(from).1).atan2(at(to).0 - at(from).0);
        let arriving = match earlier {
            Some(k) => direction(k, a),
            None => direction(a, b),
        };
        let leaving = match later {
            Some(k) => direction(b, k),
            None => direction(a, b),
        };
        let turn = steerwright_models::wrap_angle(leaving - arriving).abs().min(LARGEST_TURN);
        let allowed = 0.25 * distance(at(a), at(b)) * (0.5 * turn).tan();
        let residual = self.residual(j, [earlier, Some(a), Some(b), later]);
        (residual, (residual - allowed).max(0.0))
    }

    /// Distance of a point from the polynomial through its neighbours, as at equal distances.
    fn residual(&self, j: usize, near: [Option<usize>; 4]) -> f64 {
        let at = |k: usize| self.points[k];
        let [_, Some(a), Some(b), _] = near else { return 0.0 };
        let chord = distance(at(a), at(b));
        let (from_a, to_b) = (distance(at(a), at(j)), distance(at(j), at(b)));
        if chord <= 1e-9 * (from_a + to_b) {
            return from_a;
        }
        let place = chord * from_a / (from_a + to_b);
        let earlier = near[0].map(|k| (-distance(at(k), at(a)), at(k)));
        let later = near[3].map(|k| (chord + distance(at(b), at(k)), at(k)));
        let nodes: Vec<(f64, (f64, f64))> =
            earlier.into_iter().chain([(0.0, at(a)), (chord, at(b))]).chain(later).collect();
        let (mut x, mut y, mut squares) = (at(j).0, at(j).1, 1.0);
        for (i, (s, point)) in nodes.iter().enumerate() {
            let others = nodes.iter().enumerate().filter(|(k, _)| *k != i);
            let weight: f64 = others.map(|(_, (other, _))| (place - other) / (s - other)).product();
            (x, y) = (x - weight * point.0, y - weight * point.1);
            squares += weight * weight;
        }
        x.hypot(y) * (CUBIC_SQUARES / squares.max(CUBIC_SQUARES)).sqrt()
    }

    /// The point that is off by most, and by more than a limit.
    fn worst(&mut self, limit: f64) -> Option<(usize, f64)> {
        while let Some(&(bits, j)) = self.heap.peek() {
            let size = f64::from_bits(bits);
            if self.removed[j] || size != self.deviations[j] {
                self.heap.pop();
                continue;
            }
            return if size > limit { Some((j, size)) } else { None };
        }
        None
    }

    fn remove(&mut self, j: usize) {
        let (before, after) = (self.before[j], self.after[j]);
        self.removed[j] = true;
        self.left -= 1;
        if let Some(before) = before {
            self.after[before] = after;
        }
        if let Some(after) = after {
            self.before[after] = before;
        }
        // Two to either side, since an end depends on two.
        let changed =
            [before.and_then(|k| self.before[k]), before, after, after.and_then(|k| self.after[k])];
        changed.into_iter().flatten().for_each(|k| self.measure(k));
    }
}

/// A recording that continues at another place has no outlier but a jump: a step that leads aside or back, along
/// the steps before and after it, by more than the limit and by more than a bend as sharp as those around it.
fn reject_jump(kept: &[usize], at: impl Fn(usize) -> (f64, f64), limit: f64) -> Result<(), Error> {
    let step = |j: usize| {
        let ((ax, ay), (bx, by)) = (at(kept[j]), at(kept[j + 1]));
        (bx - ax, by - ay)
    };
    let turn = |j: usize, k: usize| {
        let ((ax, ay), (bx, by)) = (step(j), step(k));
        (ax * by - ay * bx).atan2(ax * bx + ay * by).abs().min(0.5 * LARGEST_TURN)
    };
    let unit = |(dx, dy): (f64, f64)| {
        let length = f64::hypot(dx, dy).max(f64::MIN_POSITIVE);
        (dx / length, dy / length)
    };
    let steps = kept.len().saturating_sub(1);
    for j in 1..steps.saturating_sub(1) {
        let ((ux, uy), (vx, vy)) = (unit(step(j - 1)), unit(step(j + 1)));
        let (tx, ty) = unit((ux + vx, uy + vy));
        let (dx, dy) = step(j);
        let (aside, back) = (dy * tx - dx * ty, (dx * tx + dy * ty).min(0.0));
        let earlier = j.checked_sub(2).map_or(0.0, |k| turn(k, j - 1));
        let later = if j + 2 < steps { turn(j + 1, j + 2) } else { 0.0 };
        let bend = 0.5 * (turn(j - 1, j + 1) + earlier + later);
        let jump_m = (aside.abs() - dx.hypot(dy) * bend).max(0.0).hypot(back);
        if jump_m > limit {
            return Err(Error::Jump { after: kept[j] + 1, next: kept[j + 1] + 1, jump_m });
        }
    }
    Ok(())
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Distance of an end point `p` from the ray that its two neighbours (nearest first) draw.
fn off_ray(p: (f64, f64), near: (f64, f64), next: (f64, f64)) -> f64 {
    let (dx, dy) = (near.0 - next.0, near.1 - next.1);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let (px, py) = (p.0 - near.0, p.1 - near.1);
    let along = (px * dx + py * dy) / length;
    // Up to three spacings ahead is no jump: rows may be missing, or the speed may change.
    let over = if along < 0.0 { -along } else { (along - 3.0 * length).max(0.0) };
    ((px * dy - py * dx) / length).hypot(over)
}
