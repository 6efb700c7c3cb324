//! A smooth curve through recorded positions, by a parameter that approaches its arc length.

use super::options::{Excess, PointOptions};
use super::outliers::Cleaned;
use super::spline::{Fitter, Spline, penalty};
use crate::Error;
use crate::paths::compose::GAUSS;
use steerwright_formats::PathPoint;

/// Rounds in which the points' parameters are found.
const ROUNDS: usize = 4;
/// Knots in one cut-off length.
const KNOTS: f64 = 8.0;
/// A mean offset of the points to one side that counts as no error of the path, m, and in standard errors.
const OFFSET: f64 = 0.1;
const OFFSET_ERRORS: f64 = 5.0;

/// A smooth curve by a parameter, from `from` to `to`.
pub(crate) struct Curve {
    x: Spline,
    y: Spline,
    from: f64,
    to: f64,
    /// Steps of quadrature and search.
    step: f64,
    /// Parameters of the points it was made from.
    parameters: Vec<f64>,
    /// A closed curve runs over its ends; those points are copies.
    copies: usize,
    closed: bool,
}

impl Curve {
    pub(crate) fn fit(
        cleaned: &Cleaned,
        smoothing: f64,
        options: &PointOptions,
    ) -> Result<Self, Error> {
        let (x, y, copies) = if options.closed {
            wrapped(cleaned)
        } else {
            (cleaned.x.clone(), cleaned.y.clone(), 0)
        };
        let mut parameters = vec![0.0];
        for i in 1..x.len() {
            parameters.push(parameters[i - 1] + (x[i] - x[i - 1]).hypot(y[i] - y[i - 1]));
        }
        // The cleaning leaves enough points.
        let too_few = || Error::Option {
            option: "distance between recorded points",
            value: ((x[1] - x[0]).hypot(y[1] - y[0]) * 1e3).round() / 1e3,
            unit: " m",
            must: "short compared with the bends of the road, some metres",
        };
        let mut curve: Option<Self> = None;
        for _ in 0..ROUNDS {
            if let Some(curve) = &curve {
                parameters = curve.feet(&x, &y);
            }
            let (from, to) = parameters
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &t| (a.min(t), b.max(t)));
            let length = to - from;
            let knots = (length * KNOTS / smoothing).ceil().max(3.0) as usize;
            let mu = penalty(smoothing, parameters.len() as f64 / length);
            let step = length / knots as f64;
            let fitter = Fitter::new(&parameters, from, step, knots, mu).ok_or_else(too_few)?;
            curve = Some(Self {
                x: fitter.fit(&x),
                y: fitter.fit(&y),
                from,
                to,
                step: step.min(smoothing / KNOTS),
                parameters: parameters.clone(),
                copies,
                closed: options.closed,
            });
        }
        curve.ok_or_else(too_few)
    }

    fn speed(&self, t: f64) -> f64 {
        self.x.point_at(t)[1].hypot(self.y.point_at(t)[1])
    }

    /// Arc length from `a` to `b`, which lie within a step of each other.
    fn arc(&self, a: f64, b: f64) -> f64 {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        GAUSS.iter().map(|(node, weight)| weight * half * self.speed(middle + half * node)).sum()
    }

    /// Arc length at the foot of each point on the curve, by Newton steps from its parameter.
    fn feet(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        let intervals = ((self.to - self.from) / self.step).ceil().max(1.0) as usize;
        let step = (self.to - self.from) / intervals as f64;
        let mut table = vec![0.0];
        for i in 0..intervals {
            let a = self.from + step * i as f64;
            table.push(table[i] + self.arc(a, a + step));
        }
        let feet = self.parameters.iter().zip(x.iter().zip(y)).map(|(&t, (&x, &y))| {
            let t = self.foot(t, x, y);
            let i = (((t - self.from) / step) as usize).min(intervals - 1);
            table[i] + self.arc(self.from + step * i as f64, t)
        });
        feet.collect()
    }

    fn foot(&self, mut t: f64, x: f64, y: f64) -> f64 {
        let start = t;
        for _ in 0..3 {
            let ([fx, dx, _], [fy, dy, _]) = (self.x.point_at(t), self.y.point_at(t));
            t += ((x - fx) * dx + (y - fy) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
            // Neither beyond the ends of the curve nor to another part of it.
            t = t.clamp(start - 2.0 * self.step, start + 2.0 * self.step);
            t = t.clamp(self.from, self.to);
        }
        t
    }

    /// Parameters between which the path lies: for a closed curve one turn.
    fn range(&self) -> (f64, f64) {
        let last = self.parameters.len() - 1;
        if self.closed {
            (self.parameters[self.copies], self.parameters[last - self.copies])
        } else {
            (self.from, self.to)
        }
    }

    /// Points at equal arc length.
    pub(crate) fn points(&self, spacing: f64) -> Vec<PathPoint> {
        let (from, to) = self.range();
        let fine = ((to - from) / self.step.min(spacing)).ceil().max(1.0) as usize;
        let step = (to - from) / fine as f64;
        let lengths: Vec<f64> = (0..fine)
            .map(|i| self.arc(from + step * i as f64, from + step * (i + 1) as f64))
            .collect();
        let total: f64 = lengths.iter().sum();
        let pieces = (total / spacing).round().max(1.0) as usize;
        let mut points: Vec<PathPoint> = Vec::with_capacity(pieces + 1);
        let (mut i, mut before) = (0, 0.0);
        for k in 0..=pieces {
            let s = total * k as f64 / pieces as f64;
            while i + 1 < fine && before + lengths[i] < s {
                before += lengths[i];
                i += 1;
            }
            let a = from + step * i as f64;
            let mut t = a + step * (s - before) / lengths[i];
            for _ in 0..3 {
                t += (s - before - self.arc(a, t)) / self.speed(t);
            }
            points.push(self.point(t, s, points.last()));
        }
        if self.closed {
            let first = points[0];
            if let Some(last) = points.last_mut() {
                (last.x_m, last.y_m) = (first.x_m, first.y_m);
                last.curvature_per_m = first.curvature_per_m;
            }
        }
        points
    }

    fn point(&self, t: f64, distance: f64, before: Option<&PathPoint>) -> PathPoint {
        let ([x, dx, ddx], [y, dy, ddy]) = (self.x.point_at(t), self.y.point_at(t));
        let heading = dy.atan2(dx);
        PathPoint {
            distance_m: distance,
            x_m: x,
            y_m: y,
            heading_rad: before.map_or(heading, |b| {
                b.heading_rad + steerwright_models::wrap_angle(heading - b.heading_rad)
            }),
            curvature_per_m: (dx * ddy - dy * ddx) / dx.hypot(dy).powi(3),
        }
    }

    /// The distances of the points from the curve.
    pub(crate) fn deviation(
        &self,
        cleaned: &Cleaned,
        smoothing: f64,
        limit: Option<f64>,
    ) -> Deviation {
        // Parameter and offset to the left of each point.
        let mut offsets = Vec::with_capacity(cleaned.x.len());
        let (mut sum, mut furthest, mut largest_m) = (0.0, 0, 0.0);
        for (i, (&x, &y)) in cleaned.x.iter().zip(&cleaned.y).enumerate() {
            let t = self.foot(self.parameters[i + self.copies], x, y);
            let ([fx, dx, _], [fy, dy, _]) = (self.x.point_at(t), self.y.point_at(t));
            let (ox, oy) = (x - fx, y - fy);
            let distance = ox.hypot(oy);
            sum += distance * distance;
            if distance > largest_m {
                (furthest, largest_m) = (i, distance);
            }
            offsets.push((t, (dx * oy - dy * ox) / dx.hypot(dy).max(f64::MIN_POSITIVE)));
        }
        let at = |i: usize| [cleaned.x[i], cleaned.y[i]];
        let of_points = limit.filter(|limit| largest_m > *limit).map(|limit_m| Excess {
            deviation_m: largest_m,
            limit_m,
            is_mean: false,
            at_m: at(furthest),
        });
        let of_means = || {
            worst_mean(&offsets, 0.25 * smoothing, cleaned.noise).map(
                |(i, deviation_m, limit_m)| Excess {
                    deviation_m,
                    limit_m,
                    is_mean: true,
                    at_m: at(i),
                },
            )
        };
        Deviation {
            rms_m: (sum / cleaned.x.len() as f64).sqrt(),
            largest_m,
            furthest_m: at(furthest),
            excess: of_points.or_else(of_means),
        }
    }
}

