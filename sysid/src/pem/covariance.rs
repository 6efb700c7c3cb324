//! The covariance of the estimated parameters in local coordinates (Ljung, *System Identification*,
//! 2nd ed. 1999, ch. 9; docs/methods/refinement.md).
//!
//! The initial states, and with the simulation focus where requested a constant on each output, are
//! estimated too and eliminated from ψ. Λ and R are divided by the samples less the parameters.
//! With the simulation focus K follows the model: it has the part that follows from the least
//! prediction error as (A, B, C, D) move, and a part of its own, which in open loop is independent
//! of theirs.

use crate::Error;
use crate::data::DataSet;
use crate::linalg::dense::{self, hcat, is_finite, least_squares, r_factor, solve, svd};
use crate::linalg::r_factor::RFactor;
use crate::model::{Innovation, StateSpace, predictor};
use crate::pem::coordinates::{Coordinates, Move, in_basis, inverse};
use crate::pem::neighbours::{Neighbours, larger, steps};
use crate::pem::noise::Autocovariance;
use crate::pem::rows::{Drive, Sensitivities};
use crate::pem::search::{
    Linearised, Point, each_error, error_covariance, linearise, times, weigh, weight,
};
use crate::pem::uncertain::Uncertain;
use crate::pem::{Focus, moving_inputs};
use faer::Mat;

/// The covariance of `innovation` as refined with `focus` on `data`, with the initial states `x0s`.
/// A gain of zero with the simulation focus is taken as chosen, not estimated.
///
/// # Errors
/// [`Error::NoModel`] where the data do not determine the parameters, [`Error::Numerical`] where a
/// decomposition does not converge.
pub fn uncertain(
    innovation: &Innovation,
    x0s: &[Vec<f64>],
    data: &DataSet,
    feedthrough: bool,
    focus: Focus,
) -> Result<Uncertain, Error> {
    match focus {
        Focus::Prediction => {
            let local =
                Local::new(&predictor_of(innovation), x0s, data, feedthrough, focus, false)?;
            let root = local.inverse()?;
            let of = |step: Vec<f64>| of_innovation(innovation, &back(&local.coordinates, &step));
            let factor = from_columns(&columns(&root).map(of).collect::<Vec<_>>());
            Ok(Uncertain { innovation: innovation.clone(), factor, focus })
        }
        Focus::Simulation => {
            let none = Neighbours::default();
            uncertain_simulation(innovation, (x0s, data), (x0s, data), feedthrough, false, none)
        }
    }
}

/// As [`uncertain`] of the simulation focus: initial states and data whose simulation errors, and
/// with K whose prediction errors, were made small. With `offset` constants on the outputs were
/// estimated along.
pub(crate) fn uncertain_simulation(
    innovation: &Innovation,
    simulated: (&[Vec<f64>], &DataSet),
    predicted: (&[Vec<f64>], &DataSet),
    feedthrough: bool,
    offset: bool,
    neighbours: Neighbours<'_>,
) -> Result<Uncertain, Error> {
    let focus = Focus::Simulation;
    let local =
        Local::new(&innovation.model, simulated.0, simulated.1, feedthrough, focus, offset)?;
    let mut root = local.of_coordinates(local.sandwich(simulated.1)?);
    if neighbours.replicas.len() > root.nrows() {
        let replicas: Vec<&StateSpace> = neighbours.replicas.iter().collect();
        let deviations = steps(&local.coordinates, &replicas, neighbours.omegas)?;
        root = larger(&root, &deviations)?;
    }
    let moves: Vec<Move> = columns(&root).map(|step| back(&local.coordinates, &step)).collect();
    let mut factor = with_gain(innovation, predicted.0, predicted.1, feedthrough, &moves)?;
    if !neighbours.rivals.is_empty() {
        let rivals = local.rivals(&innovation.model, neighbours)?;
        let all = hcat(&[factor.as_ref(), rivals.as_ref()]);
        factor = r_factor(all.transpose()).transpose().to_owned();
    }
    Ok(Uncertain { innovation: innovation.clone(), factor, focus })
}

fn predictor_of(innovation: &Innovation) -> StateSpace {
    predictor(&innovation.model, innovation.gain.as_ref())
}

