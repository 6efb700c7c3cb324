//! What a controller costs on the plants of an objective.
//!
//! First the violations of the requirements on every plant held against, each relative to its bound,
//! the bounds being taken a little tighter than asked for, so that other steppings keep them. Where none
//! is left: the logarithm of the longest settling time of all plants and, on the nominal plant, lag
//! behind a ramp and absolute error (speed), distance from −1 (robustness), and gain at high frequency
//! (noise). None of these depends on what was asked for: a loop that may be slow is as quick as one that
//! must be.
//!
//! Where not all can be kept, one requirement gives way, the settling time as a rule: the loop that
//! misses it least and keeps the others is looked for. That one does not depend on how much too soon
//! the loop was asked to settle.
//!
//! A search tells what a cost must not exceed to count. Nearly all of the cost is never less than what
//! is known of it, so most candidates end early: at their margins, at the first overshoot that is too
//! much, or at a plant that ended the one before. What counts is exact, in whatever order.

use crate::closed_loop::metrics::LEAVING;
use crate::closed_loop::scenario::{Scenario, View};
use crate::closed_loop::simulate::{Patience, Simulator};
use crate::design::aim::Aim;
use crate::design::objective::Objective;
use crate::requirement::{Reached, Requirement};
use formats::{Margins, StepMetrics};
use std::cell::RefCell;
use vehicle_models::PidParameters;

/// Weight of the logarithm of the settling time, the longest of all plants.
const SETTLING_WEIGHT: f64 = 2.0;
/// Modulus margin beyond which more is not paid for, and what is paid for one that is short of it by
/// 1: a tenth of the margin for a seventh of the settling time.
const MODULUS_ENOUGH: f64 = 0.7;
const MODULUS_WEIGHT: f64 = 3.0;
/// Weight of what comes beside the settling time: lag behind a ramp and absolute error.
const SPEED_WEIGHT: f64 = 0.5;
/// Weight of violations against the rest of the cost, which is about 1.
const VIOLATION_WEIGHT: f64 = 100.0;
/// Where a requirement gives way: weight of its logarithm, small enough that no other requirement is
/// given up for it, and of what is not a requirement.
const URGENCY_WEIGHT: f64 = 4.0;
const REST_WEIGHT: f64 = 0.1;
/// Violation of an unstable loop. Its response may look harmless within the simulated time, so it
/// is not looked at: the way out is less gain.
const UNSTABLE: f64 = 50.0;
/// Share of the time for plants whose steady state is not looked at.
const SHORT: f64 = 0.5;
/// Shortest settling time, s, as far as its logarithm goes.
const LEAST_SETTLING: f64 = 1e-9;
/// A cost of more than the most is told as this.
const BEYOND: f64 = f64::INFINITY;
/// Share by which a cost must be more than the most, beyond what its order of summation makes of it; and
/// an overshoot that is as good as none, percent.
const ROUNDING: f64 = 1e-9;
const NO_OVERSHOOT: f64 = 1e-8;

/// Scratch space of each thread.
#[derive(Default)]
struct Scratch {
    simulator: Simulator,
    /// The plant that told of the last candidate that it does not count: it comes first, for it may
    /// tell so of the next. No answer depends on it.
    telling: usize,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Something simulated in the scratch space of the thread, which no other simulation is using.
pub(crate) fn with_simulator<R>(simulate: impl FnOnce(&mut Simulator) -> R) -> R {
    SCRATCH.with_borrow_mut(|scratch| simulate(&mut scratch.simulator))
}

/// The parts of a cost.
#[derive(Clone, Copy)]
struct Parts {
    violation: f64,
    rest: f64,
    /// −∞ where nothing gives way.
    urgency: f64,
    /// Longest smooth settling time, s.
    slowest: f64,
}

impl Parts {
    /// Share of what is not a requirement.
    fn share(&self) -> f64 {
        if self.urgency.is_finite() { REST_WEIGHT } else { 1.0 }
    }
}

/// Which plant told that a candidate does not count.
struct Told(usize);

impl Objective {
    /// The cost of decision variables; where it is more than `most` it may be told as infinite.
    pub(crate) fn cost(&self, x: &[f64], aim: &Aim, most: f64) -> f64 {
        let (pid, outside) = self.controller(x);
        let most = most + ROUNDING * (1.0 + most.abs());
        SCRATCH.with_borrow_mut(|scratch| match self.cost_with(scratch, &pid, outside, aim, most) {
            Ok(cost) if cost.is_finite() => cost,
            Ok(_) => 1e12,
            Err(Told(plant)) => {
                scratch.telling = plant;
                BEYOND
            }
        })
    }

