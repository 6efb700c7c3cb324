//! A speed profile for people: time, speeds, and which limit binds on which share of the time.

use crate::terminal::console;
use steerwright_formats::{ProfileLimit, ProfileLimits, SpeedProfile};
use steerwright_report::Table;

/// Places that a row lists.
const PLACES: usize = 4;

pub(crate) fn summary(profile: &SpeedProfile) -> String {
    let speeds = profile.points.iter().map(|point| point.speed_mps);
    let largest = speeds.clone().fold(0.0, f64::max);
    let ends = profile.points.first().zip(profile.points.last());
    let length = ends.map_or(0.0, |(first, last)| last.distance_m - first.distance_m);
    let mut text = format!(
        "speed profile: {:.2} s, largest speed {largest:.2} m/s, mean {:.2} m/s",
        profile.time_s,
        length / profile.time_s,
    );
    if profile.limits.end_speeds_mps.is_none() {
        let least = speeds.fold(f64::INFINITY, f64::min);
        text += &format!(", smallest {least:.2} m/s; a lap ends as it begins");
    }
    let mut table = Table::new(["limit", "value", "binds", "at (m)"]);
    let mut bound = 0.0;
    for limit in ProfileLimit::ALL {
        let Some(value) = value(limit, &profile.limits) else { continue };
        let segments: Vec<_> = profile.binding.iter().filter(|s| s.limit == limit).collect();
        // The sum of none would be −0.
        let time = segments.iter().fold(0.0, |time, segment| time + segment.time_s);
        bound += time;
        let mut places: Vec<String> = segments
            .iter()
            .take(PLACES)
            .map(|segment| format!("{:.1}–{:.1}", segment.from_m, segment.to_m))
            .collect();
        if segments.len() > PLACES {
            places.push(format!("and {} more", segments.len() - PLACES));
        }
        let share = format!("{:.1} % of the time", 100.0 * time / profile.time_s);
        table.push([limit.name().replace('-', " "), value, share, places.join(", ")]);
    }
    let rest = 100.0 * (1.0 - bound / profile.time_s).max(0.0);
    format!("{text}\n{}\nno limit binds on {rest:.1} % of the time", console::table(&table))
}

/// The limit with its unit; `None` where it is not limited.
fn value(limit: ProfileLimit, limits: &ProfileLimits) -> Option<String> {
    let steering = limits.steering;
    Some(match limit {
        ProfileLimit::Speed => format!("{:.2} m/s", limits.max_speed_mps),
        ProfileLimit::LateralAcceleration => {
            format!("{:.2} m/s²", limits.max_lateral_acceleration_mps2)
        }
        ProfileLimit::Acceleration => format!("{:.2} m/s²", limits.max_acceleration_mps2),
        ProfileLimit::Deceleration => format!("{:.2} m/s²", limits.max_deceleration_mps2),
        ProfileLimit::Jerk => format!("{:.2} m/s³", limits.max_jerk_mps3?),
        ProfileLimit::Friction => format!("{:.2}", limits.friction?),
        ProfileLimit::SteeringAngle => format!("{:.1}°", steering?.max_angle_rad?.to_degrees()),
        ProfileLimit::SteeringRate => format!("{:.3} rad/s", steering?.max_rate_radps?),
    })
}
