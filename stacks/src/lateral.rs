//! What stacks know of a vehicle: delay, lag and effective wheelbase, reduced from a model.
//!
//! The model's response G(s) from road-wheel angle to yaw rate is represented by `v/L · exp(−d·s)/(1 + τ·s)`: the
//! kinematic bicycle behind a steering with a delay and a lag. L = v/G(0) is the effective wheelbase, which
//! contains understeer at that speed. Delay and lag are those whose impulse response has the mean and the variance of
//! the model's: `ln G(s) = ln G(0) − (d + τ)·s + τ²·s²/2 − …`, the method of moments. They are thus the same whether
//! the model has a pure delay or represents it by lags.

use crate::Error;
use serde::Serialize;
use steerwright_formats::{
    Bicycle, Discrete, Estimated, InputKind, Matrix, Plant, Quality, VehicleData,
};

/// A number with its standard error, if there is one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantity {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation; absent if it was stated or not estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
}

impl Quantity {
    /// A number without a standard error.
    #[must_use]
    pub fn stated(value: f64) -> Self {
        Self { value, standard_error: None }
    }

    /// Both times a constant.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            standard_error: self.standard_error.map(|error| error * factor.abs()),
        }
    }
}

/// A pure delay and a first-order lag, of steering and vehicle together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Pure delay, s.
    pub delay_s: Quantity,
    /// Time constant of the first-order lag, s.
    pub lag_s: Quantity,
    /// Their sum, which is better known than each, s.
    pub total_s: Quantity,
}

impl Timing {
    /// From `[delay, lag, total]` and their standard errors.
    fn new([delay, lag, total]: [f64; 3], errors: Option<[f64; 3]>) -> Self {
        let [d, l, t] = errors.map_or([None; 3], |e| e.map(Some));
        let quantity = |value, standard_error| Quantity { value, standard_error };
        Self { delay_s: quantity(delay, d), lag_s: quantity(lag, l), total_s: quantity(total, t) }
    }
}

/// Delay, lag and their sum, s, of an impulse response with this mean in s and this variance in s²; `None` if the
/// mean is not positive. A response of a greater variance has no delay, one of none (an underdamped one) no lag.
fn delay_and_lag(mean: f64, variance: f64) -> Option<[f64; 3]> {
    let lag = variance.max(0.0).sqrt().min(mean);
    if mean.is_finite() && lag.is_finite() && mean > 0.0 {
        Some([mean - lag, lag, mean])
    } else {
        None
    }
}

/// The steering response of a vehicle at one speed, at the road wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct Lateral {
    /// The model's name.
    pub name: String,
    /// The speed of the response, m/s.
    pub speed_mps: f64,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: Quantity,
    /// Delay and lag; `None` if the response leads.
    pub timing: Option<Timing>,
    /// Speed times road-wheel angle over yaw rate in a steady turn, m.
    pub effective_wheelbase_m: Quantity,
    /// Road-wheel angle that drives straight, rad; `None` without a drive.
    pub steering_offset_rad: Option<Quantity>,
    /// Wheelbase, m; `None` if only one speed was driven.
    pub wheelbase_m: Option<Quantity>,
    /// Largest rate of the road wheels, rad/s; `None` if the drive does not show it.
    pub largest_rate_radps: Option<Quantity>,
    /// Fastest steering of the drive, rad/s at the road wheel.
    pub driven_rate_radps: Option<f64>,
    /// The vehicle's data; `None` if only one speed was driven.
    pub vehicle: Option<VehicleData>,
    /// The model's quality.
    pub quality: Quality,
}

