//! `plant.json`, version 2: a linear plant of any system, from its named inputs to its named outputs.
//!
//! Version 1 is the [`Plant`](crate::Plant) of a vehicle, from steering to yaw rate, and is written and read as before.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::matrix::Matrix;
use crate::models::evidence::{ChannelSummary, CoherencePoint, Fits, OrderRow, ResidualTest};
use crate::models::state_space::{Continuous, Discrete};
use crate::models::uncertainty::{Estimate, EstimationFocus, FrequencyBand, UncertainPole};
use crate::provenance::Provenance;
use crate::quality::Quality;
use crate::unit::PhysicalUnit;
use serde::{Deserialize, Serialize};

/// Most inputs, most outputs and the largest order.
pub const MOST: usize = 64;

/// The identified plant: model, operating point, noise, evidence and provenance.
///
/// `x⁺ = A x + B (u − offset of u) + K e`, `y − offset of y = C x + D (u − offset of u) + e` (eq 3–5), each input delayed
/// by its `delay_s`. All values are in the units of the channels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultivariablePlant {
    /// `steerwright/plant/2`.
    pub schema: String,
    /// A name, such as the log's.
    pub name: String,
    /// The inputs u, in the order of the columns of B and D.
    pub inputs: Vec<PlantInput>,
    /// The outputs y, in the order of the rows of C and D.
    pub outputs: Vec<PlantOutput>,
    /// The model in innovation form: A n by n, B n by nu, C ny by n, D ny by nu, K n by ny.
    pub discrete: Discrete,
    /// The continuous model (eq 6–11): F n by n, G n by nu, H ny by n; absent if A has no real logarithm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<Continuous>,
    /// Covariance of the innovation e, ny by ny, in the products of the outputs' units.
    pub innovation_covariance: Matrix,
    /// The uncertainty of the model; absent if it was not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<MultivariableUncertainty>,
    /// The evidence for the quality of the model.
    pub evidence: MultivariableEvidence,
    /// Whether the model may be used.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// An input of the plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantInput {
    /// Name: letters, digits and `_`, unlike that of any other channel of the plant.
    pub name: String,
    /// The channel in the log.
    pub column: String,
    /// Unit, such as `V`; `1` without one.
    pub unit: String,
    /// The value about which the model is linear.
    pub offset: f64,
    /// Standard deviation in the estimation data.
    pub standard_deviation: f64,
    /// Pure delay of the input, a whole number of samples, s.
    pub delay_s: f64,
}

/// An output of the plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantOutput {
    /// Name: letters, digits and `_`, unlike that of any other channel of the plant.
    pub name: String,
    /// The channel in the log.
    pub column: String,
    /// Unit, such as `degC`; `1` without one.
    pub unit: String,
    /// The value about which the model is linear.
    pub offset: f64,
    /// Standard deviation in the estimation data.
    pub standard_deviation: f64,
}

/// The uncertainty of the model; standard errors are one standard deviation, to first order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultivariableUncertainty {
    /// The errors that the estimate minimises, which determines the covariance.
    pub focus: EstimationFocus,
    /// The eigenvalues of A.
    pub poles: Vec<UncertainPole>,
    /// The covariance factor, with one row for each independent standard normal number ξ: the change of the entries of A,
    /// B, C, D, K, each row by row, for ξ = 1. Changes of the state's basis only are left out.
    pub directions: Matrix,
}

/// The evidence for the quality of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultivariableEvidence {
    /// `n4sid`, `moesp`, `cva`, `ssarx` or `pbsid`: the method of the initial estimate.
    pub method: String,
    /// Block rows s of the Hankel matrices (past and future horizon).
    pub horizon: usize,
    /// Number of estimation samples.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Fits of all outputs together, each in units of its standard deviation, percent.
    pub fit: Fits,
    /// The evidence of each output.
    pub outputs: Vec<OutputEvidence>,
    /// The evidence of each pair: of the first output all inputs, then of the second.
    pub pairs: Vec<PairEvidence>,
    /// One row for each order tried.
    pub order_table: Vec<OrderRow>,
    /// Test of the estimation data for feedback from outputs to inputs; it passes where none is seen. Absent where the
    /// data are too few for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<ResidualTest>,
    /// Largest eigenvalue modulus of A before stability was enforced; absent if it was stable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stabilised_from: Option<f64>,
    /// Relative error ‖exp(F·T) − A‖/‖A‖ and the same for B, the larger (eq 9–10).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conversion_round_trip: Option<f64>,
    /// The channels of the log.
    pub channels: Vec<ChannelSummary>,
    /// Warnings of the log reader and of the identification.
    pub warnings: Vec<String>,
}

