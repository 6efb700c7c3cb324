//! Runge–Kutta methods along the actuator's motion, in equal panels: the classical one of order four, and
//! that of order six in seven stages of Butcher (1964); see `docs/methods/nonlinear.md`.
//!
//! Where the panels of order six would be no longer than those of order four, order four is taken. The
//! road-wheel angle enters in closed form ([`super::actuator`]) and is smooth within a panel, so the order
//! holds whatever the limits do, with one exception, a panel in which a wheel lifts or touches down: it is
//! done again by order four. Position and yaw are states as the others.

use super::actuator::Motion;
use super::dynamics::{Along, Dynamics, Lateral, RoadWheel};
use crate::quadrature::{Pose, panels};
use crate::trigonometry::sin_cos_small;

/// Longest panels of the two methods, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Longest {
    pub(super) fourth: f64,
    pub(super) sixth: f64,
}

/// Time constants after which a swing of the actuator is so small that panels of twice the length resolve it as well: of the
/// method of order four, which such short panels take, and which then errs 16 times as much.
const SWING: f64 = 2.8;

impl Longest {
    /// Those that resolve modes as fast as `rate` (1/s), and an actuator.
    pub(super) fn new(rate: f64, actuator_time_constant: f64) -> Self {
        Self { fourth: 0.002_f64.min(0.1 / rate), sixth: 0.010_f64.min(0.2 / rate) }
            .at_most(0.25 * actuator_time_constant)
    }

    fn at_most(self, length: f64) -> Self {
        Self { fourth: self.fourth.min(length), sixth: self.sixth.min(length) }
    }
}

/// An explicit method of N stages.
struct Method<const N: usize> {
    /// At each stage, the weights of the stages before it.
    stages: [[f64; N]; N],
    /// Weights of the stages in the whole panel.
    panel: [f64; N],
    /// Where the stages are, by their indices in [`NODES`].
    nodes: [usize; N],
}

/// Shares of a panel at which a method has stages.
const NODES: [f64; 5] = [0.0, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.0];

const FOURTH: Method<4> = Method {
    stages: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    panel: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    nodes: [0, 2, 2, 4],
};

const SIXTH: Method<7> = Method {
    stages: [
        [0.0; 7],
        [1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 2.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0 / 12.0, 1.0 / 3.0, -1.0 / 12.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / 16.0, 9.0 / 8.0, -3.0 / 16.0, -3.0 / 8.0, 0.0, 0.0, 0.0],
        [0.0, 9.0 / 8.0, -3.0 / 8.0, -3.0 / 4.0, 0.5, 0.0, 0.0],
        [9.0 / 44.0, -9.0 / 11.0, 63.0 / 44.0, 18.0 / 11.0, 0.0, -16.0 / 11.0, 0.0],
    ],
    panel: [11.0 / 120.0, 0.0, 27.0 / 40.0, 27.0 / 40.0, -4.0 / 15.0, -4.0 / 15.0, 11.0 / 120.0],
    nodes: [0, 1, 3, 1, 2, 2, 4],
};

/// What is known at the [`NODES`] of a panel.
struct Nodes {
    /// δ, rad.
    angles: [f64; 5],
    /// What driving and braking do to the axles.
    along: [Along; 5],
}

/// e^{−x} at the [`NODES`] of a panel that lasts `panel` time constants; 0 where nothing decays.
#[inline]
fn decays(start: f64, panel: f64) -> [f64; 5] {
    if start == 0.0 {
        return [0.0; 5];
    }
    let (third, half) = ((-panel / 3.0).exp(), (-panel / 2.0).exp());
    [1.0, third, half, third * third, half * half]
}

