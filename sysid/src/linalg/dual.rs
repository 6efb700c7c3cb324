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

/// A number and its derivatives by `P` parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<const P: usize> {
    pub(crate) value: f64,
    pub(crate) by: [f64; P],
}

impl<const P: usize> Dual<P> {
    /// The parameter `index` itself.
    pub(crate) fn parameter(value: f64, index: usize) -> Self {
        let mut by = [0.0; P];
        by[index] = 1.0;
        Self { value, by }
    }

    /// f(x) by the chain rule, with f's value and derivative at x.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        let mut by = self.by;
        for b in &mut by {
            *b *= slope;
        }
        Self { value, by }
    }
}

macro_rules! by_each {
    ($operator:ident, $method:ident, $assign:tt) => {
        impl<const P: usize> $operator for Dual<P> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                self.value $assign other.value;
                for (a, b) in self.by.iter_mut().zip(&other.by) {
                    *a $assign b;
                }
                self
            }
        }
    };
}

by_each!(Add, add, +=);
by_each!(Sub, sub, -=);

impl<const P: usize> Mul for Dual<P> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for (a, b) in self.by.iter_mut().zip(&other.by) {
            *a = *a * other.value + self.value * b;
        }
        self.value *= other.value;
        self
    }
}

impl<const P: usize> Div for Dual<P> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        self.value *= inverse;
        for (a, b) in self.by.iter_mut().zip(&other.by) {
            *a = (*a - self.value * b) * inverse;
        }
        self
    }
}

impl<const P: usize> Neg for Dual<P> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const P: usize> Scalar for Dual<P> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, by: [0.0; P] }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    fn inverse(self) -> Self {
        let i = 1.0 / self.value;
        self.chain(i, -i * i)
    }
    fn sqrt(self) -> Self {
        let s = self.value.sqrt();
        self.chain(s, 0.5 / s)
    }
    #[inline(always)]
    fn plus(mut self, value: f64) -> Self {
        self.value += value;
        self
    }
    #[inline(always)]
    fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(sin, cos)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(cos, -sin)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
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
