//! The limits of a manoeuvre, and how much of them a steering signal uses: of the vehicle of the model, and of the vehicles
//! within its uncertainty.

use super::motion::Motion;
use steerwright_formats::{ManoeuvreLimits, NORMAL_95, VehicleData, VehicleDirection};

/// Limited quantities: lateral acceleration, lateral offset, steering angle, steering rate.
pub(super) const QUANTITIES: usize = 4;

/// The largest absolute values of a signal, and the bounds that they keep with a probability of 97.5 % each.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Peaks {
    pub(super) nominal: [f64; QUANTITIES],
    pub(super) upper: [f64; QUANTITIES],
    /// Lateral offset at the end, m.
    pub(super) end_offset_m: f64,
}

/// A vehicle at a speed, with its uncertainty.
pub(super) struct Mover {
    sample_time_s: f64,
    nominal: Motion,
    displaced: Vec<Motion>,
}

/// The limits of the [`QUANTITIES`]; infinite where not limited.
pub(super) fn limit_values(limits: &ManoeuvreLimits) -> [f64; QUANTITIES] {
    let optional = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
    [
        limits.max_lateral_acceleration_mps2,
        optional(limits.max_offset_m),
        optional(limits.max_angle_rad),
        optional(limits.max_rate_radps),
    ]
}

fn largest(signal: &[f64]) -> f64 {
    signal.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

/// Rates between the samples of a signal, one for each sample; the first from 0.
pub(super) fn rates(signal: &[f64], sample_time_s: f64) -> Vec<f64> {
    let mut before = 0.0;
    let mut rates = Vec::with_capacity(signal.len());
    for value in signal {
        rates.push((value - before) / sample_time_s);
        before = *value;
    }
    rates
}

impl Mover {
    pub(super) fn new(
        vehicle: &VehicleData,
        directions: &[VehicleDirection],
        speed_mps: f64,
        sample_time_s: f64,
    ) -> Self {
        let motion = |vehicle: &VehicleData| Motion::new(vehicle, speed_mps, sample_time_s);
        let displaced = directions.iter().map(|d| motion(&vehicle.displaced(d, 1.0))).collect();
        Self { sample_time_s, nominal: motion(vehicle), displaced }
    }

    /// The limited quantities at the samples of a steering signal, rad.
    pub(super) fn quantities(&self, steering_rad: &[f64]) -> [Vec<f64>; QUANTITIES] {
        let moved = self.nominal.steered(steering_rad);
        [
            moved.lateral_acceleration,
            moved.lateral_offset,
            steering_rad.to_vec(),
            rates(steering_rad, self.sample_time_s),
        ]
    }

    pub(super) fn peaks(&self, steering_rad: &[f64]) -> Peaks {
        let quantities = self.quantities(steering_rad);
        let nominal: [f64; QUANTITIES] = std::array::from_fn(|i| largest(&quantities[i]));
        let mut squares = [0.0; QUANTITIES];
        for motion in &self.displaced {
            let moved = motion.steered(steering_rad);
            squares[0] += (largest(&moved.lateral_acceleration) - nominal[0]).powi(2);
            squares[1] += (largest(&moved.lateral_offset) - nominal[1]).powi(2);
        }
        let upper = std::array::from_fn(|i| nominal[i] + NORMAL_95 * squares[i].sqrt());
        let end_offset_m = quantities[1].last().copied().unwrap_or(0.0);
        Peaks { nominal, upper, end_offset_m }
    }

    /// The factor by which a signal may be multiplied to use its limits to the full.
    pub(super) fn factor(&self, steering_rad: &[f64], limits: &ManoeuvreLimits) -> f64 {
        let peaks = self.peaks(steering_rad);
        let ratios =
            limit_values(limits).into_iter().zip(peaks.upper).map(|(limit, peak)| limit / peak);
        ratios.fold(f64::INFINITY, f64::min)
    }
}
