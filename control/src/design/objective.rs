//! What the design minimises.
//!
//! Decision variables, so that plants of any gain and speed look alike: logarithms of kp·G₀
//! (about the crossover, rad/s), ki/kp, kd/kp, the derivative's filter time, and of
//! kp·(1 − b)/ki (the lag behind a yaw ramp). c is 0: a derivative that acts on the reference
//! would kick, and pass on the noise of a path.
//!
//! Cost: first the violations of the requirements on every plant held against, each relative to its
//! bound, the bounds being taken a little tighter than asked for, so that other steppings keep them.
//! Where none is left: the logarithm of the longest settling time of all plants and, on the nominal
//! plant, lag behind a ramp and absolute error (speed), distance from −1 (robustness), and gain at high
//! frequency (noise). None of these depends on what was asked for: a loop that may be slow is as quick as one that must be.
//!
//! Where not all can be kept, one requirement gives way, the settling time as a rule: the loop that
//! misses it least and keeps the others is looked for. That one does not depend on how much too soon
//! the loop was asked to settle.

use crate::closed_loop::margins::margins;
use crate::closed_loop::scenario::{Scenario, View};
use crate::closed_loop::simulate::Simulator;
use crate::design::options::DesignOptions;
use crate::design::quickest::settling_scale;
use crate::guidance::advice::Advice;
use crate::plants::DesignPlant;
use crate::requirement::{Reached, Requirement};
use formats::{Limits, Margins, Specification, StepMetrics};
use std::cell::RefCell;
use vehicle_models::PidParameters;

/// Number of decision variables.
pub(crate) const VARIABLES: usize = 5;
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
/// Settling time times crossover of a usual loop, rad.
pub(crate) const CROSSOVER_TIMES_SETTLING: f64 = 5.0;
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
/// There, weight of what a requirement is missed by beyond twice its bound: what is out of reach
/// must not take the rest with it.
pub(crate) const HOPELESS_WEIGHT: f64 = 0.02;
/// Violation of an unstable loop. Its response may look harmless within the simulated time, so it
/// is not looked at: the way out is less gain.
const UNSTABLE: f64 = 50.0;
/// No response may take more than this off the cost.
const ENOUGH: f64 = 60.0;
/// Share of that for plants whose steady state is not looked at.
const SHORT: f64 = 0.5;
/// Responses are looked at for this many times the plant's scale, and for 5 s at least, however long
/// the specification waits: a steady state only gets better.
const HORIZON: f64 = 8.0;
const LEAST_HORIZON: f64 = 5.0;

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
    gives_way: Option<Requirement>,
    /// Share of the settling band: a response that grazes the band settles much later on a plant that
    /// differs by a hair.
    band: f64,
    /// Whether plants other than the nominal one are held to no time.
    others_slow: bool,
}

impl Aim {
    /// The same with another requirement that gives way.
    pub(crate) fn giving(self, way: Requirement) -> Self {
        Self { gives_way: Some(way), ..self }
    }

    /// What is aimed at for a requirement.
    fn bound(&self, requirement: Requirement, required: f64) -> f64 {
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
}

/// The cost of decision variables on some plants, the first of which is the nominal one.
pub(crate) struct Objective {
    pub(crate) spec: Specification,
    pub(crate) limits: Limits,
    /// The time by which the decision variables are scaled, s: a settling time near the shortest.
    pub(crate) scale: f64,
    pub(crate) scenarios: Vec<Scenario>,
    pub(crate) gain: f64,
    pub(crate) sample_time: f64,
    view: View,
}

thread_local! {
    static SIMULATOR: RefCell<Simulator> = RefCell::default();
}

impl Objective {
    pub(crate) fn new(plant: &DesignPlant, options: &DesignOptions) -> Result<Self, crate::Error> {
        let (spec, limits) = (options.specification(), options.limits(plant));
        let nominal = Scenario::new(plant, options.sample_time_s, options.loop_delay_s, 1.0)?;
        let gain = plant.gain();
        let scale = settling_scale(&nominal.plant, gain, limits.max_angle_rad);
        let all_margins =
            [spec.gain_margin_db, spec.phase_margin_deg, spec.delay_margin_s, spec.disk_margin]
                .iter()
                .any(Option::is_some);
        let until = spec.steady_state_time_s.min(LEAST_HORIZON.max(HORIZON * scale));
        Ok(Self {
            scenarios: vec![nominal.at_scale(scale)],
            scale,
            spec,
            limits,
            gain,
            sample_time: options.sample_time_s,
            view: View {
                until,
                band: 1.0,
                all_margins,
                with_offset: spec.steady_state_error_percent.is_some(),
                early: true,
            },
        })
    }

