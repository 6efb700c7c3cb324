//! How a bicycle is identified.

use crate::Error;
use crate::data::split::ValidationData;
use crate::selection::options::MOST_SAMPLES;
use std::collections::BTreeMap;

/// Mass of a mid-size car, kg, where none is stated; yaw rate does not depend on it.
const CONVENTIONAL_MASS: f64 = 1500.0;
/// Share of the weight on the front axle where none is stated.
const CONVENTIONAL_SHARE: f64 = 0.5;

/// Options of [`identify_bicycle`](crate::structures::bicycle::identify_bicycle).
#[derive(Debug, Clone, PartialEq)]
pub struct BicycleOptions {
    /// Mass, kg, which does not follow from the yaw rate; 1500 where `None`.
    pub mass_kg: Option<f64>,
    /// Wheelbase, m. Stated, the steering ratio is identified in its place; `None` identifies the
    /// wheelbase by the log's steering ratio.
    pub wheelbase_m: Option<f64>,
    /// Share of the weight on the front axle, Lr/L, which hardly follows from the yaw rate; 0.5 where
    /// `None`.
    pub front_share: Option<f64>,
    /// Segments below this speed, m/s, are left out: the tyres of a vehicle that crawls obey other laws. 3 m/s·√(L/2.6 m)
    /// with the wheelbase L where `None`.
    pub least_speed_mps: Option<f64>,
    /// Most samples that estimate, in blocks spread over the log; `None`: all of them.
    pub max_samples: Option<usize>,
    /// Which part of the log validates.
    pub validation: ValidationData,
}

impl Default for BicycleOptions {
    fn default() -> Self {
        Self {
            mass_kg: None,
            wheelbase_m: None,
            front_share: None,
            least_speed_mps: None,
            max_samples: Some(MOST_SAMPLES),
            validation: ValidationData::default(),
        }
    }
}

impl BicycleOptions {
    pub(super) fn mass(&self) -> f64 {
        self.mass_kg.unwrap_or(CONVENTIONAL_MASS)
    }

    pub(super) fn front_share(&self) -> f64 {
        self.front_share.unwrap_or(CONVENTIONAL_SHARE)
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
        within("mass", self.mass(), (1.0, 200_000.0), " kg")?;
        within("front share", 100.0 * self.front_share(), (10.0, 90.0), " %")?;
        within("lowest speed", self.least_speed_mps.unwrap_or_default(), (0.0, 100.0), " m/s")?;
        within("wheelbase", self.wheelbase_m.unwrap_or(2.7), (0.05, 20.0), " m")
    }

    pub(super) fn to_map(&self) -> BTreeMap<String, String> {
        let wheelbase = match self.wheelbase_m {
            Some(l) => l.to_string(),
            None => "identified".into(),
        };
        let mut map = BTreeMap::from([
            ("structure".into(), "bicycle".into()),
            ("mass_kg".into(), self.mass().to_string()),
            ("wheelbase_m".into(), wheelbase),
            ("front_share".into(), self.front_share().to_string()),
            ("max_samples".into(), self.max_samples.map_or("all".into(), |n| n.to_string())),
        ]);
        self.validation.describe(&mut map);
        map
    }
}
