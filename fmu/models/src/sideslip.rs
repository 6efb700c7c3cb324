//! The sideslip per yaw rate of a vehicle whose tyres saturate, `S + Q·a²`.
//!
//! The slip angle per force of the rear tyres grows with the force; to second order in the lateral
//! acceleration a, the sideslip in a turn of yaw rate r is `(S + Q·a²)·r`. Tyres carry little more than
//! g, so a is limited to g; this bounds the sideslip for any reading and curvature.

/// Limit of the lateral acceleration, m/s².
const GRAVITY: f64 = 9.81;

/// `S + Q·a²`, s, at a lateral acceleration (m/s²).
#[inline]
pub(crate) fn per_yaw_rate(s: f64, q: f64, acceleration: f64) -> f64 {
    if q == 0.0 {
        return s;
    }
    let counted = acceleration.clamp(-GRAVITY, GRAVITY);
    s + q * counted * counted
}

/// The derivative of `(S + Q·a²)·r` by r, s, where a = v·r.
#[inline]
pub(crate) fn by_yaw_rate(s: f64, q: f64, acceleration: f64) -> f64 {
    let grows = acceleration.abs() < GRAVITY;
    per_yaw_rate(s, if grows { 3.0 * q } else { q }, acceleration)
}

/// The derivative of `(S + Q·a²)·r` by the speed v (m/s), s²/m, where a = v·r.
#[inline]
pub(crate) fn by_speed(q: f64, speed: f64, yaw_rate: f64) -> f64 {
    let grows = (speed * yaw_rate).abs() < GRAVITY;
    if grows { 2.0 * q * speed * yaw_rate.powi(3) } else { 0.0 }
}
