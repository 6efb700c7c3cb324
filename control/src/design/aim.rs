//! What a search aims at: how much tighter than asked for, what gives way, and what misses cost.

use crate::requirement::Requirement;

/// What is aimed at, so that other steppings keep the requirements.
pub(crate) const WITH_RESERVE: Aim = Aim {
    overshoot: 0.8,
    times: 0.95,
    errors: 0.8,
    margins: 0.01,
    band: 0.8,
    gives_way: None,
    others_slow: false,
};
/// What is aimed at where that cannot be reached; the grid of the margins may miss a little of their
/// minimum.
pub(crate) const BARELY: Aim =
    Aim { overshoot: 0.98, times: 0.99, errors: 0.98, margins: 0.006, band: 1.0, ..WITH_RESERVE };
/// The same, and as quick as the plant allows.
pub(crate) const QUICKEST: Aim = Aim { gives_way: Some(Requirement::Settling), ..BARELY };
/// What is aimed at on many plants: plants drawn anew are a little worse.
pub(crate) const ROBUST: Aim = Aim { overshoot: 0.85, margins: 0.015, band: 0.8, ..BARELY };
/// The same where the settling time gives way.
pub(crate) const ROBUST_AND_QUICK: Aim = Aim { gives_way: Some(Requirement::Settling), ..ROBUST };
/// The same where all but the nominal plant may be slow.
pub(crate) const ROBUST_BUT_SLOW: Aim = Aim { others_slow: true, ..ROBUST };
/// Where a requirement gives way, weight of what another is missed by beyond twice its bound: what is out
/// of reach must not take the rest with it.
pub(crate) const HOPELESS_WEIGHT: f64 = 0.02;

/// How much tighter than the requirements is aimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aim {
    /// Shares of the upper bounds.
    overshoot: f64,
    times: f64,
    errors: f64,
    /// Added to modulus and disk margin; the others grow by that share.
    margins: f64,
    /// The requirement that gives way to the others.
    pub(crate) gives_way: Option<Requirement>,
    /// Share of the settling band: a response that grazes the band settles much later on a plant that
    /// differs by a hair.
    pub(crate) band: f64,
    /// Whether plants other than the nominal one are held to no time.
    others_slow: bool,
}

impl Aim {
    /// The same with another requirement that gives way.
    pub(crate) fn giving(self, way: Requirement) -> Self {
        Self { gives_way: Some(way), ..self }
    }

    /// What is aimed at for a requirement.
    pub(crate) fn bound(&self, requirement: Requirement, required: f64) -> f64 {
        use Requirement as R;
        match requirement {
            R::Overshoot => self.overshoot * required,
            R::Settling | R::Rise | R::IntegralError => self.times * required,
            R::SteadyState | R::SteadyStateWithOffset | R::SteadyStateOnCurve => {
                self.errors * required
            }
            R::ModulusMargin => (required + self.margins).min(0.99),
            R::DiskMargin => (required + self.margins).min(1.99),
            R::GainMargin | R::PhaseMargin | R::DelayMargin => required * (1.0 + self.margins),
        }
    }

    /// Whether a requirement is held against the nominal plant or another one.
    pub(crate) fn holds(&self, requirement: Requirement, other: bool) -> bool {
        let slow = other && self.others_slow && requirement.is_time();
        self.gives_way != Some(requirement) && !slow
    }

    /// What it costs to miss a bound by a share of it.
    pub(crate) fn violation(&self, missed: f64) -> f64 {
        missed.min(1.0) + self.hopeless() * missed.max(1.0).ln()
    }

    /// The value beyond which a requirement with an upper bound costs more than a violation.
    pub(crate) fn beyond(&self, requirement: Requirement, required: f64, violation: f64) -> f64 {
        let rest = (violation - 1.0).max(0.0) / self.hopeless();
        let missed = violation.clamp(0.0, 1.0) * rest.exp();
        Requirement::missing(self.bound(requirement, required), missed)
    }

    fn hopeless(&self) -> f64 {
        if self.gives_way.is_some() { HOPELESS_WEIGHT } else { 1.0 }
    }
}
