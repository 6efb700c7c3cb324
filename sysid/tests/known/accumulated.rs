//! Known signals as a log that is accumulated, and the model of its R factor.

use faer::Mat;
use std::fmt::Write;
use steerwright_drivelog::{LogFile, LogOptions};
use steerwright_sysid::{
    AccumulateOptions, Accumulated, DataSet, Error, IdentifyOptions, StateSpace,
};

/// Signals of such a spread are of a size that a road wheel and a car have, rad and rad/s.
const SPREADS: [f64; 2] = [0.01, 0.1];

/// Signals accumulated.
#[derive(Debug, Clone)]
pub struct AccumulatedSignals {
    /// What was accumulated.
    pub state: Accumulated,
    /// The accumulated input and output over those given.
    scales: [f64; 2],
}

/// What was identified from a factor.
#[derive(Debug, Clone)]
pub struct OfFactor {
    /// From the inputs to the outputs that were given.
    pub model: StateSpace,
    /// Whether feedback was found.
    pub feedback: bool,
    /// The method it was refined from.
    pub method: String,
    /// Simulation fit on validation windows, percent.
    pub validation_fit: f64,
}

impl AccumulatedSignals {
    /// Of the first segment of data with one input and one output, both of them about zero.
    ///
    /// # Errors
    /// As [`Accumulated::of_log`].
    pub fn new(data: &DataSet, horizon: usize) -> Result<Self, Error> {
        let segment = &data.segments()[0];
        let step = data.sample_time_s();
        let spread = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        let [u, y] = [segment.u.row(0), segment.y.row(0)];
        let scales = [SPREADS[0] / spread(u), SPREADS[1] / spread(y)];
        let mut csv = String::from("time_s,roadwheel_command_rad,yaw_rate_radps\n");
        for (t, (u, y)) in u.iter().zip(y).enumerate() {
            let _ = writeln!(csv, "{:.4},{:e},{:e}", step * t as f64, scales[0] * u, scales[1] * y);
        }
        let log = LogOptions { sample_time_s: Some(step), ..LogOptions::default() };
        let options = AccumulateOptions { log, horizon, ..AccumulateOptions::default() };
        let state = Accumulated::of_log(LogFile::of_bytes("drive.csv", csv.as_bytes()), &options)?;
        Ok(Self { state, scales })
    }

    /// The model of the R factor.
    ///
    /// # Errors
    /// As [`Accumulated::identify`].
    pub fn identify(&self, options: &IdentifyOptions) -> Result<OfFactor, Error> {
        let plant = self.state.identify(options)?;
        let [u, y] = self.scales;
        let d = &plant.discrete;
        let [a, b, c, d] =
            [(&d.a, 1.0), (&d.b, u), (&d.c, 1.0 / y), (&d.d, u / y)].map(|(m, factor)| {
                Mat::from_fn(m.rows(), m.columns().unwrap_or(0), |i, j| factor * m.entry(i, j))
            });
        Ok(OfFactor {
            model: StateSpace { a, b, c, d },
            feedback: plant.evidence.feedback.as_ref().is_some_and(|test| !test.pass),
            method: plant.evidence.method.clone(),
            validation_fit: plant.evidence.fit.validation,
        })
    }
}
