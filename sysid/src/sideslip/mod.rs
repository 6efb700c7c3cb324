//! The sideslip in a drive, `β = (S + Q·a²)·r + C·ṙ` with `a = v·r`, from where a receiver's fixes
//! lead (docs/methods/sideslip.md).
//!
//! Yaw and bias of each 10 s are taken out of both sides (Frisch and Waugh), and standard errors
//! are those of clusters of 10 s (Liang and Zeger 1986), since segments that overlap share fixes.
//! Of a term that is nothing, ten clusters take one in thirty for something (Student's t of nine
//! degrees of freedom; Cameron and Miller 2015), and then it is small; Akaike's criterion would
//! take more, from √2 standard errors. The standard error of a fix's age is one of S (and τ²/2 −
//! τ·S of C, and τ·v₀/2 of b).
//!
//! A drive with varying speed also determines b of `S(v) = b/v − κ·v`; S is then that of the mean speed v₀. Of another
//! drive b is that of usual tyres and of the wheelbase.

mod age;
mod assumed;
mod displacements;
mod regression;
mod tyres;

use crate::data::moving::wheelbase_of_log;
use crate::sideslip::age::{Age, UNKNOWN_ERROR_S, age};
use crate::sideslip::assumed::assumed_distance;
use crate::sideslip::displacements::{
    ACCELERATION, BLOCK_S, BRAKING, DISTANCE, DisplacementSegment, GROWTH, LEAST_BLOCKS, RATE,
    SEGMENT_S, SHORT_SEGMENT_S, SideslipPiece, TERMS, blocks,
};
use crate::sideslip::regression::{Regression, robust};
use crate::sideslip::tyres::take_usual_tyres;
use steerwright_drivelog::{DriveLog, Gnss, GnssDrive};
use steerwright_formats::{
    Grade, Quality, Reason, ReasonCode, Sideslip, SideslipTerm, VehicleData,
};

/// So many standard errors from its default, a term is significant.
const SIGNIFICANT: f64 = 2.5;

/// The largest standard error of a sideslip, s: 3 mrad in a turn of 4 m/s² at 15 m/s.
pub(crate) const LARGEST_ERROR_S: f64 = 0.01;

/// A stated age of the fixes that is off by less is right, s.
const LARGEST_AGE_ERROR_S: f64 = 0.02;

/// The same of each term: of Q in that turn, of C where it is reached within half a second, of b/v₀ at half
/// and at twice the speed v₀. The effect of braking is not stated.
const LARGEST_ERROR: [f64; TERMS] = [
    LARGEST_ERROR_S,
    LARGEST_ERROR_S / 16.0,
    LARGEST_ERROR_S / 2.0,
    LARGEST_ERROR_S / 1.5,
    f64::INFINITY,
];

/// The sideslip that the fixes of a log determine, and what is to be reported of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FromFixes {
    /// The sideslip, where the fixes determine it.
    pub sideslip: Option<Sideslip>,
    /// The age that was found for the fixes; why there is no sideslip.
    pub warnings: Vec<String>,
    /// The reason against a model of fixes whose stated age is wrong, with advice.
    pub fault: Option<(Reason, String)>,
}

impl FromFixes {
    /// The quality with that reason.
    pub(crate) fn graded(&self, quality: Quality) -> Quality {
        match self.fault.clone() {
            Some((reason, advice)) => quality.with_reason(reason, advice),
            None => quality,
        }
    }
}

/// The sideslip of the drives of a log that have fixes.
#[must_use]
pub fn sideslip(log: &DriveLog) -> FromFixes {
    let mut all = FromFixes::default();
    let Some(gnss) = &log.gnss else { return all };
    let mut latency = gnss.latency_s.map_or((0.0, UNKNOWN_ERROR_S), |stated| (stated, 0.0));
    let found_age = age(&pieces(gnss, 0.0));
    if let (Some(stated), Some(age)) = (gnss.latency_s, found_age) {
        all.fault = wrong_age(stated, &age);
    }
    if let (None, Some(age)) = (gnss.latency_s, found_age) {
        latency = (age.seconds, age.standard_error);
        let error = 2.0 * age.standard_error;
        let found = if age.seconds.abs() > error {
            format!("{:.3} ± {error:.3} s", age.seconds)
        } else {
            format!("at most {:.3} s", age.seconds + error)
        };
        all.warnings.push(format!(
            "the age of the fixes is not stated: {found} by the speed's changes on straights"
        ));
    }
    let speed = log.speed.as_deref().unwrap_or_default();
    let mean = speed.iter().sum::<f64>() / speed.len().max(1) as f64;
    if speed.is_empty() && gnss.antenna_x_m != 0.0 {
        all.warnings.push("no sideslip: the antenna's place needs a speed".into());
        return all;
    }
    match of_pieces(&pieces(gnss, latency.0), latency, gnss.antenna_x_m, mean) {
        Ok(mut found) => {
            if found.distance_rear_m.is_none()
                && let Some(term) = assumed_distance(&found, mean, wheelbase_of_log(log))
            {
                found.distance_rear_m = Some(term);
                all.warnings.push(format!(
                    "the speed changes too little to determine the distance to the rear axle, on which the sideslip at other speeds depends: {:.2} ± {:.2} m, by usual tyres and the steering",
                    term.value,
                    2.0 * term.standard_error
                ));
            }
            all.sideslip = Some(found);
        }
        Err(why) => all.warnings.push(format!("no sideslip from the fixes: {why}")),
    }
    all
}

