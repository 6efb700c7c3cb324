//! What the design minimises.
//!
//! Decision variables, so that plants of any gain and speed look alike: logarithms of kp·G₀
//! (about the crossover, rad/s), ki/kp, kd/kp, the derivative's filter time, and of
//! kp·(1 − b)/ki (the lag behind a yaw ramp). c is 0: a derivative that acts on the reference
//! would kick, and pass on the noise of a path.
//!
//! Cost: first the violations of the requirements, each relative to its bound, the bounds being
//! taken a little tighter than asked for, so that other steppings keep them. Where none is left:
//! lag behind a ramp and absolute error (speed), distance from −1 (robustness), and gain at high
//! frequency (noise).
//!
//! Where not all can be kept, the settling time is what gives way: the quickest loop that keeps the
//! other requirements is looked for. That one does not depend on how much too soon the loop was
//! asked to settle.

use crate::evaluate::{requirements, small_step, steps};
use crate::margins::ResponseGrid;
use crate::options::DesignOptions;
use crate::plant::DesignPlant;
use crate::quickest::settling_scale;
use crate::sampled::Sampled;
use crate::simulate::Simulator;
use formats::{Limits, Specification, StepMetrics};
use std::cell::RefCell;
use vehicle_models::PidParameters;

/// Number of decision variables.
pub(crate) const VARIABLES: usize = 5;
/// What is aimed at, so that other steppings keep the requirements.
pub(crate) const WITH_RESERVE: Aim =
    Aim { upper: [0.8, 0.95, 0.8, 0.8], modulus: 0.01, quickest: false };
/// What is aimed at where that cannot be reached; the modulus margin's coarse grid may miss a
/// little of its minimum.
pub(crate) const BARELY: Aim =
    Aim { upper: [0.98, 0.99, 0.98, 0.98], modulus: 0.006, quickest: false };
/// The same, and as quick as the plant allows.
pub(crate) const QUICKEST: Aim = Aim { quickest: true, ..BARELY };
/// Settling time times crossover of a usual loop, rad.
pub(crate) const CROSSOVER_TIMES_SETTLING: f64 = 5.0;
/// Modulus margin beyond which more is not paid for.
const MODULUS_ENOUGH: f64 = 0.7;
/// Weight of violations against the rest of the cost, which is about 1.
const VIOLATION_WEIGHT: f64 = 100.0;
/// Where the quickest loop is looked for: weight of the settling time's logarithm, small enough
/// that no requirement is given up for it, and of what is not a requirement.
const URGENCY_WEIGHT: f64 = 4.0;
const REST_WEIGHT: f64 = 0.1;
/// There, weight of what a requirement is missed by beyond twice its bound: what is out of reach
/// must not take the rest with it.
const HOPELESS_WEIGHT: f64 = 0.02;
/// Bounds below this, such as an overshoot of 0, are violated relative to this, percent or s.
const LEAST_SCALE: f64 = 0.01;
/// Violation of an unstable loop. Its response may look harmless within the simulated time, so it
/// is not looked at: the way out is less gain.
const UNSTABLE: f64 = 50.0;
/// Points of the frequency grid.
const GRID_POINTS: usize = 120;

/// How much tighter than the requirements is aimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aim {
    /// Shares of the upper bounds: overshoot, settling, both steady-state errors.
    upper: [f64; 4],
    /// Added to the modulus margin.
    modulus: f64,
    /// Whether the settling time gives way to the other requirements.
    quickest: bool,
}

/// The cost of decision variables on a plant.
pub(crate) struct Objective {
    pub(crate) plant: Sampled,
    pub(crate) spec: Specification,
    pub(crate) limits: Limits,
    /// The time by which the decision variables are scaled, s: a settling time.
    pub(crate) scale: f64,
    gain: f64,
    ratio: f64,
    grid: ResponseGrid,
    simulator: RefCell<Simulator>,
}

impl Objective {
    pub(crate) fn new(plant: &DesignPlant, options: &DesignOptions) -> Result<Self, crate::Error> {
        let sampled = Sampled::new(plant, options.sample_time_s, options.loop_delay_s)?;
        let scale = options.settling_time_s;
        Ok(Self {
            grid: ResponseGrid::coarse(&sampled, 0.1 / scale, GRID_POINTS),
            plant: sampled,
            scale,
            spec: options.specification(),
            limits: options.limits(plant),
            gain: plant.gain(),
            ratio: plant.steering_ratio,
            simulator: RefCell::default(),
        })
    }

