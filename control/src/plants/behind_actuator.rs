//! A plant behind an actuator that its model has not.

use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::dynamics::{Dynamics, Matrices};
use nalgebra::{DMatrix, DVector};
use steerwright_formats::{
    Bicycle, ChannelSummary, Continuous, IdentifiedActuator, Intersample, Matrix, Plant,
    StatedActuator,
};
use steerwright_models::linear::discretize;

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

impl DesignPlant {
    /// The actuator that the drive of the model shows before its measured angle, and that a controller can be designed for.
    pub(crate) fn identified_actuator(&self) -> Option<IdentifiedActuator> {
        let found = match &self.family {
            Family::Identified(plant) => plant.evidence.actuator,
            Family::Bicycle(bicycle) => bicycle.evidence.as_ref()?.actuator,
            Family::Alone => None,
        };
        found.filter(|found| self.actuator.is_none() && found.fault().is_none())
    }
}

/// The document of an identified model behind an actuator, without its uncertainty. The discrete model is that of a
/// command which is held between the samples.
pub(crate) fn plant_behind(plant: &Plant, actuator: StatedActuator) -> Plant {
    let StatedActuator { time_constant_s: lag, delay_s } = actuator;
    let mut behind = plant.clone();
    behind.input_delay_s += delay_s;
    if lag <= 0.0 {
        return behind;
    }
    behind.uncertainty = None;
    let d = &plant.discrete;
    let matrices = |state: &Matrix, input: &Matrix, output: &Matrix| {
        let n = state.rows();
        Matrices {
            state: DMatrix::from_fn(n, n, |i, j| state.entry(i, j)),
            input: DVector::from_fn(n, |i, _| input.entry(i, 0)),
            output: DVector::from_fn(n, |i, _| output.entry(0, i)),
            feedthrough: d.d.entry(0, 0),
        }
    };
    let kept = (-d.sample_time_s / lag).exp();
    let mut discrete = series(&matrices(&d.a, &d.b, &d.c), kept, 1.0 - kept);
    if let Some(c) = &plant.continuous {
        let continuous = series(&matrices(&c.f, &c.g, &c.h), -1.0 / lag, 1.0 / lag);
        let input =
            DMatrix::from_column_slice(continuous.input.len(), 1, continuous.input.as_slice());
        if let Ok((a, b)) = discretize(&continuous.state, &input, d.sample_time_s) {
            (discrete.state, discrete.input) = (a, b.column(0).into_owned());
        }
        let [f, g, h] = documented(&continuous);
        behind.continuous = Some(Continuous { f, g, h });
    }
    let mut gain: Vec<f64> = (0..d.k.rows()).map(|i| d.k.entry(i, 0)).collect();
    gain.push(0.0);
    // The steering of the actuator is straight ahead at the start, and no innovation moves it.
    behind.discrete.x0.push(0.0);
    let into = &mut behind.discrete;
    [into.a, into.b, into.c] = documented(&discrete);
    into.d = Matrix::column(&[0.0]);
    into.k = Matrix::column(&gain);
    behind
}

/// The document of a bicycle behind an actuator: its own lag and delay grow by those.
pub(crate) fn bicycle_behind(bicycle: &Bicycle, actuator: StatedActuator) -> Bicycle {
    let mut vehicle = bicycle.vehicle.clone();
    vehicle.actuator_time_constant_s += actuator.time_constant_s;
    vehicle.actuator_delay_s += actuator.delay_s;
    let Bicycle { coefficients, state_matrix, input_matrix, .. } = Bicycle::new(vehicle.clone());
    Bicycle { vehicle, coefficients, state_matrix, input_matrix, ..bicycle.clone() }
}

/// State, input and output matrix as a document has them.
fn documented(m: &Matrices) -> [Matrix; 3] {
    let n = m.input.len();
    [
        Matrix::from_fn(n, n, |i, j| m.state[(i, j)]),
        Matrix::column(m.input.as_slice()),
        Matrix::from_fn(1, n, |_, j| m.output[j]),
    ]
}

/// Whether the steering is a measured angle: a command is held, or goes on straight between its samples.
fn is_measured(channels: &[ChannelSummary]) -> bool {
    let steering = channels.iter().find(|channel| channel.role == "steering");
    steering.is_some_and(|c| c.intersample == Some(Intersample::Bl) || c.along_lines)
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
