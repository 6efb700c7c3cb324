//! A receiver's fixes in a drive, brought together with gyro and speed.

use crate::drive::Drive;
use crate::options::LogOptions;
use crate::role::Role;
use crate::series::Series;
use std::ops::Range;

/// Radii of the Earth (WGS84), m, and its squared eccentricity.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;

/// The fixes of all drives of a log, and what is stated of the receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Gnss {
    /// Drives that have fixes.
    pub drives: Vec<GnssDrive>,
    /// Age of a fix at its stamp, s, where it is stated.
    pub latency_s: Option<f64>,
    /// The antenna ahead of the centre of gravity, m.
    pub antenna_x_m: f64,
}

/// Gyro and, where there is one, speed on one clock; fixes on their own, which has the same zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GnssDrive {
    /// Instants of the gyro's readings, s.
    pub time_s: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Speed at these instants, m/s; empty without a speed channel.
    pub speed_mps: Vec<f64>,
    /// Stamps of the fixes, s.
    pub fix_time_s: Vec<f64>,
    /// East and north of a first fix, m.
    pub fix_m: Vec<[f64; 2]>,
    /// The gyro's readings within the windows, between gaps.
    pub segments: Vec<Range<usize>>,
}

impl Gnss {
    pub(crate) fn from_drives(drives: &[Drive], options: &LogOptions) -> Option<Self> {
        let drives: Vec<_> = drives.iter().filter_map(|d| of_drive(d, options)).collect();
        let (latency_s, antenna_x_m) = (options.gnss_latency_s, options.antenna_x_m);
        if drives.is_empty() { None } else { Some(Self { drives, latency_s, antenna_x_m }) }
    }
}

/// Gyro, speed and fixes of a drive; `None` where there are no fixes.
fn of_drive(drive: &Drive, options: &LogOptions) -> Option<GnssDrive> {
    let place = |role| drive.places.iter().find(|c| c.role == role);
    let pairs = [(Role::East, Role::North), (Role::Longitude, Role::Latitude)];
    let (east, north) =
        pairs.into_iter().find_map(|(east, north)| Some((place(east)?, place(north)?)))?;
    let gyro = drive.channel(Role::YawRate)?;
    let speed = drive.channel(Role::Speed);
    let mut of = GnssDrive {
        time_s: gyro.time.to_vec(),
        yaw_rate_radps: gyro.value.clone(),
        speed_mps: match speed {
            Some(s) => gyro.time.iter().map(|t| value_at(s, *t)).collect(),
            None => Vec::new(),
        },
        ..GnssDrive::default()
    };
    let mut last = None;
    for (time, fix) in fixes(east, north) {
        // A log of a faster clock repeats the last fix.
        if last != Some(fix) {
            of.fix_time_s.push(time);
            of.fix_m.push(fix);
            last = Some(fix);
        }
    }
    of.segments = segments(&of, options);
    if of.fix_m.is_empty() { None } else { Some(of) }
}

/// East and north of a first fix, m, where both coordinates were reported at one instant.
fn fixes(east: &Series, north: &Series) -> Vec<(f64, [f64; 2])> {
    let mut pairs = Vec::new();
    let mut other = 0;
    for (time, x) in east.time.iter().zip(&east.value) {
        while other < north.time.len() && north.time[other] < *time {
            other += 1;
        }
        if north.time.get(other) == Some(time) {
            pairs.push((*time, [*x, north.value[other]]));
        }
    }
    if east.role == Role::East {
        return pairs;
    }
    let Some(&(_, [longitude0, latitude0])) = pairs.first() else { return pairs };
    // A plane at the first fix: over a kilometre its directions turn by less than 0.2 mrad.
    let w = 1.0 - ECCENTRICITY_SQUARED * latitude0.sin().powi(2);
    let across = SEMI_MAJOR_M / w.sqrt();
    let along = SEMI_MAJOR_M * (1.0 - ECCENTRICITY_SQUARED) / (w * w.sqrt());
    for (_, [longitude, latitude]) in &mut pairs {
        *longitude = (*longitude - longitude0) * across * latitude.cos();
        *latitude = (*latitude - latitude0) * along;
    }
    pairs
}

/// The value of a series at an instant, by a straight line, held beyond its ends.
fn value_at(series: &Series, time: f64) -> f64 {
    let after = series.time.partition_point(|t| *t < time);
    let (Some(before), true) = (after.checked_sub(1), after < series.time.len()) else {
        return series.value[after.min(series.value.len() - 1)];
    };
    let part = (time - series.time[before]) / (series.time[after] - series.time[before]);
    series.value[before] + part * (series.value[after] - series.value[before])
}

/// The readings within the windows, split at gaps of the gyro.
fn segments(of: &GnssDrive, options: &LogOptions) -> Vec<Range<usize>> {
    let wanted = |k: usize| {
        let within = |(from, to): &(f64, f64)| (*from..=*to).contains(&of.time_s[k]);
        let slow_or_fast = |(low, high): (f64, f64)| {
            of.speed_mps.get(k).is_some_and(|v| !(low..=high).contains(v))
        };
        (options.windows.is_empty() || options.windows.iter().any(within))
            && !options.speed_window.is_some_and(slow_or_fast)
    };
    let mut segments: Vec<Range<usize>> = Vec::new();
    for k in (0..of.time_s.len()).filter(|k| wanted(*k)) {
        match segments.last_mut() {
            Some(last) if last.end == k && of.time_s[k] - of.time_s[k - 1] <= options.max_gap_s => {
                last.end = k + 1;
            }
            _ => segments.push(k..k + 1),
        }
    }
    segments
}
