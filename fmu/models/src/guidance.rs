//! Guidance along a path: look-ahead based line of sight, with preview, sideslip and integral action.
//!
//! The law and its sources are in `docs/methods/path.md`, its derivation in the README of
//! `fmu/reference-path`:
//!
//! ```text
//! yaw_reference        = ψ(s') + atan2(−(e + z), Δ),     s' = s + v·preview_time
//! steering_feedforward = feedforward_gain·κ_a,           Sₐ = S + Q·a²
//! ż                    = cross_track_integral_gain·e·Δ²/(Δ² + (e + z)²)   while the vehicle moves
//! ϑ̇                    = (e/Δ)/(1 + e²/e₀²)·r/(r² + r₀²)/sideslip_correction_time,   r = v·κ
//! ψ(s')                = ψ_a + A·ψ̈_a + K·ψ⃛_a,   A = G − C,   K = Sₐ·C + J
//! ψ_a, κ_a             = ∫₀^∞ e⁻ˣ·(ψ_p, κ)(s' − v·Sₐ·x) dx
//! ```
//!
//! with `Δ = max(lookahead_min, lookahead_time·v)` and `a = v²·κ(s' − v·S)`, at most g; S, Q and C are those of
//! the speed v ([`crate::sideslip`]), S with the correction ϑ and with the offset σ that an estimator has learnt, which
//! is followed with the time constant Δ/v. In a steady turn with an error of S the cross-track error is
//! Δ·r times that error, which ϑ takes away in the stated time, slowly where r is below r₀ and not at all far off the
//! path. Yaw follows the course by `1/(1 + Sₐ·s + C·s²)` of Laplace's s: the average ψ_a is exactly `1/(1 + Sₐ·s)`, by
//! Gauss–Laguerre quadrature, since a delay by Sₐ would ask for more steering rate where a bend begins and ends than the
//! road needs. A and K are the rest to third order. The derivatives are differences of ψ_a, of fewer nodes, v·h apart, which
//! are smooth where the curvature's derivative would jump; h² is |2A|, or h³ is |2K| where that is more, so that no difference
//! weighs more than the heading. `yaw_reference` is not wrapped: it is as continuous as the path.

use crate::Error;
use crate::angle::wrap_angle;
use crate::error::{diverged, finite};
use crate::numbers::as_numbers;
use crate::path::PathGeometry;
use crate::sideslip::Sideslip;
use crate::trigonometry::atan;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_formats::Guidance;

/// Parameters of the guidance law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GuidanceParameters {
    /// The guidance of the path.
    pub guidance: Guidance,
    /// v₀, the speed at which the sideslip is stated, m/s.
    pub reference_speed: f64,
    /// σ, what the sideslip per yaw rate is beyond the stated one by an estimator, s.
    pub sideslip_per_yaw_rate_offset: f64,
}

as_numbers!(GuidanceParameters: guidance.lookahead_time_s guidance.lookahead_min_m guidance.preview_time_s
    guidance.feedforward_gain_radm
    guidance.sideslip_per_yaw_rate_s guidance.sideslip_growth_s5pm2 guidance.sideslip_per_yaw_acceleration_s2
    reference_speed sideslip_per_yaw_rate_offset guidance.distance_rear_m
    guidance.yaw_acceleration_gain_s2 guidance.yaw_jerk_gain_s3 guidance.sideslip_correction_time_s
    guidance.cross_track_integral_gain_per_s guidance.speed_preview_time_s guidance.brake_preview_time_s);

/// The outputs of the guidance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PathOutput {
    /// Yaw to steer for, rad, not wrapped.
    pub yaw_reference: f64,
    /// Steering angle for the curvature, rad.
    pub steering_feedforward: f64,
    /// Distance from the path, m, positive to the left.
    pub cross_track_error: f64,
    /// Yaw minus the path's heading, rad, in (−π, π].
    pub heading_error: f64,
    /// Curvature of the path at the vehicle, 1/m.
    pub curvature: f64,
    /// Distance along the path, m; on a closed path it goes on from lap to lap.
    pub distance: f64,
    /// Whether the end is reached; a closed path has none.
    pub finished: bool,
}

impl PathOutput {
    /// Refuses outputs that are not finite, as positions near the largest numbers cause.
    ///
    /// # Errors
    /// Names the value.
    pub fn check(&self) -> Result<(), Error> {
        diverged([
            ("the yaw reference", self.yaw_reference),
            ("the steering feedforward", self.steering_feedforward),
            ("the cross-track error", self.cross_track_error),
            ("the heading error", self.heading_error),
            ("the curvature", self.curvature),
            ("the distance", self.distance),
        ])
    }
}

/// atan2(aside, ahead), rad.
fn line_of_sight(aside: f64, ahead: f64) -> f64 {
    if ahead > 0.0 { atan(&[aside / ahead])[0] } else { aside.atan2(ahead) }
}

