//! The parameters of a stack, and those that a model does not determine.

use crate::Error;
use crate::lateral::Quantity;
use serde::Serialize;
use steerwright_formats::{Grade, Quality};

/// The form of a stack's file: YAML of ROS 2, TOML, `NAME,VALUE`, or the table of QGroundControl.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[rustfmt::skip]
pub(crate) enum FileForm { Ros2, Toml, Csv, QGroundControl }

/// Numbers that the model does not hold, at the road wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StatedValues {
    /// Largest road-wheel angle, rad.
    pub max_angle_rad: Option<f64>,
    /// Largest rate of the road wheel, rad/s.
    pub max_rate_radps: Option<f64>,
    /// Wheelbase, m; takes the place of the model's.
    pub wheelbase_m: Option<f64>,
}

impl StatedValues {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let quarter = std::f64::consts::FRAC_PI_2;
        for (name, value, most, text) in [
            ("largest road-wheel angle", self.max_angle_rad, quarter, " and less than π/2 rad"),
            ("largest rate of the road wheel", self.max_rate_radps, f64::INFINITY, ""),
            ("wheelbase", self.wheelbase_m, f64::INFINITY, ""),
        ] {
            if let Some(value) = value
                && !(value > 0.0 && value < most)
            {
                return Err(Error::Stated { name, value, most: text });
            }
        }
        Ok(())
    }
}

/// A parameter of a stack.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// The part of the stack, such as its file.
    pub group: &'static str,
    /// The stack's name of it.
    pub key: &'static str,
    /// The value in the stack's unit, and its standard error.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// The stack's unit.
    pub unit: &'static str,
    /// What the number is, in the stack's formula.
    pub note: String,
}

/// A parameter that is not determined.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Missing {
    /// The stack's name of it.
    pub key: &'static str,
    /// Why it is left out, and how to obtain it.
    pub reason: String,
}

/// The parameters of a stack.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Export {
    /// The stack's name.
    pub stack: &'static str,
    #[serde(skip)]
    pub(crate) form: FileForm,
    /// The model's name.
    pub model: String,
    /// The model's quality.
    pub quality: Grade,
    /// The reason codes of the quality.
    pub reasons: String,
    /// Signs, coordinates and formulas of the stack.
    pub convention: Vec<String>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Those that the model does not determine.
    pub missing: Vec<Missing>,
}

impl Export {
    pub(crate) fn new(stack: &'static str, form: FileForm, model: &str, quality: &Quality) -> Self {
        Self {
            stack,
            form,
            model: model.into(),
            quality: quality.grade,
            reasons: quality.codes(),
            convention: Vec::new(),
            parameters: Vec::new(),
            missing: Vec::new(),
        }
    }

    pub(crate) fn convention(&mut self, line: impl Into<String>) {
        self.convention.push(line.into());
    }

    pub(crate) fn set(
        &mut self,
        group: &'static str,
        key: &'static str,
        quantity: Quantity,
        unit: &'static str,
        note: impl Into<String>,
    ) {
        let parameter = Parameter { group, key, quantity, unit, note: note.into() };
        // Those of a group stand together.
        let last = self.parameters.iter().rposition(|p| p.group == group);
        let at = last.map_or(self.parameters.len(), |last| last + 1);
        self.parameters.insert(at, parameter);
    }

    pub(crate) fn missing(&mut self, key: &'static str, reason: impl Into<String>) {
        self.missing.push(Missing { key, reason: reason.into() });
    }

    /// The largest road-wheel angle and rate, or why they are missing. `per_unit` turns rad/s into the stack's unit.
    pub(crate) fn limits(
        &mut self,
        group: &'static str,
        stated: &StatedValues,
        (largest, driven): (Option<Quantity>, Option<f64>),
        [angle, rate]: [&'static str; 2],
        (rate_unit, per_unit): (&'static str, f64),
    ) {
        match stated.max_angle_rad {
            Some(limit) => {
                self.set(group, angle, Quantity::stated(limit), "rad", "stated, at the road wheel");
            }
            None => self.missing(
                angle,
                "a drive does not show the stops of the steering; measure the largest angle and state it",
            ),
        }
        match (stated.max_rate_radps, largest, driven) {
            (Some(limit), ..) => {
                let limit = Quantity::stated(limit * per_unit);
                self.set(group, rate, limit, rate_unit, "stated, at the road wheel");
            }
            (None, Some(largest), _) => {
                let note = "largest rate of the actuator of the model, at the road wheel";
                self.set(group, rate, largest.times(per_unit), rate_unit, note);
            }
            (None, None, Some(driven)) => self.missing(
                rate,
                format!(
                    "the fastest steering of the drive, {:.4} {rate_unit} at the road wheel, is only a lower bound; command a large step of the steering at rest, and state its rate",
                    driven * per_unit
                ),
            ),
            (None, None, None) => self.missing(
                rate,
                "the model does not state it; command a large step of the steering at rest, and state its rate",
            ),
        }
    }
}
