//! Numbers that carry their derivatives (forward-mode differentiation): the simulation is written once,
//! and its sensitivities are exact to rounding, without a step size. All operations are inlined into simulations that
//! `pulp` compiles for the widest vectors of the processor.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The numbers of the model: plain ones, or numbers with derivatives.
pub(crate) trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn constant(value: f64) -> Self;
    fn value(self) -> f64;
    /// `factor·self`.
    fn times(self, factor: f64) -> Self;
    fn exp(self) -> Self;
    fn inverse(self) -> Self;
    fn sqrt(self) -> Self;
    /// `self + value`.
    fn plus(self, value: f64) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn atan(self) -> Self;
}

/// Numbers that are multiplied by such of fewer parameters, the first of their own.
pub(crate) trait ScaledBy<T>: Scalar {
    fn scaled_by(self, factor: T) -> Self;
}

impl ScaledBy<f64> for f64 {
    #[inline(always)]
    fn scaled_by(self, factor: f64) -> Self {
        self * factor
    }
}

impl<const N: usize, const M: usize> ScaledBy<Dual<M>> for Dual<N> {
    #[inline(always)]
    fn scaled_by(mut self, factor: Dual<M>) -> Self {
        const { assert!(M <= N) };
        let (x, y) = (self.lanes[0], factor.lanes[0]);
        for a in &mut self.lanes {
            *a *= y;
        }
        for (a, b) in self.lanes.iter_mut().zip(&factor.lanes) {
            *a += x * b;
        }
        self.lanes[0] = x * y;
        self
    }
}

/// A number and its derivatives by `N − 1` parameters, side by side: sums and products run over all of them in whole
/// vectors where N is a multiple of 4.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub(crate) struct Dual<const N: usize> {
    lanes: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The parameter `index` itself.
    pub(crate) fn parameter(value: f64, index: usize) -> Self {
        let mut lanes = [0.0; N];
        lanes[0] = value;
        lanes[1 + index] = 1.0;
        Self { lanes }
    }

    /// The derivatives by the first `P` parameters.
    #[inline(always)]
    pub(crate) fn by<const P: usize>(&self) -> [f64; P] {
        std::array::from_fn(|i| self.lanes[1 + i])
    }

    /// f(x) by the chain rule, with f's value and derivative at x.
    #[inline(always)]
    fn chain(mut self, value: f64, slope: f64) -> Self {
        for lane in &mut self.lanes {
            *lane *= slope;
        }
        self.lanes[0] = value;
        self
    }
}

macro_rules! by_each {
    ($operator:ident, $method:ident, $assign:tt) => {
        impl<const N: usize> $operator for Dual<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (a, b) in self.lanes.iter_mut().zip(&other.lanes) {
                    *a $assign b;
                }
                self
            }
        }
    };
}

by_each!(Add, add, +=);
by_each!(Sub, sub, -=);

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        let (x, y) = (self.lanes[0], other.lanes[0]);
        for (a, b) in self.lanes.iter_mut().zip(&other.lanes) {
            *a = *a * y + x * b;
        }
        self.lanes[0] = x * y;
        self
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let inverse = 1.0 / other.lanes[0];
        let value = self.lanes[0] * inverse;
        for (a, b) in self.lanes.iter_mut().zip(&other.lanes) {
            *a = (*a - value * b) * inverse;
        }
        self.lanes[0] = value;
        self
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.lanes[0], -1.0)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        let mut lanes = [0.0; N];
        lanes[0] = value;
        Self { lanes }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.lanes[0]
    }
    #[inline(always)]
    fn times(mut self, factor: f64) -> Self {
        for lane in &mut self.lanes {
            *lane *= factor;
        }
        self
    }
    fn exp(self) -> Self {
        let e = self.lanes[0].exp();
        self.chain(e, e)
    }
    fn inverse(self) -> Self {
        let i = 1.0 / self.lanes[0];
        self.chain(i, -i * i)
    }
    fn sqrt(self) -> Self {
        let s = self.lanes[0].sqrt();
        self.chain(s, 0.5 / s)
    }
    #[inline(always)]
    fn plus(mut self, value: f64) -> Self {
        self.lanes[0] += value;
        self
    }
    #[inline(always)]
    fn sin(self) -> Self {
        let (sin, cos) = self.lanes[0].sin_cos();
        self.chain(sin, cos)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        let (sin, cos) = self.lanes[0].sin_cos();
        self.chain(cos, -sin)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        let x = self.lanes[0];
        self.chain(x.atan(), 1.0 / (1.0 + x * x))
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self * factor
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn inverse(self) -> Self {
        1.0 / self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn plus(self, value: f64) -> Self {
        self + value
    }
    #[inline(always)]
    fn sin(self) -> Self {
        f64::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        f64::cos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        f64::atan(self)
    }
}
