//! Evidence and judgement of an identified bicycle.

use super::options::BicycleOptions;
use super::parameters::{PARAMETERS, STEERING_OFFSET, YAW_RATE_OFFSET, combinations};
use super::uncertainty::{deviation, directions};
use super::{Estimate, Judged, Recording};
use crate::identify::evidence::failed;
use crate::signal::{mean, standard_deviation};
use crate::{DriveLog, Error};
use formats::{BicycleEvidence, Estimated, Quality, ReasonCode, SpeedSummary, Stated, WithDelay};

/// Speed that varies by less (standard deviation over mean) schedules nothing.
const LEAST_SPREAD: f64 = 0.05;
/// A delay matters where it is beyond this, s, and beyond two of its standard deviations.
const LEAST_DELAY: f64 = 0.01;

/// What the evidence is made of.
pub(super) struct Known<'a> {
    pub(super) log: &'a DriveLog,
    pub(super) options: &'a BicycleOptions,
    pub(super) recording: &'a Recording,
    pub(super) estimate: &'a Estimate,
    pub(super) covariance: &'a [[f64; PARAMETERS]; PARAMETERS],
    pub(super) judged: &'a Judged,
    pub(super) with_delay: WithDelay,
}

impl Known<'_> {
    pub(super) fn evidence(&self) -> Result<BicycleEvidence, Error> {
        let p = &self.estimate.parameters;
        let speed = self.speed();
        let identified = combinations(p, self.options.front_share(), speed.mean_mps)
            .into_iter()
            .map(|c| Estimated {
                name: c.name.into(),
                value: c.value.value,
                standard_error: deviation(&c.value.by, self.covariance),
                unit: c.unit.into(),
            })
            .collect();
        let (log, judged) = (self.log, self.judged);
        let errors: Vec<f64> = log.output[self.recording.estimation.clone()]
            .iter()
            .zip(&judged.simulated)
            .map(|(y, s)| y - s)
            .collect();
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
        let mut evidence = BicycleEvidence {
            estimation_samples: self.recording.estimation.len(),
            validation_samples: self.recording.validation.len(),
            sample_time_s: log.sample_time_s,
            estimation_fit: judged.estimation_fit,
            validation_fit: judged.validation_fit,
            speed,
            identified,
            directions: directions(self.covariance)?,
            stated: self.stated(),
            steering_offset_rad: p[STEERING_OFFSET] * log.steering_ratio,
            largest_steering_rate_radps: Some(log.fastest_steering()),
            yaw_rate_offset_radps: p[YAW_RATE_OFFSET],
            with_delay: self.with_delay,
            error_correlation_time_s: log.sample_time_s
                * (self.estimate.long_run_variance / variance.max(f64::MIN_POSITIVE)).max(1.0),
            channels: log.channels.clone(),
            warnings: log.warnings.clone(),
        };
        self.warn(&mut evidence);
        Ok(evidence)
    }

    fn speed(&self) -> SpeedSummary {
        let v = &self.recording.speed[self.recording.estimation.clone()];
        SpeedSummary {
            min_mps: v.iter().copied().fold(f64::INFINITY, f64::min),
            // Of a vehicle that stands most of the time too, so that eq 13 can be written.
            mean_mps: mean(v).max(1.0),
            max_mps: v.iter().copied().fold(0.0, f64::max),
            standard_deviation_mps: standard_deviation(v),
        }
    }

    fn stated(&self) -> Vec<Stated> {
        let o = self.options;
        let mut all = vec![
            of("mass_kg", o.mass(), o.mass_kg.is_some(), "; yaw rate does not depend on it"),
            of(
                "front_share",
                o.front_share(),
                o.front_share.is_some(),
                "; yaw rate hardly depends on it, lateral velocity does",
            ),
        ];
        match o.wheelbase_m {
            Some(wheelbase) => {
                all.push(of("wheelbase_m", wheelbase, true, "; the steering ratio is identified"));
            }
            None => all.push(of("steering_ratio", self.log.steering_ratio, true, "")),
        }
        all
    }

    fn warn(&self, e: &mut BicycleEvidence) {
        let d = &self.with_delay;
        let matters = d.input_delay_s.abs() > LEAST_DELAY.max(2.0 * d.standard_error_s);
        let (milliseconds, error) = (1e3 * d.input_delay_s.abs(), 2e3 * d.standard_error_s);
        if matters && d.input_delay_s > 0.0 {
            e.warnings.push(format!(
                "the steering acts {milliseconds:.0} ms late (± {error:.0} ms), which the plant cannot: its actuator's lag stands for it, with a fit of {:.2} % in place of {:.2} % on estimation data",
                e.estimation_fit, d.estimation_fit
            ));
        } else if matters {
            e.warnings.push(format!(
                "yaw rate comes {milliseconds:.0} ms (± {error:.0} ms) before its steering: check the channels' clocks and filters"
            ));
        }
        if e.speed.standard_deviation_mps < LEAST_SPREAD * e.speed.mean_mps {
            e.warnings.push(format!(
                "the speed hardly varies ({:.1} m/s ± {:.1}): what depends on it rests on what is known of road vehicles, not on this drive",
                e.speed.mean_mps, e.speed.standard_deviation_mps
            ));
        }
        let crooked = (e.steering_offset_rad / self.log.steering_ratio).to_degrees();
        if crooked.abs() > 1.0 {
            e.warnings.push(format!(
                "driving straight would need {crooked:.1}° at the road wheel: check the zero of the steering angle"
            ));
        }
        if e.yaw_rate_offset_radps.to_degrees().abs() > 1.0 {
            e.warnings.push(format!(
                "the yaw rate is off by {:.1}°/s: check the gyro's bias",
                e.yaw_rate_offset_radps.to_degrees()
            ));
        }
        if !self.judged.bounded {
            e.warnings.push("the model diverges on the held-out data".into());
        }
    }

    /// Judges by what matters for steering: does the log say enough, and does the model simulate data
    /// it has not seen.
    pub(super) fn quality(&self, e: &BicycleEvidence) -> Quality {
        /// Below, the steering hardly moves the vehicle: a fifth of a degree at the road wheel.
        const LEAST_STEERING: f64 = 0.0035;
        const GOOD_FIT: f64 = 60.0;
        /// Relative standard error of the yaw rate's gain beyond which it is not known.
        const LARGEST_ERROR: f64 = 0.15;
        let slalom = "drive a slalom with sweeping rhythm, 0.2 to 2 Hz, about ±20° at the steering wheel, for 60 s at each of two or three speeds";
        let (mut reasons, mut advice) = (Vec::new(), Vec::new());
        let steering = standard_deviation(&self.recording.steering);
        let mut weak = steering < LEAST_STEERING;
        if weak {
            let degrees = steering.to_degrees();
            let message =
                format!("the road wheel moves by {degrees:.2}° (standard deviation) only");
            let limit = LEAST_STEERING.to_degrees();
            reasons.push(failed(ReasonCode::WeakSteering, message).compared(degrees, limit, "deg"));
        }
        if e.validation_fit < GOOD_FIT {
            let fit = e.validation_fit;
            let message = format!("the fit on validation data is {fit:.0} %, below {GOOD_FIT} %");
            let reason = failed(ReasonCode::LowValidationFit, message);
            reasons.push(reason.compared(fit, GOOD_FIT, "%"));
            advice.push(
                "check the mapping, signs and clocks of the channels, the steering ratio, and that the tyres are not at their limit"
                    .to_owned(),
            );
        }
        if let Some(gain) = e.identified.iter().find(|c| c.name == "yaw_rate_gain")
            && gain.standard_error > LARGEST_ERROR * gain.value.abs()
        {
            let percent = 100.0 * gain.standard_error / gain.value.abs();
            let message = format!(
                "the standard error of the yaw-rate gain {:.2} 1/s is {percent:.0} %",
                gain.value
            );
            let reason = failed(ReasonCode::UncertainGain, message);
            reasons.push(reason.compared(percent, 100.0 * LARGEST_ERROR, "%"));
            weak = true;
        }
        if weak {
            advice.push(slalom.to_owned());
        }
        let spread = e.speed.standard_deviation_mps / e.speed.mean_mps;
        if spread < LEAST_SPREAD {
            advice.push(
                "for other speeds than this one, give logs at several speeds, or one whose speed varies"
                    .to_owned(),
            );
        }
        let summary = if !reasons.is_empty() {
            let messages: Vec<&str> = reasons.iter().map(|r| r.message.as_str()).collect();
            format!("Validation failed: {}.", messages.join("; "))
        } else if spread < LEAST_SPREAD {
            format!(
                "The fit on validation data is {:.1} % at {:.1} m/s, the only speed driven: fit to design on there.",
                e.validation_fit, e.speed.mean_mps
            )
        } else {
            format!(
                "The fit on validation data is {:.1} % between {:.0} and {:.0} m/s: fit to design on there.",
                e.validation_fit, e.speed.min_mps, e.speed.max_mps
            )
        };
        Quality::new(summary, reasons, advice)
    }
}

fn of(name: &str, value: f64, given: bool, more: &str) -> Stated {
    let origin = if given { "given" } else { "conventional" };
    Stated { name: name.into(), value, origin: format!("{origin}{more}") }
}
