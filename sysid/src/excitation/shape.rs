//! The shape of a multisine: amplitudes and phases of its tones together, within limits of the peaks.
//!
//! A signal is the second derivative of a windowed sum of tones, `u = d²/dt² (w·Σ (a_k·cos + b_k·sin)(ω_k·t)/ω_k²)`. Its integral
//! and its first moment are zero, so that every linear vehicle ends with the yaw angle and on the line with which it began,
//! whatever its parameters are: the yaw angle is that of the integral of u, the lateral offset that of its double integral.
//!
//! From the amplitudes of the convex problem and several sets of phases (Schroeder 1970, and spread ones) the cost at full use of the
//! limits is minimised by L-BFGS (Nocedal and Wright, *Numerical Optimization*, 2006, 7.2); the largest use of a limit is
//! replaced by a p-norm whose exponent grows. That problem is not convex: the optimum is a local one, which
//! the bound of the convex problem qualifies.

use super::criterion::{Criterion, Square};
use super::limits::{Mover, QUANTITIES, limit_values};
use std::f64::consts::{PI, TAU};
use steerwright_formats::ManoeuvreLimits;

/// Exponents of the p-norm, and steps with each.
const EXPONENTS: [(f64, usize); 5] = [(8.0, 60), (16.0, 60), (32.0, 80), (64.0, 100), (128.0, 120)];
/// Sets of phases, of which the best go on after the first exponent.
const STARTS: usize = 6;
const KEPT: usize = 2;
/// Pairs that L-BFGS keeps.
const MEMORY: usize = 12;

/// Second differences of a signal over the square of its sample time, beginning and ending at 0: their sum and their first moment
/// are exactly 0.
pub(super) fn second_differences(q: &[f64], sample_time_s: f64) -> Vec<f64> {
    let at = |k: usize, back: usize| k.checked_sub(back).and_then(|k| q.get(k)).copied();
    let mut u = Vec::with_capacity(q.len() + 2);
    for k in 0..q.len() + 2 {
        let [next, here, before] = [0, 1, 2].map(|back| at(k, back).unwrap_or(0.0));
        u.push((next - 2.0 * here + before) / (sample_time_s * sample_time_s));
    }
    u
}

/// The window at a time from 0 to `length`: it rises and falls over `taper` with two continuous derivatives.
pub(super) fn window(time: f64, length: f64, taper: f64) -> f64 {
    let s = (time.min(length - time) / taper).clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// The tones of a block: their frequencies, and its window.
#[derive(Debug, Clone)]
pub(super) struct TonesOfBlock {
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) length_s: f64,
    pub(super) taper_s: f64,
}

impl TonesOfBlock {
    /// Multiples of the block's inverse length within a band.
    pub(super) fn new(length_s: f64, taper_s: f64, [low, high]: [f64; 2]) -> Self {
        let first = (low * length_s).ceil().max(1.0) as usize;
        let last = (high * length_s).floor() as usize;
        let frequencies_hz = (first..=last).map(|k| k as f64 / length_s).collect();
        Self { frequencies_hz, length_s, taper_s }
    }

    /// The steering of coefficients (a of all tones, then b) at samples.
    pub(super) fn signal(&self, coefficients: &[f64], sample_time_s: f64) -> Vec<f64> {
        let count = (self.length_s / sample_time_s).round() as usize + 1;
        let tones = self.frequencies_hz.len();
        let mut q = vec![0.0; count];
        for (k, hz) in self.frequencies_hz.iter().enumerate() {
            let (a, b) = (coefficients[k], coefficients[tones + k]);
            if a == 0.0 && b == 0.0 {
                continue;
            }
            let rate = TAU * hz;
            for (i, q) in q.iter_mut().enumerate() {
                let (sin, cos) = (rate * sample_time_s * i as f64).sin_cos();
                *q += (a * cos + b * sin) / (rate * rate);
            }
        }
        for (i, q) in q.iter_mut().enumerate() {
            *q *= window(sample_time_s * i as f64, self.length_s, self.taper_s);
        }
        second_differences(&q, sample_time_s)
    }
}