    /// Lower and upper bounds of the decision variables before taking logarithms.
    pub(crate) fn bounds(&self) -> [(f64, f64); VARIABLES] {
        let (t, ts) = (self.scale, self.sample_time);
        [
            (0.05 / t, 60.0 / t),
            (0.01 / t, 20.0 / t),
            (1e-4 * t, 0.5 * t),
            (ts, 0.3 * t + ts),
            (1e-3 * t, 3.0 * t),
        ]
    }

    /// The controller of decision variables, and by how far they lie outside their bounds.
    pub(crate) fn controller(&self, x: &[f64]) -> (PidParameters, f64) {
        let mut outside = 0.0;
        let mut v = [0.0; VARIABLES];
        for ((v, x), (low, high)) in v.iter_mut().zip(x).zip(self.bounds()) {
            let clamped = x.clamp(low.ln(), high.ln());
            outside += (x - clamped).powi(2);
            *v = clamped.exp();
        }
        let [crossover, reset, lead, filter, lag] = v;
        let kp = crossover / self.gain;
        // b = 1 − lag·ki/kp, which must not turn the proportional action round.
        let weight = 1.0 - lag * reset;
        outside += (-weight).max(0.0);
        let ts = self.sample_time;
        let integral_time = 1.0 / reset;
        let parameters = PidParameters {
            kp,
            ki: kp * reset,
            kd: kp * lead,
            derivative_filter_time: filter,
            setpoint_weight_proportional: weight.max(0.0),
            setpoint_weight_derivative: 0.0,
            // Åström and Hägglund: between Td and Ti; not faster than the ticks allow.
            anti_windup_time: (integral_time * lead).sqrt().max(10.0 * ts).min(integral_time),
            max_angle: self.limits.max_angle_rad,
            max_increment: self.limits.max_increment_rad,
            max_rate: self.limits.max_rate_radps,
            sample_time: ts,
        };
        (parameters, outside)
    }

    /// What is asked for.
    pub(crate) fn required(&self) -> Vec<(Requirement, f64)> {
        let all = Requirement::ALL.into_iter();
        all.filter_map(|r| Some((r, r.required(&self.spec)?))).collect()
    }

    /// The same on the nominal plant alone with another specification, or other limits.
    pub(crate) fn with(&self, spec: Specification) -> Self {
        Self { spec, scenarios: self.scenarios[..1].to_vec(), ..*self }
    }

    /// See [`Objective::with`].
    pub(crate) fn limited(&self, limits: Limits) -> Self {
        Self { limits, ..self.with(self.spec) }
    }

    /// What a controller reaches on the nominal plant, on the curve as well, up to the end of the
    /// specification.
    pub(crate) fn whole(&self, simulator: &mut Simulator, pid: &PidParameters) -> Reached {
        let nominal = &self.scenarios[0];
        let margins = margins(&nominal.plant, pid);
        let view = View {
            until: self.spec.steady_state_time_s,
            band: 1.0,
            all_margins: true,
            with_offset: true,
            early: false,
        };
        let (reached, _) = nominal.reached(simulator, pid, &self.spec, view, margins);
        let advice = Advice::by_theory(pid, self.gain, nominal.speed);
        let on_curve = nominal.on_curve(simulator, pid, &self.spec, &advice);
        Reached { on_curve: on_curve.steady_state_error_percent, ..reached }
    }

    /// What a controller reaches on a plant, as the search sees it.
    pub(crate) fn reached(
        &self,
        simulator: &mut Simulator,
        scenario: &Scenario,
        pid: &PidParameters,
    ) -> Reached {
        let margins = scenario.margins(pid, self.view.all_margins);
        let view = View { band: 1.0, early: false, ..self.view };
        scenario.reached(simulator, pid, &self.spec, view, margins).0
    }

