//! How the bicycle moves over a part of a sample of constant speed and steering: the transition of (v_y, r, δ),
//! exp([A b 0; 0 −l l; 0 0 0]·h) by scaling and squaring of its blocks (l = 1/Tn), exact with its derivatives. It is
//! computed at a table of speeds and interpolated between them.

use crate::linalg::dual::{Scalar, ScaledBy};
use crate::structures::bicycle::parameters::{BLEND_SPEED, Coefficients};

/// Terms of the series; with a norm of at most 1/4 the next is below 1e-17.
const TERMS: i32 = 12;
const LARGEST_NORM: f64 = 0.25;

pub(super) struct Transition<S> {
    lateral: [S; 4],
    /// (v_y, r) by the initial δ and by the commanded one.
    by_wheel: [S; 2],
    by_target: [S; 2],
    /// δ by the initial δ; by the commanded one it is the rest to 1.
    wheel: S,
}

#[inline(always)]
fn product<S: Scalar>(m: &[S; 4], x: &[S; 2]) -> [S; 2] {
    [m[0] * x[0] + m[1] * x[1], m[2] * x[0] + m[3] * x[1]]
}

#[inline(always)]
fn row_times<T: Copy, S: ScaledBy<T>>(row: &[T], x: &[S; 2]) -> S {
    x[0].scaled_by(row[0]) + x[1].scaled_by(row[1])
}

#[inline(always)]
fn sum<S: Scalar>(x: &[S; 2], y: &[S; 2]) -> [S; 2] {
    [x[0] + y[0], x[1] + y[1]]
}

impl<S: Scalar> Transition<S> {
    fn zero() -> Self {
        let zero = S::constant(0.0);
        Self { lateral: [zero; 4], by_wheel: [zero; 2], by_target: [zero; 2], wheel: zero }
    }

    /// Adds `weight·other` but for the wheel, which follows its command at every speed alike.
    #[inline(always)]
    fn add(&mut self, other: &Self, weight: f64) {
        let add = |sum: &mut S, x: &S| *sum = *sum + x.times(weight);
        self.lateral.iter_mut().zip(&other.lateral).for_each(|(sum, x)| add(sum, x));
        self.by_wheel.iter_mut().zip(&other.by_wheel).for_each(|(sum, x)| add(sum, x));
        self.by_target.iter_mut().zip(&other.by_target).for_each(|(sum, x)| add(sum, x));
    }

    fn new(a: &[S; 4], b: &[S; 2], rate: S, h: S) -> Self {
        let size = |x: S| x.value().abs();
        // A bound on the norm after scaling the states such that the off-diagonals are of one size.
        let norm = h.value().abs()
            * (size(a[0]).max(size(a[3])) + (size(a[1]) * size(a[2])).sqrt() + size(rate));
        // A norm beyond all numbers ends in a result that is not finite, which is refused.
        let halvings = if norm > LARGEST_NORM {
            (norm / LARGEST_NORM).log2().ceil().clamp(0.0, 60.0) as i32
        } else {
            0
        };
        let h = h.times(0.5_f64.powi(halvings));
        let (a, b, l) = (a.map(|x| x * h), b.map(|x| x * h), rate * h);
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        // Columns of the exponential: of v_y and r, of δ, of the command.
        let mut t = Self {
            lateral: [one, zero, zero, one],
            by_wheel: [zero; 2],
            by_target: [zero; 2],
            wheel: one,
        };
        let mut power = [one, zero, zero, one];
        let (mut of_wheel, mut wheel) = ([zero; 2], one);
        let (mut of_target, mut target) = ([zero; 2], zero);
        for k in 1..=TERMS {
            let i = 1.0 / f64::from(k);
            let next = |x: &[S; 2], d: S| {
                let p = product(&a, x);
                [(p[0] + b[0] * d).times(i), (p[1] + b[1] * d).times(i)]
            };
            let (first, second) =
                (product(&a, &[power[0], power[2]]), product(&a, &[power[1], power[3]]));
            power = [first[0], second[0], first[1], second[1]].map(|x| x.times(i));
            of_wheel = next(&of_wheel, wheel);
            of_target = next(&of_target, target);
            wheel = -(l * wheel).times(i);
            target = if k == 1 { l } else { -(l * target).times(i) };
            for (sum, term) in t.lateral.iter_mut().zip(&power) {
                *sum = *sum + *term;
            }
            t.by_wheel = sum(&t.by_wheel, &of_wheel);
            t.by_target = sum(&t.by_target, &of_target);
            t.wheel = t.wheel + wheel;
        }
        for _ in 0..halvings {
            t = t.twice();
        }
        t
    }

    fn twice(&self) -> Self {
        let e = &self.lateral;
        let rest = S::constant(1.0) - self.wheel;
        let (first, second) = (product(e, &[e[0], e[2]]), product(e, &[e[1], e[3]]));
        let scaled = |x: &[S; 2], k: S| [x[0] * k, x[1] * k];
        Self {
            lateral: [first[0], second[0], first[1], second[1]],
            by_wheel: sum(&product(e, &self.by_wheel), &scaled(&self.by_wheel, self.wheel)),
            by_target: sum(
                &sum(&product(e, &self.by_target), &scaled(&self.by_wheel, rest)),
                &self.by_target,
            ),
            wheel: self.wheel * self.wheel,
        }
    }

