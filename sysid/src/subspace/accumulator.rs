//! Samples accumulated in chunks into a small state, of which the factor is made: for logs larger than
//! memory, and for many logs on many machines.

use crate::Error;
use crate::data::DataSet;
use crate::subspace::conditioning::Decomposition;
use crate::subspace::factor::{Decomposed, Factor};
use crate::subspace::gram::Gram;
use crate::subspace::tall::Tall;
use faer::MatRef;

const BLOCK: usize = 1024;
/// Rows of windows beyond which the state would no longer be small.
const MOST_ROWS: usize = 8_000;
/// Magnitudes beyond which products of sums overflow.
const LARGEST: f64 = 1e100;

#[derive(Debug, Clone)]
pub(crate) enum State {
    Gram(Gram),
    Qr(Tall),
}

/// The windows of the samples so far, as sums or as an R factor.
///
/// Samples continue a segment until [`end_segment`](Self::end_segment); no window reaches over its
/// end. The state is the same however a segment is cut into chunks, to the last bit. Where one log
/// is shared out, each part needs the last 2·horizon − 1 samples of the part before. From sums of
/// ill-conditioned data [`factor`](Self::factor) returns an error.
#[derive(Debug, Clone)]
pub struct Accumulator {
    pub(crate) horizon: usize,
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    pub(crate) sample_time_s: f64,
    pub(crate) state: State,
    pub(crate) shift: Option<Vec<f64>>,
    /// Samples of the segment that are part of windows to come, channel after channel.
    buffer: Vec<f64>,
    stride: usize,
    filled: usize,
    /// The segment's first w−1 samples once a window of it was added.
    head: Vec<f64>,
    pub(crate) samples: usize,
    pub(crate) columns: usize,
}

impl Accumulator {
    /// No samples yet; `horizon` block rows of past and of future, numbers of (inputs, outputs).
    ///
    /// # Errors
    /// [`Error::Data`] without horizon or outputs, and where the state would not be small.
    pub fn new(
        kind: Decomposition,
        horizon: usize,
        (inputs, outputs): (usize, usize),
        sample_time_s: f64,
    ) -> Result<Self, Error> {
        let channels = inputs + outputs;
        let rows = horizon.saturating_mul(2).saturating_mul(channels);
        if horizon == 0 || outputs == 0 || rows > MOST_ROWS {
            return Err(Error::data(format!(
                "a horizon of {horizon} with {inputs} inputs and {outputs} outputs: 1 output or more is needed, and 1 to {MOST_ROWS} rows in 2·horizon·(inputs + outputs)"
            )));
        }
        let window = 2 * horizon;
        let stride = BLOCK.max(2 * rows) + window + 8;
        let state = match kind {
            Decomposition::Gram => State::Gram(Gram::new(channels, window)),
            Decomposition::Qr => State::Qr(Tall::new(channels, window)),
        };
        Ok(Self {
            horizon,
            inputs,
            outputs,
            sample_time_s,
            state,
            shift: None,
            buffer: vec![0.0; channels * stride],
            stride,
            filled: 0,
            head: Vec::new(),
            samples: 0,
            columns: 0,
        })
    }