/// The reason against a stated age, s, that the speed's changes contradict.
fn wrong_age(stated: f64, found: &Age) -> Option<(Reason, String)> {
    let error = 2.0 * found.standard_error;
    let limit = LARGEST_AGE_ERROR_S.max(1.5 * error);
    let difference = (found.seconds - stated).abs();
    if difference > limit {
        let message = format!(
            "the fixes are {:.3} ± {error:.3} s old by the speed's changes on straights, not {stated:.3} s as stated",
            found.seconds
        );
        let reason = Reason::new(ReasonCode::AgeOfFixes, Grade::Warn, message);
        let advice = "the pose of an estimator with this age is off in turns: state the age of the fixes (--gnss-latency), or leave it to the drive";
        Some((reason.compared(difference, limit, "s"), advice.into()))
    } else {
        None
    }
}

/// The warning about fixes that a log has in vain, for a reason.
#[must_use]
pub fn unused_fixes(log: &DriveLog, reason: &str) -> Option<String> {
    log.gnss.as_ref().map(|_| format!("the GNSS fixes are not used: {reason}"))
}

/// The warning where the sideslip of a bicycle is another one than that of the fixes.
pub(crate) fn other_sideslip(vehicle: &VehicleData, found: &Sideslip) -> Option<String> {
    let speed = found.speed_mps?;
    let (a, b) = (vehicle.distance_front_m, vehicle.distance_rear_m);
    let rear_slip = vehicle.mass_kg * a / (vehicle.cornering_stiffness_rear_npr * (a + b));
    let own = b / speed - rear_slip * speed;
    let (measured, error) = (found.sideslip_per_yaw_rate_s, found.standard_error_s);
    let is_other = (own - measured).abs() > LARGEST_ERROR_S.max(3.0 * error);
    if is_other {
        Some(format!(
            "the fixes state {:.0} ± {:.0} ms of sideslip per yaw rate at {speed:.1} m/s, the yaw rate's model {:.0} ms: paths and estimators use that of the fixes, positions that the model simulates that of the model",
            1e3 * measured,
            2e3 * error,
            1e3 * own
        ))
    } else {
        None
    }
}

/// The segments of all drives, with the fixes that were valid in each.
fn pieces(gnss: &Gnss, latency_s: f64) -> Vec<SideslipPiece> {
    let of_drive = |drive: &GnssDrive| -> Vec<SideslipPiece> {
        let fixes = || drive.fix_time_s.iter().map(|time| time - latency_s).zip(&drive.fix_m);
        let piece = |range: &std::ops::Range<usize>| {
            let time = drive.time_s[range.clone()].to_vec();
            let span = time[0]..=time[time.len() - 1];
            let (fix_time, fix) = fixes().filter(|(t, _)| span.contains(t)).unzip();
            let yaw_rate = drive.yaw_rate_radps[range.clone()].to_vec();
            let speed = drive.speed_mps.get(range.clone()).unwrap_or_default().to_vec();
            SideslipPiece { time, yaw_rate, speed, fix_time, fix }
        };
        drive.segments.iter().map(piece).collect()
    };
    gnss.drives.iter().flat_map(of_drive).collect()
}

