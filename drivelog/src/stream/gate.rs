//! The parts of a segment within a speed window, as [`within_speeds`](crate::segments::within_speeds) finds them.

use crate::segments::{LEAST_SEGMENT, half_average};
use crate::signal::mean;

/// What comes out of a log, in order.
#[derive(Debug, Clone, Copy)]
pub enum Piece<'a> {
    /// Samples that continue the segment.
    Samples {
        /// Steering angle, rad.
        steering: &'a [f64],
        /// Yaw rate, rad/s.
        yaw_rate: &'a [f64],
        /// Speed, m/s.
        speed: Option<&'a [f64]>,
    },
    /// The segment ends.
    End,
}

/// What is known of a log before its first piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamStart {
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// As [`DriveLog::has_steering_angle`](crate::DriveLog::has_steering_angle).
    pub has_steering_angle: bool,
}

/// Where the pieces go.
pub type Sink<'a, E> = dyn FnMut(StreamStart, Piece<'_>) -> Result<(), E> + 'a;

type Out<'a, E> = dyn FnMut(Piece<'_>) -> Result<(), E> + 'a;

/// Lets the parts of segments pass whose speed is within a window; holds samples back until it is known whether they pass.
#[derive(Debug)]
pub struct Gate {
    window: (f64, f64),
    /// Samples on either side of the average.
    half: usize,
    /// Steering, yaw rate and speed: the run that is not sent yet, and what averages need.
    held: [Vec<f64>; 3],
    /// The held samples before this one are decided upon.
    decided: usize,
    /// Length of the run within the window that ends there.
    run: usize,
    sent: usize,
}

impl Gate {
    /// Of the least and the largest speed, m/s, and the sample time, s.
    #[must_use]
    pub fn new(window: (f64, f64), step: f64) -> Self {
        Self {
            window,
            half: half_average(step),
            held: Default::default(),
            decided: 0,
            run: 0,
            sent: 0,
        }
    }

    /// Takes the next samples of the segment: steering, yaw rate and speed.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn push<E>(&mut self, samples: [&[f64]; 3], sink: &mut Out<'_, E>) -> Result<(), E> {
        self.held.iter_mut().zip(samples).for_each(|(held, x)| held.extend_from_slice(x));
        let known = self.held[2].len().saturating_sub(self.half);
        self.decide(known, sink)?;
        self.send(sink)?;
        let keep = self.decided.saturating_sub(self.half.max(self.run - self.sent));
        self.held.iter_mut().for_each(|held| drop(held.drain(..keep)));
        self.decided -= keep;
        Ok(())
    }

    /// Ends the segment.
    ///
    /// # Errors
    /// What the sink returns.
    pub fn end<E>(&mut self, sink: &mut Out<'_, E>) -> Result<(), E> {
        self.decide(self.held[2].len(), sink)?;
        self.end_run(sink)?;
        self.held.iter_mut().for_each(Vec::clear);
        self.decided = 0;
        Ok(())
    }

    fn decide<E>(&mut self, known: usize, sink: &mut Out<'_, E>) -> Result<(), E> {
        while self.decided < known {
            let (k, speed) = (self.decided, &self.held[2]);
            let near = k.saturating_sub(self.half)..(k + self.half + 1).min(speed.len());
            if (self.window.0..=self.window.1).contains(&mean(&speed[near])) {
                self.run += 1;
            } else {
                self.end_run(sink)?;
            }
            self.decided += 1;
        }
        Ok(())
    }

    /// Sends what of the run is known, once it is long enough.
    fn send<E>(&mut self, sink: &mut Out<'_, E>) -> Result<(), E> {
        if self.run < LEAST_SEGMENT || self.run == self.sent {
            return Ok(());
        }
        let new = self.decided - (self.run - self.sent)..self.decided;
        self.sent = self.run;
        let [steering, yaw_rate, speed] = self.held.each_ref().map(|held| &held[new.clone()]);
        sink(Piece::Samples { steering, yaw_rate, speed: Some(speed) })
    }

    fn end_run<E>(&mut self, sink: &mut Out<'_, E>) -> Result<(), E> {
        self.send(sink)?;
        let was_sent = self.sent > 0;
        (self.run, self.sent) = (0, 0);
        if was_sent { sink(Piece::End) } else { Ok(()) }
    }
}
