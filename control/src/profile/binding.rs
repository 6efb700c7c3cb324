//! Which limit binds where along a profile, and the share of each limit that it needs.

use crate::profile::grid::Grid;
use crate::profile::pointwise::GRAVITY;
use crate::profile::problem::steering_rate;
use steerwright_formats::{BindingSegment, ProfileLimit, ProfileLimits, ProfilePoint};
use steerwright_models::SpeedReference;

/// A limit of which at least this share is used binds, where no other is used more.
const BINDS: f64 = 0.98;
/// Places in an interval at which the need is compared with the limits, as shares of it.
const PLACES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The largest share of a limit that a profile needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Excess {
    pub(super) limit: ProfileLimit,
    pub(super) share: f64,
    pub(super) distance_m: f64,
}

/// The segments on which one limit binds, and the largest share of any limit.
pub(super) fn binding(
    grid: &Grid,
    limits: &ProfileLimits,
    points: &[ProfilePoint],
) -> (Vec<BindingSegment>, Excess) {
    let reference = SpeedReference::from_points(points.to_vec(), grid.is_closed);
    let times = reference.times();
    let mut segments: Vec<BindingSegment> = Vec::new();
    let mut excess = Excess { limit: ProfileLimit::Speed, share: 0.0, distance_m: 0.0 };
    for (k, pair) in points.windows(2).enumerate() {
        let mut here = None;
        for place in PLACES {
            let need = Need::new(grid, k, place, pair, &reference);
            for (limit, share) in need.shares(limits) {
                if share > excess.share {
                    excess = Excess { limit, share, distance_m: need.distance };
                }
                let is_more = here.is_none_or(|(_, largest)| share > largest);
                if place == 0.5 && share >= BINDS && is_more {
                    here = Some((limit, share));
                }
            }
        }
        let Some((limit, _)) = here else { continue };
        let (from_m, to_m) = (pair[0].distance_m, pair[1].distance_m);
        let time_s = times[k + 1] - times[k];
        match segments.last_mut() {
            Some(last) if last.limit == limit && last.to_m == from_m => {
                last.to_m = to_m;
                last.time_s += time_s;
            }
            _ => segments.push(BindingSegment { limit, from_m, to_m, time_s }),
        }
    }
    (segments, excess)
}

/// The motion at a place of a profile.
struct Need {
    distance: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
    curvature: f64,
    slope: f64,
}

impl Need {
    fn new(
        grid: &Grid,
        interval: usize,
        place: f64,
        pair: &[ProfilePoint],
        reference: &SpeedReference,
    ) -> Self {
        let (a, b) = (pair[0], pair[1]);
        let length = b.distance_m - a.distance_m;
        // Within the interval: on its far end the reference would be that of the next.
        let distance = (a.distance_m + place * length).min(b.distance_m.next_down());
        let [speed, acceleration] = reference.at(distance);
        let jerk = if a.is_at_rest() || b.is_at_rest() {
            // s = j·t³/6 and v = j·t²/2.
            let end = a.speed_mps.max(b.speed_mps);
            2.0 * end * (end / (3.0 * length)).powi(2)
        } else {
            speed * (b.acceleration_mps2 - a.acceleration_mps2) / length
        };
        let slope = grid.slopes[interval];
        let curvature = grid.curvatures[interval] + place * length * slope;
        Self { distance, speed, acceleration, jerk, curvature, slope }
    }

    fn shares(&self, limits: &ProfileLimits) -> Vec<(ProfileLimit, f64)> {
        let (z, a) = (self.speed * self.speed, self.acceleration);
        let lateral = (z * self.curvature).abs();
        let mut all = vec![
            (ProfileLimit::Speed, self.speed / limits.max_speed_mps),
            (ProfileLimit::LateralAcceleration, lateral / limits.max_lateral_acceleration_mps2),
            (ProfileLimit::Acceleration, a / limits.max_acceleration_mps2),
            (ProfileLimit::Deceleration, -a / limits.max_deceleration_mps2),
        ];
        if let Some(jerk) = limits.max_jerk_mps3 {
            all.push((ProfileLimit::Jerk, self.jerk.abs() / jerk));
        }
        if let Some(friction) = limits.friction {
            all.push((ProfileLimit::Friction, lateral.hypot(a) / (friction * GRAVITY)));
        }
        if let Some(steering) = &limits.steering {
            if let Some(angle) = steering.max_angle_rad {
                let per_curvature =
                    steering.steering_per_curvature_radm + steering.understeer_gradient_rads2pm * z;
                let share = (per_curvature * self.curvature).abs() / angle;
                all.push((ProfileLimit::SteeringAngle, share));
            }
            if let Some(largest) = steering.max_rate_radps {
                let (rate, _) = steering_rate(steering, self.curvature, self.slope, z, a);
                all.push((ProfileLimit::SteeringRate, rate.abs() / largest));
            }
        }
        all
    }
}
