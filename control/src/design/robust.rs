//! One set of gains for the nominal plant and all others that may be the vehicle.
//!
//! The plants that miss a requirement by most are added to the nominal one and the search is repeated, until
//! all keep every requirement or nothing improves. The evidence is computed on plants that are drawn again.

use crate::Error;
use crate::design::ensemble::{Ensemble, Member};
use crate::design::nominal;
use crate::design::objective::Objective;
use crate::design::optimiser::{EVOLVED, NEAR, QUICK, SHORT};
use crate::design::parallel::{both, each};
use crate::design::search::{FoundDesign, starts};
use crate::design::target::{ROBUST, ROBUST_SHORTEST_SETTLING, ROBUST_UNTIMED, Target, capped};
use crate::requirement::Reached;
use steerwright_formats::Requirement;
use steerwright_models::PidParameters;

/// Plants that the gains are designed on; those of the evidence are others.
const DESIGNED_ON: usize = 100;
/// Multiples of the plant's scale about which a search starts, and starting points about each.
const SCALES: [f64; 4] = [1.0, 1.5, 3.0, 5.0];
const STARTS: u32 = 11;
/// Rounds of adding the worst plants.
const ROUNDS: usize = 5;
/// The same where the settling time is relaxed.
const FEW_ROUNDS: usize = 3;

/// A loop, and by how much the plants designed on miss the requirements with it.
struct Evaluated {
    found: FoundDesign,
    missed: f64,
}

impl Evaluated {
    fn is_kept(&self) -> bool {
        self.found.met && self.missed == 0.0
    }
}

pub(crate) struct Robust {
    pub(crate) found: FoundDesign,
    /// On the nominal plant alone.
    pub(crate) objective: Objective,
    /// Where not all plants keep the requirements: the shortest settling time that all could, s.
    pub(crate) common_settling_s: Option<f64>,
}

