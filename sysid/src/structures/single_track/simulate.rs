//! Simulation of the model over a segment, for plain and for dual numbers.
//!
//! The road wheels follow their command in closed form; lateral velocity and yaw rate by Heun's method, in steps that
//! are short at low speed, where the axles' forces change fast.

use crate::linalg::dual::Scalar;
use crate::structures::limited_wheel::Servo;
use crate::structures::single_track::dynamics::{Constants, Forces, LEAST_SPEED};
use crate::structures::single_track::prepared::PreparedSegment;
use pulp::{Arch, Simd, WithSimd};

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
pub(super) struct SimulationRun {
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

/// A largest rate of the road wheels that stands for none, but for rounding, rad/s.
const UNLIMITED_RATE: f64 = 9.999;
/// Time of the steering before a segment that a wheel of limited rate has followed, and the steps in which it does, s.
pub(super) const LONGEST_BEFORE_S: f64 = 5.0;
const BEFORE_STEP_S: f64 = 0.005;
/// The tangent of the sideslip from which v_y is guarded.
const GUARDED_TANGENT: f64 = 0.2;
/// Longest step times the rate of the faster of v_y and r.
const LONGEST_BY_RATE: f64 = 0.5;
/// Most steps between two samples.
const MOST_SUBSTEPS: f64 = 200.0;
/// The sideslip beyond which a simulation stops: the tangent is still defined.
const LARGEST_TANGENT: f64 = 20.0;

/// Simulates a segment and passes each sample's output on with its index. False where the model leaves
/// all bounds.
pub(super) fn simulate<S: Scalar>(
    k: &Constants<S>,
    segment: &PreparedSegment<'_>,
    run: &SimulationRun,
    each: impl FnMut(usize, Output<S>),
) -> bool {
    Arch::new().dispatch(Simulation { k, segment, run, each })
}

struct Simulation<'a, S, F> {
    k: &'a Constants<S>,
    segment: &'a PreparedSegment<'a>,
    run: &'a SimulationRun,
    each: F,
}

