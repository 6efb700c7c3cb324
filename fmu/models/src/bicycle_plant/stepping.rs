//! Advancing the bicycle plant by the Taylor series of the matrix exponential.

use super::BicyclePlant;
use super::dynamics::Dynamics;
use crate::Error;
use crate::delay::Segment;
use crate::error::diverged;
use crate::identified_plant::LONGEST_STEP;
use crate::nonlinear::actuator::Actuator;
use crate::quadrature::{LONGEST_PANEL, NODE, NODES, mean, panels};
use crate::trigonometry::sin_cos_small;

/// More terms than the series ever needs where the panel is shorter than the time constants.
const MOST_TERMS: usize = 60;

/// 1/k, since a division costs ten multiplications.
const RECIPROCAL: [f64; MOST_TERMS + 1] = {
    let mut table = [1.0; MOST_TERMS + 1];
    let mut k = 2;
    while k <= MOST_TERMS {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

impl BicyclePlant {
    /// Advances by `h` seconds with the inputs as they are.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]], or the states grow beyond all numbers, as they do
    /// far above the critical speed of an oversteering vehicle.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        if !(h > 0.0 && h <= LONGEST_STEP) {
            return Err(Error::Step { step: h, limit: LONGEST_STEP });
        }
        let dynamics = self.dynamics();
        let longest = if dynamics.fastest_rate * LONGEST_PANEL > 1.0 {
            1.0 / dynamics.fastest_rate
        } else {
            LONGEST_PANEL
        };
        self.delay.push(h, self.steering_angle, self.steering_rate)?;
        let mut left = h;
        while left > 0.0 {
            let command = self.delay.next(left);
            left -= command.duration;
            if self.is_within_rate(command) {
                self.move_over(&dynamics, longest, command);
            } else {
                self.move_limited(&dynamics, longest, command);
            }
        }
        self.check_finite()
    }

    /// Whether the lag alone moves the wheel throughout a piece of the command.
    #[inline]
    fn is_within_rate(&self, command: Segment) -> bool {
        let ratio = self.started.steering_ratio;
        let [start, end] =
            [0.0, command.duration].map(|t| (command.value + command.slope * t) / ratio);
        let edge = self.started.actuator_rate_max * self.started.actuator_time_constant;
        // The wheel stays between where it is and the ends of the command.
        let low = start.min(end).min(self.w[2]);
        let high = start.max(end).max(self.w[2]);
        high - low <= edge
    }

    /// The same where the rate may be limited: the wheel's motions one after the other.
    fn move_limited(&mut self, dynamics: &Dynamics, longest: f64, command: Segment) {
        let p = self.started;
        let actuator = Actuator {
            time_constant: p.actuator_time_constant,
            rate: p.actuator_rate_max,
            stop: f64::INFINITY,
        };
        let n = 1.0 / p.steering_ratio;
        let at_wheel = Segment { value: n * command.value, slope: n * command.slope, ..command };
        // A wheel that turns at a given rate.
        let turning = Dynamics { lag: 0.0, gain: 1.0, ..*dynamics };
        let mut before = 0.0;
        for motion in actuator.follow(self.w[2], at_wheel) {
            let duration = motion.duration;
            if duration <= 0.0 {
                continue;
            }
            if motion.swing == 0.0 && motion.slope.abs() == p.actuator_rate_max {
                let rate = Segment { duration, value: motion.slope, slope: 0.0 };
                self.move_over(&turning, longest, rate);
            } else {
                let value = command.value + command.slope * before;
                self.move_over(dynamics, longest, Segment { duration, value, ..command });
            }
            before += duration;
        }
    }

    /// Over a piece of an input: the steering angle, or the rate of a wheel that turns at a given one.
    fn move_over(&mut self, dynamics: &Dynamics, longest: f64, input: Segment) {
        let (count, panel) = panels(input.duration, longest);
        for k in 0..count {
            let steering = input.value + input.slope * (k as f64 * panel);
            self.move_exactly(dynamics, panel, steering, input.slope);
        }
    }

    /// Refuses to go on from states beyond all numbers.
    #[inline]
    fn check_finite(&self) -> Result<(), Error> {
        let [lateral_velocity, yaw_rate, wheel] = self.w;
        diverged([
            ("the lateral velocity", lateral_velocity),
            ("the yaw rate", yaw_rate),
            ("the road-wheel angle", wheel),
            ("yaw", self.pose.yaw),
            ("x", self.pose.x),
            ("y", self.pose.y),
        ])
    }

    /// One panel, which begins at a steering angle that grows by its slope.
    fn move_exactly(&mut self, dynamics: &Dynamics, panel: f64, steering: f64, slope: f64) {
        let mut rate = dynamics.times(&self.w);
        rate[2] += dynamics.gain * steering;
        // The ramp enters the second term, and the others through F only.
        let mut ramp = dynamics.gain * slope * panel;

        let mut end = self.w;
        let mut yaw_increment = panel * self.w[1];
        let mut yaw_at = NODE.map(|s| yaw_increment * s);
        let mut lateral_at = [self.w[0]; NODES];
        let mut power = NODE;
        let mut term = rate.map(|x| x * panel);
        for reciprocal in &RECIPROCAL[2..] {
            // For k = 1, 2, …, term is τᵏ/k! times the k-th derivative at the panel's end, at a node
            // that times nodeᵏ; `reciprocal` is 1/(k+1).
            let to_yaw = panel * term[1] * reciprocal;
            for i in 0..NODES {
                lateral_at[i] += power[i] * term[0];
                power[i] *= NODE[i];
                yaw_at[i] += power[i] * to_yaw;
            }
            yaw_increment += to_yaw;
            let mut changed = ramp != 0.0;
            for (sum, term) in end.iter_mut().zip(term) {
                let before = *sum;
                *sum += term;
                changed |= *sum != before;
            }
            if !changed {
                break;
            }
            let scale = panel * reciprocal;
            term = dynamics.times(&term).map(|x| x * scale);
            term[2] += ramp * reciprocal * panel;
            ramp = 0.0;
        }

        let (sin, cos) = sin_cos_small(&yaw_at);
        let (mut ahead, mut aside) = ([0.0; NODES], [0.0; NODES]);
        for i in 0..NODES {
            ahead[i] = self.speed * cos[i] - lateral_at[i] * sin[i];
            aside[i] = self.speed * sin[i] + lateral_at[i] * cos[i];
        }
        let (along, across) = (mean(&ahead), mean(&aside));
        self.pose.advance(panel * along, panel * across, yaw_increment);
        self.w = end;
    }
}