    #[inline(always)]
    pub(super) fn apply<X: ScaledBy<S>>(&self, x: &mut [X; 2], wheel: &mut X, target: X) {
        let turned = [row_times(&self.lateral[..2], x), row_times(&self.lateral[2..], x)];
        for (i, turned) in turned.into_iter().enumerate() {
            let steered = wheel.scaled_by(self.by_wheel[i]) + target.scaled_by(self.by_target[i]);
            x[i] = turned + steered;
        }
        *wheel = target + (*wheel - target).scaled_by(self.wheel);
    }
}

/// Transitions are computed at speeds whose logarithms are that far apart, and interpolated between them …
const SPEED_STEP: f64 = 1.0 / 64.0;
/// … by the polynomial through so many of them: the error is near rounding.
const POINTS: usize = 8;
/// 1/∏(j − k) over the other points k.
const SCALES: [f64; POINTS] = [
    -1.0 / 5040.0,
    1.0 / 720.0,
    -1.0 / 240.0,
    1.0 / 144.0,
    -1.0 / 144.0,
    1.0 / 240.0,
    -1.0 / 720.0,
    1.0 / 5040.0,
];

/// A speed between those of the table: the first of [`POINTS`] neighbours and Lagrange's weights.
pub(super) struct Between {
    first: usize,
    weights: [f64; POINTS],
}

impl Between {
    /// `None` near and below [`BLEND_SPEED`], where the coefficients have a kink.
    pub(super) fn new(speed: f64) -> Option<Self> {
        const BELOW: usize = POINTS / 2 - 1;
        let place = (speed / BLEND_SPEED).ln() / SPEED_STEP;
        if !(place >= BELOW as f64 && place.is_finite()) {
            return None;
        }
        let whole = place.floor();
        let x = BELOW as f64 + (place - whole);
        let mut weights = SCALES;
        let mut before = 1.0;
        for (k, weight) in weights.iter_mut().enumerate() {
            *weight *= before;
            before *= x - k as f64;
        }
        let mut after = 1.0;
        for (k, weight) in weights.iter_mut().enumerate().rev() {
            *weight *= after;
            after *= x - k as f64;
        }
        Some(Self { first: whole as usize - BELOW, weights })
    }
}

/// The transitions over a part of a sample, by speed.
pub(super) struct Transitions<'a, S> {
    c: &'a Coefficients<S>,
    h: S,
    table: Vec<Option<Transition<S>>>,
}

impl<'a, S: Scalar> Transitions<'a, S> {
    pub(super) fn new(c: &'a Coefficients<S>, h: S) -> Self {
        Self { c, h, table: Vec::new() }
    }

    fn exact(&self, speed: f64) -> Transition<S> {
        let (a, b) = self.c.at_speed(speed);
        Transition::new(&a, &b, self.c.rate, self.h)
    }

    #[inline(always)]
    pub(super) fn interpolate(&mut self, speed: f64, between: Option<&Between>) -> Transition<S> {
        let Some(Between { first, weights }) = between else { return self.exact(speed) };
        if self.table.len() < first + POINTS {
            self.table.resize_with(first + POINTS, || None);
        }
        let mut sum = Transition::zero();
        for (place, weight) in (*first..).zip(weights) {
            if self.table[place].is_none() {
                let node = BLEND_SPEED * (SPEED_STEP * place as f64).exp();
                self.table[place] = Some(self.exact(node));
            }
            if let Some(transition) = &self.table[place] {
                sum.add(transition, *weight);
                sum.wheel = transition.wheel;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dual::Dual;
    use crate::structures::bicycle::parameters::ALL;

    #[test]
    fn transitions_between_the_speeds_of_the_table_are_the_exact_ones() {
        // Soft and stiff tyres, a slow and a fast lag, long samples.
        for (front, rear, lag) in [(3.2, 3.4, -1.0), (4.2, 4.4, -2.5), (5.5, 5.6, -9.0)] {
            let p = [front, rear, 0.9, -0.1, lag, 0.07, 0.01, 0.002, 0.1, 14.0];
            let p = std::array::from_fn(|i| Dual::<{ ALL + 1 }>::parameter(p[i], i));
            let c = Coefficients::new(&p, 0.45);
            let mut transitions = Transitions::new(&c, c.delay);
            for k in 0..400 {
                let speed = 1.1 * (0.011 * f64::from(k)).exp();
                let between = Between::new(speed).unwrap();
                let found = transitions.interpolate(speed, Some(&between));
                let exact = transitions.exact(speed);
                let pairs = |t: &Transition<Dual<{ ALL + 1 }>>| {
                    let all = [&t.lateral[..], &t.by_wheel, &t.by_target, &[t.wheel]].concat();
                    all.iter()
                        .flat_map(|x| [&[x.value()][..], &x.by::<ALL>()].concat())
                        .collect::<Vec<_>>()
                };
                for (a, b) in pairs(&found).iter().zip(&pairs(&exact)) {
                    assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{speed}: {a} {b}");
                }
            }
        }
    }
}
