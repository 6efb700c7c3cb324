//! Position from yaw: Gauss–Legendre quadrature of `ẋ = v cos ψ`, `ẏ = v sin ψ` over a panel.
//!
//! A panel is at most [`LONGEST_PANEL`] long. Four nodes integrate polynomials up to degree 7; the
//! error is `5.6e-10·p⁹·f⁽⁸⁾`, which for a car (yaw rate up to 2 rad/s, modes up to 100 1/s,
//! 50 m/s) stays below 1e-12 m a panel. Yaw at the nodes is given as its deviation from the yaw at
//! the panel's start, so that one sine and cosine of the large angle serve all nodes.

use crate::error::{Error, finite};
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
    let count = (step / longest - 1e-6).ceil().max(1.0);
    if count == 1.0 { (1, step) } else { (count as u64, step / count) }
}

const S3: f64 = -1.0 / 6.0;
const S5: f64 = 1.0 / 120.0;
const S7: f64 = -1.0 / 5040.0;
const S9: f64 = 1.0 / 362_880.0;
const C2: f64 = -0.5;
const C4: f64 = 1.0 / 24.0;
const C6: f64 = -1.0 / 720.0;
const C8: f64 = 1.0 / 40_320.0;
const C10: f64 = -1.0 / 3_628_800.0;

/// Sine and cosine; by series where the angle is small, as it is within a panel.
#[inline]
#[must_use]
pub fn sin_cos_small(a: f64) -> (f64, f64) {
    if a.abs() > 0.125 {
        return a.sin_cos();
    }
    let q = a * a;
    // Coefficients, not nested quotients: a division costs ten multiplications.
    let sin = a + a * q * (S3 + q * (S5 + q * (S7 + q * S9)));
    let cos = 1.0 + q * (C2 + q * (C4 + q * (C6 + q * (C8 + q * C10))));
    (sin, cos)
}

/// Mean of (cos, sin) of the deviations over a panel: the direction of travel, seen from the
/// panel's start.
#[inline]
#[must_use]
pub fn mean_direction(deviations: &[f64; NODES]) -> (f64, f64) {
    let (mut along, mut across) = (0.0, 0.0);
    for (deviation, weight) in deviations.iter().zip(WEIGHT) {
        let (sin, cos) = sin_cos_small(*deviation);
        along += weight * cos;
        across += weight * sin;
    }
    (along, across)
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

impl Pose {
    /// Moves by a displacement in the vehicle's own axes at the panel's start, then turns.
    #[inline]
    pub fn advance(&mut self, along: f64, across: f64, yaw_increment: f64) {
        let (sin, cos) = self.yaw.sin_cos();
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

    #[test]
    fn small_angles_to_the_last_bit_but_one() {
        for k in -2000..=2000 {
            let a = f64::from(k) * 1e-4;
            let (s, c) = sin_cos_small(a);
            assert!((s - a.sin()).abs() < 1.2e-16 && (c - a.cos()).abs() < 2.3e-16, "{a}");
        }
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
