//! Recorded positions that cannot be: repeated points and jumps.

use super::points::PointOptions;
use crate::Error;
use std::collections::BinaryHeap;

/// Points that are kept, and what was left out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cleaned {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) repeated: usize,
    /// Index of each outlier in the recording, and its distance from its neighbours.
    pub(crate) outliers: Vec<(usize, f64)>,
}

/// Leaves out points that are nearer than the least spacing to the one kept before, then single
/// points that lie off their neighbours.
///
/// A point's deviation is its distance from the chord of its neighbours, a curve's is κ·h²/2. It
/// is an outlier beyond both `largest_jump` and eight times the median deviation. The worst is
/// taken out first, since it makes its neighbours look bad.
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
    if kept.len() < super::points::LEAST_POINTS {
        return Err(Error::TooFewPoints { got: kept.len(), need: super::points::LEAST_POINTS });
    }
    let repeated = xs.len() - kept.len();
    let mut chain = Chain::new(kept.iter().map(|&i| (xs[i], ys[i])).collect());
    let mut sorted = chain.deviations.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = options.largest_jump.max(8.0 * sorted[sorted.len() / 2]);
    let (total, allowed) = (kept.len(), (kept.len() / 50).max(2));
    let mut outliers = Vec::new();
    while let Some((worst, size)) = chain.worst(limit) {
        outliers.push((kept[worst], size));
        if outliers.len() > allowed || chain.left <= super::points::LEAST_POINTS {
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
    refuse_jump(&kept, at, limit)?;
    Ok(Cleaned {
        x: kept.iter().map(|&i| xs[i]).collect(),
        y: kept.iter().map(|&i| ys[i]).collect(),
        repeated,
        outliers,
    })
}

/// Points that are left out one after the other, the worst first: in order of deviation by a heap, since
/// a recording may be long.
struct Chain {
    points: Vec<(f64, f64)>,
    /// Neighbours of each point among those that are left; none at the ends.
    before: Vec<Option<usize>>,
    after: Vec<Option<usize>>,
    removed: Vec<bool>,
    left: usize,
    deviations: Vec<f64>,
    /// Deviations as they were once, which order as their bits do: none is negative.
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
            heap: BinaryHeap::with_capacity(left),
            points,
        };
        (0..left).for_each(|j| chain.measure(j));
        chain
    }

    fn measure(&mut self, j: usize) {
        let at = |k: usize| self.points[k];
        // An end is held against the line of the two points next to it.
        let ray = |near: Option<usize>, on: &[Option<usize>]| {
            near.and_then(|near| Some(off_ray(at(j), at(near), at(on[near]?))))
        };
        let deviation = match (self.before[j], self.after[j]) {
            (Some(a), Some(b)) => Some(off_chord(at(j), at(a), at(b))),
            (None, next) => ray(next, &self.after),
            (previous, None) => ray(previous, &self.before),
        };
        self.deviations[j] = deviation.unwrap_or(0.0);
        self.heap.push((self.deviations[j].to_bits(), j));
    }

    /// The point that is off by most, and by more than a limit.
    fn worst(&mut self, limit: f64) -> Option<(usize, f64)> {
        while let Some(&(bits, j)) = self.heap.peek() {
            let size = f64::from_bits(bits);
            if self.removed[j] || size != self.deviations[j] {
                self.heap.pop();
                continue;
            }
            return (size > limit).then_some((j, size));
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
        // Two to either side, since an end looks at two.
        let changed =
            [before.and_then(|k| self.before[k]), before, after, after.and_then(|k| self.after[k])];
        changed.into_iter().flatten().for_each(|k| self.measure(k));
    }
}

/// A recording that goes on elsewhere has no bad point but a bad step: one that leads aside or
/// back by more than the limit, seen along the steps before and after it.
fn refuse_jump(kept: &[usize], at: impl Fn(usize) -> (f64, f64), limit: f64) -> Result<(), Error> {
    let step = |j: usize| {
        let ((ax, ay), (bx, by)) = (at(kept[j]), at(kept[j + 1]));
        (bx - ax, by - ay)
    };
    let unit = |(dx, dy): (f64, f64)| {
        let length = f64::hypot(dx, dy).max(f64::MIN_POSITIVE);
        (dx / length, dy / length)
    };
    for j in 1..kept.len().saturating_sub(2) {
        let ((ux, uy), (vx, vy)) = (unit(step(j - 1)), unit(step(j + 1)));
        let (tx, ty) = unit((ux + vx, uy + vy));
        let (dx, dy) = step(j);
        let jump_m = (dy * tx - dx * ty).hypot((dx * tx + dy * ty).min(0.0));
        if jump_m > limit {
            return Err(Error::Jump { after: kept[j] + 1, next: kept[j + 1] + 1, jump_m });
        }
    }
    Ok(())
}

/// Distance of `p` from the segment between `a` and `b`.
fn off_chord(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let along = ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length2.max(f64::MIN_POSITIVE);
    let t = along.clamp(0.0, 1.0);
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

/// Distance of an end point `p` from the ray that its two neighbours (nearest first) draw.
fn off_ray(p: (f64, f64), near: (f64, f64), next: (f64, f64)) -> f64 {
    let (dx, dy) = (near.0 - next.0, near.1 - next.1);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let (px, py) = (p.0 - near.0, p.1 - near.1);
    let along = (px * dx + py * dy) / length;
    // Up to three spacings ahead is no jump: the recording may drop rows or the speed change.
    let over = if along < 0.0 { -along } else { (along - 3.0 * length).max(0.0) };
    ((px * dy - py * dx) / length).hypot(over)
}