    /// The same with another scale.
    pub(crate) fn at_scale(mut self, scale: f64) -> Self {
        self.scale = scale;
        self.grid = ResponseGrid::coarse(&self.plant, 0.1 / scale, GRID_POINTS);
        self
    }

    /// A settling time near the shortest within reach, s.
    pub(crate) fn plants_scale(&self) -> f64 {
        settling_scale(&self.plant, self.gain, self.limits.max_angle_rad)
    }

    /// Lower and upper bounds of the decision variables before taking logarithms.
    pub(crate) fn bounds(&self) -> [(f64, f64); VARIABLES] {
        let (t, ts) = (self.scale, self.plant.sample_time);
        [
            (0.2 / t, 40.0 / t),
            (0.05 / t, 20.0 / t),
            (1e-4 * t, 0.5 * t),
            (ts, 0.2 * t + ts),
            (1e-3 * t, t),
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
        let ts = self.plant.sample_time;
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

    /// By how far the small step misses overshoot and settling time, where a limit acts on the
    /// whole step; elsewhere the two are alike.
    fn small_violation(
        &self,
        simulator: &mut Simulator,
        pid: &PidParameters,
        step: &StepMetrics,
        aim: &Aim,
    ) -> f64 {
        const ACTS: f64 = 0.999;
        let limited = step.largest_increment_rad >= ACTS * pid.largest_increment()
            || step.largest_angle_rad >= ACTS * pid.max_angle;
        if !limited || aim.quickest {
            return 0.0;
        }
        let small = small_step(simulator, &self.plant, pid, &self.spec).step;
        let spec = &self.spec;
        let settling = small.settling_time_s.unwrap_or(spec.steady_state_time_s);
        [
            (small.overshoot_percent, aim.upper[0] * spec.overshoot_percent),
            (settling, aim.upper[1] * spec.settling_time_s),
        ]
        .into_iter()
        .map(|(reached, bound)| ((reached - bound) / bound.max(LEAST_SCALE)).max(0.0))
        .map(|v| v.min(1.0) + v.max(1.0).ln())
        .sum()
    }

    /// The cost; always finite.
    pub(crate) fn cost(&self, x: &[f64], aim: &Aim) -> f64 {
        let (pid, outside) = self.controller(x);
        let t = self.scale;
        let modulus = self.grid.modulus_margin(&pid);
        if modulus == 0.0 {
            let less = |rate: f64| (20.0 * rate * t).max(1.0).ln();
            let gains = less(pid.kp * self.gain) + less(pid.ki / pid.kp);
            return VIOLATION_WEIGHT * (UNSTABLE + gains + outside);
        }
        let mut simulator = self.simulator.borrow_mut();
        let [step, offset] = steps(&mut simulator, &self.plant, self.ratio, &pid, &self.spec);
        let required = requirements(&step.step, &offset.step, modulus, &self.spec);
        let aims = aim.upper.map(Some).into_iter().chain([None]);
        let hopeless = if aim.quickest { HOPELESS_WEIGHT } else { 1.0 };
        let violation: f64 = required
            .iter()
            .zip(aims)
            .enumerate()
            .filter(|(i, _)| !(aim.quickest && *i == 1))
            .map(|(_, (r, share))| match share {
                Some(share) => {
                    let bound = share * r.required;
                    ((r.reached - bound) / bound.max(LEAST_SCALE)).max(0.0)
                }
                None => {
                    let required = (r.required + aim.modulus).min(0.99);
                    ((required - r.reached) / required).max(0.0)
                }
            })
            .map(|v| v.min(1.0) + hopeless * v.max(1.0).ln())
            .sum();
        let violation = violation + self.small_violation(&mut simulator, &pid, &step.step, aim);
        let lag = pid.kp * (1.0 - pid.setpoint_weight_proportional) / pid.ki;
        let speed = lag / t + step.integral_absolute_error / t;
        let robustness = (MODULUS_ENOUGH - modulus).max(0.0) * 2.0;
        let high_frequency =
            1.0 + pid.kd / (pid.kp * (pid.derivative_filter_time + pid.sample_time));
        let noise = 0.02 * high_frequency * pid.kp * self.gain * t / 5.0;
        let rest = speed + robustness + noise;
        let rest = if aim.quickest {
            let [_, settling, ..] = &required;
            let settling = step.smooth_settling_s.max(aim.upper[1] * settling.required);
            URGENCY_WEIGHT * (settling / t).ln() + REST_WEIGHT * rest
        } else {
            rest
        };
        let cost = VIOLATION_WEIGHT * (violation + outside) + rest;
        if cost.is_finite() { cost } else { 1e12 }
    }
}
