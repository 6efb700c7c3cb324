//! What a drive would determine of a single-track model before it is driven, by the simulation, the derivatives, the free
//! parameters and the priors of the identification from steering, speed and yaw rate.

use crate::Error;
use crate::linalg::bounded_step::Normal;
use crate::structures::single_track::drive::{Drive, DriveSegment};
use crate::structures::single_track::dynamics::{Constants, GRAVITY};
use crate::structures::single_track::model::{SimulatedSegment, SingleTrackModel};
use crate::structures::single_track::options::SingleTrackOptions;
use crate::structures::single_track::parameters::{COUNT, Parameter, Scale};
use crate::structures::single_track::prepared::prepare;
use crate::structures::single_track::problem::{Point, Problem};
use crate::structures::single_track::search::result_run;
use crate::structures::single_track::simulate::{SimulationRun, simulate};

/// Parameters that two drives of opposite steering inform about with opposite signs beside all others.
const OFFSETS: [Parameter; 2] = [Parameter::SteeringOffset, Parameter::YawRateOffset];

/// A vehicle and the parameters that an identification would estimate.
#[derive(Debug, Clone)]
pub(crate) struct SingleTrackInformation {
    point: Point,
    priors: [Normal; COUNT],
    free: Vec<usize>,
    steering_ratio: f64,
}

/// A quantity that an identification states: name, unit, value, and gradient by the free parameters.
pub(crate) type Stated = (&'static str, &'static str, f64, Vec<f64>);

impl SingleTrackInformation {
    pub(crate) fn new(model: &SingleTrackModel, steering_ratio: f64) -> Result<Self, Error> {
        let priors = SingleTrackOptions::default().priors(false)?;
        Ok(Self {
            point: model.point(),
            free: (0..COUNT).filter(|&i| priors[i].standard_deviation > 0.0).collect(),
            priors: std::array::from_fn(|i| Normal::new(Parameter::ALL[i], &priors[i])),
            steering_ratio,
        })
    }

    /// Number of free parameters.
    pub(crate) fn len(&self) -> usize {
        self.free.len()
    }

    /// The information in the priors, which are independent.
    pub(crate) fn prior(&self) -> Vec<f64> {
        self.free.iter().map(|&i| self.priors[i].deviation.powi(-2)).collect()
    }

    /// The most that the axle with less grip holds in a steady turn, m/s².
    pub(crate) fn grip_mps2(&self) -> f64 {
        let of = |p: Parameter| p.value(self.point[p.index()]);
        GRAVITY * of(Parameter::FrictionFront) * of(Parameter::FrictionBalance).min(1.0)
    }

    /// The coordinates of the vehicle, moved along an axis, within the bounds.
    pub(crate) fn moved(&self, axis: &[f64; COUNT], by: f64) -> [f64; COUNT] {
        std::array::from_fn(|i| {
            let [low, high] = self.priors[i].bounds;
            (self.point[i] + by * axis[i]).clamp(low.min(self.point[i]), high.max(self.point[i]))
        })
    }

    fn drive(&self, steering_rad: &[f64], speed_mps: f64, sample_time_s: f64) -> Drive {
        let count = steering_rad.len();
        Drive {
            sample_time_s,
            steering_ratio: self.steering_ratio,
            // Each angle is held.
            steering_delay_s: 0.5 * sample_time_s,
            segments: vec![DriveSegment {
                steering_rad: steering_rad.to_vec(),
                speed_mps: vec![speed_mps; count],
                yaw_rate_radps: vec![0.0; count],
                ..DriveSegment::default()
            }],
        }
    }

    /// What a vehicle of coordinates does from straight driving; `None` where it leaves all bounds.
    pub(crate) fn motion(
        &self,
        coordinates: &[f64; COUNT],
        steering_rad: &[f64],
        speed_mps: f64,
        sample_time_s: f64,
    ) -> Option<SimulatedSegment> {
        let drive = self.drive(steering_rad, speed_mps, sample_time_s);
        let run = SimulationRun { stride: 1, ..result_run(sample_time_s) };
        let mut all = SimulatedSegment::default();
        let prepared = prepare(&drive);
        let finite =
            simulate(&Constants::new(coordinates), prepared.first()?, &run, |_, output| {
                all.yaw_rate_radps.push(output.yaw_rate);
                all.lateral_acceleration_mps2.push(output.lateral_acceleration);
                all.lateral_velocity_mps.push(output.lateral_velocity);
            });
        if finite { Some(all) } else { None }
    }

    /// The information of a drive from straight driving without that of the priors, row by row, for a density of the errors of
    /// the yaw rate; `None` where the vehicle leaves all bounds.
    pub(crate) fn information(
        &self,
        steering_rad: &[f64],
        speed_mps: f64,
        sample_time_s: f64,
        noise_density: f64,
    ) -> Option<Vec<f64>> {
        let drive = self.drive(steering_rad, speed_mps, sample_time_s);
        let problem = Problem {
            segments: prepare(&drive),
            sample_time: sample_time_s,
            priors: self.priors,
            // Without the priors, which count once and not with each drive.
            free: Vec::new(),
            fitted: [true, false, false],
        };
        let densities = [noise_density, 1.0, 1.0];
        let normals = problem.normals(&self.point, &result_run(sample_time_s), &densities)?;
        let of = |i: usize| self.free.iter().map(move |&j| normals.hessian[i][j]);
        Some(self.free.iter().flat_map(|&i| of(i)).collect())
    }

    /// The information of the drive with opposite steering.
    pub(crate) fn mirrored(&self, information: &[f64]) -> Vec<f64> {
        let is_offset = |k: usize| OFFSETS.iter().any(|p| p.index() == self.free[k]);
        let n = self.len();
        let entry = |(at, value): (usize, &f64)| {
            if is_offset(at / n) == is_offset(at % n) { *value } else { -value }
        };
        information.iter().enumerate().map(entry).collect()
    }

    fn gradient(&self, of: &[(Parameter, f64)]) -> Vec<f64> {
        let slope = |i: usize| of.iter().filter(|(p, _)| p.index() == i).map(|(_, by)| by).sum();
        self.free.iter().map(|&i| slope(i)).collect()
    }

    /// Gradients of the logarithms of the friction coefficients of front and rear axle.
    pub(crate) fn friction_gradients(&self) -> [Vec<f64>; 2] {
        let front = (Parameter::FrictionFront, 1.0);
        [self.gradient(&[front]), self.gradient(&[front, (Parameter::FrictionBalance, 1.0)])]
    }

    /// The free parameters, and the friction coefficient of the rear axle.
    pub(crate) fn stated(&self) -> Vec<Stated> {
        let value = |p: Parameter| p.value(self.point[p.index()]);
        let own = |&i: &usize| {
            let p = Parameter::ALL[i];
            let slope = if p.scale() == Scale::Logarithmic { value(p) } else { 1.0 };
            (p.name(), p.unit(), value(p), self.gradient(&[(p, slope)]))
        };
        let mut all: Vec<Stated> = self.free.iter().map(own).collect();
        let rear = value(Parameter::FrictionFront) * value(Parameter::FrictionBalance);
        let [_, by] = self.friction_gradients();
        let scaled = by.into_iter().map(|x| rear * x).collect();
        let place = Parameter::FrictionBalance.index().min(all.len());
        all.insert(place, ("friction_coefficient_rear", "1", rear, scaled));
        all
    }
}
