//! Margins of the linear sampled loop, broken at the plant's input, with its delay.
//!
//! `L(z) = C(z)·P(z)` at `z = e^{jωT}` is that of `docs/methods/design.md`, without the setpoint weights. The
//! grid is logarithmic up to π/T, denser about lightly damped modes; crossings are found by bisection and
//! the modulus margin by golden section, all far below 1e-4 relative.
//!
//! A stable loop has, over ω from 0 to π/T, the argument of 1 + L increase by π/2 for each of its integrators
//! (the argument principle on the upper half of the unit circle; P has no other pole on or outside it). An
//! unstable loop has no margins: modulus margin, gain margin, phase margin and delay margin are 0.

use crate::plants::sampled::Sampled;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use steerwright_formats::{Margins, PidGains};
use steerwright_models::PidParameters;

/// Lowest angle of the grid, rad a sample.
const LOWEST: f64 = 1e-6;
/// Points of the grid in a decade.
const PER_DECADE: f64 = 150.0;

/// The controller's frequency response at `z`.
pub(crate) fn controller(p: &PidParameters, z: Complex<f64>) -> Complex<f64> {
    let difference = Complex::new(1.0, 0.0) - z.inv();
    let (ts, tf) = (p.sample_time, p.gains.derivative_filter_time_s);
    let derivative = difference * p.gains.kd / (difference * tf + ts);
    Complex::new(p.gains.kp, 0.0) + Complex::new(p.gains.ki * ts, 0.0) / difference + derivative
}

/// The same from the reference, with the setpoint weights.
pub(crate) fn from_reference(p: &PidParameters, z: Complex<f64>) -> Complex<f64> {
    let gains = PidGains {
        kp: p.gains.setpoint_weight_proportional * p.gains.kp,
        kd: p.gains.setpoint_weight_derivative * p.gains.kd,
        ..p.gains
    };
    controller(&PidParameters { gains, ..*p }, z)
}

/// |1 + L|, the modulus margin's measure.
fn distance(l: Complex<f64>) -> f64 {
    (l + Complex::new(1.0, 0.0)).norm()
}

/// 2·|1 + L|/|1 − L| = 1/|S − ½|, the disk margin's measure with zero skew (Seiler, Packard and
/// Gahinet 2020).
fn disk_distance(l: Complex<f64>) -> f64 {
    let one = Complex::new(1.0, 0.0);
    2.0 * (one + l).norm() / (one - l).norm().max(f64::MIN_POSITIVE)
}

/// A plant's response on a grid, on which many controllers are evaluated.
#[derive(Debug, Clone)]
pub(crate) struct ResponseGrid {
    points: Vec<GridPoint>,
}

/// The factors of the loop that do not depend on the controller: `L = kp·P + ki·(P·T/D) + kd·(P·D)/(Tf·D + T)` with
/// `D = 1 − z⁻¹`.
#[derive(Debug, Clone)]
struct GridPoint {
    angle: f64,
    difference: Complex<f64>,
    plant: Complex<f64>,
    integrated: Complex<f64>,
    differenced: Complex<f64>,
}

impl GridPoint {
    fn new(plant: &Sampled, angle: f64) -> Self {
        let z = Complex::from_polar(1.0, angle);
        let (response, difference) = (plant.response(z), Complex::new(1.0, 0.0) - z.inv());
        Self {
            angle,
            difference,
            plant: response,
            integrated: response * plant.sample_time / difference,
            differenced: response * difference,
        }
    }

    fn open(&self, p: &PidParameters) -> Complex<f64> {
        let filter = self.difference * p.gains.derivative_filter_time_s + p.sample_time;
        let derivative = self.differenced * filter.conj() * (p.gains.kd / filter.norm_sqr());
        self.plant * p.gains.kp + self.integrated * p.gains.ki + derivative
    }
}

impl ResponseGrid {
    /// A coarse grid over the two decades that matter below π/T.
    pub(crate) fn coarse(plant: &Sampled, lowest: f64, points: usize) -> Self {
        let low = (lowest * plant.sample_time).min(0.1 * PI);
        let step = (PI / low).ln() / (points - 1) as f64;
        let angles = (0..points).map(|i| low * (step * i as f64).exp());
        Self { points: angles.map(|a| GridPoint::new(plant, a)).collect() }
    }

