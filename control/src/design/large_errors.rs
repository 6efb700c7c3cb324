//! What a controller does with errors beyond the step that it was designed for, chosen for the gains that
//! were found: the design and the steps of its specification do not depend on it.

use crate::closed_loop::scenario::{Step, simulated_step};
use crate::closed_loop::simulate::Simulator;
use crate::design::search::significant;
use crate::plants::sampled::Sampled;
use formats::{LargeErrors, Specification};
use vehicle_models::{PidParameters, time_at_largest_rate};

/// The largest error acted on at once, over the specification's step.
const BEYOND_STEP: f64 = 1.04;
/// Sustained rate over the largest. The multi-body cars of `tests/experiment/engagement.py` come back to the
/// road with an actuator of 3/8 of the rate stated.
const SUSTAINED: f64 = 0.35;
/// Reserve of time at the largest rate over what the specification's step takes, and the shortest, s: an
/// evasive manoeuvre steers from one side to the other.
const RESERVE: f64 = 1.3;
const LEAST_RESERVE_S: f64 = 0.15;

/// For gains on the plant that they were designed on.
pub(crate) fn large_errors(
    plant: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
) -> LargeErrors {
    let mut simulator = Simulator::default();
    simulated_step(&mut simulator, plant, pid, spec, Step::of(spec));
    let trace = &simulator.trace;
    let taken = time_at_largest_rate(pid, trace.steering_before, &trace.steering);
    LargeErrors {
        max_yaw_error_rad: significant(BEYOND_STEP * spec.step_rad, 5),
        sustained_rate_radps: significant(SUSTAINED * pid.largest_increment() / pid.sample_time, 5),
        rate_reserve_time_s: significant((RESERVE * taken).max(LEAST_RESERVE_S), 3),
    }
}
