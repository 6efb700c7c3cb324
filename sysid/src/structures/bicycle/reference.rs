//! Reference bicycles: how much of the yaw rate a bicycle leaves unexplained, with the speed of each sample, when
//! the steering is taken for another (behind play, earlier, later). What a vehicle does at varying speed, and its
//! lag, are then no fault of the recording, as they would be for a model of one speed or for one without a lag.
//!
//! The bicycle is fitted again for each change of the steering, from the fit before. Leaving out one of
//! [`BLOCKS`] blocks of time follows to second order from the sums of each block at the fit (Gauss and Newton's
//! step), so that a jackknife costs nothing.

use crate::Error;
use crate::linalg::dense::solve;
use crate::structures::bicycle::estimate::{Estimate, Problem};
use crate::structures::bicycle::parameters::{
    DELAY, Geometry, INDEX, PARAMETERS, Prior, STEERING_FACTOR, STEERING_OFFSET, is_limited,
};
use crate::structures::bicycle::rate_limit::Estimates;
use crate::structures::bicycle::simulate::{InitialState, SpeedSegment};
use crate::validation::residuals::pairs::{Pair, jackknife};
use faer::Mat;
use steerwright_drivelog::signal::{mean, standard_deviation};

/// Blocks of time.
pub(crate) const BLOCKS: usize = 10;
/// Samples that are fitted: more change no decision.
const MOST_SAMPLES: usize = 8_000;
/// Steering that is kept before and after the yaw rate of a segment, s: the longest change of a clock.
const SPARE_S: f64 = 0.4;
/// Shortest segment that is worth its initial state, s.
const SHORTEST_S: f64 = 3.0;
/// Speeds are rounded to that share, so that a steady speed has one transition; the yaw rate changes by less.
const SPEED_STEP: f64 = 0.01;
/// Of a log without a speed: the bicycle then has whatever tyres move as the vehicle does, m/s.
const ASSUMED_MPS: f64 = 15.0;
/// Sums are compared to a percent of what is left.
const COMPARED: f64 = 1e-5;
/// Standard deviation of the delay's prior, s: clocks are apart by more than a vehicle delays.
const CLOCKS_S: f64 = 0.3;
/// A standard deviation of the steering at the road wheel, rad, as a logarithm: whatever is steered, in any unit.
const MOVED: Prior = Prior { mean: -4.0, deviation: 2.0 };
/// The zero of the steering, in its standard deviations.
const ZERO: Prior = Prior { mean: 0.0, deviation: 1.0 };

/// The delay of a reference, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Delay {
    Free,
    Fixed(f64),
}

/// What is fitted.
pub(crate) struct Reference<'a> {
    segments: Vec<ReferencePart<'a>>,
    sample_time_s: f64,
    /// Standard deviation of the steering, in whose unit it is changed.
    pub(crate) unit: f64,
}

struct ReferencePart<'a> {
    steering: Vec<f64>,
    speed: Vec<f64>,
    yaw_rate: &'a [f64],
    spare: usize,
}

/// A fitted reference.
pub(crate) struct Fitted {
    estimate: Estimate,
    /// Place of the delay among the parameters that are fitted.
    delay_at: Option<usize>,
    blocks: Vec<ReferenceSums>,
}

/// Of a block: sum of squares, its gradient over −2 and its curvature over 2 by the parameters.
struct ReferenceSums {
    squares: f64,
    gradient: Mat<f64>,
    curvature: Mat<f64>,
}

/// A parameter's step, and the gradient over −2 that it follows.
struct Step {
    step: f64,
    gradient: f64,
}

impl Fitted {
    pub(crate) fn delay_s(&self) -> f64 {
        self.estimate.parameters[DELAY]
    }

    /// Standard error of the delay, s, by the block jackknife; `None` where it was fixed.
    pub(crate) fn delay_error_s(&self) -> Option<f64> {
        let at = self.delay_at?;
        let without: Vec<f64> = (0..BLOCKS).map(|b| self.step_without(b)[at].step).collect();
        Some(jackknife(&without)).filter(|error| error.is_finite())
    }

    /// Sum of squares that is left.
    pub(crate) fn left(&self) -> f64 {
        self.blocks.iter().map(|b| b.squares).sum()
    }

