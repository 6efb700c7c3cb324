//! Recorded points from NMEA 0183: sentences GGA and RMC of any talker.
//!
//! `$ccGGA,hhmmss.ss,ddmm.mm,N,dddmm.mm,E,quality,satellites,hdop,altitude,M,separation,M,age,id*hh`
//! `$ccRMC,hhmmss.ss,status,ddmm.mm,N,dddmm.mm,E,knots,course,ddmmyy,…,mode*hh`
//!
//! A GGA and an RMC of one time of day are one fix: position, quality and satellites are GGA's, and
//! RMC's status must not contradict them. RMC alone has a quality, its mode (NMEA 2.3 on), and
//! no number of satellites. Other sentences are skipped, but every checksum must be right.

use super::fixes::{Fix, Quality, check_position};
use crate::Error;
use crate::error::point_fault;

/// A fix and its time of day, as written in the sentence.
struct Timed {
    time: String,
    fix: Fix,
    from_gga: bool,
}

/// The fixes of a recording, in its order.
pub(crate) fn fixes(text: &str, file: &str) -> Result<Vec<Fix>, Error> {
    let mut found: Vec<Timed> = Vec::new();
    for (index, raw) in text.lines().enumerate() {
        let line = index as u64 + 1;
        let sentence = raw.trim();
        if sentence.is_empty() || sentence.starts_with('#') {
            continue;
        }
        let fault = |column: usize, problem: String| point_fault(file)(line, column, problem);
        let fields =
            checked_fields(sentence).map_err(|(column, problem)| fault(column, problem))?;
        let kind = fields[0].get(2..).unwrap_or_default();
        let take = |n: usize| fields.get(n).copied().unwrap_or_default();
        let column = |n: usize| 2 + fields.iter().take(n).map(|f| f.len() + 1).sum::<usize>();
        let (first, quality, satellites, altitude) = match kind {
            "GGA" => {
                let quality = gga_quality(take(6)).map_err(|p| fault(column(6), p))?;
                let satellites = number(take(7), "number of satellites")
                    .map_err(|p| fault(column(7), p))?
                    .map(|n| n as u32);
                let altitude = number(take(9), "altitude").map_err(|p| fault(column(9), p))?;
                let above =
                    number(take(11), "geoid separation").map_err(|p| fault(column(11), p))?;
                (2, quality, satellites, altitude.map(|a| a + above.unwrap_or(0.0)))
            }
            "RMC" => {
                (3, rmc_quality(take(2), take(12)).map_err(|p| fault(column(2), p))?, None, None)
            }
            _ => continue,
        };
        let no_position = take(first).is_empty() || take(first + 2).is_empty();
        let (mut latitude, mut longitude) = (0.0, 0.0);
        if no_position {
            if quality != Quality::Invalid {
                return Err(fault(column(first), "the fix is valid but has no position".into()));
            }
        } else if quality != Quality::Invalid {
            latitude = angle(take(first), take(first + 1), ["N", "S"])
                .map_err(|p| fault(column(first), format!("the latitude is {p}")))?;
            longitude = angle(take(first + 2), take(first + 3), ["E", "W"])
                .map_err(|p| fault(column(first + 2), format!("the longitude is {p}")))?;
            check_position(latitude, longitude).map_err(|p| fault(column(first), p))?;
        }
        let quality = Some(quality);
        let fix = Fix { line, latitude, longitude, altitude, quality, satellites };
        join(&mut found, Timed { time: take(1).into(), fix, from_gga: kind == "GGA" });
    }
    if found.is_empty() {
        return Err(point_fault(file)(1, 1, "no sentence GGA or RMC".into()));
    }
    Ok(found.into_iter().map(|timed| timed.fix).collect())
}

/// Adds a fix, or joins it with the other sentence of its time.
fn join(found: &mut Vec<Timed>, new: Timed) {
    let other =
        found.iter_mut().rev().take(2).find(|old| {
            old.time == new.time && old.from_gga != new.from_gga && !new.time.is_empty()
        });
    let Some(old) = other else {
        found.push(new);
        return;
    };
    let invalid = [old.fix.quality, new.fix.quality].contains(&Some(Quality::Invalid));
    if new.from_gga {
        *old = new;
    }
    if invalid {
        old.fix.quality = Some(Quality::Invalid);
    }
}

/// The fields between `$` and `*`, the address first; else column and problem.
fn checked_fields(sentence: &str) -> Result<Vec<&str>, (usize, String)> {
    let Some(body) = sentence.strip_prefix(['$', '!']) else {
        return Err((1, "a sentence begins with `$`".into()));
    };
    let Some((data, stated)) = body.rsplit_once('*') else {
        return Err((sentence.len() + 1, "the sentence ends without a checksum".into()));
    };
    let sum = data.bytes().fold(0_u8, |sum, byte| sum ^ byte);
    let column = data.len() + 3;
    let stated = stated.trim();
    let digits = stated.len() == 2 && stated.bytes().all(|b| b.is_ascii_hexdigit());
    match u8::from_str_radix(stated, 16).ok().filter(|_| digits) {
        Some(stated) if stated == sum => Ok(data.split(',').collect()),
        Some(stated) => {
            Err((column, format!("the checksum is {stated:02X}, the sentence's is {sum:02X}")))
        }
        None => Err((column, format!("the checksum `{stated}` is not two hexadecimal digits"))),
    }
}

/// GGA's quality: 2 differential, 4 and 5 RTK; 0 none; the rest by the receiver alone or estimated.
fn gga_quality(field: &str) -> Result<Quality, String> {
    match field {
        "0" | "" => Ok(Quality::Invalid),
        "2" | "4" | "5" => Ok(Quality::Corrected),
        "1" | "3" | "6" | "7" | "8" => Ok(Quality::Alone),
        other => Err(format!("the fix quality is `{other}`, not 0 to 8")),
    }
}

/// RMC's status and, from NMEA 2.3 on, its mode.
fn rmc_quality(status: &str, mode: &str) -> Result<Quality, String> {
    match (status, mode) {
        ("V" | "", _) | ("A", "N") => Ok(Quality::Invalid),
        ("A", "D" | "F" | "R") => Ok(Quality::Corrected),
        ("A", _) => Ok(Quality::Alone),
        (other, _) => Err(format!("the status is `{other}`, not A or V")),
    }
}

/// A number that may be missing.
fn number(field: &str, what: &str) -> Result<Option<f64>, String> {
    if field.is_empty() {
        return Ok(None);
    }
    match field.parse::<f64>() {
        Ok(value) if value.is_finite() && value.abs() < 1e6 => Ok(Some(value)),
        _ => Err(format!("the {what} is `{field}`, not a number")),
    }
}

/// Degrees of `dddmm.mm` and its hemisphere.
fn angle(field: &str, side: &str, [positive, negative]: [&str; 2]) -> Result<f64, String> {
    let wrong =
        || format!("`{field},{side}`, not degrees and minutes with {positive} or {negative}");
    let sign = match side {
        s if s == positive => 1.0,
        s if s == negative => -1.0,
        _ => return Err(wrong()),
    };
    let whole = field.split('.').next().unwrap_or_default().len();
    let (degrees, minutes) = field.split_at_checked(whole.saturating_sub(2)).ok_or_else(wrong)?;
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if whole < 3 || !digits(degrees) || !digits(minutes) {
        return Err(wrong());
    }
    let degrees: f64 = degrees.parse().map_err(|_| wrong())?;
    let minutes: f64 = minutes.parse().map_err(|_| wrong())?;
    if minutes >= 60.0 {
        return Err(wrong());
    }
    Ok(sign * (degrees + minutes / 60.0))
}
