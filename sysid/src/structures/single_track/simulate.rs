//! Simulation of the model over a segment, for plain and for dual numbers.
//!
//! Tyres follow their slip angle and the road wheels their command in closed form; lateral velocity and
//! yaw rate by Heun's method. The tyre forces depend on the relaxed slip angles alone, so that a step
//! needs them once: the step is of second order.

use crate::linalg::dual::Scalar;
use crate::structures::single_track::dynamics::{Constants, Forces, LEAST_SPEED};
use crate::structures::single_track::prepared::PreparedSegment;

/// What a simulation returns at each sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output<S> {
    /// Yaw rate with the sensor's offset, rad/s.
    pub(super) yaw_rate: S,
    /// Lateral acceleration with the sensor's offset at its place, m/s².
    pub(super) lateral_acceleration: S,
    /// Lateral velocity, m/s.
    pub(super) lateral_velocity: S,
}

/// How a simulation runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    /// Samples of the drive in a step of the output.
    pub(super) stride: usize,
    /// Longest step of integration, s.
    pub(super) longest_step_s: f64,
    /// Gain from the error of yaw rate to ṙ, 1/s: 0 is the free simulation.
    pub(super) gain: f64,
    /// Gain by which v_y returns to a sideslip that vehicles have without spinning, 1/s: 0 is the free
    /// simulation.
    pub(super) guard: f64,
    /// Samples after which the state is set to the measured one; 0 for never.
    pub(super) restart: usize,
}

/// The tangent of the sideslip from which v_y is guarded.
const GUARDED_TANGENT: f64 = 0.2;
/// The sideslip beyond which a simulation stops: the tangent is still defined.
const LARGEST_TANGENT: f64 = 20.0;

/// Simulates a segment and passes each sample's output on with its index. False where the model leaves
/// all bounds.
#[inline(always)]
pub(super) fn simulate<S: Scalar>(
    k: &Constants<S>,
    segment: &PreparedSegment<'_>,
    run: &Run,
    mut each: impl FnMut(usize, Output<S>),
) -> bool {
    let period = segment.sample_time * run.stride as f64;
    let substeps = (period / run.longest_step_s - 1e-9).ceil().max(1.0);
    let h = period / substeps;
    let substeps = substeps as usize;
    // The road wheels' lag, for a command that is linear within half a step.
    let lag = Ramp::new(k.lag_rate.times(0.5 * h));
    let command = |time: f64| -> S {
        let (angle, rate) = segment.steering(time - k.delay.value());
        // By the delay the command changes by −δ̇.
        let moved = -(k.delay.plus(-k.delay.value())).times(rate);
        k.steering_factor * moved.plus(angle) + k.steering_offset
    };
    let mut steering = command(0.0);
    let mut commanded = steering;
    // The state of a steady turn at the measured yaw rate.
    let rest = |index: usize, steering: S| {
        let r = (-k.yaw_rate_offset).plus(segment.smooth_yaw_rate[index]);
        let v = segment.speed[index];
        let vy = k.distance[1] * r - r * k.rear_slip_per_acceleration.times(v * v);
        (vy, r, k.slip(vy, r, steering, segment.speed[index]))
    };
    let pull = |vy: S, r: S, acceleration: f64| {
        if segment.is_acceleration_measured {
            S::constant(acceleration)
        } else {
            (-(vy * r)).plus(acceleration)
        }
    };
    let (mut vy, mut r, mut slip) = rest(0, steering);
    let mut target = slip;
    let mut now = segment.known(0.0);
    let mut forces = k.forces(slip, steering.cos(), pull(vy, r, now.acceleration), now.speed);
    let mut index = 0;
    loop {
        if run.restart > 0 && index > 0 && index % run.restart < run.stride {
            (vy, r, slip) = rest(index, steering);
            target = slip;
            forces = k.forces(slip, steering.cos(), pull(vy, r, now.acceleration), now.speed);
        }
        each(
            index,
            Output {
                yaw_rate: r + k.yaw_rate_offset,
                lateral_acceleration: forces.lateral
                    + k.accelerometer_position * forces.yaw
                    + k.lateral_acceleration_offset,
                lateral_velocity: vy,
            },
        );
        if index + run.stride >= segment.len() {
            return true;
        }
        for j in 0..substeps {
            let time = segment.sample_time * index as f64 + h * j as f64;
            let next = segment.known(time + h);
            let rates = |forces: &Forces<S>, vy: S, r: S, time: f64, speed: f64| {
                let (mut lateral, mut yaw) = (forces.lateral - r.times(speed), forces.yaw);
                if run.gain > 0.0 {
                    let error = (-(r + k.yaw_rate_offset)).plus(segment.yaw_rate(time));
                    yaw = yaw + error.times(run.gain);
                }
                let bound = GUARDED_TANGENT * speed.max(LEAST_SPEED);
                if run.guard > 0.0 && vy.value().abs() > bound {
                    lateral = lateral - vy.plus(-bound.copysign(vy.value())).times(run.guard);
                }
                (lateral, yaw)
            };
            let slope = rates(&forces, vy, r, time, now.speed);
            let (vy_next, r_next) = (vy + slope.0.times(h), r + slope.1.times(h));
            for end in [0.5 * h, h] {
                let next_command = command(time + end);
                steering = lag.follow(steering, commanded, next_command);
                commanded = next_command;
            }
            let target_next = k.slip(vy_next, r_next, steering, next.speed);
            let v = (0.5 * (now.speed + next.speed)).max(LEAST_SPEED);
            for axle in 0..2 {
                let ramp = Ramp::new(k.relaxation[axle].times(h * v));
                slip[axle] = ramp.follow(slip[axle], target[axle], target_next[axle]);
            }
            forces = k.forces(
                slip,
                steering.cos(),
                pull(vy_next, r_next, next.acceleration),
                next.speed,
            );
            let end = rates(&forces, vy_next, r_next, time + h, next.speed);
            vy = vy + (slope.0 + end.0).times(0.5 * h);
            r = r + (slope.1 + end.1).times(0.5 * h);
            target = k.slip(vy, r, steering, next.speed);
            now = next;
            let bound = LARGEST_TANGENT * next.speed.max(1.0);
            if !(vy.value().abs() < bound && r.value().abs() < bound) {
                return false;
            }
        }
        index += run.stride;
    }
}

/// A first-order lag over one step in which its input is linear: `x⁺ = e^{−z}·x + …` with z = h/T.
#[derive(Clone, Copy)]
struct Ramp<S> {
    /// Weights of the state, of the input before and of the input after.
    weights: [S; 3],
}

impl<S: Scalar> Ramp<S> {
    #[inline]
    fn new(z: S) -> Self {
        let keep = (-z).exp();
        // ∫ of the ramp: φ = (1 − e^{−z})/z.
        let phi = if z.value() < 1e-4 { (-z.times(0.5)).plus(1.0) } else { (-keep).plus(1.0) / z };
        Self { weights: [keep, phi - keep, (-phi).plus(1.0)] }
    }

    #[inline]
    fn follow(&self, state: S, before: S, after: S) -> S {
        let [w, x, y] = self.weights;
        w * state + x * before + y * after
    }
}
