//! The options of a design.

use crate::Error;
use crate::error::{positive, require};
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{
    IdentifiedActuator, NORMAL_95, Requirement, Specification, StatedActuator,
};

/// Requirements, limits and loop of a design. The defaults are the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignOptions {
    /// What the loop must reach; each requirement is optional. [`DesignOptions::specification`] chooses
    /// the time at which the steady state is read.
    pub requirements: Specification,
    /// Largest steering angle, rad, in steering coordinates; 22° at the road wheel by default.
    pub max_angle_rad: Option<f64>,
    /// Largest change in a sample, rad, in steering coordinates; 15° at the road wheel by default.
    pub max_increment_rad: Option<f64>,
    /// Largest rate, rad/s, in steering coordinates; by default twice the fastest steering of the drive
    /// that the plant was identified from. Required for a plant without a drive.
    pub max_rate_radps: Option<f64>,
    /// Fastest steering of a drive of the vehicle, rad/s in the plant's steering coordinates: where no rate is
    /// stated and the plant comes from no drive, twice that is assumed.
    pub driven_rate_radps: Option<f64>,
    /// What moves the steering of a vehicle whose model has the measured angle as its input; `None` where the
    /// model has it, or its drive shows it.
    pub actuator: Option<StatedActuator>,
    /// Largest lateral acceleration of a steady turn, m/s²: it bounds the steering angle at each speed.
    pub max_lateral_acceleration_mps2: f64,
    /// Time between the controller's ticks, s.
    pub sample_time_s: f64,
    /// Delay of the yaw loop beyond the plant's own, s.
    pub loop_delay_s: f64,
    /// Delay of the loop through the path beyond the plant's own, s; 0 for the yaw loop's.
    pub path_delay_s: f64,
    /// Delay of the loop through pose estimator and path beyond the plant's own, s; 0 for the path's.
    pub estimator_delay_s: f64,
    /// The other plants that the gains are designed for; `None` for the nominal plant alone.
    pub robust: Option<RobustOptions>,
    /// Seed of the starting points and of the plants drawn; the same seed returns the same design.
    pub seed: u64,
}

/// The plants that the gains must serve in addition to the nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustOptions {
    /// Plants drawn from the identified uncertainty.
    pub members: usize,
    /// Latency above and below the one designed for, s; by default that of another coupling.
    pub latency_s: f64,
    /// Lowest and highest gain of the plant over the nominal one: tyres saturate beyond the lateral
    /// acceleration of the drive, which the uncertainty of a linear model does not contain.
    pub gain: [f64; 2],
    /// Speed above and below the one designed for, as a share, where the model holds at other speeds.
    pub speed_share: f64,
}

impl Default for RobustOptions {
    fn default() -> Self {
        Self { members: 100, latency_s: 0.01, gain: [0.93, 1.05], speed_share: 0.2 }
    }
}

impl Default for DesignOptions {
    fn default() -> Self {
        Self {
            requirements: Specification::default(),
            max_angle_rad: None,
            max_increment_rad: None,
            max_rate_radps: None,
            driven_rate_radps: None,
            actuator: None,
            max_lateral_acceleration_mps2: 6.0,
            sample_time_s: 0.01,
            loop_delay_s: 0.0,
            path_delay_s: 0.0,
            estimator_delay_s: 0.0,
            robust: Some(RobustOptions::default()),
            seed: 1,
        }
    }
}

/// Samples that a settling time must contain.
const LEAST_SAMPLES: usize = 4;
/// Most plants drawn.
const MOST_MEMBERS: usize = 10_000;

