//! The least-squares problem: errors of the outputs over their noise, and of the parameters over their
//! priors' deviations; its cost, and its normal equations by dual numbers.

use crate::linalg::bounded_step::Normal;
use crate::linalg::dual::{Dual, Scalar};
use crate::structures::single_track::dynamics::Constants;
use crate::structures::single_track::parameters::{COUNT, Parameter};
use crate::structures::single_track::prepared::PreparedSegment;
use crate::structures::single_track::simulate::{Output, SimulationRun, simulate};
use std::cmp::Ordering;
use steerwright_formats::Prior;

/// Number of outputs: yaw rate, lateral acceleration, lateral velocity.
pub(super) const OUTPUTS: usize = 3;
const LATERAL_ACCELERATION: usize = 1;

/// Time after the beginning of a simulation in which errors have no weight, s: the initial state is
/// that of a steady turn.
const WARM_UP_S: f64 = 0.5;

/// Sideslip beyond which a simulated vehicle may spin, as a tangent, and the error of yaw rate
/// (rad/s) and time (s) that make it a spin.
const SPIN: (f64, f64, f64) = (0.7, 0.3, 0.2);

/// Coordinates of all parameters.
pub(super) type Point = [f64; COUNT];

/// Spectral density of each output's errors at low frequency, unit²·s.
pub(super) type Densities = [f64; OUTPUTS];

/// The data with the priors.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    pub(super) segments: Vec<PreparedSegment<'a>>,
    /// s.
    pub(super) sample_time: f64,
    /// Priors of the coordinates.
    pub(super) priors: [Normal; COUNT],
    /// Places of the parameters that are estimated.
    pub(super) free: Vec<usize>,
    /// Which outputs are fitted.
    pub(super) fitted: [bool; OUTPUTS],
}

impl Normal {
    pub(super) fn new(parameter: Parameter, prior: &Prior) -> Self {
        Self {
            mean: parameter.coordinate(prior.mean),
            deviation: prior.standard_deviation,
            bounds: [parameter.coordinate(prior.min), parameter.coordinate(prior.max)],
        }
    }
}

/// `½·Σ` of squares with gradient and Gauss–Newton Hessian over all parameters.
#[derive(Debug, Clone)]
pub(super) struct Normals {
    pub(super) gradient: Point,
    pub(super) hessian: [[f64; COUNT]; COUNT],
}

/// Where a number has the derivative by a parameter. The offset of the lateral acceleration, on which nothing else depends,
/// has none, so that value and derivatives fill whole vectors.
fn lane(parameter: usize) -> Option<usize> {
    match parameter.cmp(&Parameter::LateralAccelerationOffset.index()) {
        Ordering::Less => Some(parameter),
        Ordering::Equal => None,
        Ordering::Greater => Some(parameter - 1),
    }
}

