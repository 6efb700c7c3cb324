//! The log, the model and the evidence for it.

use super::words::percent;
use super::{significant, value};
use crate::figures::{self, DEG, text};
use crate::read::Traces;
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    ChannelSummary, DataFactor, Evidence, FactorMethod, Model, OrderRow, Plant, Provenance,
};

/// The channels of the log.
pub(crate) fn log(model: &Model, traces: Option<&Traces>) -> Section {
    let mut blocks = vec![Block::Table(channel_table(model.channels()))];
    blocks.extend(model.provenance().and_then(start_in_words).map(Block::Text));
    if let Some(traces) = traces {
        let caption = "What was recorded, on the clock of the identification. Yaw is the integral \
                       of the measured yaw rate.";
        blocks.push(Block::figure(figures::drive(traces), 600, caption));
    }
    Section::new("The log", blocks)
}

/// The channels of a log, with their ranges.
pub fn channel_table(channels: &[ChannelSummary]) -> Table {
    let headers =
        ["channel", "column", "read as", "rows", "rate (Hz)", "least", "mean", "largest", "in"];
    let mut table = Table::new(headers);
    for c in channels {
        let (factor, unit) = shown_in(c).unwrap_or((1.0, &c.unit));
        let shown = |number: f64| match shown_in(c) {
            Some(_) => text(factor * number, 2),
            None => significant(number),
        };
        table.push([
            c.role.clone(),
            c.column.clone(),
            c.unit.clone(),
            c.rows.to_string(),
            text(c.rate_hz, 1),
            shown(c.min),
            shown(c.mean),
            shown(c.max),
            unit.to_owned(),
        ]);
    }
    table
}

/// The information of the log by frequency.
pub(crate) fn information(e: &Evidence) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !e.excitation.coherence.is_empty() {
        let caption = "Coherence is the share of the yaw rate that steering explains linearly, by \
                       frequency. Above the limit the log does not determine a model.";
        blocks.push(Block::figure(figures::coherence(&e.excitation), 330, caption));
    }
    blocks.extend(super::evidence::bands(e));
    blocks
}

/// When the log starts on its own clock, where that is not at 0: all times are counted from there.
fn start_in_words(provenance: &Provenance) -> Option<String> {
    let starts = provenance.options.get("log_start_s")?;
    let starts: Vec<String> = starts
        .split("; ")
        .map(|start| {
            let date = match start.parse().ok().and_then(utc) {
                Some(d) => format!(" ({d})"),
                None => String::new(),
            };
            format!("{start} s{date}")
        })
        .collect();
    Some(format!(
        "Time counts from the first sample, which is at {} on the log's clock.",
        starts.join(" and ")
    ))
}