/// A block at a speed: quadratic forms of the information, and linear forms of the limited quantities, in the coefficients.
pub(super) struct Block {
    /// Blocks of the estimation data that are driven at this speed.
    pub(super) repeats: f64,
    /// Number of coefficients.
    count: usize,
    /// A form for each pair i ≤ j of parameters, `count` by `count`.
    forms: Vec<Vec<f64>>,
    /// Quantities over their limits, a row of `count` for each.
    uses: Vec<Vec<f64>>,
}

impl Block {
    /// `sensitivities` returns the derivatives of the yaw rate, weighted to unit noise, of a steering signal.
    pub(super) fn new(
        tones: &TonesOfBlock,
        mover: &Mover,
        limits: &ManoeuvreLimits,
        sample_time_s: f64,
        repeats: f64,
        size: usize,
        sensitivities: impl Fn(&[f64]) -> Option<Vec<Vec<f64>>>,
    ) -> Option<Self> {
        let count = 2 * tones.frequencies_hz.len();
        let mut by: Vec<Vec<Vec<f64>>> = Vec::with_capacity(count);
        let mut columns: Vec<Vec<f64>> = Vec::with_capacity(count);
        let limit = limit_values(limits);
        for k in 0..count {
            let mut unit = vec![0.0; count];
            unit[k] = 1.0;
            let signal = tones.signal(&unit, sample_time_s);
            by.push(sensitivities(&signal)?);
            let quantities = mover.quantities(&signal);
            let mut column = Vec::new();
            for i in (0..QUANTITIES).filter(|i| limit[*i].is_finite()) {
                column.extend(quantities[i].iter().map(|x| x / limit[i]));
            }
            columns.push(column);
        }
        let mut forms = Vec::new();
        for i in 0..size {
            for j in i..size {
                let mut form = vec![0.0; count * count];
                for k in 0..count {
                    for l in 0..count {
                        let pairs = by[k].iter().zip(&by[l]);
                        form[k * count + l] = pairs.map(|(x, y)| x[i] * y[j]).sum();
                    }
                }
                // Of the symmetric part, which alone counts.
                let symmetric =
                    |k: usize, l: usize| 0.5 * (form[k * count + l] + form[l * count + k]);
                forms.push((0..count * count).map(|e| symmetric(e / count, e % count)).collect());
            }
        }
        let rows = columns.first().map_or(0, Vec::len);
        let uses = (0..rows).map(|r| columns.iter().map(|column| column[r]).collect()).collect();
        Some(Self { repeats, count, forms, uses })
    }

    /// The information of a tone of power 1 of any phase.
    pub(super) fn of_tone(&self, tone: usize, size: usize) -> Square {
        let tones = self.count / 2;
        let place = |k: usize| k * self.count + k;
        let mean = |form: &Vec<f64>| 0.5 * (form[place(tone)] + form[place(tones + tone)]);
        self.square(self.forms.iter().map(|form| self.repeats * mean(form)), size)
    }

    /// The mean squares of the limited quantities of a tone of power 1 over their limits' squares.
    pub(super) fn shares_of_tone(&self, tone: usize, quantities: usize) -> Vec<f64> {
        let rows = self.uses.len() / quantities;
        let tones = self.count / 2;
        let mean = |rows: &[Vec<f64>]| {
            let square = |row: &Vec<f64>| 0.5 * (row[tone].powi(2) + row[tones + tone].powi(2));
            rows.iter().map(square).sum::<f64>() / rows.len() as f64
        };
        self.uses.chunks(rows).map(mean).collect()
    }

    fn square(&self, entries: impl Iterator<Item = f64>, size: usize) -> Square {
        let mut square = vec![0.0; size * size];
        let mut pairs = (0..size).flat_map(|i| (i..size).map(move |j| (i, j)));
        for (entry, (i, j)) in entries.zip(&mut pairs) {
            square[i * size + j] = entry;
            square[j * size + i] = entry;
        }
        square
    }

    /// Form times coefficients.
    fn times(&self, form: &[f64], x: &[f64]) -> Vec<f64> {
        form.chunks_exact(self.count).map(|row| dot(row, x)).collect()
    }

