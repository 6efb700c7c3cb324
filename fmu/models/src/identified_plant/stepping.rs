//! Advancing the identified plant: pieces between grid points and breakpoints of the delayed input.

use super::IdentifiedPlant;
use crate::delay::Segment;
use crate::error::Error;
use crate::linear::INTEGRALS;
use crate::quadrature::{NODE, NODES, Pose, mean_direction, panels};

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
        if self.on_grid {
            let points = h / self.model.data().sample_time;
            if points > MOST_GRID_POINTS {
                return Err(Error::TooManyGridPoints { step: h, points, limit: MOST_GRID_POINTS });
            }
        }
        let u = self.model.input(self.steering_angle, self.speed);
        let slope = self.steering_rate * self.model.input_by_steering(self.speed);
        if self.on_grid {
            self.delay.push(h, u, slope)?;
            self.walk_grid(h);
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
        for (name, value) in states.chain([("yaw", yaw), ("x", x), ("y", y)]) {
            if !value.is_finite() {
                return Err(Error::Diverged { name, value });
            }
        }
        Ok(())
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
            let u = self.delay.here();
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
        let n = self.model.order();
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
        let n = self.z.len() - 3;
        let map = self.cache.get(model, piece.duration, self.model.longest_panel());
        let distance = self.speed * map.panel();
        let known = if piece.slope == 0.0 { n + 2 } else { n + 3 };
        self.z[n] = piece.value;
        self.z[n + 2] = piece.slope;
        for panel in 0..map.panels() {
            if panel > 0 {
                self.z[n] = piece.value + piece.slope * (panel as f64 * map.panel());
            }
            map.apply(&self.z[..known], &mut self.out);
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
