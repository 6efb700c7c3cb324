//! The file of each stack's own tools, with standard errors and conventions as comments.

use crate::export::{Export, FileForm, Parameter};
use std::fmt::Write;
use steerwright_formats::Grade;

/// The start of each file.
pub const MARK: &str = "# steerwright: parameters for ";

impl Export {
    /// The file.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!("{MARK}{}\n# model: {}\n", self.stack, one_line(&self.model));
        let grade = match self.quality {
            Grade::Pass => "pass",
            Grade::Warn => "warn",
            Grade::Fail => "fail",
        };
        let reasons =
            if self.reasons.is_empty() { String::new() } else { format!(" ({})", self.reasons) };
        let _ = writeln!(text, "# quality of the model: {grade}{reasons}");
        for line in &self.convention {
            let _ = writeln!(text, "# {line}");
        }
        if self.form == FileForm::Ros2 {
            text += "/**:\n  ros__parameters:\n";
        }
        let mut group = "";
        for parameter in &self.parameters {
            if parameter.group != group {
                group = parameter.group;
                text += &heading(self.form, group);
            }
            text += &line(self.form, parameter);
        }
        if !self.missing.is_empty() {
            text += "\n# not determined by this model:\n";
        }
        for missing in &self.missing {
            let _ = writeln!(text, "# {}: {}", missing.key, one_line(&missing.reason));
        }
        text
    }
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn heading(form: FileForm, group: &str) -> String {
    match form {
        FileForm::Ros2 => format!("    # {group}\n"),
        FileForm::Toml => format!("[{group}]\n"),
        FileForm::Csv | FileForm::QGroundControl => format!("# {group}\n"),
    }
}

fn line(form: FileForm, p: &Parameter) -> String {
    let (key, value) = (p.key, number(p.quantity.value));
    let error = match p.quantity.standard_error {
        Some(error) => format!("standard error {}", number(error)),
        None => "no standard error".into(),
    };
    let comment = format!("{}, {error}: {}", p.unit, one_line(&p.note));
    match form {
        FileForm::Ros2 => format!("    {key}: {value}  # {comment}\n"),
        FileForm::Toml => format!("{key} = {value}  # {comment}\n"),
        FileForm::Csv => format!("# {key}: {comment}\n{key},{value}\n"),
        // Vehicle, component, and 9: the type of a 32-bit float in MAVLink.
        FileForm::QGroundControl => format!("# {key}: {comment}\n1\t1\t{key}\t{value}\t9\n"),
    }
}

/// Six significant digits, with a decimal point: without one, ROS 2 reads an integer.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0.0".into();
    }
    let decimals = (5 - value.abs().log10().floor() as i32).clamp(1, 9) as usize;
    let text = format!("{value:.decimals$}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.into() }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_a_decimal_point_and_six_digits() {
        for (value, text) in [
            (0.24, "0.24"),
            (1.0, "1.0"),
            (1234567.0, "1234567.0"),
            (-0.001_234_567_8, "-0.00123457"),
            (0.0, "0.0"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