    /// The same of all blocks but one, with the parameters that suit those.
    pub(crate) fn left_without(&self, block: usize) -> f64 {
        let others = self.blocks.iter().enumerate().filter(|(b, _)| *b != block);
        let squares: f64 = others.map(|(_, b)| b.squares).sum();
        let gained: f64 = self.step_without(block).iter().map(|s| s.step * s.gradient).sum();
        if gained.is_finite() { (squares - gained).max(0.0) } else { squares }
    }

    /// Gauss and Newton's step of each parameter without one of the blocks.
    fn step_without(&self, block: usize) -> Vec<Step> {
        let others = self.blocks.iter().enumerate().filter(|(b, _)| *b != block);
        let n = self.blocks[block].gradient.nrows();
        let (mut gradient, mut curvature) = (Mat::<f64>::zeros(n, 1), Mat::<f64>::zeros(n, n));
        for (_, b) in others {
            gradient += &b.gradient;
            curvature += &b.curvature;
        }
        let scale: Vec<f64> =
            (0..n).map(|i| curvature[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
        // A ridge in place of a rank decision: steps along what the data do not determine change nothing.
        let normal = Mat::from_fn(n, n, |i, j| {
            curvature[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-6 } else { 0.0 }
        });
        let right = Mat::from_fn(n, 1, |i, _| gradient[(i, 0)] / scale[i]);
        let step = solve(normal.as_ref(), right.as_ref());
        (0..n).map(|i| Step { step: step[(i, 0)] / scale[i], gradient: gradient[(i, 0)] }).collect()
    }
}

impl<'a> Reference<'a> {
    /// Of recorded segments; `None` where nothing is long enough.
    pub(crate) fn new(segments: &[Pair<'a>], sample_time_s: f64) -> Option<Self> {
        let spare = (SPARE_S / sample_time_s).ceil() as usize;
        let shortest = 2 * spare + (SHORTEST_S / sample_time_s).ceil() as usize;
        let all: Vec<f64> = segments.iter().flat_map(|s| s.steering.iter().copied()).collect();
        let unit = standard_deviation(&all);
        if unit.is_nan() || unit <= 0.0 {
            return None;
        }
        let mut room = MOST_SAMPLES;
        let mut parts = Vec::new();
        for segment in segments {
            let count = segment.yaw_rate.len().min(room);
            if count < shortest {
                continue;
            }
            room -= count;
            let speed = match segment.speed {
                Some(speed) => speed[..count].iter().map(|v| rounded(*v)).collect(),
                None => vec![ASSUMED_MPS; count],
            };
            parts.push(ReferencePart {
                steering: segment.steering[..count].iter().map(|u| u / unit).collect(),
                speed,
                yaw_rate: &segment.yaw_rate[..count],
                spare,
            });
        }
        if parts.is_empty() { None } else { Some(Self { segments: parts, sample_time_s, unit }) }
    }

    /// By how much a width of play is smaller in the samples than it was, in standard deviations of the steering: the
    /// mean over a sample T misses `|δ̈|·T²/8` at each of the two reversals.
    pub(crate) fn width_between_samples(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0_u32);
        for part in &self.segments {
            for u in part.steering.windows(3) {
                squares += (u[0] - 2.0 * u[1] + u[2]).powi(2);
                count += 1;
            }
        }
        0.25 * (squares / f64::from(count.max(1))).sqrt()
    }

    /// Sum of squares of the yaw rate about its mean, of the samples that are fitted.
    pub(crate) fn variation(&self) -> f64 {
        let fitted =
            |p: &ReferencePart<'a>| p.yaw_rate[p.spare..p.yaw_rate.len() - p.spare].to_vec();
        let all: Vec<f64> = self.segments.iter().flat_map(fitted).collect();
        let level = mean(&all);
        all.iter().map(|y| (y - level).powi(2)).sum()
    }

    /// The bicycle that explains the yaw rate best by the steering as it was recorded, its delay free.
    pub(crate) fn recorded(&self) -> Option<Fitted> {
        let steering: Vec<Vec<f64>> = self.segments.iter().map(|p| p.steering.clone()).collect();
        let [prompt, delayed] =
            [Delay::Fixed(0.0), Delay::Free].map(|delay| self.problem(&steering, delay, None));
        let found = Estimates::new(prompt, delayed).ok()?;
        fitted(&found.delayed, found.with_delay).ok().flatten()
    }

    /// The same by the steering that `change` makes of a segment's, refined `from` another fit.
    pub(crate) fn changed(
        &self,
        change: &dyn Fn(&[f64]) -> Vec<f64>,
        delay: Delay,
        from: &Fitted,
    ) -> Option<Fitted> {
        let steering: Vec<Vec<f64>> = self.segments.iter().map(|p| change(&p.steering)).collect();
        let problem = self.problem(&steering, delay, Some(&from.estimate));
        let mut start = from.estimate.clone();
        if let Delay::Fixed(seconds) = delay {
            start.parameters[DELAY] = seconds;
        }
        let estimate = problem.solve_from(&start).ok()??;
        fitted(&problem, estimate).ok().flatten()
    }

    /// What the same leaves of the yaw rate, the delay free.
    pub(crate) fn left_by(
        &self,
        change: &dyn Fn(&[f64]) -> Vec<f64>,
        from: &Fitted,
    ) -> Option<f64> {
        let steering: Vec<Vec<f64>> = self.segments.iter().map(|p| change(&p.steering)).collect();
        let problem = self.problem(&steering, Delay::Free, Some(&from.estimate));
        let found = problem.solve_from(&from.estimate).ok()??;
        let errors = problem.errors(&found.parameters, &found.initial_states)?;
        Some(errors.iter().flatten().map(|e| e * e).sum())
    }

    /// With a largest rate of the road wheels where the estimate that it goes on from has one.
    fn problem<'b>(
        &'b self,
        steering: &'b [Vec<f64>],
        delay: Delay,
        from: Option<&Estimate>,
    ) -> Problem<'b> {
        let segment = |(p, steering): (&'b ReferencePart<'a>, &'b Vec<f64>)| {
            let end = p.yaw_rate.len() - p.spare;
            SpeedSegment {
                sample_time: self.sample_time_s,
                before: &steering[..p.spare],
                steering: &steering[p.spare..],
                speed: &p.speed[p.spare..end],
                yaw_rate: &p.yaw_rate[p.spare..end],
            }
        };
        let segments = self.segments.iter().zip(steering).map(segment).collect();
        let geometry = Geometry { wheelbase: Some(2.7), is_angle: false };
        let mut problem = Problem::new(segments, 0.5, geometry, delay == Delay::Free);
        problem.priors[DELAY].deviation = CLOCKS_S;
        (problem.priors[STEERING_FACTOR], problem.priors[STEERING_OFFSET]) = (MOVED, ZERO);
        (problem.fixed[STEERING_FACTOR], problem.fixed[STEERING_OFFSET]) = (MOVED.mean, ZERO.mean);
        problem.least_gain = COMPARED;
        problem.free.retain(|i| *i != INDEX);
        if from.is_some_and(|from| is_limited(&from.parameters)) {
            problem.free_rate();
        }
        problem
    }
}

