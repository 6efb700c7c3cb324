//! `path.json`: a reference road in arc length, with guidance parameters.

use crate::controllers::{GuidanceEntry, check_speeds};
use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts};
use crate::is_zero;
use crate::provenance::Provenance;
use crate::speed_profile::SpeedProfile;
use serde::{Deserialize, Serialize};

/// A reference path: points in arc length, x and y in a local plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Path {
    /// `steerwright/path/1`.
    pub schema: String,
    /// A name.
    pub name: String,
    /// Whether the last point meets the first.
    pub closed: bool,
    /// The guidance of a vehicle along it.
    pub guidance: Guidance,
    /// Parameters of the guidance over speed, at increasing speeds; linear between them and constant beyond the
    /// ends. Empty or omitted if those of `guidance` hold at every speed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub schedule: Vec<GuidanceEntry>,
    /// The speed for which the path was computed, m/s.
    pub speed_mps: f64,
    /// At least two, at increasing distance.
    pub points: Vec<PathPoint>,
    /// The speed along it; absent if it is driven at `speed_mps`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<SpeedProfile>,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// One point, in the file an array `[distance_m, x_m, y_m, heading_rad, curvature_per_m]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 5]", into = "[f64; 5]")]
pub struct PathPoint {
    /// Arc length from the first point, m.
    pub distance_m: f64,
    /// Position, m.
    pub x_m: f64,
    /// Position, m.
    pub y_m: f64,
    /// Heading, rad, not wrapped along the path.
    pub heading_rad: f64,
    /// Curvature, 1/m, positive to the left.
    pub curvature_per_m: f64,
}

impl From<[f64; 5]> for PathPoint {
    fn from([distance_m, x_m, y_m, heading_rad, curvature_per_m]: [f64; 5]) -> Self {
        Self { distance_m, x_m, y_m, heading_rad, curvature_per_m }
    }
}

impl From<PathPoint> for [f64; 5] {
    fn from(p: PathPoint) -> Self {
        [p.distance_m, p.x_m, p.y_m, p.heading_rad, p.curvature_per_m]
    }
}

/// Parameters of the guidance law (look-ahead based line of sight).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guidance {
    /// Look-ahead distance over speed, s.
    pub lookahead_time_s: f64,
    /// Smallest look-ahead distance, m.
    pub lookahead_min_m: f64,
    /// Preview time of heading and curvature, s, which compensates for the loop's lag.
    pub preview_time_s: f64,
    /// Steering angle per curvature, rad·m.
    pub feedforward_gain_radm: f64,
    /// Sideslip angle per yaw rate in a steady turn, s; at small lateral acceleration if the growth is
    /// stated.
    pub sideslip_per_yaw_rate_s: f64,
    /// Sideslip angle per yaw acceleration, s²; 0 or omitted if unknown.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_per_yaw_acceleration_s2: f64,
    /// Growth of the sideslip per yaw rate, per squared lateral acceleration, s⁵/m²; 0 or omitted if
    /// unknown.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_growth_s5pm2: f64,
    /// Distance from centre of gravity to rear axle, m, by which the sideslip follows the speed from that at
    /// `speed_mps`; 0 or omitted if unknown, which keeps the sideslip per yaw rate at all speeds.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub distance_rear_m: f64,
    /// Gain from the path's yaw acceleration to the yaw reference, s², which compensates for the error
    /// of the loop that remains with preview and feedforward; 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_acceleration_gain_s2: f64,
    /// Gain from the path's yaw jerk to the yaw reference, s³, for the same; 0 may be omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_jerk_gain_s3: f64,
    /// Time in which the sideslip per yaw rate is corrected by the cross-track error of turns, s; 0 or omitted for no
    /// correction.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sideslip_correction_time_s: f64,
    /// Integral gain of the cross-track error, 1/s; 0 or omitted for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cross_track_integral_gain_per_s: f64,
    /// Preview time of the speed profile, s, which compensates for lag and delay of the drive; 0 or omitted for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub speed_preview_time_s: f64,
    /// The same where the profile decelerates, s, for those of the brake.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub brake_preview_time_s: f64,
}

impl Default for Guidance {
    fn default() -> Self {
        Self {
            lookahead_time_s: 1.0,
            lookahead_min_m: 5.0,
            preview_time_s: 0.0,
            feedforward_gain_radm: 0.0,
            sideslip_per_yaw_rate_s: 0.0,
            sideslip_per_yaw_acceleration_s2: 0.0,
            sideslip_growth_s5pm2: 0.0,
            distance_rear_m: 0.0,
            yaw_acceleration_gain_s2: 0.0,
            yaw_jerk_gain_s3: 0.0,
            sideslip_correction_time_s: 0.0,
            cross_track_integral_gain_per_s: 0.0,
            speed_preview_time_s: 0.0,
            brake_preview_time_s: 0.0,
        }
    }
}

impl Document for Path {
    const SCHEMA: &'static str = "steerwright/path/1";

    fn check(&self, c: &mut Checker) {
        let g = &self.guidance;
        c.not_negative(g.lookahead_time_s, "guidance.lookahead_time_s");
        c.positive(g.lookahead_min_m, "guidance.lookahead_min_m");
        c.not_negative(g.preview_time_s, "guidance.preview_time_s");
        check_fields!(c.finite(g, "guidance."): feedforward_gain_radm sideslip_per_yaw_rate_s
            sideslip_per_yaw_acceleration_s2 sideslip_growth_s5pm2 yaw_acceleration_gain_s2
            yaw_jerk_gain_s3);
        check_fields!(c.not_negative(g, "guidance."): distance_rear_m
            sideslip_correction_time_s cross_track_integral_gain_per_s speed_preview_time_s
            brake_preview_time_s);
        check_speeds(c, self.schedule.iter().map(|entry| entry.speed_mps));
        for (i, entry) in self.schedule.iter().enumerate() {
            entry.check(c, &format!("schedule[{i}]."));
        }
        c.positive(self.speed_mps, "speed_mps");
        c.require(self.points.len() >= 2, "points", || {
            format!("{} points, a path needs at least 2", self.points.len())
        });
        let mut before = f64::NEG_INFINITY;
        for (i, point) in self.points.iter().enumerate() {
            for (j, value) in <[f64; 5]>::from(*point).into_iter().enumerate() {
                c.finite(value, &format!("points[{i}][{j}]"));
            }
            c.require(point.distance_m > before, &format!("points[{i}][0]"), || {
                format!("distance {} does not increase (before it {before})", point.distance_m)
            });
            before = point.distance_m;
        }
        if let Some(profile) = &self.profile
            && let (Some(first), Some(last)) = (self.points.first(), self.points.last())
        {
            profile.check(c, [first.distance_m, last.distance_m], self.closed);
        }
    }
}

impl Described for Path {
    fn facts(self) -> Facts {
        let ends = self.points.first().zip(self.points.last());
        let length = ends.map_or(0.0, |(first, last)| last.distance_m - first.distance_m);
        let mut facts = vec![
            Fact::new("length", length, "m"),
            Fact::new("points", self.points.len(), ""),
            Fact::new("closed", self.closed, ""),
            Fact::new("speed", self.speed_mps, "m/s"),
        ];
        if let Some(profile) = &self.profile {
            facts.push(Fact::new("time_of_profile", profile.time_s, "s"));
        }
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
