//! Fixes of a satellite receiver, and the selection of those that are good enough for a road.

use super::geodesy::wgs84_to_local;
use crate::Error;

/// Positions in a local plane, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedPoints {
    /// x, or east of the first point, m.
    pub x_m: Vec<f64>,
    /// y, or north of the first point, m.
    pub y_m: Vec<f64>,
    /// Warnings about rows that were left out or are doubtful.
    pub warnings: Vec<String>,
}

/// The use of fixes with too few satellites or without correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PoorFixes {
    /// Left out, with a warning.
    #[default]
    Refuse,
    /// Used, with a warning that names them.
    Mark,
}

/// The requirements on a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixOptions {
    /// Fewest satellites of a good fix.
    pub least_satellites: u32,
    /// Whether a good fix needs correction data (differential, RTK).
    pub correction: bool,
    /// The use of the others.
    pub poor: PoorFixes,
}

impl Default for FixOptions {
    fn default() -> Self {
        Self { least_satellites: 5, correction: true, poor: PoorFixes::Refuse }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quality {
    Invalid,
    /// From the receiver's signals alone, or estimated.
    Alone,
    /// With correction data.
    Corrected,
}

/// One fix; fields that the file does not state are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fix {
    pub(crate) line: u64,
    /// Degrees.
    pub(crate) latitude: f64,
    /// Degrees.
    pub(crate) longitude: f64,
    /// Above the ellipsoid, m.
    pub(crate) altitude: Option<f64>,
    pub(crate) quality: Option<Quality>,
    pub(crate) satellites: Option<u32>,
}

/// Lines that a warning names, at most.
const NAMED: usize = 5;

/// The good fixes, and the others as the options require, in a local plane.
pub(crate) fn choose(
    fixes: &[Fix],
    file: &str,
    options: &FixOptions,
) -> Result<RecordedPoints, Error> {
    let valid: Vec<Fix> =
        fixes.iter().copied().filter(|f| f.quality != Some(Quality::Invalid)).collect();
    let is_poor = |fix: &&Fix| {
        let few = fix.satellites.is_some_and(|n| n < options.least_satellites);
        few || (options.correction && fix.quality == Some(Quality::Alone))
    };
    let poor: Vec<u64> = valid.iter().filter(is_poor).map(|fix| fix.line).collect();
    let refused = options.poor == PoorFixes::Refuse;
    let kept: Vec<Fix> = valid.iter().filter(|f| !(refused && is_poor(f))).copied().collect();
    if kept.is_empty() {
        let (total, without) = (fixes.len(), fixes.len() - valid.len());
        return Err(Error::PoorFixes {
            file: file.into(),
            total,
            without,
            poor: poor.len(),
            least_satellites: options.least_satellites,
        });
    }
    let mut warnings = Vec::new();
    if valid.len() < fixes.len() {
        let count = fixes.len() - valid.len();
        warnings.push(format!("left out {count} of {} rows without a position", fixes.len()));
    }
    if !poor.is_empty() {
        let named: Vec<String> = poor.iter().take(NAMED).map(u64::to_string).collect();
        let more = if poor.len() > NAMED { " …" } else { "" };
        let correction = if options.correction { " or no correction" } else { "" };
        warnings.push(format!(
            "{} {} of {} fixes with fewer than {} satellites{correction} (lines {}{more})",
            if refused { "left out" } else { "used" },
            poor.len(),
            valid.len(),
            options.least_satellites,
            named.join(", "),
        ));
    }
    let column = |value: fn(&Fix) -> f64| kept.iter().map(value).collect::<Vec<f64>>();
    // Altitudes of some rows alone would be steps in height.
    let altitudes: Option<Vec<f64>> = kept.iter().map(|fix| fix.altitude).collect();
    let (x_m, y_m) =
        wgs84_to_local(&column(|f| f.latitude), &column(|f| f.longitude), altitudes.as_deref());
    Ok(RecordedPoints { x_m, y_m, warnings })
}

/// Rejects a position that is not on the globe.
pub(crate) fn check_position(latitude: f64, longitude: f64) -> Result<(), String> {
    for (name, value, limit) in [("latitude", latitude, 90.0), ("longitude", longitude, 360.0)] {
        if value.is_nan() {
            return Err(format!("the {name} is not a number"));
        }
        if value.abs() > limit {
            return Err(format!("the {name} is {value}, beyond ±{limit}"));
        }
    }
    Ok(())
}
