//! Simulation of the bicycle over recorded steering and speed, with its sensitivities.
//!
//! The speed is that of each sample, held over it, as in the FMU; so is the steering angle, which
//! acts τ later: within a sample it is first the older value, then the newer. The transitions over the two
//! parts have derivatives by their lengths, too, from which the one by the delay follows.

use crate::linalg::dual::{Dual, Scalar, ScaledBy};
use crate::structures::bicycle::parameters::{
    ALL, Coefficients, OF_MOTION, PARAMETERS, YAW_RATE_OFFSET,
};
use crate::structures::bicycle::transitions::{Between, Transition, Transitions};
use crate::structures::limited_wheel::Servo;
use pulp::{Arch, Simd, WithSimd};
use std::cmp::Ordering;
use std::ops::Range;

/// A recording without a gap: steering angle at the road wheel, speed, yaw rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedSegment<'a> {
    pub(super) sample_time: f64,
    /// Steering before the first sample, where it was recorded.
    pub(super) before: &'a [f64],
    /// It may go on beyond the last yaw rate, which a negative delay needs.
    pub(super) steering: &'a [f64],
    pub(super) speed: &'a [f64],
    pub(super) yaw_rate: &'a [f64],
}

impl SpeedSegment<'_> {
    pub(super) fn len(&self) -> usize {
        self.yaw_rate.len()
    }

    /// No v_y, and the first yaw rate.
    pub(super) fn measured(&self) -> InitialState {
        [0.0, self.yaw_rate.first().copied().unwrap_or(0.0)]
    }
}

pub(super) type InitialState = [f64; 2];

/// Yaw rates beyond this end a simulation, rad/s: no vehicle turns like that.
const BOUND: f64 = 1e3;
/// Time constants after which a wheel has forgotten where it was.
const LASTING: f64 = 40.0;

/// The transitions over the older and the newer part of a sample.
struct AtSpeed<S> {
    older: Option<Transition<S>>,
    newer: Transition<S>,
}

/// Runs the model; `each` gets the yaw rates. `false` where it leaves all bounds. `by_delay` keeps
/// the older part of a sample where it is empty, for the derivative by its length.
fn run<T: Scalar, S: ScaledBy<T>>(
    c: (&Coefficients<T>, &Coefficients<S>),
    recording: &SpeedSegment<'_>,
    start: [S; 2],
    by_delay: bool,
    each: impl FnMut(S),
) -> bool {
    Arch::new().dispatch(BicycleRun { of_motion: c.0, c: c.1, recording, start, by_delay, each })
}

struct BicycleRun<'a, T, S, F> {
    /// The same with derivatives by the parameters of the motion alone.
    of_motion: &'a Coefficients<T>,
    c: &'a Coefficients<S>,
    recording: &'a SpeedSegment<'a>,
    start: [S; 2],
    by_delay: bool,
    each: F,
}