impl<S: Scalar, F: FnMut(usize, Output<S>)> WithSimd for Simulation<'_, S, F> {
    type Output = bool;

    /// The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) -> bool {
        let Self { k, segment, run, mut each } = self;
        let period = segment.sample_time * run.stride as f64;
        let command = |time: f64| -> S {
            let (angle, rate) = segment.steering(time - k.delay.value());
            // By the delay the command changes by −δ̇.
            let moved = -(k.delay.plus(-k.delay.value())).times(rate);
            k.steering_factor * moved.plus(angle) + k.steering_offset
        };
        let mut commanded = command(0.0);
        let mut steering = commanded;
        // The state of a steady turn at the measured yaw rate.
        let rest = |index: usize| {
            let r = (-k.yaw_rate_offset).plus(segment.smooth_yaw_rate[index]);
            let v = segment.speed[index];
            (k.distance[1] * r - r * k.rear_slip_per_acceleration.times(v * v), r)
        };
        let (mut vy, mut r) = rest(0);
        let is_limited = k.rate_max.value() < UNLIMITED_RATE;
        let servo = Servo { lag_rate: k.lag_rate, rate_max: k.rate_max };
        // The wheel at the end of a part of a step: of a limited rate after each step of a held command, else after a command
        // that is linear within the part.
        let turned = |lag: &Ramp<S>, steering: S, command: [S; 2], from: f64, to: f64| -> S {
            if !is_limited {
                return lag.follow(steering, command[0], command[1]);
            }
            let Some((held, before)) = segment.held_steering() else {
                // The rate is limited throughout the part or not at all.
                let most = k.rate_max.times(to - from);
                let followed = lag.follow(steering, command[0], command[1]);
                return match (followed - steering).value() {
                    moved if moved > most.value() => steering + most,
                    moved if moved < -most.value() => steering - most,
                    _ => followed,
                };
            };
            let last = (held.len() - 1) as f64;
            let (mut wheel, mut at) = (steering, S::constant(from));
            let mut sample = ((from - k.delay.value()) / segment.sample_time).floor();
            loop {
                let step = k.delay.plus((sample + 1.0) * segment.sample_time);
                let is_last = step.value() >= to;
                let end = if is_last { S::constant(to) } else { step };
                let angle = held[(sample + before as f64).clamp(0.0, last) as usize];
                let target = k.steering_factor.times(angle) + k.steering_offset;
                wheel = servo.follow(wheel, target, end - at);
                if is_last {
                    return wheel;
                }
                (at, sample) = (end, sample + 1.0);
            }
        };
        if is_limited {
            // A command may have outrun the wheel, which is where it followed what was steered before.
            let before = segment.known_before().min(LONGEST_BEFORE_S);
            let count = (before / BEFORE_STEP_S).ceil();
            let h = before / count.max(1.0);
            let lag = Ramp::new(k.lag_rate.times(h));
            commanded = command(-before);
            steering = commanded;
            for j in 0..count as usize {
                let [from, to] = [j, j + 1].map(|j| h * j as f64 - before);
                let next = command(to);
                steering = turned(&lag, steering, [commanded, next], from, to);
                commanded = next;
            }
        }
        let mut known = segment.known(0.0);
        let mut forces = k.forces(vy, r, steering, known);
        let mut substeps = 0.0;
        let mut lag = Ramp::new(k.lag_rate);
        let mut index = 0;
        loop {
            if run.restart > 0 && index > 0 && index % run.restart < run.stride {
                (vy, r) = rest(index);
                forces = k.forces(vy, r, steering, known);
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
            let by_rate = LONGEST_BY_RATE * known.speed.max(LEAST_SPEED) / k.rate_by_speed;
            let needed =
                (period / run.longest_step_s.min(by_rate) - 1e-9).ceil().clamp(1.0, MOST_SUBSTEPS);
            let h = period / needed;
            if needed != substeps {
                substeps = needed;
                // For a command that is linear within half a step.
                lag = Ramp::new(k.lag_rate.times(0.5 * h));
            }
            for j in 0..substeps as usize {
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
                let slope = rates(&forces, vy, r, time, known.speed);
                let (vy_next, r_next) = (vy + slope.0.times(h), r + slope.1.times(h));
                let middle = time + 0.5 * h;
                for [from, to] in [[time, middle], [middle, time + h]] {
                    let next_command = command(to);
                    steering = turned(&lag, steering, [commanded, next_command], from, to);
                    commanded = next_command;
                }
                let predicted = k.forces(vy_next, r_next, steering, next);
                let end = rates(&predicted, vy_next, r_next, time + h, next.speed);
                vy = vy + (slope.0 + end.0).times(0.5 * h);
                r = r + (slope.1 + end.1).times(0.5 * h);
                known = next;
                forces = k.forces(vy, r, steering, known);
                let bound = LARGEST_TANGENT * known.speed.max(1.0);
                if !(vy.value().abs() < bound && r.value().abs() < bound) {
                    return false;
                }
            }
            index += run.stride;
        }
    }
}

/// A first-order lag over one step in which its input is linear: `x⁺ = e^{−z}·x + …` with z = h/T.
#[derive(Clone, Copy)]
struct Ramp<S> {
    /// Weights of the state, of the input before and of the input after.
    weights: [S; 3],
}

impl<S: Scalar> Ramp<S> {
    #[inline(always)]
    fn new(z: S) -> Self {
        let keep = (-z).exp();
        // ∫ of the ramp: φ = (1 − e^{−z})/z.
        let phi = if z.value() < 1e-4 { (-z.times(0.5)).plus(1.0) } else { (-keep).plus(1.0) / z };
        Self { weights: [keep, phi - keep, (-phi).plus(1.0)] }
    }

    #[inline(always)]
    fn follow(&self, state: S, before: S, after: S) -> S {
        let [w, x, y] = self.weights;
        w * state + x * before + y * after
    }
}
