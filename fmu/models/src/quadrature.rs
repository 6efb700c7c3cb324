//! Position from yaw: Gauss–Legendre quadrature of `ẋ = v cos ψ`, `ẏ = v sin ψ` over a panel.
//!
//! A panel is at most [`LONGEST_PANEL`] long. Four nodes integrate polynomials up to degree 7; the
//! error is `5.6e-10·p⁹·f⁽⁸⁾`, which for a car (yaw rate up to 2 rad/s, modes up to 100 1/s,
//! 50 m/s) stays below 1e-12 m a panel. Yaw at the nodes is given as its deviation from the yaw at
//! the panel's start, so that one sine and cosine of the large angle serve all nodes.

use crate::Error;
use crate::error::finite;
use crate::trigonometry::{sin_cos, sin_cos_small};
use serde::{Deserialize, Serialize};

/// Longest panel, s.
pub const LONGEST_PANEL: f64 = 0.010;

/// Nodes of a panel.
pub const NODES: usize = 4;

/// The nodes on (0, 1).
pub const NODE: [f64; NODES] = [
    0.069_431_844_202_973_71,
    0.330_009_478_207_571_87,
    0.669_990_521_792_428_1,
    0.930_568_155_797_026_3,
];

/// Their weights; the sum is 1.
pub const WEIGHT: [f64; NODES] = [
    0.173_927_422_568_726_92,
    0.326_072_577_431_273_05,
    0.326_072_577_431_273_05,
    0.173_927_422_568_726_92,
];

/// How a step is cut into equal panels: how many, and how long each is. `longest` is at most
/// [`LONGEST_PANEL`], less where the model has fast modes.
#[must_use]
pub fn panels(step: f64, longest: f64) -> (u64, f64) {
    // The slack keeps a step that is a hair above 10 ms from costing two panels.
    let ratio = step / longest - 1e-6;
    if ratio <= 1.0 {
        return (1, step);
    }
    let count = ratio.ceil();
    (count as u64, step / count)
}

/// Mean of (cos, sin) of the deviations over a panel: the direction of travel as seen from its start.
#[inline]
#[must_use]
pub fn mean_direction(deviations: &[f64; NODES]) -> (f64, f64) {
    let (sin, cos) = sin_cos_small(deviations);
    (mean(&cos), mean(&sin))
}

/// Mean over a panel of so much to the left of the direction of travel, seen from the panel's start:
/// `(−sin, cos)` of the deviations, times the amounts.
#[inline]
#[must_use]
pub fn mean_aside(amounts: &[f64; NODES], deviations: &[f64; NODES]) -> [f64; 2] {
    let (sin, cos) = sin_cos_small(deviations);
    let times = |direction: &[f64; NODES]| std::array::from_fn(|i| amounts[i] * direction[i]);
    [-mean(&times(&sin)), mean(&times(&cos))]
}

/// Mean over a panel of a function with these values at the nodes.
#[inline]
#[must_use]
pub fn mean(at: &[f64; NODES]) -> f64 {
    // The rule is symmetric.
    WEIGHT[0] * (at[0] + at[3]) + WEIGHT[1] * (at[1] + at[2])
}

/// Coefficients of `sin t/t` and `(1 − cos t)/t²` by t².
const ARC: [[f64; 2]; 5] = [
    [1.0, 1.0 / 2.0],
    [-1.0 / 6.0, -1.0 / 24.0],
    [1.0 / 120.0, 1.0 / 720.0],
    [-1.0 / 5040.0, -1.0 / 40_320.0],
    [1.0 / 362_880.0, 1.0 / 3_628_800.0],
];

/// [`mean_direction`] over an arc that turns evenly, by `turn` in all: `(sin t/t, (1 − cos t)/t)`.
#[inline]
#[must_use]
pub fn mean_direction_of_arc(turn: f64) -> (f64, f64) {
    if turn.abs() <= 0.125 {
        let q = turn * turn;
        let mut sum = ARC[4];
        for coefficients in ARC[..4].iter().rev() {
            sum = [sum[0] * q + coefficients[0], sum[1] * q + coefficients[1]];
        }
        return (sum[0], sum[1] * turn);
    }
    let (sin, cos) = sin_cos(turn);
    (sin / turn, (1.0 - cos) / turn)
}

/// Where a vehicle is and where it points.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// Position of the centre of gravity, m.
    pub x: f64,
    /// Position of the centre of gravity, m.
    pub y: f64,
    /// Yaw, rad, not wrapped.
    pub yaw: f64,
}

/// The getters of a plant that has a `pose`.
macro_rules! pose_getters {
    () => {
        /// Yaw ψ, rad, not wrapped.
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
    };
}
pub(crate) use pose_getters;

impl Pose {
    /// Moves by a displacement in the vehicle's own axes at the panel's start, then turns.
    #[inline]
    pub fn advance(&mut self, along: f64, across: f64, yaw_increment: f64) {
        self.advance_by(sin_cos(self.yaw), along, across, yaw_increment);
    }

    /// [`Self::advance`] with sine and cosine of the yaw, which can be had before the displacement.
    #[inline]
    pub fn advance_by(
        &mut self,
        (sin, cos): (f64, f64),
        along: f64,
        across: f64,
        yaw_increment: f64,
    ) {
        self.x += along * cos - across * sin;
        self.y += along * sin + across * cos;
        self.yaw += yaw_increment;
    }

    /// Refuses a pose that is not finite.
    ///
    /// # Errors
    /// Names the value.
    pub fn check(&self) -> Result<(), Error> {
        finite("x", &[self.x])?;
        finite("y", &[self.y])?;
        finite("yaw", &[self.yaw])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_is_exact_up_to_degree_seven_and_no_further() {
        let integral = |degree: i32| -> f64 {
            NODE.iter().zip(WEIGHT).map(|(x, w)| w * x.powi(degree)).sum::<f64>()
                - 1.0 / f64::from(degree + 1)
        };
        for degree in 0..=7 {
            assert!(integral(degree).abs() < 1e-16, "degree {degree}: {}", integral(degree));
        }
        assert!(integral(8).abs() > 1e-6);
    }

    /// Against the quadrature where it is good, and by where the arc leads.
    #[test]
    fn arcs() {
        for k in -100..=100 {
            let turn = f64::from(k) * 1e-3;
            let (along, across) = mean_direction_of_arc(turn);
            let (a, b) = mean_direction(&NODE.map(|s| s * turn));
            assert!((along - a).abs() < 5e-16 && (across - b).abs() < 5e-16, "{turn}");
        }
        for turn in [-700.0, -2.5, 0.12, 0.13, 0.3, 7.0] {
            let (along, across) = mean_direction_of_arc(turn);
            // The chord has the length 2·sin(t/2)/t and points along t/2.
            let chord = 2.0 * (0.5 * turn).sin() / turn;
            assert!((along - chord * (0.5 * turn).cos()).abs() < 1e-15, "{turn}");
            assert!((across - chord * (0.5 * turn).sin()).abs() < 1e-15, "{turn}");
        }
        assert_eq!(mean_direction_of_arc(0.0), (1.0, 0.0));
    }

    #[test]
    fn panels_cover_the_step() {
        assert_eq!(panels(0.01, LONGEST_PANEL), (1, 0.01));
        assert_eq!(panels(0.003, LONGEST_PANEL), (1, 0.003));
        let (count, panel) = panels(1.0 / 60.0, LONGEST_PANEL);
        assert_eq!(count, 2);
        assert!((panel - 1.0 / 120.0).abs() < 1e-18);
    }
}