impl<T: Scalar, S: ScaledBy<T>, F: FnMut(S)> WithSimd for BicycleRun<'_, T, S, F> {
    type Output = bool;

    /// The same sums whatever the vectors are.
    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) -> bool {
        let Self { of_motion, c, recording, start, by_delay, mut each } = self;
        let t = recording.sample_time;
        let whole = (of_motion.delay.value() / t).floor();
        // The part of a sample in which the older value still acts.
        let older = of_motion.delay - T::constant(whole * t);
        let newer = T::constant(t) - older;
        let parts = [older, newer];
        let lengths = parts.map(|h| S::constant(1.0).scaled_by(h));
        let known = recording.before.len() as f64;
        let last = recording.steering.len() as f64 - 1.0;
        let target = |k: f64| {
            let k = k.clamp(-known, last);
            let angle = if k < 0.0 {
                recording.before[(known + k) as usize]
            } else {
                recording.steering[k as usize]
            };
            (S::constant(angle) - c.steering_offset) * c.steering_factor
        };
        let servo = Servo { lag_rate: c.rate, rate_max: c.rate_max };
        let mut x = start;
        // The wheel is where the steering before has brought it; long before, where it was commanded to.
        let history = (LASTING / (of_motion.rate.value() * t)).ceil().clamp(0.0, known) as usize;
        let mut wheel = target(-(history as f64) - whole - 1.0);
        if history > 0 {
            let rests = parts.map(|h| (-(h * of_motion.rate)).exp());
            for k in (1..=history).rev() {
                let at = -(k as f64) - whole;
                for (i, target) in [target(at - 1.0), target(at)].into_iter().enumerate() {
                    wheel = match servo.limited(wheel, target, lengths[i]) {
                        Some(limited) => limited.end,
                        None => target + (wheel - target).scaled_by(rests[i]),
                    };
                }
            }
        }
        let acts = older.value() > 0.0 || by_delay;
        let mut olders = if acts { Some(Transitions::new(of_motion, older)) } else { None };
        let mut newers = Transitions::new(of_motion, newer);
        // That of the sample before is kept: a speed may be constant, or logged at a lower rate.
        let mut kept: Option<(f64, AtSpeed<T>)> = None;
        for (k, &speed) in recording.speed.iter().enumerate().take(recording.len()) {
            each(x[1] + c.yaw_rate_offset);
            let over = match &mut kept {
                Some((of, over)) if *of == speed => over,
                kept => {
                    let between = Between::new(speed);
                    let older = olders.as_mut().map(|o| o.interpolate(speed, between.as_ref()));
                    let newer = newers.interpolate(speed, between.as_ref());
                    &mut kept.insert((speed, AtSpeed { older, newer })).1
                }
            };
            let at = k as f64 - whole;
            let mut move_over = |transition: &Transition<T>, length: S, target: S| {
                let limited = servo.limited(wheel, target, length);
                let felt = limited.as_ref().map_or(target, |limited| limited.target);
                transition.apply(&mut x, &mut wheel, felt);
                wheel = limited.map_or(wheel, |limited| limited.end);
            };
            if let Some(older) = &over.older {
                move_over(older, lengths[0], target(at - 1.0));
            }
            move_over(&over.newer, lengths[1], target(at));
            // Not a number is no less than the bound either.
            if !(x[1].value().abs() < BOUND && x[0].value().abs() < 1e3 * BOUND) {
                return false;
            }
        }
        true
    }
}

/// The simulated yaw rate; `None` where the model leaves all bounds.
pub(super) fn yaw_rate(
    p: &[f64; PARAMETERS],
    share: f64,
    recording: &SpeedSegment<'_>,
    start: &InitialState,
) -> Option<Vec<f64>> {
    let mut all = Vec::with_capacity(recording.len());
    let c = Coefficients::new(p, share);
    if run((&c, &c), recording, *start, false, |r| all.push(r)) { Some(all) } else { None }
}

/// A simulated yaw rate, and its derivatives by the parameters and the two initial states.
pub(super) struct Sensitivities {
    pub(super) yaw_rate: Vec<f64>,
    /// A row for each sample.
    pub(super) by: Vec<[f64; ALL]>,
}

/// Where a number has the derivative by a parameter or an initial state. The offset of the yaw rate, which is added to it and
/// acts on nothing else, has none, so that value and derivatives fill whole vectors.
fn lane(i: usize) -> Option<usize> {
    match i.cmp(&YAW_RATE_OFFSET) {
        Ordering::Less => Some(i),
        Ordering::Equal => None,
        Ordering::Greater => Some(i - 1),
    }
}

/// As [`yaw_rate`], with derivatives; that by the delay only if `by_delay`.
pub(super) fn sensitivities(
    p: &[f64; PARAMETERS],
    share: f64,
    recording: &SpeedSegment<'_>,
    start: &InitialState,
    by_delay: bool,
) -> Option<Sensitivities> {
    // Value and derivatives by these fill two vectors, not three.
    let of_motion = std::array::from_fn(|i| match i {
        0..OF_MOTION => Dual::<8>::parameter(p[i], i),
        _ => Dual::constant(p[i]),
    });
    let of_motion = Coefficients::new(&of_motion, share);
    let dual = |value: f64, i: usize| match lane(i) {
        Some(lane) => Dual::<ALL>::parameter(value, lane),
        None => Dual::constant(value),
    };
    let p = std::array::from_fn(|i| dual(p[i], i));
    let start = std::array::from_fn(|i| dual(start[i], PARAMETERS + i));
    let mut all = Vec::with_capacity(recording.len());
    let mut by = Vec::with_capacity(recording.len());
    let c = Coefficients::new(&p, share);
    let bounded = run((&of_motion, &c), recording, start, by_delay, |r| {
        all.push(r.value());
        let own = r.by::<{ ALL - 1 }>();
        by.push(std::array::from_fn(|i| lane(i).map_or(1.0, |lane| own[lane])));
    });
    if bounded { Some(Sensitivities { yaw_rate: all, by }) } else { None }
}

