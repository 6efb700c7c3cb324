//! The estimator: readings and fixes in, a pose out, step by step.

use super::alignment::{Alignment, UNKNOWN};
use super::filter::{BIAS, Filter, SIDESLIP, STATES, YAW};
use super::history::{History, Interval};
use super::parameters::PoseParameters;
use crate::Error;
use crate::error::diverged;
use crate::ticks::Ticks;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// The normalised innovation squared beyond which a fix is an outlier: one good fix in 10,000
/// (χ², two degrees of freedom).
pub const GATE: f64 = 18.42;

/// Outliers in a row after which it is the filter that is wrong.
pub const MOST_OUTLIERS: u32 = 10;

/// Least standard deviation that a fix is believed to have, m.
const LEAST_STD: f64 = 1e-3;

/// The longest step, s.
const LONGEST_STEP: f64 = 3600.0;

/// The readings of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseInput {
    /// The latest fix of the antenna, m.
    pub gnss_x: f64,
    /// The latest fix of the antenna, m.
    pub gnss_y: f64,
    /// Its standard deviation in each coordinate, m; not usable unless above zero.
    pub gnss_std: f64,
    /// Counts fixes: a new fix is a changed count, or the end of a period.
    pub gnss_fix_count: i32,
    /// The gyro's reading, rad/s.
    pub yaw_rate: f64,
    /// Longitudinal velocity, m/s.
    pub speed: f64,
}

/// An extended Kalman filter that takes fixes at the time they were valid.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseEstimator {
    /// Its parameters; taken over by [`Self::start`].
    pub parameters: PoseParameters,
    /// The readings at the end of the next step.
    pub input: PoseInput,
    /// As of when a fix that arrives now was valid.
    pub(super) delayed: Filter,
    pub(super) present: Filter,
    /// The readings between the two.
    pub(super) history: History,
    /// Readings at the end of the last step: yaw rate and speed.
    pub(super) last: Option<[f64; 2]>,
    pub(super) fix_count: i32,
    /// Of fixes without a count.
    pub(super) clock: Ticks,
    /// Outliers since the last fix that was taken.
    pub(super) outliers: u32,
    /// Present while the yaw is to be determined from the fixes.
    pub(super) alignment: Option<Alignment>,
}

impl PoseEstimator {
    /// An estimator before its start.
    ///
    /// # Errors
    /// Names the parameter that is wrong.
    pub fn new(parameters: PoseParameters) -> Result<Self, Error> {
        parameters.check()?;
        let start = Filter::start(&parameters);
        Ok(Self {
            parameters,
            input: PoseInput::default(),
            delayed: start,
            present: start,
            history: History::default(),
            last: None,
            fix_count: 0,
            clock: Ticks::new(),
            outliers: 0,
            alignment: None,
        })
    }

    /// Starts from the parameters. The fix at the input is not used, since its age is unknown.
    ///
    /// # Errors
    /// Names the parameter that is wrong.
    pub fn start(&mut self) -> Result<(), Error> {
        let (input, parameters) = (self.input, self.parameters);
        let unknown = parameters.initial.yaw_std_rad > UNKNOWN;
        *self = Self {
            input,
            fix_count: input.gnss_fix_count,
            alignment: if unknown { Some(Alignment::waiting()) } else { None },
            ..Self::new(parameters)?
        };
        Ok(())
    }

    /// Moves on by a step (s), at whose end the readings are those in [`Self::input`].
    ///
    /// # Errors
    /// Where the step is too long, or the estimate is beyond all numbers.
    pub fn step(&mut self, step: f64) -> Result<(), Error> {
        if !(step > 0.0 && step <= LONGEST_STEP) {
            return Err(Error::Step { step, limit: LONGEST_STEP });
        }
        let PoseInput { yaw_rate, speed, .. } = self.input;
        let [yaw_rate_before, speed_before] = self.last.unwrap_or([yaw_rate, speed]);
        self.last = Some([yaw_rate, speed]);
        let interval = Interval {
            duration: step,
            yaw_rate: 0.5 * yaw_rate_before + 0.5 * yaw_rate,
            // Of readings near the largest numbers, or over next to no time, it would be none.
            yaw_acceleration: ((yaw_rate - yaw_rate_before) / step).clamp(f64::MIN, f64::MAX),
            speed: 0.5 * speed_before + 0.5 * speed,
        };
        let latency = self.parameters.gnss.latency_s;
        self.present.predict(&self.parameters, &interval);
        self.history.push(interval, latency);
        while let Some(passed) = self.history.pop(latency) {
            self.delayed.predict(&self.parameters, &passed);
        }
        let period = self.parameters.gnss.period_s;
        let due = period > 0.0 && self.clock.advance(step / period) > 0;
        if due || self.input.gnss_fix_count != self.fix_count {
            self.fix_count = self.input.gnss_fix_count;
            self.take_fix();
        }
        self.check()
    }

