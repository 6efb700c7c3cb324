//! An estimator as plain data, to be kept and read again, perhaps in another process.

use super::alignment::Alignment;
use super::estimator::{MOST_OUTLIERS, PoseEstimator, PoseInput};
use super::filter::{Filter, STATES};
use super::history::History;
use super::parameters::PoseParameters;
use crate::Error;
use crate::error::finite;
use crate::ticks::Ticks;
use serde::{Deserialize, Serialize};

/// Mean, and covariance by its columns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct SavedFilter {
    mean: [f64; STATES],
    covariance: [[f64; STATES]; STATES],
}

/// All that a [`PoseEstimator`] is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedPose {
    parameters: PoseParameters,
    input: PoseInput,
    delayed: SavedFilter,
    present: SavedFilter,
    history: History,
    last: Option<[f64; 2]>,
    fix_count: i32,
    clock: Ticks,
    outliers: u32,
    alignment: Option<Alignment>,
}

impl PoseEstimator {
    /// The estimator as plain data.
    #[must_use]
    pub fn save(&self) -> SavedPose {
        SavedPose {
            parameters: self.parameters,
            input: self.input,
            delayed: (&self.delayed).into(),
            present: (&self.present).into(),
            history: self.history.clone(),
            last: self.last,
            fix_count: self.fix_count,
            clock: self.clock,
            outliers: self.outliers,
            alignment: self.alignment,
        }
    }

    /// The estimator that was saved. The data may come from anywhere.
    ///
    /// # Errors
    /// Names an invalid value.
    pub fn restore(saved: SavedPose) -> Result<Self, Error> {
        saved.parameters.check()?;
        let input = &saved.input;
        finite("an input", &[input.gnss_x, input.gnss_y, input.gnss_std])?;
        finite("an input", &[input.yaw_rate, input.speed])?;
        finite("a reading of the last step", saved.last.as_ref().map_or(&[], |last| last))?;
        saved.clock.check()?;
        saved.history.check(saved.parameters.gnss.latency_s)?;
        if saved.outliers >= MOST_OUTLIERS {
            let (name, value) = ("the number of outliers in a row", f64::from(saved.outliers));
            return Err(Error::SavedState { name, value, expected: "less than 10" });
        }
        if let Some(alignment) = &saved.alignment {
            alignment.check()?;
        }
        Ok(Self {
            parameters: saved.parameters,
            input: saved.input,
            delayed: saved.delayed.filter()?,
            present: saved.present.filter()?,
            history: saved.history,
            last: saved.last,
            fix_count: saved.fix_count,
            clock: saved.clock,
            outliers: saved.outliers,
            alignment: saved.alignment,
        })
    }
}

impl From<&Filter> for SavedFilter {
    fn from(filter: &Filter) -> Self {
        Self { mean: filter.mean.into(), covariance: filter.covariance.into() }
    }
}

impl SavedFilter {
    fn filter(self) -> Result<Filter, Error> {
        finite("a state", &self.mean)?;
        let c = &self.covariance;
        finite("a covariance", c.as_flattened())?;
        for i in 0..STATES {
            if c[i][i] < 0.0 {
                let (name, value) = ("a variance", c[i][i]);
                return Err(Error::SavedState { name, value, expected: "zero or more" });
            }
            for j in 0..i {
                let value = c[i][j];
                // Rounding may leave a little more than Schwarz allows.
                let most = (c[i][i] * c[j][j]).sqrt() * (1.0 + 1e-6) + 1e-12;
                if value != c[j][i] || value.abs() > most {
                    let expected = "that of its two variances";
                    return Err(Error::SavedState { name: "a covariance", value, expected });
                }
            }
        }
        Ok(Filter { mean: self.mean.into(), covariance: self.covariance.into() })
    }
}
