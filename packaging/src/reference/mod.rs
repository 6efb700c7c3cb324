//! The reference run: inputs that excite the FMU, and its outputs.
//!
//! The files in `extra/io.github.steerwright/reference/`, whose rules the documentation page of the archive
//! states: `input.csv`, `result.csv`, and `reference.json` with start, stop, step and absolute tolerance. The
//! result is rounded to 1e-10, so that it does not depend on the last bits of the platform's sine.

use crate::Error;
use model_description::{Causality, Kind, ModelDescription, Value, Variable};
use serde::Serialize;
use steerwright_units::{Fmu, Moment, Running, Scenario};

/// Seconds of a scenario.
const SCENARIO: f64 = 10.0;
/// Most steps of the run, however small the step.
const MOST_STEPS: u32 = 10_000;
/// Most rows of a file.
const MOST_ROWS: u32 = 1_000;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Reference {
    schema: &'static str,
    input: &'static str,
    result: &'static str,
    start_time: f64,
    stop_time: f64,
    step_size: f64,
    absolute_tolerance: f64,
}

/// The three files: `reference.json`, the inputs and the results.
pub(crate) struct Files {
    pub(crate) description: String,
    pub(crate) input: Vec<u8>,
    pub(crate) result: Vec<u8>,
}

pub(crate) fn run(
    fmu: Fmu,
    document: &str,
    file: &str,
    resources: Vec<(String, Vec<u8>)>,
    description: &ModelDescription,
    [step, duration]: [f64; 2],
) -> Result<Files, Error> {
    let failed =
        |time: f64| move |problem| Error::Reference { file: file.to_owned(), time, problem };
    let mut unit = fmu.open(resources).map_err(failed(0.0))?;
    let of = |causality| {
        description.variables.iter().filter(move |v| v.causality == causality).collect::<Vec<_>>()
    };
    let (inputs, outputs) = (of(Causality::Input), of(Causality::Output));
    let steps = steps(step, duration);
    let every = steps.div_ceil(MOST_ROWS - 1);
    let scenario = fmu.scenario(document, file)?;
    let pace = SCENARIO / (f64::from(steps) * step);

    let mut input = ReferenceRows::new(&inputs);
    let mut result = ReferenceRows::new(&outputs);
    let mut largest = 0.0_f64;
    for k in 0..=steps {
        let time = time_at(k, step);
        if k > 0 {
            // The step that ends here, with the inputs set at its beginning.
            let begin = f64::from(k - 1) * step;
            unit.step(begin, step).map_err(failed(begin))?;
        }
        let mut given = None;
        let moment = Moment { time, course: time * pace };
        if k % every == 0 && (k < steps || k == 0) {
            given = Some(inputs.iter().map(|v| value(&scenario, v, moment)).collect::<Vec<_>>());
        }
        if k == 0 {
            set(&mut *unit, &inputs, given.as_deref());
            unit.exit_initialization(0.0).map_err(failed(0.0))?;
        }
        if k % every == 0 || k == steps {
            let values: Vec<Option<Value>> =
                outputs.iter().map(|v| unit.get(v.reference)).collect();
            for value in values.iter().flatten().filter_map(Value::as_number) {
                if !value.is_finite() {
                    return Err(failed(time)("an output is not finite".to_owned()));
                }
                largest = largest.max(value.abs());
            }
            result.push(time, values.into_iter().map(|v| v.unwrap_or(Value::Real(0.0))));
        }
        if let Some(given) = given {
            if k > 0 {
                set(&mut *unit, &inputs, Some(&given));
            }
            // Inputs without part in the scenario keep their start values.
            let values = inputs
                .iter()
                .zip(given)
                .map(|(v, value)| value.or_else(|| v.start.clone()).unwrap_or(Value::Real(0.0)));
            input.push(time, values);
        }
    }

    let reference = Reference {
        schema: "steerwright/reference/1",
        input: "input.csv",
        result: "result.csv",
        start_time: 0.0,
        stop_time: time_at(steps, step),
        step_size: step,
        // A few parts in 1e12 where the numbers are large.
        absolute_tolerance: (largest * 1e-12).max(1e-9),
    };
    let description = serde_json::to_string_pretty(&reference).unwrap_or_default() + "\n";
    Ok(Files { description, input: input.finish(), result: result.finish() })
}

/// The time after `k` steps, tidied unless steps are as small as the digits that would be cut.
fn time_at(k: u32, step: f64) -> f64 {
    let time = f64::from(k) * step;
    if step >= 1e-6 { rounded(time) } else { time }
}

/// How many steps the run of some seconds has: at least one.
fn steps(step: f64, duration: f64) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within 1 and MOST_STEPS
    let steps = (duration / step + 1e-9).floor().clamp(1.0, f64::from(MOST_STEPS)) as u32;
    steps
}

/// The value of an input from a moment on; `None` where it keeps its start value.
fn value(scenario: &Scenario, input: &Variable, moment: Moment) -> Option<Value> {
    let number = scenario.value(&input.name, moment)?;
    match input.kind {
        Kind::Real => {
            let (min, max) = (input.min.unwrap_or(f64::MIN), input.max.unwrap_or(f64::MAX));
            Some(Value::Real(rounded(number.max(min).min(max))))
        }
        #[allow(clippy::cast_possible_truncation)] // saturates
        Kind::Integer => Some(Value::Integer(number as i32)),
        Kind::Boolean => Some(Value::Boolean(number != 0.0)),
        Kind::String => None,
    }
}

fn set(unit: &mut dyn Running, inputs: &[&Variable], values: Option<&[Option<Value>]>) {
    for (variable, value) in inputs.iter().zip(values.unwrap_or_default()) {
        if let Some(value) = value.as_ref().or(variable.start.as_ref()) {
            unit.set(variable.reference, value);
        }
    }
}

/// To 1e-10, so that the text is short and the same everywhere.
fn rounded(value: f64) -> f64 {
    let scaled = (value * 1e10).round();
    // Beyond 2^53 the value has no such digits.
    if scaled.abs() < 9e15 { scaled / 1e10 + 0.0 } else { value }
}

/// A CSV file being written.
struct ReferenceRows(csv::Writer<Vec<u8>>);

impl ReferenceRows {
    fn new(variables: &[&Variable]) -> Self {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let names = std::iter::once("time").chain(variables.iter().map(|v| v.name.as_str()));
        // Writing to a vector cannot fail.
        let _ = writer.write_record(names);
        Self(writer)
    }

    fn push(&mut self, time: f64, values: impl Iterator<Item = Value>) {
        let values = values.map(|value| match value {
            Value::Real(value) => rounded(value).to_string(),
            Value::Integer(value) => value.to_string(),
            Value::Boolean(value) => u8::from(value).to_string(),
            Value::String(text) => text,
        });
        let _ = self.0.write_record(std::iter::once(time.to_string()).chain(values));
    }

    fn finish(self) -> Vec<u8> {
        self.0.into_inner().unwrap_or_default()
    }
}
