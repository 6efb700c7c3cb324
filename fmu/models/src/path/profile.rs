//! The speed profile of a path, as `path.json` states it: speed and acceleration at a distance.
//!
//! ```text
//! a(s)  = a₀ + (a₁ − a₀)·σ/h          v²(s) = v₀² + 2·a₀·σ + (a₁ − a₀)·σ²/h       σ = s − s₀, h = s₁ − s₀
//! v²(s) = v₁²·(σ/h)^{4/3}             from standstill with acceleration 0: the jerk is constant
//! ```
//!
//! The reference is read where the vehicle is a preview time later if it keeps to the profile. From speed v and acceleration
//! a at its place this is s + v·t + a(s + v·t/3 + a·t²/18)·t²/2, exact for a constant jerk.
//!
//! A motion whose acceleration is linear in the distance is harmonic or hyperbolic, hence the closed form of its time.

use crate::intervals::Intervals;
use steerwright_formats::{ProfilePoint, SpeedProfile};

/// How far ahead the reference of a vehicle that stands at the start is read, m: a speed of 0 as a function of the distance
/// would hold it there. Half of a path that is shorter than twice that.
const LEAST_DISTANCE: f64 = 0.1;

/// A speed profile over the distance along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedReference {
    points: Vec<ProfilePoint>,
    intervals: Intervals,
    closed: bool,
}

impl SpeedReference {
    /// That of a document that was checked: at least two points at increasing distance.
    #[must_use]
    pub fn new(profile: &SpeedProfile, closed: bool) -> Self {
        Self::from_points(profile.points.clone(), closed)
    }

    /// The same speed everywhere, m/s.
    #[must_use]
    pub fn constant(speed_mps: f64) -> Self {
        let point = |distance_m| ProfilePoint { distance_m, speed_mps, acceleration_mps2: 0.0 };
        Self::from_points(vec![point(0.0), point(1.0)], false)
    }

    /// That of points at increasing distance, at least two.
    #[must_use]
    pub fn from_points(points: Vec<ProfilePoint>, closed: bool) -> Self {
        let distances: Vec<f64> = points.iter().map(|point| point.distance_m).collect();
        Self { intervals: Intervals::from_distances(&distances), points, closed }
    }

    /// Speed (m/s) and acceleration (m/s²) to drive at a distance: those of the profile a preview time ahead, s, of which the
    /// second holds where it decelerates there, and a little ahead where the vehicle has yet to start from standstill.
    #[must_use]
    pub fn reference(&self, distance: f64, [drive, brake]: [f64; 2]) -> [f64; 2] {
        let (first, last) = self.ends();
        let least = if first.speed_mps > 0.0 || self.closed {
            f64::NEG_INFINITY
        } else {
            let length = last.distance_m - first.distance_m;
            first.distance_m + LEAST_DISTANCE.min(0.5 * length)
        };
        let braking = self.at(self.ahead(distance.max(least), brake));
        if braking[1] < 0.0 || drive == brake {
            braking
        } else {
            self.at(self.ahead(distance.max(least), drive))
        }
    }

    /// Where a vehicle at a distance is after a time, m.
    fn ahead(&self, distance: f64, time: f64) -> f64 {
        if time == 0.0 {
            return distance;
        }
        let [speed, acceleration] = self.at(distance);
        let third = distance + time * (speed / 3.0 + acceleration * time / 18.0);
        let [_, acceleration] = self.at(third);
        distance + (time * (speed + 0.5 * acceleration * time)).max(0.0)
    }

    /// Speed (m/s) and acceleration (m/s²) at a distance. Before the start and beyond the end of an open path the speed is
    /// constant; a closed path is driven lap by lap.
    #[must_use]
    pub fn at(&self, distance: f64) -> [f64; 2] {
        let (first, last) = self.ends();
        let local = if self.closed {
            let length = last.distance_m - first.distance_m;
            let lap = ((distance - first.distance_m) / length).floor();
            (distance - lap * length).clamp(first.distance_m, last.distance_m)
        } else if distance < first.distance_m {
            return [first.speed_mps, 0.0];
        } else if distance > last.distance_m {
            return [last.speed_mps, 0.0];
        } else {
            distance
        };
        let index = self.intervals.count(local).saturating_sub(1).min(self.points.len() - 2);
        between(self.points[index], self.points[index + 1], local)
    }

