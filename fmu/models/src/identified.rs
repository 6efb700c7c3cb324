//! The identified lateral dynamics: the content of `plant.json`, validated and made ready to step.
//!
//! Discrete innovation form (eq 3–4), steering in, yaw rate out,
//!
//! ```text
//! x(k+1) = A x(k) + B u(k) + K e(k)        u = steering − steering_offset   (times speed, by kind)
//! r(k)   = C x(k) + D u(k) + yaw_rate_offset + e(k)
//! ```
//!
//! and, where A has a real logarithm, the continuous form of eq 6–11 whose zero-order-hold samples
//! these are. The plant that moves by it is [`crate::identified_plant::IdentifiedPlant`].

use crate::Error;
use crate::error::numbers;
use crate::limits::FASTEST_RATE;
use crate::linear::{ContinuousModel, discretize};
use crate::quadrature::LONGEST_PANEL;
use crate::sideslip::Sideslip;
use nalgebra::DMatrix;
use steerwright_formats::InputKind;

/// An identified model as numbers. Matrices are row-major; the order n is that of `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedData {
    /// Sample time T of the discrete model, s.
    pub sample_time: f64,
    /// State matrix A, n·n entries, row by row.
    pub a: Vec<f64>,
    /// Input matrix B, n entries.
    pub b: Vec<f64>,
    /// Output matrix C, n entries.
    pub c: Vec<f64>,
    /// Feedthrough D.
    pub d: f64,
    /// Kalman gain K, n entries.
    pub k: Vec<f64>,
    /// The continuous form, absent where A has no real logarithm.
    pub continuous: Option<Continuous>,
    /// The input of the model.
    pub input: InputKind,
    /// Delay of the input, s.
    pub delay: f64,
    /// Steering angle of straight driving, rad.
    pub steering_offset: f64,
    /// Yaw rate at that angle, rad/s.
    pub yaw_rate_offset: f64,
    /// Speed of the identification, m/s.
    pub speed: f64,
    /// Standard deviation of the innovation e, rad/s.
    pub innovation_std: f64,
    /// The sideslip β: the lateral velocity is v·β.
    pub sideslip: Sideslip,
}

/// `ẋ = F x + G u`, `y = H x + D u` (eq 6–7), row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Continuous {
    /// State matrix F, n·n entries, row by row.
    pub f: Vec<f64>,
    /// Input matrix G, n entries.
    pub g: Vec<f64>,
    /// Output matrix H, n entries.
    pub h: Vec<f64>,
}

/// A validated model, shared by all plants that move by it.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedModel {
    data: IdentifiedData,
    continuous: Option<ContinuousModel>,
    longest_panel: f64,
}

/// How far eq 9–11 may be off, relative to the largest entry.
const CONSISTENCY: f64 = 1e-6;

impl IdentifiedModel {
    /// Checks shapes and numbers, and that the continuous form samples to the discrete one.
    ///
    /// # Errors
    /// Names the matrix or quantity that is wrong.
    pub fn new(data: IdentifiedData) -> Result<Self, Error> {
        check(&data)?;
        if let Some(c) = &data.continuous {
            check_consistency(&data, c)?;
        }
        let continuous = data.continuous.as_ref().map(|c| ContinuousModel {
            f: c.f.clone(),
            g: c.g.clone(),
            h: c.h.clone(),
            d: data.d,
            offset: data.yaw_rate_offset,
        });
        let rate = continuous.as_ref().map_or(0.0, ContinuousModel::fastest_rate);
        if rate.is_nan() || rate > FASTEST_RATE {
            return Err(Error::TooFast { rate, limit: FASTEST_RATE });
        }
        let longest_panel = if rate * LONGEST_PANEL > 1.0 { 1.0 / rate } else { LONGEST_PANEL };
        Ok(Self { data, continuous, longest_panel })
    }

    /// The numbers it was made of.
    #[must_use]
    pub fn data(&self) -> &IdentifiedData {
        &self.data
    }

    /// Order n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.data.b.len()
    }

    /// The continuous form.
    #[must_use]
    pub fn continuous(&self) -> Option<&ContinuousModel> {
        self.continuous.as_ref()
    }

    /// Longest panel of the position's quadrature, s: shorter than a time constant.
    #[must_use]
    pub fn longest_panel(&self) -> f64 {
        self.longest_panel
    }

    /// The model's input for a steering angle and a speed.
    #[inline]
    #[must_use]
    pub fn input(&self, steering_angle: f64, speed: f64) -> f64 {
        let u = steering_angle - self.data.steering_offset;
        match self.data.input {
            InputKind::Steering => u,
            InputKind::SteeringTimesSpeed => u * speed,
        }
    }

    /// Whether the model's input is the product of steering angle and speed.
    #[inline]
    #[must_use]
    pub fn input_is_product(&self) -> bool {
        self.data.input == InputKind::SteeringTimesSpeed
    }

    /// The derivative of the model's input by the steering angle, at a speed.
    #[inline]
    #[must_use]
    pub fn input_by_steering(&self, speed: f64) -> f64 {
        if self.input_is_product() { speed } else { 1.0 }
    }
}

