//! The cost of a controller on the plants of an objective.
//!
//! First come the violations of the requirements on every plant, each relative to its bound. A controller
//! without violations costs the logarithm of the longest settling time of all plants and, on the nominal
//! plant, speed, robustness and noise, none of which depends on the requirements. Where a requirement is
//! relaxed, its slack is part of the cost.
//!
//! Nearly every part of the cost adds to what is already known of it, so most candidates are rejected early. A
//! cost that is not rejected is exact, in whatever order the plants are evaluated.

mod bounds;

use crate::closed_loop::scenario::{Scenario, View};
use crate::closed_loop::simulate::{Simulator, with_simulator};
use crate::design::objective::Objective;
use crate::design::target::Target;
use crate::requirement::Reached;
use bounds::{Parts, slack};
use std::cell::Cell;
use steerwright_formats::{Margins, Requirement, StepMetrics};
use steerwright_models::PidParameters;

/// Violation of an unstable loop. Its response may look harmless within the simulated time, so it is not
/// simulated; less gain stabilises it.
const UNSTABLE: f64 = 50.0;
/// Share of the time for plants whose steady state is not evaluated.
const SHORT: f64 = 0.5;
/// The cost of a rejected candidate.
const REJECTED: f64 = f64::INFINITY;
/// Share by which a cost must exceed the largest one, beyond the rounding of its sum.
const ROUNDING: f64 = 1e-9;

thread_local! {
    /// The plant that rejected the last candidate, which may reject the next. No result depends on it.
    static REJECTING: Cell<usize> = const { Cell::new(0) };
}

struct Rejected(usize);

impl Objective {
    /// The cost of decision variables: exact up to `most`, beyond it exact or infinite.
    pub(crate) fn cost(&self, x: &[f64], target: &Target, most: f64) -> f64 {
        let (pid, outside) = self.controller(x);
        let most = most + ROUNDING * (1.0 + most.abs());
        match with_simulator(|s| self.cost_with(s, &pid, outside, target, most)) {
            Ok(cost) if cost.is_finite() => cost,
            Ok(_) => 1e12,
            Err(Rejected(plant)) => {
                REJECTING.set(plant);
                REJECTED
            }
        }
    }