    fn cost_with(
        &self,
        scratch: &mut Scratch,
        pid: &PidParameters,
        outside: f64,
        aim: &Aim,
        most: f64,
    ) -> Result<f64, Told> {
        // Margins cost little: those of all plants come before any response.
        let margins = self.scenarios.iter().map(|s| s.margins(pid, self.view.all_margins));
        let margins: Vec<Margins> = margins.collect();
        let stable = |k: &usize| margins[*k].modulus_margin > 0.0;
        let lost = (0..margins.len()).filter(|k| !stable(k)).count();
        // Less gain is the way out of instability, so more of it costs more.
        let unstable = UNSTABLE + (pid.kp * self.gain * self.scale).ln().max(0.0);
        let base = outside + lost as f64 * unstable;
        // What each plant adds, its small step apart: before its response, that of its margins.
        let mut added: Vec<[f64; 2]> = (0..margins.len())
            .map(|k| [if stable(&k) { self.of_margins(&margins[k], aim) } else { 0.0 }, 0.0])
            .collect();
        // In the order of the plants, whichever was looked at first.
        let sum = |added: &[[f64; 2]]| added.iter().flatten().fold(base, |sum, v| sum + v);
        let mut parts =
            Parts { violation: sum(&added), rest: 0.0, urgency: f64::NEG_INFINITY, slowest: 0.0 };
        let first = Some(scratch.telling).filter(|k| (1..margins.len()).contains(k));
        let others = (1..margins.len()).filter(|k| Some(*k) != first);
        for k in std::iter::once(0).chain(first).chain(others).filter(stable) {
            let scenario = &self.scenarios[k];
            let view = self.view_of(scenario, aim);
            let least = if k == 0 { self.least(pid, &margins[0], aim, parts) } else { parts };
            // Without a stable nominal plant nothing is known yet of what gives way.
            let told = |parts: &Parts| match self.is_bounded(parts, aim) && self.total(parts) > most
            {
                true => Err(Told(k)),
                false => Ok(()),
            };
            told(&least)?;
            let patience = self.patience(aim, &least, most, k > 0);
            let simulator = &mut scratch.simulator;
            let metrics = scenario.step(simulator, pid, &self.spec, view, &patience);
            let metrics = metrics.ok_or(Told(k))?;
            let (step, smooth, end) = (metrics.step, metrics.smooth_settling_s, view.until);
            let with_offset = step.steady_state_error_percent;
            let mut reached =
                Reached { step, with_offset, on_curve: 0.0, margins: margins[k], end };
            parts.slowest = parts.slowest.max(smooth);
            let mut count = |reached: &Reached, parts: &mut Parts| {
                if let Some((weak, required)) = self.giving_way(aim) {
                    let value = match weak {
                        Requirement::Settling => smooth,
                        other => reached.value(other),
                    };
                    let urgency = urgency(weak, aim.bound(weak, required), value);
                    parts.urgency = parts.urgency.max(urgency);
                }
                added[k][0] = self.violation(reached, aim, k > 0);
                parts.violation = sum(&added);
            };
            if k == 0 {
                parts.rest = self.rest(pid, &margins[0], step.integral_absolute_error_s);
            }
            if view.with_offset {
                // Without it first: that may be too much already.
                reached.with_offset = 0.0;
                count(&reached, &mut parts);
                told(&parts)?;
                reached.with_offset = scenario.error_with_offset(simulator, pid, &self.spec, view);
            }
            count(&reached, &mut parts);
            if k == 0 {
                added[0][1] = self.small_violation(simulator, scenario, pid, &step, aim);
                parts.violation = sum(&added);
            }
            told(&parts)?;
        }
        Ok(self.total(&parts))
    }

    fn total(&self, parts: &Parts) -> f64 {
        let settling = (parts.slowest.max(LEAST_SETTLING) / self.scale).ln();
        let rest = parts.rest + SETTLING_WEIGHT * settling;
        let rest = match parts.urgency.is_finite() {
            true => parts.urgency + REST_WEIGHT * rest,
            false => rest,
        };
        VIOLATION_WEIGHT * parts.violation + rest
    }

    /// Whether parts of a cost are a bound on it: where a requirement gives way, once a stable plant has
    /// told how far.
    fn is_bounded(&self, parts: &Parts, aim: &Aim) -> bool {
        aim.gives_way.is_none() || parts.urgency.is_finite()
    }

    /// What the nominal plant leaves of the cost at least, whatever its response.
    fn least(&self, pid: &PidParameters, margins: &Margins, aim: &Aim, parts: Parts) -> Parts {
        // At tick 0 all of the step is still missing: half of it is not made up for before half of the
        // first sample.
        let half = LEAVING.0 * aim.band * self.spec.settling_band_percent < 50.0;
        let slowest = if half { 0.5 * self.sample_time } else { 0.0 };
        let urgency = self.giving_way(aim).map_or(f64::NEG_INFINITY, |(weak, required)| {
            let best = match weak {
                Requirement::Settling => slowest,
                other if other.at_least() => f64::INFINITY,
                _ => 0.0,
            };
            urgency(weak, aim.bound(weak, required), best)
        });
        Parts { rest: self.rest(pid, margins, 0.0), urgency, slowest, ..parts }
    }

