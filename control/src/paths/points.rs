//! Paths from recorded points.
//!
//! Repeated points and outliers are left out, a penalised spline ([`super::spline`]) is laid
//! through x and y, and heading and curvature are read from its derivatives,
//! ψ = atan2(y′, x′), κ = (x′·y″ − y′·x″)/(x′² + y′²)^{3/2}. The spline's parameter is found by
//! iteration: at first the distance from point to point, which noise lengthens, then each point's
//! foot on the curve, measured in the curve's own arc length. Lengths in m, angles in rad.
//!
//! **How much is smoothed.** The length asked for, unless it takes the path off the points: where their
//! mean offset to one side, over a quarter of that length, is more than 0.1 m and than five standard errors
//! of their noise, or a point is further off than is allowed, the length is shortened. Where the curvature
//! is too large, it is lengthened instead.

use super::compose::{GAUSS, document};
use super::fixes::FixOptions;
use super::outliers::{Cleaned, clean};
use super::spline::{Fitter, Spline, penalty};
use crate::Error;
use formats::{Document, Path, PathPoint, Provenance};

/// Fewest distinct points that make a path.
pub(crate) const LEAST_POINTS: usize = 4;
/// Most points of a path.
const MOST_POINTS: f64 = 1e6;
/// Rounds in which the points' parameters are found.
const ROUNDS: usize = 4;
/// Longest smoothing tried for the sake of the curvature, m.
const LONGEST_SMOOTHING: f64 = 200.0;
/// Shortest smoothing tried for the sake of the points, m.
const SHORTEST_SMOOTHING: f64 = 1.0;
/// Ratio of the smoothing lengths that are tried one after the other.
const RATIO: f64 = 1.3;
/// A mean offset of the points to one side that is no fault of the path, m, and in standard errors.
const OFFSET: f64 = 0.1;
const OFFSET_ERRORS: f64 = 5.0;
/// Knots in one cut-off length.
const KNOTS: f64 = 8.0;

/// How recorded points become a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PointOptions {
    /// A name for people.
    pub name: String,
    /// Speed the path is made for, m/s.
    pub speed: f64,
    /// Whether the last point leads to the first.
    pub closed: bool,
    /// Points nearer than this to the one before are repeated ones, m.
    pub minimum_spacing: f64,
    /// Waves in the road shorter than this are smoothed away, m.
    pub smoothing_length: f64,
    /// Largest curvature of the path, 1/m: smoothing is lengthened until it is kept.
    pub max_curvature: f64,
    /// A point further than this from where its neighbours lead is an outlier, m.
    pub largest_jump: f64,
    /// Largest distance of a point from the path, m. `None`: what the points' noise explains.
    pub max_deviation: Option<f64>,
    /// Distance between the path's points, m.
    pub spacing: f64,
    /// Which fixes of a satellite receiver are used.
    pub fixes: FixOptions,
}

impl Default for PointOptions {
    fn default() -> Self {
        Self {
            name: "recorded path".into(),
            speed: 10.0,
            closed: false,
            minimum_spacing: 0.1,
            smoothing_length: 20.0,
            max_curvature: 0.2,
            largest_jump: 1.0,
            max_deviation: None,
            spacing: 0.5,
            fixes: FixOptions::default(),
        }
    }
}

/// A path, and how it relates to the points it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedPath {
    /// The path.
    pub path: Path,
    /// Root mean square of the points' distances from the path, m.
    pub rms_distance_m: f64,
    /// Largest distance of a point from the path, m.
    pub largest_distance_m: f64,
    /// That point, m.
    pub furthest_point_m: [f64; 2],
    /// The points' noise in each direction, as a standard deviation, m.
    pub noise_m: f64,
    /// The deviation that exceeds its limit, if any does: the path is off the points.
    pub excess: Option<Excess>,
    /// Smoothing in force, m; longer than asked for where the curvature needed it, shorter where the
    /// points did.
    pub smoothing_length_m: f64,
    /// What was left out or changed, in words.
    pub warnings: Vec<String>,
}

/// A path that is further off its points than it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Distance of a point, or the mean distance of neighbours to one side, m.
    pub deviation_m: f64,
    /// What is allowed, m.
    pub limit_m: f64,
    /// Whether it is the mean of neighbours.
    pub is_mean: bool,
    /// The point, m.
    pub at_m: [f64; 2],
}

impl std::fmt::Display for Excess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.at_m;
        let what = if self.is_mean { "neighbouring points are on average" } else { "a point is" };
        let (deviation, limit) = (self.deviation_m, self.limit_m);
        write!(
            f,
            "{what} {deviation:.2} m off the path at x {x:.1} m, y {y:.1} m, allowed {limit:.2} m"
        )
    }
}

