//! The requirements of a design: their names, their words and the bounds of a specification.

use super::design::Specification;
use super::loop_metrics::{Margins, StepMetrics};

/// One requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Requirement {
    /// Overshoot of the yaw step.
    Overshoot,
    /// Settling time of the yaw step.
    Settling,
    /// Error at the end of the yaw step.
    SteadyState,
    /// The same with the steering offset.
    SteadyStateWithOffset,
    /// Error on a curve of constant curvature, with feedforward.
    SteadyStateOnCurve,
    /// Rise time, 10 to 90 %.
    Rise,
    /// Integral of the absolute error.
    IntegralError,
    /// Gain margin.
    GainMargin,
    /// Phase margin.
    PhaseMargin,
    /// Smallest distance of the loop from −1.
    ModulusMargin,
    /// Delay up to which the loop is stable.
    DelayMargin,
    /// Gain and phase together.
    DiskMargin,
}

use Requirement as R;

impl Requirement {
    /// All of them.
    pub const ALL: [Self; 12] = [
        R::Overshoot,
        R::Settling,
        R::SteadyState,
        R::SteadyStateWithOffset,
        R::SteadyStateOnCurve,
        R::Rise,
        R::IntegralError,
        R::GainMargin,
        R::PhaseMargin,
        R::ModulusMargin,
        R::DelayMargin,
        R::DiskMargin,
    ];

    /// Its name in files, its name in texts, and its unit, as it follows a number.
    fn words(self) -> [&'static str; 3] {
        match self {
            R::Overshoot => ["overshoot_percent", "overshoot", " %"],
            R::Settling => ["settling_time_s", "settling time", " s"],
            R::SteadyState => ["steady_state_error_percent", "steady-state error", " %"],
            R::SteadyStateWithOffset => [
                "steady_state_error_with_offset_percent",
                "steady-state error with the steering 1° off",
                " %",
            ],
            R::SteadyStateOnCurve => {
                ["steady_state_error_on_curve_percent", "steady-state error on a curve", " %"]
            }
            R::Rise => ["rise_time_s", "rise time", " s"],
            R::IntegralError => ["integral_absolute_error_s", "integral of absolute error", " s"],
            R::GainMargin => ["gain_margin_db", "gain margin", " dB"],
            R::PhaseMargin => ["phase_margin_deg", "phase margin", "°"],
            R::ModulusMargin => ["modulus_margin", "modulus margin", ""],
            R::DelayMargin => ["delay_margin_s", "delay margin", " s"],
            R::DiskMargin => ["disk_margin", "disk margin", ""],
        }
    }

    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.words()[0]
    }

    /// The requirement of a name in a file.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|r| r.name() == name)
    }

    /// Its name in texts.
    #[must_use]
    pub fn label(self) -> &'static str {
        self.words()[1]
    }

    /// The values that it may have, in words and as a function.
    #[must_use]
    pub fn bounds(self) -> (&'static str, fn(f64) -> bool) {
        match self {
            R::Settling => ("greater than 0 and at most 60 s", |v| v > 0.0 && v <= 60.0),
            R::ModulusMargin => ("at least 0 and below 1", |v| (0.0..1.0).contains(&v)),
            R::DiskMargin => ("at least 0 and below 2", |v| (0.0..2.0).contains(&v)),
            R::PhaseMargin => ("at least 0 and below 180°", |v| (0.0..180.0).contains(&v)),
            R::Overshoot => ("at least 0 and at most 100 %", |v| (0.0..=100.0).contains(&v)),
            R::SteadyState => ("greater than 0 and below 100 %", |v| v > 0.0 && v < 100.0),
            R::GainMargin | R::DelayMargin => ("0 or more", |v| v >= 0.0),
            _ => ("greater than 0", |v| v > 0.0),
        }
    }

    /// A value with its unit in texts.
    #[must_use]
    pub fn text(self, value: f64) -> String {
        if value == f64::INFINITY {
            return "unlimited".into();
        }
        let digits = match self {
            R::GainMargin => 2,
            R::PhaseMargin => 1,
            _ => 3,
        };
        let text = format!("{value:.digits$}");
        // 1 and not 1.000.
        let text = text.trim_end_matches('0').trim_end_matches('.');
        format!("{text}{}", self.unit())
    }

    /// Its unit, as it follows a number.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.words()[2]
    }

    /// Its value in a step, `None` inside where the step never reaches it; `None` for requirements that
    /// are not read from one step.
    #[must_use]
    pub fn of_step(self, step: &StepMetrics) -> Option<Option<f64>> {
        match self {
            R::Overshoot => Some(Some(step.overshoot_percent)),
            R::Settling => Some(step.settling_time_s),
            R::SteadyState => Some(Some(step.steady_state_error_percent)),
            R::Rise => Some(step.rise_time_s),
            R::IntegralError => Some(Some(step.integral_absolute_error_s)),
            _ => None,
        }
    }

    /// Whether more is better: a margin.
    #[must_use]
    pub fn at_least(self) -> bool {
        matches!(
            self,
            R::GainMargin | R::PhaseMargin | R::ModulusMargin | R::DelayMargin | R::DiskMargin
        )
    }

    /// The margin that it bounds; infinite for a requirement on none.
    #[must_use]
    pub fn of_margins(self, margins: &Margins) -> f64 {
        let unlimited = |margin: Option<f64>| margin.unwrap_or(f64::INFINITY);
        match self {
            R::GainMargin => unlimited(margins.gain_margin_db),
            R::PhaseMargin => unlimited(margins.phase_margin_deg.map(f64::abs)),
            R::ModulusMargin => margins.modulus_margin,
            R::DelayMargin => unlimited(margins.delay_margin_s),
            R::DiskMargin => margins.disk_margin.unwrap_or(0.0),
            _ => f64::INFINITY,
        }
    }

    /// Whether it bounds a time.
    #[must_use]
    pub fn is_time(self) -> bool {
        matches!(self, R::Settling | R::Rise | R::IntegralError)
    }

    /// The bound in a specification.
    #[must_use]
    pub fn required(self, s: &Specification) -> Option<f64> {
        match self {
            R::Overshoot => s.overshoot_percent,
            R::Settling => s.settling_time_s,
            R::SteadyState | R::SteadyStateWithOffset | R::SteadyStateOnCurve => {
                s.steady_state_error_percent
            }
            R::Rise => s.rise_time_s,
            R::IntegralError => s.integral_absolute_error_s,
            R::GainMargin => s.gain_margin_db,
            R::PhaseMargin => s.phase_margin_deg,
            R::ModulusMargin => s.modulus_margin,
            R::DelayMargin => s.delay_margin_s,
            R::DiskMargin => s.disk_margin,
        }
    }

    /// Whether a value keeps the bound.
    #[must_use]
    pub fn is_met(self, required: f64, reached: f64) -> bool {
        // Written so that NaN does not keep it.
        if self.at_least() { reached >= required } else { reached <= required }
    }

    /// The share by which a bound is missed; 0 where it is kept.
    #[must_use]
    pub fn missed(self, bound: f64, reached: f64) -> f64 {
        let over = if self.at_least() { bound - reached } else { reached - bound };
        // NaN misses it by far.
        if over.is_nan() { 1e3 } else { (over / bound.max(LEAST_SCALE)).max(0.0) }
    }

    /// The value that misses an upper bound by a share.
    #[must_use]
    pub fn missing(bound: f64, share: f64) -> f64 {
        bound + share * bound.max(LEAST_SCALE)
    }
}

/// Bounds below this value, percent or s, such as an overshoot of 0, are missed relative to it.
const LEAST_SCALE: f64 = 0.01;
