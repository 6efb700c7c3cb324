//! The Kalman gain of a fixed model by its one-step prediction errors.

use crate::Error;
use crate::data::DataSet;
use crate::linalg::columns::Columns;
use crate::linalg::dense::spectral_radius;
use crate::linalg::levenberg_marquardt::{USUAL, by_more_than, lower};
use crate::linalg::r_factor::RFactor;
use crate::model::{StateSpace, predictor};
use crate::pem::rows::Drive;
use crate::pem::search::{
    Point, Stop, criterion, damped_step, each_error, error_covariance, weigh, weight,
};
use faer::{Mat, MatRef};

/// Refines the Kalman gain `k` of a fixed model by its one-step prediction errors from the states
/// `x0`; A − K C stays stable. `∂ŷ/∂K_kj` is state k of `w⁺ = (A − K C)ᵀ w + c_iᵀ e_j` for output
/// i.
///
/// # Errors
/// [`Error::Numerical`] where a decomposition does not converge.
pub fn refine_gain(
    model: &StateSpace,
    k: MatRef<'_, f64>,
    data: &DataSet,
    x0: &[Vec<f64>],
    stop: Stop,
) -> Result<Mat<f64>, Error> {
    const LARGEST_RADIUS: f64 = 0.9999;
    let (n, p) = (model.order(), model.outputs());
    let covariance_of = |gain: &Mat<f64>| {
        let point =
            Point { model: predictor(model, gain.as_ref()), x0s: x0.to_vec(), offsets: None };
        error_covariance(&point, Drive::InputsAndOutputs, data)
    };
    let covariance = covariance_of(&k.to_owned());
    let cost = criterion(&covariance);
    let reached = lower::<_, _, Error>(
        ((k.to_owned(), covariance), cost),
        stop.steps,
        USUAL,
        by_more_than(stop.least_gain),
        |(gain, covariance), _| {
            Ok(Some(gain_r_factor(model, gain, data, x0, &weight(covariance)?)))
        },
        |(gain, _), r, damping| {
            let step = damped_step(r.get(..n * p, ..n * p), r.get(..n * p, n * p..), damping, 0)?;
            let trial = Mat::from_fn(n, p, |s, j| gain[(s, j)] + step[s * p + j]);
            if spectral_radius((&model.a - &trial * &model.c).as_ref()) < LARGEST_RADIUS {
                let covariance = covariance_of(&trial);
                let cost = criterion(&covariance);
                return Ok(Some(((trial, covariance), cost)));
            }
            Ok(None)
        },
    )?;
    Ok(reached.point.0)
}

/// R of the weighted derivatives by K row by row, and last the errors' column.
fn gain_r_factor(
    model: &StateSpace,
    gain: &Mat<f64>,
    data: &DataSet,
    x0: &[Vec<f64>],
    weight: &Mat<f64>,
) -> Mat<f64> {
    let (n, p) = (model.order(), model.outputs());
    let width = n * p + 1;
    let predictor = predictor(model, gain.as_ref());
    let closed = Columns::new(predictor.a.transpose());
    let mut all = RFactor::new(width);
    let mut next = vec![0.0; n];
    let mut block = vec![0.0; p * width];
    for (segment, x0) in data.segments().iter().zip(x0) {
        // States of (output i, innovation j), n each.
        let mut w = vec![0.0; p * p * n];
        each_error(&predictor, Drive::InputsAndOutputs, segment, x0, |_, e| {
            for i in 0..p {
                for j in 0..p {
                    let states = &mut w[(i * p + j) * n..(i * p + j + 1) * n];
                    closed.product(states, &mut next);
                    for (s, o) in next.iter_mut().enumerate() {
                        block[i * width + s * p + j] = states[s];
                        *o += model.c[(i, s)] * e[j];
                    }
                    states.copy_from_slice(&next);
                }
                block[i * width + n * p] = e[i];
            }
            weigh(weight, &mut block);
            for row in block.chunks_exact(width) {
                all.push(row);
            }
        });
    }
    all.finish()
}
