//! What a design is asked for.

use crate::{Error, plants::DesignPlant, requirement::Requirement};
use formats::{LateralAcceleration, Limits, Specification};

/// Requirements, limits and loop of a design. The defaults are the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignOptions {
    /// What the loop must reach; each requirement is optional. When the steady state is read is chosen
    /// by [`DesignOptions::specification`].
    pub requirements: Specification,
    /// Largest steering angle, rad, in steering coordinates; 22° at the road wheel by default.
    pub max_angle_rad: Option<f64>,
    /// Largest change in a sample, rad, in steering coordinates; 15° at the road wheel by default.
    pub max_increment_rad: Option<f64>,
    /// Largest rate, rad/s, in steering coordinates; by default twice the fastest steering of the drive
    /// that the plant was identified from. A plant without a drive needs it.
    pub max_rate_radps: Option<f64>,
    /// Fastest steering of a drive of the vehicle, rad/s in the plant's steering coordinates: where no rate is
    /// stated and the plant comes from no drive, twice that is assumed.
    pub driven_rate_radps: Option<f64>,
    /// Largest lateral acceleration that the steering angle may ask for in a steady turn, m/s²: it bounds
    /// the angle at each speed.
    pub max_lateral_acceleration_mps2: f64,
    /// Time between the controller's ticks, s.
    pub sample_time_s: f64,
    /// Delay of the yaw loop beyond the plant's own, s.
    pub loop_delay_s: f64,
    /// Delay of the loop through the path beyond the plant's own, s; 0 for the yaw loop's.
    pub path_delay_s: f64,
    /// Delay of the loop through pose estimator and path beyond the plant's own, s; 0 for the path's.
    pub estimator_delay_s: f64,
    /// How the gains are held against other plants than the nominal one; `None` for not at all.
    pub robust: Option<RobustOptions>,
    /// Names the sequence of starting points and the plants drawn; the same seed gives the same design.
    pub seed: u64,
}

/// Which other plants one set of gains must serve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustOptions {
    /// Plants drawn from the identified uncertainty.
    pub members: usize,
    /// Latency beyond and below the one designed for, s; by default what another master adds.
    pub latency_s: f64,
    /// Lowest and highest gain of the plant over the nominal one: tyres give way beyond the lateral
    /// acceleration of the drive, which no uncertainty of a linear model tells.
    pub gain: [f64; 2],
    /// Speed beyond and below the one designed for, as a share, where the model holds at others.
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

/// Usual largest steering angle at the road wheel, deg: the paper's.
pub const MAX_ANGLE_DEG: f64 = 22.0;

/// Samples that a settling time must hold.
const LEAST_SAMPLES: usize = 4;
/// What an actuator is taken to follow, as a multiple of the fastest steering that was driven.
const TIMES_DRIVEN: f64 = 2.0;
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
            let (option, must, within) = bounds(requirement);
            if !(value.is_finite() && within(value)) {
                return Err(Error::Option { option, value, must });
            }
        }
        let band = ("settling band", s.settling_band_percent);
        let limits = [
            ("largest angle", self.max_angle_rad),
            ("largest increment", self.max_increment_rad),
            ("largest rate", self.max_rate_radps),
        ]
        .map(|(name, value)| (name, value.unwrap_or(1.0)));
        let acceleration = ("largest lateral acceleration", self.max_lateral_acceleration_mps2);
        let sample = ("sample time", self.sample_time_s);
        for (option, value) in limits.into_iter().chain([acceleration, sample, band]) {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::Option { option, value, must: "greater than 0" });
            }
        }
        for (option, value) in [
            ("loop delay", self.loop_delay_s),
            ("delay through the path", self.path_delay_s),
            ("delay through the estimator", self.estimator_delay_s),
            ("latency spread", self.robust.map_or(0.0, |r| r.latency_s)),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::Option { option, value, must: "0 or more" });
            }
        }
        if let Some(r) = self.robust {
            if !(0.0..1.0).contains(&r.speed_share) {
                let (option, value) = ("speed spread", r.speed_share);
                return Err(Error::Option { option, value, must: "at least 0 and below 1" });
            }
            if let Some(value) = r.gain.into_iter().find(|g| !(0.1..=10.0).contains(g)) {
                let option = "gain of the plant over the nominal one";
                return Err(Error::Option { option, value, must: "between 0.1 and 10" });
            }
            if r.members > MOST_MEMBERS {
                let (option, value) = ("ensemble", r.members as f64);
                return Err(Error::Option { option, value, must: "at most 10000 plants" });
            }
        }
        // One step simulation stays below a million ticks.
        if self.sample_time_s < 1e-4 {
            let (option, value) = ("sample time", self.sample_time_s);
            return Err(Error::Option { option, value, must: "at least 0.0001 s" });
        }
        self.contradictions()
    }

    /// What cannot hold at once whatever the plant.
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
                    why: "what has settled has risen",
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

    /// The same with the fastest steering of a plant's drive, where none is there yet: for another model of
    /// that vehicle, in the same steering coordinates.
    #[must_use]
    pub fn with_rate_of(self, plant: &DesignPlant) -> Self {
        let driven = || plant.fastest_steering();
        Self { driven_rate_radps: self.driven_rate_radps.or_else(driven), ..self }
    }

    /// The limits of the file, in the plant's steering coordinates; that of the yaw error belongs to the
    /// gains.
    ///
    /// # Errors
    /// [`Error::NoSteeringRate`] where no rate is stated and the plant comes from no drive.
    pub fn limits(&self, plant: &DesignPlant) -> Result<Limits, Error> {
        let road_wheel = |degrees: f64| degrees.to_radians() * plant.steering_ratio;
        let driven = plant.fastest_steering().or(self.driven_rate_radps);
        let max_rate_radps = self
            .max_rate_radps
            .or(driven.map(|rate| TIMES_DRIVEN * rate))
            .ok_or_else(|| Error::NoSteeringRate { model: plant.name.clone() })?;
        let [steering_per_curvature_radm, understeer_gradient_rads2pm] = plant.steady_turn();
        Ok(Limits {
            max_angle_rad: self.max_angle_rad.unwrap_or(road_wheel(MAX_ANGLE_DEG)),
            max_increment_rad: self.max_increment_rad.unwrap_or(road_wheel(15.0)),
            max_rate_radps,
            large_errors: None,
            lateral_acceleration: Some(LateralAcceleration {
                max_mps2: self.max_lateral_acceleration_mps2,
                steering_per_curvature_radm,
                understeer_gradient_rads2pm,
            }),
        })
    }
}

/// What a requirement is called in errors, and what can be asked of it.
fn bounds(requirement: Requirement) -> (&'static str, &'static str, fn(f64) -> bool) {
    use Requirement as R;
    let label = requirement.label();
    match requirement {
        // None at all may be asked for.
        R::Overshoot => (label, "0 or more", |v| v >= 0.0),
        R::Settling => (label, "greater than 0 and at most 60 s", |v| v > 0.0 && v <= 60.0),
        R::ModulusMargin => (label, "at least 0 and below 1", |v| (0.0..1.0).contains(&v)),
        R::DiskMargin => (label, "at least 0 and below 2", |v| (0.0..2.0).contains(&v)),
        R::PhaseMargin => (label, "at least 0 and below 180°", |v| (0.0..180.0).contains(&v)),
        R::GainMargin | R::DelayMargin => (label, "0 or more", |v| v >= 0.0),
        _ => (label, "greater than 0", |v| v > 0.0),
    }
}