/// The parts of a log's segments that `ranges` hold, each of which lies within one of them.
pub(super) fn within<'a>(
    segments: &[(Range<usize>, SpeedSegment<'a>)],
    ranges: &[Range<usize>],
) -> Vec<SpeedSegment<'a>> {
    let part = |range: &Range<usize>| {
        let holds = |(at, _): &&(Range<usize>, SpeedSegment<'a>)| {
            at.start <= range.start && range.end <= at.end
        };
        let (at, s) = segments.iter().find(holds)?;
        let cut = range.start - at.start..range.end - at.start;
        Some(SpeedSegment {
            sample_time: s.sample_time,
            before: &s.steering[..cut.start],
            steering: &s.steering[cut.clone()],
            speed: &s.speed[cut.clone()],
            yaw_rate: &s.yaw_rate[cut],
        })
    };
    ranges.iter().filter_map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::bicycle::parameters::{DELAY, LAG, RATE};

    /// ln of a rate that nothing reaches.
    const UNLIMITED: f64 = 14.0;

    /// Steering and speed of a drive that stops and starts again.
    fn signals(n: usize) -> (Vec<f64>, Vec<f64>) {
        let time = (0..n).map(|k| k as f64 * 0.04);
        let steering = time.clone().map(|t| 0.05 * (1.3 * t).sin() + 0.02 * (5.1 * t).cos());
        (steering.collect(), time.map(|t| 12.0 * (0.3 * t).cos().max(0.0)).collect())
    }

    fn recording<'a>(
        steering: &'a [f64],
        speed: &'a [f64],
        yaw_rate: &'a [f64],
    ) -> SpeedSegment<'a> {
        SpeedSegment { sample_time: 0.04, before: &[], steering, speed, yaw_rate }
    }

    #[test]
    fn derivatives_are_those_of_central_differences() {
        let (steering, speed) = signals(300);
        let zeros = vec![0.0; 300];
        let recording = recording(&steering, &speed, &zeros);
        let base = [4.2, 4.4, 0.9, -0.1, -2.5, 0.07, 0.01, 0.002, 0.1, UNLIMITED];
        for (lag, delay, rate) in [
            (-2.5, 0.07, UNLIMITED),
            (-8.0, 0.0431, UNLIMITED),
            (-1.0, -0.013, UNLIMITED),
            (-12.0, 0.31, UNLIMITED),
            (-2.5, 0.07, -3.0),
            (-8.0, 0.0431, -2.8),
            (-1.0, -0.013, -4.0),
        ] {
            let mut p = base;
            (p[LAG], p[DELAY], p[RATE]) = (lag, delay, rate);
            let is_limited = rate != UNLIMITED;
            let start = [0.3, 0.1];
            let found = sensitivities(&p, 0.45, &recording, &start, true).unwrap();
            assert_eq!(found.yaw_rate, yaw_rate(&p, 0.45, &recording, &start).unwrap());
            for i in 0..ALL {
                let at = |h: f64| {
                    let (mut p, mut start) = (p, start);
                    if i < PARAMETERS {
                        p[i] += h
                    } else {
                        start[i - PARAMETERS] += h
                    }
                    yaw_rate(&p, 0.45, &recording, &start).unwrap()
                };
                let (up, down) = (at(1e-5), at(-1e-5));
                let size = found.by.iter().map(|row| row[i].abs()).fold(0.0, f64::max);
                assert!(i != RATE || is_limited == (size > 0.01), "{size}");
                // Slopes have kinks where a limit begins or ends.
                let share = if is_limited { 1e-3 } else { 1e-5 };
                for t in 0..300 {
                    let difference = (up[t] - down[t]) / 2e-5;
                    let error = (difference - found.by[t][i]).abs();
                    // Rounding, a millionth of a millionth of the yaw rate, over the step.
                    assert!(error < share * size + 1e-7, "{i} at {t}: {difference} {error:e}");
                }
            }
        }
    }

    #[test]
    fn a_delay_of_whole_samples_is_a_shift_and_halves_of_a_step_are_the_step() {
        let (steering, speed) = signals(400);
        let zeros = vec![0.0; 400];
        let whole = recording(&steering, &speed, &zeros);
        let shifted: Vec<f64> = (0..400_usize).map(|k| steering[k.saturating_sub(3)]).collect();
        let late = SpeedSegment { steering: &shifted, ..whole };
        let p = [4.2, 4.4, 0.9, -0.1, -2.5, 0.0, 0.01, 0.002, 0.0, UNLIMITED];
        let mut delayed = p;
        delayed[DELAY] = 0.12;
        let simulate = |p, r: &SpeedSegment<'_>| yaw_rate(p, 0.5, r, &[0.1, 0.2]).unwrap();
        let close = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) < 1e-12
        };
        assert!(close(&simulate(&delayed, &whole), &simulate(&p, &late)));
        // Twice as many samples of half the time.
        let double = |x: &[f64]| x.iter().flat_map(|v| [*v, *v]).collect::<Vec<f64>>();
        let (steering2, speed2, zeros2) = (double(&steering), double(&speed), double(&zeros));
        let fine = SpeedSegment { sample_time: 0.02, ..recording(&steering2, &speed2, &zeros2) };
        let every: Vec<f64> = simulate(&p, &fine).into_iter().step_by(2).collect();
        assert!(close(&every, &simulate(&p, &whole)));
    }

    #[test]
    fn a_limited_rate_is_that_of_finer_samples() {
        let (steering, speed) = signals(400);
        let zeros = vec![0.0; 400];
        let whole = recording(&steering, &speed, &zeros);
        let times = |x: &[f64]| x.iter().flat_map(|v| [*v; 20]).collect::<Vec<f64>>();
        let (steering20, speed20, zeros20) = (times(&steering), times(&speed), times(&zeros));
        let fine =
            SpeedSegment { sample_time: 0.002, ..recording(&steering20, &speed20, &zeros20) };
        for (lag, delay, rate) in [(-2.5, 0.0, -3.0), (-4.0, 0.053, -2.5), (-8.0, 0.031, -3.5)] {
            let p = [4.2, 4.4, 0.9, -0.1, lag, delay, 0.01, 0.002, 0.0, rate];
            let found = yaw_rate(&p, 0.5, &whole, &[0.1, 0.2]).unwrap();
            let exact = yaw_rate(&p, 0.5, &fine, &[0.1, 0.2]).unwrap();
            let unlimited = [p[0], p[1], p[2], p[3], lag, delay, 0.01, 0.002, 0.0, UNLIMITED];
            let unlimited = yaw_rate(&unlimited, 0.5, &whole, &[0.1, 0.2]).unwrap();
            let largest = |a: &[f64], b: &mut dyn Iterator<Item = f64>| {
                a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
            };
            let error = largest(&found, &mut exact.into_iter().step_by(20));
            let effect = largest(&found, &mut unlimited.into_iter());
            assert!(error < 5e-3 * effect, "{lag} {delay} {rate}: {error} {effect}");
        }
    }

    #[test]
    fn what_was_steered_before_still_acts() {
        let (steering, speed) = signals(400);
        let zeros = vec![0.0; 400];
        let whole = recording(&steering, &speed, &zeros);
        for delay in [0.0, 0.07, 0.5] {
            let p = [4.2, 4.4, 0.9, -0.1, -1.0, delay, 0.01, 0.002, 0.0, UNLIMITED];
            // v_y and r forget within a second; the wheel angle must be right from the start.
            let all = yaw_rate(&p, 0.5, &whole, &[0.0, 0.0]).unwrap();
            let part = within(&[(0..400, whole)], std::slice::from_ref(&(100..400)));
            let found = yaw_rate(&p, 0.5, &part[0], &[0.0, 0.0]).unwrap();
            for t in 50..300 {
                assert!((found[t] - all[100 + t]).abs() < 1e-9, "{delay} {t}");
            }
            let cold =
                yaw_rate(&p, 0.5, &SpeedSegment { before: &[], ..part[0] }, &[0.0; 2]).unwrap();
            assert!((5..30).any(|t| (found[t] - cold[t]).abs() > 1e-3), "{delay}");
        }
    }

    #[test]
    fn a_model_that_diverges_ends_the_simulation() {
        let (steering, _) = signals(2000);
        let speed = vec![60.0; 2000];
        let recording = recording(&steering, &speed, &speed);
        // Oversteering far beyond its critical speed.
        let p = [4.8, 3.5, 0.9, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, UNLIMITED];
        assert!(yaw_rate(&p, 0.5, &recording, &[0.0, 0.0]).is_none());
        assert!(sensitivities(&p, 0.5, &recording, &[0.0, 0.0], false).is_none());
    }
}
