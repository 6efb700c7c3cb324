//! Yaw by alignment: the displacement between two fixes has the direction of the displacement from
//! speed and gyro alone, rotated by the yaw error.
//!
//! With standard deviations σ and σ₀ of the fixes and a displacement of length D, the angle between
//! both has the standard deviation √(σ² + σ₀²)/D. Once it is below [`GOOD_ENOUGH`] it is a
//! measurement of the yaw. Until then the position is that of the last fix.

use super::filter::{BIAS, Filter, SIDESLIP, YAW};
use super::parameters::PoseParameters;
use crate::Error;
use crate::angle::wrap_angle;
use crate::error::finite;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Largest standard deviation of a direction that determines the yaw, rad.
pub const GOOD_ENOUGH: f64 = 0.1;

/// A start with a larger standard deviation of the yaw begins with alignment, rad.
pub const UNKNOWN: f64 = 0.5;

/// Shortest displacement that is used, m.
const SHORTEST: f64 = 1.0;

/// Largest relative difference between the displacements of fixes and of speed.
const STRETCHED: f64 = 0.1;

/// Largest difference of the lengths by noise, in standard deviations.
const DEVIATIONS: f64 = 4.0;

/// The displacement since the first fix of an alignment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Alignment {
    /// The fix that it began with, m; none yet at the start.
    first: Option<First>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct First {
    fix: [f64; 2],
    variance: f64,
    /// The way of the antenna since then by speed and gyro, m.
    travelled: [f64; 2],
    /// The latest fix, which the filter was set to, m.
    latest: [f64; 2],
}

impl Alignment {
    /// An alignment that waits for a fix.
    #[must_use]
    pub const fn waiting() -> Self {
        Self { first: None }
    }

    /// Takes a fix and sets the filter to it; returns whether the yaw is determined now.
    pub fn take(
        &mut self,
        filter: &mut Filter,
        p: &PoseParameters,
        fix: Vector2<f64>,
        variance: f64,
    ) -> bool {
        let expected = filter.antenna(p);
        set_position(filter, p, fix, variance, Vector2::zeros());
        let begin = First { fix: fix.into(), variance, travelled: [0.0, 0.0], latest: fix.into() };
        let Some(first) = &mut self.first else {
            self.first = Some(begin);
            return false;
        };
        let travelled = Vector2::from(first.travelled) + expected - Vector2::from(first.latest);
        (first.travelled, first.latest) = (travelled.into(), fix.into());
        let led = fix - Vector2::from(first.fix);
        let (length, sum) = (travelled.norm(), variance + first.variance);
        if (led.norm() - length).abs() > STRETCHED * length + DEVIATIONS * sum.sqrt() {
            // One of the fixes is not to be trusted: the later one is given the chance.
            self.first = Some(begin);
            return false;
        }
        if length < SHORTEST || sum > (GOOD_ENOUGH * length).powi(2) {
            return false;
        }
        let angle = wrap_angle(led.y.atan2(led.x) - travelled.y.atan2(travelled.x));
        let measured = sum / (length * length);
        let known = filter.covariance[(YAW, YAW)];
        // A yaw that the way contradicts is given up, another is improved.
        let agrees = angle * angle <= DEVIATIONS * DEVIATIONS * (known + measured);
        let gain = if agrees { known / (known + measured) } else { 1.0 };
        filter.mean[YAW] += gain * angle;
        let rest = 1.0 - gain;
        filter.covariance[(YAW, YAW)] = gain * gain * measured + rest * rest * known;
        filter.covariance[(YAW, BIAS)] *= rest;
        filter.covariance[(YAW, SIDESLIP)] *= rest;
        // The error of this fix is part of the position's and of the yaw's.
        let shared = Vector2::new(-led.y, led.x) * (gain * variance / led.norm_squared());
        set_position(filter, p, fix, variance, shared);
        true
    }

    /// Refuses numbers that are none.
    ///
    /// # Errors
    /// Names an invalid value.
    pub fn check(&self) -> Result<(), Error> {
        let Some(f) = &self.first else { return Ok(()) };
        for pair in [f.fix, f.travelled, f.latest] {
            finite("a place of the alignment", &pair)?;
        }
        if f.variance.is_finite() && f.variance > 0.0 {
            return Ok(());
        }
        let (name, expected) = ("the variance of the alignment's fix", "more than 0");
        Err(Error::SavedState { name, value: f.variance, expected })
    }
}

/// Puts the antenna where the fix is. `shared` is the covariance of the fix's error with the yaw's.
fn set_position(
    filter: &mut Filter,
    p: &PoseParameters,
    fix: Vector2<f64>,
    variance: f64,
    shared: Vector2<f64>,
) {
    let arm = filter.antenna(p) - filter.mean.xy();
    let (x, y) = (fix.x - arm.x, fix.y - arm.y);
    (filter.mean[0], filter.mean[1]) = (x, y);
    let swing = Vector2::new(-arm.y, arm.x);
    let c = &mut filter.covariance;
    let yaw = c[(YAW, YAW)];
    let half = swing * shared.transpose();
    // In this order it is symmetric to the last bit.
    let both = half + half.transpose();
    let position =
        nalgebra::Matrix2::identity() * variance + swing * swing.transpose() * yaw - both;
    c.fixed_view_mut::<2, 2>(0, 0).copy_from(&position);
    for i in 0..2 {
        let with_yaw = shared[i] - swing[i] * yaw;
        (c[(i, YAW)], c[(YAW, i)]) = (with_yaw, with_yaw);
    }
    for other in [BIAS, SIDESLIP] {
        let with_yaw = c[(YAW, other)];
        c[(other, YAW)] = with_yaw;
        for i in 0..2 {
            let value = -swing[i] * with_yaw;
            (c[(i, other)], c[(other, i)]) = (value, value);
        }
    }
}
