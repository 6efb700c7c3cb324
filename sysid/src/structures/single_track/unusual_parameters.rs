//! Parameters that are those of no usual vehicle: one of them takes up what the model lacks.

use crate::structures::single_track::parameters::Parameter;
use steerwright_formats::{Grade, Reason, ReasonCode, VehicleParameter};

/// Standard deviations of the prior that a parameter may be off it.
const MOST_DEVIATIONS: f64 = 3.0;

/// The reason against parameters at a bound or far off their prior, with advice. A stated parameter is none of them, nor is
/// a delay or a lag of zero, as of a measured angle, nor all of the driving or braking force at one axle.
pub(super) fn unusual_parameters(parameters: &[VehicleParameter]) -> Option<(Reason, String)> {
    let mut unusual = Vec::new();
    let mut largest: f64 = 0.0;
    for p in parameters {
        let is_no_lag = p.name == Parameter::Lag.name() && p.value < p.prior.mean;
        if p.prior.standard_deviation == 0.0 || is_no_lag {
            continue;
        }
        let name = p.name.replace('_', " ");
        let is_no_delay = p.name == Parameter::Delay.name() && p.value < p.prior.max;
        let is_share =
            [Parameter::DriveShare, Parameter::BrakeShare].iter().any(|s| p.name == s.name());
        if p.is_at_bound && !is_no_delay && !is_share {
            unusual
                .push(format!("{name} is at a bound, {:.3} {}", p.value, p.unit).trim_end().into());
        } else if p.moved_deviations.abs() > MOST_DEVIATIONS {
            unusual.push(format!("{name} is {:+.1} deviations off its prior", p.moved_deviations));
        }
        largest = largest.max(p.moved_deviations.abs());
    }
    if unusual.is_empty() {
        return None;
    }
    let reason = Reason::new(ReasonCode::UnusualParameter, Grade::Warn, unusual.join(", "));
    let advice = "a parameter unlike those of usual vehicles may compensate for a fault of the log: check units, clocks and the steering ratio, or state the prior of such a vehicle";
    Some((reason.compared(largest, MOST_DEVIATIONS, ""), advice.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parameter at its prior's mean.
    fn usual(parameter: Parameter) -> VehicleParameter {
        let prior = parameter.default_prior();
        VehicleParameter {
            name: parameter.name().into(),
            unit: "m".into(),
            value: prior.mean,
            standard_error: 0.002,
            band_95: [prior.mean; 2],
            is_logarithmic: false,
            prior,
            posterior_per_prior: 0.1,
            moved_deviations: 0.0,
            is_determined: true,
            is_at_bound: false,
        }
    }

    fn message(p: VehicleParameter) -> Option<String> {
        unusual_parameters(&[usual(Parameter::Lag), p]).map(|(reason, _)| {
            assert_eq!((reason.code, reason.grade), (ReasonCode::UnusualParameter, Grade::Warn));
            reason.message
        })
    }

    #[test]
    fn no_lag_is_usual_and_a_long_one_is_not() {
        let lag = usual(Parameter::Lag);
        let none = VehicleParameter {
            value: 0.0005,
            is_at_bound: true,
            moved_deviations: -3.7,
            ..lag.clone()
        };
        assert_eq!(message(none), None);
        let short = VehicleParameter { value: 0.0009, moved_deviations: -3.1, ..lag.clone() };
        assert_eq!(message(short), None);
        let long = VehicleParameter { value: 0.5, moved_deviations: 3.2, ..lag };
        assert!(message(long).unwrap().contains("actuator time constant is +3.2"));
    }

    #[test]
    fn a_bound_and_a_far_prior_are_named() {
        let wheelbase = usual(Parameter::Wheelbase);
        assert_eq!(message(wheelbase.clone()), None);
        let at_bound = VehicleParameter { value: 8.0, is_at_bound: true, ..wheelbase.clone() };
        assert_eq!(message(at_bound.clone()).unwrap(), "wheelbase is at a bound, 8.000 m");
        for (moved, named) in [(2.9, false), (-2.9, false), (3.1, true), (-3.1, true)] {
            let p = VehicleParameter { moved_deviations: moved, ..wheelbase.clone() };
            let expected = format!("wheelbase is {moved:+.1} deviations off its prior");
            assert_eq!(message(p), named.then_some(expected));
        }
        let delay = usual(Parameter::Delay);
        for (value, named) in [(delay.prior.min, false), (delay.prior.max, true)] {
            let p = VehicleParameter { value, is_at_bound: true, ..delay.clone() };
            let expected = format!("actuator delay is at a bound, {value:.3} m");
            assert_eq!(message(p), named.then_some(expected), "{value}");
        }
        let rear_wheel_drive =
            VehicleParameter { value: 0.0, is_at_bound: true, ..usual(Parameter::DriveShare) };
        assert_eq!(message(rear_wheel_drive), None);
        // What is stated is not judged.
        let mut stated = at_bound;
        stated.prior.standard_deviation = 0.0;
        assert_eq!(message(stated), None);
    }
}