    /// The cost of decision variables; where it is more than `most`, by how much is left open.
    pub(crate) fn cost(&self, x: &[f64], aim: &Aim, most: f64) -> f64 {
        let (pid, outside) = self.controller(x);
        // Scratch space of each thread.
        SIMULATOR.with_borrow_mut(|simulator| self.cost_with(simulator, &pid, outside, aim, most))
    }

    fn cost_with(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        outside: f64,
        aim: &Aim,
        most: f64,
    ) -> f64 {
        let (mut rest, mut urgency, mut slowest) = (0.0, f64::NEG_INFINITY, 0.0_f64);
        // Margins cost little: those of all plants come before any response.
        let margins = self.scenarios.iter().map(|s| s.margins(pid, self.view.all_margins));
        let margins: Vec<Margins> = margins.collect();
        // Less gain is the way out of instability, so more of it costs more.
        let unstable = UNSTABLE + (pid.kp * self.gain * self.scale).ln().max(0.0);
        let lost = margins.iter().filter(|m| m.modulus_margin <= 0.0).count();
        let mut violation = outside + lost as f64 * unstable;
        let total = |violation: f64, rest: f64, urgency: f64, slowest: f64| {
            let settling = (slowest.max(1e-9) / self.scale).ln();
            let rest = rest + SETTLING_WEIGHT * settling;
            let rest = if urgency.is_finite() { urgency + REST_WEIGHT * rest } else { rest };
            VIOLATION_WEIGHT * violation + rest
        };
        for (k, (scenario, margins)) in self.scenarios.iter().zip(&margins).enumerate() {
            if margins.modulus_margin <= 0.0 {
                continue;
            }
            // Each further plant only adds to the cost; only the nominal one may take off.
            let less = if k == 0 { ENOUGH } else { 0.0 };
            if total(violation, rest, urgency, slowest) - less > most {
                break;
            }
            let view = self.view_of(scenario, aim);
            let (reached, step) = scenario.reached(simulator, pid, &self.spec, view, *margins);
            violation += self.violation(&reached, aim, k > 0);
            slowest = slowest.max(step.smooth_settling_s);
            if let Some((weak, required)) = self.giving_way(aim) {
                let value = match weak {
                    Requirement::Settling => step.smooth_settling_s,
                    other => reached.value(other),
                };
                let bound = aim.bound(weak, required);
                let ratio = if weak.at_least() {
                    bound / value.clamp(1e-3 * bound, bound)
                } else {
                    value.max(bound).max(1e-9)
                };
                urgency = urgency.max(URGENCY_WEIGHT * ratio.ln());
            }
            if k == 0 {
                rest = self.rest(pid, &reached);
                violation += self.small_violation(simulator, scenario, pid, &step.step, aim);
            }
        }
        let cost = total(violation, rest, urgency, slowest);
        if cost.is_finite() { cost } else { 1e12 }
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
    fn rest(&self, pid: &PidParameters, reached: &Reached) -> f64 {
        let t = self.scale;
        let lag = pid.kp * (1.0 - pid.setpoint_weight_proportional) / pid.ki;
        let slow = (lag + reached.step.integral_absolute_error_s) / t;
        let weak = (MODULUS_ENOUGH - reached.margins.modulus_margin).max(0.0);
        let high_frequency =
            1.0 + pid.kd / (pid.kp * (pid.derivative_filter_time + pid.sample_time));
        let noise = 0.004 * high_frequency * pid.kp * self.gain;
        SPEED_WEIGHT * slow + MODULUS_WEIGHT * weak + noise
    }

    fn violation(&self, reached: &Reached, aim: &Aim, other: bool) -> f64 {
        let hopeless = if aim.gives_way.is_some() { HOPELESS_WEIGHT } else { 1.0 };
        Requirement::ALL
            .into_iter()
            .filter(|r| aim.gives_way != Some(*r))
            .filter(|r| !(other && aim.others_slow && r.is_time()))
            .filter_map(|r| Some((r, r.required(&self.spec)?)))
            .map(|(r, required)| r.missed(aim.bound(r, required), reached.value(r)))
            .map(|v| v.min(1.0) + hopeless * v.max(1.0).ln())
            .sum()
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
            || step.largest_angle_rad >= ACTS * pid.max_angle;
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
