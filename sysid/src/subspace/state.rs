//! The state of an [`Accumulator`] as bytes, so that it can be kept, or sent to where states are merged.
//!
//! Eight bytes that name the format, then little-endian doubles: kind (0 sums, 1 R factor), horizon,
//! inputs, outputs, sample time in s, samples, columns, the constant of each channel (none before the
//! first window), and the sums or the R factor.

use crate::Error;
use crate::subspace::accumulator::{Accumulator, State};
use crate::subspace::conditioning::Decomposition;

const FORMAT: &[u8; 8] = b"swsums/1";
const HEAD: usize = 7;
/// Beyond what samples of 1e100 make of an R factor, and what can still be squared.
const LARGEST: f64 = 1e150;

impl Accumulator {
    /// The state after the end of the present segment; a few times (2·horizon·channels)² bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut done = self.clone();
        done.end_segment();
        let kind = match done.state {
            State::Gram(_) => 0.0,
            State::Qr(_) => 1.0,
        };
        let count = |n: usize| n as f64;
        let mut numbers = vec![kind, count(done.horizon), count(done.inputs), count(done.outputs)];
        numbers.extend([done.sample_time_s, count(done.samples), count(done.columns)]);
        if let Some(shift) = &done.shift {
            numbers.extend(shift);
            match &done.state {
                State::Gram(gram) => gram.write(&mut numbers),
                State::Qr(tall) => tall.write(&mut numbers),
            }
        }
        FORMAT.iter().copied().chain(numbers.iter().flat_map(|x| x.to_le_bytes())).collect()
    }

    /// The state that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`Error::Data`] where the bytes are not that.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let wrong =
            |problem: &str| Error::Data { problem: format!("these bytes are no state: {problem}") };
        let Some(rest) = bytes.strip_prefix(FORMAT) else {
            return Err(wrong("they do not begin as one"));
        };
        let (doubles, odd) = rest.as_chunks::<8>();
        let numbers: Vec<f64> = doubles.iter().map(|b| f64::from_le_bytes(*b)).collect();
        if !odd.is_empty() || numbers.len() < HEAD || numbers.iter().any(|x| !x.is_finite()) {
            return Err(wrong("they end too early, or a number is not finite"));
        }
        let count = |k: usize| {
            let x = numbers[k];
            if x >= 0.0 && x < 2f64.powi(53) && x.fract() == 0.0 { Some(x as usize) } else { None }
        };
        let counts = (count(0), count(1), count(2), count(3), count(5), count(6));
        let (Some(kind), Some(s), Some(m), Some(p), Some(samples), Some(columns)) = counts else {
            return Err(wrong("a count is not one"));
        };
        let kind = match kind {
            0 => Decomposition::Gram,
            1 => Decomposition::Qr,
            _ => return Err(wrong("the kind is not known")),
        };
        if columns > samples {
            return Err(wrong("it has more windows than samples"));
        }
        if kind == Decomposition::Qr && numbers.iter().any(|x| x.abs() > LARGEST) {
            return Err(wrong("a number is too large to come from samples"));
        }
        let rows = s.saturating_mul(2).saturating_mul(m.saturating_add(p));
        // Before room is made for a state that the bytes cannot hold.
        if columns > 0 && rows > numbers.len() {
            return Err(wrong("they end too early"));
        }
        let mut state = Self::new(kind, s, (m, p), numbers[4])?;
        (state.samples, state.columns) = (samples, columns);
        let mut left = &numbers[HEAD..];
        if columns > 0 {
            let mut read = || {
                let (shift, rest) = left.split_at_checked(m + p)?;
                state.shift = Some(shift.to_vec());
                left = match &mut state.state {
                    State::Gram(gram) => gram.read(rest),
                    State::Qr(tall) => tall.read(rest, columns),
                }?;
                Some(())
            };
            read().ok_or_else(|| wrong("they end too early"))?;
        }
        if left.is_empty() { Ok(state) } else { Err(wrong("they go on after its end")) }
    }
}