impl Lateral {
    /// From an identified plant.
    ///
    /// # Errors
    /// A plant without speed or without a positive steady-state gain.
    pub fn of_plant(plant: &Plant) -> Result<Self, Error> {
        let speed = plant.operating_point.speed_mps;
        if speed <= 0.0 {
            return Err(Error::Speed);
        }
        let to_road_wheel = match plant.input {
            InputKind::Steering => plant.steering_ratio,
            InputKind::SteeringTimesSpeed => plant.steering_ratio * speed,
        };
        let delay = plant.input_delay_s;
        let turn_and_timing = |d: &Discrete| {
            let [gain, mean, variance] = moments(d)?;
            let [delay, lag, total] = delay_and_lag(delay + mean, variance)?;
            Some([speed / (gain * to_road_wheel), delay, lag, total])
        };
        let [gain, ..] = moments(&plant.discrete).ok_or(Error::Gain { gain: f64::NAN })?;
        let wheelbase = speed / (gain * to_road_wheel);
        if wheelbase.is_nan() || wheelbase <= 0.0 {
            return Err(Error::Gain { gain });
        }
        let errors = spread(plant.ensemble_dimension(), |xi| {
            turn_and_timing(&plant.ensemble_member(xi)?.discrete)
        });
        // A first-order model has no freedom to correct its delay.
        let fixed = delay > 0.0 && plant.order() == 1;
        let delay_error = plant.evidence.delay.filter(|d| d.taken).and_then(|d| d.standard_error_s);
        let timing = turn_and_timing(&plant.discrete).map(|[_, delay, lag, total]| {
            let errors = errors.and_then(|[_, d, l, t]| {
                let more = if fixed { delay_error? } else { 0.0 };
                Some([d.hypot(more), l.hypot(more), t])
            });
            Timing::new([delay, lag, total], errors)
        });
        let ratio = plant.steering_ratio;
        Ok(Self {
            name: plant.name.clone(),
            speed_mps: speed,
            steering_ratio: Quantity::stated(ratio),
            timing,
            effective_wheelbase_m: Quantity {
                value: wheelbase,
                standard_error: errors.map(|e| e[0]),
            },
            steering_offset_rad: Some(Quantity::stated(
                plant.operating_point.steering_offset_rad / ratio,
            )),
            wheelbase_m: None,
            largest_rate_radps: None,
            driven_rate_radps: plant
                .evidence
                .excitation
                .largest_steering_rate_radps
                .map(|rate| rate / ratio),
            vehicle: None,
            quality: plant.quality.clone(),
        })
    }

    /// From a bicycle, at the speed of its file.
    ///
    /// # Errors
    /// A bicycle without a positive steady-state gain (beyond its critical speed).
    pub fn of_bicycle(bicycle: &Bicycle) -> Result<Self, Error> {
        let vehicle = &bicycle.vehicle;
        let evidence = bicycle.evidence.as_ref();
        let [effective, ..] = turn(vehicle);
        if effective.is_nan() || effective <= 0.0 {
            return Err(Error::Gain { gain: vehicle.speed_mps / effective });
        }
        // In a file without a delay, the actuator's lag represents it too: the mean is that of the file, the variance
        // that of the model with a delay.
        let delayed = evidence.map(|e| e.with_delay).filter(|d| {
            vehicle.actuator_delay_s == 0.0 && d.input_delay_s > 2.0 * d.standard_error_s
        });
        let values = |v: &VehicleData| {
            let [effective, mean, variance] = turn(v);
            let actuator = v.actuator_time_constant_s;
            let lag = delayed.map_or(actuator, |d| d.actuator_time_constant_s);
            let mean = mean + actuator + v.actuator_delay_s;
            let [delay, lag, total] = delay_and_lag(mean, variance + lag * lag)?;
            let wheelbase = v.distance_front_m + v.distance_rear_m;
            Some([effective, wheelbase, v.steering_ratio, delay, lag, total])
        };
        let errors =
            spread(bicycle.ensemble_dimension(), |xi| values(&bicycle.ensemble_member(xi)?));
        // The spread of the file's vehicle does not contain that of the delay.
        let delay_error = delayed.map_or(0.0, |d| d.standard_error_s);
        let timing = values(vehicle).map(|[.., delay, lag, total]| {
            let errors =
                errors.map(|[.., d, l, t]| [d.hypot(delay_error), l.hypot(delay_error), t]);
            Timing::new([delay, lag, total], errors)
        });
        let [effective_error, wheelbase_error, ratio_error] = errors
            .map_or([None; 3], |[e, w, r, ..]| {
                [e, w, r].map(|e| if e > 0.0 { Some(e) } else { None })
            });
        let (one_speed, stated) = evidence.map_or((false, false), |e| {
            (e.speed.is_one_speed(), e.stated.iter().any(|s| s.name == "wheelbase_m"))
        });
        let offset = evidence.map(|e| Quantity {
            value: e.steering_offset_rad / vehicle.steering_ratio,
            standard_error: named(&e.identified, "steering_offset_road_wheel"),
        });
        Ok(Self {
            name: vehicle.name.clone(),
            speed_mps: vehicle.speed_mps,
            steering_ratio: Quantity { value: vehicle.steering_ratio, standard_error: ratio_error },
            timing,
            effective_wheelbase_m: Quantity { value: effective, standard_error: effective_error },
            steering_offset_rad: offset,
            // At one speed, understeer and a longer wheelbase are the same.
            wheelbase_m: if !one_speed || stated {
                Some(Quantity {
                    value: vehicle.distance_front_m + vehicle.distance_rear_m,
                    standard_error: wheelbase_error,
                })
            } else {
                None
            },
            largest_rate_radps: bicycle
                .largest_rate()
                .map(|(value, standard_error)| Quantity { value, standard_error }),
            driven_rate_radps: evidence
                .and_then(|e| e.largest_steering_rate_radps)
                .map(|rate| rate / vehicle.steering_ratio),
            vehicle: if one_speed { None } else { Some(vehicle.clone()) },
            quality: bicycle.quality.clone(),
        })
    }
}

