//! The design target of a search: the bounds, the relaxed requirement, and the cost of a violation.

use steerwright_formats::Requirement;

/// A reserve, so that other ways of stepping the loop keep the requirements.
pub(crate) const WITH_RESERVE: Target = Target {
    overshoot: 0.8,
    times: 0.95,
    errors: 0.8,
    margins: 0.01,
    band: 0.8,
    relaxed: None,
    untimed_others: false,
};
/// The smallest reserve: the grid of the margins may miss a little of their minimum.
pub(crate) const LEAST_RESERVE: Target = Target {
    overshoot: 0.98,
    times: 0.99,
    errors: 0.98,
    margins: 0.006,
    band: 1.0,
    ..WITH_RESERVE
};
pub(crate) const SHORTEST_SETTLING: Target = LEAST_RESERVE.relaxing(Requirement::Settling);
/// The target on many plants: those of the evidence are a little worse than those designed on.
pub(crate) const ROBUST: Target =
    Target { overshoot: 0.85, margins: 0.015, band: 0.8, ..LEAST_RESERVE };
pub(crate) const ROBUST_SHORTEST_SETTLING: Target = ROBUST.relaxing(Requirement::Settling);
/// Requirements on time for the nominal plant alone.
pub(crate) const ROBUST_UNTIMED: Target = Target { untimed_others: true, ..ROBUST };
/// Weight of the logarithm of a violation beyond twice its bound, where a requirement is relaxed: one that is
/// out of reach must not dominate the others.
pub(crate) const LARGE_VIOLATION_WEIGHT: f64 = 0.02;

/// The cost of missing a bound by a share of it, where violations beyond the bound itself weigh little.
pub(crate) fn capped(missed: f64) -> f64 {
    missed.min(1.0) + LARGE_VIOLATION_WEIGHT * missed.max(1.0).ln()
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Target {
    /// Shares of the upper bounds.
    overshoot: f64,
    times: f64,
    errors: f64,
    /// Added to modulus and disk margin; the others grow by that share.
    margins: f64,
    /// The relaxed requirement: the search minimises its slack.
    pub(crate) relaxed: Option<Requirement>,
    /// Share of the settling band: a response that grazes it settles much later on another plant.
    pub(crate) band: f64,
    /// Whether requirements on time apply to the nominal plant alone.
    untimed_others: bool,
}

impl Target {
    pub(crate) const fn relaxing(self, requirement: Requirement) -> Self {
        Self { relaxed: Some(requirement), ..self }
    }

    /// The bound of a requirement.
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

    /// Whether a requirement applies to the nominal plant or, where `other`, to another one.
    pub(crate) fn applies(&self, requirement: Requirement, other: bool) -> bool {
        let untimed = other && self.untimed_others && requirement.is_time();
        self.relaxed != Some(requirement) && !untimed
    }

    /// The cost of missing a bound by a share of it.
    pub(crate) fn violation(&self, missed: f64) -> f64 {
        missed.min(1.0) + self.large_violation_weight() * missed.max(1.0).ln()
    }

    /// The value beyond which a requirement with an upper bound costs more than a violation.
    pub(crate) fn value_at_violation(
        &self,
        requirement: Requirement,
        required: f64,
        violation: f64,
    ) -> f64 {
        let rest = (violation - 1.0).max(0.0) / self.large_violation_weight();
        let missed = violation.clamp(0.0, 1.0) * rest.exp();
        Requirement::missing(self.bound(requirement, required), missed)
    }

    fn large_violation_weight(&self) -> f64 {
        if self.relaxed.is_some() { LARGE_VIOLATION_WEIGHT } else { 1.0 }
    }
}