struct Local {
    coordinates: Coordinates,
    x0s: Vec<Vec<f64>>,
    drive: Drive,
    weight: Mat<f64>,
    linear: Linearised,
    /// R, of the offsets and the coordinates.
    r: Mat<f64>,
    /// N·ny over that less the parameters.
    inflation: f64,
}

impl Local {
    fn new(
        model: &StateSpace,
        x0s: &[Vec<f64>],
        data: &DataSet,
        feedthrough: bool,
        focus: Focus,
        offset: bool,
    ) -> Result<Self, Error> {
        let drive = match focus {
            Focus::Prediction => Drive::InputsAndOutputs,
            Focus::Simulation => Drive::Inputs,
        };
        let moving = moving_inputs(data.inputs(), data.outputs(), feedthrough, drive);
        let offsets = if offset { Some(vec![0.0; data.outputs()]) } else { None };
        let point = Point { model: model.clone(), x0s: x0s.to_vec(), offsets };
        let covariance = error_covariance(&point, drive, data);
        let weight = weight(&covariance)?;
        let coordinates = Coordinates::new(model, &weight, &moving)?;
        let x0s: Vec<Vec<f64>> = x0s.iter().map(|x| times(&coordinates.basis, x)).collect();
        let offsets = point.offsets.as_deref();
        let linear = linearise(&coordinates, (&x0s, offsets), drive, data, &weight);
        let q = linear.offsets + coordinates.count();
        let r = linear.r_factor.get(..q, ..q).to_owned();
        let values = (data.samples() * data.outputs()) as f64;
        let estimated = (q + model.order() * x0s.len()) as f64;
        let inflation = values / (values - estimated).max(1.0);
        Ok(Self { coordinates, x0s, drive, weight, linear, r, inflation })
    }

    fn inverse(&self) -> Result<Mat<f64>, Error> {
        const WORST: f64 = 1e-11;
        let q = self.r.ncols();
        let sizes: Vec<f64> = (0..q).map(|j| self.r.col(j).norm_l2()).collect();
        let scaled = Mat::from_fn(q, q, |i, j| self.r[(i, j)] / sizes[j].max(1e-300));
        let singular = svd(scaled.as_ref())?.s;
        let least = singular.last().copied().unwrap_or(1.0);
        if !least.is_finite() || least <= WORST * singular.first().copied().unwrap_or(1.0) {
            return Err(Error::no_model("the data do not determine all parameters of the model"));
        }
        let inverse = inverse(scaled.as_ref());
        let root = self.inflation.sqrt();
        Ok(Mat::from_fn(q, q, |i, j| root * inverse[(i, j)] / sizes[i]))
    }

    /// The root of the covariance of coloured errors: R⁻¹ R⁻ᵀ R̄ᵀ, R̄ of the filtered derivatives.
    fn sandwich(&self, data: &DataSet) -> Result<Mat<f64>, Error> {
        let model = &self.coordinates.model;
        let (n, p, q) = (model.order(), model.outputs(), self.r.ncols());
        let mut products = Autocovariance::new(p, data.samples());
        for (segment, x0) in data.segments().iter().zip(&self.x0s) {
            products.break_off();
            each_error(model, self.drive, segment, x0, |_, e| {
                let mut e = e.to_vec();
                weigh(&self.weight, &mut e);
                products.push(&e);
            });
        }
        let noise = products.reversed()?;
        let offsets = vec![0.0; self.linear.offsets];
        let offsets = if offsets.is_empty() { None } else { Some(offsets.as_slice()) };
        let width = n + q + 1;
        let mut rows = vec![0.0; p * width];
        let mut psi = vec![0.0; p * q];
        let mut filtered = RFactor::new(q);
        for ((segment, x0), head) in data.segments().iter().zip(&self.x0s).zip(&self.linear.heads) {
            let through_x0 = least_squares(head.get(.., ..n), head.get(.., n..n + q), 1e-12)?;
            let mut sensitivities =
                Sensitivities::new(&self.coordinates, self.drive, segment, x0, offsets);
            let mut filter = noise.filter(q)?;
            for t in 0..segment.len() {
                let free = sensitivities.free;
                sensitivities.sample(t, &mut rows);
                weigh(&self.weight, &mut rows);
                for (row, psi) in rows.chunks_exact(width).zip(psi.chunks_exact_mut(q)) {
                    psi.copy_from_slice(&row[n..n + q]);
                    for k in (0..n).filter(|_| free) {
                        for (j, psi) in psi.iter_mut().enumerate() {
                            *psi -= row[k] * through_x0[(k, j)];
                        }
                    }
                }
                filter.push(&psi, |row| filtered.push(row));
            }
            psi.fill(0.0);
            for _ in 0..filter.tail() {
                filter.push(&psi, |row| filtered.push(row));
            }
        }
        let inverse = self.inverse()?;
        let root = &inverse * (inverse.transpose() * filtered.finish().transpose());
        // R⁻¹ occurs twice and carries the inflation each time; once is due.
        let once = self.inflation.sqrt().recip();
        Ok(Mat::from_fn(q, q, |i, j| once * root[(i, j)]))
    }

