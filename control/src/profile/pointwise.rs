//! The largest speed at each place by the limits that depend on nothing but the speed there.

use crate::Error;
use crate::profile::grid::{Grid, Place};
use steerwright_formats::{ProfileLimit, ProfileLimits, SteeringLimits};

/// Gravity, m/s².
pub(super) const GRAVITY: f64 = 9.80665;
/// A limit that allows less than this speed, m/s, is infeasible: the vehicle would have to stop.
const LEAST_SPEED: f64 = 0.1;

/// The largest z = v² at a place by all limits on z alone, m²/s².
pub(super) fn largest_square(place: &Place, limits: &ProfileLimits) -> f64 {
    let bounds = speed_bounds(place, limits).into_iter();
    bounds
        .filter(|(limit, _)| {
            // With understeer the rate also depends on the acceleration.
            let understeer = limits.steering.map_or(0.0, |s| s.understeer_gradient_rads2pm);
            *limit != ProfileLimit::SteeringRate || understeer == 0.0
        })
        .map(|(_, speed)| speed * speed)
        .fold(f64::INFINITY, f64::min)
}

/// The largest speed at a place by each limit, without acceleration, m/s.
fn speed_bounds(place: &Place, limits: &ProfileLimits) -> Vec<(ProfileLimit, f64)> {
    let curvature = place.curvature.abs();
    let mut all = vec![(ProfileLimit::Speed, limits.max_speed_mps)];
    if curvature > 0.0 {
        let lateral = (limits.max_lateral_acceleration_mps2 / curvature).sqrt();
        all.push((ProfileLimit::LateralAcceleration, lateral));
        if let Some(friction) = limits.friction {
            all.push((ProfileLimit::Friction, (friction * GRAVITY / curvature).sqrt()));
        }
    }
    if let Some(steering) = &limits.steering {
        if let Some(angle) = steering.max_angle_rad {
            all.push((ProfileLimit::SteeringAngle, by_angle(steering, curvature, angle)));
        }
        if let Some(rate) = steering.max_rate_radps {
            let [before, after] = place.slopes.map(f64::abs);
            let slope = before.max(after);
            all.push((ProfileLimit::SteeringRate, by_rate(steering, slope, rate)));
        }
    }
    all
}

/// The largest speed with an angle of (L + K·v²)·κ, m/s; 0 where the angle is too small at a low speed.
fn by_angle(steering: &SteeringLimits, curvature: f64, angle: f64) -> f64 {
    let (l, k) = (steering.steering_per_curvature_radm, steering.understeer_gradient_rads2pm);
    if l * curvature > angle {
        return 0.0;
    }
    if k == 0.0 || curvature == 0.0 {
        return f64::INFINITY;
    }
    // An oversteering vehicle steers less and less, and beyond its critical speed to the other side.
    let square = if k > 0.0 { (angle / curvature - l) / k } else { (angle / curvature + l) / -k };
    square.sqrt()
}

/// The largest speed at which v·|L + K·v²|·κ′ is within a rate, from 0 on, m/s, by bisection.
fn by_rate(steering: &SteeringLimits, slope: f64, rate: f64) -> f64 {
    let (l, k) = (steering.steering_per_curvature_radm, steering.understeer_gradient_rads2pm);
    if slope == 0.0 {
        return f64::INFINITY;
    }
    let allowed = rate / slope;
    if k == 0.0 {
        return allowed / l;
    }
    let needed = |v: f64| v * (l + k * v * v);
    // Of an oversteering vehicle the need has its maximum at this speed; what lies beyond is not reached from below.
    let high = if k > 0.0 { allowed / l } else { (l / (-3.0 * k)).sqrt() };
    if needed(high) <= allowed {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, high);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if needed(middle) <= allowed { low = middle } else { high = middle }
    }
    low
}

/// Rejects a path on which a limit requires a standstill.
pub(super) fn check(grid: &Grid, limits: &ProfileLimits) -> Result<(), Error> {
    for node in 0..=grid.intervals() {
        let place = grid.place(node);
        for (limit, speed) in speed_bounds(&place, limits) {
            if speed < LEAST_SPEED {
                let distance_m = place.distance;
                return Err(Error::ProfileStandstill {
                    limit: limit.name(),
                    speed_mps: speed,
                    distance_m,
                });
            }
        }
    }
    Ok(())
}