/// Nodes and weights of the Gauss–Laguerre quadrature, Abramowitz and Stegun, table 25.9.
const SIX_NODES: [[f64; 2]; 6] = [
    [0.222_846_604_179_260_7, 0.458_964_673_949_964_76],
    [1.188_932_101_672_622_6, 0.417_000_830_772_12],
    [2.992_736_326_059_314, 0.113_373_382_074_044_88],
    [5.775_143_569_104_51, 0.010_399_197_453_149_087],
    [9.837_467_418_382_59, 2.610_172_028_149_326_5e-4],
    [15.982_873_980_601_703, 8.985_479_064_296_213e-7],
];

/// The same of three nodes, which are enough for differences.
const THREE_NODES: [[f64; 2]; 3] = [
    [0.415_774_556_783_479_1, 0.711_093_009_929_172_9],
    [2.294_280_360_279_042, 0.278_517_733_569_241],
    [6.289_945_082_937_479_4, 0.010_389_256_501_586_133],
];

/// ψ_a and κ_a at a distance with a lag, m, which is negative for a lead.
fn average_behind(path: &PathGeometry, distance: f64, lag: f64, nodes: &[[f64; 2]]) -> [f64; 2] {
    if lag == 0.0 {
        return path.direction(distance);
    }
    let mut sum = [0.0; 2];
    for [node, weight] in nodes {
        let [heading, curvature] = path.direction(distance - lag * node);
        sum[0] += weight * heading;
        sum[1] += weight * curvature;
    }
    sum
}

/// r₀, rad/s: slower turns say little of the sideslip.
const LEAST_YAW_RATE: f64 = 0.1;
/// e₀, m: a vehicle further off the path is there for other reasons.
const NEAR: f64 = 1.0;
/// Largest correction and offset of the sideslip per yaw rate, s: that of a rear axle of half or twice the stiffness at 30 m/s.
const LARGEST_CORRECTION: f64 = 0.15;

/// How many laps of a closed path a saved progress may be.
const MOST_LAPS: f64 = 1e9;

/// A vehicle's progress along a path.
///
/// [`Self::evaluate`] depends on the inputs and on the progress of the last [`Self::commit`]
/// alone: outputs may be read any number of times with any inputs, and only the ones that the
/// simulation goes on from are committed. Before the first commit the whole path is searched.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFollower {
    geometry: Arc<PathGeometry>,
    state: GuidanceState,
}

/// What a [`PathFollower`] has kept of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GuidanceState {
    /// The distance along the path that was committed last, m; none before.
    pub progress: Option<f64>,
    /// z, the integral of the cross-track error, m.
    pub integral: f64,
    /// ϑ, the correction of the sideslip per yaw rate by the cross-track error, s.
    pub sideslip_correction: f64,
    /// σ, the offset of the sideslip per yaw rate, as far as it is followed, s.
    pub sideslip_offset: f64,
}

impl GuidanceParameters {
    /// The sideslip of the vehicle.
    #[inline]
    #[must_use]
    pub fn sideslip(&self) -> Sideslip {
        Sideslip {
            per_yaw_rate: self.guidance.sideslip_per_yaw_rate_s,
            growth: self.guidance.sideslip_growth_s5pm2,
            per_yaw_acceleration: self.guidance.sideslip_per_yaw_acceleration_s2,
            reference_speed: self.reference_speed,
            distance_rear: self.guidance.distance_rear_m,
        }
    }

    /// Δ, m.
    fn lookahead(&self, speed: f64) -> f64 {
        self.guidance.lookahead_min_m.max(self.guidance.lookahead_time_s * speed)
    }

    /// ψ(s'), rad, with which the course is the path's heading at a distance, and κ_a, 1/m, as which
    /// it changes; with what is added to the sideslip per yaw rate, s.
    fn yaw(&self, path: &PathGeometry, distance: f64, speed: f64, added: f64) -> [f64; 2] {
        let mut sideslip = self.sideslip().at_speed(speed);
        sideslip.per_yaw_rate += added;
        let mut lag = sideslip.per_yaw_rate;
        if sideslip.growth != 0.0 {
            let curvature = path.direction(distance - speed * lag)[1];
            lag = sideslip.in_turn(speed * speed * curvature);
        }
        let lead = sideslip.per_yaw_acceleration;
        let second = self.guidance.yaw_acceleration_gain_s2 - lead;
        let third = self.guidance.yaw_jerk_gain_s3 + lag * lead;
        let [heading, curvature] = average_behind(path, distance, speed * lag, &SIX_NODES);
        // The larger of |2A|^½ and |2K|^⅓, found without the other root.
        let (square, cube) = ((2.0 * second).abs(), (2.0 * third).abs());
        let apart = if square.powi(3) >= cube * cube { square.sqrt() } else { cube.cbrt() };
        if apart == 0.0 {
            return [heading, curvature];
        }
        // Each difference is of time; at a standstill all headings are the same.
        let near = |steps: f64| {
            let place = distance + speed * (steps * apart);
            average_behind(path, place, speed * lag, &THREE_NODES)[0]
        };
        let (before, own, after) = (near(-1.0), near(0.0), near(1.0));
        let bent = second / (apart * apart) * (after - 2.0 * own + before);
        let twisted = match third {
            0.0 => 0.0,
            third => {
                let difference = near(2.0) - 2.0 * after + 2.0 * before - near(-2.0);
                0.5 * third / apart.powi(3) * difference
            }
        };
        [heading + bent + twisted, curvature]
    }
}

