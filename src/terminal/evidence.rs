//! The evidence behind an identified plant, for people: tables and figures.

use crate::failure::Failure;
use crate::output::Files;
use crate::terminal::console;
use std::fmt::Write;
use steerwright_formats::{
    BandDeparture, ChannelSummary, Evidence, ExcitationBand, IdentifiedActuator, Information, Mode,
    Plant, Provenance, Quality, ResidualTest, Sideslip,
};
use steerwright_report::{Figure, Table};
use steerwright_sysid::Traces;

/// The actuator behind the steering command of a drive.
pub(crate) fn actuator_in_words(actuator: &IdentifiedActuator) -> String {
    let a = actuator;
    let lag = steerwright_report::not_negative(
        1e3 * a.time_constant_s,
        2e3 * a.time_constant_standard_error_s,
        0,
        " ms",
    );
    let delay =
        steerwright_report::not_negative(1e3 * a.delay_s, 2e3 * a.delay_standard_error_s, 0, " ms");
    let rate = a.max_rate_radps.map_or(String::new(), |rate| {
        format!(", at most {rate:.3} rad/s ({:.1}°/s)", rate.to_degrees())
    });
    format!(
        "actuator lag {lag}, delay {delay}{rate}, {:.3} times the command; fit {:.1} % of the measured angle\n",
        a.gain, a.fit
    )
}

/// The evidence behind a plant, for people.
pub(crate) fn evidence(plant: &Plant) -> String {
    let e = &plant.evidence;
    let channels = channels(&e.channels, Some(&plant.provenance));
    let mut orders =
        Table::new(["order", "singular value", "estimation", "validation", "as estimated"]);
    let validation_fit = |fit: f64| fit_text(fit, e.validation_samples);
    for row in &e.order_table {
        let chosen = if row.order == plant.order() { " <" } else { "" };
        orders = orders.row([
            format!("{}{chosen}", row.order),
            match row.singular_value {
                Some(s) => format!("{s:.4e}"),
                None => "–".into(),
            },
            format!("{:.2} %", row.estimation_fit),
            validation_fit(row.validation_fit),
            if row.stable { "stable".into() } else { "unstable".to_owned() },
        ]);
    }
    let mut text = format!("{channels}\n{}\n", console::table(&orders));
    let _ = writeln!(
        text,
        "model    order {}, {} ({}) with {} block rows, sample time {} s",
        plant.order(),
        e.method,
        plant.provenance.options.get("realization").map_or("", String::as_str),
        e.horizon,
        plant.discrete.sample_time_s
    );
    if let Some(factor) = &e.factor {
        let _ = writeln!(text, "factor   {}", steerwright_report::factor_in_words(factor));
    }
    if let Some(d) = &e.delay {
        let taken = if d.taken { "taken" } else { "not taken: lags explain the log as well" };
        let _ = match d.standard_error_s {
            Some(e) => {
                let delay = steerwright_report::not_negative(1e3 * d.estimate_s, 2e3 * e, 0, " ms");
                writeln!(text, "delay    {delay}, {taken}")
            }
            None => writeln!(text, "delay    none taken: this log does not determine it"),
        };
    }
    text.extend(e.actuator.as_ref().map(actuator_in_words));
    if let Some(sideslip) = &plant.sideslip {
        text += &sideslip_in_words(sideslip, plant.operating_point.speed_mps);
    }
    text.push_str(&validation(e));
    text + &conclusion(&e.warnings, &plant.quality)
}

/// The sideslip that fixes determine; `speed_mps` is that of the model, for a sideslip that states none.
pub(crate) fn sideslip_in_words(s: &Sideslip, speed_mps: f64) -> String {
    let lines = steerwright_report::sideslip_in_words(s, speed_mps);
    format!("sideslip {}\n", lines.join("\n         "))
}

/// Warnings, quality, remarks and advice, whatever was identified.
pub(crate) fn conclusion(warnings: &[String], quality: &Quality) -> String {
    let mut text = String::new();
    for warning in warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    let grade = console::grade(quality.grade);
    let codes =
        if quality.reasons.is_empty() { String::new() } else { format!(" ({})", quality.codes()) };
    let _ = writeln!(text, "quality  {grade}{codes}: {}", quality.summary);
    for reason in quality.unstated_reasons() {
        let (grade, code) = (console::grade(reason.grade), reason.code.name());
        let _ = writeln!(text, "         {grade} ({code}): {}", reason.message);
    }
    for remark in &quality.remarks {
        let _ = writeln!(text, "remark   {remark}");
    }
    for advice in &quality.advice {
        let _ = writeln!(text, "advice   {advice}");
    }
    text
}

