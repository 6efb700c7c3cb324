//! The section on the reliability of the model.

use super::{optional, significant, value};
use crate::figures::{self, text};
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    Evidence, FrequencyResponse, HeldOut, Information, Plant, PoleZeroMap, ResidualCorrelation,
};

/// The evidence behind the model; `None` where a file holds none.
pub(crate) fn evidence(plant: &Plant) -> Option<Section> {
    let e = &plant.evidence;
    let mut blocks = Vec::new();
    blocks.extend(e.held_out.iter().flat_map(held_out));
    blocks.extend(e.residuals.iter().flat_map(|r| residuals(r, plant)));
    blocks.extend(e.frequency_response.iter().flat_map(|r| response(r, plant)));
    blocks.extend(e.poles_and_zeros.iter().flat_map(poles_and_zeros));
    if blocks.is_empty() {
        None
    } else {
        Some(Section::new("How far the model can be trusted", blocks))
    }
}

fn held_out(h: &HeldOut) -> Vec<Block> {
    let mut table =
        Table::new(["validation data, yaw rate up to", "fit", "variance accounted for"]);
    for p in &h.predictions {
        let ahead = match (p.steps, p.ahead_s) {
            (Some(1), Some(s)) => format!("{} s before (one sample)", significant(s)),
            (_, Some(s)) => format!("{} s before", significant(s)),
            _ => "never (simulation)".into(),
        };
        let uncertainty = match (p.steps, h.fit_standard_error) {
            (None, Some(error)) => format!(" ± {}", text(2.0 * error, 2)),
            _ => String::new(),
        };
        table.push([
            ahead,
            format!("{}{uncertainty}\u{a0}%", text(p.fit, 2)),
            value(p.variance_accounted_for, 2, "%"),
        ]);
    }
    let uncertainty = match h.fit_standard_error {
        Some(_) => format!(
            "The ± is two standard errors, by leaving out each of {} blocks of time in turn: the \
             scatter between drives of the same kind.",
            h.blocks
        ),
        None => format!("The fit has no ±: {}.", h.without_standard_error()),
    };
    let caption = format!(
        "The longer a prediction, the less it depends on the measured yaw rate. {uncertainty}"
    );
    vec![
        Block::Heading("Prediction of the validation data".into()),
        Block::Details(vec![Block::Table(table)]),
        Block::figure(figures::prediction(h), 280, caption),
    ]
}

fn residuals(r: &ResidualCorrelation, plant: &Plant) -> Vec<Block> {
    vec![
        Block::Heading("Residuals".into()),
        Block::figure(
            figures::residuals(r, plant.discrete.sample_time_s),
            320,
            "Left: structure in time that the noise model misses. Right, positive lags: effects of \
             the steering that the model misses; negative lags, where the positive ones are clean: \
             the driver's reaction to the yaw rate, which is feedback. The tests weigh all lags \
             together and allow for the steering's own memory.",
        ),
    ]
}

fn response(r: &FrequencyResponse, plant: &Plant) -> Vec<Block> {
    let mut blocks = vec![Block::Heading("Frequency response".into())];
    if !r.bands.is_empty() {
        let mut table = Table::new(["band", "± model's gain", "± model's phase"]);
        for b in &r.bands {
            table.push([
                band_name(b.from_hz, b.to_hz),
                value(200.0 * b.standard_error, 1, "%"),
                value(2.0 * figures::DEG * b.standard_error, 1, "deg"),
            ]);
        }
        let text = "Each band as a whole, where steering explains most of the yaw rate; two standard errors.";
        blocks.push(Block::Details(vec![Block::Table(table), Block::Text(text.into())]));
    }
    let caption = format!(
        "Measured by Welch's method from {} independent averages, {} Hz apart; shown where the \
         coherence is significant.",
        text(r.averages, 0),
        significant(r.resolution_hz)
    );
    blocks.push(Block::figure(figures::frequency_response(r, plant.input), 760, caption));
    blocks
}