/// Makes a path from positions in m, in driving order. A path that cannot be brought near enough to the
/// points is returned with its [`Excess`].
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::Jumps`], [`Error::Curvature`] and [`Error::Option`] where
/// the slices differ in length, hold something that is not a number, or an option cannot be.
pub fn from_points(xs: &[f64], ys: &[f64], options: &PointOptions) -> Result<RecordedPath, Error> {
    check(xs, ys, options)?;
    let cleaned = clean(xs, ys, options)?;
    let steps = cleaned.x.windows(2).zip(cleaned.y.windows(2));
    let length: f64 = steps.map(|(x, y)| (x[1] - x[0]).hypot(y[1] - y[0])).sum();
    if length > MOST_POINTS * options.spacing {
        let (option, must) = ("length of the path", "at most a million times its points' spacing");
        return Err(Error::Option { option, value: length.round(), must });
    }
    let mut warnings = warnings(&cleaned, xs.len(), options.closed);
    let found = smoothed(&cleaned, options)?;
    let (asked, used) = (options.smoothing_length, found.smoothing);
    let because = if used > asked {
        Some(format!("to keep the curvature below {} 1/m", options.max_curvature))
    } else if used < asked {
        Some("to stay on the points".to_owned())
    } else {
        None
    };
    if let Some(because) = because {
        warnings.push(format!("smoothed over {used:.1} m instead of {asked} m {because}"));
    }
    let mut path =
        document(&options.name, options.speed, options.closed, found.points, provenance(options));
    path.checked(&options.name)?;
    let Deviation { rms_m, largest_m, furthest_m, .. } = found.deviation;
    for (name, value) in [
        ("smoothing_length_used_m", used),
        ("deviation_rms_m", rms_m),
        ("deviation_largest_m", largest_m),
        ("noise_m", cleaned.noise),
    ] {
        let rounded = (value * 1e4).round() / 1e4;
        path.provenance.options.insert(name.into(), rounded.to_string());
    }
    Ok(RecordedPath {
        path,
        rms_distance_m: rms_m,
        largest_distance_m: largest_m,
        furthest_point_m: furthest_m,
        noise_m: cleaned.noise,
        excess: found.deviation.excess,
        smoothing_length_m: used,
        warnings,
    })
}

/// A curve that is smooth enough to drive, its points, and how far the recording is off it.
struct Smoothed {
    smoothing: f64,
    points: Vec<PathPoint>,
    deviation: Deviation,
}

/// The longest smoothing up to the one asked for that stays on the points; longer where the curvature
/// needs it.
fn smoothed(cleaned: &Cleaned, options: &PointOptions) -> Result<Smoothed, Error> {
    let mut smoothing = options.smoothing_length;
    let mut best: Option<Smoothed> = None;
    loop {
        let curve = Curve::fit(cleaned, smoothing, options)?;
        let points = curve.points(options.spacing);
        let reached = curvature(&points);
        if reached > options.max_curvature {
            if let Some(best) = best {
                return Ok(best);
            }
            smoothing *= RATIO;
            if smoothing > LONGEST_SMOOTHING {
                return Err(Error::Curvature {
                    reached,
                    allowed: options.max_curvature,
                    smoothing_m: smoothing / RATIO,
                });
            }
            continue;
        }
        let deviation = curve.deviation(cleaned, smoothing, options.max_deviation);
        let is_longer = smoothing > options.smoothing_length;
        let is_off = deviation.excess.is_some();
        best = Some(Smoothed { smoothing, points, deviation });
        if is_longer || !is_off || smoothing / RATIO < SHORTEST_SMOOTHING {
            break;
        }
        smoothing /= RATIO;
    }
    best.ok_or(Error::TooFewPoints { got: cleaned.x.len(), need: LEAST_POINTS })
}

/// Largest curvature; infinite for a curve that has shrunk to a point or turns on the spot.
fn curvature(points: &[PathPoint]) -> f64 {
    let curvature = |p: &PathPoint| match p.curvature_per_m.abs() {
        k if k.is_finite() && p.distance_m.is_finite() => k,
        _ => f64::INFINITY,
    };
    let rises = points.windows(2).all(|w| w[1].distance_m > w[0].distance_m);
    if rises { points.iter().map(curvature).fold(0.0, f64::max) } else { f64::INFINITY }
}

fn check(xs: &[f64], ys: &[f64], options: &PointOptions) -> Result<(), Error> {
    if xs.len() != ys.len() {
        let value = ys.len() as f64;
        return Err(Error::Option { option: "number of y", value, must: "the number of x" });
    }
    if let Some(&value) = xs.iter().chain(ys).find(|v| !(v.is_finite() && v.abs() < 1e8)) {
        return Err(Error::Option { option: "position", value, must: "a finite number of metres" });
    }
    for (option, value) in [
        ("minimum spacing", options.minimum_spacing),
        ("smoothing length", options.smoothing_length),
        ("largest curvature", options.max_curvature),
        ("largest jump", options.largest_jump),
        ("spacing", options.spacing),
        ("speed", options.speed),
        ("largest deviation", options.max_deviation.unwrap_or(1.0)),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::Option { option, value, must: "greater than 0" });
        }
    }
    Ok(())
}

fn warnings(cleaned: &Cleaned, total: usize, closed: bool) -> Vec<String> {
    let mut out = Vec::new();
    if cleaned.repeated > 0 {
        out.push(format!(
            "left out {} of {total} points that repeat the one before",
            cleaned.repeated
        ));
    }
    for (i, jump) in &cleaned.outliers {
        out.push(format!("left out point {}: {jump:.2} m off its neighbours", i + 1));
    }
    // Rows may be missing: the spline bridges the gap, but nobody has seen the road there.
    let steps: Vec<f64> = (1..cleaned.x.len()).map(|i| gap(cleaned, i)).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let largest = (8.0 * usual).max(5.0);
    for (i, step) in steps.iter().enumerate().filter(|(_, s)| **s > largest) {
        out.push(format!(
            "a gap of {step:.1} m at x {:.1} m, y {:.1} m was bridged",
            cleaned.x[i], cleaned.y[i]
        ));
    }
    let last = cleaned.x.len() - 1;
    let closing = (cleaned.x[last] - cleaned.x[0]).hypot(cleaned.y[last] - cleaned.y[0]);
    if closed && closing > largest {
        out.push(format!(
            "the last point is {closing:.1} m from the first: nobody has seen the road that closes it"
        ));
    }
    out
}

fn gap(cleaned: &Cleaned, i: usize) -> f64 {
    (cleaned.x[i] - cleaned.x[i - 1]).hypot(cleaned.y[i] - cleaned.y[i - 1])
}

fn provenance(options: &PointOptions) -> Provenance {
    let numbers = [
        ("minimum_spacing_m", options.minimum_spacing),
        ("smoothing_length_m", options.smoothing_length),
        ("max_curvature_per_m", options.max_curvature),
        ("largest_jump_m", options.largest_jump),
        ("spacing_m", options.spacing),
    ];
    let mut options_in_force: std::collections::BTreeMap<_, _> =
        numbers.into_iter().map(|(k, v)| (k.to_owned(), v.to_string())).collect();
    options_in_force.insert("closed".into(), options.closed.to_string());
    if let Some(limit) = options.max_deviation {
        options_in_force.insert("max_deviation_m".into(), limit.to_string());
    }
    Provenance { options: options_in_force, ..Provenance::default() }
}

/// A smooth curve by a parameter, from `from` to `to`.
struct Curve {
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
    fn fit(cleaned: &Cleaned, smoothing: f64, options: &PointOptions) -> Result<Self, Error> {
        let (x, y, copies) = if options.closed {
            wrapped(cleaned)
        } else {
            (cleaned.x.clone(), cleaned.y.clone(), 0)
        };
        let mut parameters = vec![0.0];
        for i in 1..x.len() {
            parameters.push(parameters[i - 1] + (x[i] - x[i - 1]).hypot(y[i] - y[i - 1]));
        }
        // Enough of them are left by the cleaning.
        let too_few = || Error::Option {
            option: "distance between recorded points",
            value: ((x[1] - x[0]).hypot(y[1] - y[0]) * 1e3).round() / 1e3,
            must: "short beside the bends of the road, some metres",
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
        self.x.at(t)[1].hypot(self.y.at(t)[1])
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
            let ([fx, dx, _], [fy, dy, _]) = (self.x.at(t), self.y.at(t));
            t += ((x - fx) * dx + (y - fy) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
            // No further than the curve is known, nor to another part of it.
            t = t.clamp(start - 2.0 * self.step, start + 2.0 * self.step);
            t = t.clamp(self.from, self.to);
        }
        t
    }

    /// Parameters between which the path lies: for a closed curve one turn, from the first point
    /// to the copy of it.
    fn range(&self) -> (f64, f64) {
        let last = self.parameters.len() - 1;
        if self.closed {
            (self.parameters[self.copies], self.parameters[last - self.copies])
        } else {
            (self.from, self.to)
        }
    }

    /// Points at equal arc length.
    fn points(&self, spacing: f64) -> Vec<PathPoint> {
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
        let ([x, dx, ddx], [y, dy, ddy]) = (self.x.at(t), self.y.at(t));
        let heading = dy.atan2(dx);
        PathPoint {
            distance_m: distance,
            x_m: x,
            y_m: y,
            heading_rad: before.map_or(heading, |b| {
                b.heading_rad + vehicle_models::wrap_angle(heading - b.heading_rad)
            }),
            curvature_per_m: (dx * ddy - dy * ddx) / dx.hypot(dy).powi(3),
        }
    }

    /// How far the points are off the curve.
    fn deviation(&self, cleaned: &Cleaned, smoothing: f64, limit: Option<f64>) -> Deviation {
        // Parameter and offset to the left of each point.
        let mut offsets = Vec::with_capacity(cleaned.x.len());
        let (mut sum, mut furthest, mut largest_m) = (0.0, 0, 0.0);
        for (i, (&x, &y)) in cleaned.x.iter().zip(&cleaned.y).enumerate() {
            let t = self.foot(self.parameters[i + self.copies], x, y);
            let ([fx, dx, _], [fy, dy, _]) = (self.x.at(t), self.y.at(t));
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

/// How far the points are off a curve.
struct Deviation {
    rms_m: f64,
    largest_m: f64,
    furthest_m: [f64; 2],
    excess: Option<Excess>,
}

/// The mean offset over a window that exceeds what noise explains by most: the point in its middle, the
/// mean and the limit.
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