/// Writes figures, each with a name and a height in pixels.
pub(crate) fn plots(
    figures: Vec<(&'static str, u32, Figure)>,
    files: &Files,
) -> Result<(), Failure> {
    for (name, height, figure) in figures {
        match figure.to_svg(steerwright_report::WIDTH, height) {
            Ok(svg) => {
                files.write(&format!("{name}.svg"), svg.as_bytes())?;
            }
            // A short log leaves some of them empty.
            Err(steerwright_report::Error::NoData { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// The channels, their units, and when the log starts.
pub(crate) fn channels(all: &[ChannelSummary], provenance: Option<&Provenance>) -> String {
    let mut text = console::table(&channel_table(all)) + "values in rad, rad/s and m/s\n";
    if let Some(start) = provenance.and_then(steerwright_report::start_in_words) {
        text += &format!("{start}\n");
    }
    text
}

pub(crate) fn channel_table(all: &[ChannelSummary]) -> Table {
    let mut channels =
        Table::new(["channel", "column", "read as", "rows", "rate", "min", "mean", "max"]);
    for c in all {
        channels = channels.row([
            c.role.clone(),
            c.column.clone(),
            c.unit.clone(),
            c.rows.to_string(),
            format!("{:.1} Hz", c.rate_hz),
            format!("{:.4}", c.min),
            format!("{:.4}", c.mean),
            format!("{:.4}", c.max),
        ]);
    }
    channels
}

/// A fit with twice its standard error, about 95 %, or why there is none.
pub(crate) fn with_error(fit: f64, standard_error: Option<f64>, without: String) -> String {
    match standard_error {
        Some(error) => format!("{fit:.2} ± {:.2} %", 2.0 * error),
        None => format!("{fit:.2} % (no ±: {without})"),
    }
}

/// A fit on validation data, if there are any.
fn fit_text(fit: f64, samples: usize) -> String {
    if samples == 0 { "–".into() } else { format!("{fit:.2} %") }
}

/// Fits, tests, and the information of the log by frequency.
fn validation(e: &Evidence) -> String {
    let mut text = String::new();
    let fit = match e.held_out.as_ref().filter(|_| e.validation_samples > 0) {
        Some(h) => with_error(e.fit.validation, h.fit_standard_error, h.without_standard_error()),
        None => fit_text(e.fit.validation, e.validation_samples),
    };
    let _ = writeln!(
        text,
        "fit      {fit} simulated on validation data, {} one step ahead, {:.2} % on estimation data",
        fit_text(e.fit.validation_one_step, e.validation_samples),
        e.fit.estimation
    );
    if let Some(held_out) = &e.held_out {
        let ahead = held_out.predictions.iter().filter_map(|p| {
            let seconds = p.ahead_s.filter(|_| p.steps > Some(1))?;
            Some(format!("{seconds} s {:.2} %", p.fit))
        });
        let ahead: Vec<String> = ahead.collect();
        let vaf = held_out.variance_accounted_for;
        if ahead.is_empty() {
            text += "         ";
        } else {
            let _ = write!(text, "         predicted ahead by {}; ", ahead.join(", "));
        }
        let _ = writeln!(text, "the simulation accounts for {vaf:.2} % of the variance");
        text += &validation_data(held_out);
    }
    let test = |name: &str, t: &ResidualTest| match (t.lags, t.pass) {
        (0, _) => format!("{name} not tested"),
        (_, true) => format!("{name} passed ({:.1}, bound {:.1})", t.statistic, t.bound),
        (_, false) => format!("{name} failed ({:.1}, bound {:.1})", t.statistic, t.bound),
    };
    let mut tests =
        vec![test("whiteness", &e.whiteness), test("independence of input", &e.independence)];
    if let Some(residuals) = &e.residuals {
        let t = &residuals.feedback;
        let found = if t.pass { "none" } else { "found" };
        let name = "dependence of the input on past residuals";
        tests.push(format!("{name} {found} ({:.1}, bound {:.1})", t.statistic, t.bound));
    }
    let _ = writeln!(text, "tests    of the residuals on validation data: {}", tests.join(", "));
    if let Some(t) = e.feedback.as_ref().filter(|t| t.lags > 0) {
        let found = if t.pass { "none" } else { "found" };
        let _ = writeln!(
            text,
            "feedback {found} in the estimation data ({:.1}, bound {:.1}), which selects among the methods",
            t.statistic, t.bound
        );
    }
    if let Some(response) = e.frequency_response.as_ref().filter(|r| r.compared > 0) {
        let _ = writeln!(
            text,
            "response model within the {:.0} % confidence of the measured one at {:.0} % of {} frequencies",
            100.0 * response.confidence,
            100.0 * response.within,
            response.compared
        );
    }
    if let Some(map) = &e.poles_and_zeros {
        let modes: Vec<String> = map.poles.iter().filter_map(mode).collect();
        let _ = writeln!(text, "modes    {}", modes.join(", "));
    }
    if !e.excitation.bands.is_empty() {
        let headers = [
            "excitation",
            "road wheel",
            "yaw rate",
            "explained",
            "gain error",
            "",
            "model's gain",
            "phase",
        ];
        let errors = e.frequency_response.as_ref().map_or(&[][..], |r| &r.bands);
        let mut bands = Table::new(headers);
        for b in &e.excitation.bands {
            bands.push([
                format!("{} to {} Hz", b.from_hz, b.to_hz),
                format!("{:.3}°", b.road_wheel_std_rad.to_degrees()),
                format!("{:.3} °/s", b.yaw_rate_std_radps.to_degrees()),
                format!("{:.0} %", 100.0 * b.coherence),
                if b.information != Information::None {
                    format!("±{:.1} %", 200.0 * b.relative_error)
                } else {
                    "–".to_owned()
                },
                match b.information {
                    Information::Good => "good",
                    Information::Weak => "weak",
                    Information::None => "no information",
                }
                .to_owned(),
                of_band(errors, b, |d| format!("×{:.2}", d.gain_ratio)),
                of_band(errors, b, |d| {
                    format!("{:+.0}°", d.phase_ahead_rad.to_degrees().round() + 0.0)
                }),
            ]);
        }
        let _ = write!(text, "\n{}\n", console::table(&bands));
    }
    text
}

/// A quantity of the model in a band compared with the measured response; a dash where it is unknown.
fn of_band(
    errors: &[BandDeparture],
    band: &ExcitationBand,
    value: impl Fn(&BandDeparture) -> String,
) -> String {
    match errors.iter().find(|d| d.from_hz == band.from_hz && d.to_hz == band.to_hz) {
        Some(departure) => value(departure),
        None => "–".into(),
    }
}

/// A pole for people: its time constant, or frequency and damping.
fn mode(pole: &Mode) -> Option<String> {
    let (hz, damping) = (pole.natural_frequency_hz?, pole.damping?);
    if pole.discrete[1] != 0.0 {
        return Some(format!("{hz:.2} Hz (damping {damping:.2})"));
    }
    Some(match pole.time_constant_s {
        Some(t) => format!("{t:.3} s"),
        None => "integrator".into(),
    })
}

/// How the validation data were chosen, and the fit that noise allows there; a line.
pub(crate) fn validation_data(held_out: &steerwright_formats::HeldOut) -> String {
    let chosen_by = match held_out.selection.as_str() {
        "excited-blocks" => {
            "blocks chosen for their excitation, since the end of the log is not excited"
        }
        "speed-blocks" => "blocks of the whole drive, since the speed varies",
        "windows" => "windows of accumulated drives",
        _ => "the end of the log",
    };
    let bound = match held_out.fit_bound {
        Some(bound) => {
            format!("; noise allows a fit of {bound:.1} % at most there")
        }
        None => String::new(),
    };
    format!("         validation data: {chosen_by}{bound}\n")
}

/// The signals as CSV; with the yaw rate of a bicycle model where there is one.
pub(crate) fn traces_csv(traces: &Traces, bicycle: Option<&[f64]>) -> String {
    let mut text = String::from(
        "time_s,steering_rad,yaw_rate_radps,simulated_yaw_rate_radps,held_out,yaw_rad,simulated_yaw_rad",
    );
    if bicycle.is_some() {
        text.push_str(",bicycle_yaw_rate_radps");
    }
    text.push('\n');
    for k in 0..traces.time_s.len() {
        let _ = write!(
            text,
            "{},{},{},{},{},{},{}",
            traces.time_s[k],
            traces.steering_rad[k],
            traces.yaw_rate_radps[k],
            traces.simulated_yaw_rate_radps[k],
            u8::from(traces.is_validation[k]),
            traces.yaw_rad[k],
            traces.simulated_yaw_rad[k]
        );
        if let Some(bicycle) = bicycle {
            let _ = write!(text, ",{}", bicycle[k]);
        }
        text.push('\n');
    }
    text
}