fn named(identified: &[Estimated], name: &str) -> Option<f64> {
    identified.iter().find(|q| q.name == name).map(|q| q.standard_error)
}

/// Standard errors of functions of an ensemble, to first order: the root of the sum of squares of half the
/// differences for ξ = ±1 along each axis. `None` without uncertainty, or if a member does not exist.
fn spread<const N: usize>(
    dimension: usize,
    values: impl Fn(&[f64]) -> Option<[f64; N]>,
) -> Option<[f64; N]> {
    /// Of a standard deviation: the member exists and the function is linear over the step.
    const STEP: f64 = 0.1;
    if dimension == 0 {
        return None;
    }
    let mut sums = [0.0; N];
    let mut xi = vec![0.0; dimension];
    for axis in 0..dimension {
        let mut at = |step: f64| {
            xi[axis] = step;
            let values = values(&xi);
            xi[axis] = 0.0;
            values
        };
        let (up, down) = (at(STEP)?, at(-STEP)?);
        for (sum, (up, down)) in sums.iter_mut().zip(up.iter().zip(down)) {
            *sum += ((up - down) / (2.0 * STEP)).powi(2);
        }
    }
    Some(sums.map(f64::sqrt))
}

/// Effective wheelbase of a vehicle in m, and mean in s and variance in s² of the impulse response of its yaw rate,
/// all of the two states (v_y, r) of eq 13 without the actuator.
fn turn(v: &VehicleData) -> [f64; 3] {
    let (u, coefficients) = (v.speed_mps, v.coefficients());
    let [a, b, c, d] = coefficients.lateral(u);
    let solve = |[p, q]: [f64; 2]| {
        let determinant = a * d - b * c;
        [(d * p - b * q) / determinant, (a * q - c * p) / determinant]
    };
    // G(s) = −Σ s^k·H F^(−k−1) G.
    let once = solve([coefficients.b1, coefficients.b2]);
    let twice = solve(once);
    let thrice = solve(twice);
    let (mean, second) = (-twice[1] / once[1], 2.0 * thrice[1] / once[1]);
    [u / -once[1], mean, second - mean * mean]
}

/// Steady-state gain G(0), and mean in s and variance in s² of the impulse response, of a discrete model with its
/// input held, without the delay; `None` for a pole at 1.
///
/// With θ = s·T and z = exp(θ), `−dG/dθ/G` and `d²G/dθ²/G − (dG/dθ/G)²` at 0 are mean and variance in samples; the
/// hold has 1/2 and 1/12 of them.
fn moments(d: &Discrete) -> Option<[f64; 3]> {
    let n = d.a.rows();
    let column =
        |m: &Matrix| m.0.iter().map(|row| row.first().copied()).collect::<Option<Vec<_>>>();
    let once = solved(&d.a, column(&d.b)?)?;
    let twice = solved(&d.a, once.clone())?;
    let thrice = solved(&d.a, twice.clone())?;
    let row = d.c.0.first().filter(|row| row.len() == n)?;
    let output = |x: &[f64]| row.iter().zip(x).map(|(c, x)| c * x).sum::<f64>();
    let gain = output(&once) + d.d.0.first()?.first()?;
    let (first, second) = (-output(&twice) / gain, 2.0 * output(&thrice) / gain);
    let (mean, variance) = (-first, second + first - first * first);
    let t = d.sample_time_s;
    let moments = [gain, t * (mean - 0.5), t * t * (variance - 1.0 / 12.0)];
    if gain != 0.0 && moments.iter().all(|x| x.is_finite()) { Some(moments) } else { None }
}