    /// How long the response of a plant can be followed before the cost is more than the most.
    fn patience(&self, aim: &Aim, least: &Parts, most: f64, other: bool) -> Patience {
        let spare = most - self.total(least);
        if spare == f64::INFINITY || !self.is_bounded(least, aim) {
            return Patience::ENDLESS;
        }
        let beyond = |r: Requirement| {
            let required = r.required(&self.spec).filter(|_| aim.holds(r, other));
            required.map_or(f64::INFINITY, |x| aim.beyond(r, x, spare / VIOLATION_WEIGHT))
        };
        let overshoot = beyond(Requirement::Overshoot) + NO_OVERSHOOT;
        // What the logarithm of the settling time may grow to.
        let of_slowest = least.share() * SETTLING_WEIGHT;
        let now = of_slowest * least.slowest.max(LEAST_SETTLING).ln();
        let logarithm = match aim.gives_way {
            Some(Requirement::Settling) => {
                (now + least.urgency + spare) / (of_slowest + URGENCY_WEIGHT)
            }
            _ => (now + spare) / of_slowest,
        };
        let band = aim.band * self.spec.settling_band_percent / 100.0;
        Patience {
            highest: 1.0 + 0.01 * overshoot,
            settled: (band, beyond(Requirement::Settling)),
            entered: (LEAVING.0 * band, logarithm.exp()),
            decay: None,
        }
    }

    /// What the search looks at of a plant.
    fn view_of(&self, scenario: &Scenario, aim: &Aim) -> View {
        let view = View { band: aim.band, ..self.view };
        if scenario.offset_matters {
            return view;
        }
        // Overshoot and settling show early; what comes late is seen when all plants are judged.
        View { with_offset: false, until: SHORT * self.view.until, ..view }
    }

    /// The requirement that gives way; without a settling time asked for, the shortest is wanted.
    fn giving_way(&self, aim: &Aim) -> Option<(Requirement, f64)> {
        let weak = aim.gives_way?;
        Some((weak, weak.required(&self.spec).unwrap_or(0.0)))
    }

    /// What makes one good loop better than another.
    fn rest(&self, pid: &PidParameters, margins: &Margins, integral_absolute_error: f64) -> f64 {
        let t = self.scale;
        let lag = pid.kp * (1.0 - pid.setpoint_weight_proportional) / pid.ki;
        let slow = (lag + integral_absolute_error) / t;
        let weak = (MODULUS_ENOUGH - margins.modulus_margin).max(0.0);
        let high_frequency =
            1.0 + pid.kd / (pid.kp * (pid.derivative_filter_time + pid.sample_time));
        let noise = 0.004 * high_frequency * pid.kp * self.gain;
        SPEED_WEIGHT * slow + MODULUS_WEIGHT * weak + noise
    }

    fn violation(&self, reached: &Reached, aim: &Aim, other: bool) -> f64 {
        let held = Requirement::ALL.into_iter().filter(|r| aim.holds(*r, other));
        held.map(|r| self.violation_of(r, aim, reached.value(r))).sum()
    }

    /// The part of it that margins tell.
    fn of_margins(&self, margins: &Margins, aim: &Aim) -> f64 {
        let held = Requirement::ALL.into_iter().filter(|r| r.at_least() && aim.holds(*r, false));
        held.map(|r| self.violation_of(r, aim, r.of_margins(margins))).sum()
    }

    fn violation_of(&self, requirement: Requirement, aim: &Aim, value: f64) -> f64 {
        let required = requirement.required(&self.spec);
        required
            .map_or(0.0, |x| aim.violation(requirement.missed(aim.bound(requirement, x), value)))
    }

