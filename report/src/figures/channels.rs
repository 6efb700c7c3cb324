//! The figures of a model whose inputs and outputs have names: outputs over time, and of a plant of any system frequency
//! responses by pair.

use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style};
use crate::figures::text;
use crate::palette::{BLACK, GREY, VERMILION};
use steerwright_formats::{
    Model, MultivariablePlant, NORMAL_95, OutputEvidence, PairEvidence, PlantOutput,
};

/// Measured and simulated outputs of a log, in the units of the channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChannelSignals {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Name, measured and simulated samples of each output.
    pub outputs: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Whether the sample is validation data.
    pub is_validation: Vec<bool>,
}

impl ChannelSignals {
    /// First and last time of each run of validation data.
    fn validation_ranges(&self) -> Vec<(f64, f64)> {
        let mut ranges: Vec<(f64, f64)> = Vec::new();
        let mut before = false;
        for (time, is_validation) in self.time_s.iter().zip(&self.is_validation) {
            match (is_validation, before, ranges.last_mut()) {
                (true, true, Some(range)) => range.1 = *time,
                (true, ..) => ranges.push((*time, *time)),
                _ => {}
            }
            before = *is_validation;
        }
        ranges
    }
}

/// The names of [`of_channels`].
pub const OF_CHANNELS: [&str; 2] = ["outputs", "gains"];

/// Every figure of a model whose inputs and outputs have names, as those of [`super::of_identification`]; that of the
/// outputs where the signals are there.
#[must_use]
pub fn of_channels(
    model: &Model,
    signals: Option<&ChannelSignals>,
) -> Vec<(&'static str, u32, Figure)> {
    /// Height of a row of panels, px.
    const ROW: u32 = 240;
    let height = |figure: &Figure| ROW * figure.panels.len().div_ceil(figure.columns) as u32 + 60;
    let [over_time, over_frequency] = OF_CHANNELS;
    let mut all = Vec::new();
    if let Some(signals) = signals {
        let figure = outputs(&fits(model, signals), signals);
        all.push((over_time, height(&figure), figure));
    }
    if let Some(plant) = model.multivariable() {
        let figure = gains(plant);
        all.push((over_frequency, height(&figure), figure));
    }
    all
}

/// The fits of the outputs on validation data, each with the label of its axis.
fn fits(model: &Model, signals: &ChannelSignals) -> Vec<(String, Option<f64>)> {
    let Some(plant) = model.multivariable() else {
        let [_, fit] = model.fits();
        return signals.outputs.iter().map(|(name, ..)| (name.clone(), fit)).collect();
    };
    let outputs = plant.outputs.iter().zip(&plant.evidence.outputs);
    let fit = |(output, evidence): (&PlantOutput, &OutputEvidence)| {
        (label(&output.name, &output.unit), Some(evidence.fit.validation))
    };
    outputs.map(fit).collect()
}

fn label(name: &str, unit: &str) -> String {
    if unit == "1" { name.to_owned() } else { format!("{name} ({unit})") }
}

/// Each output over time, measured and simulated, a panel each.
fn outputs(fits: &[(String, Option<f64>)], signals: &ChannelSignals) -> Figure {
    let mut panels = Vec::new();
    let mut stated = Vec::new();
    for ((label, fit), (name, measured, simulated)) in fits.iter().zip(&signals.outputs) {
        let line = Style::line(BLACK).width(1.1);
        let mut panel = Panel::new("Time (s)", label.clone())
            .with(Series::over("measured", &signals.time_s, (measured, 1.0), line))
            .with(Series::over(
                "simulated",
                &signals.time_s,
                (simulated, 1.0),
                Style::line(VERMILION),
            ));
        panel.y_limits = panel.limits_of_the_first();
        panel.link = "log";
        for (k, (from, to)) in signals.validation_ranges().into_iter().enumerate() {
            let name = if k == 0 { "validation data" } else { "" };
            panel = panel.mark(Mark::new(name, MarkPlace::XBand(from, to), GREY));
        }
        panels.push(panel);
        stated.extend(fit.map(|fit| format!("{name} by {} %", text(fit, 1))));
    }
    let figure = Figure::new("Measured and simulated outputs", panels);
    // Of another log than the plant's own the evidence states no fit.
    if !signals.is_validation.contains(&true) {
        return figure;
    }
    figure.stating(format!("On validation data the model fits {}.", stated.join(", ")))
}

/// The gain of each pair over frequency with its 95 % band, and the measured one.
fn gains(plant: &MultivariablePlant) -> Figure {
    let panel = |pair: &PairEvidence| {
        let of = |gain: fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
            let bands = pair.frequency_response.iter();
            bands
                .map(|b| {
                    let error = NORMAL_95 * b.magnitude_standard_error;
                    (b.frequency_hz, gain(b.magnitude, error))
                })
                .filter(|(_, gain)| *gain > 0.0)
                .collect()
        };
        let measured = pair.measured.iter().map(|m| (m.frequency_hz, m.gain)).collect();
        let band = Style::dashed(VERMILION).width(1.0);
        let mut panel =
            Panel::new("Frequency (Hz)", format!("{} over {}", pair.output, pair.input))
                .with(Series::new("measured", measured, Style::line(GREY)))
                .with(Series::new("model", of(|gain, _| gain), Style::line(VERMILION)))
                .with(Series::new("95 % band", of(|gain, error| gain + error), band))
                .with(Series::new("", of(|gain, error| gain - error), band));
        panel.x_log = true;
        panel.y_log = true;
        panel.link = "frequency";
        panel
    };
    let panels: Vec<Panel> = plant.evidence.pairs.iter().map(panel).collect();
    let mut figure = Figure::new("Gains", panels).stating(format!(
        "The gains of {} pairs over frequency, with the 95 % bands of the model.",
        plant.evidence.pairs.len()
    ));
    figure.columns = plant.inputs.len().min(3);
    figure
}
