//! The sections of the report, each from a file or two.

mod bicycle;
mod controller;
mod evidence;
mod facts;
mod identification;
mod manoeuvre;
mod model;
mod outcome;
mod over_speed;
mod robustness;
mod speed_controller;
mod vehicle_facts;
mod words;

pub use controller::{controller_section, shortfalls};
pub use identification::channel_table;
pub use manoeuvre::{manoeuvre_page, manoeuvre_sections};
pub use speed_controller::speed_controller_section;

use crate::figures::text;
use crate::html::report_html;
use crate::report::Report;
use crate::section::{Block, Section, Tone};
use steerwright_formats::{Grade, Quality};

impl Report<'_> {
    /// What is shown of everything that is known: the verdict first.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let mut out = vec![outcome::summary(self)];
        if let Some(model) = self.model {
            out.extend(model::sections(model, self.traces, self.bicycle_fit));
            if self.channels.is_some() || model.multivariable().is_some() {
                out.push(model::figures_of_channels(model, self.channels));
            }
        }
        if let Some(bicycle) = self.bicycle {
            out.push(bicycle::bicycle(bicycle, self.bicycle_fit));
        }
        out.extend(self.controllers.iter().map(controller::controller_section));
        if self.path.is_some() || !self.tracks.is_empty() {
            out.push(outcome::tracking(self.path, &self.tracks));
        }
        out.push(outcome::provenance(self));
        out
    }

    /// The page.
    #[must_use]
    pub fn to_html(&self) -> String {
        let fit = "a fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) in percent, of a simulation unless said otherwise.";
        let is_of_channels = self.channels.is_some()
            || self.model.is_some_and(|model| model.multivariable().is_some());
        let units = if is_of_channels {
            "Signals are in the units of the log, or of their names"
        } else {
            "Angles are in degrees, positive to the left (ISO 8855)"
        };
        report_html(&self.title, &format!("{units}; {fit}"), &self.sections())
    }
}

/// The quality of a model, or of what was designed on it, as the verdict.
pub(crate) fn quality_note(quality: &Quality) -> Block {
    let tone = match quality.grade {
        Grade::Pass => Tone::Good,
        Grade::Warn => Tone::Neutral,
        Grade::Fail => Tone::Bad,
    };
    let codes =
        if quality.reasons.is_empty() { String::new() } else { format!(" ({})", quality.codes()) };
    let reasons = quality
        .unstated_reasons()
        .map(|r| format!(" {} ({}): {}.", r.grade, r.code.name(), r.message));
    Block::Note {
        tone,
        title: format!("quality {}{codes}", quality.grade),
        text: quality.summary.clone() + &reasons.collect::<String>(),
    }
}

/// A value in a table, with its unit.
fn value(value: f64, digits: usize, unit: &str) -> String {
    if unit.is_empty() || !value.is_finite() {
        return text(value, digits);
    }
    // A number stays on the line of its unit.
    format!("{}\u{a0}{unit}", text(value, digits))
}

fn length(length_m: f64) -> String {
    format!("{}\u{a0}m", crate::figures::metres(length_m))
}

/// A value that may be absent.
fn optional(number: Option<f64>, digits: usize, unit: &str, absent: &str) -> String {
    match number {
        Some(n) => value(n, digits, unit),
        None => absent.to_owned(),
    }
}

/// Up to four digits that count, whatever the size.
fn significant(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return text(number, 0);
    }
    let exponent = number.abs().log10().floor();
    if !(-4.0..6.0).contains(&exponent) {
        return format!("{number:.3e}").replace('-', "−");
    }
    let digits = text(number, (3.0 - exponent).clamp(0.0, 8.0) as usize);
    if digits.contains('.') {
        return digits.trim_end_matches('0').trim_end_matches('.').into();
    }
    digits
}

fn met(ok: bool) -> String {
    if ok { "met" } else { "not met" }.into()
}
