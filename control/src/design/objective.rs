//! The requirements of a design, the plants on which they apply, and the decision variables of a search.
//!
//! The decision variables make plants of any gain and speed alike: logarithms of kp·G₀ (about the crossover,
//! rad/s), ki/kp, kd/kp, the derivative's filter time, and kp·(1 − b)/ki (the lag behind a yaw ramp). c is 0:
//! a derivative of the reference jumps with it, and amplifies the noise of a path.

use crate::closed_loop::feedforward::Advice;
use crate::closed_loop::margins::margins;
use crate::closed_loop::scenario::{Scenario, View, on_curve};
use crate::closed_loop::simulate::{Simulator, with_simulator};
use crate::design::bandwidth_limit::settling_scale;
use crate::design::options::DesignOptions;
use crate::plants::design_plant::DesignPlant;
use crate::requirement::Reached;
use steerwright_formats::{Limits, PidGains, Requirement, Specification};
use steerwright_models::PidParameters;
use steerwright_models::files::controller_parameters;

/// Number of decision variables.
pub(crate) const VARIABLES: usize = 5;
/// Responses are simulated for this many times the plant's scale, and for 5 s at least, even where the
/// specification reads the steady state later: by then the error is smaller.
const HORIZON: f64 = 8.0;
const LEAST_HORIZON: f64 = 5.0;

/// The requirements on some plants, the first of which is the nominal one.
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
        // b = 1 − lag·ki/kp, which must not reverse the proportional action.
        let weight = 1.0 - lag * reset;
        outside += (-weight).max(0.0);
        let ts = self.sample_time;
        let integral_time = 1.0 / reset;
        let gains = PidGains {
            kp,
            ki: kp * reset,
            kd: kp * lead,
            derivative_filter_time_s: filter,
            setpoint_weight_proportional: weight.max(0.0),
            setpoint_weight_derivative: 0.0,
            // Åström and Hägglund: between Td and Ti; not faster than the ticks allow.
            anti_windup_time_s: (integral_time * lead).sqrt().max(10.0 * ts).min(integral_time),
        };
        (controller_parameters(&gains, &self.limits, ts), outside)
    }

    /// The decision variables of a controller.
    pub(crate) fn variables(&self, pid: &PidParameters) -> Vec<f64> {
        let PidGains { kp, ki, kd, derivative_filter_time_s, .. } = pid.gains;
        let lag = kp * (1.0 - pid.gains.setpoint_weight_proportional) / ki;
        [kp * self.gain, ki / kp, kd / kp, derivative_filter_time_s, lag].map(f64::ln).to_vec()
    }

    /// Largest rate of the steering that increment and rate allow, rad/s.
    pub(crate) fn fastest(&self) -> f64 {
        self.limits.max_rate_radps.min(self.limits.max_increment_rad / self.sample_time)
    }

    /// The requirements of the specification with their values.
    pub(crate) fn required(&self) -> Vec<(Requirement, f64)> {
        let all = Requirement::ALL.into_iter();
        all.filter_map(|r| Some((r, r.required(&self.spec)?))).collect()
    }

    /// The same on the nominal plant alone with another specification.
    pub(crate) fn with(&self, spec: Specification) -> Self {
        Self { spec, scenarios: self.scenarios[..1].to_vec(), ..*self }
    }

    /// The same on the nominal plant alone with other limits.
    pub(crate) fn limited(&self, limits: Limits) -> Self {
        Self { limits, ..self.with(self.spec) }
    }

    /// The figures of a controller on the nominal plant up to the end of the specification, with the curve.
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
        let (plant, speed) = (&nominal.plant, nominal.speed);
        let curve = on_curve(simulator, plant, speed, pid, &self.spec, &advice);
        Reached { on_curve: curve.steady_state_error_percent, ..reached }
    }

    /// The figures of a controller on a plant, as a search evaluates them.
    pub(crate) fn reached(&self, scenario: &Scenario, pid: &PidParameters) -> Reached {
        let margins = scenario.grid.margins(pid, self.view.all_margins);
        let view = View { band: 1.0, early: false, ..self.view };
        with_simulator(|simulator| scenario.reached(simulator, pid, &self.spec, view, margins))
    }
}
