//! The log, the model and the evidence for it.

use super::{significant, value};
use crate::figures::{self, DEG, text};
use crate::read::Traces;
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    ChannelSummary, DataFactor, Evidence, Excitation, FactorMethod, InputKind, Model, Plant,
    Provenance, ResidualTest,
};

/// The channels of the log.
pub(crate) fn log(model: &Model, traces: Option<&Traces>) -> Section {
    let mut blocks = Vec::new();
    if !model.channels().is_empty() {
        let headers = ["channel", "column", "read as", "rows", "rate", "least", "mean", "largest"];
        let mut table = Table::new(headers);
        for c in model.channels() {
            let (factor, unit) = shown_in(c);
            table.push([
                c.role.clone(),
                c.column.clone(),
                c.unit.clone(),
                c.rows.to_string(),
                value(c.rate_hz, 1, "Hz"),
                value(factor * c.min, 2, unit),
                value(factor * c.mean, 2, unit),
                value(factor * c.max, 2, unit),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    if let Some(start) = model.provenance().and_then(start_in_words) {
        blocks.push(Block::Text(start));
    }
    if let Some(traces) = traces {
        let caption = "What was recorded, on the clock of the identification. Yaw is the integral \
                       of the measured yaw rate.";
        blocks.push(Block::figure(figures::drive(traces), 600, caption));
    }
    Section::new("The log", blocks)
}

/// The information of the log by frequency.
pub(crate) fn information(e: &Excitation) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !e.coherence.is_empty() {
        let caption = "Coherence is the share of the yaw rate that steering explains linearly, by \
                       frequency. Above the limit the log does not determine a model.";
        blocks.push(Block::figure(figures::coherence(e), 330, caption));
    }
    blocks.extend(super::evidence::bands(e));
    blocks
}

/// When the log starts on its own clock, where that is not at 0: all times are counted from there.
#[must_use]
pub fn start_in_words(provenance: &Provenance) -> Option<String> {
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

/// Channels are kept in SI; people read degrees.
fn shown_in(c: &ChannelSummary) -> (f64, &'static str) {
    match c.role.as_str() {
        "steering" | "yaw" | "heading" | "roll" | "sideslip" => (DEG, "deg"),
        "yaw_rate" => (DEG, "deg/s"),
        "speed" | "lateral_velocity" => (1.0, "m/s"),
        "lateral_acceleration" | "longitudinal_acceleration" => (1.0, "m/s²"),
        _ => (1.0, ""),
    }
}

/// The model, how well it fits, and how its order was chosen.
pub(crate) fn model(plant: &Plant, traces: Option<&Traces>, bicycle_fit: Option<f64>) -> Section {
    let e = &plant.evidence;
    let p = &plant.operating_point;
    let mut table = Table::new(["quantity", "value"]);
    let input = match plant.input {
        InputKind::Steering => "steering angle",
        InputKind::SteeringTimesSpeed => "steering angle times speed",
    };
    for (name, text) in [
        ("method", e.method.to_uppercase()),
        ("order n", plant.order().to_string()),
        ("horizon (block rows)", e.horizon.to_string()),
        (
            "data factor",
            match e.factor.as_ref() {
                Some(value) => factor_in_words(value),
                None => "–".into(),
            },
        ),
        ("input", input.to_owned()),
        ("sample time", format!("{} s", plant.discrete.sample_time_s)),
        ("input delay", value(plant.input_delay_s, 3, "s")),
        ("speed", value(p.speed_mps, 2, "m/s")),
        ("steering ratio", significant(plant.steering_ratio)),
        ("steering offset", value(p.steering_offset_rad * DEG, 3, "deg")),
        ("yaw-rate offset", value(p.yaw_rate_offset_radps * DEG, 3, "deg/s")),
        ("fit, estimation data", value(e.fit.estimation, 1, "%")),
        ("fit, validation data", value(e.fit.validation, 1, "%")),
        ("fit, validation data, one-step prediction", value(e.fit.validation_one_step, 1, "%")),
    ] {
        table.push([name.to_owned(), text]);
    }
    let mut blocks = vec![Block::Table(table)];
    if let Some(traces) = traces {
        let fits = [Some(e.fit.estimation), Some(e.fit.validation)];
        let caption = "Simulation from the steering alone: the measured yaw rate is no input of the \
                       model. The shaded part is validation data.";
        blocks.push(Block::figure(figures::comparison(traces, fits, bicycle_fit), 720, caption));
    }
    if !e.order_table.is_empty() {
        let caption = "Singular values of the chosen method and horizon: a gap after the n-th, and \
                       a validation fit that no longer rises, indicate order n. The fits are those \
                       of each order's own best method and horizon, refined. The order with the \
                       least criterion on the estimation data is chosen.";
        let figure = figures::order_table(&e.order_table, plant.order());
        blocks.push(Block::figure(figure, 320, caption));
        let headers = ["order", "singular value", "estimation fit", "validation fit", "stable", ""];
        let mut table = Table::new(headers);
        for row in &e.order_table {
            table.push([
                row.order.to_string(),
                match row.singular_value {
                    Some(value) => significant(value),
                    None => "–".into(),
                },
                fit(row.estimation_fit),
                fit(row.validation_fit),
                if row.stable { "yes" } else { "no" }.into(),
                if row.order == plant.order() { "chosen" } else { "" }.into(),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    blocks.push(Block::Heading("The evidence in words".into()));
    blocks.push(Block::List(in_words(plant)));
    Section::new("The identified model", blocks)
}

/// The reduction of the data, for people.
#[must_use]
pub fn factor_in_words(f: &DataFactor) -> String {
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

/// Below −100 % only the sign of a fit means anything.
fn fit(percent: f64) -> String {
    if percent < -100.0 { "−100 % or less".into() } else { value(percent, 1, "%") }
}

fn in_words(plant: &Plant) -> Vec<String> {
    let e: &Evidence = &plant.evidence;
    let test = |t: &ResidualTest| {
        let (statistic, bound) = (significant(t.statistic), significant(t.bound));
        format!("statistic {statistic} over {} lags, 99 % bound {bound}", t.lags)
    };
    let mut out = vec![format!(
        "Estimated on {} samples, validated on {} others: there the simulation fits the yaw rate \
         by {}, one-step prediction by {}.",
        e.estimation_samples,
        e.validation_samples,
        value(e.fit.validation, 1, "%"),
        value(e.fit.validation_one_step, 1, "%"),
    )];
    if e.whiteness.lags > 0 {
        let verdict = if e.whiteness.pass {
            "The one-step residuals are white"
        } else {
            "The one-step residuals are not white: the noise model is incomplete"
        };
        out.push(format!("{verdict} ({}).", test(&e.whiteness)));
    }
    if e.independence.lags > 0 {
        let verdict = if e.independence.pass {
            "The residuals do not depend on past steering: no linear effect of it is missing"
        } else {
            "The residuals still depend on past steering: dynamics are missing, or the vehicle is \
             not linear over this drive"
        };
        out.push(format!("{verdict} ({}).", test(&e.independence)));
    }
    let x = &e.excitation;
    out.push(format!(
        "The road wheel moved by {} (standard deviation), the yaw rate by {}; the innovation is \
         {} of the yaw rate.",
        value(x.road_wheel_std_rad * DEG, 2, "deg"),
        value(x.yaw_rate_std_radps * DEG, 2, "deg/s"),
        value(100.0 * x.noise_to_signal, 1, "%"),
    ));
    out.push(if x.informative_up_to_hz > 0.0 {
        format!(
            "The log has information on the dynamics up to {} Hz.",
            text(x.informative_up_to_hz, 1)
        )
    } else {
        "At no frequency does steering explain half of the yaw rate.".into()
    });
    if let Some(radius) = e.stabilised_from {
        let radius = text(radius, 6);
        out.push(format!(
            "The model came out unstable (largest eigenvalue modulus {radius}) and was made stable."
        ));
    }
    out.push(match (&plant.continuous, e.conversion_round_trip) {
        (Some(_), error) => format!(
            "The samples of the continuous model are the discrete model (eq 9 and 10) to a relative error of {}.",
            error.map_or_else(|| "–".into(), significant)
        ),
        (None, _) => "There is no continuous model: A has no real logarithm, so the plant is \
                      stepped on its own grid."
            .into(),
    });
    out
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
