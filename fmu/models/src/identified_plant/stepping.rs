//! Advancing the identified plant: pieces between grid points and breakpoints of the delayed input.

use super::IdentifiedPlant;
use crate::Error;
use crate::delay::Segment;
use crate::error::diverged;
use crate::linear::Outputs;
use crate::quadrature::{NODES, Pose, mean_aside, mean_direction, mean_direction_of_arc};
use crate::sideslip::Sideslip;
use crate::trigonometry::sin_cos;

/// Longest communication step, s.
pub const LONGEST_STEP: f64 = 3600.0;

/// Most grid points in a step: about a second of computing.
const MOST_GRID_POINTS: f64 = 1e7;

impl IdentifiedPlant {
    /// Advances by `h` seconds with the inputs as they are.
    ///
    /// # Errors
    /// Where h is not in (0, [`LONGEST_STEP`]] or spans more grid points than can be walked, or
    /// the states grow beyond all numbers.
    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        if !(h > 0.0 && h <= LONGEST_STEP) {
            return Err(Error::Step { step: h, limit: LONGEST_STEP });
        }
        let u = self.model.input(self.steering_angle, self.speed);
        let slope = self.steering_rate * self.model.input_by_steering(self.speed);
        if self.on_grid {
            let points = h / self.model.data().sample_time;
            if points > MOST_GRID_POINTS {
                return Err(Error::TooManyGridPoints { step: h, points, limit: MOST_GRID_POINTS });
            }
            self.delay.push(h, u, slope)?;
            self.walk_grid(h, points);
        } else if self.model.data().delay > 0.0 {
            self.delay.push(h, u, slope)?;
            self.walk(h);
        } else {
            self.move_exactly(&Segment { duration: h, value: u, slope });
        }
        self.check_finite()
    }

    /// Refuses to go on from states beyond all numbers.
    #[inline]
    fn check_finite(&self) -> Result<(), Error> {
        let Pose { x, y, yaw } = self.pose;
        let sum: f64 = self.states().iter().sum();
        // One test instead of one for each; a sum of finite numbers may overflow too.
        if (sum + x + y + yaw).is_finite() {
            return Ok(());
        }
        let states = self.states().iter().map(|&x| ("a state of the model", x));
        diverged(states.chain([("yaw", yaw), ("x", x), ("y", y)]))
    }

    /// A step of so many grid intervals, split at the grid points in it.
    fn walk_grid(&mut self, h: f64, points: f64) {
        let ts = self.model.data().sample_time;
        let to_first = (1.0 - self.grid.phase()) * ts;
        let at_start = self.grid.phase() == 0.0;
        let count = self.grid.advance(points);
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

    /// A time interval within one grid interval, which it begins or not.
    fn walk_from(&mut self, length: f64, begins_interval: bool) {
        if begins_interval && self.model.continuous().is_none() {
            let u = self.delay.here();
            self.input = u;
            self.held = self.output(u);
        }
        self.walk(length);
    }

    /// At a grid point: the states move (without continuous form), the innovation of the interval
    /// that ends acts on them, the next one is drawn.
    fn grid_point(&mut self) {
        let data = self.model.data();
        let n = self.model.order();
        if self.model.continuous().is_none() {
            for (i, next) in self.next.iter_mut().enumerate() {
                let row = data.a[i * n..(i + 1) * n].iter();
                let ax: f64 = row.zip(&self.states).map(|(a, x)| a * x).sum();
                *next = ax + data.b[i] * self.input;
            }
            std::mem::swap(&mut self.states, &mut self.next);
        }
        for (x, k) in self.states.iter_mut().zip(&data.k) {
            *x += k * self.innovation;
        }
        self.draw();
    }

    /// A time interval without grid points, split where the delayed input changes.
    #[inline]
    fn walk(&mut self, length: f64) {
        let mut left = length;
        while left > 0.0 {
            let piece = self.delay.next(left);
            if self.model.continuous().is_some() {
                self.move_exactly(&piece);
            } else {
                self.move_held(piece.duration);
            }
            left -= piece.duration;
        }
    }

    /// A piece whose input is held or one ramp, by the matrix exponential.
    #[inline]
    fn move_exactly(&mut self, piece: &Segment) {
        let Some(model) = self.model.continuous() else { return };
        let map = self.cache.get(model, piece.duration, self.model.longest_panel());
        let distance = self.speed * map.panel();
        let sideslip = self.model.data().sideslip.at_speed(self.speed);
        let slip = self.speed * sideslip.per_yaw_rate;
        let beyond = sideslip.growth != 0.0 || sideslip.per_yaw_acceleration != 0.0;
        for panel in 0..map.panels() {
            let u = piece.value + piece.slope * (panel as f64 * map.panel());
            let direction = sin_cos(self.pose.yaw);
            let outputs =
                if beyond { Some(map.outputs(&self.states, u, piece.slope)) } else { None };
            let turned = map.advance(&mut self.states, u, piece.slope);
            let (along, across) = mean_direction(&turned.at_nodes);
            let [ahead, aside] = slipped(slip, turned.end);
            let (mut along, mut across) = (distance * along + ahead, distance * across + aside);
            if let Some(outputs) = outputs {
                let slips = slips_beyond(&sideslip, self.speed, &outputs);
                let [ahead, aside] = mean_aside(&slips, &turned.at_nodes);
                along += distance * ahead;
                across += distance * aside;
            }
            self.pose.advance_by(direction, along, across, turned.end);
        }
    }

    /// A piece with the output held: an arc.
    #[inline]
    fn move_held(&mut self, piece: f64) {
        let turn = self.held * piece;
        let (along, across) = mean_direction_of_arc(turn);
        let distance = self.speed * piece;
        let sideslip = self.model.data().sideslip.at_speed(self.speed);
        let slip = self.speed * sideslip.in_turn(self.speed * self.held);
        let [ahead, aside] = slipped(slip, turn);
        self.pose.advance(distance * along + ahead, distance * across + aside, turn);
    }
}

/// The sideslip beyond S·r at the nodes of a panel: Q·a²·r + C·ṙ, at the speed (m/s) of the law.
fn slips_beyond(sideslip: &Sideslip, speed: f64, outputs: &Outputs) -> [f64; NODES] {
    let beyond = Sideslip { per_yaw_rate: 0.0, ..*sideslip };
    std::array::from_fn(|i| {
        let rate = outputs.value[i];
        beyond.in_turn(speed * rate) * rate + beyond.per_yaw_acceleration * outputs.rate[i]
    })
}

/// What a lateral velocity of `slip·ψ̇` (slip in m) adds to the way while the yaw turns by `turn`, in
/// the vehicle's axes at the beginning: exactly `slip·(cos turn − 1, sin turn)`, however it turns.
#[inline]
fn slipped(slip: f64, turn: f64) -> [f64; 2] {
    if slip == 0.0 {
        return [0.0, 0.0];
    }
    let (s, c) = mean_direction_of_arc(turn);
    [-slip * turn * c, slip * turn * s]
}