    /// Number of samples accumulated.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Sample time, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    pub(crate) fn is_r_factor(&self) -> bool {
        matches!(self.state, State::Qr(_))
    }

    /// Accumulates the next samples of the segment, `u` nu by N and `y` ny by N.
    ///
    /// # Errors
    /// [`Error::Data`] where the shapes are not those announced, and where a sample is not finite or
    /// beyond 1e100; the samples before it have been accumulated.
    pub fn push(&mut self, u: MatRef<'_, f64>, y: MatRef<'_, f64>) -> Result<(), Error> {
        let wrong = |problem: String| Err(Error::data(problem));
        if (u.nrows(), y.nrows()) != (self.inputs, self.outputs) {
            return wrong(format!(
                "a chunk has {} inputs and {} outputs, the state {} and {}",
                u.nrows(),
                y.nrows(),
                self.inputs,
                self.outputs
            ));
        }
        // Without inputs, `u` has no columns to speak of.
        if u.nrows() > 0 && u.ncols() != y.ncols() {
            return wrong(format!(
                "a chunk has {} samples of input and {} of output",
                u.ncols(),
                y.ncols()
            ));
        }
        let full = self.stride - 8 - 1;
        let mut start = 0;
        while start < y.ncols() {
            let count = (full - self.filled).min(y.ncols() - start);
            for c in 0..self.inputs + self.outputs {
                let (m, row) = if c < self.inputs { (u, c) } else { (y, c - self.inputs) };
                let to = &mut self.buffer[c * self.stride + self.filled..][..count];
                let shift = self.shift.as_ref().map_or(0.0, |s| s[c]);
                if let Some(bad) = copy(m.get(row, start..start + count), to, shift) {
                    let what = if c < self.inputs { "input" } else { "output" };
                    let at = self.samples + bad;
                    let value = m[(row, start + bad)];
                    return wrong(format!(
                        "{what} {row} is {value:e} at sample {at}, counted from 0; magnitudes up to {LARGEST:e} can be used"
                    ));
                }
            }
            self.filled += count;
            self.samples += count;
            start += count;
            if self.filled == full {
                self.flush();
            }
        }
        Ok(())
    }

    /// Ends the segment; one shorter than a window of 2·horizon samples has no information.
    pub fn end_segment(&mut self) {
        let edge = 2 * self.horizon - 1;
        if self.filled > edge {
            self.flush();
        }
        if !self.head.is_empty() {
            let tail = self.first_samples(edge);
            if let State::Gram(gram) = &mut self.state {
                gram.add_edges(&self.head, &tail);
            }
        }
        self.head.clear();
        self.filled = 0;
    }

    /// Adds what `other` has accumulated, as segments of its own.
    ///
    /// # Errors
    /// [`Error::Data`] where the two differ in kind, shape, horizon or sample time.
    pub fn merge(&mut self, mut other: Self) -> Result<(), Error> {
        self.end_segment();
        other.end_segment();
        let shape = |a: &Self| (a.horizon, a.inputs, a.outputs);
        let differs = |problem: String| Err(Error::Data { problem });
        if shape(self) != shape(&other) {
            return differs(format!(
                "states of (horizon, inputs, outputs) {:?} and {:?} cannot be merged",
                shape(self),
                shape(&other)
            ));
        }
        if (self.sample_time_s - other.sample_time_s).abs() > 1e-9 * self.sample_time_s.abs() {
            return differs(format!(
                "states of {} s and {} s a sample cannot be merged",
                self.sample_time_s, other.sample_time_s
            ));
        }
        self.samples += other.samples;
        let Some(theirs) = other.shift.take() else { return Ok(()) };
        let ours = self.shift.get_or_insert_with(|| theirs.clone());
        let shift: Vec<f64> = theirs.iter().zip(ours.iter()).map(|(t, o)| t - o).collect();
        match (&mut self.state, &other.state) {
            (State::Gram(a), State::Gram(b)) => a.merge(b, &shift, other.columns),
            (State::Qr(a), State::Qr(b)) => a.merge(b, &shift),
            _ => return differs("sums and an R factor cannot be merged".into()),
        }
        self.columns += other.columns;
        Ok(())
    }

    /// The factor of all windows so far.
    ///
    /// # Errors
    /// - [`Error::TooFewSamples`] where there are fewer windows than rows.
    /// - [`Error::IllConditioned`] where sums are not enough.
    /// - [`Error::NotExciting`] where a channel is constant or the input does not move.
    pub fn factor(&self) -> Result<Factor, Error> {
        let mut done = self.clone();
        done.end_segment();
        let size = 2 * self.horizon * (self.inputs + self.outputs);
        if done.columns < size {
            let need = size + 2 * self.horizon - 1;
            return Err(Error::too_few(self.samples, need, self.sample_time_s));
        }
        let shift = done.shift.unwrap_or_default();
        let (decomposed, mut mean, cancellation) = match &done.state {
            State::Gram(gram) => {
                let m = gram.moments(done.columns);
                (Decomposed::Gram(m.covariance), m.mean, m.cancellation)
            }
            State::Qr(tall) => {
                let (r, mean) = tall.centred(done.columns);
                (Decomposed::Qr(r), mean, 1.0)
            }
        };
        for (j, mean) in mean.iter_mut().enumerate() {
            *mean += shift[j % shift.len()];
        }
        let channels = (self.inputs, self.outputs);
        Factor::from_moments(decomposed, mean, cancellation, self.horizon, channels, done.columns)
    }

    /// Adds the windows that the buffer has in full, and keeps the samples that are in later ones.
    fn flush(&mut self) {
        let (channels, stride) = (self.inputs + self.outputs, self.stride);
        let edge = 2 * self.horizon - 1;
        let count = self.filled - edge;
        if self.shift.is_none() {
            let mut shift = Vec::with_capacity(channels);
            for samples in self.buffer.chunks_exact_mut(stride) {
                let mean = crate::subspace::gram::sum(&samples[..self.filled]) / self.filled as f64;
                samples[..self.filled].iter_mut().for_each(|x| *x -= mean);
                shift.push(mean);
            }
            self.shift = Some(shift);
        }
        if self.head.is_empty() {
            self.head = self.first_samples(edge);
        }
        match &mut self.state {
            State::Gram(gram) => gram.add_windows(&self.buffer, stride, count),
            State::Qr(tall) => tall.add_windows(&self.buffer, stride, count),
        }
        self.columns += count;
        for samples in self.buffer.chunks_exact_mut(stride) {
            samples.copy_within(count..self.filled, 0);
        }
        self.filled = edge;
    }

    /// The first samples of the buffer, sample after sample.
    fn first_samples(&self, count: usize) -> Vec<f64> {
        let channels = self.inputs + self.outputs;
        (0..count * channels)
            .map(|k| self.buffer[k % channels * self.stride + k / channels])
            .collect()
    }
}

