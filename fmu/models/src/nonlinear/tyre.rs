//! Lateral forces of an axle: two tyres by Pacejka's magic formula at their own loads, x = 1 ± q times the
//! static wheel load (equations in `docs/methods/nonlinear.md`).
//!
//! Braking and driving change the load of both tyres of an axle by m: x = 1 + m ± q. Where nothing lifts, an axle loses
//! the part k·q² of stiffness and peak force by a transfer q; a transfer beyond the load lifts the inner wheel and
//! leaves all load on the outer one. Beyond twice the static load the sensitivities do not grow. Forces are positive
//! to the left for a positive slip angle α (rad). With C in [1, 2) and E in [−1.5, 1] the force of a tyre
//! rises from its steepest slope C_α at α = 0 and is never above D.

use crate::trigonometry::{atan, sin_of_half_turn};

/// The tyres of one axle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axle {
    /// B and D of a tyre at the static load.
    b: f64,
    d: f64,
    c: f64,
    e: f64,
    friction_sensitivity: f64,
    stiffness_sensitivity: f64,
}

/// What both tyres of an axle are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TyreParameters {
    /// μ at the static load.
    pub friction: f64,
    /// C.
    pub shape: f64,
    /// E.
    pub curvature: f64,
    /// k_μ.
    pub friction_sensitivity: f64,
    /// k_C.
    pub stiffness_sensitivity: f64,
}

impl Axle {
    /// The axle with that cornering stiffness (N/rad) at its static load (N), both of two tyres.
    #[must_use]
    pub fn new(cornering_stiffness: f64, static_load: f64, tyre: &TyreParameters) -> Self {
        let d = tyre.friction * static_load / 2.0;
        Self {
            b: cornering_stiffness / 2.0 / (tyre.shape * d),
            d,
            c: tyre.shape,
            e: tyre.curvature,
            friction_sensitivity: tyre.friction_sensitivity,
            stiffness_sensitivity: tyre.stiffness_sensitivity,
        }
    }

    /// Lateral force of both tyres, N, at a slip angle (rad) and a transfer q over the static wheel load.
    #[must_use]
    pub fn force(&self, slip_angle: f64, transfer: f64) -> f64 {
        let q = transfer.clamp(-1.0, 1.0);
        let [outer, inner] = tyres([self; 2], [slip_angle; 2], [q, -q]);
        outer + inner
    }

    /// [`Axle::force`] of two axles, all four tyres together, each axle with `more` of its static load; `more` is above −1.
    #[inline]
    #[must_use]
    pub fn forces(
        axles: [&Self; 2],
        slip_angle: [f64; 2],
        transfer: [f64; 2],
        more: [f64; 2],
    ) -> [f64; 2] {
        let [f, r] = axles;
        let [a, b] = slip_angle;
        let [m, n] = more;
        // A load that is no number, as of a mass at the end of the numbers, has no force that is one.
        let bounded = |transfer: f64, more: f64| {
            let most = 1.0 + more;
            if most >= 0.0 { transfer.clamp(-most, most) } else { f64::NAN }
        };
        let (p, q) = (bounded(transfer[0], m), bounded(transfer[1], n));
        let force = tyres([f, f, r, r], [a, a, b, b], [m + p, m - p, n + q, n - q]);
        [force[0] + force[1], force[2] + force[3]]
    }
}

/// Forces of tyres whose loads are 1 + `more` times the static ones.
#[inline(always)]
fn tyres<const N: usize>(of: [&Axle; N], slip_angle: [f64; N], more: [f64; N]) -> [f64; N] {
    let (mut slip, mut peak) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        let sensed = more[i].min(1.0);
        let friction = 1.0 - of[i].friction_sensitivity * sensed;
        let stiffness = 1.0 - of[i].stiffness_sensitivity * sensed;
        slip[i] = of[i].b * stiffness / friction * slip_angle[i];
        peak[i] = of[i].d * (1.0 + more[i]) * friction;
    }
    let bent = atan(&slip);
    let mut shaped = [0.0; N];
    for i in 0..N {
        shaped[i] = slip[i] - of[i].e * (slip[i] - bent[i]);
    }
    let mut angle = atan(&shaped);
    for i in 0..N {
        angle[i] *= of[i].c;
    }
    // With C below 2 the angle is within half a turn.
    let sine = sin_of_half_turn(&angle);
    let mut force = [0.0; N];
    for i in 0..N {
        force[i] = peak[i] * sine[i];
    }
    force
}
