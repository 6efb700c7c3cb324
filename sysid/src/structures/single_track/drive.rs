//! The signals of a drive on one uniform grid.

use crate::Error;

/// A segment: signals without a gap, each of one length; index is time. Axes are those of ISO 8855.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DriveSegment {
    /// Angle of the road wheels, or of the steering wheel by [`Drive::steering_ratio`], rad.
    pub steering_rad: Vec<f64>,
    /// The same before the first sample, where it was recorded: a wheel may still follow it.
    pub steering_before_rad: Vec<f64>,
    /// Of a steering that is held for less than a sample, and whose samples are therefore not what it is held at, its means
    /// over the samples, before the segment and within.
    pub steering_held_rad: Option<Vec<f64>>,
    /// Longitudinal velocity, m/s; not negative.
    pub speed_mps: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: Vec<f64>,
    /// Lateral acceleration `v̇_y + v·r`, m/s².
    pub lateral_acceleration_mps2: Option<Vec<f64>>,
    /// Lateral velocity of the centre of gravity, m/s.
    pub lateral_velocity_mps: Option<Vec<f64>>,
}

/// The signals of a drive. All segments have the same optional signals.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Angle of `steering_rad` over the road-wheel angle: 1 where it is that of the road wheels.
    pub steering_ratio: f64,
    /// How much later than its samples the steering acts, s: half a sample of a command that is held.
    pub steering_delay_s: f64,
    /// The segments.
    pub segments: Vec<DriveSegment>,
}

/// Fewest samples of a segment.
const FEWEST: usize = 10;

impl DriveSegment {
    /// Samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.yaw_rate_radps.len()
    }

    /// Whether it has no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The signals with their names; those that are not there are left out.
    fn signals(&self) -> impl Iterator<Item = (&'static str, &[f64])> {
        [
            ("steering angle", Some(&self.steering_rad)),
            ("speed", Some(&self.speed_mps)),
            ("yaw rate", Some(&self.yaw_rate_radps)),
            ("lateral acceleration", self.lateral_acceleration_mps2.as_ref()),
            ("lateral velocity", self.lateral_velocity_mps.as_ref()),
        ]
        .into_iter()
        .filter_map(|(name, signal)| Some((name, signal?.as_slice())))
    }
}

impl Drive {
    /// Samples of all segments.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.segments.iter().map(DriveSegment::len).sum()
    }

    /// Checks lengths and values.
    ///
    /// # Errors
    /// [`Error::Data`] with the segment and the signal, [`Error::Option`] for the sample time and the
    /// steering ratio, [`Error::TooFewSamples`].
    pub fn check(&self) -> Result<(), Error> {
        let within = |option, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::option(option, value, format!("{low} to {high}")))
        };
        within("sample time", self.sample_time_s, 1e-4, 0.1)?;
        within("steering ratio", self.steering_ratio, 0.01, 1000.0)?;
        within("steering delay", self.steering_delay_s, 0.0, 0.1)?;
        let Some(first) = self.segments.first() else {
            return Err(Error::too_few(0, FEWEST, self.sample_time_s));
        };
        for (k, segment) in self.segments.iter().enumerate() {
            if segment.len() < FEWEST {
                return Err(Error::too_few(segment.len(), FEWEST, self.sample_time_s));
            }
            for (name, signal) in segment.signals() {
                if signal.len() != segment.len() {
                    return Err(Error::data(format!(
                        "segment {k} has {} samples of {name} and {} of yaw rate",
                        signal.len(),
                        segment.len()
                    )));
                }
                if let Some(at) = signal.iter().position(|x| !x.is_finite()) {
                    return Err(Error::data(format!(
                        "sample {at} of the {name} in segment {k} is {}",
                        signal[at]
                    )));
                }
            }
            if let Some(at) = segment.speed_mps.iter().position(|v| *v < 0.0) {
                return Err(Error::data(format!(
                    "the speed is {} m/s at sample {at} of segment {k}; the model drives forwards",
                    segment.speed_mps[at]
                )));
            }
            if !segment.signals().map(|s| s.0).eq(first.signals().map(|s| s.0)) {
                return Err(Error::data(format!(
                    "segment {k} does not have the same signals as the first"
                )));
            }
        }
        Ok(())
    }
}
