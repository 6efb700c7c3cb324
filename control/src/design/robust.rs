//! One set of gains for all plants that the nominal one may stand for.
//!
//! The plants are those drawn from the identified uncertainty, at the latency designed for and beyond
//! and below it, and the same at other speeds where the model holds there. The design is made on few
//! of them: those that miss a requirement by most are added to the nominal one, the gains are looked
//! for again from where they are, and so on until all plants keep everything or nothing is gained. The
//! figures in the evidence are those of plants drawn anew.

use crate::Error;
use crate::closed_loop::scenario::Scenario;
use crate::design::aim::{Aim, HOPELESS_WEIGHT, ROBUST, ROBUST_AND_QUICK, ROBUST_BUT_SLOW};
use crate::design::nominal::{self, Found};
use crate::design::objective::Objective;
use crate::design::optimise::{EVOLVED, QUICK, SHORT, both, each};
use crate::design::options::{DesignOptions, RobustOptions};
use crate::design::search::{search, starts};
use crate::plants::DesignPlant;
use crate::requirement::{Reached, Requirement};
use vehicle_models::PidParameters;
use vehicle_models::noise::gaussian;

/// Plants that the gains are made for; those of the evidence are others.
const DESIGNED_ON: usize = 100;
/// How many times as many plants are drawn at the nominal latency as beyond and below it.
const AT_NOMINAL: usize = 3;
/// Multiples of the plant's scale about which a search begins, and how many starts there are.
const SCALES: [(f64, u32); 4] = [(1.0, 11), (1.5, 11), (3.0, 11), (5.0, 11)];
/// Rounds of adding the worst plants.
const ROUNDS: usize = 5;
/// The same where the settling time gives way.
const FEW_ROUNDS: usize = 3;
/// Draws tried for one plant: what is drawn may be unstable.
const TRIES: u64 = 20;

/// The plants of a robust design.
pub(crate) struct Ensemble<'a> {
    pub(super) plant: &'a DesignPlant,
    pub(super) options: &'a DesignOptions,
    pub(super) robust: RobustOptions,
    scale: f64,
}

/// A plant of the ensemble, and whether it is a drawn one at the nominal latency and speed.
pub(super) struct Relative {
    pub(super) scenario: Scenario,
    pub(super) at_nominal: bool,
}

/// A loop, and by how much the plants designed on miss the requirements with it.
struct Judged {
    found: Found,
    missed: f64,
}

impl Judged {
    /// Whether all plants keep everything.
    fn is_kept(&self) -> bool {
        self.found.met && self.missed == 0.0
    }
}

/// What was found for all plants.
pub(crate) struct Robust {
    pub(crate) found: Found,
    /// On the nominal plant alone.
    pub(crate) objective: Objective,
    /// Where not all plants keep the requirements: the settling time that could be asked for of all
    /// of them, s.
    pub(crate) kept_by: Option<f64>,
}

impl<'a> Ensemble<'a> {
    pub(crate) fn new(
        plant: &'a DesignPlant,
        options: &'a DesignOptions,
        robust: RobustOptions,
        scale: f64,
    ) -> Self {
        Self { plant, options, robust, scale }
    }

    /// Lowest and highest delay of the loop beyond the plant's own.
    pub(super) fn delays(&self) -> [f64; 2] {
        let (delay, spread) = (self.options.loop_delay_s, self.robust.latency_s);
        [(delay - spread).max(-self.plant.input_delay), delay + spread]
    }

    pub(super) fn speeds(&self) -> Option<[f64; 2]> {
        let scheduled = self.plant.is_speed_scheduled() && self.robust.speed_share > 0.0;
        let share = self.robust.speed_share;
        scheduled.then(|| [1.0 - share, 1.0 + share].map(|s| s * self.plant.speed))
    }

    pub(super) fn scenario(&self, plant: &DesignPlant, delay: f64) -> Option<Scenario> {
        Scenario::new(plant, self.options.sample_time_s, delay, self.scale).ok()
    }

    /// `count` drawn plants, and the nominal one where none can be drawn, at all latencies and speeds.
    pub(super) fn draw(&self, stream: u64, count: usize) -> Vec<Relative> {
        let nominal = self.options.loop_delay_s;
        let mut delays = self.delays().to_vec();
        delays.retain(|d| (d - nominal).abs() > 1e-9);
        let mut all = Vec::new();
        let mut push = |plant: &DesignPlant, delay: f64, at_nominal: bool| {
            all.extend(self.scenario(plant, delay).map(|s| Relative { scenario: s, at_nominal }));
        };
        for delay in &delays {
            push(self.plant, *delay, false);
        }
        for (k, member) in self.members(stream, count).iter().enumerate() {
            push(member, nominal, true);
            if k % AT_NOMINAL == 0 {
                delays.iter().for_each(|delay| push(member, *delay, false));
            }
        }
        for gain in self.robust.gain.into_iter().filter(|g| *g != 1.0) {
            push(&self.plant.with_gain(gain), nominal, false);
        }
        for speed in self.speeds().into_iter().flatten() {
            let Ok(plant) = self.plant.at_speed(speed) else { continue };
            push(&plant, nominal, false);
            delays.iter().for_each(|delay| push(&plant, *delay, false));
        }
        all
    }

