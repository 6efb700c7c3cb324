//! The quality of an identified bicycle: whether the log is informative enough, sign, gain and
//! wheelbase can be a road vehicle's, the recording was sound, and the model simulates the validation
//! data.

use crate::structures::bicycle::evidence::Known;
use crate::structures::bicycle::parameters::{STEERING_FACTOR, STEERING_OFFSET, YAW_RATE_OFFSET};
use crate::structures::bicycle::response::{response, response_errors};
use crate::structures::bicycle::uncertainty::LARGEST_ERROR;
use crate::structures::held::with_open_hold;
use crate::validation::faults::open_hold;
use crate::validation::faults::play::steering_play;
use crate::validation::faults::recording::{Recorded, faults};
use crate::validation::plausible::{Response, implausible, opposite};
use crate::validation::quality::{
    GOOD_FIT, failed, failure, messages, short_validation, speed_range, weak_steering, with_error,
};
use crate::validation::residuals::pairs::pairs;
use crate::validation::residuals::rate::slow_log;
use crate::validation::response::modelled::bandwidth_hz;
use crate::validation::response::uncertain_response::uncertain_response;
use crate::validation::vehicle_class::implausible_vehicle;
use std::f64::consts::TAU;
use steerwright_drivelog::signal::standard_deviation;
use steerwright_formats::{BicycleEvidence, Grade, Quality, Reason, ReasonCode, VehicleData};

impl Known<'_, '_> {
    pub(super) fn quality(&self, e: &BicycleEvidence, vehicle: &VehicleData) -> Quality {
        let (mut reasons, mut advice) = (Vec::new(), Vec::new());
        let reversed = opposite(&pairs(self.log), self.log.sample_time_s);
        // Gain and offsets of a model of a reversed yaw rate are meaningless.
        let gain_error = if reversed.is_some() { None } else { uncertain_gain(e) };
        let has_gain = reversed.is_none() && gain_error.is_none();
        let implausible = match reversed {
            Some(found) => vec![found],
            None if has_gain => self.implausible(e),
            None => Vec::new(),
        };
        let steering = standard_deviation(&self.recording.steering);
        let mut too_little: Vec<Reason> =
            weak_steering(steering).into_iter().chain(gain_error).collect();
        if too_little.is_empty() {
            let errors = response_errors(vehicle, &e.directions, e.speed.mean_mps);
            let (errors, open_hold_s) = with_open_hold(errors, e.open_hold_s);
            too_little = uncertain_response(&errors);
            advice.extend(open_hold_s.map(open_hold::advice));
            if let Some(h) = &e.held_out {
                too_little.extend(short_validation(h.fit_standard_error, h.blocks));
            }
        }
        let mut explained = !implausible.is_empty();
        if !too_little.is_empty() {
            reasons.extend(too_little);
            let hint = "drive a slalom whose rhythm sweeps from 0.2 to 2 Hz, about ±20° at the steering wheel, for 60 s at each of two or three speeds";
            advice.push(hint.to_owned());
        }
        for (reason, cause) in implausible.into_iter().chain(self.faults(e, has_gain)) {
            explained |= reason.grade == Grade::Fail;
            reasons.push(reason);
            advice.push(cause);
        }
        let fit_error = e.held_out.as_ref().and_then(|h| h.fit_standard_error);
        let fit = with_error(e.validation_fit, fit_error, 1);
        if e.validation_fit < GOOD_FIT {
            let message = format!("the fit on validation data is {fit}, below {GOOD_FIT} %");
            let reason = failed(ReasonCode::LowValidationFit, message);
            reasons.push(reason.compared(e.validation_fit, GOOD_FIT, "%"));
            if !explained {
                let hint = "check the mapping, signs and clocks of the channels, the steering ratio, and that the tyres are not at their limit";
                advice.push(hint.to_owned());
            }
        }
        let one_speed = e.speed.is_one_speed();
        if one_speed {
            let hint = "for other speeds than this one, use logs at several speeds, or one whose speed varies";
            advice.push(hint.to_owned());
        }
        let speeds = if one_speed {
            format!("at {:.1} m/s, the only speed driven", e.speed.mean_mps)
        } else {
            speed_range(e.speed.min_mps, e.speed.max_mps)
        };
        let summary = if reasons.is_empty() {
            format!("The fit on validation data is {fit} {speeds}: fit to design on there.")
        } else if let Some(failure) = failure(&reasons) {
            failure
        } else {
            format!(
                "The fit on validation data is {fit} {speeds}. A controller may be designed there with reservations: {}.",
                messages(&reasons)
            )
        };
        Quality::new(summary, reasons, advice)
    }

