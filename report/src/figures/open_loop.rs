//! The open loop of a design: Bode and Nyquist plots with its margins.

use super::{DEG, text};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style, Symbol};
use crate::palette::{BLACK, BLUE, GREEN, GREY, VERMILION};
use std::f64::consts::TAU;
use steerwright_formats::Margins;

/// The open loop's frequency response (real and imaginary part), broken at the plant's input, and its
/// margins.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub struct OpenLoop {
    pub frequency_hz: Vec<f64>,
    pub real: Vec<f64>,
    pub imaginary: Vec<f64>,
    pub margins: Margins,
    /// The required modulus margin.
    pub required_modulus_margin: Option<f64>,
}

/// Gain and phase over frequency, with crossover, gain and phase margin.
pub fn bode(open: &OpenLoop) -> Figure {
    let m = &open.margins;
    let parts = open.real.iter().zip(&open.imaginary);
    let decibel: Vec<f64> = parts.clone().map(|(re, im)| 20.0 * re.hypot(*im).log10()).collect();
    let mut phase = Vec::with_capacity(decibel.len());
    let mut before = f64::NAN;
    for (re, im) in parts {
        // Continuous, and below 0 from the integrators on.
        let mut angle = im.atan2(*re) * DEG;
        if before.is_nan() && angle > 0.0 {
            angle -= 360.0;
        }
        while angle - before > 180.0 {
            angle -= 360.0;
        }
        while before - angle > 180.0 {
            angle += 360.0;
        }
        before = angle;
        phase.push(angle);
    }
    let gain_margin = match m.gain_margin_db {
        Some(margin) => format!("gain margin {} dB", text(margin, 1)),
        None => "gain margin unlimited".into(),
    };
    let phase_margin = m.phase_margin_deg.map(|v| format!("phase margin {} deg", text(v, 1)));
    let f = &open.frequency_hz;
    let line = Style::line(BLUE).width(2.0);
    let mut gain = Panel::new("Frequency (Hz)", "Gain (dB)")
        .with(Series::over("loop", f, (&decibel, 1.0), line).noted(format!(" ({gain_margin})")))
        .mark(Mark::new("", MarkPlace::YLine(0.0), GREY));
    let in_parentheses = match phase_margin.as_ref() {
        Some(m) => format!(" ({m})"),
        None => String::new(),
    };
    let mut angle = Panel::new("Frequency (Hz)", "Phase (deg)")
        .with(Series::over("loop", f, (&phase, 1.0), line).noted(in_parentheses))
        .mark(Mark::new("−180 deg", MarkPlace::YLine(-180.0), VERMILION));
    if let Some(crossover) = m.crossover_radps {
        let at = crossover / TAU;
        let name = format!("crossover at {} Hz", text(at, 2));
        gain = gain.mark(Mark::new(name, MarkPlace::XLine(at), BLACK));
        angle = angle.mark(Mark::new("", MarkPlace::XLine(at), BLACK));
    }
    // Far below that the phase winds down for nothing.
    angle.y_limits = Some((-400.0, -60.0));
    let panels = [gain, angle].map(|p| Panel { x_log: true, ..p }).to_vec();
    let margins: Vec<_> = [Some(gain_margin), phase_margin].into_iter().flatten().collect();
    Figure::new("Open loop, sampled, with its delay", panels)
        .stating(format!("The loop has {}.", margins.join(" and ")))
}

/// The loop in the complex plane with the disc about −1 that the modulus margin keeps free.
pub fn nyquist(open: &OpenLoop) -> Figure {
    const REACH: f64 = 2.5;
    let near: Vec<(f64, f64)> = open
        .real
        .iter()
        .zip(&open.imaginary)
        .map(|(re, im)| {
            let far = re.hypot(*im) > REACH;
            if far { (f64::NAN, f64::NAN) } else { (*re, *im) }
        })
        .collect();
    let circle = |x: f64, radius: f64| -> Vec<(f64, f64)> {
        (0..=180)
            .map(|k| (TAU * f64::from(k) / 180.0).sin_cos())
            .map(|(s, c)| (x + radius * c, radius * s))
            .collect()
    };
    let m = &open.margins;
    let thin = |color| Style::line(color).width(1.0);
    let name = format!("modulus margin {}", text(m.modulus_margin, 3));
    let mut panel = Panel::new("Real part (1)", "Imaginary part (1)")
        .with(Series::new("loop", near, Style::line(BLUE).width(2.0)))
        .with(Series::shape("unit circle", circle(0.0, 1.0), thin(GREY)))
        .with(Series::shape(name, circle(-1.0, m.modulus_margin), thin(GREEN)))
        .with(Series::shape("−1", vec![(-1.0, 0.0)], Style::symbols(VERMILION, Symbol::Dot, 4.0)));
    if let Some(asked) = open.required_modulus_margin.filter(|asked| *asked > 0.0) {
        let style = Style::dashed(VERMILION).width(1.0);
        panel = panel.with(Series::shape(format!("asked: {asked}"), circle(-1.0, asked), style));
    }
    panel.equal_aspect = true;
    Figure::new("Open loop in the complex plane", vec![panel]).stating(format!(
        "The loop stays {} away from −1 (modulus margin).",
        text(m.modulus_margin, 3)
    ))
}