impl Dynamics<'_> {
    /// Moves along a motion of the road wheel, from a longitudinal acceleration that the load has followed. What is left of a
    /// swing that fades within the motion takes longer and longer panels, at most those of a `rate`, 1/s.
    pub(super) fn advance(
        &self,
        s: &mut Lateral,
        pose: &mut Pose,
        motion: &Motion,
        mut along: f64,
        rate: f64,
    ) {
        let time_constant = self.constants.actuator.time_constant;
        let mut longest = Longest::new(rate, time_constant);
        let slowest = Longest::new(rate, f64::INFINITY);
        let (mut length, part_s) = (0.25 * time_constant, SWING * time_constant);
        let mut left = *motion;
        while left.swing != 0.0 && length < slowest.sixth && left.duration > part_s {
            self.in_equal_panels(s, pose, &Motion { duration: part_s, ..left }, along, &longest);
            along *= (-part_s * self.constants.roll).exp();
            left.duration -= part_s;
            left.start += left.slope * part_s;
            left.swing *= (-SWING).exp();
            length *= 2.0;
            longest = slowest.at_most(length);
        }
        self.in_equal_panels(s, pose, &left, along, &longest);
    }

    fn in_equal_panels(
        &self,
        s: &mut Lateral,
        pose: &mut Pose,
        motion: &Motion,
        along: f64,
        longest: &Longest,
    ) {
        let (count, panel) = panels(motion.duration, longest.sixth);
        if panel <= longest.fourth {
            return self.by_order_four(s, pose, motion, along, longest);
        }
        self.in_panels(motion, along, (count, panel), |part, along, nodes| {
            let (after, moved, smooth) = self.panel(&SIXTH, s, pose, panel, nodes);
            if smooth {
                (*s, *pose) = (after, moved);
            } else {
                self.by_order_four(s, pose, part, along, longest);
            }
        });
    }

    fn by_order_four(
        &self,
        s: &mut Lateral,
        pose: &mut Pose,
        motion: &Motion,
        along: f64,
        longest: &Longest,
    ) {
        let (count, panel) = panels(motion.duration, longest.fourth);
        self.in_panels(motion, along, (count, panel), |_, _, nodes| {
            (*s, *pose, _) = self.panel(&FOURTH, s, pose, panel, nodes);
        });
    }

    /// Calls `advance` with each panel of a motion: its part of the motion, the longitudinal acceleration that the load has
    /// followed at its start, and what is known at the [`NODES`].
    #[inline]
    fn in_panels(
        &self,
        motion: &Motion,
        mut along: f64,
        (count, panel): (u64, f64),
        mut advance: impl FnMut(&Motion, f64, &Nodes),
    ) {
        let swings = decays(motion.swing, panel / self.constants.actuator.time_constant);
        let fades = decays(along, panel * self.constants.roll);
        let mut part = Motion { duration: panel, ..*motion };
        for _ in 0..count {
            let nodes = Nodes {
                angles: std::array::from_fn(|i| {
                    part.start + part.slope * (NODES[i] * panel) + part.swing * swings[i]
                }),
                along: fades.map(|fade| self.constants.along(along * fade)),
            };
            advance(&part, along, &nodes);
            part.start += part.slope * panel;
            part.swing *= swings[4];
            along *= fades[4];
        }
    }

    /// One panel: states and pose at its end, and whether no wheel lifts or lands.
    #[inline]
    fn panel<const N: usize>(
        &self,
        method: &Method<N>,
        s: &Lateral,
        pose: &Pose,
        h: f64,
        Nodes { angles, along }: &Nodes,
    ) -> (Lateral, Pose, bool) {
        let (sin, cos) = sin_cos_small(angles);
        // Yaw, `turned`, is counted from the panel's start.
        let (mut states, mut turned, mut rates) = ([*s; N], [0.0; N], [[0.0; 3]; N]);
        for stage in 0..N {
            for before in 0..stage {
                let weight = method.stages[stage][before];
                // What is constant here is not multiplied by.
                if weight != 0.0 {
                    turned[stage] += weight * h * states[before][1];
                    for i in 0..3 {
                        states[stage][i] += weight * h * rates[before][i];
                    }
                }
            }
            let node = method.nodes[stage];
            let wheel = RoadWheel { angle: angles[node], sin: sin[node], cos: cos[node] };
            rates[stage] = self.rates(&states[stage], &wheel, &along[node]).0;
        }
        let (sin, cos) = sin_cos_small(&turned);
        let (mut after, mut ahead, mut aside, mut yaw) = (*s, 0.0, 0.0, 0.0);
        for stage in 0..N {
            let weight = method.panel[stage] * h;
            let [vy, r, _] = states[stage];
            ahead += weight * (self.speed * cos[stage] - vy * sin[stage]);
            aside += weight * (self.speed * sin[stage] + vy * cos[stage]);
            yaw += weight * r;
            for i in 0..3 {
                after[i] += weight * rates[stage][i];
            }
        }
        let mut moved = *pose;
        moved.advance(ahead, aside, yaw);
        let lifted = self.lifted(s, &along[0]);
        let at_stage = |stage: usize| self.lifted(&states[stage], &along[method.nodes[stage]]);
        let smooth = self.lifted(&after, &along[4]) == lifted
            && (0..N).all(|stage| at_stage(stage) == lifted);
        (after, moved, smooth)
    }
}
