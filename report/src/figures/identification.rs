//! The recorded drive (the paper's Fig. 1 and 2), and the identified model: against the measurement,
//! by frequency, by order.

use super::{DEG, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
use crate::palette::{BLACK, BLUE, GREEN, GREY, VERMILION};
use crate::read::Traces;
use steerwright_formats::{Excitation, OrderRow};

/// Length of the magnified part of a long drive, s.
const NEAR_S: f64 = 20.0;

/// Steering angle, yaw rate and yaw of the drive over time.
pub fn drive(traces: &Traces) -> Figure {
    let t = &traces.axis_time_s();
    let thin = |color| Style::line(color).width(1.1);
    let panel = |label: &str, y: &[f64], color| {
        let mut panel =
            Panel::new(traces.axis_label(), label).with(Series::over("", t, (y, DEG), thin(color)));
        for (k, (from, to)) in traces.validation_ranges().into_iter().enumerate() {
            let name = if k == 0 { "validation data" } else { "" };
            panel = panel.mark(Mark::new(name, MarkPlace::XBand(from, to), GREY));
        }
        Panel { link: "drive", ..panel }
    };
    let panels = vec![
        panel("Steering angle (deg)", &traces.steering_rad, BLUE),
        panel("Yaw rate (deg/s)", &traces.yaw_rate_radps, BLACK),
        panel("Yaw (deg)", &traces.yaw_rad, BLACK),
    ];
    let length = |(from, to): (f64, f64)| to - from;
    let most = |values: &[f64]| {
        let finite = values.iter().filter(|v| v.is_finite());
        text(DEG * finite.fold(0.0, |m: f64, v| m.max(v.abs())), 1)
    };
    let result = format!(
        "{} s, of which {} s are validation data; steering up to {} deg, yaw rate up to {} deg/s.",
        text(length((t.first().copied().unwrap_or(0.0), t.last().copied().unwrap_or(0.0))), 1),
        text(traces.validation_ranges().into_iter().map(length).sum(), 1),
        most(&traces.steering_rad),
        most(&traces.yaw_rate_radps),
    );
    Figure::new("The drive: steering, yaw rate and its integral", panels).stating(result)
}

/// Measured and simulated yaw rate and yaw (the paper's Fig. 3), with the fits in the legend and
/// the validation data shaded.
///
/// `fits` are those on estimation and on validation data, percent; `bicycle_fit` is the fit of the bicycle model in percent, where known; its curve is in
/// [`Traces::bicycle_yaw_rate_radps`].
pub fn comparison(traces: &Traces, fits: [Option<f64>; 2], bicycle_fit: Option<f64>) -> Figure {
    let t = &traces.axis_time_s();
    let [estimation, validation] = fits.map(|fit| text(fit.unwrap_or(f64::NAN), 1));
    let fits = format!("fit {estimation} %, validation {validation} %");
    let mut result = format!("The identified model: {fits}");
    let measured = Style::line(BLACK).width(1.1);
    let reference = Series::over("measured", t, (&traces.yaw_rate_radps, DEG), measured);
    let mut rate = Panel::new(traces.axis_label(), "Yaw rate (deg/s)").with(reference);
    if let Some(bicycle) = &traces.bicycle_yaw_rate_radps {
        let fit = match bicycle_fit {
            Some(f) => format!("fit {} %", text(f, 1)),
            None => String::new(),
        };
        let mut series = Series::over("bicycle model", t, (bicycle, DEG), Style::dashed(GREEN));
        if !fit.is_empty() {
            series = series.noted(format!(" ({fit})"));
            result += &format!("; the bicycle model: {fit}");
        }
        rate = rate.with(series);
    }
    let line = Style::line(VERMILION);
    rate = rate.with(
        Series::over("identified", t, (&traces.simulated_yaw_rate_radps, DEG), line)
            .noted(format!(" ({fits})")),
    );
    rate.y_limits = rate.limits_of_the_first();
    let mut yaw = Panel::new(traces.axis_label(), "Yaw (deg)")
        .with(Series::over("measured", t, (&traces.yaw_rad, DEG), measured))
        .with(Series::over("identified", t, (&traces.simulated_yaw_rad, DEG), line));
    yaw.y_limits = yaw.limits_of_the_first();
    yaw.weight = 0.8;
    let near = magnified(&rate, traces);
    for (k, (from, to)) in traces.validation_ranges().into_iter().enumerate() {
        let name = if k == 0 { "validation data" } else { "" };
        rate = rate.mark(Mark::new(name, MarkPlace::XBand(from, to), GREY));
        yaw = yaw.mark(Mark::new(name, MarkPlace::XBand(from, to), GREY));
    }
    let [rate, yaw] = [rate, yaw].map(|p| Panel { link: "drive", ..p });
    let panels = [Some(rate), Some(yaw), near].into_iter().flatten().collect();
    Figure::new("Measured and identified model", panels).stating(result + ".")
}

/// The beginning of the validation data, where the whole drive is too long to see the curves apart.
fn magnified(rate: &Panel, traces: &Traces) -> Option<Panel> {
    let time = traces.axis_time_s();
    let (first, last) = (*time.first()?, *time.last()?);
    let (from, to) = traces.validation_ranges().first().copied()?;
    let to = to.min(from + NEAR_S);
    if last - first < 3.0 * NEAR_S || to - from < 0.2 * NEAR_S {
        return None;
    }
    let label = format!("Time (s), the first {} s of validation data", text(to - from, 0));
    let mut near = Panel { x_label: label, weight: 1.0, ..rate.clone() };
    for series in &mut near.series {
        series.note.clear();
        series.points.retain(|p| (from..=to).contains(&p.0));
    }
    // The panel above shows a model that leaves the range of the drive.
    Some(near)
}

/// Coherence of steering and yaw rate over frequency; beyond the information limit is shaded.
pub fn coherence(excitation: &Excitation) -> Figure {
    let points =
        excitation.coherence.iter().map(|p| (p.frequency_hz, p.coherence)).collect::<Vec<_>>();
    let limit = excitation.informative_up_to_hz;
    let mut panel = Panel::new("Frequency (Hz)", "Coherence (1)")
        .with(Series::new("steering angle → yaw rate", points, Style::line(BLUE)))
        .mark(Mark::new("coherence 0.5", MarkPlace::YLine(0.5), GREY));
    let beyond = |from| MarkPlace::XBand(from, f64::INFINITY);
    panel = if limit > 0.0 {
        let name = format!("low coherence above {} Hz", significant(limit));
        let line = Mark::new("", MarkPlace::XLine(limit), VERMILION);
        panel.mark(line).mark(Mark::new(name, beyond(limit), VERMILION))
    } else {
        panel.mark(Mark::new("low coherence at all frequencies", beyond(0.0), VERMILION))
    };
    panel.x_log = true;
    panel.y_limits = Some((0.0, 1.0));
    let result = if limit > 0.0 {
        format!("The log is informative up to {} Hz.", significant(limit))
    } else {
        "The log is informative at no frequency.".into()
    };
    Figure::new("Information in the log by frequency", vec![panel]).stating(result)
}

fn significant(value: f64) -> String {
    text(value, if value < 1.0 { 2 } else { 1 })
}

/// Singular values and fits by order, with the order that was chosen.
pub fn order_table(rows: &[OrderRow], chosen: usize) -> Figure {
    let values =
        rows.iter().map(|r| (r.order as f64, r.singular_value.unwrap_or(f64::NAN))).collect();
    // Unstable models fit by minus millions; what is below 0 is as useless at −10 as at −1e6.
    let fit = |f: fn(&OrderRow) -> f64| -> Vec<_> {
        rows.iter().map(|r| (r.order as f64, f(r).max(-20.0))).collect()
    };
    let marked = || MarkPlace::XLine(chosen as f64);
    let mut singular = Panel::new("Order n", "Singular value")
        .with(Series::new("of the chosen method and horizon", values, Style::dots(BLUE)))
        .mark(Mark::new(format!("chosen: {chosen}"), marked(), VERMILION));
    singular.y_log = true;
    let unstable: Vec<_> = rows
        .iter()
        .filter(|r| !r.stable)
        .map(|r| (r.order as f64, r.validation_fit.max(-20.0)))
        .collect();
    let low = rows.iter().any(|r| r.validation_fit < -20.0 || r.estimation_fit < -20.0);
    let faint = Style { dashed: true, dot: 2.5, ..Style::dots(GREY) };
    let mut fits = Panel::new("Order n", "Fit of simulation (%)")
        .with(Series::new("estimation", fit(|r| r.estimation_fit), faint))
        .with(Series::new("validation", fit(|r| r.validation_fit), Style::dots(GREEN)))
        .mark(Mark::new("", marked(), VERMILION));
    if !unstable.is_empty() {
        let style = Style::symbols(VERMILION, Symbol::Dot, 5.0);
        fits.series.insert(1, Series::new("unstable as estimated", unstable, style));
    }
    if low && let Some(validation) = fits.series.last_mut() {
        validation.note = " (−20 or less)".into();
    }
    let fit = rows.iter().find(|r| r.order == chosen).map_or(f64::NAN, |r| r.validation_fit);
    let result = format!(
        "Order {chosen} of {} orders was chosen; its simulation fits the validation data by {} %.",
        rows.len(),
        text(fit, 1)
    );
    let title = "Choice of the order";
    Figure { columns: 2, ..Figure::new(title, vec![singular, fits]) }.stating(result)
}
