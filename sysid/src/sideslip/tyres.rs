//! What usual tyres and bodies imply of Q and C, which a drive of gentle turns hardly determines.
//!
//! With the slip of the rear tyres κ·v = b/v − S per yaw rate (docs/methods/sideslip.md):
//!
//! ```text
//! Q = −ρ·κ·v                  ρ = c/g²
//! C = κ²·v² + κ·d             d = b·(i²/(Lf·Lr) − 1) − σ
//! ```
//!
//! c is the curvature of the tyres' characteristic: slip over that of the cornering stiffness is 1 + c·(a/g)². At
//! 4 m/s² and a friction of 1, c is 1.1 for a brush, 0.37 for tanh, and 0.39 for the magic formula with C = 1.35 and E = 0; at a
//! friction of 0.8 the latter is 0.65, and the lateral transfer of load adds to it. In d are the yaw inertia, whose i²/(Lf·Lr) is 0.85 to 1.15
//! of usual cars, and the relaxation length σ, up to half a metre. Estimates of a drive count by their covariance.

use crate::sideslip::displacements::{ACCELERATION, DISTANCE, GROWTH, RATE, TERMS};
use crate::sideslip::regression::Regression;

const GRAVITY: f64 = 9.81;
/// c, mean and standard deviation.
const CURVATURE: [f64; 2] = [0.8, 0.4];
/// Standard deviation of d around 0, m.
const LEVER_M: f64 = 0.4;

/// Takes them into the estimate of a drive over speed with a reference speed, m/s.
pub(super) fn take_usual_tyres(found: &mut Regression, reference_speed: f64) {
    let slip = |found: &Regression| found.values[DISTANCE] - found.values[RATE];
    // Rear tyres that push are no tyres.
    if slip(found) > 0.0 {
        let [rho, deviation] = CURVATURE.map(|c| c / (GRAVITY * GRAVITY));
        let mut growth = [0.0; TERMS];
        (growth[GROWTH], growth[DISTANCE], growth[RATE]) = (1.0, rho, -rho);
        found.take(&growth, 0.0, deviation * slip(found));
    }
    let slip = slip(found);
    if slip > 0.0 {
        // Of (b/v₀ − S)² the tangent.
        let mut lead = [0.0; TERMS];
        (lead[ACCELERATION], lead[DISTANCE], lead[RATE]) = (1.0, -2.0 * slip, 2.0 * slip);
        found.take(&lead, -slip * slip, LEVER_M * slip / reference_speed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// S = 0.02 s and b/v₀ = 0.1 s at 15 m/s, with a growth Q of some standard error.
    fn estimate(growth: f64, error: f64) -> Regression {
        let mut values = [0.0; TERMS];
        (values[RATE], values[DISTANCE], values[GROWTH]) = (0.02, 0.1, growth);
        values[ACCELERATION] = 0.006;
        let mut covariance = [[0.0; TERMS]; TERMS];
        covariance[RATE][RATE] = 1e-8;
        covariance[DISTANCE][DISTANCE] = 1e-8;
        covariance[GROWTH][GROWTH] = error * error;
        covariance[ACCELERATION][ACCELERATION] = 1e-8;
        Regression { values, covariance, residuals: Vec::new() }
    }

    #[test]
    fn usual_tyres_decide_where_the_drive_does_not() {
        // −0.8·0.08/9.81² with half of that as deviation.
        let usual = -0.8 * 0.08 / (GRAVITY * GRAVITY);
        for (growth, error, expected, deviation) in [
            (3e-3, 1.0, usual, 0.5 * usual.abs()),
            (-2e-3, 1e-7, -2e-3, 1e-7),
            (usual + 1e-3, 0.5 * usual.abs(), usual + 0.5e-3, 0.5 * usual.abs() / 2.0_f64.sqrt()),
        ] {
            let mut found = estimate(growth, error);
            take_usual_tyres(&mut found, 15.0);
            let value = found.values[GROWTH];
            assert!((value - expected).abs() < 0.01 * usual.abs(), "{value:e}, {expected:e}");
            let stated = found.error(GROWTH);
            assert!((stated / deviation - 1.0).abs() < 0.01, "{stated:e}, {deviation:e}");
        }
    }

    #[test]
    fn what_does_not_slip_is_left_as_it_is() {
        let mut found = estimate(3e-3, 1.0);
        found.values[DISTANCE] = 0.01;
        let before = found.values;
        take_usual_tyres(&mut found, 15.0);
        assert_eq!(found.values, before);
    }
}