    fn cost_with(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        outside: f64,
        target: &Target,
        most: f64,
    ) -> Result<f64, Rejected> {
        // Margins cost little: those of all plants come before any response.
        let margins = self.scenarios.iter().map(|s| s.grid.margins(pid, self.view.all_margins));
        let margins: Vec<Margins> = margins.collect();
        let stable = |k: &usize| margins[*k].modulus_margin > 0.0;
        let unstable_plants = (0..margins.len()).filter(|k| !stable(k)).count();
        // Less gain leads out of instability, so more of it costs more.
        let unstable = UNSTABLE + (pid.gains.kp * self.gain * self.scale).ln().max(0.0);
        let base = outside + unstable_plants as f64 * unstable;
        // The violations on each plant and on its small step; at first, those of its margins.
        let mut added: Vec<[f64; 2]> = (0..margins.len())
            .map(|k| [if stable(&k) { self.of_margins(&margins[k], target) } else { 0.0 }, 0.0])
            .collect();
        // In the order of the plants, whichever is evaluated first.
        let sum = |added: &[[f64; 2]]| added.iter().flatten().fold(base, |sum, v| sum + v);
        let mut parts =
            Parts { violation: sum(&added), rest: 0.0, slack: f64::NEG_INFINITY, slowest: 0.0 };
        let first = Some(REJECTING.get()).filter(|k| (1..margins.len()).contains(k));
        let others = (1..margins.len()).filter(|k| Some(*k) != first);
        let check = |k: usize, parts: &Parts| {
            // Without a stable nominal plant the slack is not known yet.
            let exceeds = self.is_lower_bound(parts, target) && self.total(parts) > most;
            if exceeds { Err(Rejected(k)) } else { Ok(()) }
        };
        let count = |k: usize,
                     reached: &Reached,
                     smooth: f64,
                     added: &mut [[f64; 2]],
                     parts: &mut Parts| {
            if let Some((relaxed, required)) = self.relaxed(target) {
                let value = match relaxed {
                    Requirement::Settling => smooth,
                    other => reached.value(other),
                };
                let slack = slack(relaxed, target.bound(relaxed, required), value);
                parts.slack = parts.slack.max(slack);
            }
            added[k][0] = self.violation(reached, target, k > 0);
            parts.violation = sum(added);
        };
        let mut with_offsets = Vec::new();
        for k in std::iter::once(0).chain(first).chain(others).filter(stable) {
            let scenario = &self.scenarios[k];
            let view = self.view_of(scenario, target);
            let least = if k == 0 { self.least(pid, &margins[0], target, parts) } else { parts };
            check(k, &least)?;
            let bounds = self.stopping_bounds(target, &least, most, k > 0);
            let metrics = scenario.step(simulator, pid, &self.spec, view, &bounds);
            let metrics = metrics.ok_or(Rejected(k))?;
            let (step, smooth, end) = (metrics.step, metrics.smooth_settling_s, view.until);
            // The response to the offset rejects few candidates: it comes after the steps of all plants.
            let with_offset = if view.with_offset { 0.0 } else { step.steady_state_error_percent };
            let reached = Reached { step, with_offset, on_curve: 0.0, margins: margins[k], end };
            parts.slowest = parts.slowest.max(smooth);
            if k == 0 {
                parts.rest = self.rest(pid, &margins[0], step.integral_absolute_error_s);
            }
            count(k, &reached, smooth, &mut added, &mut parts);
            if k == 0 {
                check(k, &parts)?;
                added[0][1] = self.small_violation(simulator, scenario, pid, &step, target);
                parts.violation = sum(&added);
            }
            check(k, &parts)?;
            if view.with_offset {
                with_offsets.push((k, view, reached, smooth));
            }
        }
        for (k, view, mut reached, smooth) in with_offsets {
            let scenario = &self.scenarios[k];
            reached.with_offset = scenario.error_with_offset(simulator, pid, &self.spec, view);
            count(k, &reached, smooth, &mut added, &mut parts);
            check(k, &parts)?;
        }
        Ok(self.total(&parts))
    }

    /// The figures of a plant that the search evaluates.
    fn view_of(&self, scenario: &Scenario, target: &Target) -> View {
        let view = View { band: target.band, ..self.view };
        if scenario.with_offset {
            return view;
        }
        // Overshoot and settling show early; the steady state is evaluated with all plants.
        View { with_offset: false, until: SHORT * self.view.until, ..view }
    }

    fn violation(&self, reached: &Reached, target: &Target, other: bool) -> f64 {
        let applying = Requirement::ALL.into_iter().filter(|r| target.applies(*r, other));
        applying.map(|r| self.violation_of(r, target, reached.value(r))).sum()
    }

    /// The violations of the requirements on margins.
    fn of_margins(&self, margins: &Margins, target: &Target) -> f64 {
        let on_margins = |r: &Requirement| r.at_least() && target.applies(*r, false);
        let applying = Requirement::ALL.into_iter().filter(on_margins);
        applying.map(|r| self.violation_of(r, target, r.of_margins(margins))).sum()
    }

    fn violation_of(&self, requirement: Requirement, target: &Target, value: f64) -> f64 {
        requirement.required(&self.spec).map_or(0.0, |required| {
            target.violation(requirement.missed(target.bound(requirement, required), value))
        })
    }