    /// Corrects the filter of the fix's time, and predicts the present one from it again.
    fn take_fix(&mut self) {
        let PoseInput { gnss_x, gnss_y, gnss_std, .. } = self.input;
        let usable = gnss_std > 0.0 && [gnss_x, gnss_y, gnss_std].iter().all(|v| v.is_finite());
        // A fix from before the start has no information on the time since.
        if !usable || !self.history.reaches(self.parameters.gnss.latency_s) {
            return;
        }
        let fix = Vector2::new(gnss_x, gnss_y);
        let variance = gnss_std.max(LEAST_STD).powi(2);
        let (p, delayed) = (&self.parameters, &mut self.delayed);
        if let Some(alignment) = &mut self.alignment {
            if alignment.take(delayed, p, fix, variance) {
                self.alignment = None;
            }
        } else {
            let innovation = delayed.innovation(p, fix, variance);
            // NaN, of a covariance beyond all numbers, fits as little.
            if innovation.normalised_square <= GATE {
                delayed.correct(&innovation);
                self.outliers = 0;
            } else if self.outliers + 1 < MOST_OUTLIERS {
                self.outliers += 1;
                return;
            } else {
                self.outliers = 0;
                let mut alignment = Alignment::waiting();
                alignment.take(delayed, p, fix, variance);
                self.alignment = Some(alignment);
            }
        }
        self.present = self.delayed;
        for interval in self.history.iter() {
            self.present.predict(p, interval);
        }
    }

    fn check(&self) -> Result<(), Error> {
        let [x, y, yaw, bias, sideslip] = self.mean();
        diverged([
            ("x", x),
            ("y", y),
            ("the yaw", yaw),
            ("the gyro's bias", bias),
            ("the correction of the sideslip", sideslip),
            ("the position's deviation", self.position_std()),
        ])?;
        // Numbers without a name.
        let rest = self.delayed.is_finite() && self.present.is_finite();
        diverged([("a covariance", if rest { 0.0 } else { f64::NAN })])
    }

    /// X, Y (m), yaw (rad), the gyro's bias (rad/s) and what is added to the sideslip per yaw rate (s), at present.
    #[must_use]
    pub fn mean(&self) -> [f64; STATES] {
        self.present.mean.into()
    }

    /// Their covariance.
    #[must_use]
    pub fn covariance(&self) -> [[f64; STATES]; STATES] {
        self.present.covariance.into()
    }

    /// Position of the centre of gravity, m.
    #[must_use]
    pub fn x(&self) -> f64 {
        self.present.mean[0]
    }

    /// Position of the centre of gravity, m.
    #[must_use]
    pub fn y(&self) -> f64 {
        self.present.mean[1]
    }

    /// Yaw, rad, not wrapped.
    #[must_use]
    pub fn yaw(&self) -> f64 {
        self.present.mean[YAW]
    }

    /// The direction in which the centre of gravity moves, rad, not wrapped. Without the sideslip of yaw
    /// acceleration: of two readings of a gyro the difference is mostly noise.
    #[must_use]
    pub fn course(&self) -> f64 {
        let [yaw_rate, speed] = self.last.unwrap_or([self.input.yaw_rate, self.input.speed]);
        let rate = yaw_rate - self.present.mean[BIAS];
        let stated = self.parameters.sideslip.at_speed(speed).in_turn(speed * rate);
        self.yaw() + ((stated + self.present.mean[SIDESLIP]) * rate).atan()
    }

    /// What the sideslip per yaw rate is beyond the stated one, s.
    #[must_use]
    pub fn sideslip_per_yaw_rate_offset(&self) -> f64 {
        self.present.mean[SIDESLIP]
    }

    /// Standard deviation of the position in the direction in which it is largest, m.
    #[must_use]
    pub fn position_std(&self) -> f64 {
        self.present.position_std()
    }

    /// Whether the yaw is still to be determined from the fixes.
    #[must_use]
    pub fn is_aligning(&self) -> bool {
        self.alignment.is_some()
    }
}