/// The evidence of one output, on validation data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputEvidence {
    /// Name of the output.
    pub output: String,
    /// Fits, percent.
    pub fit: Fits,
    /// Standard error of the simulation fit on validation data, percentage points (block jackknife); absent where the
    /// validation data are too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_standard_error: Option<f64>,
    /// Standard deviation of the one-step prediction errors on validation data, in the unit of the output.
    pub one_step_error: f64,
    /// Autocorrelation of the one-step residuals.
    pub whiteness: ResidualTest,
    /// Multiple coherence: the share of the output's power that all inputs together explain, by frequency.
    pub coherence: Vec<CoherencePoint>,
    /// The multiple coherence of unrelated signals stays below with a probability of 95 %.
    pub coherence_of_chance: f64,
}

/// The evidence of one pair of output and input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairEvidence {
    /// Name of the output.
    pub output: String,
    /// Name of the input.
    pub input: String,
    /// Pure delay that the impulse response shows; absent where it shows no response.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<PairDelay>,
    /// Correlation of the one-step residuals with the past input, on validation data.
    pub independence: ResidualTest,
    /// Gain at rest; absent without uncertainty, and for an integrator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_gain: Option<Estimate>,
    /// Response of the model with standard errors, with the delay of the input, in the output's unit over the input's.
    pub frequency_response: Vec<FrequencyBand>,
    /// Measured response by spectra of the whole log.
    pub measured: Vec<MeasuredPoint>,
}

/// The pure delay of a pair by the first lags of its impulse response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairDelay {
    /// Delay beyond that of a model without feedthrough, s: a whole number of samples.
    pub estimate_s: f64,
    /// The part of it that is the input's in the plant, s; the states of the model represent the rest.
    pub in_input_s: f64,
}

/// The measured response of a pair at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredPoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gain.
    pub gain: f64,
    /// Phase, rad, within ±π.
    pub phase_rad: f64,
    /// Radius of the confidence disk (95 %) about the response, in the unit of the gain.
    pub radius: f64,
}

impl MultivariablePlant {
    /// Order n of the model.
    #[must_use]
    pub fn order(&self) -> usize {
        self.discrete.a.rows()
    }
}

/// Names that no channel may have: the other variables of the plant, and the time, which is a column of every trajectory.
const TAKEN: [&str; 3] = ["noise_scale", "noise_seed", "time"];

/// The name of a channel as a variable: letters, digits and `_`, not a digit first, and none of those that are taken.
#[must_use]
pub fn variable_name(channel: &str) -> String {
    let mut name = String::new();
    for c in channel.trim().chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if c != '_' || !name.ends_with('_') {
            name.push(c);
        }
    }
    let name = name.trim_matches('_');
    match name.chars().next() {
        None => "channel".into(),
        Some(first) if first.is_ascii_digit() || TAKEN.contains(&name) => format!("c_{name}"),
        Some(_) => name.into(),
    }
}

impl Document for MultivariablePlant {
    const SCHEMA: &'static str = "steerwright/plant/2";

