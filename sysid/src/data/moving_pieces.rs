//! The part in which the vehicle moves, of a drive that is read in pieces: as [`moving`](crate::data::moving) of one that
//! is read whole, but the least speed follows from its first minute of driving.

use crate::data::moving::{of_wheelbase, steady_wheelbase};
use steerwright_drivelog::{Gate, Piece, StreamStart, below_speed_in_words};

/// Time above the least speed of a car that determines the least speed, s.
const FIRST_S: f64 = 60.0;
/// Time that is waited for it, s: for good where a smaller vehicle is nowhere as fast.
const LONGEST_S: f64 = 3600.0;

/// Where the pieces go that move.
type Sink<'a, E> = dyn FnMut(Piece<'_>) -> Result<(), E> + 'a;

/// Leaves out what crawls.
#[derive(Debug, Default)]
pub(crate) struct MovingPieces {
    /// The segments from which the least speed is determined: steering, yaw rate and speed. The last one is open.
    first: Vec<[Vec<f64>; 3]>,
    /// Samples of them above the least speed of a car.
    fast: usize,
    /// What faster parts pass through, and the least speed, m/s; `None` until that is determined.
    gate: Option<(Gate, f64)>,
    start: Option<StreamStart>,
    taken: usize,
    passed: usize,
}

impl MovingPieces {
    /// Hands on what moves, or all of a drive without a speed.
    pub(crate) fn take<E>(
        &mut self,
        start: StreamStart,
        piece: Piece<'_>,
        sink: &mut Sink<'_, E>,
    ) -> Result<(), E> {
        self.start = Some(start);
        match piece {
            Piece::Samples { steering, yaw_rate, speed: Some(speed) } => {
                self.taken += speed.len();
                let samples = [steering, yaw_rate, speed];
                if self.gate.is_some() {
                    return self.pass(samples, sink);
                }
                if self.first.is_empty() {
                    self.first.push(Default::default());
                }
                if let Some(segment) = self.first.last_mut() {
                    segment.iter_mut().zip(samples).for_each(|(x, more)| x.extend(more));
                }
                // Driving at walking pace says nothing of what comes after it.
                let least_of_car = of_wheelbase(None);
                self.fast += speed.iter().filter(|v| **v >= least_of_car).count();
                let is_enough = self.fast as f64 * start.sample_time_s >= FIRST_S
                    || self.taken as f64 * start.sample_time_s >= LONGEST_S;
                if is_enough { self.begin(sink) } else { Ok(()) }
            }
            Piece::End if self.gate.is_some() => self.end_segment(sink),
            Piece::End if !self.first.is_empty() => {
                self.first.push(Default::default());
                Ok(())
            }
            piece => sink(piece),
        }
    }

    /// Hands on what is left; the least speed, m/s, and a warning about what is left out.
    pub(crate) fn end<E>(
        &mut self,
        sink: &mut Sink<'_, E>,
    ) -> Result<Option<(f64, Option<String>)>, E> {
        if self.gate.is_none() {
            self.begin(sink)?;
        }
        self.end_segment(sink)?;
        let (Some((_, least_mps)), Some(start)) = (&self.gate, self.start) else { return Ok(None) };
        let [left_out, all] =
            [self.taken - self.passed, self.taken].map(|n| n as f64 * start.sample_time_s);
        let mut warning = None;
        if left_out > 0.0 {
            warning = Some(below_speed_in_words(*least_mps, left_out, all));
        }
        Ok(Some((*least_mps, warning)))
    }

    /// Determines the least speed and hands on what was read until then.
    fn begin<E>(&mut self, sink: &mut Sink<'_, E>) -> Result<(), E> {
        let first = std::mem::take(&mut self.first);
        let Some(start) = self.start.filter(|_| !first.is_empty()) else { return Ok(()) };
        let segments = || first.iter().map(|segment| segment.each_ref().map(Vec::as_slice));
        let least_mps = of_wheelbase(steady_wheelbase(start, segments()));
        let is_fast = segments().any(|[_, _, speed]| speed.iter().any(|v| *v >= least_mps));
        // All of a vehicle that is nowhere faster.
        let least_mps = if is_fast { least_mps } else { 0.0 };
        let gate = Gate::new((least_mps, f64::INFINITY), start.sample_time_s);
        self.gate = Some((gate, least_mps));
        for (i, segment) in segments().enumerate() {
            if i > 0 {
                self.end_segment(sink)?;
            }
            self.pass(segment, sink)?;
        }
        Ok(())
    }

    fn pass<E>(&mut self, samples: [&[f64]; 3], sink: &mut Sink<'_, E>) -> Result<(), E> {
        let Some((gate, _)) = &mut self.gate else { return Ok(()) };
        let passed = &mut self.passed;
        gate.push(samples, &mut |piece| {
            *passed += samples_of(&piece);
            sink(piece)
        })
    }

    fn end_segment<E>(&mut self, sink: &mut Sink<'_, E>) -> Result<(), E> {
        let Some((gate, _)) = &mut self.gate else { return Ok(()) };
        let passed = &mut self.passed;
        gate.end(&mut |piece| {
            *passed += samples_of(&piece);
            sink(piece)
        })
    }
}

fn samples_of(piece: &Piece<'_>) -> usize {
    match piece {
        Piece::Samples { yaw_rate, .. } => yaw_rate.len(),
        Piece::End => 0,
    }
}
