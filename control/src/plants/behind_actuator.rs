//! A plant behind an actuator that its model has not.

use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::dynamics::{Dynamics, Matrices};
use nalgebra::{DMatrix, DVector};
use steerwright_formats::{ChannelSummary, Intersample, StatedActuator};

/// Lag and delay below which a model of a measured angle has no actuator, s: tyres that relax within 0.3 m at 15 m/s have as
/// much.
const NO_ACTUATOR_S: f64 = 0.02;

impl DesignPlant {
    /// The plant of a model behind an actuator; `None` is the plant itself.
    #[must_use]
    pub fn behind(&self, actuator: Option<StatedActuator>) -> Self {
        let mut behind = self.behind_lag(actuator);
        behind.input_delay += actuator.unwrap_or_default().delay_s;
        behind
    }

    /// A plant of the same vehicle without an actuator, behind that of this one; its delay is this one's already.
    pub(crate) fn with_actuator_of(&self, other: &Self) -> Self {
        self.behind_lag(other.actuator)
    }

    fn behind_lag(&self, actuator: Option<StatedActuator>) -> Self {
        let mut behind = self.clone();
        behind.actuator = actuator;
        let lag = actuator.unwrap_or_default().time_constant_s;
        if lag <= 0.0 {
            return behind;
        }
        behind.dynamics = match &self.dynamics {
            Dynamics::Continuous(m) => Dynamics::Continuous(series(m, -1.0 / lag, 1.0 / lag)),
            Dynamics::Discrete { sample_time, matrices } => {
                let kept = (-sample_time / lag).exp();
                let matrices = series(matrices, kept, 1.0 - kept);
                Dynamics::Discrete { sample_time: *sample_time, matrices }
            }
        };
        behind
    }

    /// Whether the model is that of a drive with the measured steering angle, and has no actuator.
    #[must_use]
    pub fn lacks_actuator(&self) -> bool {
        if self.actuator.is_some() {
            return false;
        }
        match &self.family {
            Family::Identified(plant) => is_measured(&plant.evidence.channels),
            Family::Bicycle(bicycle) => {
                let vehicle = &bicycle.vehicle;
                let own = vehicle.actuator_time_constant_s + vehicle.actuator_delay_s;
                let evidence = bicycle.evidence.as_ref();
                own < NO_ACTUATOR_S && evidence.is_some_and(|e| is_measured(&e.channels))
            }
            Family::Alone => false,
        }
    }
}

/// Whether the steering is a measured angle: a command is held, or goes on straight between its samples.
fn is_measured(channels: &[ChannelSummary]) -> bool {
    let steering = channels.iter().find(|channel| channel.role == "steering");
    steering.is_some_and(|c| c.intersample == Some(Intersample::Bl))
}

/// A first-order lag with the state `pole` and the input `gain` before a model.
fn series(m: &Matrices, pole: f64, gain: f64) -> Matrices {
    let n = m.input.len();
    let state = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
        (true, true) => m.state[(i, j)],
        (true, false) => m.input[i],
        (false, true) => 0.0,
        (false, false) => pole,
    });
    Matrices {
        state,
        input: DVector::from_fn(n + 1, |i, _| if i < n { 0.0 } else { gain }),
        output: DVector::from_fn(n + 1, |i, _| if i < n { m.output[i] } else { m.feedthrough }),
        feedthrough: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    /// `G(s)·e^(−τs)/(1 + Ts)` of the plant of the tests, with a feedthrough.
    #[test]
    fn a_plant_behind_an_actuator_is_their_product() {
        let plant = DesignPlant::from_matrices(&[-2.0], &[3.0], &[1.0], 0.5, 0.02).unwrap();
        let actuator = StatedActuator { time_constant_s: 0.05, delay_s: 0.03 };
        let behind = plant.behind(Some(actuator));
        assert!((behind.input_delay - 0.05).abs() < 1e-12);
        assert!((behind.gain() - plant.gain()).abs() < 1e-12);
        let Dynamics::Continuous(m) = &behind.dynamics else { panic!() };
        for omega in [0.3, 2.0, 9.0] {
            let s = Complex::new(0.0, omega);
            let n = m.input.len();
            let matrix = DMatrix::from_fn(n, n, |i, j| {
                if i == j { s - m.state[(i, j)] } else { Complex::from(-m.state[(i, j)]) }
            });
            let x = matrix.lu().solve(&m.input.map(Complex::from)).unwrap();
            let response = m.output.map(Complex::from).dot(&x) + m.feedthrough;
            let expected = (3.0 / (s + 2.0) + 0.5) / (s * 0.05 + 1.0);
            assert!((response - expected).norm() < 1e-12, "{omega}");
        }
        // Its drawn plants and other speeds are behind the same one.
        assert_eq!(plant.with_actuator_of(&behind).dynamics, behind.dynamics);
    }
}
