//! The standard errors of a manoeuvre: of all parameters of the structure, with the offsets and the initial state of each block
//! eliminated as in the identification.

use super::criterion::{Factor, Square};
use super::schedule::needed_times;
use crate::Error;
use crate::structures::bicycle::information::BicycleInformation;
use steerwright_formats::{Estimated, ExpectedErrors, ExpectedResponse, ManoeuvreGoal};

/// Initial states of a block, after the parameters in a row of sensitivities.
const INITIAL: usize = 2;
/// Of the information of an initial state, as a share of the largest.
const RIDGE: f64 = 1e-9;

/// The information of blocks.
pub(super) struct Driven {
    size: usize,
    information: Square,
    prior: Vec<f64>,
}

impl Driven {
    pub(super) fn new(information: &BicycleInformation) -> Self {
        let size = information.with_offsets();
        Self { size, information: vec![0.0; size * size], prior: information.prior() }
    }

    /// Adds a block by its rows of sensitivities over the noise, which end with those by the initial state.
    pub(super) fn add(&mut self, rows: &[Vec<f64>]) -> Result<(), Error> {
        let (n, all) = (self.size, self.size + INITIAL);
        let mut products = vec![0.0; all * all];
        for row in rows {
            for i in 0..all {
                for j in 0..all {
                    products[i * all + j] += row[i] * row[j];
                }
            }
        }
        // The yaw rate of a neutral vehicle does not depend on its lateral velocity: a ridge in place of a rank decision.
        let ridge = RIDGE * (n..all).map(|i| products[i * all + i]).fold(0.0, f64::max);
        let entry = |i: usize, j: usize| products[i * all + j] + if i == j { ridge } else { 0.0 };
        let own: Vec<f64> = (n..all)
            .flat_map(|i| (n..all).map(move |j| (i, j)))
            .map(|(i, j)| entry(i, j))
            .collect();
        let singular = Error::Numerical { what: "information of the initial state" };
        let factor = Factor::new(&own, INITIAL).ok_or(singular)?;
        let halves: Vec<Vec<f64>> = (0..n)
            .map(|i| factor.half_solve(&[products[i * all + n], products[i * all + n + 1]]))
            .collect();
        for i in 0..n {
            for j in 0..n {
                let explained: f64 = halves[i].iter().zip(&halves[j]).map(|(a, b)| a * b).sum();
                self.information[i * n + j] += products[i * all + j] - explained;
            }
        }
        Ok(())
    }

    /// The factor of the information of a multiple of the time, with the priors.
    fn factor(&self, times: f64) -> Result<Factor, Error> {
        let mut sum: Square = self.information.iter().map(|m| times * m).collect();
        for (i, prior) in self.prior.iter().enumerate() {
            sum[i * self.size + i] += prior;
        }
        Factor::new(&sum, self.size).ok_or(Error::Numerical { what: "information of the design" })
    }
}

/// What is known after blocks.
pub(super) struct Expected<'a> {
    pub(super) information: &'a BicycleInformation,
    pub(super) driven: &'a Driven,
    pub(super) speeds_mps: &'a [f64],
    pub(super) frequencies_hz: &'a [f64],
    pub(super) goal: ManoeuvreGoal,
}

impl Expected<'_> {
    fn response(&self, factor: &Factor, steering_ratio: f64) -> Vec<ExpectedResponse> {
        let mut rows = Vec::new();
        for speed in self.speeds_mps {
            for hz in self.frequencies_hz {
                let [gain, phase] = self.information.response_gradients(*speed, *hz).map(|c| {
                    // The offsets do not change the response.
                    let mut c = c;
                    c.resize(self.driven.size, 0.0);
                    factor.variance(&c).sqrt()
                });
                let [re, im] = self.information.response(*speed, *hz);
                rows.push(ExpectedResponse {
                    speed_mps: *speed,
                    frequency_hz: *hz,
                    gain: re.hypot(im) / steering_ratio,
                    gain_error: gain,
                    phase_error_rad: phase,
                });
            }
        }
        rows
    }

    /// The standard errors, and the time that two of them need to be below `max_error`.
    pub(super) fn errors(
        &self,
        max_error: Option<f64>,
        time_s: f64,
        steering_ratio: f64,
    ) -> Result<ExpectedErrors, Error> {
        let largest = |factor: &Factor, rows: &[ExpectedResponse]| match self.goal {
            ManoeuvreGoal::Understeer => {
                factor.variance(&self.information.understeer_gradient()).sqrt()
            }
            ManoeuvreGoal::Response | ManoeuvreGoal::TyreLimit => {
                rows.iter().map(|row| row.gain_error.max(row.phase_error_rad)).fold(0.0, f64::max)
            }
        };
        let factor = self.driven.factor(1.0)?;
        let response = self.response(&factor, steering_ratio);
        let largest_error = largest(&factor, &response);
        let is_met = |error: f64| max_error.is_none_or(|wanted| 2.0 * error <= wanted);
        let times = max_error.map(|_| {
            needed_times(|times| {
                let factor = self.driven.factor(times)?;
                Ok(is_met(largest(&factor, &self.response(&factor, steering_ratio))))
            })
        });
        let needed_time_s = times.transpose()?.flatten().map(|times| times * time_s);
        let mean = self.speeds_mps.iter().sum::<f64>() / self.speeds_mps.len() as f64;
        let mut parameters = Vec::new();
        for (name, unit, value, gradient) in self.information.combinations(mean) {
            let standard_error = factor.variance(&gradient).sqrt();
            // That of a vehicle that hardly understeers is far beyond what it drives, and not determined.
            let is_speed = unit == "m/s";
            let is_stated = value.is_finite() && standard_error.is_finite();
            if is_stated && !(is_speed && standard_error > value) {
                let (name, unit) = (name.into(), unit.into());
                parameters.push(Estimated { name, value, standard_error, unit });
            }
        }
        Ok(ExpectedErrors {
            largest_error,
            bound: None,
            gap: None,
            met: is_met(largest_error),
            needed_time_s,
            response,
            parameters,
        })
    }
}