    fn check(&self, c: &mut Checker) {
        let (n, m, p) = (self.order(), self.inputs.len(), self.outputs.len());
        let counts = [(m, "inputs"), (p, "outputs"), (n, "discrete.A")];
        for (count, key) in counts {
            c.require((1..=MOST).contains(&count), key, || {
                format!("{count} stand here, expected 1 to {MOST}")
            });
        }
        let d = &self.discrete;
        c.positive(d.sample_time_s, "discrete.sample_time_s");
        for (matrix, rows, columns, key) in [
            (&d.a, n, n, "discrete.A"),
            (&d.b, n, m, "discrete.B"),
            (&d.c, p, n, "discrete.C"),
            (&d.d, p, m, "discrete.D"),
            (&d.k, n, p, "discrete.K"),
            (&self.innovation_covariance, p, p, "innovation_covariance"),
        ] {
            c.shape(matrix, rows, columns, key);
        }
        c.require(d.x0.len() == n, "discrete.x0", || {
            format!("{} entries, expected {n}", d.x0.len())
        });
        for (i, x) in d.x0.iter().enumerate() {
            c.finite(*x, &format!("discrete.x0[{i}]"));
        }
        if let Some(continuous) = &self.continuous {
            c.shape(&continuous.f, n, n, "continuous.F");
            c.shape(&continuous.g, n, m, "continuous.G");
            c.shape(&continuous.h, p, n, "continuous.H");
        }
        let inputs = self.inputs.iter().enumerate().map(|(k, i)| {
            (format!("inputs[{k}]."), &i.name, &i.unit, [i.offset, i.standard_deviation])
        });
        let outputs = self.outputs.iter().enumerate().map(|(k, o)| {
            (format!("outputs[{k}]."), &o.name, &o.unit, [o.offset, o.standard_deviation])
        });
        let mut names = std::collections::BTreeSet::new();
        for (at, name, unit, [offset, deviation]) in inputs.chain(outputs) {
            c.require(*name == variable_name(name), &format!("{at}name"), || {
                format!("`{name}` is no name of letters, digits and `_`")
            });
            c.require(names.insert(name.clone()), &format!("{at}name"), || {
                format!("`{name}` is the name of another channel")
            });
            c.require(PhysicalUnit::parse(unit).is_some(), &format!("{at}unit"), || {
                format!("`{unit}` is no unit known here")
            });
            c.finite(offset, &format!("{at}offset"));
            c.not_negative(deviation, &format!("{at}standard_deviation"));
        }
        for (k, input) in self.inputs.iter().enumerate() {
            let at = format!("inputs[{k}].delay_s");
            c.not_negative(input.delay_s, &at);
            let samples = input.delay_s / d.sample_time_s;
            c.require((samples - samples.round()).abs() < 1e-6, &at, || {
                format!("{} s is no whole number of samples", input.delay_s)
            });
        }
        if let Some(uncertainty) = &self.uncertainty {
            let found = uncertainty.poles.len();
            c.require(found == n, "uncertainty.poles", || format!("{found} poles, expected {n}"));
            let entries = n * n + n * m + p * n + p * m + n * p;
            let rows = uncertainty.directions.rows();
            if rows > 0 {
                c.shape(&uncertainty.directions, rows, entries, "uncertainty.directions");
            }
        }
        let e = &self.evidence;
        for (count, expected, key) in
            [(e.outputs.len(), p, "evidence.outputs"), (e.pairs.len(), m * p, "evidence.pairs")]
        {
            c.require(count == expected, key, || format!("{count} entries, expected {expected}"));
        }
        for (k, output) in e.outputs.iter().enumerate() {
            let at = format!("evidence.outputs[{k}].fit.");
            check_fields!(c.finite(output.fit, at): estimation validation validation_one_step);
        }
        for (k, pair) in e.pairs.iter().enumerate() {
            for (i, band) in pair.frequency_response.iter().enumerate() {
                let at = format!("evidence.pairs[{k}].frequency_response[{i}].");
                check_fields!(c.not_negative(band, at): frequency_hz magnitude
                    magnitude_standard_error phase_standard_error_rad);
                check_fields!(c.finite(band, at): phase_rad);
            }
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for MultivariablePlant {
    fn facts(self) -> Facts {
        let order = self.order();
        let e = self.evidence;
        let mut facts = quality_facts(self.quality);
        facts.extend(e.warnings.into_iter().map(|line| Fact::new("warning", line, "")));
        let by_output = e.outputs.iter().map(|o| format!("{} {:.2} %", o.output, o.fit.validation));
        facts.extend([
            Fact::new("fit_held_out", e.fit.validation, "%"),
            Fact::new("fit_held_out_one_step", e.fit.validation_one_step, "%"),
            Fact::new("fit_held_out_by_output", by_output.collect::<Vec<_>>().join(", "), ""),
        ]);
        facts.extend([
            Fact::new("fit_estimation", e.fit.estimation, "%"),
            Fact::new("method", e.method, ""),
            Fact::new("order", order, ""),
            Fact::new("horizon", e.horizon, ""),
            Fact::new("estimation_samples", e.estimation_samples, ""),
            Fact::new("held_out_samples", e.validation_samples, ""),
            Fact::new("sample_time", self.discrete.sample_time_s, "s"),
        ]);
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}

#[cfg(test)]
mod tests {
    use super::variable_name;

    #[test]
    fn names_of_channels_become_names_of_variables() {
        for (channel, name) in [
            ("outlet temperature", "outlet_temperature"),
            ("u", "u"),
            ("imu/angular.z", "imu_angular_z"),
            ("2 stages", "c_2_stages"),
            ("°", "channel"),
            ("A + 0.1 * B", "A_0_1_B"),
            ("noise scale", "c_noise_scale"),
            ("time", "c_time"),
        ] {
            assert_eq!(variable_name(channel), name);
        }
    }
}
