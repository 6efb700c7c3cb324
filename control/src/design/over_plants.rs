//! What gains reach over plants drawn anew, and where each requirement breaks.

use crate::Error;
use crate::closed_loop::scenario::Scenario;
use crate::design::breaking::breaking;
use crate::design::cost::with_simulator;
use crate::design::objective::Objective;
use crate::design::optimise::each;
use crate::design::robust::Ensemble;
use crate::guidance::advice::Advice;
use crate::requirement::{Reached, Requirement};
use formats::{OverEnsemble, Robustness};
use vehicle_models::PidParameters;

/// Latency that is looked at for where requirements break, s.
const LONGEST_LATENCY: f64 = 0.5;
/// Speeds that are looked at, as shares of the nominal one.
const SPEEDS: (f64, f64) = (0.4, 2.5);

impl Ensemble<'_> {
    /// What the gains reach over plants drawn anew.
    pub(crate) fn evidence(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        advice: &Advice,
    ) -> Result<Robustness, Error> {
        let all = self.draw(1, self.robust.members);
        let spec = &objective.spec;
        let reach = |scenario: &Scenario| {
            let curve = with_simulator(|s| scenario.on_curve(s, pid, spec, advice));
            let on_curve = curve.steady_state_error_percent;
            Reached { on_curve, ..objective.reached(scenario, pid) }
        };
        let reached = each(&all, |r| reach(&r.scenario))?;
        let at_nominal = all.iter().filter(|r| r.at_nominal).count();
        let requirements: Vec<OverEnsemble> = Requirement::ALL
            .into_iter()
            .filter_map(|r| Some((r, r.required(spec)?)))
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
                    // A file holds no infinity.
                    worst: worst.min(1e4),
                    share_kept: share((0..all.len()).filter(kept).count(), all.len()),
                    share_kept_at_nominal: (at_nominal > 0).then(|| share(nominal, at_nominal)),
                }
            })
            .collect();
        let latency = breaking(
            spec,
            self.options.loop_delay_s,
            [-self.plant.input_delay, self.options.loop_delay_s + LONGEST_LATENCY],
            |delay| self.scenario(self.plant, delay).map(|s| reach(&s)),
        );
        let speed = self.plant.is_speed_scheduled().then(|| {
            let (v, delay) = (self.plant.speed, self.options.loop_delay_s);
            breaking(spec, v, [SPEEDS.0 * v, SPEEDS.1 * v], |speed| {
                self.plant
                    .at_speed(speed)
                    .ok()
                    .and_then(|plant| self.scenario(&plant, delay))
                    .map(|s| reach(&s))
            })
        });
        Ok(Robustness {
            met: requirements.iter().all(|r| r.share_kept >= 1.0),
            members: at_nominal,
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