/// (I − A)x = b by elimination with row pivots.
fn solved(a: &Matrix, b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    if a.rows() != n || a.columns() != Some(n) {
        return None;
    }
    // The rows of (I − A | b).
    let row = |(i, (row, b)): (usize, (&Vec<f64>, f64))| {
        let mut row: Vec<f64> = row.iter().map(|x| -x).chain([b]).collect();
        row[i] += 1.0;
        row
    };
    let mut m: Vec<Vec<f64>> = a.0.iter().zip(b).enumerate().map(row).collect();
    for i in 0..n {
        let pivot = (i..n).max_by(|p, q| m[*p][i].abs().total_cmp(&m[*q][i].abs()))?;
        m.swap(i, pivot);
        let pivot = m[i].clone();
        if pivot[i].abs() < 1e-12 {
            return None;
        }
        for (_, row) in m.iter_mut().enumerate().filter(|(k, _)| *k != i) {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(&pivot).skip(i).for_each(|(x, p)| *x -= factor * p);
        }
    }
    Some(m.iter().enumerate().map(|(i, row)| row[n] / row[i]).collect())
}

#[cfg(test)]
mod tests {
    use super::{delay_and_lag, moments, turn};
    use steerwright_formats::{Discrete, Matrix, VehicleData};

    #[test]
    fn lag_and_gain_of_a_first_order_lag_are_its_own() {
        let (t, tau, gain) = (0.02_f64, 0.3, 4.0);
        let a = (-t / tau).exp();
        let one = |x: f64| Matrix(vec![vec![x]]);
        let (b, k) = (one(gain * (1.0 - a)), one(0.0));
        let model =
            Discrete { sample_time_s: t, a: one(a), b, c: one(1.0), d: one(0.0), k, x0: vec![0.0] };
        let [found, mean, variance] = moments(&model).unwrap();
        assert!((found - gain).abs() < 1e-12, "{found}");
        let [delay, lag, total] = delay_and_lag(0.1 + mean, variance).unwrap();
        assert!((delay - 0.1).abs() < 3e-4 && (lag - tau).abs() < 3e-4, "{delay} {lag}");
        assert!((total - delay - lag).abs() < 1e-12, "{total}");
        // An integrator has no gain.
        assert_eq!(moments(&Discrete { a: one(1.0), ..model }), None);
    }

    #[test]
    fn turn_of_a_vehicle_is_that_of_its_understeer_gradient_and_step_response() {
        let v = VehicleData {
            name: "car".into(),
            mass_kg: 1500.0,
            yaw_inertia_kgm2: 2500.0,
            distance_front_m: 1.2,
            distance_rear_m: 1.5,
            cornering_stiffness_front_npr: 80e3,
            cornering_stiffness_rear_npr: 90e3,
            actuator_time_constant_s: 0.1,
            steering_ratio: 15.0,
            speed_mps: 15.0,
            ..VehicleData::default()
        };
        let [effective, mean, variance] = turn(&v);
        let gradient = 1500.0 / 2.7 * (1.5 / 80e3 - 1.2 / 90e3);
        assert!((effective - (2.7 + gradient * 225.0)).abs() < 1e-9, "{effective}");
        // The step response of (v_y, r), by small Euler steps.
        let (h, mut y, mut r) = (1e-5, 0.0_f64, 0.0_f64);
        let (mut area, mut second) = (0.0, 0.0);
        for k in 0..400_000 {
            let rest = 1.0 - r * effective / 15.0;
            area += h * rest;
            second += 2.0 * h * f64::from(k) * h * rest;
            let (front, rear) = (80e3 * (1.0 - (y + 1.2 * r) / 15.0), -90e3 * (y - 1.5 * r) / 15.0);
            (y, r) = (
                y + h * ((front + rear) / 1500.0 - 15.0 * r),
                r + h * (1.2 * front - 1.5 * rear) / 2500.0,
            );
        }
        assert!((mean - area).abs() < 1e-4, "{mean} {area}");
        let expected = second - area * area;
        assert!((variance - expected).abs() < 1e-4, "{variance} {expected}");
    }
}