    fn members(&self, stream: u64, count: usize) -> Vec<DesignPlant> {
        let n = self.plant.ensemble_dimension() as u64;
        if n == 0 {
            return Vec::new();
        }
        // Streams of one seed do not meet: a plant takes at most TRIES · n numbers of its own.
        let seed = (self.options.seed % (1 << 30)) as i32;
        let first = |k: u64| ((stream << 32) + k * TRIES) * n;
        (0..count as u64)
            .filter_map(|k| {
                (0..TRIES).find_map(|t| {
                    let from = first(k) + t * n;
                    let xi: Vec<f64> = (from..from + n).map(|i| gaussian(seed, i)).collect();
                    self.plant.member(&xi)
                })
            })
            .collect()
    }

    /// What is furthest from the nominal plant without drawing: latency, gain and speed at their ends.
    fn extremes(&self) -> Vec<Relative> {
        self.draw(0, 0)
    }

    /// Gains that serve all plants; or else those that serve the nominal one and the others as well as
    /// can be.
    pub(crate) fn find(&self, mut objective: Objective) -> Result<Robust, Error> {
        let seed = self.options.seed;
        let relatives = self.draw(0, DESIGNED_ON);
        self.begin_again(&mut objective);
        let begin = SCALES.map(|(multiple, count)| starts(&objective, multiple, count, seed));
        let begin = begin.concat();
        let first = Found::of(&objective, search(&objective, &ROBUST, &begin, EVOLVED)?);
        // What is nowhere near on few plants is not looked for on more.
        let best = match nominal::is_far(&objective, &first) {
            true => self.judged(&objective, first, &relatives)?,
            false => self.on_members(&mut objective, first, &ROBUST, &relatives, ROUNDS)?,
        };
        if best.is_kept() {
            let best = self.once_more(&mut objective, best.found, &relatives)?;
            objective.scenarios.truncate(1);
            return Ok(Robust { found: best, objective, kept_by: None });
        }
        // The nominal plant comes first.
        objective.scenarios.truncate(1);
        let (quick, nominal) = both(
            || self.quickest(&objective, &begin, &relatives),
            || nominal::find(&objective, seed, true),
        )?;
        let ((quick, kept_by), nominal) = (quick?, nominal?);
        let mut all = vec![best, quick, self.judged(&objective, nominal.clone(), &relatives)?];
        if nominal.met {
            let from = |aim| self.serving_all(&objective, &nominal, aim, &relatives);
            let (first, second) = both(|| from(&ROBUST), || from(&ROBUST_BUT_SLOW))?;
            all.extend([first?, second?]);
        }
        objective.scenarios.truncate(1);
        // Where none keeps everything on the nominal plant, the quickest of those that keep the rest there:
        // a time that is asked for too soon must not change what is the shortest. A stable sort: of those as
        // good as each other the first.
        let keeps_rest = |j: &Judged| j.found.missed(&objective) == 0.0;
        let settling = |j: &Judged| match j.found.met || !keeps_rest(j) {
            true => 0.0,
            false => j.found.reached.value(Requirement::Settling),
        };
        all.sort_by(|a, b| {
            b.found
                .met
                .cmp(&a.found.met)
                .then(keeps_rest(b).cmp(&keeps_rest(a)))
                .then(settling(a).total_cmp(&settling(b)))
                .then(a.missed.total_cmp(&b.missed))
        });
        Ok(Robust { found: all.remove(0).found, objective, kept_by })
    }

    /// How soon all plants could settle: the quickest loop, and the settling time that all keep with it
    /// where they keep everything else.
    fn quickest(
        &self,
        objective: &Objective,
        begin: &[Vec<f64>],
        relatives: &[Relative],
    ) -> Result<(Judged, Option<f64>), Error> {
        let mut objective = objective.with(objective.spec);
        self.begin_again(&mut objective);
        let first = Found::of(&objective, search(&objective, &ROBUST_AND_QUICK, begin, SHORT)?);
        let quick =
            self.on_members(&mut objective, first, &ROBUST_AND_QUICK, relatives, FEW_ROUNDS)?;
        let kept_by = self.kept_by(&objective, &quick.found.pid, relatives);
        Ok((quick, kept_by))
    }