    /// The margins read from the grid; modulus and disk margin are 0 for an unstable loop.
    pub(crate) fn margins(&self, pid: &PidParameters, all: bool) -> Margins {
        let one = Complex::new(1.0, 0.0);
        let mut least = f64::INFINITY;
        let mut disk = f64::INFINITY;
        let mut crossings = Crossings::default();
        let mut before: Option<(Complex<f64>, f64)> = None;
        let (mut first, mut last, mut turns) = (one, one, 0);
        for point in &self.points {
            let open = point.open(pid);
            let value = open + one;
            least = least.min(value.norm_sqr());
            match before {
                Some(_) => turns += turn_over_negative_axis(last, value),
                None => first = value,
            }
            last = value;
            if all {
                disk = disk.min(disk_distance(open));
                if let Some(before) = before {
                    crossings.between(before, (open, point.angle));
                }
            }
            before = Some((open, point.angle));
        }
        // The argument begins at −π/2 for each integrator and, in a stable loop, ends at 0.
        let start = if pid.gains.ki > 0.0 && first.im > 0.0 { TAU } else { 0.0 };
        let argument = last.arg() + TAU * f64::from(turns) - start;
        let stable = argument.abs() < FRAC_PI_2;
        let held = |margin: f64| if stable { margin } else { 0.0 };
        let finite = |margin: f64| Some(held(margin)).filter(|m| m.is_finite());
        Margins {
            gain_margin_db: finite(20.0 * crossings.gain.log10()),
            phase_margin_deg: finite(crossings.phase.to_degrees()),
            delay_margin_s: finite(crossings.delay * pid.sample_time),
            modulus_margin: held(least.sqrt()),
            disk_margin: Some(held(disk)),
            crossover_radps: None,
        }
    }
}

/// Whole turns that the principal argument misses on the straight way from `a` to `b`: 1 where it
/// crosses the negative real axis upwards to downwards, −1 the other way round.
fn turn_over_negative_axis(a: Complex<f64>, b: Complex<f64>) -> i32 {
    if (a.im >= 0.0) == (b.im >= 0.0) {
        return 0;
    }
    let cross = a.re * b.im - a.im * b.re;
    match (a.im >= 0.0, cross > 0.0) {
        // From above to below on the left of the origin is anticlockwise.
        (true, true) => 1,
        (false, false) => -1,
        _ => 0,
    }
}

/// Gain, phase (rad) and delay (samples) margin, read linearly between points of a grid.
struct Crossings {
    gain: f64,
    phase: f64,
    delay: f64,
}

impl Default for Crossings {
    fn default() -> Self {
        Self { gain: f64::INFINITY, phase: f64::INFINITY, delay: f64::INFINITY }
    }
}

impl Crossings {
    fn between(&mut self, a: (Complex<f64>, f64), b: (Complex<f64>, f64)) {
        let ((l, angle), (next, next_angle)) = (a, b);
        if (l.im > 0.0) != (next.im > 0.0) {
            let share = l.im / (l.im - next.im);
            let real = l.re + share * (next.re - l.re);
            if real < 0.0 && real > -1.0 {
                self.gain = self.gain.min(-1.0 / real);
            }
        }
        let (size, next_size) = (l.norm(), next.norm());
        if (size > 1.0) != (next_size > 1.0) {
            let share = (size - 1.0) / (size - next_size);
            let at = l + (next - l) * share;
            let margin = (-at).arg();
            self.phase = self.phase.min(margin.abs());
            let lag = if margin < 0.0 { margin + TAU } else { margin };
            self.delay = self.delay.min(lag / (angle + share * (next_angle - angle)));
        }
    }
}

struct Loop<'a> {
    plant: &'a Sampled,
    pid: &'a PidParameters,
}

impl Loop<'_> {
    fn response_at(&self, angle: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, angle);
        controller(self.pid, z) * self.plant.response(z)
    }

    fn grid(&self) -> Vec<f64> {
        let decades = (PI / LOWEST).log10();
        let count = (decades * PER_DECADE).ceil() as usize;
        let mut grid: Vec<f64> = (0..=count)
            .map(|i| PI * 10.0_f64.powf(decades * (i as f64 / count as f64 - 1.0)))
            .collect();
        for (angle, decay) in self.plant.mode_angles() {
            grid.extend((-20..=20).map(|k| angle + 0.3 * f64::from(k) * decay));
        }
        grid.retain(|a| (LOWEST..=PI).contains(a));
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        grid
    }

    /// Change of the argument of 1 + L from `a` to `b`, halved until no part turns much.
    fn turn(&self, a: (f64, Complex<f64>), b: (f64, Complex<f64>), depth: u32) -> f64 {
        let change = (b.1 / a.1).arg();
        if change.abs() < 0.5 || depth == 0 {
            return change;
        }
        let angle = 0.5 * (a.0 + b.0);
        let middle = (angle, self.response_at(angle) + Complex::new(1.0, 0.0));
        self.turn(a, middle, depth - 1) + self.turn(middle, b, depth - 1)
    }

    fn bisect(&self, mut a: f64, mut b: f64, f: impl Fn(Complex<f64>) -> f64) -> f64 {
        let sign = f(self.response_at(a)) > 0.0;
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if (f(self.response_at(middle)) > 0.0) == sign { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    }

    /// The least value between two angles, by golden section.
    fn least(&self, f: impl Fn(Complex<f64>) -> f64, mut a: f64, mut b: f64) -> f64 {
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
            if f(self.response_at(c)) < f(self.response_at(d)) { b = d } else { a = c }
        }
        f(self.response_at(0.5 * (a + b)))
    }
}