    fn implausible(&self, e: &BicycleEvidence) -> Vec<(Reason, String)> {
        let mut found = implausible(&Response {
            at: &self.response(e.speed.mean_mps),
            excitation: None,
            speed_mps: e.speed.mean_mps,
            steering_ratio: self.log.steering_ratio,
            zeros: &[],
            spreads: &[],
        });
        let length = e.identified.iter().find(|q| q.name == "effective_wheelbase");
        let wheelbase = length.map(|q| [q.value, q.standard_error]);
        found.extend(implausible_vehicle(self.log.vehicle_class, wheelbase, e.speed.mean_mps));
        found
    }

    fn faults(&self, e: &BicycleEvidence, has_gain: bool) -> Vec<(Reason, String)> {
        let (log, p) = (self.log, &self.estimate.parameters);
        let steering_faults = self.steering.faults();
        let at = self.response(e.speed.mean_mps);
        let gain = at(0.0).0 * p[STEERING_FACTOR].exp();
        let (angle, rate) =
            if has_gain { (p[STEERING_OFFSET], p[YAW_RATE_OFFSET]) } else { (0.0, 0.0) };
        let play = steering_faults.play_rad.map(|width| steering_play(width, &|w| at(w / TAU)));
        let mut found = faults(&Recorded {
            channels: &e.channels,
            play: play.as_ref(),
            delay_in_windows_s: None,
            yaw_rate_lead_s: steering_faults.yaw_rate_lead_s,
            yaw_rate_lag_s: steering_faults.yaw_rate_lag_s,
            road_wheel_std_rad: standard_deviation(&self.recording.steering),
            yaw_rate_std_radps: standard_deviation(&log.output),
            steering_ratio: log.steering_ratio,
            noise_radps: self.variance().sqrt(),
            seconds: log.len() as f64 * log.sample_time_s,
            road_wheel_offset_rad: angle - rate / gain,
            yaw_rate_offset_radps: rate - gain * angle,
        });
        let slow = slow_log(&e.channels, bandwidth_hz(&at, 0.5 / log.sample_time_s));
        found.extend(slow);
        found
    }

    /// Yaw rate over road-wheel angle, 1/s, at a frequency in Hz.
    fn response(&self, speed_mps: f64) -> impl Fn(f64) -> (f64, f64) + use<> {
        let (p, front_share) = (self.estimate.parameters, self.options.front_share());
        move |hz| {
            let g = response(&p, front_share, speed_mps, hz);
            (g.re, g.im)
        }
    }
}

fn uncertain_gain(e: &BicycleEvidence) -> Option<Reason> {
    let gain = e.identified.iter().find(|c| c.name == "yaw_rate_gain")?;
    let percent = 100.0 * gain.standard_error / gain.value.abs();
    if percent > 100.0 * LARGEST_ERROR {
        let message = format!(
            "the standard error of the yaw-rate gain {:.2} 1/s is {percent:.0} %",
            gain.value
        );
        Some(failed(ReasonCode::UncertainGain, message).compared(
            percent,
            100.0 * LARGEST_ERROR,
            "%",
        ))
    } else {
        None
    }
}
