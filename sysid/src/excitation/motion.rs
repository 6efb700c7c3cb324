//! The motion of a bicycle in gentle driving under a steering signal: `d/dt (v_y, r, δ, ψ, y)` of eq 13 in the body frame with
//! the actuator's lag, the steering held over each sample, for small yaw angles ψ: `ẏ = v·ψ + v_y`.
//!
//! The delay moves the motion in time alone and is left out.

use crate::model::conversion::exponential;
use faer::Mat;
use steerwright_formats::VehicleData;

/// States v_y, r, δ, ψ, y, and the steering angle.
const SIZE: usize = 6;
const STATES: usize = SIZE - 1;

/// The transition over a sample at a speed.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    step: [[f64; SIZE]; STATES],
    /// Lateral acceleration of v_y, r and δ.
    acceleration: [f64; 3],
}

/// What a vehicle does at the samples of a steering signal.
#[derive(Debug, Clone, Default)]
pub(super) struct Moved {
    /// Of the centre of gravity, m/s².
    pub(super) lateral_acceleration: Vec<f64>,
    /// Of the centre of gravity from the line that it drove along before, m.
    pub(super) lateral_offset: Vec<f64>,
}

impl Motion {
    pub(super) fn new(vehicle: &VehicleData, speed_mps: f64, sample_time_s: f64) -> Self {
        let c = vehicle.coefficients();
        let [a, b, d, e] = c.lateral(speed_mps);
        #[rustfmt::skip]
        let rates: [[f64; SIZE]; STATES] = [
            [a,   b,   c.b1,        0.0,       0.0, 0.0],
            [d,   e,   c.b2,        0.0,       0.0, 0.0],
            [0.0, 0.0, -1.0 / c.tn, 0.0,       0.0, c.n / c.tn],
            [0.0, 1.0, 0.0,         0.0,       0.0, 0.0],
            [1.0, 0.0, 0.0,         speed_mps, 0.0, 0.0],
        ];
        let rates =
            Mat::from_fn(
                SIZE,
                SIZE,
                |i, j| {
                    if i < STATES { sample_time_s * rates[i][j] } else { 0.0 }
                },
            );
        let step = exponential(rates.as_ref());
        Self {
            step: std::array::from_fn(|i| std::array::from_fn(|j| step[(i, j)])),
            acceleration: [a, b + speed_mps, c.b1],
        }
    }

    /// From straight driving, with the angle in steering coordinates, rad.
    pub(super) fn steered(&self, steering_rad: &[f64]) -> Moved {
        let mut moved = Moved::default();
        let mut x = [0.0; SIZE];
        for angle in steering_rad {
            let [v_y, yaw_rate, wheel, _, offset, _] = x;
            let [by_v_y, by_yaw_rate, by_wheel] = self.acceleration;
            let acceleration = by_v_y * v_y + by_yaw_rate * yaw_rate + by_wheel * wheel;
            moved.lateral_acceleration.push(acceleration);
            moved.lateral_offset.push(offset);
            x[STATES] = *angle;
            let mut next = x;
            for (row, value) in self.step.iter().zip(&mut next) {
                *value = row.iter().zip(&x).map(|(s, x)| s * x).sum();
            }
            x = next;
        }
        moved
    }
}
