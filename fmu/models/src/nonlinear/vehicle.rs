//! The vehicle: inputs, states, steps and outputs. Equations are in `docs/methods/nonlinear.md`.

use super::actuator::Motion;
use super::dynamics::{Constants, Lateral, RoadWheel};
use super::parameters::{NonlinearParameters, within};
use super::play;
use super::runge_kutta::Longest;
use crate::Error;
use crate::delay::{DelayLine, Segment};
use crate::error::{diverged, numbers};
use crate::identified_plant::LONGEST_STEP;
use crate::quadrature::{Pose, pose_getters};
use crate::trigonometry::sin_cos;

/// Most panels a step may take: some seconds of computing.
const MOST_PANELS: f64 = 1e7;

/// How near to an edge of the play the wheels count as taken along, rad.
const EDGE: f64 = 1e-12;

/// A wheel's angle, if need be moved to the nearer edge of a gap of twice `half` about the servo's angle, rad.
pub(super) fn within_play(wheel: f64, servo: f64, half: f64) -> f64 {
    wheel.max(servo - half).min(servo + half)
}

/// A vehicle up to its limits. Its clone is its whole state.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearVehicle {
    /// What it is made of. Read at the start.
    pub parameters: NonlinearParameters,
    /// Input: steering angle, rad.
    pub steering_angle: f64,
    /// How fast the steering angle grows within the next steps, rad/s; the delay, the actuator and
    /// the integration see it grow.
    pub steering_slope: f64,
    /// Input: speed, m/s.
    pub speed: f64,
    /// Input: velocity of the air to the left of the vehicle, m/s.
    pub crosswind: f64,
    /// Position at the start, m.
    pub initial_x: f64,
    /// Position at the start, m.
    pub initial_y: f64,
    /// Yaw at the start, rad.
    pub initial_yaw: f64,
    /// (v_y, r, δ, a_φ) at the start. Before the start the command was what holds δ.
    pub initial_states: [f64; 4],
    pub(super) started: NonlinearParameters,
    pub(super) constants: Constants,
    pub(super) pose: Pose,
    /// v_y, r, a_φ.
    pub(super) lateral: Lateral,
    /// δ of the actuator, rad.
    pub(super) angle: f64,
    /// δ behind the play, rad.
    pub(super) wheel: f64,
    /// v_x that the load has followed, m/s; `None` before the first step, whose speed the vehicle has had before.
    pub(super) followed_speed: Option<f64>,
    pub(super) delay: DelayLine,
}

impl NonlinearVehicle {
    /// A vehicle at the origin, at 15 m/s, driving straight, started.
    ///
    /// # Errors
    /// Where the parameters are not those of a vehicle.
    pub fn new(parameters: NonlinearParameters) -> Result<Self, Error> {
        parameters.check()?;
        Ok(Self {
            parameters,
            steering_angle: 0.0,
            steering_slope: 0.0,
            speed: 15.0,
            crosswind: 0.0,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            initial_states: [0.0; 4],
            started: parameters,
            constants: Constants::new(&parameters),
            pose: Pose::default(),
            lateral: [0.0; 3],
            angle: 0.0,
            wheel: 0.0,
            followed_speed: None,
            delay: DelayLine::new(parameters.actuator.delay_s, 0.0),
        })
    }

