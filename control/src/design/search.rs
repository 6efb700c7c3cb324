//! One search for the best controller on given plants: where it starts, and the controller that it finds.

use crate::Error;
use crate::closed_loop::simulate::Simulator;
use crate::design::bandwidth_limit::CROSSOVER_TIMES_SETTLING;
use crate::design::objective::{Objective, VARIABLES};
use crate::design::optimiser::{Effort, minimise, sequence};
use crate::design::target::{Target, capped};
use crate::requirement::Reached;
use steerwright_formats::{PidGains, Requirement};
use steerwright_models::PidParameters;

/// Digits of the gains, and of gains that just miss a requirement with so few.
const READABLE_DIGITS: i32 = 5;
const EXACT_DIGITS: i32 = 12;

/// Starting points about a multiple of the objective's scale: an initial guess and `count` others.
pub(crate) fn starts(objective: &Objective, multiple: f64, count: u32, seed: u64) -> Vec<Vec<f64>> {
    let (t, ts) = (multiple * objective.scale, objective.sample_time);
    // A crossover that settles in time, a reset that removes an offset within the 5 s, a little
    // lead; and the lag of a fast pole at the crossover, which cancels the slow pole of the reset.
    let crossover = CROSSOVER_TIMES_SETTLING / t;
    let guess = [crossover, 0.8 / t, 0.05 * t, 0.01 * t + ts, 0.2 * t].map(f64::ln);
    let ranges = [(3.0, 10.0), (0.3, 1.5), (0.02, 0.3), (0.01, 0.05), (0.1, 0.4)];
    let mut box_ = [(0.0, 0.0); VARIABLES];
    for (i, ((low, high), bounds)) in ranges.into_iter().zip(objective.bounds()).enumerate() {
        let unit = if i < 2 { 1.0 / t } else { t };
        box_[i] = ((low * unit).max(bounds.0).ln(), (high * unit).min(bounds.1).max(bounds.0).ln());
    }
    let mut starts = vec![guess.to_vec()];
    starts.extend(sequence(&box_, count, seed));
    starts
}

/// A controller, its decision variables, and what it reaches on the nominal plant.
#[derive(Debug, Clone)]
pub(crate) struct FoundDesign {
    pub(crate) pid: PidParameters,
    pub(crate) variables: Vec<f64>,
    pub(crate) reached: Reached,
    pub(crate) met: bool,
    /// The next best points of the search, as starting points of another.
    pub(crate) others: Vec<Vec<f64>>,
}

impl FoundDesign {
    /// The best controller of a search from these starting points.
    pub(crate) fn by_search(
        objective: &Objective,
        target: &Target,
        starts: &[Vec<f64>],
        effort: Effort,
    ) -> Result<Self, Error> {
        let points = minimise(&|x, most| objective.cost(x, target, most), starts, effort)?;
        Ok(Self::new(objective, points.into_iter().map(|(x, _)| x).collect()))
    }

    /// The controller of the first of these points, rounded unless that breaks a requirement.
    pub(crate) fn new(objective: &Objective, mut points: Vec<Vec<f64>>) -> Self {
        // A search always returns a point.
        let variables = if points.is_empty() { Vec::new() } else { points.remove(0) };
        let mut simulator = Simulator::default();
        let mut finish = |digits| {
            let pid = rounded(&objective.controller(&variables).0, digits);
            let reached = objective.whole(&mut simulator, &pid);
            (pid, reached, reached.shortfalls(&objective.spec).len())
        };
        let mut best = finish(READABLE_DIGITS);
        if best.2 > 0 {
            let exact = finish(EXACT_DIGITS);
            if exact.2 < best.2 {
                best = exact;
            }
        }
        let (pid, reached, short) = best;
        Self { pid, variables, reached, met: short == 0, others: points }
    }

    /// By how much the requirements are missed, summed without the settling time.
    pub(crate) fn missed(&self, objective: &Objective) -> f64 {
        let missed =
            |(r, required): (Requirement, f64)| capped(r.missed(required, self.reached.value(r)));
        objective
            .required()
            .into_iter()
            .filter(|(r, _)| *r != Requirement::Settling)
            .map(missed)
            .sum()
    }
}

/// Gains rounded to some significant digits.
fn rounded(pid: &PidParameters, digits: i32) -> PidParameters {
    let round = |value| significant(value, digits);
    let gains = PidGains {
        kp: round(pid.gains.kp),
        ki: round(pid.gains.ki),
        kd: round(pid.gains.kd),
        derivative_filter_time_s: round(pid.gains.derivative_filter_time_s),
        setpoint_weight_proportional: round(pid.gains.setpoint_weight_proportional),
        anti_windup_time_s: round(pid.gains.anti_windup_time_s),
        ..pid.gains
    };
    PidParameters { gains, ..*pid }
}

/// A number to some significant digits.
pub(crate) fn significant(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10.0_f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    // Dividing keeps decimal numbers short: 0.3 and not 0.30000000000000004.
    (value * scale).round() / scale
}
