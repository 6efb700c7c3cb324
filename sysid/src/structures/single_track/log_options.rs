//! How a vehicle is identified in a log.

use crate::Error;
use crate::data::moving::wheelbase_of_log;
use crate::data::split::ValidationData;
use crate::selection::options::MOST_SAMPLES;
use crate::structures::single_track::options::SingleTrackOptions;
use crate::structures::single_track::parameters::Parameter;
use std::collections::BTreeMap;
use steerwright_drivelog::DriveLog;
use steerwright_formats::Prior;

/// Mass of a mid-size car, kg, where none is stated; nothing that is fitted depends on it.
const CONVENTIONAL_MASS: f64 = 1500.0;

/// Options of [`identify_vehicle`](crate::structures::single_track::identify_vehicle).
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyVehicleOptions {
    /// Mass, kg, which does not follow from the motion; 1500 where `None`.
    pub mass_kg: Option<f64>,
    /// Wheelbase, m. Stated, the steering ratio is identified in its place; `None` identifies the
    /// wheelbase by the log's steering ratio.
    pub wheelbase_m: Option<f64>,
    /// Share of the weight on the front axle; identified, with its prior, where `None`.
    pub front_share: Option<f64>,
    /// Left to right wheel, m; 0.58 wheelbases where `None`.
    pub track_width_m: Option<f64>,
    /// Priors by name of the parameter: mean and standard deviation of the coordinate, 0 to fix it. They replace what is
    /// stated above.
    pub priors: Vec<(String, [f64; 2])>,
    /// Whether lateral velocity or sideslip, where the log has one, is fitted too.
    pub fit_lateral_velocity: bool,
    /// Segments below this speed, m/s, are left out: slip angles have no meaning at rest. 3 m/s·√(L/2.6 m) with the
    /// wheelbase L where `None`.
    pub least_speed_mps: Option<f64>,
    /// Most samples that estimate, in blocks spread over the log; `None`: all of them.
    pub max_samples: Option<usize>,
    /// Which part of the log validates.
    pub validation: ValidationData,
}

impl Default for IdentifyVehicleOptions {
    fn default() -> Self {
        Self {
            mass_kg: None,
            wheelbase_m: None,
            front_share: None,
            track_width_m: None,
            priors: Vec::new(),
            fit_lateral_velocity: true,
            least_speed_mps: None,
            max_samples: Some(MOST_SAMPLES),
            validation: ValidationData::default(),
        }
    }
}

/// A wheelbase by the steady turn below which it is that of a model car and the prior's mean, m. A road car whose speed was
/// read in km/h where it is in m/s would have 0.7 m.
const MODEL_CAR_M: f64 = 0.5;

impl IdentifyVehicleOptions {
    pub(super) fn mass(&self) -> f64 {
        self.mass_kg.unwrap_or(CONVENTIONAL_MASS)
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let within = |option, value: f64, (low, high): (f64, f64), unit: &str| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            let expected = format!("{low} to {high}{unit}");
            Err(Error::option(option, format!("{value}{unit}"), expected))
        };
        self.validation.check()?;
        let share = Parameter::FrontShare.default_prior();
        let bounds = (100.0 * share.min, 100.0 * share.max);
        within("front share", 100.0 * self.front_share.unwrap_or(share.mean), bounds, " %")?;
        within("mass", self.mass(), (1.0, 200_000.0), " kg")?;
        within("lowest speed", self.least_speed_mps.unwrap_or(3.0), (0.5, 100.0), " m/s")?;
        within("track width", self.track_width_m.unwrap_or(1.5), (0.1, 10.0), " m")?;
        within("wheelbase", self.wheelbase_m.unwrap_or(2.7), (0.05, 20.0), " m")
    }

    /// The options of the estimator for a log.
    pub(super) fn estimator(&self, log: &DriveLog) -> Result<SingleTrackOptions, Error> {
        let is_angle = log.has_steering_angle();
        if !is_angle && self.wheelbase_m.is_none() {
            return Err(Error::WheelbaseNeeded);
        }
        let mut priors = Vec::new();
        // A longer one may be that of wrong units.
        if self.wheelbase_m.is_none()
            && let Some(wheelbase) = wheelbase_of_log(log).filter(|l| *l < MODEL_CAR_M)
        {
            let prior = Prior { mean: wheelbase, ..Parameter::Wheelbase.default_prior() };
            priors.push((Parameter::Wheelbase, prior));
        }
        if !is_angle {
            // The angle at a command of 1 may be that of a servo or of a steering wheel.
            let prior = Prior { mean: 0.4, standard_deviation: 1.5, min: 1e-3, max: 100.0 };
            priors.push((Parameter::SteeringFactor, prior));
        }
        if let Some(share) = self.front_share {
            let prior = Parameter::FrontShare.default_prior();
            let stated = Prior { mean: share, standard_deviation: 0.0, ..prior };
            priors.push((Parameter::FrontShare, stated));
        }
        for (name, [mean, standard_deviation]) in &self.priors {
            let parameter = Parameter::ALL.into_iter().find(|p| p.name() == name);
            let Some(parameter) = parameter else {
                let names: Vec<&str> = Parameter::ALL.iter().map(|p| p.name()).collect();
                let expected = format!("one of {}", names.join(", "));
                return Err(Error::option("prior", name, expected));
            };
            let (mean, standard_deviation) = (*mean, *standard_deviation);
            let prior = Prior { mean, standard_deviation, ..parameter.default_prior() };
            priors.push((parameter, prior));
        }
        Ok(SingleTrackOptions {
            wheelbase_m: self.wheelbase_m,
            priors,
            fit_lateral_acceleration: true,
            fit_lateral_velocity: self.fit_lateral_velocity,
        })
    }

    pub(super) fn to_map(&self) -> BTreeMap<String, String> {
        let or = |x: Option<f64>, other: &str| match x {
            Some(x) => x.to_string(),
            None => other.into(),
        };
        let mut map = BTreeMap::from([
            ("structure".into(), "single-track".into()),
            ("mass_kg".into(), self.mass().to_string()),
            ("wheelbase_m".into(), or(self.wheelbase_m, "identified")),
            ("front_share".into(), or(self.front_share, "identified")),
            ("track_width_m".into(), or(self.track_width_m, "0.58 wheelbases")),
            ("fit_lateral_velocity".into(), self.fit_lateral_velocity.to_string()),
            ("max_samples".into(), self.max_samples.map_or("all".into(), |n| n.to_string())),
        ]);
        self.validation.describe(&mut map);
        for (name, [mean, deviation]) in &self.priors {
            map.insert(format!("prior {name}"), format!("{mean} ± {deviation}"));
        }
        map
    }
}
