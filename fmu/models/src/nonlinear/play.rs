//! Play between the steering's servo and the road wheels: they follow it at the edges of a gap.
//!
//! ```text
//! δ = max(σ − g/2, min(σ + g/2, δ))
//! ```
//!
//! with the servo's angle σ and the gap g from stop to stop. A motion of the servo is cut where it turns and where an
//! edge takes the wheels along, so that each part of the wheels' motion is smooth.

use super::actuator::Motion;

/// The parts of a servo's motion: until it turns and after, each until an edge is reached and after.
pub(super) type Parts = [Motion; 4];

/// Halvings of a time, after which it is exact to the last digit of an f64.
const HALVINGS: u32 = 53;

/// How the road wheels, now at `wheel`, follow a motion of the servo through a gap of twice `half` (rad), and where they
/// are then; parts may be empty.
pub(super) fn follow(
    half: f64,
    mut wheel: f64,
    motion: &Motion,
    time_constant: f64,
) -> (Parts, f64) {
    let mut parts = Parts::default();
    let turn = turning_time(motion, time_constant);
    let pieces = [(0.0, turn), (turn, motion.duration - turn)];
    for (pair, (begin, duration)) in parts.chunks_exact_mut(2).zip(pieces) {
        if duration <= 0.0 {
            continue;
        }
        let servo = part(motion, begin, duration, time_constant);
        let [from, end] = [0.0, duration].map(|time| servo.angle_at(time, time_constant));
        // The edge that moves towards the wheels, and their angle less the servo's once it has reached them.
        let edge = half.copysign(from - end);
        let stands = from == end;
        let reached =
            if stands { duration } else { reaching_time(&servo, wheel - edge, time_constant) };
        pair[0] = Motion { duration: reached, start: wheel, slope: 0.0, swing: 0.0 };
        if reached < duration {
            let moved = part(&servo, reached, duration - reached, time_constant);
            pair[1] = Motion { start: moved.start + edge, ..moved };
            wheel = end + edge;
        }
    }
    (parts, wheel)
}

/// The part of a motion that begins at a time and lasts for a duration, s.
fn part(motion: &Motion, begin: f64, duration: f64, time_constant: f64) -> Motion {
    if begin == 0.0 {
        return Motion { duration, ..*motion };
    }
    let swing =
        if motion.swing == 0.0 { 0.0 } else { motion.swing * (-begin / time_constant).exp() };
    Motion { duration, start: motion.start + motion.slope * begin, slope: motion.slope, swing }
}

/// When a motion turns back, s; its duration if it does not.
fn turning_time(motion: &Motion, time_constant: f64) -> f64 {
    // δ̇ = slope − swing/T·exp(−τ/T) vanishes once, if both have one sign.
    if motion.slope * motion.swing <= 0.0 {
        return motion.duration;
    }
    let time = -time_constant * (motion.slope * time_constant / motion.swing).ln();
    if time > 0.0 && time < motion.duration { time } else { motion.duration }
}

/// When a motion that does not turn reaches an angle, s; its duration if it does not.
fn reaching_time(motion: &Motion, angle: f64, time_constant: f64) -> f64 {
    let end = motion.angle_at(motion.duration, time_constant);
    let side = (end - motion.angle_at(0.0, time_constant)).signum();
    let is_reached = |time: f64| (motion.angle_at(time, time_constant) - angle) * side >= 0.0;
    if is_reached(0.0) {
        return 0.0;
    }
    if !is_reached(motion.duration) {
        return motion.duration;
    }
    let (mut before, mut after) = (0.0, motion.duration);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        if is_reached(middle) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}