    /// The time from the first point to each of them, s.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        let mut times = vec![0.0];
        let mut time = 0.0;
        for pair in self.points.windows(2) {
            time += time_between(pair[0], pair[1]);
            times.push(time);
        }
        times
    }

    fn ends(&self) -> (ProfilePoint, ProfilePoint) {
        (self.points[0], self.points[self.points.len() - 1])
    }
}

/// Speed and acceleration at a distance between two points.
fn between(a: ProfilePoint, b: ProfilePoint, distance: f64) -> [f64; 2] {
    let length = b.distance_m - a.distance_m;
    let share = (distance - a.distance_m) / length;
    if a.is_at_rest() {
        return near_rest(b, share);
    }
    if b.is_at_rest() {
        return near_rest(a, 1.0 - share);
    }
    let [from, to] = [a.speed_mps.powi(2), b.speed_mps.powi(2)];
    let change = b.acceleration_mps2 - a.acceleration_mps2;
    let gained = length * (2.0 * a.acceleration_mps2 + change * share) * share;
    // The rest is what the rounded numbers of a file contradict each other by.
    let rest = to - from - length * (a.acceleration_mps2 + b.acceleration_mps2);
    let square = from + gained + rest * share;
    [square.max(0.0).sqrt(), a.acceleration_mps2 + change * share]
}

/// At a share of the way from a standstill to a point.
fn near_rest(point: ProfilePoint, share: f64) -> [f64; 2] {
    let third = share.max(0.0).cbrt();
    [point.speed_mps * third * third, point.acceleration_mps2 * third]
}

