//! The values that a design reaches, by requirement.

use steerwright_formats::Requirement as R;
use steerwright_formats::{
    DesignEvidence, Margins, OnACurve, Requirement, Shortfall, Specification, StepMetrics,
};

/// What a closed loop reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reached {
    pub(crate) step: StepMetrics,
    /// Error with the steering offset, percent of the step.
    pub(crate) with_offset: f64,
    /// Error on the curve, percent of the step.
    pub(crate) on_curve: f64,
    pub(crate) margins: Margins,
    /// Where the responses end, s.
    pub(crate) end: f64,
}

impl Reached {
    /// The values in the evidence of a file.
    pub(crate) fn new(e: &DesignEvidence, s: &Specification) -> Self {
        Self {
            step: e.step,
            with_offset: e.step_with_offset.steady_state_error_percent,
            on_curve: e.curve.map_or(0.0, |c: OnACurve| c.steady_state_error_percent),
            margins: e.margins,
            end: s.steady_state_time_s,
        }
    }

    /// The value of a requirement. For a response that never settles it is the end of the response plus
    /// the share by which it is off, so that better responses have smaller values.
    pub(crate) fn value(&self, requirement: Requirement) -> f64 {
        let never = self.end * (1.0 + 0.01 * self.step.steady_state_error_percent);
        match requirement {
            R::Overshoot => self.step.overshoot_percent,
            R::Settling => self.step.settling_time_s.unwrap_or(never),
            R::SteadyState => self.step.steady_state_error_percent,
            R::SteadyStateWithOffset => self.with_offset,
            R::SteadyStateOnCurve => self.on_curve,
            R::Rise => self.step.rise_time_s.unwrap_or(never),
            R::IntegralError => self.step.integral_absolute_error_s,
            margin => margin.of_margins(&self.margins),
        }
    }

    /// The requirements of a specification that are missed.
    pub(crate) fn shortfalls(&self, s: &Specification) -> Vec<Shortfall> {
        Requirement::ALL
            .into_iter()
            .filter_map(|r| Some((r, r.required(s)?, self.value(r))))
            .filter(|(r, required, reached)| !r.is_met(*required, *reached))
            .map(|(r, required, reached)| Shortfall {
                requirement: r.name().into(),
                required,
                reached,
            })
            .collect()
    }
}