    /// Moves of the entries towards the rivals, times the roots of their weights; D moves too.
    fn rivals(&self, model: &StateSpace, of: Neighbours<'_>) -> Result<Mat<f64>, Error> {
        let all = vec![true; model.inputs()];
        let coordinates = Coordinates::new(model, &self.weight, &all)?;
        let models: Vec<&StateSpace> = of.rivals.iter().map(|(_, model)| model).collect();
        let steps = steps(&coordinates, &models, of.omegas)?;
        let still = Mat::zeros(model.order(), model.outputs());
        let moves: Vec<Vec<f64>> = columns(&steps)
            .zip(of.rivals)
            .map(|(step, (weight, _))| {
                let step: Vec<f64> = step.iter().map(|x| weight.sqrt() * x).collect();
                entries(&back(&coordinates, &step), &still)
            })
            .collect();
        Ok(from_columns(&moves))
    }

    /// The root of the coordinates' covariance, of that with the offsets.
    fn of_coordinates(&self, root: Mat<f64>) -> Mat<f64> {
        if self.linear.offsets == 0 {
            return root;
        }
        r_factor(root.get(self.linear.offsets.., ..).transpose()).transpose().to_owned()
    }
}

/// The move along `step` in the basis of the model that the coordinates were made of.
fn back(coordinates: &Coordinates, step: &[f64]) -> Move {
    in_basis(&coordinates.direction(step), inverse(coordinates.basis.as_ref()).as_ref())
}

fn with_gain(
    innovation: &Innovation,
    x0s: &[Vec<f64>],
    data: &DataSet,
    feedthrough: bool,
    moves: &[Move],
) -> Result<Mat<f64>, Error> {
    let (n, p) = (innovation.model.order(), innovation.model.outputs());
    let still = Mat::zeros(n, p);
    if innovation.gain.norm_max() == 0.0 {
        let all: Vec<_> = moves.iter().map(|delta| entries(delta, &still)).collect();
        return Ok(from_columns(&all));
    }
    let predictor = predictor_of(innovation);
    let local = Local::new(&predictor, x0s, data, feedthrough, Focus::Prediction, false)?;
    // What moves the predictor: its local coordinates, and for nothing changes of basis.
    let q = local.r.ncols();
    let unit = |k: usize| (0..q).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    let local_moves = (0..q).map(|k| back(&local.coordinates, &unit(k)));
    let changes = (0..n * n).map(|e| change_of_basis(&predictor, e / n, e % n));
    let spanning = from_columns(&local_moves.chain(changes).map(|m| flat(&m)).collect::<Vec<_>>());
    let unit_gain = |k: usize| Mat::from_fn(n, p, |i, j| f64::from(u8::from(i * p + j == k)));
    let nothing = Move {
        a: Mat::zeros(n, n),
        b: Mat::zeros(n, innovation.model.inputs()),
        c: Mat::zeros(p, n),
        d: Mat::zeros(p, innovation.model.inputs()),
    };
    let by_model: Vec<Vec<f64>> =
        moves.iter().map(|m| flat(&of_predictor(innovation, m, &still))).collect();
    let by_gain: Vec<Vec<f64>> =
        (0..n * p).map(|k| flat(&of_predictor(innovation, &nothing, &unit_gain(k)))).collect();
    let wanted = hcat(&[from_columns(&by_model).as_ref(), from_columns(&by_gain).as_ref()]);
    // The equations are consistent and as many as the unknowns, or fewer columns of D may move.
    let found = least_squares(spanning.as_ref(), wanted.as_ref(), 1e-13)?;
    let seen = &local.r * found.get(..q, ..);
    let (model_seen, gain_seen) = (seen.get(.., ..moves.len()), seen.get(.., moves.len()..));
    let follows = least_squares(gain_seen, model_seen, 1e-12)?;
    let own = r_factor(gain_seen);
    let own = solve(own.as_ref(), Mat::<f64>::identity(n * p, n * p).as_ref());
    let root = local.inflation.sqrt();
    let mut all = Vec::new();
    for (k, delta) in moves.iter().enumerate() {
        let gain = Mat::from_fn(n, p, |i, j| -follows[(i * p + j, k)]);
        all.push(entries(delta, &gain));
    }
    for k in 0..n * p {
        let gain = Mat::from_fn(n, p, |i, j| root * own[(i * p + j, k)]);
        all.push(entries(&nothing, &gain));
    }
    let factor = from_columns(&all);
    if is_finite(factor.as_ref()) {
        Ok(factor)
    } else {
        Err(Error::no_model("the data do not determine the Kalman gain"))
    }
}

