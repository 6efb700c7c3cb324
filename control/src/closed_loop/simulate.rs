//! The sampled closed loop, with the controller that runs in the FMU.
//!
//! Timing as under a Gauss–Seidel coupling: at tick k the controller sees the yaw of tick k, and its output acts
//! from tick k on. The loop is at rest with reference 0 at tick −1.

use crate::closed_loop::early_stopping::{Decay, StoppingBounds};
use crate::plants::sampled::Sampled;
use std::cell::RefCell;
use steerwright_models::{Pid, PidInput, PidParameters};

/// A response at the controller's ticks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Time, s.
    pub time: Vec<f64>,
    /// Yaw reference, rad.
    pub yaw_reference: Vec<f64>,
    /// Yaw, rad.
    pub yaw: Vec<f64>,
    /// Steering angle commanded at the tick, rad, in steering coordinates.
    pub steering: Vec<f64>,
    /// The same at the tick before the first.
    pub steering_before: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Excitation {
    /// Reference at tick 0, rad.
    pub(crate) step: f64,
    /// Its rate from there on, rad/s.
    pub(crate) ramp: f64,
    /// Constant steering feedforward from tick 0 on, rad.
    pub(crate) feedforward: f64,
    /// Constant unmeasured steering at the plant's input from time 0 on, rad.
    pub(crate) offset: f64,
    /// Last time of the trace, s.
    pub(crate) until: f64,
    /// Distance from the step within which a response at rest is not followed further, rad; 0 for none.
    pub(crate) quiet: f64,
}

/// Scratch space, so that thousands of simulations allocate once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Simulator {
    pub(crate) trace: Trace,
}

thread_local! {
    static SIMULATOR: RefCell<Simulator> = RefCell::default();
}

/// Runs simulations in the scratch space of the thread. Calls must not be nested.
pub(crate) fn with_simulator<R>(simulate: impl FnOnce(&mut Simulator) -> R) -> R {
    SIMULATOR.with_borrow_mut(simulate)
}

/// A response beyond this many times the step diverges; the rest is not simulated.
const RUNAWAY: f64 = 100.0;

impl Simulator {
    /// Simulates from rest; the trace holds ticks 0 to `until`, fewer where the loop diverges.
    pub(crate) fn run(&mut self, plant: &Sampled, pid: &PidParameters, e: &Excitation) -> &Trace {
        self.follow(plant, pid, e, &StoppingBounds::NONE);
        &self.trace
    }

    /// Simulates up to the first bound that is exceeded; returns whether none was.
    pub(crate) fn follow(
        &mut self,
        plant: &Sampled,
        pid: &PidParameters,
        e: &Excitation,
        bounds: &StoppingBounds,
    ) -> bool {
        let last = (e.until / plant.sample_time).round() as usize;
        let trace = &mut self.trace;
        for column in
            [&mut trace.time, &mut trace.yaw_reference, &mut trace.yaw, &mut trace.steering]
        {
            column.resize(last + 1, 0.0);
        }
        // Loops with a number of states known at compile time are several times as fast.
        let (ticks, to_the_end) = match plant.order {
            0..=4 => ticks(trace, &mut Small::<4>::from_plant(plant), plant, pid, e, bounds),
            5 => ticks(trace, &mut Small::<5>::from_plant(plant), plant, pid, e, bounds),
            6 => ticks(trace, &mut Small::<6>::from_plant(plant), plant, pid, e, bounds),
            7..=8 => ticks(trace, &mut Small::<8>::from_plant(plant), plant, pid, e, bounds),
            _ => ticks(trace, &mut Large::from_plant(plant), plant, pid, e, bounds),
        };
        for column in
            [&mut trace.time, &mut trace.yaw_reference, &mut trace.yaw, &mut trace.steering]
        {
            column.truncate(ticks);
        }
        to_the_end
    }
}

/// The plant's states, advanced tick by tick.
trait Motion {
    fn yaw(&self) -> f64;

    /// Advances to the next tick with the steering of the two ticks before it.
    fn advance(&mut self, old: f64, new: f64);
}

/// Up to N states, right-aligned so that the index of yaw is a constant. The unused ones stay at 0.
struct Small<const N: usize> {
    state: [f64; N],
    /// Φ, column by column.
    phi: [[f64; N]; N],
    gamma_old: [f64; N],
    gamma_new: [f64; N],
}

impl<const N: usize> Small<N> {
    fn from_plant(plant: &Sampled) -> Self {
        let n = plant.order.min(N);
        let rest = N - n;
        let column =
            |from: &[f64]| std::array::from_fn(|i| if i < rest { 0.0 } else { from[i - rest] });
        let phi = |i: usize, j: usize| {
            if i.min(j) < rest { 0.0 } else { plant.phi[(i - rest) * n + j - rest] }
        };
        Self {
            state: [0.0; N],
            phi: std::array::from_fn(|j| std::array::from_fn(|i| phi(i, j))),
            gamma_old: column(&plant.gamma_old),
            gamma_new: column(&plant.gamma_new),
        }
    }
}