impl Ensemble<'_> {
    /// Gains that serve all plants; otherwise the nominal one, and the others as well as possible. The search begins at the
    /// gains of nearly the same plants; where none found from there serve all, at the usual starting points.
    pub(crate) fn find(
        &self,
        mut objective: Objective,
        near: &[PidParameters],
    ) -> Result<Robust, Error> {
        let seed = self.options.seed;
        let members = self.draw(0, DESIGNED_ON);
        if let Some(found) = self.find_near(&mut objective, near, &members)? {
            objective.scenarios.truncate(1);
            return Ok(Robust { found, objective, common_settling_s: None });
        }
        self.reset(&mut objective);
        let begin = SCALES.map(|multiple| starts(&objective, multiple, STARTS, seed)).concat();
        let first = FoundDesign::by_search(&objective, &ROBUST, &begin, EVOLVED)?;
        // Requirements that are out of reach on few plants are not searched for on more.
        let best = match nominal::is_far(&objective, &first) {
            true => self.evaluated(&objective, first, &members)?,
            false => self.with_worst(&mut objective, first, &ROBUST, &members, ROUNDS)?,
        };
        if best.is_kept() {
            let best = self.repeated(&mut objective, best.found, &members)?;
            objective.scenarios.truncate(1);
            return Ok(Robust { found: best, objective, common_settling_s: None });
        }
        // The nominal plant comes first.
        objective.scenarios.truncate(1);
        let (fastest, nominal) = both(
            || self.fastest(&objective, &begin, &members),
            || nominal::find(&objective, seed, true),
        )?;
        let ((fastest, common_settling_s), nominal) = (fastest?, nominal?);
        let mut all = vec![best, fastest, self.evaluated(&objective, nominal.clone(), &members)?];
        if nominal.met {
            let from = |target| self.starting_at_nominal(&objective, &nominal, target, &members);
            let (first, second) = both(|| from(&ROBUST), || from(&ROBUST_UNTIMED))?;
            all.extend([first?, second?]);
        }
        objective.scenarios.truncate(1);
        // A settling time that is out of reach must not change which loop is the fastest. The sort is stable.
        let keeps_rest = |e: &Evaluated| e.found.missed(&objective) == 0.0;
        let settling = |e: &Evaluated| match e.found.met || !keeps_rest(e) {
            true => 0.0,
            false => e.found.reached.value(Requirement::Settling),
        };
        all.sort_by(|a, b| {
            b.found
                .met
                .cmp(&a.found.met)
                .then(keeps_rest(b).cmp(&keeps_rest(a)))
                .then(settling(a).total_cmp(&settling(b)))
                .then(a.missed.total_cmp(&b.missed))
        });
        Ok(Robust { found: all.remove(0).found, objective, common_settling_s })
    }

    /// Gains that keep every requirement on all plants, from those of nearly the same plants.
    fn find_near(
        &self,
        objective: &mut Objective,
        near: &[PidParameters],
        members: &[Member],
    ) -> Result<Option<FoundDesign>, Error> {
        if near.is_empty() {
            return Ok(None);
        }
        self.reset(objective);
        let begin: Vec<Vec<f64>> = near.iter().map(|pid| objective.variables(pid)).collect();
        let first = FoundDesign::by_search(objective, &ROBUST, &begin, NEAR)?;
        if nominal::is_far(objective, &first) {
            return Ok(None);
        }
        let best = self.with_worst(objective, first, &ROBUST, members, ROUNDS)?;
        Ok(if best.is_kept() { Some(best.found) } else { None })
    }

    /// The fastest loop on all plants, and the settling time that all keep if they keep the rest.
    fn fastest(
        &self,
        objective: &Objective,
        begin: &[Vec<f64>],
        members: &[Member],
    ) -> Result<(Evaluated, Option<f64>), Error> {
        let mut objective = objective.with(objective.spec);
        self.reset(&mut objective);
        let target = &ROBUST_SHORTEST_SETTLING;
        let first = FoundDesign::by_search(&objective, target, begin, SHORT)?;
        let fastest = self.with_worst(&mut objective, first, target, members, FEW_ROUNDS)?;
        let common_settling_s = self.common_settling(&objective, &fastest.found.pid, members);
        Ok((fastest, common_settling_s))
    }

    fn starting_at_nominal(
        &self,
        objective: &Objective,
        nominal: &FoundDesign,
        target: &Target,
        members: &[Member],
    ) -> Result<Evaluated, Error> {
        let mut objective = objective.with(objective.spec);
        self.reset(&mut objective);
        self.with_worst(&mut objective, nominal.clone(), target, members, FEW_ROUNDS)
    }

    /// The better of a loop that keeps every requirement on all plants and of another search with the plants
    /// that were added: the populations of the first may have converged too early.
    fn repeated(
        &self,
        objective: &mut Objective,
        best: FoundDesign,
        members: &[Member],
    ) -> Result<FoundDesign, Error> {
        let seed = self.options.seed.wrapping_add(1);
        let begin = SCALES.map(|multiple| starts(objective, multiple, STARTS, seed)).concat();
        let other = FoundDesign::by_search(objective, &ROBUST, &begin, EVOLVED)?;
        let other = self.with_worst(objective, other, &ROBUST, members, ROUNDS)?;
        let cost = |found: &FoundDesign| objective.cost(&found.variables, &ROBUST, f64::INFINITY);
        let better = other.is_kept() && cost(&other.found) < cost(&best);
        Ok(if better { other.found } else { best })
    }

    /// Leaves the nominal plant and the ends of the ranges of latency, gain and speed.
    fn reset(&self, objective: &mut Objective) {
        objective.scenarios.truncate(1);
        let extremes = self.draw(0, 0).into_iter();
        objective.scenarios.extend(extremes.map(|m| m.scenario.without_offset()));
    }

    /// The settling time that all plants keep, where they keep every other requirement.
    fn common_settling(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        members: &[Member],
    ) -> Option<f64> {
        let mut slowest = 0.0_f64;
        for scenario in objective.scenarios[..1].iter().chain(members.iter().map(|m| &m.scenario)) {
            let reached = objective.reached(scenario, pid);
            let missed = |(r, required): &(Requirement, f64)| {
                *r != Requirement::Settling && !r.is_met(*required, reached.value(*r))
            };
            if objective.required().iter().any(missed) {
                return None;
            }
            slowest = slowest.max(reached.step.settling_time_s?);
        }
        Some(slowest)
    }

    /// Adds the worst plants and repeats the search from the gains found, until none misses a requirement.
    fn with_worst(
        &self,
        objective: &mut Objective,
        first: FoundDesign,
        target: &Target,
        members: &[Member],
        rounds: usize,
    ) -> Result<Evaluated, Error> {
        let mut chosen: Vec<(bool, usize)> = Vec::new();
        let mut found = first.clone();
        let (mut best, mut least) = (first, f64::INFINITY);
        for _ in 0..rounds {
            let (worst, missed) = self.missed(objective, &found.pid, members)?;
            if missed < least && (found.met || !best.met) {
                (best, least) = (found.clone(), missed);
            }
            let before = chosen.len();
            for (r, k) in worst {
                let with_offset = r == Requirement::SteadyStateWithOffset;
                if !chosen.contains(&(with_offset, k)) {
                    chosen.push((with_offset, k));
                    let scenario = members[k].scenario.clone();
                    objective.scenarios.push(if with_offset {
                        scenario
                    } else {
                        scenario.without_offset()
                    });
                }
            }
            if chosen.len() == before {
                break;
            }
            let others = found.others.iter().chain(&best.others).cloned();
            let begin: Vec<_> = [found.variables.clone(), best.variables.clone()]
                .into_iter()
                .chain(others)
                .collect();
            found = FoundDesign::by_search(objective, target, &begin, QUICK)?;
        }
        Ok(Evaluated { found: best, missed: least })
    }

    fn evaluated(
        &self,
        objective: &Objective,
        found: FoundDesign,
        members: &[Member],
    ) -> Result<Evaluated, Error> {
        let missed = self.missed(objective, &found.pid, members)?.1;
        Ok(Evaluated { found, missed })
    }

    /// The plants that miss each requirement by most, and by how much all requirements are missed.
    fn missed(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        members: &[Member],
    ) -> Result<(Vec<(Requirement, usize)>, f64), Error> {
        let reached: Vec<Reached> = each(members, |m| objective.reached(&m.scenario, pid))?;
        let (mut worst, mut sum) = (Vec::new(), 0.0);
        for (r, required) in objective.required() {
            let missed = |k: usize| capped(r.missed(required, reached[k].value(r)));
            let most = (0..members.len()).max_by(|a, b| missed(*a).total_cmp(&missed(*b)));
            if let Some(k) = most.filter(|k| missed(*k) > 0.0) {
                worst.push((r, k));
                // The worst plant counts, and the number of similar ones.
                let mean = (0..members.len()).map(missed).sum::<f64>() / members.len() as f64;
                sum += missed(k) + mean;
            }
        }
        Ok((worst, sum))
    }
}