fn check(data: &IdentifiedData) -> Result<(), Error> {
    let n = data.b.len();
    let mut vectors =
        vec![("B", &data.b, n.max(1)), ("A", &data.a, n * n), ("C", &data.c, n), ("K", &data.k, n)];
    if let Some(c) = &data.continuous {
        vectors.extend([("F", &c.f, n * n), ("G", &c.g, n), ("H", &c.h, n)]);
    }
    for (name, vector, need) in vectors {
        if vector.len() != need {
            return Err(Error::Shape { name, got: vector.len(), need });
        }
        if let Some(&value) = vector.iter().find(|v| !v.is_finite()) {
            return Err(Error::NotFinite { name, value });
        }
    }
    numbers(&[
        ("D", data.d),
        ("the sample time", data.sample_time),
        ("the input delay", data.delay),
        ("the steering offset", data.steering_offset),
        ("the yaw-rate offset", data.yaw_rate_offset),
        ("the identified speed", data.speed),
        ("the innovation's standard deviation", data.innovation_std),
        ("the sideslip per yaw rate", data.sideslip.per_yaw_rate),
        ("the sideslip per yaw acceleration", data.sideslip.per_yaw_acceleration),
        ("the sideslip's growth", data.sideslip.growth),
        ("the sideslip's reference speed", data.sideslip.reference_speed),
        ("the distance to the rear axle", data.sideslip.distance_rear),
    ])?;
    if data.sample_time <= 0.0 {
        return Err(Error::NotPositive { name: "the sample time", value: data.sample_time });
    }
    for (name, value) in [
        ("the input delay", data.delay),
        ("the identified speed", data.speed),
        ("the innovation's standard deviation", data.innovation_std),
        ("the sideslip's reference speed", data.sideslip.reference_speed),
        ("the distance to the rear axle", data.sideslip.distance_rear),
    ] {
        if value < 0.0 {
            return Err(Error::Negative { name, value });
        }
    }
    Ok(())
}

/// Eq 9–11.
fn check_consistency(data: &IdentifiedData, c: &Continuous) -> Result<(), Error> {
    let n = data.b.len();
    let (a, b) = discretize(
        &DMatrix::from_row_slice(n, n, &c.f),
        &DMatrix::from_row_slice(n, 1, &c.g),
        data.sample_time,
    )?;
    for (name, sampled, given) in [
        ("A", a, DMatrix::from_row_slice(n, n, &data.a)),
        ("B", b, DMatrix::from_row_slice(n, 1, &data.b)),
        ("C", DMatrix::from_row_slice(1, n, &c.h), DMatrix::from_row_slice(1, n, &data.c)),
    ] {
        let scale = sampled.amax().max(given.amax());
        let difference = (sampled - given).amax() / scale;
        // A NaN is refused too, but for two matrices that are zero.
        if scale > 0.0 && (difference > CONSISTENCY || difference.is_nan()) {
            return Err(Error::Inconsistent { name, difference });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A car's yaw rate at 15 m/s: two real modes and an actuator lag, in a skewed basis.
    fn car() -> IdentifiedData {
        let f = vec![-6.0, 11.0, 0.5, -9.0, -5.0, 14.0, 0.0, 0.3, -8.0];
        let g = vec![0.4, 6.0, 8.0];
        let h = vec![0.8, 1.1, -0.2];
        let (a, b) = discretize(
            &DMatrix::from_row_slice(3, 3, &f),
            &DMatrix::from_row_slice(3, 1, &g),
            0.02,
        )
        .unwrap();
        IdentifiedData {
            sample_time: 0.02,
            a: a.transpose().as_slice().to_vec(),
            b: b.as_slice().to_vec(),
            c: h.clone(),
            d: 0.0,
            k: vec![0.3, 0.15, 0.1],
            continuous: Some(Continuous { f, g, h }),
            input: InputKind::Steering,
            delay: 0.0,
            steering_offset: 0.0,
            yaw_rate_offset: 0.0,
            speed: 15.0,
            innovation_std: 0.01,
            sideslip: Sideslip::default(),
        }
    }

    #[test]
    fn bad_models_are_refused_by_name() {
        assert!(IdentifiedModel::new(car()).is_ok());
        let refused = |change: &dyn Fn(&mut IdentifiedData)| {
            let mut data = car();
            change(&mut data);
            let error = IdentifiedModel::new(data).unwrap_err();
            assert!(!error.hint().is_empty());
            error.to_string()
        };
        assert_eq!(refused(&|d| d.c.truncate(2)), "C has 2 entries, expected 3");
        assert_eq!(refused(&|d| d.b.clear()), "B has 0 entries, expected 1");
        assert!(refused(&|d| d.a[4] = f64::NAN).starts_with("A is NaN"));
        assert!(refused(&|d| d.sample_time = 0.0).contains("sample time"));
        assert!(refused(&|d| d.delay = -0.1).contains("delay"));
        assert!(refused(&|d| d.b[0] += 1e-3).contains("B differs"));
        assert!(refused(&|d| d.c[0] += 1e-3).contains("C differs"));
        assert!(refused(&|d| d.sample_time *= 1.01).contains("A differs"));
    }
}