/// The sideslip of the pieces, or why they do not determine it, for fixes of a latency with its standard
/// error (0 where it is stated), s. `speed` is their mean, m/s.
fn of_pieces(
    pieces: &[SideslipPiece],
    (gnss_latency_s, latency_error_s): (f64, f64),
    antenna_x_m: f64,
    speed: f64,
) -> Result<Sideslip, String> {
    let segments = cut(pieces, SEGMENT_S, None);
    let Some(alone) = robust(&segments, &[RATE]) else {
        return Err(format!(
            "{:.0} s of fixes while driving are too few: {:.0} s are needed",
            segments.len() as f64 * BLOCK_S,
            LEAST_BLOCKS as f64 * BLOCK_S
        ));
    };
    // Without a speed there is no lateral acceleration.
    let known = speed > 0.0 && pieces.iter().all(|piece| !piece.speed.is_empty());
    let over_speed = || {
        let found =
            estimated(pieces, &[RATE, DISTANCE, GROWTH, ACCELERATION, BRAKING], Some(speed))?;
        let value = found.values[DISTANCE] * speed - antenna_x_m;
        let standard_error = found.error(DISTANCE).hypot(0.5 * latency_error_s) * speed;
        let is_certain = standard_error <= LARGEST_ERROR[DISTANCE] * speed;
        let distance = SideslipTerm { value, standard_error };
        if value > 0.0 && is_certain { Some((found, distance)) } else { None }
    };
    let (found, distance_rear_m) = if let Some((found, distance)) = known.then(over_speed).flatten()
    {
        (found, Some(distance))
    } else {
        // A drive without a turn has none.
        let error = alone.error(RATE);
        if error.is_nan() || error > LARGEST_ERROR_S {
            return Err(format!(
                "its standard error would be {error:.3} s, above {LARGEST_ERROR_S} s: drive more turns, \
                 or with better fixes"
            ));
        }
        let candidates: &[usize] =
            if known { &[RATE, GROWTH, ACCELERATION] } else { &[RATE, ACCELERATION] };
        (estimated(pieces, candidates, None).unwrap_or(alone), None)
    };
    let error = found.error(RATE).hypot(latency_error_s);
    if error > LARGEST_ERROR_S {
        return Err(format!(
            "the age of the fixes is not stated, and known to ±{:.3} s only, so the standard error of \
             the sideslip would be {error:.3} s, above {LARGEST_ERROR_S} s: state the age, or drive \
             straights with changing speed",
            2.0 * latency_error_s
        ));
    }
    let of_antenna = if speed > 0.0 { antenna_x_m / speed } else { 0.0 };
    let term = |i: usize| {
        let (value, standard_error) = (found.values[i], found.error(i));
        if standard_error > 0.0 { Some(SideslipTerm { value, standard_error }) } else { None }
    };
    Ok(Sideslip {
        speed_mps: Some(speed).filter(|speed| *speed > 0.0),
        sideslip_per_yaw_rate_s: found.values[RATE] - of_antenna,
        standard_error_s: error,
        sideslip_growth_s5pm2: term(GROWTH),
        sideslip_per_yaw_acceleration_s2: term(ACCELERATION),
        distance_rear_m,
        gnss_latency_s,
        gnss_latency_standard_error_s: Some(latency_error_s).filter(|e| *e > 0.0),
        antenna_x_m,
    })
}

/// The segments of a length (s) of all pieces, by blocks.
fn cut(
    pieces: &[SideslipPiece],
    length: f64,
    reference_speed: Option<f64>,
) -> Vec<Vec<DisplacementSegment>> {
    pieces.iter().flat_map(|piece| blocks(piece, length, reference_speed)).collect()
}

/// S and the significant ones of the candidates, constant or following the speed from a reference speed
/// (m/s); `None` where only S is, or where b of a following S is not. Where S follows the speed, the slip of the rear
/// tyres is known, and with it Q and C of usual ones.
fn estimated(
    pieces: &[SideslipPiece],
    candidates: &[usize],
    reference_speed: Option<f64>,
) -> Option<Regression> {
    let fit = |length: f64, terms: &[usize]| {
        let mut found = robust(&cut(pieces, length, reference_speed), terms)?;
        if let Some(speed) = reference_speed {
            take_usual_tyres(&mut found, speed);
        }
        Some(found)
    };
    let is_known = |term| reference_speed.is_some() && (term == GROWTH || term == ACCELERATION);
    let (terms, found) =
        significant_terms(&|terms: &[usize]| fit(SEGMENT_S, terms), candidates, &is_known)?;
    if reference_speed.is_some() && !terms.contains(&DISTANCE) {
        return None;
    }
    match fit(SHORT_SEGMENT_S, &terms) {
        Some(shorter) if is_certain(&shorter, &terms) => Some(shorter),
        _ => Some(found),
    }
}

/// The significant terms in addition to S and to those that are known; `None` where there are none.
fn significant_terms(
    fit: &dyn Fn(&[usize]) -> Option<Regression>,
    candidates: &[usize],
    is_known: &dyn Fn(usize) -> bool,
) -> Option<(Vec<usize>, Regression)> {
    let mut wanted = candidates.to_vec();
    while wanted.len() > 1 {
        let found = fit(&wanted)?;
        // How many standard errors it is from what it is otherwise taken for.
        let distance = |&term: &usize| {
            let (value, error) = (found.values[term], found.error(term));
            let away = match term {
                _ if is_known(term) => f64::INFINITY,
                // An S that does not change with the speed: b/v₀ is S/2.
                DISTANCE => (value - 0.5 * found.values[RATE]).abs(),
                _ => value.abs(),
            };
            let away = away / error;
            if away.is_nan() || error > LARGEST_ERROR[term] { 0.0 } else { away }
        };
        let distances: Vec<f64> = wanted[1..].iter().map(distance).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        if least >= SIGNIFICANT {
            return if is_certain(&found, &wanted) { Some((wanted, found)) } else { None };
        }
        let place = distances.iter().position(|d| *d == least)?;
        wanted.remove(1 + place);
    }
    None
}

fn is_certain(found: &Regression, terms: &[usize]) -> bool {
    terms.iter().all(|&term| found.error(term) <= LARGEST_ERROR[term])
}
