//! The plant sampled at the controller's ticks, exactly.
//!
//! With yaw added to the states, `z = (x, ψ)`, and the steering angle held from tick to tick, a
//! delay τ = (d + φ)·T, d whole and 0 ≤ φ < 1, splits each sample in two:
//!
//! ```text
//! z(k+1) = Φ z(k) + Γ_old u(k−d−1) + Γ_new u(k−d) + (Γ_old + Γ_new) w(k)
//! Φ = e^{MT},  Γ_old = e^{M(1−φ)T} ∫₀^{φT} e^{Mσ} N dσ,  Γ_new = ∫₀^{(1−φ)T} e^{Mσ} N dσ
//! ```
//!
//! M and N being F and G with the row of ψ̇ = H x + D u. w acts at the plant's input undelayed.
//! A model on its own grid advances by whole steps of that grid within a tick.

use crate::Error;
use crate::plants::design_plant::DesignPlant;
use crate::plants::dynamics::{Dynamics, Matrices};
use nalgebra::{Complex, DMatrix};
use steerwright_models::linear::discretize;

/// Longest delay handled, s.
const LONGEST_DELAY: f64 = 2.0;
/// Delays and grids are taken as whole within this share of a sample.
const SNAP: f64 = 1e-9;

/// A plant between the controller's ticks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sampled {
    pub(crate) sample_time: f64,
    /// States and yaw.
    pub(crate) order: usize,
    /// Φ, row by row.
    pub(crate) phi: Vec<f64>,
    pub(crate) gamma_old: Vec<f64>,
    pub(crate) gamma_new: Vec<f64>,
    /// Whole samples of delay d.
    pub(crate) delay: usize,
    /// Speed that the controller's limits follow, m/s.
    pub(crate) speed: f64,
}

impl Sampled {
    /// Samples a plant with an additional delay at its input.
    pub(crate) fn new(
        plant: &DesignPlant,
        sample_time: f64,
        loop_delay: f64,
    ) -> Result<Self, Error> {
        let delay = plant.input_delay + loop_delay;
        if !(0.0..=LONGEST_DELAY).contains(&delay) {
            return Err(Error::DelayTooLong { delay_s: delay, allowed_s: LONGEST_DELAY });
        }
        let sampled = match &plant.dynamics {
            Dynamics::Continuous(m) => continuous(plant, m, sample_time, delay),
            Dynamics::Discrete { sample_time: grid, matrices } => {
                discrete(plant, matrices, *grid, sample_time, delay)
            }
        }?;
        Ok(Self { speed: plant.speed, ..sampled })
    }

    /// Frequency response from steering to yaw at `z = e^{jωT}`.
    pub(crate) fn response(&self, z: Complex<f64>) -> Complex<f64> {
        let n = self.order;
        let inverse = z.inv();
        let delayed = inverse.powu(u32::try_from(self.delay).unwrap_or(u32::MAX));
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let diagonal = if i == j { z } else { Complex::new(0.0, 0.0) };
            diagonal - self.phi[i * n + j]
        });
        let input = nalgebra::DVector::from_fn(n, |i, _| {
            delayed * (inverse * self.gamma_old[i] + self.gamma_new[i])
        });
        matrix.lu().solve(&input).map_or(Complex::new(f64::INFINITY, 0.0), |x| x[n - 1])
    }

    /// Angle and decay, rad a sample, of the oscillating modes, near which the response may be sharp.
    pub(crate) fn mode_angles(&self) -> Vec<(f64, f64)> {
        let n = self.order;
        DMatrix::from_row_slice(n, n, &self.phi)
            .complex_eigenvalues()
            .iter()
            .filter(|l| l.im > 0.0)
            .map(|l| (l.im.atan2(l.re), -l.re.hypot(l.im).ln()))
            .collect()
    }
}

/// `(x, ψ)` of `(x)`: M and N.
fn with_yaw(m: &Matrices, rate: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = m.input.len();
    let mut state = DMatrix::zeros(n + 1, n + 1);
    state.view_mut((0, 0), (n, n)).copy_from(&m.state);
    for j in 0..n {
        state[(n, j)] = rate * m.output[j];
    }
    let mut input = DMatrix::zeros(n + 1, 1);
    input.view_mut((0, 0), (n, 1)).copy_from(&m.input);
    input[(n, 0)] = rate * m.feedthrough;
    (state, input)
}

fn continuous(
    plant: &DesignPlant,
    m: &Matrices,
    sample_time: f64,
    delay: f64,
) -> Result<Sampled, Error> {
    let (state, input) = with_yaw(m, 1.0);
    let (whole, rest) = split(delay / sample_time);
    let step = |time: f64| {
        discretize(&state, &input, time)
            .map_err(|e| Error::Model { model: plant.name.clone(), problem: e.to_string() })
    };
    let (phi, old, new) = if rest == 0.0 {
        let (phi, new) = step(sample_time)?;
        let old = new.scale(0.0);
        (phi, old, new)
    } else {
        let (first, old) = step(rest * sample_time)?;
        let (second, new) = step((1.0 - rest) * sample_time)?;
        (&second * first, &second * old, new)
    };
    Ok(collect(sample_time, &phi, &old, &new, whole))
}

fn discrete(
    plant: &DesignPlant,
    m: &Matrices,
    grid: f64,
    sample_time: f64,
    delay: f64,
) -> Result<Sampled, Error> {
    let ratio = sample_time / grid;
    let steps = ratio.round();
    if !(steps >= 1.0 && (ratio - steps).abs() < 1e-6) {
        return Err(Error::SampleTimeMismatch {
            model: plant.name.clone(),
            plant_s: grid,
            controller_s: sample_time,
        });
    }
    // Yaw is the integral of the held output; the state matrix keeps ψ itself.
    let (mut state, input) = with_yaw(m, grid);
    let n = state.nrows();
    state[(n - 1, n - 1)] = 1.0;
    let whole = (delay / sample_time - SNAP).ceil().max(0.0) as usize;
    let mut phi = DMatrix::identity(n, n);
    let (mut old, mut new) = (DMatrix::zeros(n, 1), DMatrix::zeros(n, 1));
    // At grid point i of the tick the delayed input is u(k − late), and `late` is d or d + 1.
    let whole_below = whole.saturating_sub(1);
    for i in 0..steps as usize {
        phi = &state * phi;
        old = &state * old;
        new = &state * new;
        let ago = delay / sample_time - i as f64 / steps;
        let late = (ago - SNAP).ceil().max(0.0) as usize;
        if late > whole_below { old += &input } else { new += &input }
    }
    Ok(collect(sample_time, &phi, &old, &new, whole_below))
}

/// Whole samples and the fraction of one.
fn split(samples: f64) -> (usize, f64) {
    let nearest = samples.round();
    if (samples - nearest).abs() < SNAP {
        (nearest as usize, 0.0)
    } else {
        (samples.floor() as usize, samples - samples.floor())
    }
}

fn collect(
    sample_time: f64,
    phi: &DMatrix<f64>,
    old: &DMatrix<f64>,
    new: &DMatrix<f64>,
    delay: usize,
) -> Sampled {
    let order = phi.nrows();
    Sampled {
        sample_time,
        order,
        phi: phi.transpose().as_slice().to_vec(),
        gamma_old: old.as_slice().to_vec(),
        gamma_new: new.as_slice().to_vec(),
        delay,
        speed: 0.0,
    }
}
