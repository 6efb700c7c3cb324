//! What a design is asked for on which plants, in the variables that a search moves. What they cost stands
//! in `cost`.
//!
//! Decision variables, so that plants of any gain and speed look alike: logarithms of kp·G₀
//! (about the crossover, rad/s), ki/kp, kd/kp, the derivative's filter time, and of
//! kp·(1 − b)/ki (the lag behind a yaw ramp). c is 0: a derivative that acts on the reference
//! would kick, and pass on the noise of a path.

use crate::closed_loop::margins::margins;
use crate::closed_loop::scenario::{Scenario, View};
use crate::closed_loop::simulate::Simulator;
use crate::design::cost::with_simulator;
use crate::design::options::DesignOptions;
use crate::design::quickest::settling_scale;
use crate::guidance::advice::Advice;
use crate::plants::DesignPlant;
use crate::requirement::{Reached, Requirement};
use formats::{Limits, Specification};
use vehicle_models::PidParameters;

/// Number of decision variables.
pub(crate) const VARIABLES: usize = 5;
/// Settling time times crossover of a usual loop, rad.
pub(crate) const CROSSOVER_TIMES_SETTLING: f64 = 5.0;
/// Responses are looked at for this many times the plant's scale, and for 5 s at least, however long
/// the specification waits: a steady state only gets better.
const HORIZON: f64 = 8.0;
const LEAST_HORIZON: f64 = 5.0;

/// What is asked for on some plants, the first of which is the nominal one.
pub(crate) struct Objective {
    pub(crate) spec: Specification,
    pub(crate) limits: Limits,
    /// The time by which the decision variables are scaled, s: a settling time near the shortest.
    pub(crate) scale: f64,
    pub(crate) scenarios: Vec<Scenario>,
    pub(crate) gain: f64,
    pub(crate) sample_time: f64,
    pub(super) view: View,
}

impl Objective {
    pub(crate) fn new(plant: &DesignPlant, options: &DesignOptions) -> Result<Self, crate::Error> {
        let (spec, limits) = (options.specification(), options.limits(plant)?);
        let nominal = Scenario::new(plant, options.sample_time_s, options.loop_delay_s, 1.0)?;
        let gain = plant.gain();
        let scale = settling_scale(&nominal.plant, gain, limits.largest_angle_rad(plant.speed));
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
        let lateral = self.limits.lateral_acceleration;
        let usual = PidParameters::default();
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
            max_lateral_acceleration: lateral
                .map_or(usual.max_lateral_acceleration, |l| l.max_mps2),
            steering_per_curvature: lateral
                .map_or(usual.steering_per_curvature, |l| l.steering_per_curvature_radm),
            understeer_gradient: lateral
                .map_or(usual.understeer_gradient, |l| l.understeer_gradient_rads2pm),
            sample_time: ts,
            ..usual
        };
        (parameters, outside)
    }

    /// Largest rate of the steering that increment and rate allow, rad/s.
    pub(crate) fn fastest(&self) -> f64 {
        self.limits.max_rate_radps.min(self.limits.max_increment_rad / self.sample_time)
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
        let reached = nominal.reached(simulator, pid, &self.spec, view, margins);
        let advice = Advice::by_theory(pid, self.gain, nominal.speed);
        let on_curve = nominal.on_curve(simulator, pid, &self.spec, &advice);
        Reached { on_curve: on_curve.steady_state_error_percent, ..reached }
    }

    /// What a controller reaches on a plant, as the search sees it.
    pub(crate) fn reached(&self, scenario: &Scenario, pid: &PidParameters) -> Reached {
        let margins = scenario.margins(pid, self.view.all_margins);
        let view = View { band: 1.0, early: false, ..self.view };
        with_simulator(|simulator| scenario.reached(simulator, pid, &self.spec, view, margins))
    }
}
