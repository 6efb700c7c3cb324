//! Sentences that several sections have.

use super::value;
use steerwright_formats::{HeldOut, Sideslip, SideslipTerm};

/// Names, and what there is to state of each.
pub(super) type Facts = Vec<(String, String)>;

/// How the validation data were chosen, and the fit that noise allows there.
pub(super) fn validation_data(held_out: &HeldOut) -> String {
    let chosen_by = match held_out.selection.as_str() {
        "excited-blocks" => {
            "blocks chosen for their excitation, since the end of the log is not excited"
        }
        "speed-blocks" => "blocks of the whole drive, since the speed varies",
        "windows" => "windows of accumulated drives",
        _ => "the end of the log",
    };
    match held_out.fit_bound {
        Some(bound) => {
            format!("{chosen_by}; noise allows a fit of {bound:.1} % at most there")
        }
        None => chosen_by.into(),
    }
}

/// A fit or a share.
pub(super) fn percent(percent: f64) -> String {
    // Below −100 % only the sign of a fit means anything.
    if percent < -100.0 { "−100 % or less".into() } else { value(percent, 2, "%") }
}

/// A fit with twice its standard error, about 95 %, or why there is none.
pub(super) fn with_error(fit: f64, standard_error: Option<f64>, without: String) -> String {
    match standard_error {
        Some(error) => format!("{fit:.2} ± {:.2} %", 2.0 * error),
        None => format!("{} (no ±: {without})", percent(fit)),
    }
}

/// The sideslip that fixes determine, in lines; `speed_mps` is that of the model, for a sideslip that states none.
pub(super) fn sideslip_in_words(s: &Sideslip, speed_mps: f64) -> Vec<String> {
    let (value, error) = (s.sideslip_per_yaw_rate_s, 2.0 * s.standard_error_s);
    let latency = match s.gnss_latency_standard_error_s {
        Some(e) => not_negative(s.gnss_latency_s, 2.0 * e, 3, ""),
        None => s.gnss_latency_s.to_string(),
    };
    let mut lines =
        vec![format!("{value:.4} ± {error:.4} s per yaw rate, with fixes {latency} s old")];
    if let Some(SideslipTerm { value, standard_error }) = s.sideslip_growth_s5pm2 {
        let (value, error) = (1e3 * value, 2e3 * standard_error);
        lines
            .push(format!("{value:+.2} ± {error:.2} ms of it per (m/s²)² of lateral acceleration"));
    }
    if let Some(SideslipTerm { value, standard_error }) = s.sideslip_per_yaw_acceleration_s2 {
        let error = 2.0 * standard_error;
        lines.push(format!("{value:.4} ± {error:.4} s2 per yaw acceleration"));
    }
    if let Some(SideslipTerm { value, standard_error }) = s.distance_rear_m {
        let (speed, error) = (s.speed_mps.unwrap_or(speed_mps), 2.0 * standard_error);
        lines.push(format!(
            "all at {speed:.1} m/s; {value:.2} ± {error:.2} m from centre of gravity to rear axle"
        ));
    }
    lines
}

/// A quantity that should not be negative with its error; where the error reaches zero, the upper end alone.
pub(super) fn not_negative(value: f64, error: f64, digits: usize, unit: &str) -> String {
    if value.abs() > error {
        format!("{value:.digits$} ± {error:.digits$}{unit}")
    } else {
        format!("at most {:.digits$}{unit}", value + error)
    }
}
