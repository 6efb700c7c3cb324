//! A receiver's fixes in a drive, brought together with gyro and speed.

use super::drive::Drive;
use super::role::Role;
use super::series::Series;
use super::{DriveLog, LogOptions};
use crate::sideslip::{self, Piece, Receiver};

/// Radii of the Earth (WGS84), m, and its squared eccentricity.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;

impl DriveLog {
    /// Takes the sideslip of the drives where they have fixes; says so where those do not tell it.
    pub(super) fn take_sideslip(&mut self, drives: &[Drive], options: &LogOptions) {
        let mut pieces: Vec<Piece> = drives.iter().filter_map(|d| piece(d, options)).collect();
        if pieces.is_empty() {
            return;
        }
        let mut receiver = Receiver {
            latency_s: options.gnss_latency_s.unwrap_or(0.0),
            latency_error_s: 0.0,
            antenna_x_m: options.antenna_x_m,
        };
        if options.gnss_latency_s.is_none() {
            let parts = pieces.iter().flat_map(|p| parts(p, options)).collect::<Vec<_>>();
            receiver.latency_error_s = sideslip::UNKNOWN_ERROR_S;
            if let Some(age) = sideslip::age(&parts) {
                (receiver.latency_s, receiver.latency_error_s) = (age.seconds, age.standard_error);
                self.warnings.push(format!(
                    "the age of the fixes is not stated: {:.3} ± {:.3} s by the speed's changes on straights",
                    age.seconds,
                    2.0 * age.standard_error
                ));
            }
            let times = pieces.iter_mut().flat_map(|piece| &mut piece.fix_time);
            times.for_each(|time| *time -= receiver.latency_s);
        }
        let speed = self.speed.as_deref().unwrap_or_default();
        let mean = speed.iter().sum::<f64>() / speed.len().max(1) as f64;
        if speed.is_empty() && options.antenna_x_m != 0.0 {
            self.warnings.push("no sideslip: the antenna's place needs a speed".into());
            return;
        }
        let found = pieces.iter().flat_map(|p| parts(p, options)).collect::<Vec<_>>();
        match sideslip::sideslip(&found, receiver, mean) {
            Ok(found) => self.sideslip = Some(found),
            Err(why) => self.warnings.push(format!("no sideslip from the fixes: {why}")),
        }
    }
}

/// Gyro, speed and fixes of a drive; `None` where there are no fixes.
fn piece(drive: &Drive, options: &LogOptions) -> Option<Piece> {
    let place = |role| drive.places.iter().find(|c| c.role == role);
    let pairs = [(Role::East, Role::North), (Role::Longitude, Role::Latitude)];
    let (east, north) =
        pairs.into_iter().find_map(|(east, north)| Some((place(east)?, place(north)?)))?;
    let gyro = drive.channel(Role::YawRate)?;
    let speed = drive.channel(Role::Speed);
    let mut piece = Piece {
        time: gyro.time.to_vec(),
        yaw_rate: gyro.value.clone(),
        speed: speed.map_or_else(Vec::new, |s| gyro.time.iter().map(|t| at(s, *t)).collect()),
        ..Piece::default()
    };
    let mut last = None;
    for (time, fix) in fixes(east, north) {
        // A log of a faster clock repeats the last fix.
        if last != Some(fix) {
            piece.fix_time.push(time - options.gnss_latency_s.unwrap_or(0.0));
            piece.fix.push(fix);
            last = Some(fix);
        }
    }
    (!piece.fix.is_empty()).then_some(piece)
}

/// East and north of a first fix, m, where both coordinates were told at one instant.
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
fn at(series: &Series, time: f64) -> f64 {
    let after = series.time.partition_point(|t| *t < time);
    let (Some(before), true) = (after.checked_sub(1), after < series.time.len()) else {
        return series.value[after.min(series.value.len() - 1)];
    };
    let part = (time - series.time[before]) / (series.time[after] - series.time[before]);
    series.value[before] + part * (series.value[after] - series.value[before])
}

/// The parts of a piece within the windows and between gaps of the gyro.
fn parts(piece: &Piece, options: &LogOptions) -> Vec<Piece> {
    let wanted = |k: usize| {
        let time = piece.time[k];
        let within = |(from, to): &(f64, f64)| (*from..=*to).contains(&time);
        let slow_or_fast =
            |(low, high): (f64, f64)| piece.speed.get(k).is_some_and(|v| !(low..=high).contains(v));
        (options.windows.is_empty() || options.windows.iter().any(within))
            && !options.speed_window.is_some_and(slow_or_fast)
    };
    let mut parts: Vec<Piece> = Vec::new();
    let mut before = None;
    for k in 0..piece.time.len() {
        if !wanted(k) {
            before = None;
            continue;
        }
        let goes_on =
            before.is_some_and(|last: usize| piece.time[k] - piece.time[last] <= options.max_gap_s);
        if !goes_on {
            parts.push(Piece::default());
        }
        if let Some(part) = parts.last_mut() {
            part.time.push(piece.time[k]);
            part.yaw_rate.push(piece.yaw_rate[k]);
            part.speed.extend(piece.speed.get(k));
        }
        before = Some(k);
    }
    for part in &mut parts {
        let range = part.time[0]..=part.time[part.time.len() - 1];
        let own = piece.fix_time.iter().zip(&piece.fix).filter(|(t, _)| range.contains(t));
        (part.fix_time, part.fix) = own.map(|(t, fix)| (*t, *fix)).unzip();
    }
    parts
}
