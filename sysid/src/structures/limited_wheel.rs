//! How a road wheel moves whose rate is limited, after a command that is held, and what the vehicle feels of it.

use crate::linalg::dual::Scalar;

/// The servo of a road wheel: a lag of limited rate.
#[derive(Clone, Copy)]
pub(super) struct Servo<S> {
    /// The inverse of the time constant, 1/s.
    pub(super) lag_rate: S,
    /// Largest rate of the road wheel, rad/s.
    pub(super) rate_max: S,
}

/// A part of a sample in which the rate is limited.
pub(super) struct LimitedPart<S> {
    /// The command by which the lag alone would turn the wheel by the same mean angle: what the vehicle feels of it.
    pub(super) target: S,
    /// The angle at the end.
    pub(super) end: S,
}

/// Below this share of the time constant a part is too short to tell the lag from a ramp.
const SHORT: f64 = 1e-3;

impl<S: Scalar> Servo<S> {
    /// The wheel after a time `h`, s, from an angle to a command.
    #[inline(always)]
    pub(super) fn follow(&self, wheel: S, target: S, h: S) -> S {
        match self.limited(wheel, target, h) {
            Some(limited) => limited.end,
            None => target + (wheel - target) * (-(self.lag_rate * h)).exp(),
        }
    }

    /// The wheel within a part of length `h`, s, from an angle to a command; `None` where the lag is slower than the limit. The
    /// error falls by the largest rate until the lag takes over.
    #[inline(always)]
    pub(super) fn limited(&self, wheel: S, target: S, h: S) -> Option<LimitedPart<S>> {
        let Self { lag_rate, rate_max } = *self;
        let error = target - wheel;
        // Where the rate of the lag is the largest one.
        let edge = rate_max * lag_rate.inverse();
        let is_limited = error.value().abs() > edge.value();
        if !is_limited {
            return None;
        }
        let side = error.value().signum();
        let until = (error.times(side) - edge) * rate_max.inverse();
        let turned = rate_max.times(side);
        let edge = edge.times(side);
        // The integral of the wheel's motion, and its end.
        let (moved, end) = if until.value() >= h.value() {
            ((turned * h * h).times(0.5), wheel + turned * h)
        } else {
            let rest = h - until;
            let left = (-(lag_rate * rest)).exp();
            let decayed = edge * (rest - (-left).plus(1.0) * lag_rate.inverse());
            (
                (turned * until * until).times(0.5) + turned * until * rest + decayed,
                target - edge * left,
            )
        };
        let keep = (-(lag_rate * h)).exp();
        let by_target = h - (-keep).plus(1.0) * lag_rate.inverse();
        let target = if (lag_rate * h).value() < SHORT {
            wheel + edge
        } else {
            wheel + moved * by_target.inverse()
        };
        Some(LimitedPart { target, end })
    }
}
