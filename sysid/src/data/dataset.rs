//! Recorded inputs and outputs at one sample time: a [`Segment`] for each run of samples without a
//! gap, each with an initial state of its own.

use crate::Error;
use crate::data::signals::Signals;

/// Samples without a gap, time along columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Inputs, nu by N.
    pub u: Signals,
    /// Outputs, ny by N.
    pub y: Signals,
}

impl Segment {
    /// Inputs nu by N and outputs ny by N: matrices, or the samples of one channel.
    #[must_use]
    pub fn new(u: impl Into<Signals>, y: impl Into<Signals>) -> Self {
        Self { u: u.into(), y: y.into() }
    }

    /// Number of samples N.
    #[must_use]
    pub fn len(&self) -> usize {
        self.y.ncols()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Segments of one system at one sample time.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSet {
    sample_time_s: f64,
    segments: Vec<Segment>,
}

impl DataSet {
    /// Puts segments together.
    ///
    /// # Errors
    /// [`Error::Data`] where there is none, where their numbers of inputs, outputs or samples differ
    /// or are zero, and where a sample is not finite.
    pub fn new(sample_time_s: f64, segments: Vec<Segment>) -> Result<Self, Error> {
        let wrong = |problem: String| Err(Error::data(problem));
        let Some(first) = segments.first() else {
            return wrong("there is no segment".into());
        };
        let (nu, ny) = (first.u.nrows(), first.y.nrows());
        if ny == 0 {
            return wrong("there is no output".into());
        }
        for (k, segment) in segments.iter().enumerate() {
            let (u, y) = (&segment.u, &segment.y);
            if (u.nrows(), y.nrows()) != (nu, ny) {
                return wrong(format!(
                    "segment {k} has {} inputs and {} outputs, the first {nu} and {ny}",
                    u.nrows(),
                    y.nrows()
                ));
            }
            if u.ncols() != y.ncols() || u.ncols() == 0 {
                return wrong(format!(
                    "segment {k} has {} samples of input and {} of output",
                    u.ncols(),
                    y.ncols()
                ));
            }
            let rows = (0..nu).map(|i| u.row(i)).chain((0..ny).map(|i| y.row(i)));
            let bad = |row: &[f64]| row.iter().position(|x| !x.is_finite());
            if let Some(t) = rows.filter_map(bad).min() {
                return wrong(format!("sample {t} of segment {k} is not finite"));
            }
        }
        Ok(Self { sample_time_s, segments })
    }

    /// One segment of inputs nu by N and outputs ny by N: matrices, or the samples of one channel.
    ///
    /// # Errors
    /// As [`DataSet::new`].
    pub fn single(
        sample_time_s: f64,
        u: impl Into<Signals>,
        y: impl Into<Signals>,
    ) -> Result<Self, Error> {
        Self::new(sample_time_s, vec![Segment::new(u, y)])
    }

    /// Sample time T, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The segments, at least one, none of them empty.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Number of inputs nu.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.segments[0].u.nrows()
    }

    /// Number of outputs ny.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.segments[0].y.nrows()
    }

    /// Number of samples over all segments.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.segments.iter().map(Segment::len).sum()
    }
}

/// The data with a constant taken from each output.
pub(crate) fn without(data: &DataSet, offsets: &[f64]) -> Result<DataSet, Error> {
    let segments = data.segments().iter().map(|s| {
        let y = Signals::from_fn(s.y.nrows(), s.len(), |i, t| s.y[(i, t)] - offsets[i]);
        Segment { u: s.u.clone(), y }
    });
    DataSet::new(data.sample_time_s(), segments.collect())
}