impl DesignOptions {
    /// Checks the values against each other.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::Contradiction`], [`Error::SampleTimeTooLong`].
    pub fn check(&self) -> Result<(), Error> {
        let s = &self.requirements;
        for requirement in Requirement::ALL {
            let Some(value) = requirement.required(s) else { continue };
            let (must, within) = requirement.bounds();
            require(
                value.is_finite() && within(value),
                requirement.label(),
                (value, requirement.unit()),
                must,
            )?;
        }
        positive([
            ("largest angle", self.max_angle_rad.unwrap_or(1.0), " rad"),
            ("largest increment", self.max_increment_rad.unwrap_or(1.0), " rad"),
            ("largest rate", self.max_rate_radps.unwrap_or(1.0), " rad/s"),
            ("largest lateral acceleration", self.max_lateral_acceleration_mps2, " m/s²"),
            ("sample time", self.sample_time_s, " s"),
            ("settling band", s.settling_band_percent, " %"),
        ])?;
        let actuator = self.actuator.unwrap_or_default();
        for (option, value) in [
            ("loop delay", self.loop_delay_s),
            ("delay through the path", self.path_delay_s),
            ("delay through the estimator", self.estimator_delay_s),
            ("time constant of the actuator", actuator.time_constant_s),
            ("delay of the actuator", actuator.delay_s),
            ("latency spread", self.robust.map_or(0.0, |r| r.latency_s)),
        ] {
            require(value.is_finite() && value >= 0.0, option, (value, " s"), "0 or more")?;
        }
        if let Some(r) = self.robust {
            let spread = (100.0 * r.speed_share, " %");
            let is_share = (0.0..1.0).contains(&r.speed_share);
            require(is_share, "speed spread", spread, "at least 0 and below 100 %")?;
            for gain in r.gain {
                let option = "gain of the plant over the nominal one";
                require((0.1..=10.0).contains(&gain), option, (gain, ""), "between 0.1 and 10")?;
            }
            let members = (r.members as f64, " plants");
            require(r.members <= MOST_MEMBERS, "ensemble", members, "at most 10000")?;
        }
        // One step simulation stays below a million ticks.
        let ts = self.sample_time_s;
        require(ts >= 1e-4, "sample time", (ts, " s"), "at least 0.0001 s")?;
        self.contradictions()
    }

    /// Options that contradict each other whatever the plant.
    fn contradictions(&self) -> Result<(), Error> {
        let s = &self.requirements;
        if let Some(settling_time_s) = s.settling_time_s {
            if settling_time_s < LEAST_SAMPLES as f64 * self.sample_time_s {
                return Err(Error::SampleTimeTooLong {
                    sample_time_s: self.sample_time_s,
                    settling_time_s,
                    need: LEAST_SAMPLES,
                });
            }
            if let Some(rise) = s.rise_time_s.filter(|rise| *rise > settling_time_s) {
                return Err(Error::Contradiction {
                    one: format!("a rise time of up to {rise} s"),
                    other: format!("a settling time of at most {settling_time_s} s"),
                    why: "a response rises before it settles",
                });
            }
        }
        let shorter = |outer: f64, inner: f64| outer > 0.0 && outer < inner;
        if shorter(self.path_delay_s, self.loop_delay_s)
            || shorter(self.estimator_delay_s, self.path_delay_s)
        {
            return Err(Error::Contradiction {
                one: format!("a delay of {} s of the yaw loop", self.loop_delay_s),
                other: format!(
                    "{} s through the path and {} s through the estimator",
                    self.path_delay_s, self.estimator_delay_s
                ),
                why: "the loop through the path goes through the yaw loop, and that through the \
                      estimator goes through the path",
            });
        }
        Ok(())
    }

    /// The delays of the loop through the path and of that through the estimator, s.
    pub(crate) fn outer_delays(&self) -> [f64; 2] {
        let path = self.path_delay_s.max(self.loop_delay_s);
        [path, self.estimator_delay_s.max(path)]
    }

    /// The specification of the file: the steady state is read at 5 s, unless settling itself may
    /// take longer than half of that.
    #[must_use]
    pub fn specification(&self) -> Specification {
        let settling = self.requirements.settling_time_s.unwrap_or(0.0);
        let steady_state_time_s = self.requirements.steady_state_time_s.max(2.0 * settling);
        Specification { steady_state_time_s, ..self.requirements }
    }

    /// The same with the actuator that a plant's drive shows between the steering command and the measured angle, and with
    /// its largest rate or that of the model, unless they are stated.
    #[must_use]
    pub fn with_actuator_of(mut self, plant: &DesignPlant) -> Self {
        let found = plant.identified_actuator().filter(|_| self.actuator.is_none());
        let rates = [found.and_then(|found| found.max_rate_radps), plant.largest_rate()];
        let lowest = rates.into_iter().flatten().min_by(f64::total_cmp);
        self.max_rate_radps = self.max_rate_radps.or(lowest);
        let Some(found) = found else { return self };
        let IdentifiedActuator { time_constant_s, delay_s, delay_standard_error_s, .. } = found;
        // The delay may be another one, as a latency may.
        let late = NORMAL_95 * delay_standard_error_s;
        let robust = self.robust.map(|r| RobustOptions { latency_s: r.latency_s.hypot(late), ..r });
        Self { actuator: Some(StatedActuator { time_constant_s, delay_s }), robust, ..self }
    }

    /// The same with the fastest steering of a plant's drive, unless one is stated: for another model of
    /// that vehicle, in the same steering coordinates.
    #[must_use]
    pub fn with_rate_of(self, plant: &DesignPlant) -> Self {
        let driven = || plant.fastest_steering();
        Self { driven_rate_radps: self.driven_rate_radps.or_else(driven), ..self }
    }
}