fn rounded(speed: f64) -> f64 {
    if speed > 0.0 { ((speed.ln() / SPEED_STEP).round() * SPEED_STEP).exp() } else { 0.0 }
}

/// The sums of each block at an estimate.
fn fitted(problem: &Problem<'_>, estimate: Estimate) -> Result<Option<Fitted>, Error> {
    let (n, total) = (problem.free.len(), problem.samples());
    let empty =
        || ReferenceSums { squares: 0.0, gradient: Mat::zeros(n, 1), curvature: Mat::zeros(n, n) };
    let mut blocks: Vec<ReferenceSums> = (0..BLOCKS).map(|_| empty()).collect();
    let mut taken = 0;
    let starts: &[InitialState] = &estimate.initial_states;
    let p: &[f64; PARAMETERS] = &estimate.parameters;
    for (segment, start) in problem.segments.iter().zip(starts) {
        let Some(found) = problem.sensitivities(p, segment, start) else { return Ok(None) };
        for (t, (measured, simulated)) in segment.yaw_rate.iter().zip(&found.yaw_rate).enumerate() {
            let block = &mut blocks[taken * BLOCKS / total];
            let error = measured - simulated;
            block.squares += error * error;
            for (i, &row) in problem.free.iter().enumerate() {
                let by = found.by[t][row];
                block.gradient[(i, 0)] += by * error;
                for (j, &column) in problem.free.iter().enumerate() {
                    block.curvature[(i, j)] += by * found.by[t][column];
                }
            }
            taken += 1;
        }
    }
    let delay_at = problem.free.iter().position(|i| *i == DELAY);
    Ok(Some(Fitted { estimate, delay_at, blocks }))
}
