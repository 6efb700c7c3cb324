//! The identified plant: steering angle and speed in, yaw rate, yaw and position out.
//!
//! The equations are in the README of `fmu/identified-plant`. Yaw is part of the matrix exponential, so it
//! is exact; the position is Gauss–Legendre quadrature to 1e-9 m. What the sideslip term S(v) adds to it is
//! `v·S(v)` times the change of `(cos ψ, sin ψ)`, exactly; for Q and C, r and ṙ are those of the matrix
//! exponential at the quadrature's nodes. Where r jumps, or is held, C·ṙ adds nothing.
//!
//! The model's input is that of `delay` seconds ago: a step is split where it changes, and each piece is
//! one ramp, which the matrix exponential takes exactly. Before the start the input was zero, which is
//! where states that start at zero are at rest.
//!
//! Noise, where `noise_scale > 0`, is that of eq 3–4 on the model's own grid `t0 + k·Ts`: e(k) stands on
//! the yaw rate from grid point k until the next, where the state jumps by K·e(k), both times
//! `noise_scale`. Without continuous form (A has no real logarithm) the states move on the grid by A and
//! B, with the input as it is at the grid point; the output is held between, and yaw integrates it.

use crate::delay::DelayLine;
use crate::identified::IdentifiedModel;
use crate::linear::StepCache;
use crate::noise::gaussian;
use crate::quadrature::{Pose, pose_getters};
use crate::ticks::Ticks;
use std::sync::Arc;

mod saved;
mod sensitivity;
mod stepping;

pub use saved::SavedIdentifiedPlant;
pub use stepping::LONGEST_STEP;

/// How far the speed may be from that of the identification, relative to it.
const SPEED_RANGE: f64 = 0.2;

/// A plant that moves by an [`IdentifiedModel`]. Its clone is its whole state.
#[derive(Debug, Clone)]
pub struct IdentifiedPlant {
    /// Input: steering angle, rad, at the beginning of a step.
    pub steering_angle: f64,
    /// Its derivative within a step, rad/s; 0 holds it.
    pub steering_rate: f64,
    /// Input: speed, m/s.
    pub speed: f64,
    /// Position at the start, m.
    pub initial_x: f64,
    /// Position at the start, m.
    pub initial_y: f64,
    /// Yaw at the start, rad.
    pub initial_yaw: f64,
    /// Noise relative to the identified; 0 for none. Read at the start.
    pub noise_scale: f64,
    /// Names the noise sequence. Read at the start.
    pub noise_seed: i32,
    model: Arc<IdentifiedModel>,
    pose: Pose,
    states: Vec<f64>,
    /// The states at the next grid point, where there is no continuous form.
    next: Vec<f64>,
    /// The input of the present grid interval, where there is no continuous form.
    input: f64,
    /// States at the start.
    initial: Vec<f64>,
    delay: DelayLine,
    cache: StepCache,
    /// Where the time is on the grid; followed only where something happens on it.
    grid: Ticks,
    on_grid: bool,
    scale: f64,
    seed: i32,
    drawn: u64,
    /// e of the present grid interval, times the scale.
    innovation: f64,
    /// Noise-free output of the present grid interval, where there is no continuous form.
    held: f64,
}

impl IdentifiedPlant {
    /// A plant at the origin, at the speed of its identification, driving straight, started.
    #[must_use]
    pub fn new(model: Arc<IdentifiedModel>) -> Self {
        let data = model.data();
        let n = model.order();
        let mut plant = Self {
            steering_angle: data.steering_offset,
            steering_rate: 0.0,
            speed: data.speed,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            noise_scale: 0.0,
            noise_seed: 0,
            pose: Pose::default(),
            states: vec![0.0; n],
            next: vec![0.0; n],
            input: 0.0,
            initial: vec![0.0; n],
            delay: DelayLine::new(data.delay, 0.0),
            cache: StepCache::default(),
            grid: Ticks::new(),
            on_grid: false,
            scale: 0.0,
            seed: 0,
            drawn: 0,
            innovation: 0.0,
            held: 0.0,
            model,
        };
        plant.start();
        plant
    }

    /// The model it moves by.
    #[must_use]
    pub fn model(&self) -> &Arc<IdentifiedModel> {
        &self.model
    }

    /// Puts the plant at its initial pose, with its model in its initial states.
    pub fn start(&mut self) {
        self.pose = Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw };
        self.states.copy_from_slice(&self.initial);
        self.input = 0.0;
        self.delay.reset(0.0);
        self.grid = Ticks::new();
        self.scale = self.noise_scale * self.model.data().innovation_std;
        self.seed = self.noise_seed;
        self.on_grid = self.scale != 0.0 || self.model.continuous().is_none();
        self.drawn = 0;
        self.held = 0.0;
        self.draw();
    }

    /// Yaw rate, rad/s, with the noise.
    #[inline]
    #[must_use]
    pub fn yaw_rate(&self) -> f64 {
        self.noise_free_yaw_rate() + self.innovation
    }

    /// Yaw rate, rad/s, without the noise: the derivative of yaw.
    #[inline]
    #[must_use]
    pub fn noise_free_yaw_rate(&self) -> f64 {
        if self.is_held() { self.held } else { self.output(self.delayed_input().0) }
    }

    pose_getters!();

    /// The model's states.
    #[must_use]
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// The model's states at the start: all zero, unless changed. [`Self::start`] takes them over.
    #[must_use]
    pub fn initial_states_mut(&mut self) -> &mut [f64] {
        &mut self.initial
    }

    /// Whether the speed is more than 20 % off that of the identification: worth one warning.
    #[must_use]
    pub fn speed_far_from_identified(&self) -> bool {
        let identified = self.model.data().speed;
        identified > 0.0 && (self.speed - identified).abs() > SPEED_RANGE * identified
    }

    /// The model's input as of now and its derivative, after the delay.
    #[inline]
    fn delayed_input(&self) -> (f64, f64) {
        let present = self.model.input(self.steering_angle, self.speed);
        self.delay.output(present, self.steering_rate * self.model.input_by_steering(self.speed))
    }

    /// Output without noise for an input.
    #[inline]
    fn output(&self, u: f64) -> f64 {
        let data = self.model.data();
        let cx: f64 = data.c.iter().zip(&self.states).map(|(c, x)| c * x).sum();
        cx + data.d * u + data.yaw_rate_offset
    }

    /// Whether the output stays as it was at the last grid point.
    #[inline]
    fn is_held(&self) -> bool {
        self.model.continuous().is_none() && self.grid.phase() > 0.0
    }

    /// Draws e of the grid interval that begins.
    fn draw(&mut self) {
        self.innovation = self.innovation_at(self.drawn);
        self.drawn = self.drawn.wrapping_add(1);
    }

    fn innovation_at(&self, index: u64) -> f64 {
        if self.scale == 0.0 { 0.0 } else { self.scale * gaussian(self.seed, index) }
    }
}
