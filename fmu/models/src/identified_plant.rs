//! The identified plant: steering angle and speed in, yaw rate, yaw and position out.
//!
//! Between the importer's steps the steering angle and speed are held. Within a step
//!
//! ```text
//! ẋ = F x + G u,   r = H x + D u + yaw_rate_offset          (eq 6–7)
//! ψ̇ = r            exactly, the integral is part of the matrix exponential
//! X' = v cos ψ,  Y' = v sin ψ                               (Gauss–Legendre, to 1e-9 m)
//! ```
//!
//! with u the model's input `delay` seconds ago: a step is split where that delayed input changes.
//! Before the start the input was zero, which is where the states, that start at zero, are at
//! rest. Speed moves X and Y alone (and drives the model where it was identified with
//! [`InputKind::SteeringTimesSpeed`](crate::identified::InputKind::SteeringTimesSpeed)).
//!
//! **Noise**, where `noise_scale > 0`, is that of eq 3–4 on the model's own grid `t0 + k·Ts`: e(k)
//! stands on the yaw rate from grid point k until the next, where the state jumps by K·e(k), both
//! times `noise_scale`. At grid points this is eq 3–4 to the letter, whatever steps the importer
//! takes. Yaw integrates the output without e: e is the sensor's part.
//!
//! **Without continuous form** (A has no real logarithm) the states move on the grid by A and B,
//! with the input as it is at the grid point; the output is held between, and yaw integrates what
//! is held.

use crate::delay::DelayLine;
use crate::error::Error;
use crate::identified::IdentifiedModel;
use crate::linear::{INTEGRALS, StepCache};
use crate::noise::gaussian;
use crate::quadrature::{NODE, NODES, Pose, mean_direction, panels};
use crate::ticks::Ticks;
use std::sync::Arc;

/// Longest communication step, s.
pub const LONGEST_STEP: f64 = 3600.0;

/// How far the speed may be from that of the identification, relative to it.
const SPEED_RANGE: f64 = 0.2;

/// A plant that moves by an [`IdentifiedModel`]. Its clone is its whole state.
#[derive(Debug, Clone)]
pub struct IdentifiedPlant {
    /// Input: steering angle, rad.
    pub steering_angle: f64,
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
    /// States, input, 1.
    z: Vec<f64>,
    /// What a panel's map yields; the states at the next grid point.
    out: Vec<f64>,
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
            speed: data.speed,
            initial_x: 0.0,
            initial_y: 0.0,
            initial_yaw: 0.0,
            noise_scale: 0.0,
            noise_seed: 0,
            pose: Pose::default(),
            z: vec![0.0; n + 2],
            out: vec![0.0; INTEGRALS + n],
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

    /// Puts the plant at its initial pose with all states zero.
    pub fn start(&mut self) {
        let n = self.model.order();
        self.pose = Pose { x: self.initial_x, y: self.initial_y, yaw: self.initial_yaw };
        self.z.fill(0.0);
        self.z[n + 1] = 1.0;
        self.delay.reset(0.0);
        self.grid = Ticks::new();
        self.scale = self.noise_scale * self.model.data().innovation_std;
        self.seed = self.noise_seed;
        self.on_grid = self.scale != 0.0 || self.model.continuous().is_none();
        self.drawn = 0;
        self.draw();
    }