pub(crate) fn margins(plant: &Sampled, pid: &PidParameters) -> Margins {
    let open = Loop { plant, pid };
    let grid = open.grid();
    let values: Vec<Complex<f64>> = grid.iter().map(|a| open.response_at(*a)).collect();
    if !is_stable(&open, &grid, &values) {
        return Margins {
            gain_margin_db: Some(0.0),
            phase_margin_deg: Some(0.0),
            delay_margin_s: Some(0.0),
            modulus_margin: 0.0,
            disk_margin: Some(0.0),
            crossover_radps: None,
        };
    }
    let last = grid.len() - 1;
    let (mut gain, mut phase, mut delay) = (f64::INFINITY, None::<f64>, f64::INFINITY);
    let mut crossover = None;
    for k in 0..last {
        let (a, b) = (values[k], values[k + 1]);
        if (a.im > 0.0) != (b.im > 0.0) && a.re.min(b.re) < 0.0 {
            let l = open.response_at(open.bisect(grid[k], grid[k + 1], |l| l.im));
            // More gain reaches −1 only from inside; a jump of sign at a pole is no crossing.
            if l.re < 0.0 && l.re > -1.0 && l.im.abs() < 1e-6 {
                gain = gain.min(-1.0 / l.re);
            }
        }
        if (a.norm() > 1.0) != (b.norm() > 1.0) {
            let angle = open.bisect(grid[k], grid[k + 1], |l| l.norm() - 1.0);
            let margin = (-open.response_at(angle)).arg();
            if phase.is_none_or(|p| margin.abs() < p.abs()) {
                phase = Some(margin);
            }
            let lag = if margin < 0.0 { margin + TAU } else { margin };
            delay = delay.min(lag / angle * plant.sample_time);
            crossover = Some(angle / plant.sample_time);
        }
    }
    // At π/T the loop is real: it may cross there as well.
    if values[last].re < 0.0 && values[last].re > -1.0 {
        gain = gain.min(-1.0 / values[last].re);
    }
    // The smallest value of a function of the loop.
    let smallest = |f: fn(Complex<f64>) -> f64| {
        let on_grid: Vec<f64> = values.iter().map(|l| f(*l)).collect();
        let mut smallest = on_grid.iter().copied().fold(f64::INFINITY, f64::min);
        for k in 1..last {
            let lowest = on_grid[k] <= on_grid[k - 1] && on_grid[k] <= on_grid[k + 1];
            if lowest && on_grid[k] < 1.2 * smallest {
                smallest = smallest.min(open.least(f, grid[k - 1], grid[k + 1]));
            }
        }
        smallest
    };
    let modulus = smallest(distance);
    let disk = smallest(disk_distance);
    Margins {
        gain_margin_db: if gain.is_finite() { Some(20.0 * gain.log10()) } else { None },
        phase_margin_deg: phase.map(f64::to_degrees),
        delay_margin_s: if delay.is_finite() { Some(delay) } else { None },
        modulus_margin: modulus,
        disk_margin: Some(disk),
        crossover_radps: crossover,
    }
}

fn is_stable(open: &Loop<'_>, grid: &[f64], values: &[Complex<f64>]) -> bool {
    let one = Complex::new(1.0, 0.0);
    if values.iter().any(|l| !l.is_finite()) {
        return false;
    }
    let turned: f64 = (1..grid.len())
        .map(|k| open.turn((grid[k - 1], values[k - 1] + one), (grid[k], values[k] + one), 30))
        .sum();
    let integrators = if open.pid.gains.ki > 0.0 { 2.0 } else { 1.0 };
    (turned - integrators * FRAC_PI_2).abs() < 0.25 * PI
}