/// A time since 1970 as a date, where it is one of these decades.
fn utc(seconds: f64) -> Option<String> {
    if !(9e8..4e9).contains(&seconds) {
        return None;
    }
    let (days, of_day) = ((seconds / 86_400.0) as i64, seconds.rem_euclid(86_400.0) as i64);
    // Days from 1 March of the year 0, so that a leap day is the last of its year (Hinnant, 2013).
    let since = days + 719_468;
    let (era, day) = (since / 146_097, since % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let from_march = (5 * day + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year + 400 * era + i64::from(month <= 2);
    let day = day - (153 * from_march + 2) / 5 + 1;
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    Some(format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02} UTC"))
}

/// Channels are kept in SI; people read degrees. `None` for a channel in a unit of its own.
fn shown_in(c: &ChannelSummary) -> Option<(f64, &'static str)> {
    Some(match c.role.as_str() {
        "steering" | "yaw" | "heading" | "roll" | "sideslip" => (DEG, "deg"),
        "yaw_rate" => (DEG, "deg/s"),
        "speed" | "lateral_velocity" => (1.0, "m/s"),
        "lateral_acceleration" | "longitudinal_acceleration" => (1.0, "m/s²"),
        _ => return None,
    })
}

/// How the order was chosen.
pub(super) fn orders(rows: &[OrderRow], chosen: usize) -> Vec<Block> {
    if rows.is_empty() {
        return Vec::new();
    }
    let caption = "Singular values of the chosen method and horizon: a gap after the n-th, and \
                   a validation fit that no longer rises, indicate order n. The fits are those \
                   of each order's own best method and horizon, refined. The order with the \
                   least criterion on the estimation data is chosen.";
    let headers =
        ["order", "singular value", "estimation fit", "validation fit", "as estimated", ""];
    let mut table = Table::new(headers);
    for row in rows {
        table.push([
            row.order.to_string(),
            match row.singular_value {
                Some(value) => significant(value),
                None => "–".into(),
            },
            percent(row.estimation_fit),
            percent(row.validation_fit),
            if row.stable { "stable" } else { "unstable" }.into(),
            if row.order == chosen { "chosen" } else { "" }.into(),
        ]);
    }
    vec![
        Block::figure(figures::order_table(rows, chosen), 320, caption),
        Block::Details(vec![Block::Table(table)]),
    ]
}

/// The conditioning of the data, the excitation, and how the model was converted.
pub(super) fn details(plant: &Plant) -> Vec<Block> {
    let e = &plant.evidence;
    let x = &e.excitation;
    let mut facts: Vec<_> =
        e.factor.iter().map(|f| Block::fact("factor", factor_in_words(f))).collect();
    facts.push(Block::fact(
        "excitation",
        format!(
            "{} of the road wheel and {} of the yaw rate (standard deviations); the innovation is {} of the yaw rate",
            value(x.road_wheel_std_rad * DEG, 2, "deg"),
            value(x.yaw_rate_std_radps * DEG, 2, "deg/s"),
            value(100.0 * x.noise_to_signal, 1, "%"),
        ),
    ));
    let information = if x.informative_up_to_hz > 0.0 {
        format!("on the dynamics up to {} Hz", text(x.informative_up_to_hz, 1))
    } else {
        "at no frequency does steering explain half of the yaw rate".into()
    };
    facts.push(Block::fact("information", information));
    if let Some(radius) = e.stabilised_from {
        let radius = text(radius, 6);
        let text = format!(
            "the model came out unstable (largest eigenvalue modulus {radius}) and was made stable"
        );
        facts.push(Block::fact("stability", text));
    }
    let conversion = match (&plant.continuous, e.conversion_round_trip) {
        (Some(_), error) => format!(
            "the samples of the continuous model are the discrete model (eq 9 and 10) to a relative error of {}",
            error.map_or_else(|| "–".into(), significant)
        ),
        (None, _) => "there is no continuous model: A has no real logarithm, so the plant is stepped on its own grid"
            .into(),
    };
    facts.push(Block::fact("conversion", conversion));
    vec![Block::Facts(facts)]
}

/// The reduction of the data, for people.
fn factor_in_words(f: &DataFactor) -> String {
    let condition = |c: Option<f64>| match c {
        Some(c) => format!("{c:.1e}"),
        None => "infinite".into(),
    };
    let method = match f.method {
        FactorMethod::Gram => "Gram matrix",
        FactorMethod::Qr => "QR factorisation",
    };
    let (all, input) = (condition(f.condition), condition(f.input_condition));
    let mut words = format!("{method}, condition {all} (input alone {input})");
    if f.horizon < f.asked_horizon {
        let more = format!("; {} block rows asked for, {} excited", f.asked_horizon, f.horizon);
        words.push_str(&more);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_of_a_log_is_stated_with_its_date() {
        let starts = |start: &str| {
            let options = [("log_start_s".to_owned(), start.to_owned())].into();
            start_in_words(&Provenance { options, ..Provenance::default() }).unwrap()
        };
        assert!(starts("1764000000.06").contains("1764000000.06 s (2025-11-24 16:00:00 UTC)"));
        assert!(starts("951782400").contains("(2000-02-29 00:00:00 UTC)"));
        assert!(starts("149.99").contains("at 149.99 s on"));
        assert!(starts("1000; 2000").contains("at 1000 s and 2000 s on"));
        assert_eq!(start_in_words(&Provenance::default()), None);
    }
}
