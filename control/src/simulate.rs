//! The sampled closed loop, with the controller that runs in the FMU.
//!
//! Timing as under a Gauss–Seidel master: at tick k the controller sees the yaw of tick k, and its
//! output acts from tick k on (delayed by the plant's and the loop's delay). The loop is at rest
//! with reference 0 at tick −1.

use crate::sampled::Sampled;
use vehicle_models::{Pid, PidInput, PidParameters};

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
}

/// What the loop is driven with.
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
}

/// Scratch space, so that thousands of simulations allocate once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Simulator {
    state: Vec<f64>,
    next: Vec<f64>,
    pub(crate) trace: Trace,
}

/// Beyond this many times the step the loop has run away and the rest is not simulated.
const RUNAWAY: f64 = 100.0;

impl Simulator {
    /// Simulates from rest; the trace holds ticks 0 to `until`, fewer where the loop runs away.
    pub(crate) fn run(&mut self, plant: &Sampled, pid: &PidParameters, e: &Excitation) -> &Trace {
        let n = plant.order;
        let ts = plant.sample_time;
        let last = (e.until / ts).round() as usize;
        self.state.clear();
        self.state.resize(n, 0.0);
        self.next.clear();
        self.next.resize(n, 0.0);
        let trace = &mut self.trace;
        for column in
            [&mut trace.time, &mut trace.yaw_reference, &mut trace.yaw, &mut trace.steering]
        {
            column.clear();
            column.reserve(last + 1);
        }
        let bound = RUNAWAY * e.step.abs().max(e.ramp.abs() * e.until);
        let mut controller = Pid::default();
        controller.tick(pid, &PidInput { enabled: true, ..PidInput::default() });
        for k in 0..=last {
            let time = k as f64 * ts;
            let yaw = self.state[n - 1];
            let yaw_reference = e.step + e.ramp * time;
            let input =
                PidInput { yaw_reference, yaw, steering_feedforward: e.feedforward, enabled: true };
            let output = controller.tick(pid, &input);
            trace.time.push(time);
            trace.yaw_reference.push(yaw_reference);
            trace.yaw.push(yaw);
            trace.steering.push(output.steering_angle);
            let bounded = yaw.abs() <= bound;
            if !bounded {
                break;
            }
            let ago = |d: usize| if k >= d { trace.steering[k - d] } else { 0.0 };
            let (new, old) = (ago(plant.delay) + e.offset, ago(plant.delay + 1) + e.offset);
            let rows = plant.phi.chunks_exact(n);
            for (i, (next, row)) in self.next.iter_mut().zip(rows).enumerate() {
                *next = plant.gamma_old[i] * old + plant.gamma_new[i] * new;
                for (phi, x) in row.iter().zip(&self.state) {
                    *next += phi * x;
                }
            }
            std::mem::swap(&mut self.state, &mut self.next);
        }
        &self.trace
    }
}