impl Problem<'_> {
    /// A point with the parameters that are not estimated where their priors have them.
    pub(super) fn with_fixed_parameters(&self, point: &Point) -> Point {
        std::array::from_fn(|i| if self.free.contains(&i) { point[i] } else { self.priors[i].mean })
    }

    /// The measured signal of an output on a segment.
    pub(super) fn measured_signal<'s>(
        &self,
        segment: &'s PreparedSegment<'_>,
        output: usize,
    ) -> Option<&'s [f64]> {
        [Some(segment.yaw_rate), segment.lateral_acceleration, segment.lateral_velocity]
            .get(output)
            .copied()
            .flatten()
    }

    /// The measured outputs at a sample.
    fn measured(segment: &PreparedSegment<'_>, index: usize) -> [Option<f64>; OUTPUTS] {
        [
            Some(segment.yaw_rate[index]),
            segment.lateral_acceleration.map(|a| a[index]),
            segment.lateral_velocity.map(|v| v[index]),
        ]
    }

    /// Samples before the errors count.
    fn warm_up(&self) -> usize {
        (WARM_UP_S / self.sample_time).round() as usize
    }

    /// Whether the errors at a sample count.
    #[inline]
    fn counts(index: usize, run: &SimulationRun, warm_up: usize) -> bool {
        let since = if run.restart > 0 { index % run.restart } else { index };
        since >= warm_up
    }

    /// Errors of each fitted output by segment; `None` where the model leaves all bounds or, in a free
    /// simulation, spins.
    pub(super) fn errors(
        &self,
        p: &Point,
        run: &SimulationRun,
    ) -> Option<[Vec<Vec<f64>>; OUTPUTS]> {
        let constants = Constants::new(p);
        let warm_up = self.warm_up();
        let mut all: [Vec<Vec<f64>>; OUTPUTS] = Default::default();
        let is_free = run.gain == 0.0 && run.guard == 0.0 && run.restart == 0;
        for segment in &self.segments {
            let mut own: [Vec<f64>; OUTPUTS] = Default::default();
            let (mut spinning, mut spun) = (0.0, false);
            let finite = simulate(&constants, segment, run, |index, output| {
                let yaw_error = segment.yaw_rate[index] - output.yaw_rate;
                let sideways =
                    output.lateral_velocity.abs() > SPIN.0 * segment.speed[index].max(3.0);
                if sideways && yaw_error.abs() > SPIN.1 {
                    spinning += segment.sample_time * run.stride as f64;
                    spun |= spinning > SPIN.2;
                } else {
                    spinning = 0.0;
                }
                if !Self::counts(index, run, warm_up) {
                    return;
                }
                let simulated =
                    [output.yaw_rate, output.lateral_acceleration, output.lateral_velocity];
                let measured = Self::measured(segment, index);
                for i in 0..OUTPUTS {
                    if let (true, Some(y)) = (self.fitted[i], measured[i]) {
                        own[i].push(y - simulated[i]);
                    }
                }
            });
            if !finite || (is_free && spun) {
                return None;
            }
            for (all, own) in all.iter_mut().zip(own) {
                all.push(own);
            }
        }
        Some(all)
    }

    /// `½·Σ` of squares; `None` as for [`Problem::errors`].
    pub(super) fn cost(
        &self,
        p: &Point,
        run: &SimulationRun,
        densities: &Densities,
    ) -> Option<f64> {
        let errors = self.errors(p, run)?;
        let mut sum = 0.0;
        for (i, errors) in errors.iter().enumerate() {
            if self.fitted[i] {
                let squares: f64 = errors.iter().flatten().map(|e| e * e).sum();
                sum += squares * self.period(run) / densities[i];
            }
        }
        let prior: f64 = self.free.iter().map(|&i| self.deviation(p, i).powi(2)).sum();
        let cost = 0.5 * (sum + prior);
        if cost.is_finite() { Some(cost) } else { None }
    }

    pub(super) fn period(&self, run: &SimulationRun) -> f64 {
        run.stride as f64 * self.sample_time
    }

    /// (p − μ)/σ.
    pub(super) fn deviation(&self, p: &Point, i: usize) -> f64 {
        (p[i] - self.priors[i].mean) / self.priors[i].deviation
    }

    /// Passes errors and derivatives of the outputs on, sample by sample, with the segment's number.
    pub(super) fn sensitivities(
        &self,
        p: &Point,
        run: &SimulationRun,
        mut each: impl FnMut(usize, [Option<(f64, [f64; COUNT])>; OUTPUTS]),
    ) -> bool {
        let duals: [Dual<COUNT>; COUNT] = std::array::from_fn(|i| match lane(i) {
            Some(lane) => Dual::parameter(p[i], lane),
            None => Dual::constant(p[i]),
        });
        let constants = Constants::new(&duals);
        let warm_up = self.warm_up();
        self.segments.iter().enumerate().all(|(number, segment)| {
            simulate(&constants, segment, run, |index, output: Output<Dual<COUNT>>| {
                if !Self::counts(index, run, warm_up) {
                    return;
                }
                let simulated =
                    [output.yaw_rate, output.lateral_acceleration, output.lateral_velocity];
                let measured = Self::measured(segment, index);
                each(
                    number,
                    std::array::from_fn(|i| {
                        let y = measured[i].filter(|_| self.fitted[i])?;
                        let own = simulated[i].by::<{ COUNT - 1 }>();
                        // The offset is added to the lateral acceleration.
                        let added = if i == LATERAL_ACCELERATION { 1.0 } else { 0.0 };
                        let by = |j: usize| lane(j).map_or(added, |lane| own[lane]);
                        Some((y - simulated[i].value(), std::array::from_fn(by)))
                    }),
                );
            })
        })
    }

    /// The normal equations at a point.
    pub(super) fn normals(
        &self,
        p: &Point,
        run: &SimulationRun,
        densities: &Densities,
    ) -> Option<Normals> {
        let mut normals = Normals { gradient: [0.0; COUNT], hessian: [[0.0; COUNT]; COUNT] };
        let period = self.period(run);
        let finite = self.sensitivities(p, run, |_, outputs| {
            for (i, output) in outputs.iter().enumerate() {
                let Some((error, by)) = output else { continue };
                let weight = period / densities[i];
                for (j, b) in by.iter().enumerate() {
                    let weighted = weight * b;
                    normals.gradient[j] -= weighted * error;
                    for (h, c) in normals.hessian[j][..=j].iter_mut().zip(by) {
                        *h += weighted * c;
                    }
                }
            }
        });
        if !finite {
            return None;
        }
        for i in 0..COUNT {
            for j in 0..i {
                normals.hessian[j][i] = normals.hessian[i][j];
            }
        }
        for &i in &self.free {
            let deviation = self.priors[i].deviation;
            normals.gradient[i] += self.deviation(p, i) / deviation;
            normals.hessian[i][i] += deviation.powi(-2);
        }
        if normals.gradient.iter().all(|g| g.is_finite()) { Some(normals) } else { None }
    }
}