impl PathFollower {
    /// A vehicle somewhere near a path.
    #[must_use]
    pub fn new(geometry: Arc<PathGeometry>) -> Self {
        Self { geometry, state: GuidanceState::default() }
    }

    /// The path.
    #[must_use]
    pub fn geometry(&self) -> &Arc<PathGeometry> {
        &self.geometry
    }

    /// The outputs for a pose and a speed.
    #[must_use]
    pub fn evaluate(
        &self,
        p: &GuidanceParameters,
        x: f64,
        y: f64,
        yaw: f64,
        speed: f64,
    ) -> PathOutput {
        let state = &self.state;
        let projection = match state.progress {
            Some(from) => self.geometry.project(x, y, from),
            None => self.geometry.locate(x, y, yaw),
        };
        let foot = projection.foot;
        let error = projection.cross_track_error;
        let previewed = foot.distance_m + speed * p.guidance.preview_time_s;
        let lookahead = p.lookahead(speed);
        let aimed = error + state.integral;
        let added = state.sideslip_correction + state.sideslip_offset;
        let [prescribed, curvature] = p.yaw(&self.geometry, previewed, speed, added);
        PathOutput {
            yaw_reference: prescribed + line_of_sight(-aimed, lookahead),
            steering_feedforward: p.guidance.feedforward_gain_radm * curvature,
            cross_track_error: error,
            heading_error: wrap_angle(yaw - foot.heading_rad),
            curvature: foot.curvature_per_m,
            distance: foot.distance_m,
            finished: !self.geometry.is_closed() && foot.distance_m >= self.geometry.end(),
        }
    }

    /// What was kept.
    #[must_use]
    pub fn state(&self) -> &GuidanceState {
        &self.state
    }

    /// Lets integral and correction grow over a step (s) at whose end the outputs were evaluated, and follows the offset
    /// of the sideslip: each fix changes it, and a steering that has no rate to spare would follow the noise. Nothing at
    /// a standstill, and the first two not far off the path.
    pub fn integrate(&mut self, p: &GuidanceParameters, out: &PathOutput, speed: f64, step: f64) {
        if speed <= 0.0 {
            return;
        }
        let lookahead = p.lookahead(speed);
        let state = &mut self.state;
        let offset = p.sideslip_per_yaw_rate_offset.clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
        let share = (step * speed / lookahead).min(1.0);
        state.sideslip_offset += share * (offset - state.sideslip_offset);
        let time = p.guidance.sideslip_correction_time_s;
        if time > 0.0 {
            let (error, yaw_rate) = (out.cross_track_error, speed * out.curvature);
            let missed = error / lookahead / (1.0 + (error / NEAR).powi(2));
            let share = yaw_rate / (yaw_rate * yaw_rate + LEAST_YAW_RATE * LEAST_YAW_RATE);
            let corrected = state.sideslip_correction + step / time * missed * share;
            if corrected.is_finite() {
                state.sideslip_correction =
                    corrected.clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
            }
        }
        let gain = p.guidance.cross_track_integral_gain_per_s;
        if gain == 0.0 {
            return;
        }
        let (error, aimed) = (out.cross_track_error, out.cross_track_error + state.integral);
        let share = 1.0 / (1.0 + (aimed / lookahead).powi(2));
        let grown = state.integral + step * gain * error * share;
        if grown.is_finite() {
            state.integral = grown.clamp(-lookahead, lookahead);
        }
    }

    /// Goes on from what was kept.
    ///
    /// # Errors
    /// Where a number is not finite, or more laps of a closed path than anybody drives.
    pub fn restore(&mut self, state: GuidanceState) -> Result<(), Error> {
        finite("the integral of the cross-track error", &[state.integral])?;
        finite("the correction of the sideslip", &[state.sideslip_correction])?;
        finite("the offset of the sideslip", &[state.sideslip_offset])?;
        if let Some(value) = state.progress {
            let name = "the distance along the path";
            finite(name, &[value])?;
            let (start, end) = (self.geometry.start(), self.geometry.end());
            // An open path goes on straight beyond its ends.
            let closed = self.geometry.is_closed();
            if closed && (value - start).abs() > MOST_LAPS * (end - start) {
                let expected = "at most 1e9 laps";
                return Err(Error::SavedState { name, value, expected });
            }
        }
        self.state = state;
        Ok(())
    }

    /// Goes on from what was evaluated.
    pub fn commit(&mut self, output: &PathOutput) {
        self.state.progress = Some(output.distance);
    }
}