pub(crate) struct Deviation {
    pub(crate) rms_m: f64,
    pub(crate) largest_m: f64,
    pub(crate) furthest_m: [f64; 2],
    pub(crate) excess: Option<Excess>,
}

/// The mean offset over a window that exceeds the offset explained by noise by most: the point in its middle,
/// the mean and the limit.
fn worst_mean(offsets: &[(f64, f64)], window: f64, noise: f64) -> Option<(usize, f64, f64)> {
    let mut sums = vec![0.0];
    sums.extend(offsets.iter().scan(0.0, |sum, (_, offset)| {
        *sum += offset;
        Some(*sum)
    }));
    let (mut from, mut to) = (0, 0);
    let mut worst = None;
    let mut ratio = 1.0;
    for (i, (t, _)) in offsets.iter().enumerate() {
        // Feet may stand still, so each end moves on its own.
        while from < i && offsets[from].0 < t - 0.5 * window {
            from += 1;
        }
        to = to.max(i + 1);
        while to < offsets.len() && offsets[to].0 <= t + 0.5 * window {
            to += 1;
        }
        let count = (to - from) as f64;
        let mean = ((sums[to] - sums[from]) / count).abs();
        let limit = OFFSET.max(OFFSET_ERRORS * noise / count.sqrt());
        if mean / limit > ratio {
            ratio = mean / limit;
            worst = Some((i, mean, limit));
        }
    }
    worst
}

/// The points of a closed path with half of them again before and after, and the first again.
fn wrapped(cleaned: &Cleaned) -> (Vec<f64>, Vec<f64>, usize) {
    let n = cleaned.x.len();
    let copies = n / 2;
    let wrap = |v: &[f64]| (0..=n + 2 * copies).map(|i| v[(i + n - copies) % n]).collect();
    (wrap(&cleaned.x), wrap(&cleaned.y), copies)
}
