//! Recorded positions that cannot be: repeated points and jumps.

use super::points::PointOptions;
use crate::Error;

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
    let total = kept.len();
    let at = |i: usize| (xs[i], ys[i]);
    let deviation = |kept: &[usize], j: usize| match (j, kept.len() - 1 - j) {
        (0, _) => off_ray(at(kept[0]), at(kept[1]), at(kept[2])),
        (_, 0) => off_ray(at(kept[j]), at(kept[j - 1]), at(kept[j - 2])),
        _ => off_chord(at(kept[j]), at(kept[j - 1]), at(kept[j + 1])),
    };
    let mut deviations: Vec<f64> = (0..kept.len()).map(|j| deviation(&kept, j)).collect();
    let mut sorted = deviations.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = options.largest_jump.max(8.0 * sorted[sorted.len() / 2]);
    let allowed = (total / 50).max(2);
    let mut outliers = Vec::new();
    let worst_of = |deviations: &[f64]| {
        let all = deviations.iter().copied().enumerate();
        all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, size)| *size > limit)
    };
    while let Some((worst, size)) = worst_of(&deviations) {
        outliers.push((kept[worst], size));
        if outliers.len() > allowed || kept.len() <= super::points::LEAST_POINTS {
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
        kept.remove(worst);
        deviations.remove(worst);
        let near = worst.saturating_sub(2)..(worst + 2).min(kept.len());
        for (j, slot) in deviations.iter_mut().enumerate().take(near.end).skip(near.start) {
            *slot = deviation(&kept, j);
        }
    }
    outliers.sort_by_key(|(i, _)| *i);
    refuse_jump(&kept, at, limit)?;
    Ok(Cleaned {
        x: kept.iter().map(|&i| xs[i]).collect(),
        y: kept.iter().map(|&i| ys[i]).collect(),
        repeated,
        outliers,
    })
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
