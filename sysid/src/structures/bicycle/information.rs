//! What a steering signal would determine of a bicycle before it is driven: the sensitivities of its yaw rate, of which the
//! information matrix is made, and the gradients of what is to be known by the delta method.
//!
//! The simulation, its derivatives, the free parameters and their priors are those of the identification, so that the
//! standard errors computed here are those that it states for errors that are white.

use crate::linalg::dual::Scalar;
use crate::structures::bicycle::parameters::{
    Combination, DELAY, FRONT, Geometry, INDEX, LAG, PARAMETERS, REAR, STEERING_FACTOR,
    STEERING_OFFSET, WHEELBASE, YAW_RATE_OFFSET, combinations, of_vehicle, priors,
};
use crate::structures::bicycle::response::response;
use crate::structures::bicycle::simulate::{SpeedSegment, sensitivities};
use steerwright_formats::VehicleData;

/// Step of central differences of the response by a parameter, a logarithm or a time in s.
const STEP: f64 = 1e-5;

/// A bicycle and the parameters that an identification would estimate.
#[derive(Debug, Clone)]
pub(crate) struct BicycleInformation {
    p: [f64; PARAMETERS],
    front_share: f64,
    /// Parameters of the dynamics, then the offsets.
    free: Vec<usize>,
    /// Number of those of the dynamics.
    dynamic: usize,
}

impl BicycleInformation {
    /// Of a vehicle in gentle driving whose steering is an angle with a known ratio; its delay is estimated where it has one.
    pub(crate) fn new(vehicle: &VehicleData) -> Self {
        let mut free = vec![FRONT, REAR, WHEELBASE, INDEX, LAG];
        if vehicle.actuator_delay_s > 0.0 {
            free.push(DELAY);
        }
        let dynamic = free.len();
        free.extend([STEERING_OFFSET, YAW_RATE_OFFSET]);
        Self {
            p: of_vehicle(vehicle, vehicle.steering_ratio),
            front_share: vehicle.distance_rear_m
                / (vehicle.distance_front_m + vehicle.distance_rear_m),
            free,
            dynamic,
        }
    }

    /// Number of parameters of the dynamics.
    pub(crate) fn len(&self) -> usize {
        self.dynamic
    }

    /// Number of all parameters: those of the dynamics, then the offsets of steering and yaw rate.
    pub(crate) fn with_offsets(&self) -> usize {
        self.free.len()
    }

    /// The information in the priors of all parameters, which are independent.
    pub(crate) fn prior(&self) -> Vec<f64> {
        let geometry = Geometry { wheelbase: None, is_angle: true };
        let priors = priors(geometry);
        self.free.iter().map(|&i| priors[i].deviation.powi(-2)).collect()
    }

    /// The derivatives of the yaw rate by all parameters, rad/s, and then by the initial lateral velocity and yaw rate: a row
    /// for each sample of the road-wheel angle, rad, which is held over it. `None` where the vehicle is unstable.
    pub(crate) fn sensitivities(
        &self,
        road_wheel_rad: &[f64],
        speed_mps: f64,
        sample_time_s: f64,
    ) -> Option<Vec<Vec<f64>>> {
        let count = road_wheel_rad.len();
        let (speed, yaw_rate) = (vec![speed_mps; count], vec![0.0; count]);
        let recording = SpeedSegment {
            sample_time: sample_time_s,
            before: &[],
            steering: road_wheel_rad,
            speed: &speed,
            yaw_rate: &yaw_rate,
        };
        let by_delay = self.free.contains(&DELAY);
        let found = sensitivities(&self.p, self.front_share, &recording, &[0.0; 2], by_delay)?;
        let row = |by: &[f64]| {
            let parameters = self.free.iter().map(|&i| by[i]);
            parameters.chain(by[PARAMETERS..].iter().copied()).collect()
        };
        Some(found.by.iter().map(|by| row(by)).collect())
    }

    /// Yaw rate over steering angle, 1/s at the road wheel of the log, at a frequency in Hz: real and imaginary part.
    pub(crate) fn response(&self, speed_mps: f64, hz: f64) -> [f64; 2] {
        self.response_of(&self.p, speed_mps, hz)
    }

    fn response_of(&self, p: &[f64; PARAMETERS], speed_mps: f64, hz: f64) -> [f64; 2] {
        let g = response(p, self.front_share, speed_mps, hz) * p[STEERING_FACTOR].exp();
        [g.re, g.im]
    }

    /// Gradients of the logarithm of the gain and of the phase, rad, of the response by the parameters of the dynamics.
    pub(crate) fn response_gradients(&self, speed_mps: f64, hz: f64) -> [Vec<f64>; 2] {
        let mut gradients = [Vec::new(), Vec::new()];
        for &i in &self.free[..self.dynamic] {
            let moved = |step: f64| {
                let mut p = self.p;
                p[i] += step;
                let [re, im] = self.response_of(&p, speed_mps, hz);
                (re.hypot(im).ln(), im.atan2(re))
            };
            let (up, down) = (moved(STEP), moved(-STEP));
            let turned = (up.1 - down.1).sin().atan2((up.1 - down.1).cos());
            gradients[0].push((up.0 - down.0) / (2.0 * STEP));
            gradients[1].push(turned / (2.0 * STEP));
        }
        gradients
    }

    /// The gradient of the understeer gradient at the road wheel, rad·s²/m, by all parameters.
    pub(crate) fn understeer_gradient(&self) -> Vec<f64> {
        // It does not depend on the speed.
        let all = self.combinations(1.0);
        let own = all.into_iter().find(|(name, ..)| *name == "understeer_gradient");
        own.map_or_else(|| vec![0.0; self.free.len()], |(.., gradient)| gradient)
    }

    /// The combinations that the identification states: name, unit, value, and gradient by all parameters.
    pub(crate) fn combinations(
        &self,
        speed_mps: f64,
    ) -> Vec<(&'static str, &'static str, f64, Vec<f64>)> {
        let own = |(name, unit, combined): Combination| {
            let by: [f64; PARAMETERS] = combined.by();
            let gradient = self.free.iter().map(|&i| by[i]).collect();
            (name, unit, combined.value(), gradient)
        };
        combinations(&self.p, self.front_share, speed_mps).into_iter().map(own).collect()
    }
}