    /// What serves all plants, looked for from what serves the nominal one.
    fn serving_all(
        &self,
        objective: &Objective,
        nominal: &Found,
        aim: &Aim,
        relatives: &[Relative],
    ) -> Result<Judged, Error> {
        let mut objective = objective.with(objective.spec);
        self.begin_again(&mut objective);
        self.on_members(&mut objective, nominal.clone(), aim, relatives, FEW_ROUNDS)
    }

    /// A loop that keeps everything on all plants, looked for once more with those that were added: what
    /// evolves may have come together too soon.
    fn once_more(
        &self,
        objective: &mut Objective,
        best: Found,
        relatives: &[Relative],
    ) -> Result<Found, Error> {
        let seed = self.options.seed.wrapping_add(1);
        let begin = SCALES.map(|(multiple, count)| starts(objective, multiple, count, seed));
        let begin = begin.concat();
        let other = Found::of(objective, search(objective, &ROBUST, &begin, EVOLVED)?);
        let other = self.on_members(objective, other, &ROBUST, relatives, ROUNDS)?;
        let cost = |found: &Found| objective.cost(&found.variables, &ROBUST, f64::INFINITY);
        let better = other.is_kept() && cost(&other.found) < cost(&best);
        Ok(if better { other.found } else { best })
    }

    /// The nominal plant and the extremes alone.
    fn begin_again(&self, objective: &mut Objective) {
        objective.scenarios.truncate(1);
        objective.scenarios.extend(self.extremes().into_iter().map(|r| r.scenario.in_short()));
    }

    /// The settling time that all plants keep, where they keep everything else.
    fn kept_by(&self, objective: &Objective, pid: &PidParameters, all: &[Relative]) -> Option<f64> {
        let mut slowest = 0.0_f64;
        for scenario in objective.scenarios[..1].iter().chain(all.iter().map(|r| &r.scenario)) {
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

    /// Adds the worst of the plants drawn and looks again from there, until none is missed.
    fn on_members(
        &self,
        objective: &mut Objective,
        first: Found,
        aim: &Aim,
        relatives: &[Relative],
        rounds: usize,
    ) -> Result<Judged, Error> {
        let mut chosen: Vec<(bool, usize)> = Vec::new();
        let mut found = first.clone();
        let (mut best, mut least) = (first, f64::INFINITY);
        for _ in 0..rounds {
            let (worst, missed) = self.missed(objective, &found.pid, relatives)?;
            if missed < least && (found.met || !best.met) {
                (best, least) = (found.clone(), missed);
            }
            let before = chosen.len();
            for (r, k) in worst {
                let offset_matters = r == Requirement::SteadyStateWithOffset;
                if !chosen.contains(&(offset_matters, k)) {
                    chosen.push((offset_matters, k));
                    let scenario = relatives[k].scenario.clone();
                    objective.scenarios.push(if offset_matters {
                        scenario
                    } else {
                        scenario.in_short()
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
            found = Found::of(objective, search(objective, aim, &begin, QUICK)?);
        }
        Ok(Judged { found: best, missed: least })
    }

    fn judged(
        &self,
        objective: &Objective,
        found: Found,
        relatives: &[Relative],
    ) -> Result<Judged, Error> {
        let missed = self.missed(objective, &found.pid, relatives)?.1;
        Ok(Judged { found, missed })
    }

    /// The plants that miss each requirement by most, and by how much all is missed.
    fn missed(
        &self,
        objective: &Objective,
        pid: &PidParameters,
        all: &[Relative],
    ) -> Result<(Vec<(Requirement, usize)>, f64), Error> {
        let reached: Vec<Reached> = each(all, |r| objective.reached(&r.scenario, pid))?;
        let (mut worst, mut sum) = (Vec::new(), 0.0);
        for (r, required) in objective.required() {
            // What is out of reach must not take the rest with it.
            let capped = |v: f64| v.min(1.0) + HOPELESS_WEIGHT * v.max(1.0).ln();
            let missed = |k: usize| capped(r.missed(required, reached[k].value(r)));
            let most = (0..all.len()).max_by(|a, b| missed(*a).total_cmp(&missed(*b)));
            if let Some(k) = most.filter(|k| missed(*k) > 0.0) {
                worst.push((r, k));
                // The worst plant counts, and how many there are like it.
                let mean = (0..all.len()).map(missed).sum::<f64>() / all.len() as f64;
                sum += missed(k) + mean;
            }
        }
        Ok((worst, sum))
    }
}