/// The move of the predictor (A − KC, (B − KD, K), C, (D, 0)).
fn of_predictor(innovation: &Innovation, delta: &Move, gain: &Mat<f64>) -> Move {
    let (model, k) = (&innovation.model, &innovation.gain);
    let b = &delta.b - gain * &model.d - k * &delta.d;
    Move {
        a: &delta.a - gain * &model.c - k * &delta.c,
        b: hcat(&[b.as_ref(), gain.as_ref()]),
        c: delta.c.clone(),
        d: hcat(&[delta.d.as_ref(), Mat::zeros(k.ncols(), k.ncols()).as_ref()]),
    }
}

/// The entries of the innovation form's move that a move of its predictor is.
fn of_innovation(innovation: &Innovation, delta: &Move) -> Vec<f64> {
    let (model, k) = (&innovation.model, &innovation.gain);
    let m = model.inputs();
    let gain = delta.b.get(.., m..).to_owned();
    let d = delta.d.get(.., ..m).to_owned();
    let moved = Move {
        a: &delta.a + &gain * &model.c + k * &delta.c,
        b: delta.b.get(.., ..m) + &gain * &model.d + k * &d,
        c: delta.c.clone(),
        d,
    };
    entries(&moved, &gain)
}

/// The move under x → (I + ε e_row e_colᵀ)x.
fn change_of_basis(model: &StateSpace, row: usize, col: usize) -> Move {
    let n = model.order();
    let e = Mat::from_fn(n, n, |i, j| f64::from(u8::from((i, j) == (row, col))));
    Move {
        a: &e * &model.a - &model.a * &e,
        b: &e * &model.b,
        c: Mat::from_fn(model.outputs(), n, |i, j| -(&model.c * &e)[(i, j)]),
        d: Mat::zeros(model.outputs(), model.inputs()),
    }
}

fn flat(delta: &Move) -> Vec<f64> {
    [&delta.a, &delta.b, &delta.c, &delta.d]
        .into_iter()
        .flat_map(|m| dense::rows(m.as_ref()))
        .collect()
}

fn entries(delta: &Move, gain: &Mat<f64>) -> Vec<f64> {
    let mut all = flat(delta);
    all.extend(dense::rows(gain.as_ref()));
    all
}

fn columns(m: &Mat<f64>) -> impl Iterator<Item = Vec<f64>> + '_ {
    (0..m.ncols()).map(|j| m.col(j).iter().copied().collect())
}

fn from_columns(columns: &[Vec<f64>]) -> Mat<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    Mat::from_fn(rows, columns.len(), |i, j| columns[j][i])
}