    /// By how far the small step misses overshoot and settling time, where a limit acts on the
    /// whole step; elsewhere the two are alike.
    fn small_violation(
        &self,
        simulator: &mut Simulator,
        scenario: &Scenario,
        pid: &PidParameters,
        step: &StepMetrics,
        aim: &Aim,
    ) -> f64 {
        const ACTS: f64 = 0.999;
        let limited = step.largest_increment_rad >= ACTS * pid.largest_increment()
            || step.largest_angle_rad >= ACTS * pid.largest_angle(scenario.speed);
        if !limited || aim.gives_way.is_some() {
            return 0.0;
        }
        let small = scenario.small_step(simulator, pid, &self.spec, self.view.until).step;
        let settling = small.settling_time_s.unwrap_or(self.view.until);
        [(Requirement::Overshoot, small.overshoot_percent), (Requirement::Settling, settling)]
            .into_iter()
            .filter_map(|(r, reached)| Some((r, r.required(&self.spec)?, reached)))
            .map(|(r, required, reached)| r.missed(aim.bound(r, required), reached))
            .sum()
    }
}

/// The logarithm of what gives way, weighed: the less the better, and none better than its bound.
fn urgency(weak: Requirement, bound: f64, value: f64) -> f64 {
    let ratio = if weak.at_least() {
        bound / value.clamp(1e-3 * bound, bound)
    } else {
        value.max(bound).max(1e-9)
    };
    URGENCY_WEIGHT * ratio.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::aim::{BARELY, QUICKEST, ROBUST, ROBUST_AND_QUICK, ROBUST_BUT_SLOW};
    use crate::design::options::DesignOptions;
    use crate::design::search::starts;
    use crate::plants::{DesignPlant, PlantInfo};

    /// A mode and a lag, 20 ms late: at its own latency, at others, and with other gains.
    fn objective(max_rate_radps: Option<f64>) -> Objective {
        let info = PlantInfo {
            model: "plant".into(),
            name: "mode".into(),
            speed: 15.0,
            steering_ratio: 1.0,
            input_delay: 0.02,
            quality: formats::Quality::default(),
        };
        let (f, h) = ([0.0, 1.0, -60.0, -9.0], [300.0, 6.0]);
        let plant = DesignPlant::from_matrices(info, &f, &[0.0, 1.0], &h, 0.0).unwrap();
        let max_rate_radps = max_rate_radps.or(Some(1e3));
        let max_lateral_acceleration_mps2 = 1e3;
        let options = DesignOptions {
            max_rate_radps,
            max_lateral_acceleration_mps2,
            ..DesignOptions::default()
        };
        let mut objective = Objective::new(&plant, &options).unwrap();
        for (late, gain, in_short) in [(0.0, 1.2, true), (0.06, 1.0, true), (0.0, 0.3, false)] {
            let plant = plant.with_gain(gain);
            let scenario = Scenario::new(&plant, 0.01, late, objective.scale).unwrap();
            objective.scenarios.push(if in_short { scenario.in_short() } else { scenario });
        }
        objective
    }

    const GIVING: [Requirement; 3] =
        [Requirement::Overshoot, Requirement::ModulusMargin, Requirement::SteadyStateWithOffset];

    /// What gives way is in the cost: a loop that is steered further off costs more.
    #[test]
    fn the_error_with_an_offset_may_give_way() {
        let aim = BARELY.giving(Requirement::SteadyStateWithOffset);
        let cost = |degrees: f64| {
            let mut objective = objective(None);
            objective.spec.steering_offset_rad = degrees.to_radians();
            // Its integral action is too slow to take up any offset within the time.
            let mut x = starts(&objective, 1.0, 1, 1).remove(0);
            x[1] -= 3.0;
            objective.cost(&x, &aim, f64::INFINITY)
        };
        assert!(cost(2.0) > cost(1.0) + 0.1, "{} {}", cost(2.0), cost(1.0));
    }

    /// What a cost must not exceed changes when it is told, not what: above it is told to be above, and
    /// anything else bit by bit.
    #[test]
    fn a_candidate_that_ends_early_is_one_that_does_not_count() {
        let aims = [ROBUST, ROBUST_AND_QUICK, ROBUST_BUT_SLOW, QUICKEST, BARELY]
            .into_iter()
            .chain(GIVING.map(|r| BARELY.giving(r)));
        for (aim, max_rate) in aims.flat_map(|aim| [(aim, None), (aim, Some(0.5))]) {
            let objective = objective(max_rate);
            let points = [0.3, 1.0, 1.5, 3.0, 8.0].map(|m| starts(&objective, m, 12, 1)).concat();
            let exact: Vec<f64> =
                points.iter().map(|x| objective.cost(x, &aim, f64::INFINITY)).collect();
            let (mut early, mut counted) = (0, 0);
            for (x, exact_cost) in points.iter().zip(&exact) {
                let near = [0.999, 1.0, 1.001].map(|share| share * exact_cost);
                for most in exact.iter().copied().step_by(3).chain(near) {
                    let told = objective.cost(x, &aim, most);
                    if told == f64::INFINITY {
                        assert!(*exact_cost > most, "{aim:?}: {exact_cost} {most}");
                        early += 1;
                    } else {
                        assert_eq!(told, *exact_cost, "{aim:?}");
                        counted += 1;
                    }
                }
            }
            assert!(early > 300 && counted > 300, "{aim:?}: {early} {counted}");
        }
    }
}
