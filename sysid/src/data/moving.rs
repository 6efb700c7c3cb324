//! The part of a log in which the vehicle moves: one least speed for all structures that depend on the speed. Slip angles
//! have no meaning at rest, and the tyres of a vehicle that crawls obey other laws.
//!
//! Vehicles of different size are alike at the same `v²/(g·L)` (Froude's number), so the least speed is
//! `3 m/s·√(L/2.6 m)` with the wheelbase L. Where L is not stated it is the steering angle over the curvature of the path,
//! `δ/(r/v)`, of means over a second: at most some tens of percent more by understeer, of which the root is taken.

use crate::Error;
use std::borrow::Cow;
use std::ops::Range;
use steerwright_drivelog::signal::mean;
use steerwright_drivelog::{DriveLog, StreamStart};

/// Speed below which a car crawls, m/s, and the wheelbase of that car, m.
const CAR: [f64; 2] = [3.0, 2.6];
/// Least and largest wheelbase that the steady turn is believed, m: that of a model car, and of a lorry.
const WHEELBASES: [f64; 2] = [0.1, 8.0];
/// Share of the largest speed below which the curvature is mostly noise.
const SLOW: f64 = 0.25;

/// The least speed of a log, m/s: the stated one, or by the wheelbase, in tenths.
pub(crate) fn least_speed(log: &DriveLog, stated: Option<f64>, wheelbase_m: Option<f64>) -> f64 {
    if let Some(least) = stated {
        return least;
    }
    of_wheelbase(wheelbase_m.or_else(|| wheelbase_of_log(log)))
}

/// The least speed of a vehicle, m/s, in tenths.
pub(super) fn of_wheelbase(wheelbase_m: Option<f64>) -> f64 {
    let [speed, car_wheelbase] = CAR;
    let wheelbase = wheelbase_m.unwrap_or(car_wheelbase);
    (10.0 * speed * (wheelbase / car_wheelbase).sqrt()).round() / 10.0
}

/// The segments of a log in which the speed is `least_mps` or more; all of it where it has no speed.
pub(crate) fn moving(log: &DriveLog, least_mps: f64) -> Result<Cow<'_, DriveLog>, Error> {
    let moving = log.above_speed(least_mps);
    if moving.is_empty() && !log.is_empty() {
        let speed = log.speed.as_deref().unwrap_or_default();
        let fastest_mps = speed.iter().copied().fold(0.0, f64::max);
        return Err(Error::TooSlow { least_mps, fastest_mps });
    }
    Ok(moving)
}

/// The wheelbase by the steady turn of a log, m.
pub(crate) fn wheelbase_of_log(log: &DriveLog) -> Option<f64> {
    let speed = log.speed.as_ref()?;
    if speed.len() != log.len() || log.output.len() != log.len() {
        return None;
    }
    let start = StreamStart {
        sample_time_s: log.sample_time_s,
        steering_ratio: log.steering_ratio,
        has_steering_angle: log.has_steering_angle(),
    };
    let of = |range: &Range<usize>| [&log.input, &log.output, speed].map(|x| &x[range.clone()]);
    steady_wheelbase(start, log.segments.iter().map(|segment| of(&segment.range)))
}

/// The wheelbase by the steady turn, m, of segments of steering, yaw rate and speed; `None` where the steering is no
/// angle or the vehicle does not turn.
pub(super) fn steady_wheelbase<'a>(
    log: StreamStart,
    segments: impl Iterator<Item = [&'a [f64]; 3]>,
) -> Option<f64> {
    if !(log.has_steering_angle && log.steering_ratio > 0.0 && log.sample_time_s > 0.0) {
        return None;
    }
    let width = ((1.0 / log.sample_time_s).round() as usize).max(1);
    let mut turns: Vec<[f64; 3]> = Vec::new();
    for segment in segments {
        let mut start = 0;
        while start + width <= segment[0].len() {
            turns.push(segment.map(|x| mean(&x[start..start + width])));
            start += width;
        }
    }
    let fastest = turns.iter().map(|[_, _, v]| *v).fold(0.0, f64::max);
    turns.retain(|[_, _, v]| *v > 0.0 && *v >= SLOW * fastest);
    let angles: Vec<f64> = turns.iter().map(|[angle, ..]| angle / log.steering_ratio).collect();
    let curvatures: Vec<f64> = turns.iter().map(|[_, rate, v]| rate / v).collect();
    let (angle, curvature) = (mean(&angles), mean(&curvatures));
    let mut sums = [0.0; 2];
    for (a, k) in angles.iter().zip(&curvatures) {
        sums[0] += (a - angle) * (k - curvature);
        sums[1] += (k - curvature) * (k - curvature);
    }
    let wheelbase = sums[0] / sums[1];
    let [least, largest] = WHEELBASES;
    if wheelbase.is_finite() && wheelbase > 0.0 {
        return Some(wheelbase.clamp(least, largest));
    }
    None
}
