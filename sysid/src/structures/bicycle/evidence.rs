//! Evidence of an identified bicycle.

use crate::Error;
use crate::actuator::identified_actuator;
use crate::data::held_input::ContinuousResponse;
use crate::data::recording::{Recording, count, samples_in};
use crate::data::statistics::variance_accounted_for;
use crate::linalg::dual::Scalar;
use crate::structures::bicycle::estimate::Estimate;
use crate::structures::bicycle::options::BicycleOptions;
use crate::structures::bicycle::parameters::{
    PARAMETERS, STEERING_OFFSET, YAW_RATE_OFFSET, combinations,
};
use crate::structures::bicycle::simulation::Simulation;
use crate::structures::bicycle::uncertainty::{covariance_factor, deviation};
use crate::structures::held::Steering;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{BicycleEvidence, Estimated, HeldOut, PredictionFit, Stated, WithDelay};

/// A delay is part of the model where it is beyond this, s, and beyond two of its standard deviations.
const LEAST_DELAY: f64 = 0.01;

pub(super) fn is_determined(d: &WithDelay) -> bool {
    d.input_delay_s.abs() > LEAST_DELAY.max(2.0 * d.standard_error_s)
}

pub(super) struct Known<'a, 'l> {
    /// The drive, with the steering as it is held.
    pub(super) log: &'a DriveLog,
    pub(super) steering: &'a Steering<'l>,
    pub(super) options: &'a BicycleOptions,
    pub(super) recording: &'a Recording,
    pub(super) estimate: &'a Estimate,
    pub(super) covariance: &'a [[f64; PARAMETERS]; PARAMETERS],
    pub(super) simulation: &'a Simulation,
    pub(super) with_delay: WithDelay,
}

/// Leaves out the characteristic or critical speed where the 95 % band of the understeer gradient has 0 in it: the speed is
/// infinite there, and of either kind.
fn leave_out_speed_without_band(identified: &mut Vec<Estimated>) {
    let is_neutral = identified
        .iter()
        .any(|e| e.name == "understeer_gradient" && e.value.abs() < 2.0 * e.standard_error);
    if is_neutral {
        identified.retain(|e| e.name != "characteristic_speed" && e.name != "critical_speed");
    }
}

impl Known<'_, '_> {
    pub(super) fn evidence(&self) -> Result<BicycleEvidence, Error> {
        let p = &self.estimate.parameters;
        let speed = self.recording.speed_summary();
        let mut identified: Vec<Estimated> =
            combinations(p, self.options.front_share(), speed.mean_mps)
                .into_iter()
                .map(|(name, unit, c)| Estimated {
                    name: name.into(),
                    value: c.value(),
                    standard_error: deviation(&c.by(), self.covariance),
                    unit: unit.into(),
                })
                .collect();
        leave_out_speed_without_band(&mut identified);
        let (log, simulation) = (self.log, self.simulation);
        let read = self.steering.read().ok();
        let split = &self.recording.split;
        let mut warnings = log.warnings.clone();
        warnings.extend(read.and_then(|read| read.warning.clone()));
        warnings.extend(self.steering.fixes().warnings.iter().cloned());
        let mut evidence = BicycleEvidence {
            estimation_samples: count(&split.estimation),
            validation_samples: count(&split.validation),
            sample_time_s: log.sample_time_s,
            held_for: read
                .and_then(|read| read.held.vehicle.as_ref().map(ContinuousResponse::to_file)),
            open_hold_s: self.steering.open_hold_s(),
            estimation_fit: simulation.estimation_fit,
            validation_fit: simulation.validation_fit.fit,
            held_out: Some(self.validation()),
            speed,
            identified,
            directions: covariance_factor(self.covariance)?,
            stated: self.stated(),
            steering_offset_rad: p[STEERING_OFFSET] * log.steering_ratio,
            largest_steering_rate_radps: Some(log.fastest_steering()),
            yaw_rate_offset_radps: p[YAW_RATE_OFFSET],
            with_delay: self.with_delay,
            error_correlation_time_s: log.sample_time_s
                * (self.estimate.long_run_variance / self.variance().max(f64::MIN_POSITIVE))
                    .max(1.0),
            error_std_radps: Some(self.variance().sqrt()),
            channels: log.channels.clone(),
            actuator: identified_actuator(log, &mut warnings),
            warnings,
        };
        self.warn(&mut evidence);
        Ok(evidence)
    }

    /// Mean square of the simulation errors on the estimation data, rad²/s².
    pub(super) fn variance(&self) -> f64 {
        let ranges = &self.recording.split.estimation;
        let samples = ranges.iter().flat_map(|r| r.clone());
        let square = |k: usize| (self.log.output[k] - self.simulation.simulated[k]).powi(2);
        samples.map(square).sum::<f64>() / count(ranges).max(1) as f64
    }

    fn validation(&self) -> HeldOut {
        let (split, fit) = (&self.recording.split, &self.simulation.validation_fit);
        let [measured, simulated] = [&self.log.output, &self.simulation.simulated]
            .map(|x| samples_in(x, &split.validation));
        // A file holds finite numbers only.
        let variance_accounted_for = variance_accounted_for(&measured, &simulated).max(-1e9);
        let instants = self.log.time_s();
        HeldOut {
            fit_standard_error: fit.standard_error,
            blocks: fit.blocks,
            selection: split.selection.name().into(),
            segments_s: split
                .validation
                .iter()
                .map(|r| [instants[r.start], instants[r.end - 1]])
                .collect(),
            fit_bound: None,
            variance_accounted_for,
            predictions: vec![PredictionFit {
                steps: None,
                ahead_s: None,
                fit: fit.fit,
                variance_accounted_for,
            }],
        }
    }

    fn stated(&self) -> Vec<Stated> {
        let o = self.options;
        let mut all = vec![
            stated_parameter(
                "mass_kg",
                o.mass(),
                o.mass_kg.is_some(),
                "; yaw rate does not depend on it",
            ),
            stated_parameter(
                "front_share",
                o.front_share(),
                o.front_share.is_some(),
                "; yaw rate hardly depends on it, lateral velocity does",
            ),
        ];
        all.push(match o.wheelbase_m {
            Some(l) => {
                stated_parameter("wheelbase_m", l, true, "; the steering ratio is identified")
            }
            None => stated_parameter("steering_ratio", self.log.steering_ratio, true, ""),
        });
        all
    }

    fn warn(&self, e: &mut BicycleEvidence) {
        let d = &self.with_delay;
        let (milliseconds, error) = (1e3 * d.input_delay_s.abs(), 2e3 * d.standard_error_s);
        if is_determined(d) && d.input_delay_s < 0.0 {
            e.warnings.push(format!(
                "yaw rate comes {milliseconds:.0} ms (± {error:.0} ms) before its steering: check the channels' clocks and filters"
            ));
        }
        if e.speed.is_one_speed() {
            e.warnings.push(format!(
                "the speed hardly varies ({:.1} m/s ± {:.1}): the parameters that depend on it follow from the prior of road vehicles, not from this drive",
                e.speed.mean_mps, e.speed.standard_deviation_mps
            ));
        }
        if !self.simulation.bounded {
            e.warnings.push("the model diverges on the validation data".into());
        }
    }
}

fn stated_parameter(name: &str, value: f64, given: bool, more: &str) -> Stated {
    let origin = if given { "given" } else { "conventional" };
    Stated { name: name.into(), value, origin: format!("{origin}{more}") }
}