    /// The p-norm of the uses of the limits, and its gradient.
    fn norm(&self, x: &[f64], exponent: f64) -> (f64, Vec<f64>) {
        let uses: Vec<f64> = self.uses.iter().map(|row| dot(row, x)).collect();
        let largest = uses.iter().map(|z| z.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let sum: f64 = uses.iter().map(|z| (z.abs() / largest).powf(exponent)).sum();
        let norm = largest * sum.powf(1.0 / exponent);
        let mut gradient = vec![0.0; self.count];
        for (row, z) in self.uses.iter().zip(&uses) {
            let slope = z.signum() * (z.abs() / norm).powf(exponent - 1.0);
            if slope.abs() > 1e-12 {
                for (g, a) in gradient.iter_mut().zip(row) {
                    *g += slope * a;
                }
            }
        }
        (norm, gradient)
    }

    fn peak(&self, x: &[f64]) -> f64 {
        self.uses.iter().map(|row| dot(row, x).abs()).fold(f64::MIN_POSITIVE, f64::max)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    crate::linalg::dense::dot(a, b)
}

/// The blocks of all speeds, whose coefficients are optimised together.
pub(super) struct Shape<'a> {
    pub(super) criterion: &'a Criterion,
    pub(super) prior: &'a [f64],
    pub(super) blocks: &'a [Block],
}

impl Shape<'_> {
    /// The coefficients of each block in those of all.
    fn parts<'x>(&self, x: &'x [f64]) -> impl Iterator<Item = (&Block, &'x [f64])> {
        let mut rest = x;
        self.blocks.iter().map(move |block| {
            let (own, others) = rest.split_at(block.count);
            rest = others;
            (block, own)
        })
    }

    /// The cost at full use of the limits by their p-norms, and its gradient.
    fn value(&self, x: &[f64], exponent: f64, gradient: &mut [f64]) -> f64 {
        let size = self.criterion.size;
        let mut information = self.prior.to_vec();
        let mut parts = Vec::new();
        for (block, own) in self.parts(x) {
            let (norm, slope) = block.norm(own, exponent);
            let products: Vec<Vec<f64>> =
                block.forms.iter().map(|form| block.times(form, own)).collect();
            let forms = products.iter().map(|product| dot(product, own));
            let entries: Vec<f64> = forms.map(|q| block.repeats * q / (norm * norm)).collect();
            for (m, own) in information.iter_mut().zip(block.square(entries.iter().copied(), size))
            {
                *m += own;
            }
            parts.push((block, norm, slope, products, entries));
        }
        let Some((value, w)) = self.criterion.smooth(&information) else {
            return f64::INFINITY;
        };
        let mut at = 0;
        for (block, norm, slope, products, entries) in parts {
            let own = &mut gradient[at..at + block.count];
            own.fill(0.0);
            let mut whole = 0.0;
            let pairs = (0..size).flat_map(|i| (i..size).map(move |j| (i, j)));
            for (((i, j), product), entry) in pairs.zip(&products).zip(&entries) {
                let weight = w[i * size + j] * if i == j { 1.0 } else { 2.0 };
                whole += weight * entry;
                let factor = 2.0 * weight * block.repeats / (norm * norm);
                for (g, p) in own.iter_mut().zip(product) {
                    *g -= factor * p;
                }
            }
            for (g, s) in own.iter_mut().zip(&slope) {
                *g += 2.0 * whole / norm * s;
            }
            at += block.count;
        }
        value
    }

    /// Coefficients whose largest use of a limit is 1, block by block.
    fn scaled(&self, x: &[f64]) -> Vec<f64> {
        let part = |(block, own): (&Block, &[f64])| {
            let peak = block.peak(own);
            own.iter().map(|c| c / peak).collect::<Vec<f64>>()
        };
        self.parts(x).flat_map(part).collect()
    }

    /// The cost at full use of the limits.
    fn cost(&self, x: &[f64]) -> f64 {
        let size = self.criterion.size;
        let mut information = self.prior.to_vec();
        let scaled = self.scaled(x);
        for (block, own) in self.parts(&scaled) {
            let entry = |form: &Vec<f64>| block.repeats * dot(&block.times(form, own), own);
            for (m, own) in
                information.iter_mut().zip(block.square(block.forms.iter().map(entry), size))
            {
                *m += own;
            }
        }
        self.criterion.cost(&information)
    }

    /// Optimised coefficients of all blocks, a of all tones, then b, for each; `power` has that of each tone of each block.
    pub(super) fn optimise(&self, power: &[Vec<f64>]) -> Vec<f64> {
        let mut found: Vec<(f64, Vec<f64>)> = (0..STARTS)
            .map(|start| {
                let mut x = self.scaled(&initial(power, start));
                let (exponent, steps) = EXPONENTS[0];
                minimise(|x, gradient| self.value(x, exponent, gradient), &mut x, steps);
                (self.cost(&x), x)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.truncate(KEPT);
        let mut best = (f64::INFINITY, Vec::new());
        for (_, mut x) in found {
            for (exponent, steps) in &EXPONENTS[1..] {
                x = self.scaled(&x);
                minimise(|x, gradient| self.value(x, *exponent, gradient), &mut x, *steps);
                let cost = self.cost(&x);
                if cost < best.0 {
                    best = (cost, x.clone());
                }
            }
        }
        self.scaled(&best.1)
    }
}

/// Coefficients of powers: phases of Schroeder at first, then spread ones.
fn initial(power: &[Vec<f64>], start: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for (block, power) in power.iter().enumerate() {
        let total: f64 = power.iter().sum();
        let floor = 0.01 * total / power.len() as f64;
        let mut before = 0.0;
        let mut phase = 0.0;
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for (k, p) in power.iter().enumerate() {
            if start == 0 {
                phase -= TAU * before / total;
                before += p;
            } else {
                // Multiples of the golden ratio's square spread evenly.
                let spread = (k + 1) as f64 * (start + 7 * block) as f64 * 0.381_966_011_250_105;
                phase = TAU * (spread * (k + 1) as f64).fract() + PI * start as f64 / 3.0;
            }
            let amplitude = (p + floor).sqrt();
            a.push(amplitude * phase.cos());
            b.push(amplitude * phase.sin());
        }
        all.extend(a);
        all.extend(b);
    }
    all
}

/// L-BFGS from `x`, in place.
fn minimise(f: impl Fn(&[f64], &mut [f64]) -> f64, x: &mut Vec<f64>, steps: usize) {
    let count = x.len();
    let mut gradient = vec![0.0; count];
    let mut value = f(x, &mut gradient);
    let mut pairs: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..steps {
        let mut direction: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut weights = Vec::new();
        for (s, y) in pairs.iter().rev() {
            let weight = dot(s, &direction) / dot(s, y);
            direction.iter_mut().zip(y).for_each(|(d, y)| *d -= weight * y);
            weights.push(weight);
        }
        if let Some((s, y)) = pairs.last() {
            let scale = dot(s, y) / dot(y, y);
            direction.iter_mut().for_each(|d| *d *= scale);
        } else {
            let size = dot(&gradient, &gradient).sqrt().max(f64::MIN_POSITIVE);
            let first = 0.05 * dot(x, x).sqrt() / size;
            direction.iter_mut().for_each(|d| *d *= first);
        }
        for ((s, y), weight) in pairs.iter().zip(weights.iter().rev()) {
            let back = weight - dot(y, &direction) / dot(s, y);
            direction.iter_mut().zip(s).for_each(|(d, s)| *d += back * s);
        }
        let slope = dot(&direction, &gradient);
        if slope.is_nan() || slope >= 0.0 {
            return;
        }
        let mut length = 1.0;
        let mut next_gradient = vec![0.0; count];
        let next = loop {
            let next: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + length * d).collect();
            let reached = f(&next, &mut next_gradient);
            if reached <= value + 1e-4 * length * slope {
                value = reached;
                break next;
            }
            length *= 0.5;
            if length < 1e-10 {
                return;
            }
        };
        let s: Vec<f64> = next.iter().zip(x.iter()).map(|(a, b)| a - b).collect();
        let y: Vec<f64> = next_gradient.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        // Without curvature the pair would spoil the approximation.
        if dot(&s, &y) > 1e-12 * dot(&y, &y) {
            pairs.push((s, y));
            if pairs.len() > MEMORY {
                pairs.remove(0);
            }
        }
        *x = next;
        gradient = next_gradient;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::bicycle::information::BicycleInformation;
    use steerwright_formats::VehicleData;

    fn limits() -> ManoeuvreLimits {
        ManoeuvreLimits {
            max_lateral_acceleration_mps2: 3.0,
            max_angle_rad: None,
            max_rate_radps: Some(0.4),
            max_offset_m: Some(2.5),
        }
    }

    /// Blocks of two speeds, each with tones up to 1 Hz.
    fn blocks(information: &BicycleInformation, vehicle: &VehicleData) -> Vec<Block> {
        let tones = TonesOfBlock::new(8.0, 1.5, [0.2, 1.0]);
        let block = |speed: f64| {
            let mover = Mover::new(vehicle, &[], speed, 0.04);
            Block::new(&tones, &mover, &limits(), 0.04, 2.0, information.len(), |signal| {
                let mut rows = information.sensitivities(signal, speed, 0.04)?;
                rows.iter_mut().flatten().for_each(|x| *x *= 100.0);
                Some(rows)
            })
        };
        [12.0, 20.0].map(|speed| block(speed).unwrap()).into()
    }

    #[test]
    fn the_gradient_is_that_of_central_differences() {
        let vehicle = VehicleData::default();
        let information = BicycleInformation::new(&vehicle);
        let blocks = blocks(&information, &vehicle);
        let size = information.len();
        let gradients = [0.3, 1.0, 1.8]
            .into_iter()
            .flat_map(|hz| information.response_gradients(15.0, hz))
            .collect();
        let criterion = Criterion { size, gradients };
        let mut prior = vec![0.0; size * size];
        (0..size).for_each(|i| prior[i * size + i] = 1.0);
        let shape = Shape { criterion: &criterion, prior: &prior, blocks: &blocks };
        let count = blocks[0].count;
        let x: Vec<f64> =
            (0..2 * count).map(|k| ((k * 37 % 19) as f64 - 9.0) / 40.0 + 0.02).collect();
        let mut gradient = vec![0.0; x.len()];
        let mut unused = gradient.clone();
        shape.value(&x, 16.0, &mut gradient);
        for k in 0..x.len() {
            let mut moved = |step: f64| {
                let mut x = x.clone();
                x[k] += step;
                shape.value(&x, 16.0, &mut unused)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            let error = (difference - gradient[k]).abs();
            assert!(error < 1e-4 * (1.0 + gradient[k].abs()), "{k}: {difference} {}", gradient[k]);
        }
    }

    /// A quadratic of condition 1e4, whose minimum is known.
    #[test]
    fn the_minimum_of_a_quadratic() {
        let mut x = vec![1.0; 8];
        let f = |x: &[f64], gradient: &mut [f64]| {
            let mut sum = 0.0;
            for (k, x) in x.iter().enumerate() {
                let curve = 10.0_f64.powf(4.0 * k as f64 / 7.0);
                sum += 0.5 * curve * (x - k as f64).powi(2);
                gradient[k] = curve * (x - k as f64);
            }
            sum
        };
        minimise(f, &mut x, 200);
        for (k, x) in x.iter().enumerate() {
            assert!((x - k as f64).abs() < 1e-5, "{k} {x}");
        }
    }

    /// The second difference of whatever is windowed moves no vehicle for good.
    #[test]
    fn tones_leave_no_yaw_and_no_offset() {
        let tones = TonesOfBlock::new(18.0, 1.5, [0.1, 3.0]);
        let count = 2 * tones.frequencies_hz.len();
        let coefficients: Vec<f64> =
            (0..count).map(|k| ((k * 29 % 17) as f64 - 8.0) / 8.0).collect();
        let signal = tones.signal(&coefficients, 0.01);
        let size: f64 = signal.iter().map(|u| u.abs()).sum();
        let moment: f64 = signal.iter().enumerate().map(|(k, u)| 0.01 * k as f64 * u).sum();
        assert!(signal.iter().sum::<f64>().abs() < 1e-9 * size);
        assert!(moment.abs() < 1e-8 * size, "{moment} {size}");
    }
}
