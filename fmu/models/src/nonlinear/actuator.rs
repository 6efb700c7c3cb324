//! The steering actuator: a lag with a limited rate and end stops, moved in closed form.
//!
//! A command that grows linearly is cut where the end stops cut it; within such a piece the error
//! e = c − δ obeys `ė = ċ ∓ rate` where the rate is limited, |e| > rate·T, and `ė = ċ − e/T` elsewhere.
//! Both have closed solutions, and the times at which one turns into the other too: at most three
//! motions a piece, each smooth.

use crate::delay::Segment;
use std::hint::black_box;

/// A smooth motion: `δ(τ) = start + slope·τ + swing·exp(−τ/T)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// How long it lasts, s.
    pub duration: f64,
    /// rad.
    pub start: f64,
    /// rad/s.
    pub slope: f64,
    /// rad; 0 where the rate is limited.
    pub swing: f64,
}

/// The actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuator {
    /// T, s.
    pub time_constant: f64,
    /// Largest rate, rad/s.
    pub rate: f64,
    /// Largest angle, rad.
    pub stop: f64,
}

impl Motion {
    /// δ at `time` after the beginning.
    #[must_use]
    pub fn angle_at(&self, time: f64, time_constant: f64) -> f64 {
        let swing =
            if self.swing == 0.0 { 0.0 } else { self.swing * (-time / time_constant).exp() };
        self.start + self.slope * time + swing
    }
}

impl Actuator {
    /// δ̇ at an angle and a command, both at the road wheel.
    #[must_use]
    pub fn rate_of(&self, angle: f64, command: f64) -> f64 {
        let error = command.clamp(-self.stop, self.stop) - angle;
        (error / self.time_constant).clamp(-self.rate, self.rate)
    }

    /// The command between the end stops, in pieces, which may be empty; both as road-wheel angles, rad.
    #[must_use]
    pub fn within_stops(&self, command: Segment) -> [Segment; 3] {
        let mut pieces = [Segment::default(); 3];
        let Segment { duration: mut left, value: mut start, slope } = command;
        // Down to the nearer stop, to the farther one, and beyond: the third piece is the last.
        for piece in &mut pieces {
            // The compiler may divide before it looks whether the time is of use, and hosts trap a division by zero.
            let divisor = black_box(if slope == 0.0 { 1.0 } else { slope });
            let until = |level: f64| (level - start) / divisor;
            let (held, time, level) = if start > self.stop || (start == self.stop && slope >= 0.0) {
                (true, if slope < 0.0 { until(self.stop) } else { left }, self.stop)
            } else if start < -self.stop || (start == -self.stop && slope <= 0.0) {
                (true, if slope > 0.0 { until(-self.stop) } else { left }, -self.stop)
            } else if slope == 0.0 {
                (false, left, start)
            } else {
                let level = self.stop.copysign(slope);
                (false, until(level), level)
            };
            let ends = time >= left;
            let duration = if ends { left } else { time };
            let value = if held { level } else { start };
            *piece = Segment { duration, value, slope: if held { 0.0 } else { slope } };
            if ends {
                break;
            }
            left -= time;
            start = level;
        }
        pieces
    }

    /// How δ, now `angle`, follows a command between the end stops; motions may be empty.
    #[must_use]
    pub fn follow(&self, angle: f64, command: Segment) -> [Motion; 3] {
        let mut motions = [Motion::default(); 3];
        let mut left = command.duration;
        let limit = self.rate * self.time_constant;
        let mut error = command.value - angle;
        let mut from = angle;
        if error.abs() > limit {
            let side = error.signum();
            let closing = self.rate - side * command.slope;
            // As above: not by zero, of use or not.
            let divisor = black_box(if closing > 0.0 { closing } else { 1.0 });
            let time = if closing > 0.0 { (error.abs() - limit) / divisor } else { left };
            let duration = time.min(left);
            let slope = side * self.rate;
            motions[0] = Motion { duration, start: from, slope, swing: 0.0 };
            if time >= left {
                return motions;
            }
            left -= time;
            error = side * limit;
            from += slope * time;
        }
        // In the lag, e goes from here to T·ċ, and may leave the band on the way.
        let rest = self.time_constant * command.slope;
        let edge = limit.copysign(rest);
        let time = if rest.abs() > limit {
            self.time_constant * ((rest - error) / (rest - edge)).ln()
        } else {
            left
        };
        let swing = rest - error;
        let duration = time.clamp(0.0, left);
        motions[1] = Motion { duration, start: from - swing, slope: command.slope, swing };
        if time < left {
            let start = from + command.slope * time + error - edge;
            let slope = self.rate.copysign(rest);
            motions[2] = Motion { duration: left - duration, start, slope, swing: 0.0 };
        }
        motions
    }
}