    /// By how far the small step misses overshoot and settling time, where a limit acts on the
    /// whole step; elsewhere the two steps are alike.
    fn small_violation(
        &self,
        simulator: &mut Simulator,
        scenario: &Scenario,
        pid: &PidParameters,
        step: &StepMetrics,
        target: &Target,
    ) -> f64 {
        const ACTS: f64 = 0.999;
        let limited = step.largest_increment_rad >= ACTS * pid.largest_increment()
            || step.largest_angle_rad >= ACTS * pid.largest_angle(scenario.speed);
        if !limited || target.relaxed.is_some() {
            return 0.0;
        }
        let small = scenario.small_step(simulator, pid, &self.spec, self.view.until).step;
        let settling = small.settling_time_s.unwrap_or(self.view.until);
        [(Requirement::Overshoot, small.overshoot_percent), (Requirement::Settling, settling)]
            .into_iter()
            .filter_map(|(r, reached)| Some((r, r.required(&self.spec)?, reached)))
            .map(|(r, required, reached)| r.missed(target.bound(r, required), reached))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::options::DesignOptions;
    use crate::design::search::starts;
    use crate::design::target::{
        LEAST_RESERVE, ROBUST, ROBUST_SHORTEST_SETTLING, ROBUST_UNTIMED, SHORTEST_SETTLING,
    };
    use crate::plants::design_plant::DesignPlant;

    /// A mode and a lag with a delay of 20 ms: at that latency, at others, and with other gains.
    fn objective(max_rate_radps: Option<f64>) -> Objective {
        let (f, h) = ([0.0, 1.0, -60.0, -9.0], [300.0, 6.0]);
        let plant = DesignPlant::from_matrices(&f, &[0.0, 1.0], &h, 0.0, 0.02).unwrap();
        let max_rate_radps = max_rate_radps.or(Some(1e3));
        let max_lateral_acceleration_mps2 = 1e3;
        let options = DesignOptions {
            max_rate_radps,
            max_lateral_acceleration_mps2,
            ..DesignOptions::default()
        };
        let mut objective = Objective::new(&plant, &options).unwrap();
        for (late, gain, without_offset) in [(0.0, 1.2, true), (0.06, 1.0, true), (0.0, 0.3, false)]
        {
            let plant = plant.with_gain(gain);
            let scenario = Scenario::new(&plant, 0.01, late, objective.scale).unwrap();
            objective.scenarios.push(if without_offset {
                scenario.without_offset()
            } else {
                scenario
            });
        }
        objective
    }

    const RELAXED: [Requirement; 3] =
        [Requirement::Overshoot, Requirement::ModulusMargin, Requirement::SteadyStateWithOffset];

    /// The slack is part of the cost: a larger steering offset costs more.
    #[test]
    fn the_error_with_an_offset_may_be_relaxed() {
        let target = LEAST_RESERVE.relaxing(Requirement::SteadyStateWithOffset);
        let cost = |degrees: f64| {
            let mut objective = objective(None);
            objective.spec.steering_offset_rad = degrees.to_radians();
            // The integral action is too slow to remove an offset within the time.
            let mut x = starts(&objective, 1.0, 1, 1).remove(0);
            x[1] -= 3.0;
            objective.cost(&x, &target, f64::INFINITY)
        };
        assert!(cost(2.0) > cost(1.0) + 0.1, "{} {}", cost(2.0), cost(1.0));
    }

    /// A candidate is rejected only where its cost exceeds the largest; every other cost is exact to the bit.
    #[test]
    fn rejected_candidates_exceed_the_largest_cost() {
        let targets =
            [ROBUST, ROBUST_SHORTEST_SETTLING, ROBUST_UNTIMED, SHORTEST_SETTLING, LEAST_RESERVE]
                .into_iter()
                .chain(RELAXED.map(|r| LEAST_RESERVE.relaxing(r)));
        for (target, max_rate) in targets.flat_map(|target| [(target, None), (target, Some(0.5))]) {
            let objective = objective(max_rate);
            let points = [0.3, 1.0, 1.5, 3.0, 8.0].map(|m| starts(&objective, m, 12, 1)).concat();
            let exact: Vec<f64> =
                points.iter().map(|x| objective.cost(x, &target, f64::INFINITY)).collect();
            let (mut early, mut counted) = (0, 0);
            for (x, exact_cost) in points.iter().zip(&exact) {
                let near = [0.999, 1.0, 1.001].map(|share| share * exact_cost);
                for most in exact.iter().copied().step_by(3).chain(near) {
                    let cost = objective.cost(x, &target, most);
                    if cost == f64::INFINITY {
                        assert!(*exact_cost > most, "{target:?}: {exact_cost} {most}");
                        early += 1;
                    } else {
                        assert_eq!(cost, *exact_cost, "{target:?}");
                        counted += 1;
                    }
                }
            }
            assert!(early > 300 && counted > 300, "{target:?}: {early} {counted}");
        }
    }
}