/// Copies a row less a constant; returns the place of a value that cannot be used.
fn copy(row: faer::RowRef<'_, f64>, to: &mut [f64], shift: f64) -> Option<usize> {
    let usable = |x: f64| x.abs() <= LARGEST;
    // No early end, so that the loops are vectorised.
    let mut all = true;
    if let Some(row) = row.try_as_row_major() {
        for (to, &x) in to.iter_mut().zip(row.as_slice()) {
            all &= usable(x);
            *to = x - shift;
        }
    } else {
        for (to, &x) in to.iter_mut().zip(row.iter()) {
            all &= usable(x);
            *to = x - shift;
        }
    }
    if all { None } else { row.iter().position(|x| !usable(*x)) }
}

impl Factor {
    /// Factors the data with `horizon` block rows.
    ///
    /// Where the data are too ill-conditioned for the Gram matrix a QR factorisation takes a second
    /// pass; memory does not grow with N. Where the input does not excite 2·horizon samples, the
    /// horizon is shorter: see [`Conditioning`](crate::subspace::Conditioning).
    ///
    /// # Errors
    /// - [`Error::TooFewSamples`] where there are fewer columns than rows.
    /// - [`Error::NotExciting`] where a channel is constant or the input does not move.
    /// - [`Error::Data`] where a value is too large to be squared.
    pub fn new(data: &DataSet, horizon: usize) -> Result<Self, Error> {
        let signals: Vec<_> =
            data.segments().iter().map(|s| (s.u.as_ref(), s.y.as_ref())).collect();
        Self::of_signals(&signals, horizon, data.sample_time_s())
    }

    /// As [`Factor::new`], of segments (u, y) that are someone else's, nu by N and ny by N each. Signals
    /// of which each channel's samples lie side by side in memory are read fastest.
    ///
    /// # Errors
    /// As [`Factor::new`]; [`Error::Data`] too where the segments are not of one shape.
    pub fn of_signals(
        segments: &[(MatRef<'_, f64>, MatRef<'_, f64>)],
        horizon: usize,
        sample_time_s: f64,
    ) -> Result<Self, Error> {
        let by = |kind| accumulated(kind, segments, horizon, sample_time_s);
        match by(Decomposition::Gram) {
            Err(Error::IllConditioned { .. }) => by(Decomposition::Qr),
            done => done,
        }
    }
}

fn accumulated(
    kind: Decomposition,
    segments: &[(MatRef<'_, f64>, MatRef<'_, f64>)],
    horizon: usize,
    sample_time_s: f64,
) -> Result<Factor, Error> {
    let channels = segments.first().map_or((0, 0), |(u, y)| (u.nrows(), y.nrows()));
    let window = horizon.saturating_mul(2);
    let size = window.saturating_mul(channels.0 + channels.1);
    let columns: usize = segments.iter().map(|(_, y)| (y.ncols() + 1).saturating_sub(window)).sum();
    // Before room is made for the sums of a horizon that is far too long.
    if columns < size {
        let got = segments.iter().map(|(_, y)| y.ncols()).sum();
        let need = window.saturating_add(size) - 1;
        return Err(Error::TooFewSamples { got, need, sample_time_s });
    }
    let mut sums = Accumulator::new(kind, horizon, channels, sample_time_s)?;
    for (u, y) in segments {
        sums.push(*u, *y)?;
        sums.end_segment();
    }
    sums.factor()
}
