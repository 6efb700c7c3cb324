//! Samples of several channels, channel after channel, each contiguous: matrices of faer pad their
//! columns, so that one channel as a 1 by N matrix takes eight times its samples.
//! [`Signals::as_ref`] shows them to matrix code without a copy.

use faer::{Mat, MatRef};
use std::ops::{Index, IndexMut, Range, Sub};

/// Channels by N samples; `signals[(i, t)]` is sample t of channel i.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    channels: usize,
    samples: usize,
    values: Vec<f64>,
}

impl Signals {
    /// All zero.
    #[must_use]
    pub fn zeros(channels: usize, samples: usize) -> Self {
        Self { channels, samples, values: vec![0.0; channels * samples] }
    }

    /// Sample t of channel i is `value(i, t)`.
    #[must_use]
    pub fn from_fn(
        channels: usize,
        samples: usize,
        mut value: impl FnMut(usize, usize) -> f64,
    ) -> Self {
        let mut values = Vec::with_capacity(channels * samples);
        for i in 0..channels {
            values.extend((0..samples).map(|t| value(i, t)));
        }
        Self { channels, samples, values }
    }

    /// Number of channels.
    #[must_use]
    pub fn nrows(&self) -> usize {
        self.channels
    }

    /// Number of samples N.
    #[must_use]
    pub fn ncols(&self) -> usize {
        self.samples
    }

    /// The samples of one channel.
    #[must_use]
    pub fn row(&self, channel: usize) -> &[f64] {
        &self.values[channel * self.samples..][..self.samples]
    }

    /// The samples of one channel.
    pub fn row_mut(&mut self, channel: usize) -> &mut [f64] {
        &mut self.values[channel * self.samples..][..self.samples]
    }

    /// All samples, channel after channel.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Channels by N, without a copy.
    #[must_use]
    #[allow(clippy::should_implement_trait)] // as that of faer's matrices, which returns a view too
    pub fn as_ref(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.values, self.channels, self.samples)
    }

    /// A segment of all channels, without a copy.
    #[must_use]
    pub fn columns(&self, range: Range<usize>) -> MatRef<'_, f64> {
        self.as_ref().get(.., range)
    }
}

impl Index<(usize, usize)> for Signals {
    type Output = f64;

    fn index(&self, (channel, t): (usize, usize)) -> &f64 {
        &self.row(channel)[t]
    }
}

impl IndexMut<(usize, usize)> for Signals {
    fn index_mut(&mut self, (channel, t): (usize, usize)) -> &mut f64 {
        &mut self.row_mut(channel)[t]
    }
}

/// The difference reuses the memory of the subtrahend.
impl Sub<Signals> for &Signals {
    type Output = Signals;

    fn sub(self, mut other: Signals) -> Signals {
        assert_eq!((self.channels, self.samples), (other.channels, other.samples));
        other.values.iter_mut().zip(&self.values).for_each(|(b, a)| *b = a - *b);
        other
    }
}

impl Sub for &Signals {
    type Output = Signals;

    fn sub(self, other: Self) -> Signals {
        self - other.clone()
    }
}

/// One channel, without a copy.
impl From<Vec<f64>> for Signals {
    fn from(values: Vec<f64>) -> Self {
        Self { channels: 1, samples: values.len(), values }
    }
}

impl From<MatRef<'_, f64>> for Signals {
    fn from(m: MatRef<'_, f64>) -> Self {
        Self::from_fn(m.nrows(), m.ncols(), |i, t| m[(i, t)])
    }
}

impl From<Mat<f64>> for Signals {
    fn from(m: Mat<f64>) -> Self {
        Self::from(m.as_ref())
    }
}

impl From<&Mat<f64>> for Signals {
    fn from(m: &Mat<f64>) -> Self {
        Self::from(m.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_lie_one_after_the_other_and_look_like_a_matrix() {
        let m = Mat::from_fn(2, 3, |i, t| (10 * i + t) as f64);
        let signals = Signals::from(&m);
        assert_eq!(signals.values(), [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        assert_eq!(signals.row(1), [10.0, 11.0, 12.0]);
        assert_eq!(signals.as_ref(), m.as_ref());
        assert_eq!(signals.columns(1..3), m.get(.., 1..3));
        assert_eq!((&signals - &signals).values(), [0.0; 6]);
        assert_eq!((&signals - Signals::zeros(2, 3)), signals);
        let none = Signals::from(Mat::<f64>::zeros(0, 7));
        assert_eq!((none.nrows(), none.ncols(), none.as_ref().ncols()), (0, 7, 7));
    }
}
