//! An actuator that turns more slowly than its largest rate, noticed by the yaw rate.
//!
//! The angle that was sent turns the vehicle by `G(v)/(1 + T·s)`, with T = `yaw_rate_lag`. Two actuators are
//! compared by the yaw rate r, all filtered alike: one that turns at the present rate, at first the largest, and one
//! that turns at `sustained_rate`. With r₁ and r₂ the yaw rates expected of them,
//!
//! ```text
//! d = r₂ − r₁,   slow += Ts·((r − r₁)·d − d²/5)/E − Ts·slow/10 s,   0 ≤ slow ≤ 1
//! E = (G·(largest − sustained rate)·t)²·t/3
//! ```
//!
//! where E is what a ramp at the largest rate adds to ∫d² within t = 0.2 s, but for the lag. From slow = 0.05 on the
//! rate is reduced, until r is r₁ but for a fifth of d, which errors of G and T may explain. However fast the
//! steering, there is no evidence while the vehicle follows it. Page (1954) has such sums.

use super::parameters::PidParameters;
use serde::{Deserialize, Serialize};

/// Time constant of the filter of the yaw rate, s.
const FILTER: f64 = 0.05;
/// Time at the largest rate after which the slow actuator is noticed, s.
const NOTICED_AFTER: f64 = 0.2;
/// Rate at which the evidence is forgotten, 1/s.
const FORGOTTEN: f64 = 0.1;
/// Share of the difference of both actuators that an error of gain and lag explains.
const UNCERTAIN: f64 = 0.2;
/// The sum up to which nothing is reduced.
const NOTICED: f64 = 0.05;
/// Largest evidence of a tick over that of the slow actuator itself: yaw may jump.
const LARGEST: f64 = 2.0;

/// See the module. The first of two is that of the actuator with the present rate.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Actuator {
    /// Angles, rad.
    angles: [f64; 2],
    /// Yaw rates of both, rad/s, and the same filtered.
    yaw_rates: [f64; 2],
    expected: [f64; 2],
    /// Yaw rate of the vehicle, filtered, rad/s.
    measured: f64,
    /// The sum.
    slow: f64,
}

impl Actuator {
    /// One that has come to an angle, rad.
    pub(crate) fn resting_at(angle: f64) -> Self {
        Self { angles: [angle; 2], ..Self::default() }
    }

    /// Takes in a tick: the angle sent at the one before, and the change of the yaw since, rad.
    #[inline(always)]
    pub(crate) fn turned(&mut self, p: &PidParameters, speed: f64, sent: f64, change: f64) {
        let (ts, gain) = (p.sample_time, p.steady_gain(speed));
        let increments = [self.increment(p), p.large_errors.sustained_rate_radps * ts];
        let (lag, filter) = (ts / (p.large_errors.yaw_rate_lag_s + ts), ts / (FILTER + ts));
        for (i, reach) in increments.into_iter().enumerate() {
            self.angles[i] += (sent - self.angles[i]).min(reach).max(-reach);
            self.yaw_rates[i] += lag * (gain * self.angles[i] - self.yaw_rates[i]);
            self.expected[i] += filter * (self.yaw_rates[i] - self.expected[i]);
        }
        self.measured += filter * (change / ts - self.measured);

        let difference = self.expected[1] - self.expected[0];
        let square = difference * difference;
        let evidence = (self.measured - self.expected[0]) * difference;
        let evidence = evidence.min(LARGEST * square).max(-LARGEST * square) - UNCERTAIN * square;
        let ramp = gain
            * (p.largest_increment() / ts - p.large_errors.sustained_rate_radps)
            * NOTICED_AFTER;
        let enough = ramp * ramp * NOTICED_AFTER / 3.0;
        let noticed = if enough > 0.0 { evidence / enough } else { 0.0 };
        // A vehicle at standstill does not turn whatever its actuator does.
        let noticed = noticed * p.integral_share(speed);
        self.slow = (self.slow + ts * (noticed - FORGOTTEN * self.slow)).clamp(0.0, 1.0);
    }

    /// How far the rate is reduced, from 0 to 1.
    #[inline(always)]
    pub(crate) fn reduction(&self, p: &PidParameters) -> f64 {
        if p.large_errors.yaw_rate_lag_s > 0.0 && self.slow > NOTICED {
            (self.slow - NOTICED) / (1.0 - NOTICED)
        } else {
            0.0
        }
    }

    /// Largest change of the steering angle in one tick, rad.
    #[inline(always)]
    pub(crate) fn increment(&self, p: &PidParameters) -> f64 {
        let largest = p.largest_increment();
        let reduction = self.reduction(p);
        if reduction > 0.0 {
            largest
                - reduction
                    * (largest - p.large_errors.sustained_rate_radps * p.sample_time).max(0.0)
        } else {
            largest
        }
    }

    /// The numbers that must be finite.
    pub(crate) fn memory(&self) -> [(&'static str, f64); 5] {
        [
            ("the angle of a slow actuator", self.angles[0] + self.angles[1]),
            ("the yaw rate expected of the actuator", self.expected[0] + self.yaw_rates[0]),
            ("the yaw rate expected of a slow actuator", self.expected[1] + self.yaw_rates[1]),
            ("the yaw rate", self.measured),
            ("the evidence of a slow actuator", self.slow),
        ]
    }
}
