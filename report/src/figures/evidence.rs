//! The reliability of a model: prediction, residuals, frequency response, poles and zeros.

use super::{DEG, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
use crate::palette::{BLACK, BLUE, Color, GREY, VERMILION};
use std::f64::consts::TAU;
use steerwright_formats::{
    FrequencyResponse, HeldOut, InputKind, Mode, PoleZeroMap, ResidualCorrelation, ResponsePoint,
    Spread,
};

const GAP: (f64, f64) = (f64::NAN, f64::NAN);

/// Fit of predictions over how far they look ahead, and of the simulation.
pub fn prediction(held_out: &HeldOut) -> Figure {
    let points: Vec<_> =
        held_out.predictions.iter().filter_map(|p| Some((p.ahead_s?, p.fit.max(-20.0)))).collect();
    let mut panel = Panel::new("Looking ahead (s)", "Fit, validation data (%)").with(Series::new(
        "prediction from measured yaw rate up to then",
        points,
        Style::dots(BLUE),
    ));
    if let Some(simulation) = held_out.predictions.iter().find(|p| p.steps.is_none()) {
        let fit = simulation.fit.max(-20.0);
        let name = format!("simulation: {} %", text(simulation.fit, 1));
        panel = panel.mark(Mark::new(name, MarkPlace::YLine(fit), VERMILION));
        if let Some(error) = held_out.fit_standard_error {
            let band = MarkPlace::YBand(fit - 2.0 * error, fit + 2.0 * error);
            panel = panel.mark(Mark::new("± two standard errors", band, VERMILION));
        }
    }
    let fits: Vec<_> = held_out
        .predictions
        .iter()
        .map(|p| match p.ahead_s {
            Some(s) => format!("{} % from {} s before", text(p.fit, 1), text(s, 2)),
            None => format!("{} % in simulation", text(p.fit, 1)),
        })
        .collect();
    Figure::new("Prediction of the validation data", vec![panel])
        .stating(format!("The fit is {}.", fits.join(", ")))
}

/// Auto- and cross-correlation of the residuals, lag by lag, with the bands of 99 %.
pub fn residuals(correlation: &ResidualCorrelation, sample_time_s: f64) -> Figure {
    let half = (correlation.with_input.len() / 2) as f64;
    let own = stems(&correlation.autocorrelation, 1.0, sample_time_s);
    let cross = stems(&correlation.with_input, -half, sample_time_s);
    let panel = |x: &str, y: &str, points: Vec<(f64, f64)>, bound: f64| {
        let last = (points.len() / 3).saturating_sub(1);
        let tips = points.chunks(3).take(last).skip(1).map(|c| c[1]).collect();
        let band = MarkPlace::YBand(-bound, bound);
        Panel::new(x, y)
            .with(Series::shape("", points, Style::line(BLUE)))
            .with(Series::new("", tips, Style::symbols(BLUE, Symbol::Dot, 2.5)))
            .mark(Mark::new("99 % of lags where there is nothing", band, GREY))
    };
    let own = panel("Lag (s)", "Autocorrelation (1)", own, correlation.autocorrelation_bound);
    let cross = panel(
        "Residual after steering (s)",
        "Correlation with steering (1)",
        cross,
        correlation.with_input_bound,
    )
    .mark(Mark::new("", MarkPlace::XLine(0.0), GREY));
    let beyond = |values: &[f64], bound: f64| values.iter().filter(|v| v.abs() > bound).count();
    let result = format!(
        "Beyond the band of 99 %: {} of {} lags of the autocorrelation, {} of {} lags with steering.",
        beyond(&correlation.autocorrelation, correlation.autocorrelation_bound),
        correlation.autocorrelation.len(),
        beyond(&correlation.with_input, correlation.with_input_bound),
        correlation.with_input.len(),
    );
    let title = "What the model leaves unexplained";
    Figure { columns: 2, ..Figure::new(title, vec![own, cross]) }.stating(result)
}

/// From 0 to each value.
fn stems(values: &[f64], first: f64, sample_time_s: f64) -> Vec<(f64, f64)> {
    let stem = |(k, v): (usize, f64)| {
        let t = (first - 1.0 + k as f64) * sample_time_s;
        [(t, 0.0), (t, v), GAP]
    };
    // A lag more at each end, for air.
    let padded = std::iter::once(0.0).chain(values.iter().copied()).chain([0.0]);
    padded.enumerate().flat_map(stem).collect()
}

/// Gain, phase and coherence over frequency: measured without a model, with confidence, and the
/// model's.
pub fn frequency_response(response: &FrequencyResponse, input: InputKind) -> Figure {
    let unit = match input {
        InputKind::Steering => "1/s",
        InputKind::SteeringTimesSpeed => "1/m",
    };
    let all = &response.points;
    let known: Vec<&ResponsePoint> =
        all.iter().filter(|p| p.coherence > response.significant_coherence).collect();
    let percent = text(100.0 * response.confidence, 0);
    let bars = |f: &dyn Fn(&ResponsePoint) -> (f64, f64)| -> Vec<Series> {
        let bar = |p: &&ResponsePoint| {
            let (low, high) = f(p);
            [(p.frequency_hz, low), (p.frequency_hz, high), GAP]
        };
        // A series torn into very many pieces would be thinned when it is drawn.
        let some = |part: &[&ResponsePoint]| {
            let points = part.iter().flat_map(bar).collect();
            Series::shape("", points, Style::line(GREY).width(1.0))
        };
        known.chunks(20).map(some).collect()
    };
    let over = |f: fn(&ResponsePoint) -> f64| all.iter().map(move |p| (p.frequency_hz, f(p)));
    let gain_bars = bars(&|p| ((p.gain - p.radius).max(0.05 * p.gain), p.gain + p.radius));
    let phase_bars = bars(&|p| {
        let apart = (p.radius / p.gain).min(1.0).asin();
        (DEG * (p.phase_rad - apart), DEG * (p.phase_rad + apart))
    });
    let model = Style::line(VERMILION);
    let measured = |points: Vec<(f64, f64)>| {
        let name = format!("measured, {percent} % confidence");
        Series::new(name, points, Style::symbols(BLACK, Symbol::Dot, 2.5))
    };
    let mut gain = Panel::new("Frequency (Hz)", format!("Gain ({unit})"))
        .with(measured(known.iter().map(|p| (p.frequency_hz, p.gain)).collect()))
        .with(Series::new("model", over(|p| p.model_gain).collect(), model));
    gain.y_log = true;
    gain.series.extend(gain_bars);
    let mut phase = Panel::new("Frequency (Hz)", "Phase (deg)")
        .with(measured(known.iter().map(|p| (p.frequency_hz, DEG * p.phase_rad)).collect()))
        .with(Series::new("model", over(|p| DEG * p.model_phase_rad).collect(), model));
    phase.series.extend(phase_bars);
    let significant = MarkPlace::YLine(response.significant_coherence);
    let mut coherence = Panel::new("Frequency (Hz)", "Coherence (1)")
        .with(Series::new("coherence", over(|p| p.coherence).collect(), Style::line(BLUE)))
        .with(Series::shape(
            format!("{percent} % confidence"),
            over(|p| p.coherence_low).chain([GAP]).chain(over(|p| p.coherence_high)).collect(),
            Style::dashed(GREY).width(1.0),
        ))
        .mark(Mark::new("1 % of unrelated signals are above", significant, VERMILION));
    coherence.y_limits = Some((0.0, 1.0));
    coherence.weight = 0.75;
    let mut panels = vec![gain, phase, coherence];
    if known.is_empty() {
        // Nothing was measured: the model alone would look like a finding.
        panels.drain(..2);
    }
    for panel in &mut panels {
        panel.x_log = true;
    }
    let figure = Figure::new("Frequency response, measured and modelled", panels);
    if response.compared == 0 {
        return figure.stating("At no frequency is the coherence high enough for a comparison.");
    }
    figure.stating(format!(
        "The model lies within the {percent} % band of the measured response at {} of {} frequencies \
         whose coherence is above 0.5.",
        text(response.within * response.compared as f64, 0),
        response.compared
    ))
}

/// Poles and zeros in the z-plane with the unit circle, and in the s-plane, with the ellipses that hold
/// each with 95 % probability where its covariance is known.
pub fn poles_and_zeros(map: &PoleZeroMap) -> Figure {
    let both = |[re, im]: [f64; 2]| {
        let mirrored = if im != 0.0 { Some((re, -im)) } else { None };
        [Some((re, im)), mirrored].into_iter().flatten().collect::<Vec<_>>()
    };
    let plane = |of: fn(&Mode) -> Option<[f64; 2]>, modes: &[Mode]| -> Vec<(f64, f64)> {
        modes.iter().filter_map(of).flat_map(both).collect()
    };
    let circle = (0..=180).map(|k| (TAU * f64::from(k) / 180.0).sin_cos()).collect();
    let near = |zeros: Vec<(f64, f64)>, reach: f64| -> Vec<(f64, f64)> {
        zeros.into_iter().filter(|z| z.0.hypot(z.1) <= reach).collect()
    };
    let circle = Series::shape("unit circle", circle, Style::line(GREY).width(1.0));
    let mut z = Panel::new("Re z (1)", "Im z (1)").with(circle);
    let (cross, ring) =
        (Style::symbols(VERMILION, Symbol::Cross, 6.0), Style::symbols(BLUE, Symbol::Ring, 6.0));
    z = z.with(Series::new("pole", plane(|m| Some(m.discrete), &map.poles), cross));
    let zeros = near(plane(|m| Some(m.discrete), &map.zeros), 2.0);
    if !zeros.is_empty() {
        z = z.with(Series::new("zero", zeros, ring));
    }
    let within: Vec<_> =
        map.zeros.iter().filter(|m| m.discrete[0].hypot(m.discrete[1]) <= 2.0).collect();
    let of = |modes: &[&Mode]| -> Vec<(f64, f64)> {
        let ellipse =
            |m: &&Mode| Some(ellipse(m.discrete, m.spread?, (1.0, 0.0), m.discrete[1] != 0.0));
        modes.iter().filter_map(ellipse).flatten().map(|p| near_point(p, 2.0)).collect()
    };
    let all: Vec<_> = map.poles.iter().collect();
    z = with_ellipses(z, [(of(&all), VERMILION), (of(&within), BLUE)]);
    let poles = plane(|m| m.continuous, &map.poles);
    let reach = poles.iter().map(|p| p.0.hypot(p.1)).fold(1e-3, f64::max);
    let shown = |z: &[f64; 2]| z[0].hypot(z[1]) <= 2.0 * reach;
    let zeros =
        map.continuous_zeros.iter().filter(|z| shown(z)).map(|z| (z[0], z[1])).collect::<Vec<_>>();
    // Seen with the axes' crossing, from which frequency and damping are read.
    let wide = zeros.iter().map(|p| p.0.hypot(p.1)).fold(reach, f64::max);
    let axes = vec![(-wide, 0.0), (0.2 * wide, 0.0), GAP, (0.0, -0.6 * wide), (0.0, 0.6 * wide)];
    let s = Panel::new("Re s (rad/s)", "Im s (rad/s)")
        .with(Series::shape("stable to the left", axes, Style::line(GREY).width(1.0)))
        .with(Series::new("pole", poles, cross));
    let s = if zeros.is_empty() { s } else { s.with(Series::new("zero", zeros, ring)) };
    let of_poles: Vec<(f64, f64)> =
        map.poles.iter().filter_map(continuous_ellipse).flatten().collect();
    let spreads = map.continuous_zeros.iter().zip(&map.continuous_zero_spreads);
    let of_zeros: Vec<(f64, f64)> = spreads
        .filter(|(z, _)| shown(z))
        .flat_map(|(z, s)| ellipse(*z, *s, (1.0, 0.0), false))
        .collect();
    let clip =
        |points: Vec<(f64, f64)>| points.into_iter().map(|p| near_point(p, 1.5 * wide)).collect();
    let s = with_ellipses(s, [(clip(of_poles), VERMILION), (clip(of_zeros), BLUE)]);
    let panels = [z, s].map(|p| Panel { equal_aspect: true, ..p }).to_vec();
    let moduli = map.poles.iter().map(|m| m.discrete[0].hypot(m.discrete[1]));
    let largest = moduli.fold(0.0, f64::max);
    let result = format!("The largest pole has modulus {}; below 1 is stable.", text(largest, 4));
    Figure { columns: 2, ..Figure::new("Poles and zeros", panels) }.stating(result)
}

/// What lies far outside is not drawn: it would leave nothing of the rest to be seen.
fn near_point(p: (f64, f64), reach: f64) -> (f64, f64) {
    if p.0.hypot(p.1) <= reach { p } else { GAP }
}

fn with_ellipses(panel: Panel, of: [(Vec<(f64, f64)>, Color); 2]) -> Panel {
    let mut name = "95 % confidence";
    of.into_iter().filter(|(points, _)| points.iter().any(|p| p.0.is_finite())).fold(
        panel,
        |panel, (points, color)| {
            let style = Style::dashed(color).width(1.0);
            panel.with(Series::shape(std::mem::take(&mut name), points, style))
        },
    )
}

/// The 95 % ellipse of a pole in the s-plane: s = ln(z)/T moves by dz/(zT).
fn continuous_ellipse(m: &Mode) -> Option<Vec<(f64, f64)>> {
    let (s, spread) = (m.continuous?, m.spread?);
    let [re, im] = m.discrete;
    let size = re * re + im * im;
    let logarithm = (0.5 * size.ln()).hypot(im.atan2(re));
    let sample_time = logarithm / s[0].hypot(s[1]);
    let per = sample_time * size;
    if per > 0.0 { Some(ellipse(s, spread, (re / per, -im / per), im != 0.0)) } else { None }
}

/// The ellipse that holds a point with 95 % probability, its moves turned and scaled by a complex
/// `factor`, and its mirror image. Of a real point it is a piece of the real axis.
fn ellipse(at: [f64; 2], spread: Spread, factor: (f64, f64), mirrored: bool) -> Vec<(f64, f64)> {
    // χ² with one and with two degrees of freedom at 95 %.
    let real = spread.variance_im == 0.0;
    let radius = f64::sqrt(if real { 3.841 } else { 5.991 });
    // Cholesky factor of the covariance.
    let first = spread.variance_re.max(0.0).sqrt();
    let across = if first > 0.0 { spread.covariance / first } else { 0.0 };
    let second = (spread.variance_im - across * across).max(0.0).sqrt();
    if real && !mirrored {
        let (x, y) = (factor.0 * radius * first, factor.1 * radius * first);
        return vec![(at[0] - x, at[1] - y), (at[0] + x, at[1] + y), GAP];
    }
    let point = |k: i32| {
        let (sin, cos) = (TAU * f64::from(k) / 72.0).sin_cos();
        let (x, y) = (radius * first * cos, radius * (across * cos + second * sin));
        (at[0] + factor.0 * x - factor.1 * y, at[1] + factor.0 * y + factor.1 * x)
    };
    let mut points: Vec<(f64, f64)> = (0..=72).map(point).chain([GAP]).collect();
    if mirrored {
        points.extend((0..=72).map(point).map(|(x, y)| (x, -y)).chain([GAP]));
    }
    points
}