/// Time from one point to the next, s.
fn time_between(a: ProfilePoint, b: ProfilePoint) -> f64 {
    let length = b.distance_m - a.distance_m;
    let sum = a.speed_mps + b.speed_mps;
    if a.is_at_rest() || b.is_at_rest() {
        return 3.0 * length / sum;
    }
    let stiffness = (b.acceleration_mps2 - a.acceleration_mps2) / length;
    let rate = stiffness.abs().sqrt();
    let angle = rate * length / sum;
    // To second order in the angle both functions are the angle itself.
    if angle < 1e-4 {
        2.0 * length / sum
    } else if stiffness > 0.0 {
        2.0 * angle.min(1.0 - f64::EPSILON).atanh() / rate
    } else {
        2.0 * angle.atan() / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(distance_m: f64, speed_mps: f64, acceleration_mps2: f64) -> ProfilePoint {
        ProfilePoint { distance_m, speed_mps, acceleration_mps2 }
    }

    /// A motion of constant jerk from standstill: s = j·t³/6, v = j·t²/2, a = j·t.
    fn from_rest(jerk: f64, time: f64) -> ProfilePoint {
        point(jerk * time.powi(3) / 6.0, 0.5 * jerk * time * time, jerk * time)
    }

    #[test]
    fn a_start_from_standstill_has_a_constant_jerk() {
        let reference =
            SpeedReference::from_points(vec![point(0.0, 0.0, 0.0), from_rest(2.5, 1.2)], false);
        for time in [0.1, 0.5, 0.9, 1.2] {
            let expected = from_rest(2.5, time);
            let [speed, acceleration] = reference.at(expected.distance_m);
            assert!((speed - expected.speed_mps).abs() < 1e-12, "{speed} {expected:?}");
            assert!((acceleration - expected.acceleration_mps2).abs() < 1e-12);
            let elapsed = time_between(point(0.0, 0.0, 0.0), expected);
            assert!((elapsed - time).abs() < 1e-12, "{elapsed}");
        }
    }

    /// ṡ of s(t) = cosh and sin motions, whose acceleration is linear in the distance.
    #[test]
    fn the_time_of_a_linear_acceleration_is_exact() {
        let hyperbolic = |t: f64| point(t.cosh(), t.sinh(), t.cosh());
        let harmonic =
            |t: f64| point(-(2.0 * t).cos(), 2.0 * (2.0 * t).sin(), 4.0 * (2.0 * t).cos());
        for (from, to) in [(0.2, 0.9), (0.5, 0.5001), (0.1, 1.4)] {
            let time = time_between(hyperbolic(from), hyperbolic(to));
            assert!((time - (to - from)).abs() < 1e-9, "{time}");
            let time = time_between(harmonic(from), harmonic(to));
            assert!((time - (to - from)).abs() < 1e-9, "{time}");
        }
        let [speed, acceleration] = between(harmonic(0.2), harmonic(0.7), -(1.0_f64).cos());
        assert!((speed - 2.0 * 1.0_f64.sin()).abs() < 1e-12);
        assert!((acceleration - 4.0 * 1.0_f64.cos()).abs() < 1e-12);
    }

    #[test]
    fn a_closed_path_is_driven_lap_by_lap_and_an_open_one_ends() {
        let points = vec![point(5.0, 10.0, 1.0), point(15.0, 120.0_f64.sqrt(), 1.0)];
        let lap = SpeedReference::from_points(points.clone(), true);
        assert_eq!(lap.at(5.0 + 2.5), lap.at(5.0 + 42.5));
        assert_eq!(lap.at(5.0 + 2.5), lap.at(5.0 - 7.5));
        let open = SpeedReference::from_points(points, false);
        assert_eq!(open.at(0.0), [10.0, 0.0]);
        assert_eq!(open.at(15.1), [120.0_f64.sqrt(), 0.0]);
        assert_eq!(open.reference(5.0, [0.0; 2]), [10.0, 1.0]);
    }

    #[test]
    fn a_vehicle_at_standstill_has_a_reference_to_start_with() {
        let end = from_rest(2.5, 1.2);
        let reference = SpeedReference::from_points(vec![point(0.0, 0.0, 0.0), end], false);
        assert_eq!(reference.at(0.0), [0.0, 0.0]);
        assert_eq!(reference.reference(-1.0, [0.0; 2]), reference.at(0.1));
        assert!(reference.reference(0.0, [0.0; 2])[0] > 0.4);
        assert_eq!(reference.reference(0.3, [0.0; 2]), reference.at(0.3));
    }

    /// The preview is in time, whether the acceleration rises, is held, or falls; at the end the reference is that of the end.
    #[test]
    fn a_preview_is_the_profile_later() {
        let (jerk, preview) = (1.5, 0.4);
        let motion = |time: f64| from_rest(jerk, time);
        let points = (0..=40).map(|k| motion(0.1 * f64::from(k))).collect();
        let rising = SpeedReference::from_points(points, false);
        for time in [0.8, 1.7, 3.0] {
            let (now, later) = (motion(time), motion(time + preview));
            let [speed, acceleration] = rising.reference(now.distance_m, [preview, 0.1]);
            assert!((speed - later.speed_mps).abs() < 2e-3, "{time}: {speed} {later:?}");
            assert!((acceleration - later.acceleration_mps2).abs() < 2e-3, "{time}");
        }
        // v = 20 − 3·t, to standstill.
        let at = |t: f64| point(20.0 * t - 1.5 * t * t, 20.0 - 3.0 * t, -3.0);
        let falling =
            SpeedReference::from_points((0..=6).map(|k| at(f64::from(k))).collect(), false);
        for time in [0.5, 2.25, 4.0] {
            let [speed, acceleration] = falling.reference(at(time).distance_m, [preview, 0.15]);
            assert!((speed - at(time + 0.15).speed_mps).abs() < 1e-9, "{time}: {speed}");
            assert!((acceleration + 3.0).abs() < 1e-12);
        }
        assert_eq!(falling.reference(at(6.0).distance_m, [preview, 0.15])[0], 2.0);
    }
}