    /// Takes over the parameters and puts the vehicle at its initial pose and states.
    ///
    /// # Errors
    /// Where the parameters are not those of a vehicle, or a state cannot be.
    pub fn start(&mut self) -> Result<(), Error> {
        if self.started != self.parameters {
            self.parameters.check()?;
            self.started = self.parameters;
            self.constants = Constants::new(&self.parameters);
            self.delay = DelayLine::new(self.started.actuator.delay_s, 0.0);
        }
        let [lateral_velocity, yaw_rate, angle, roll] = self.initial_states;
        numbers(&[
            ("the lateral velocity", lateral_velocity),
            ("the yaw rate", yaw_rate),
            ("the lateral acceleration that the load has followed", roll),
        ])?;
        let stop = self.started.actuator.road_wheel_angle_max_rad;
        within("the road-wheel angle at the start", angle, -stop, stop)?;
        self.pose = Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw };
        self.lateral = [lateral_velocity, yaw_rate, roll];
        (self.angle, self.wheel) = (angle, angle);
        self.followed_speed = None;
        self.delay.reset(angle * self.started.actuator.steering_ratio);
        Ok(())
    }

    /// Advances by `h` seconds with the inputs as they are, the steering angle growing by its slope.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]], or takes more than ten million panels, or the
    /// steering angle or the states grow beyond all numbers.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        let rate = self.constants.fastest_rate(self.speed);
        let longest = Longest::new(rate, self.constants.actuator.time_constant);
        let limit = LONGEST_STEP.min(MOST_PANELS * longest.fourth);
        if !(h > 0.0 && h <= limit) {
            return Err(Error::Step { step: h, limit });
        }
        numbers(&[("the crosswind", self.crosswind)])?;
        self.delay.push(h, self.steering_angle, self.steering_slope)?;
        self.followed_speed.get_or_insert(self.speed);
        let mut left = h;
        while left > 0.0 {
            let piece = self.delay.next(left);
            left -= piece.duration;
            self.follow(piece, rate)?;
        }
        let [lateral_velocity, yaw_rate, roll] = self.lateral;
        diverged([
            ("the lateral velocity", lateral_velocity),
            ("the yaw rate", yaw_rate),
            ("the lateral acceleration that the load has followed", roll),
            ("yaw", self.pose.yaw),
            ("x", self.pose.x),
            ("y", self.pose.y),
        ])
    }

    /// Moves under a command that is one line, in steering coordinates.
    fn follow(&mut self, command: Segment, rate: f64) -> Result<(), Error> {
        let constants = self.constants;
        let (n, actuator) = (constants.n, constants.actuator);
        let half_gap = 0.5 * self.started.actuator.play_rad;
        let at_wheel = Segment { value: command.value * n, slope: command.slope * n, ..command };
        // A steering ratio near zero makes any angle infinite; what follows divides by neither.
        numbers(&[
            ("the steering at the road wheel", at_wheel.value),
            ("the steering's rate at the road wheel", at_wheel.slope * actuator.time_constant),
        ])?;
        let lines = actuator.within_stops(at_wheel);
        for line in lines.into_iter().filter(|line| line.duration > 0.0) {
            let motions = actuator.follow(self.angle, line);
            for motion in motions.iter().filter(|motion| motion.duration > 0.0) {
                let end = motion.angle_at(motion.duration, actuator.time_constant);
                self.angle = end.clamp(-actuator.stop, actuator.stop);
                if half_gap == 0.0 {
                    self.advance(&constants, motion, rate);
                    self.wheel = self.angle;
                    continue;
                }
                let (parts, wheel) =
                    play::follow(half_gap, self.wheel, motion, actuator.time_constant);
                for part in parts.iter().filter(|part| part.duration > 0.0) {
                    self.advance(&constants, part, rate);
                }
                self.wheel = within_play(wheel, self.angle, half_gap);
            }
        }
        Ok(())
    }

    /// Moves along a motion of the road wheels, with panels that resolve modes as fast as `rate`, 1/s.
    fn advance(&mut self, constants: &Constants, wheels: &Motion, rate: f64) {
        let dynamics = constants.at_speed(self.speed, self.crosswind);
        let along = self.followed_acceleration();
        dynamics.advance(&mut self.lateral, &mut self.pose, wheels, along, rate);
        if along != 0.0 {
            let fade = (-wheels.duration * constants.roll).exp();
            let followed = self.followed_speed.unwrap_or(self.speed);
            self.followed_speed = Some(self.speed + (followed - self.speed) * fade);
        }
    }

    /// Longitudinal acceleration that the load has followed, m/s².
    fn followed_acceleration(&self) -> f64 {
        let followed = self.followed_speed.unwrap_or(self.speed);
        (self.speed - followed) * self.constants.roll
    }

    /// Yaw rate r, rad/s.
    #[must_use]
    pub fn yaw_rate(&self) -> f64 {
        self.lateral[1]
    }

    pose_getters!();

    /// Lateral velocity v_y of the centre of gravity, m/s.
    #[must_use]
    pub fn lateral_velocity(&self) -> f64 {
        self.lateral[0]
    }

    /// Lateral acceleration of the centre of gravity, `v̇_y + v·r`, m/s², at the present speed.
    #[must_use]
    pub fn lateral_acceleration(&self) -> f64 {
        self.rates().1
    }

    /// Road-wheel angle behind actuator and play, rad.
    #[must_use]
    pub fn road_wheel_angle(&self) -> f64 {
        self.wheel
    }

    /// (v_y, r, δ, a_φ), δ before the play.
    #[must_use]
    pub fn states(&self) -> [f64; 4] {
        let [vy, r, roll] = self.lateral;
        [vy, r, self.angle, roll]
    }

    /// Puts one of (v_y, r, δ, a_φ), from 0, where it is wanted, in the middle of a drive.
    pub fn set_state(&mut self, index: usize, value: f64) {
        let [vy, r, roll] = &mut self.lateral;
        if let Some(state) = [vy, r, &mut self.angle, roll].into_iter().nth(index) {
            *state = value;
        }
        self.wheel = within_play(self.wheel, self.angle, 0.5 * self.started.actuator.play_rad);
    }

    /// Their derivatives by time, at the present inputs.
    #[must_use]
    pub fn derivatives(&self) -> [f64; 4] {
        let ([vy, r, roll], _) = self.rates();
        let (command, _) = self.delay.output(self.steering_angle, self.steering_slope);
        [vy, r, self.constants.actuator.rate_of(self.angle, command * self.constants.n), roll]
    }

    fn rates(&self) -> (Lateral, f64) {
        let along = self.constants.along(self.followed_acceleration());
        let dynamics = self.constants.at_speed(self.speed, self.crosswind);
        dynamics.rates(&self.lateral, &RoadWheel::from_angle(self.wheel), &along)
    }

    /// Derivatives by time of yaw and position: ψ̇, Ẋ, Ẏ.
    #[must_use]
    pub fn pose_derivatives(&self) -> [f64; 3] {
        let (sin, cos) = sin_cos(self.pose.yaw);
        let [vy, r, _] = self.lateral;
        [r, self.speed * cos - vy * sin, self.speed * sin + vy * cos]
    }

    /// Derivative by time of the lateral acceleration, m/s³, at the present inputs: a central
    /// difference along the motion, good to about nine digits.
    #[must_use]
    pub fn lateral_acceleration_derivative(&self) -> f64 {
        let [vy, r, angle, roll] = self.derivatives();
        // Within the gap the wheels stand still.
        let gap = 0.5 * self.started.actuator.play_rad - EDGE;
        let is_taken_along = (self.angle - self.wheel) * angle.signum() >= gap;
        let wheel = if is_taken_along { angle } else { 0.0 };
        let dynamics = self.constants.at_speed(self.speed, self.crosswind);
        let at = |time: f64| {
            let [y, yaw, a] = self.lateral;
            let s = [y + time * vy, yaw + time * r, a + time * roll];
            let along = self.followed_acceleration() * (1.0 - time * self.constants.roll);
            let along = self.constants.along(along);
            dynamics.rates(&s, &RoadWheel::from_angle(self.wheel + time * wheel), &along).1
        };
        let time = 1e-5;
        (at(time) - at(-time)) / (2.0 * time)
    }
}
