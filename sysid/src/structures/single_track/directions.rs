//! The uncertainty of the vehicle in gentle driving, as a factor of the covariance of its data.

use crate::Error;
use crate::linalg::dense::svd;
use crate::structures::single_track::identify::SingleTrack;
use crate::structures::single_track::parameters::{COUNT, Parameter};
use faer::Mat;
use steerwright_formats::VehicleDirection;

/// ln L, ln J, ln C_f, ln C_r, ln T, τ and ln of the steering ratio.
const DATA: usize = 7;

/// One standard deviation along each independent axis. The distances of the axles follow the wheelbase. With stiffnesses
/// over loads and inertia over m·L_f·L_r the yaw rate hardly depends on the front axle's share in the weight, so the share
/// stays where it is: moved at fixed distances it would change the understeer, which it does not.
///
/// # Errors
/// [`Error::Numerical`] where the covariance has no decomposition.
pub(super) fn directions(found: &SingleTrack) -> Result<Vec<VehicleDirection>, Error> {
    let mut by: [[f64; COUNT]; DATA] = [[0.0; COUNT]; DATA];
    for (data, parameter, slope) in [
        (0, Parameter::Wheelbase, 1.0),
        (1, Parameter::DynamicIndex, 1.0),
        (1, Parameter::Wheelbase, 2.0),
        (2, Parameter::StiffnessFront, 1.0),
        (3, Parameter::StiffnessRear, 1.0),
        (4, Parameter::Lag, 1.0),
        (5, Parameter::Delay, 1.0),
        (6, Parameter::SteeringFactor, -1.0),
    ] {
        by[data][parameter.index()] = slope;
    }
    let covariance = Mat::from_fn(DATA, DATA, |i, j| {
        let mut sum = 0.0;
        for (a, row) in by[i].iter().zip(&found.covariance) {
            sum += a * row.iter().zip(&by[j]).map(|(c, b)| c * b).sum::<f64>();
        }
        sum
    });
    let axes = svd(covariance.as_ref())?;
    let largest = axes.s.first().copied().unwrap_or(0.0);
    let direction = |k: usize| {
        let of = |data: usize| axes.u[(data, k)] * axes.s[k].sqrt();
        VehicleDirection {
            wheelbase: of(0),
            yaw_inertia: of(1),
            cornering_stiffness_front: of(2),
            cornering_stiffness_rear: of(3),
            actuator_time_constant: of(4),
            actuator_delay_s: of(5),
            steering_ratio: of(6),
        }
    };
    Ok((0..DATA).filter(|&k| axes.s[k] > 1e-12 * largest).map(direction).collect())
}
