//! The segments of a drive that is read in chunks, on the grids they have where it is read whole.

use super::gate::{Gate, Piece, Sink, StreamStart};
use crate::Error;
use crate::drive::Drive;
use crate::error::counted;
use crate::options::LogOptions;
use crate::resample::{Grid, MARGIN};
use crate::role::Role;
use crate::segments::{self, Clock, LEAST_SEGMENT, Span};
use crate::series::{LEAST_SAMPLES, Series};
use std::rc::Rc;

/// Most samples between rows that are read together; more, and a clock or an option is wrong.
const MOST_SAMPLES: usize = 5_000_000;

struct Open {
    /// Where the data of its grid begin, s.
    from: f64,
    /// Its first sample, s.
    start: f64,
    done: usize,
}

pub(super) struct Spans {
    clock: Clock,
    step: f64,
    stream: StreamStart,
    per_step: usize,
    open: Option<Open>,
    gate: Option<Gate>,
    gaps: usize,
    short: usize,
    /// First and last instant of reversing, and the time of it in all, s.
    reversing: Option<(f64, f64, f64)>,
    /// Samples sent out.
    sent: usize,
}

impl Spans {
    pub(super) fn new(clock: Clock, stream: StreamStart, speeds: Option<(f64, f64)>) -> Self {
        let step = stream.sample_time_s;
        let per_step = clock.per_step(step) as usize;
        let gate = speeds.map(|window| Gate::new(window, step));
        Self {
            clock,
            step,
            stream,
            per_step,
            open: None,
            gate,
            gaps: 0,
            short: 0,
            reversing: None,
            sent: 0,
        }
    }

    /// Sends out what the rows at hand allow, and drops the rows that are done with.
    pub(super) fn advance<E: From<Error>>(
        &mut self,
        drive: &mut Drive,
        options: &LogOptions,
        frozen_to: Option<f64>,
        is_last: bool,
        sink: &mut Sink<'_, E>,
    ) -> Result<(), E> {
        let channels = &drive.channels;
        if channels.iter().any(|c| c.value.is_empty()) {
            drop_before(drive, frozen_to.unwrap_or(f64::NEG_INFINITY));
            return Ok(());
        }
        let from = channels.iter().map(|c| c.start()).fold(f64::NEG_INFINITY, f64::max);
        let to = channels.iter().map(|c| c.end()).fold(f64::INFINITY, f64::min);
        let (spans, splits) = segments::without_gaps(drive, vec![(from, to)], options);
        let gap = |c: &Series| c.gap_limit(options.max_gap_s);
        let limit = channels.iter().map(gap).fold(0.0, f64::max);
        let ends = frozen_to.filter(|frozen_to| frozen_to - to > limit);
        self.gaps += splits.len();
        let (spans, reversing) = segments::without_reversing(drive, spans);
        for run in reversing {
            let (_, last, seconds) = self.reversing.get_or_insert((run.0, run.0, 0.0));
            // Rows that are kept for filters are seen again.
            *seconds += (run.1 - run.0.max(*last)).max(0.0);
            *last = last.max(run.1);
        }
        let continues = |open: &Open, span: &Span| {
            let next =
                if open.done > 0 { self.step * open.done as f64 + open.start } else { open.from };
            span.0 <= next + 1e-9 * self.step
        };
        let goes_on = self.open.as_ref().zip(spans.first()).is_some_and(|(o, s)| continues(o, s));
        if self.open.is_some() && !goes_on {
            self.close(sink)?;
        }
        for (k, span) in spans.iter().enumerate().filter(|(_, span)| span.0 < span.1) {
            if self.open.is_none() {
                let start = self.clock.grid(drive, *span, self.step).start;
                self.open = Some(Open { from: start - self.margin(), start, done: 0 });
            }
            let closed = is_last || ends.is_some() || k + 1 < spans.len() || span.1 < to;
            self.send(drive, span.1, closed, sink)?;
            if closed {
                self.close(sink)?;
            }
        }
        let keep = match &self.open {
            Some(o) if o.done > 0 => {
                o.start + self.step * o.done as f64 - (MARGIN + 2.0) * self.step
            }
            Some(o) => o.from,
            None => ends.unwrap_or(to),
        };
        drop_before(drive, keep);
        Ok(())
    }