impl<const N: usize> Motion for Small<N> {
    #[inline]
    fn yaw(&self) -> f64 {
        self.state[N - 1]
    }

    #[inline]
    fn advance(&mut self, old: f64, new: f64) {
        let mut next: [f64; N] = std::array::from_fn(|i| self.gamma_old[i] * old);
        for (column, x) in self.phi.iter().zip(self.state) {
            for (next, phi) in next.iter_mut().zip(column) {
                *next += phi * x;
            }
        }
        // The newest steering is added last: the sums before do not wait for it.
        for (next, gamma) in next.iter_mut().zip(self.gamma_new) {
            *next += gamma * new;
        }
        self.state = next;
    }
}

struct Large<'a> {
    plant: &'a Sampled,
    state: Vec<f64>,
    next: Vec<f64>,
}

impl<'a> Large<'a> {
    fn from_plant(plant: &'a Sampled) -> Self {
        Self { plant, state: vec![0.0; plant.order], next: vec![0.0; plant.order] }
    }
}

impl Motion for Large<'_> {
    fn yaw(&self) -> f64 {
        self.state[self.plant.order - 1]
    }

    fn advance(&mut self, old: f64, new: f64) {
        let p = self.plant;
        let rows = p.phi.chunks_exact(p.order);
        for (i, (next, row)) in self.next.iter_mut().zip(rows).enumerate() {
            *next = p.gamma_old[i] * old + p.gamma_new[i] * new;
            for (phi, x) in row.iter().zip(&self.state) {
                *next += phi * x;
            }
        }
        std::mem::swap(&mut self.state, &mut self.next);
    }
}

/// Ticks, and share of the time so far, for which a response must have been quiet.
const QUIET_TICKS: usize = 20;
const QUIET_SHARE: usize = 5;

/// Fills the trace. Returns the number of ticks until the end, until the loop has come to rest, or until it
/// diverges or exceeds a bound, and whether no bound was exceeded.
fn ticks(
    trace: &mut Trace,
    motion: &mut impl Motion,
    plant: &Sampled,
    pid: &PidParameters,
    e: &Excitation,
    bounds: &StoppingBounds,
) -> (usize, bool) {
    let (ts, share) = (plant.sample_time, e.step.recip());
    let bound = RUNAWAY * e.step.abs().max(e.ramp.abs() * e.until);
    let mut controller = Pid::default();
    let speed = plant.speed;
    controller.tick(pid, &PidInput { enabled: true, speed, ..PidInput::default() });
    let Trace { time, yaw_reference, yaw, steering, .. } = trace;
    let last = time.len() - 1;
    // Filled outside the loop over the ticks, which takes as long as it has instructions. Slices of one length need no check
    // of an index there.
    for (k, (time, reference)) in time.iter_mut().zip(yaw_reference.iter_mut()).enumerate() {
        *time = k as f64 * ts;
        *reference = e.step + e.ramp * *time;
    }
    let (time, yaw_reference) = (&time[..=last], &yaw_reference[..=last]);
    let (yaw, steering) = (&mut yaw[..=last], &mut steering[..=last]);
    let mut old = e.offset;
    let (mut loud, mut entered) = (0, false);
    let known_at = bounds.decay.map_or(usize::MAX, |decay| decay.tick());
    for k in 0..=last {
        yaw[k] = motion.yaw();
        let input = PidInput {
            yaw_reference: yaw_reference[k],
            yaw: yaw[k],
            steering_feedforward: e.feedforward,
            enabled: true,
            speed,
        };
        steering[k] = controller.tick(pid, &input).steering_angle;
        // Written so that NaN counts as diverged.
        let bounded = yaw[k].abs() <= bound;
        if !bounded {
            return (k + 1, true);
        }
        let reached = yaw[k] * share;
        let away = (reached - 1.0).abs();
        entered |= away <= bounds.entered.0;
        let beyond = reached > bounds.highest
            || away > bounds.settled.0 && time[k] > bounds.settled.1
            || !entered && time[k] > bounds.entered.1;
        let known = |d: Decay| d.error(&yaw[..=k]).is_some();
        if beyond || k == known_at && bounds.decay.is_some_and(known) {
            return (k + 1, false);
        }
        let off = (yaw[k] - e.step).abs();
        if off > e.quiet {
            loud = k;
        } else if k - loud > QUIET_TICKS.max(k / QUIET_SHARE) && e.quiet > 0.0 {
            // An overshoot that is still to come shows in the slope: extrapolated, the response must stay.
            let moved = (yaw[k] - yaw[loud + 1]).abs() / (k - loud - 1) as f64;
            if off + moved * (last - k) as f64 <= e.quiet {
                return (k + 1, true);
            }
        }
        let new = e.offset + if k >= plant.delay { steering[k - plant.delay] } else { 0.0 };
        motion.advance(old, new);
        old = new;
    }
    (last + 1, true)
}
