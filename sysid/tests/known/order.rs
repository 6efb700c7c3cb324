//! Systems whose order can be determined: how badly the best model of one order less does.

use super::Random;
use faer::{Mat, MatRef, Side};
use steerwright_sysid::pem::{Stop, refine_output_error};
use steerwright_sysid::{DataSet, Signals, StateSpace, simulate};

/// Of a system whose order can be determined, the best model of one order less errs by this share of
/// the output's root mean square, or more: else no method can determine it.
pub const LEAST_SHARE: f64 = 0.02;
/// Systems are of order 1 to this one in turn.
pub const LARGEST_ORDER: usize = 6;

/// A system with its input and outputs, one of each, from rest.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// What made the data.
    pub truth: StateSpace,
    /// Input, 1 by N: white, standard normal.
    pub u: Signals,
    /// Output without noise.
    pub clean: Signals,
    /// Output with white noise.
    pub noisy: Signals,
}

impl Experiment {
    /// `samples` of a random stable system of one input and one output at a signal-to-noise ratio of
    /// `snr_db` (of the root mean squares).
    pub fn random(
        random: &mut Random,
        order: usize,
        feedthrough: bool,
        samples: usize,
        snr_db: f64,
    ) -> Self {
        let mut truth = random.system(order, 1, 1);
        if !feedthrough {
            truth.d = Mat::zeros(1, 1);
        }
        let u = Signals::from(random.matrix(1, samples));
        let clean = simulate(&truth, u.as_ref(), &vec![0.0; order]);
        let size = rms(&clean) * 10f64.powf(-snr_db / 20.0);
        let noise = random.matrix(1, samples);
        let noisy = Signals::from_fn(1, samples, |_, t| clean[(0, t)] + size * noise[(0, t)]);
        Self { truth, u, clean, noisy }
    }

    /// The error of the best model of one order less on the output without noise, as a share of the
    /// output's root mean square.
    ///
    /// The best has no closed form: the least is taken of output-error models refined on the noise-free
    /// output from balanced truncation, and from each of the models that leave out another balanced
    /// state. A local minimum would make the share too large, the filter too mild.
    #[must_use]
    pub fn share_of_last_state(&self, feedthrough: bool) -> f64 {
        const STOP: Stop = Stop { steps: 60, least_gain: 1e-6 };
        let n = self.truth.order();
        let size = rms(&self.clean);
        let of = |model: &StateSpace, x0: &[f64]| {
            rms(&(&self.clean - simulate(model, self.u.as_ref(), x0))) / size
        };
        let Some(all) = balanced(&self.truth) else { return 0.0 };
        let Ok(data) = DataSet::single(1.0, self.u.clone(), self.clean.clone()) else { return 0.0 };
        if all.order() < n {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for left_out in (0..n).rev() {
            let kept: Vec<usize> = (0..n).filter(|k| *k != left_out).collect();
            let start = keep(&all, &kept);
            if n == 1 {
                // Without a state only the direct gain is left.
                let gain = if feedthrough { projected_gain(&self.u, &self.clean) } else { 0.0 };
                let rest = Signals::from_fn(1, self.u.ncols(), |_, t| {
                    self.clean[(0, t)] - gain * self.u[(0, t)]
                });
                return rms(&rest) / size;
            }
            let x0 = vec![0.0; n - 1];
            if start.spectral_radius() >= 1.0 {
                continue;
            }
            if let Ok((model, x0)) =
                refine_output_error(&start, &[x0], &data, feedthrough, STOP, 1.0)
            {
                least = least.min(of(&model, &x0[0]));
            }
        }
        least
    }

    /// Fit of a model's simulation to the output without noise for another white input, percent.
    #[must_use]
    pub fn clean_fit(&self, model: &StateSpace) -> f64 {
        let mut random = Random(0x5EED);
        let u = random.matrix(1, self.u.ncols());
        let want = simulate(&self.truth, u.as_ref(), &vec![0.0; self.truth.order()]);
        let got = simulate(model, u.as_ref(), &vec![0.0; model.order()]);
        100.0 * (1.0 - rms(&(&want - got)) / rms(&want))
    }
}

/// Root mean square over all samples.
fn rms(m: &Signals) -> f64 {
    (m.as_ref().squared_norm_l2() / m.values().len() as f64).sqrt()
}

fn projected_gain(u: &Signals, y: &Signals) -> f64 {
    let both: f64 = (0..u.ncols()).map(|t| u[(0, t)] * y[(0, t)]).sum();
    both / u.as_ref().squared_norm_l2()
}

/// A stable model in balanced coordinates, states in descending order of their Hankel singular values
/// (B. C. Moore, IEEE Trans. Automatic Control 26, 1981, by the square-root method of Tombs and
/// Postlethwaite 1987), without those that are not reached or not seen; `None` where it is unstable.
fn balanced(model: &StateSpace) -> Option<StateSpace> {
    let bb = &model.b * model.b.transpose();
    let cc = model.c.transpose() * &model.c;
    let l = root(gramian(model.a.as_ref(), bb)?.as_ref())?;
    let m = root(gramian(model.a.transpose(), cc)?.as_ref())?;
    let f = (m.transpose() * &l).as_ref().thin_svd().ok()?;
    let (u, v, s) = (f.U(), f.V(), f.S().column_vector());
    let n = (0..s.nrows()).take_while(|i| s[*i] > 1e-12 * s[0]).count();
    let right = Mat::from_fn(v.nrows(), n, |i, j| v[(i, j)] / s[j].sqrt());
    let left = Mat::from_fn(u.nrows(), n, |i, j| u[(i, j)] / s[j].sqrt());
    let (t, inverse) = (l * right, left.transpose() * m.transpose());
    Some(StateSpace {
        a: &inverse * &model.a * &t,
        b: &inverse * &model.b,
        c: &model.c * &t,
        d: model.d.clone(),
    })
}

/// The model with the states of the given indices only.
fn keep(m: &StateSpace, states: &[usize]) -> StateSpace {
    let n = states.len();
    StateSpace {
        a: Mat::from_fn(n, n, |i, j| m.a[(states[i], states[j])]),
        b: Mat::from_fn(n, m.inputs(), |i, j| m.b[(states[i], j)]),
        c: Mat::from_fn(m.outputs(), n, |i, j| m.c[(i, states[j])]),
        d: m.d.clone(),
    }
}

/// `X = A X Aᵀ + W` for a stable A: X ← X + A X Aᵀ, A ← A², until nothing is added (Smith 1968).
fn gramian(a: MatRef<'_, f64>, w: Mat<f64>) -> Option<Mat<f64>> {
    let (mut a, mut x) = (a.to_owned(), w);
    for _ in 0..50 {
        let added = &a * &x * a.transpose();
        x = &x + &added;
        if added.norm_l2() <= 1e-17 * x.norm_l2() {
            return x.norm_l2().is_finite().then_some(x);
        }
        a = &a * &a;
    }
    None
}

/// R with X = R Rᵀ of a symmetric, positive semidefinite X.
fn root(x: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let n = x.nrows();
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (x[(i, j)] + x[(j, i)]));
    let f = symmetric.self_adjoint_eigen(Side::Lower).ok()?;
    let s = f.S().column_vector();
    Some(Mat::from_fn(n, n, |i, j| f.U()[(i, j)] * s[j].max(0.0).sqrt()))
}
