//! Pieces of several groups, brought to one end: each with the rows up to an instant that all have reached.

use crate::Error;
use crate::recording::{Columns, Pieces};
use std::iter::Peekable;

/// The next rows of each group.
pub(super) struct Rows {
    pub(super) of_groups: Vec<Columns>,
    pub(super) are_last: bool,
}

pub(super) struct Aligned<'r> {
    pieces: Peekable<Pieces<'r>>,
    /// The unit of each group's clock, s; `None` without a clock.
    seconds: Vec<Option<f64>>,
    pending: Vec<Columns>,
}

impl<'r> Aligned<'r> {
    pub(super) fn new(pieces: Pieces<'r>, seconds: Vec<Option<f64>>) -> Self {
        let pending = vec![Columns::default(); seconds.len()];
        Self { pieces: pieces.peekable(), seconds, pending }
    }

    /// The next rows; some, unless they are the last.
    pub(super) fn next(&mut self) -> Result<Rows, Error> {
        loop {
            let piece = self.pieces.next().transpose()?;
            if let Some(rows) = piece {
                self.pending[rows.wanted].append(rows.columns);
            }
            if self.pieces.peek().is_none() {
                return Ok(Rows { of_groups: std::mem::take(&mut self.pending), are_last: true });
            }
            let ready = self.ready();
            if ready.iter().any(|rows| !rows.lines.is_empty()) {
                return Ok(Rows { of_groups: ready, are_last: false });
            }
        }
    }

    /// Takes the rows up to the first of the last instants of the groups.
    fn ready(&mut self) -> Vec<Columns> {
        if let [only] = &mut self.pending[..] {
            return vec![std::mem::take(only)];
        }
        let last = self.pending.iter().zip(&self.seconds).map(|(columns, seconds)| {
            let time = columns.values.first()?.iter().rev().find(|t| !t.is_nan())?;
            Some(time * (*seconds)?)
        });
        let to = last.map(|t| t.unwrap_or(f64::NEG_INFINITY)).fold(f64::INFINITY, f64::min);
        let all = self.pending.iter_mut().zip(&self.seconds);
        all.map(|(columns, seconds)| {
            let seconds = seconds.unwrap_or(1.0);
            let after = |t: &f64| t * seconds > to;
            let time = columns.values.first().map_or(&[][..], Vec::as_slice);
            let count = time.iter().position(after).unwrap_or(time.len());
            let rest = columns.split_off(count);
            std::mem::replace(columns, rest)
        })
        .collect()
    }
}