    /// Advances by `h` seconds with the inputs as they are.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]], or the states grow beyond all numbers.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        if !(h > 0.0 && h <= LONGEST_STEP) {
            return Err(Error::Step { step: h, limit: LONGEST_STEP });
        }
        let u = self.model.input(self.steering_angle, self.speed);
        self.delay.push(h, u);
        if self.on_grid {
            self.walk_grid(h)
        } else {
            self.walk(h)
        }
        if self.pose.x.is_finite() && self.pose.y.is_finite() {
            Ok(())
        } else {
            Err(Error::Diverged { name: "yaw", value: self.pose.yaw })
        }
    }

    /// Yaw rate, rad/s, with the noise.
    #[inline]
    #[must_use]
    pub fn yaw_rate(&self) -> f64 {
        let output = if self.model.continuous().is_none() && self.grid.phase() > 0.0 {
            self.held
        } else {
            let present = self.model.input(self.steering_angle, self.speed);
            self.output(self.delay.output(present))
        };
        output + self.innovation
    }

    /// Yaw, rad, not wrapped: the integral of the yaw rate without noise.
    #[inline]
    #[must_use]
    pub fn yaw(&self) -> f64 {
        self.pose.yaw
    }

    /// Position of the centre of gravity, m.
    #[inline]
    #[must_use]
    pub fn x(&self) -> f64 {
        self.pose.x
    }

    /// Position of the centre of gravity, m.
    #[inline]
    #[must_use]
    pub fn y(&self) -> f64 {
        self.pose.y
    }

    /// The model's states.
    #[must_use]
    pub fn states(&self) -> &[f64] {
        &self.z[..self.model.order()]
    }

    /// Whether the speed is more than 20 % off that of the identification: worth one warning.
    #[must_use]
    pub fn speed_far_from_identified(&self) -> bool {
        let identified = self.model.data().speed;
        identified > 0.0 && (self.speed - identified).abs() > SPEED_RANGE * identified
    }

    /// Output without noise for an input.
    #[inline]
    fn output(&self, u: f64) -> f64 {
        let data = self.model.data();
        let cx: f64 = data.c.iter().zip(&self.z).map(|(c, x)| c * x).sum();
        cx + data.d * u + data.yaw_rate_offset
    }

    /// Draws e of the grid interval that begins.
    fn draw(&mut self) {
        self.innovation =
            if self.scale == 0.0 { 0.0 } else { self.scale * gaussian(self.seed, self.drawn) };
        self.drawn += 1;
    }

    /// A step split at the grid points in it.
    fn walk_grid(&mut self, h: f64) {
        let ts = self.model.data().sample_time;
        let to_first = (1.0 - self.grid.phase()) * ts;
        let at_start = self.grid.phase() == 0.0;
        let count = self.grid.advance(h / ts);
        let ends_on_grid = self.grid.phase() == 0.0;
        let mut left = h;
        for k in 1..=count {
            let length = if k == count && ends_on_grid {
                left
            } else {
                (if k == 1 { to_first } else { ts }).min(left)
            };
            self.walk_from(length, k > 1 || at_start);
            left -= length;
            self.grid_point();
        }
        if !ends_on_grid && left > 0.0 {
            self.walk_from(left, count > 0 || at_start);
        }
    }

    /// A stretch within one grid interval, which it begins or not.
    fn walk_from(&mut self, length: f64, begins_interval: bool) {
        if begins_interval && self.model.continuous().is_none() {
            let u = self.delay.output(self.model.input(self.steering_angle, self.speed));
            let n = self.model.order();
            self.z[n] = u;
            self.held = self.output(u);
        }
        self.walk(length);
    }

    /// At a grid point: the states move (without continuous form), the innovation of the interval
    /// that ends acts on them, the next one is drawn.
    fn grid_point(&mut self) {
        let data = self.model.data();
        let n = self.z.len() - 2;
        if self.model.continuous().is_none() {
            let u = self.z[n];
            for (i, next) in self.out[..n].iter_mut().enumerate() {
                let row = &data.a[i * n..(i + 1) * n];
                *next = row.iter().zip(&self.z).map(|(a, x)| a * x).sum::<f64>() + data.b[i] * u;
            }
            self.z[..n].copy_from_slice(&self.out[..n]);
        }
        for (x, k) in self.z.iter_mut().zip(&data.k) {
            *x += k * self.innovation;
        }
        self.draw();
    }

    /// A stretch without grid points, split where the delayed input changes.
    #[inline]
    fn walk(&mut self, length: f64) {
        let mut left = length;
        while left > 0.0 {
            let (piece, u) = self.delay.next(left);
            if self.model.continuous().is_some() {
                self.move_exactly(piece, u);
            } else {
                self.move_held(piece);
            }
            left -= piece;
        }
    }

    /// A piece with constant input, by the matrix exponential.
    #[inline]
    fn move_exactly(&mut self, piece: f64, u: f64) {
        let Some(model) = self.model.continuous() else { return };
        let n = self.z.len() - 2;
        let map = self.cache.get(model, piece, self.model.longest_panel());
        let distance = self.speed * map.panel();
        self.z[n] = u;
        for _ in 0..map.panels() {
            map.apply(&self.z, &mut self.out);
            let (integrals, states) = self.out.split_at(INTEGRALS);
            self.z[..n].copy_from_slice(states);
            let (along, across) =
                mean_direction(&[integrals[1], integrals[2], integrals[3], integrals[4]]);
            self.pose.advance(distance * along, distance * across, integrals[0]);
        }
    }

    /// A piece with the output held.
    fn move_held(&mut self, piece: f64) {
        let (count, panel) = panels(piece, self.model.longest_panel());
        let turn = self.held * panel;
        let mut deviations = [0.0; NODES];
        for (deviation, node) in deviations.iter_mut().zip(NODE) {
            *deviation = turn * node;
        }
        let (along, across) = mean_direction(&deviations);
        let distance = self.speed * panel;
        for _ in 0..count {
            self.pose.advance(distance * along, distance * across, turn);
        }
    }
}