fn poles_and_zeros(map: &PoleZeroMap) -> Vec<Block> {
    let mut table = Table::new(["", "z", "s", "natural frequency", "damping", "time constant"]);
    let rad = "rad/s";
    for (name, modes) in [("pole", &map.poles), ("zero", &map.zeros)] {
        for m in modes {
            let name = if m.discrete[1] == 0.0 { name.to_owned() } else { format!("{name} pair") };
            table.push([
                name,
                complex(m.discrete, 3, ""),
                match m.continuous {
                    Some(s) => complex(s, 2, rad),
                    None => "–".into(),
                },
                optional(m.natural_frequency_hz, 3, "Hz", "–"),
                optional(m.damping, 3, "", "–"),
                optional(m.time_constant_s, 3, "s", "–"),
            ]);
        }
    }
    for z in map.continuous_zeros.iter().filter(|z| z[1] >= 0.0) {
        let name = if z[1] == 0.0 { "zero, continuous" } else { "zero pair, continuous" };
        table.push([name.into(), "–".into(), complex(*z, 2, rad)]);
    }
    vec![
        Block::Heading("Poles and zeros".into()),
        Block::Details(vec![Block::Table(table)]),
        Block::figure(
            figures::poles_and_zeros(map),
            440,
            "Left the discrete model, right s = ln(z)/T of its poles with the zeros of the \
             continuous model. Zeros far outside are in the table alone; those of the discrete \
             model without a continuous one come from sampling. Dashed: what holds the true one \
             with 95 % probability, for a model of the right order.",
        ),
    ]
}

fn complex([re, im]: [f64; 2], digits: usize, unit: &str) -> String {
    if im == 0.0 {
        return value(re, digits, unit);
    }
    let space = if unit.is_empty() { "" } else { "\u{a0}" };
    format!("{}\u{a0}±\u{a0}{}j{space}{unit}", text(re, digits), text(im.abs(), digits))
}

/// The frequencies at which the log is informative, and the model there compared with the measured response.
pub(super) fn bands(e: &Evidence) -> Vec<Block> {
    let x = &e.excitation;
    if x.bands.is_empty() {
        return Vec::new();
    }
    let headers = [
        "band",
        "road wheel",
        "yaw rate",
        "explained",
        "gain known to",
        "",
        "model's gain",
        "phase",
    ];
    let compared = e.frequency_response.as_ref().map_or(&[][..], |r| &r.bands);
    let mut table = Table::new(headers);
    for b in &x.bands {
        let of_model = compared.iter().find(|d| d.from_hz == b.from_hz && d.to_hz == b.to_hz);
        let [gain, phase] = match of_model {
            Some(d) => [
                format!("×{:.3}", d.gain_ratio),
                // Without the sign of a value that is rounded to −0.
                format!("{:+.1}°", (10.0 * figures::DEG * d.phase_ahead_rad).round() / 10.0 + 0.0),
            ],
            None => ["–".into(), "–".into()],
        };
        table.push([
            band_name(b.from_hz, b.to_hz),
            format!("{:.3}°", figures::DEG * b.road_wheel_std_rad),
            format!("{:.3}\u{a0}°/s", figures::DEG * b.yaw_rate_std_radps),
            value(100.0 * b.coherence, 0, "%"),
            if b.information == Information::None {
                "–".into()
            } else {
                known_to(b.relative_error)
            },
            match b.information {
                Information::Good => "good",
                Information::Weak => "weak",
                Information::None => "no information",
            }
            .into(),
            gain,
            phase,
        ]);
    }
    let mut sentence = match x.silent_from_hz() {
        Some(f) if f > 0.0 => format!("Above {f} Hz there is no information in this log"),
        Some(_) => "There is no information in this log".to_owned(),
        None => "The log has information in all bands".to_owned(),
    };
    if let Some(p) = x.persistence {
        let more = if p.order == p.tried { "at least " } else { "" };
        sentence += &format!("; the steering is persistently exciting of order {more}{}", p.order);
    }
    vec![
        Block::Table(table),
        Block::Text(format!(
            "{sentence}. Angles and rates are standard deviations; the gain's ± is twice its standard error, about \
             95 %; the model's gain is relative to the measured one, its phase positive where the model is ahead."
        )),
    ]
}

fn band_name(from_hz: f64, to_hz: f64) -> String {
    format!("{from_hz} to {to_hz}\u{a0}Hz")
}

fn known_to(relative_error: f64) -> String {
    let twice = 200.0 * relative_error;
    format!("±{}", value(twice, if twice < 10.0 { 1 } else { 0 }, "%"))
}