    fn margin(&self) -> f64 {
        self.step * self.clock.margin(self.step)
    }

    /// Sends out the samples that have all of their data up to `to`.
    fn send<E: From<Error>>(
        &mut self,
        drive: &Drive,
        to: f64,
        closed: bool,
        sink: &mut Sink<'_, E>,
    ) -> Result<(), E> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let margin = self.clock.margin(self.step);
        let count = Grid::within(open.from, to, self.step, self.per_step, margin).count;
        if count < LEAST_SEGMENT {
            self.short += usize::from(closed);
            return Ok(());
        }
        if count - open.done.min(count) > MOST_SAMPLES {
            let sample_time_s = self.step;
            let duration_s = count as f64 * self.step;
            return Err(
                Error::TooManySamples { duration_s, sample_time_s, limit: MOST_SAMPLES }.into()
            );
        }
        let grid = Grid {
            start: open.start + self.step * open.done as f64,
            step: self.step,
            count: count.saturating_sub(open.done),
            per_step: self.per_step,
        };
        open.done = open.done.max(count);
        if grid.count == 0 {
            return Ok(());
        }
        self.sent += grid.count;
        let on_grid = |role: Role| Some(drive.channel(role)?.interpolate(&grid));
        let steering = on_grid(Role::Steering).unwrap_or_default();
        let yaw_rate = on_grid(Role::YawRate).unwrap_or_default();
        let mut speed = on_grid(Role::Speed);
        speed.iter_mut().flatten().for_each(|v| *v = v.max(0.0));
        match (&mut self.gate, speed) {
            (Some(gate), Some(speed)) => {
                let mut sink = |piece: Piece<'_>| sink(self.stream, piece);
                gate.push([&steering, &yaw_rate, &speed], &mut sink)
            }
            (_, speed) => sink(
                self.stream,
                Piece::Samples {
                    steering: &steering,
                    yaw_rate: &yaw_rate,
                    speed: speed.as_deref(),
                },
            ),
        }
    }

    fn close<E>(&mut self, sink: &mut Sink<'_, E>) -> Result<(), E> {
        if self.open.take().is_none_or(|open| open.done == 0) {
            return Ok(());
        }
        match &mut self.gate {
            Some(gate) => gate.end(&mut |piece| sink(self.stream, piece)),
            None => sink(self.stream, Piece::End),
        }
    }

    /// Rejects a drive of which reversing leaves next to nothing.
    pub(super) fn check_forward(&self, drive: &Drive) -> Result<(), Error> {
        match (self.reversing, drive.channel(Role::Speed)) {
            (Some((_, last, reversing_s)), Some(speed)) if self.sent < LEAST_SAMPLES => {
                let forward_s = self.sent as f64 * self.step;
                Err(Error::Reversing { at: speed.place_at(last), reversing_s, forward_s })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn warnings(&self, name: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.gaps > 0 {
            warnings.push(format!("{name}: split at {}", counted(self.gaps, "gap")));
        }
        if let Some((first_s, _, seconds)) = self.reversing {
            warnings.push(segments::reversing_in_words(name, seconds, first_s));
        }
        if self.short > 0 {
            warnings.push(format!(
                "{name}: {} shorter than {:.1} s left out",
                counted(self.short, "segment"),
                LEAST_SEGMENT as f64 * self.step
            ));
        }
        warnings
    }
}

/// Drops what is no longer needed from that instant on.
pub(super) fn drop_before(drive: &mut Drive, keep: f64) {
    for series in &mut drive.channels {
        // One row before, to draw the line from.
        let cut = series.time.partition_point(|t| *t <= keep).saturating_sub(1);
        Rc::make_mut(&mut series.time).drain(..cut);
        Rc::make_mut(&mut series.line).drain(..cut);
        series.value.drain(..cut);
    }
}
