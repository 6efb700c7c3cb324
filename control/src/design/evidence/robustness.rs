//! The figures of gains over plants that are drawn again, and where each requirement breaks.

use crate::Error;
use crate::closed_loop::feedforward::Advice;
use crate::closed_loop::scenario::{Scenario, on_curve};
use crate::closed_loop::simulate::with_simulator;
use crate::design::ensemble::Ensemble;
use crate::design::objective::Objective;
use crate::design::parallel::each;
use crate::requirement::Reached;
use steerwright_formats::{Breaking, OverEnsemble, Requirement, Robustness, Specification};
use steerwright_models::PidParameters;

/// Longest latency that is examined, s.
const LONGEST_LATENCY: f64 = 0.5;
/// Speeds that are examined, as shares of the nominal one.
const SPEEDS: (f64, f64) = (0.4, 2.5);
/// Steps to either side, and bisections of the step in which a requirement breaks.
const STEPS: u32 = 40;
const BISECTIONS: u32 = 8;

impl Ensemble<'_> {
    /// The number of plants that are drawn again, and the share that keeps every requirement.
    pub(crate) fn kept(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        advice: &Advice,
    ) -> Result<(usize, f64), Error> {
        let all = self.draw(1, self.robust.members);
        let kept = each(&all, |r| {
            self.reached(objective, &r.scenario, pid, advice).shortfalls(&objective.spec).is_empty()
        })?;
        let count = kept.iter().filter(|kept| **kept).count();
        Ok((all.len(), count as f64 / all.len().max(1) as f64))
    }

    fn reached(
        &self,
        objective: &Objective,
        scenario: &Scenario,
        pid: &PidParameters,
        advice: &Advice,
    ) -> Reached {
        let (plant, speed, spec) = (&scenario.plant, scenario.speed, &objective.spec);
        let curve = with_simulator(|s| on_curve(s, plant, speed, pid, spec, advice));
        let on_curve = curve.steady_state_error_percent;
        Reached { on_curve, ..objective.reached(scenario, pid) }
    }

    /// The figures of the gains over plants that are drawn again; `fixed` gains at other speeds, too.
    pub(crate) fn evidence(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        advice: &Advice,
        fixed: bool,
    ) -> Result<Robustness, Error> {
        let all = self.draw(1, self.robust.members);
        let spec = &objective.spec;
        let reach = |scenario: &Scenario| self.reached(objective, scenario, pid, advice);
        let reached = each(&all, |r| reach(&r.scenario))?;
        let at_nominal = all.iter().filter(|r| r.at_nominal).count();
        let requirements: Vec<OverEnsemble> = objective
            .required()
            .into_iter()
            .map(|(r, required)| {
                let kept = |k: &usize| r.is_met(required, reached[*k].value(r));
                let share = |kept: usize, of: usize| kept as f64 / of.max(1) as f64;
                let values = reached.iter().map(|x| x.value(r));
                let worst = if r.at_least() {
                    values.fold(f64::INFINITY, f64::min)
                } else {
                    values.fold(0.0, f64::max)
                };
                let nominal = (0..all.len()).filter(|k| all[*k].at_nominal).filter(kept).count();
                OverEnsemble {
                    requirement: r.name().into(),
                    required,
                    // JSON has no infinity.
                    worst: worst.min(1e4),
                    share_kept: share((0..all.len()).filter(kept).count(), all.len()),
                    share_kept_at_nominal: if at_nominal > 0 {
                        Some(share(nominal, at_nominal))
                    } else {
                        None
                    },
                }
            })
            .collect();
        let latency = breaking(
            spec,
            self.options.loop_delay_s,
            [-self.plant.input_delay, self.options.loop_delay_s + LONGEST_LATENCY],
            |delay| self.scenario(self.plant, delay).map(|s| reach(&s)),
        );
        let speed = if fixed && self.plant.is_speed_scheduled() {
            let (v, delay) = (self.plant.speed, self.options.loop_delay_s);
            Some(breaking(spec, v, [SPEEDS.0 * v, SPEEDS.1 * v], |speed| {
                self.plant
                    .at_speed(speed)
                    .ok()
                    .and_then(|plant| self.scenario(&plant, delay))
                    .map(|s| reach(&s))
            }))
        } else {
            None
        };
        let lost = at_nominal > 0 && at_nominal < self.robust.members;
        let wanted = if lost { Some(self.robust.members) } else { None };
        Ok(Robustness {
            met: requirements.iter().all(|r| r.share_kept >= 1.0),
            members: at_nominal,
            members_wanted: wanted,
            seed: self.options.seed,
            loop_delay_range_s: self.delays(),
            gain_range: self.robust.gain,
            speed_range_mps: self.speeds(),
            plants: all.len(),
            requirements,
            latency,
            speed: speed.unwrap_or_default(),
        })
    }
}

/// For each requirement kept at `nominal`, the values to either side within `range` from which on it is not;
/// `reached` is `None` where there is no plant to control.
fn breaking(
    spec: &Specification,
    nominal: f64,
    range: [f64; 2],
    reached: impl Fn(f64) -> Option<Reached>,
) -> Vec<Breaking> {
    let at_nominal = reached(nominal);
    let kept_at_nominal: Vec<(Requirement, f64)> = Requirement::ALL
        .into_iter()
        .filter_map(|r| Some((r, r.required(spec)?)))
        .filter(|(r, required)| at_nominal.is_some_and(|x| r.is_met(*required, x.value(*r))))
        .collect();
    let mut all: Vec<Breaking> = kept_at_nominal
        .iter()
        .map(|(r, _)| Breaking {
            requirement: r.name().into(),
            below: None,
            above: None,
            looked: range,
        })
        .collect();
    for (side, end) in range.into_iter().enumerate() {
        if (end - nominal).abs() < 1e-9 {
            continue;
        }
        let mut before = nominal;
        for step in 1..=STEPS {
            // In smaller steps near the nominal value.
            let share = f64::from(step) / f64::from(STEPS);
            let value = nominal + (end - nominal) * share * (0.4 + 0.6 * share);
            let now = reached(value);
            for ((r, required), breaking) in kept_at_nominal.iter().zip(&mut all) {
                let found = if side == 0 { &mut breaking.below } else { &mut breaking.above };
                let kept =
                    |x: &Option<Reached>| x.is_some_and(|x| r.is_met(*required, x.value(*r)));
                if found.is_none() && !kept(&now) {
                    let (mut inside, mut outside) = (before, value);
                    for _ in 0..BISECTIONS {
                        let middle = 0.5 * (inside + outside);
                        if kept(&reached(middle)) { inside = middle } else { outside = middle }
                    }
                    *found = Some(inside);
                }
            }
            before = value;
            let broken = |b: &Breaking| if side == 0 { b.below } else { b.above };
            if all.iter().all(|b| broken(b).is_some()) {
                break;
            }
        }
    }
    all
}
