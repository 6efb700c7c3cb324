//! Estimation by the simulation error: Levenberg–Marquardt over the parameters and each segment's
//! initial states, from several initial estimates, of `Σ (y − ŷ)² + s²·Σ ((p − μ)/σ)²` with the
//! priors of [`crate::structures::bicycle::parameters`] and the long-run variance `s²` of the errors (their
//! spectral density at zero). That is twice the negative log posterior density up to the factor s².

use crate::Error;
use crate::data::statistics::long_run_variance;
use crate::linalg::dense::least_squares;
use crate::linalg::elimination::Elimination;
use crate::linalg::levenberg_marquardt::{Damping, USUAL, by_more_than, lower};
use crate::linalg::r_factor::RFactor;
use crate::structures::bicycle::parameters::{
    ALL, DELAY, FRONT, Geometry, INDEX, LAG, PARAMETERS, Prior, RATE, REAR, STEERING_FACTOR,
    STEERING_OFFSET, WHEELBASE, YAW_RATE_OFFSET, is_limited, priors,
};
use crate::structures::bicycle::simulate::{InitialState, SpeedSegment, sensitivities, yaw_rate};
use crate::structures::rate_limit;
use faer::Mat;
use steerwright_drivelog::signal::standard_deviation;

const STEPS: usize = 40;
/// Lag and delay that a servo of limited rate may have, s.
const LIMITED_LAG_S: f64 = 0.06;
/// [`Problem::least_gain`] of what is delivered.
const LEAST_GAIN: f64 = 1e-8;
/// Where initial estimates are compared, and refined again after.
pub(super) const COMPARED: f64 = 1e-4;
/// Largest step: of a logarithm, and of what is measured in its prior's deviations.
const LARGEST_STEP: f64 = 1.0;
/// Initial estimates that are refined, of those that are tried.
const REFINED: usize = 2;

#[derive(Clone)]
pub(super) struct Problem<'a> {
    pub(super) segments: Vec<SpeedSegment<'a>>,
    /// Share λ of the weight on the front axle.
    pub(super) share: f64,
    pub(super) priors: [Prior; PARAMETERS],
    /// Numbers of the parameters that are estimated, in ascending order.
    pub(super) free: Vec<usize>,
    /// Value of those that are not; of a stated wheelbase the value.
    pub(super) fixed: [f64; PARAMETERS],
    /// A step that lowers the sum by a smaller share is the last.
    pub(super) least_gain: f64,
}

/// What was found.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub(super) parameters: [f64; PARAMETERS],
    pub(super) initial_states: Vec<InitialState>,
    /// Long-run variance s² of the errors, per sample.
    pub(super) long_run_variance: f64,
    pub(super) cost: f64,
}

impl<'a> Problem<'a> {
    /// All free but the delay unless `delay`, and a stated wheelbase or else the steering factor.
    pub(super) fn new(
        segments: Vec<SpeedSegment<'a>>,
        share: f64,
        geometry: Geometry,
        delay: bool,
    ) -> Self {
        let priors = priors(geometry);
        let mut free = vec![FRONT, REAR, INDEX, LAG, STEERING_OFFSET, YAW_RATE_OFFSET];
        free.push(if geometry.wheelbase.is_some() { STEERING_FACTOR } else { WHEELBASE });
        if delay {
            free.push(DELAY);
        }
        free.sort_unstable();
        Self {
            segments,
            share,
            priors,
            free,
            fixed: priors.map(|p| p.mean),
            least_gain: LEAST_GAIN,
        }
    }

    pub(super) fn samples(&self) -> usize {
        self.segments.iter().map(SpeedSegment::len).sum()
    }

    /// Errors y − ŷ of all segments; `None` where the model leaves all bounds.
    pub(super) fn errors(
        &self,
        p: &[f64; PARAMETERS],
        initial_states: &[InitialState],
    ) -> Option<Vec<Vec<f64>>> {
        let of = |(s, start): (&SpeedSegment<'_>, &InitialState)| {
            let simulated = yaw_rate(p, self.share, s, start)?;
            Some(s.yaw_rate.iter().zip(&simulated).map(|(y, r)| y - r).collect())
        };
        self.segments.iter().zip(initial_states).map(of).collect()
    }

    fn cost(&self, p: &[f64; PARAMETERS], initial_states: &[InitialState], s2: f64) -> Option<f64> {
        let errors = self.errors(p, initial_states)?;
        let sum: f64 = errors.iter().flatten().map(|e| e * e).sum();
        let prior: f64 = self.free.iter().map(|&i| self.deviation(p, i).powi(2)).sum();
        let cost = sum + s2 * prior;
        if cost.is_finite() { Some(cost) } else { None }
    }

    /// (p − μ)/σ.
    fn deviation(&self, p: &[f64; PARAMETERS], i: usize) -> f64 {
        (p[i] - self.priors[i].mean) / self.priors[i].deviation
    }

    /// Estimates from several initial estimates.
    pub(super) fn solve(&self) -> Result<Estimate, Error> {
        let output: Vec<f64> = self.segments.iter().flat_map(|s| s.yaw_rate).copied().collect();
        // Before there are errors: a tenth of the signal, as if white.
        let s2 = (0.1 * standard_deviation(&output)).powi(2).max(f64::MIN_POSITIVE);
        let mut tried: Vec<Estimate> = self
            .candidates()
            .into_iter()
            .filter_map(|parameters| {
                let initial_states: Vec<InitialState> =
                    self.segments.iter().map(SpeedSegment::measured).collect();
                let cost = self.cost(&parameters, &initial_states, s2)?;
                Some(Estimate { parameters, initial_states, long_run_variance: s2, cost })
            })
            .collect();
        tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = self
            .best(tried.into_iter().take(REFINED))?
            .ok_or(Error::no_model("no bicycle follows this drive, not even roughly"))?;
        self.reweighted(best)
    }

    /// Estimates with the weight of the priors that follows from the errors, which hardly depend on it in turn.
    pub(super) fn reweighted(&self, mut best: Estimate) -> Result<Estimate, Error> {
        for _ in 0..2 {
            best = self.refine(self.with_own_variance(best), self.least_gain)?;
        }
        Ok(best)
    }

    /// An estimate with the weight of the priors that follows from its errors.
    pub(super) fn with_own_variance(&self, of: Estimate) -> Estimate {
        let Some(errors) = self.errors(&of.parameters, &of.initial_states) else { return of };
        let s2 = long_run_variance(&errors).max(f64::MIN_POSITIVE);
        let cost = self.cost(&of.parameters, &of.initial_states, s2).unwrap_or(of.cost);
        Estimate { long_run_variance: s2, cost, ..of }
    }

    /// An estimate of another problem with the cost that it has here; `None` where the model leaves all bounds.
    pub(super) fn weighed(&self, from: Estimate) -> Option<Estimate> {
        let cost = self.cost(&from.parameters, &from.initial_states, from.long_run_variance)?;
        Some(Estimate { cost, ..from })
    }

    /// Estimates the largest rate of the road wheels too.
    pub(super) fn free_rate(&mut self) {
        self.priors[RATE] = Prior {
            mean: rate_limit::PRIOR.mean.ln(),
            deviation: rate_limit::PRIOR.standard_deviation,
        };
        self.free.push(RATE);
    }

    /// Estimates the delay too, from an estimate without.
    pub(super) fn solve_with_delay(&self, without: &Estimate) -> Result<Estimate, Error> {
        // A long lag without a delay may be a delay: it is shared out in two ways. So may a largest rate, which leaves no lag.
        let lag = without.parameters[LAG].exp();
        let mut shares = vec![(lag, 0.0), (0.3 * lag, 0.7 * lag)];
        if is_limited(&without.parameters) {
            shares.push((LIMITED_LAG_S, LIMITED_LAG_S));
        }
        let shared = shares.into_iter().filter_map(|(lag, delay)| {
            let mut from = without.clone();
            from.parameters[DELAY] = delay;
            from.parameters[LAG] = lag.ln();
            self.weighed(from)
        });
        let best =
            self.best(shared)?.ok_or(Error::no_model("the bicycle with a delay diverges"))?;
        self.refine(best, self.least_gain)
    }

    /// Estimates from an estimate of a problem that differs a little; `None` where the model leaves all bounds
    /// there.
    pub(super) fn solve_from(&self, from: &Estimate) -> Result<Option<Estimate>, Error> {
        let weighed = self.weighed(from.clone());
        weighed.map(|from| self.refine(from, self.least_gain)).transpose()
    }

    fn best(&self, starts: impl Iterator<Item = Estimate>) -> Result<Option<Estimate>, Error> {
        let refined = starts.map(|s| self.refine(s, COMPARED)).collect::<Result<Vec<_>, _>>()?;
        Ok(refined.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)))
    }

    /// The steady turn by regression, with various tyres and steerings; and the priors' means.
    fn candidates(&self) -> Vec<[f64; PARAMETERS]> {
        let (length, gradient) = self.steady_turn();
        let mut all = vec![self.fixed];
        for front in [25.0_f64, 60.0, 130.0] {
            for lag in [0.02_f64, 0.1] {
                let mut p = self.fixed;
                p[FRONT] = front.ln();
                let wheelbase = if self.free.contains(&WHEELBASE) {
                    p[WHEELBASE] = length.ln();
                    length
                } else {
                    p[STEERING_FACTOR] = (self.fixed[WHEELBASE].exp() / length).ln();
                    self.fixed[WHEELBASE].exp()
                };
                // K = (β − α)/(α·β·L) for β.
                let rest = 1.0 - gradient * front * wheelbase;
                p[REAR] = (front / rest.max(0.2)).ln();
                p[LAG] = lag.ln();
                all.push(p);
            }
        }
        all
    }

    /// L and K of `δ = (L/v + K·v)·r + o` by least squares.
    fn steady_turn(&self) -> (f64, f64) {
        let rows: Vec<[f64; 4]> = self
            .segments
            .iter()
            .flat_map(|s| (0..s.len()).map(move |k| (s.speed[k], s.yaw_rate[k], s.steering[k])))
            .filter(|(v, _, _)| *v > 1.0)
            .map(|(v, r, delta)| [r / v, r * v, 1.0, delta])
            .collect();
        let a = Mat::from_fn(rows.len(), 3, |i, j| rows[i][j]);
        let b = Mat::from_fn(rows.len(), 1, |i, _| rows[i][3]);
        let wheelbase = self.fixed[WHEELBASE].exp();
        match least_squares(a.as_ref(), b.as_ref(), 1e-6) {
            Ok(x) if rows.len() > 3 && (0.5..20.0).contains(&x[(0, 0)]) => (x[(0, 0)], x[(1, 0)]),
            _ => (wheelbase, 0.002),
        }
    }

    /// Until a step lowers the cost by a smaller share than `least_gain`.
    pub(super) fn refine(&self, from: Estimate, least_gain: f64) -> Result<Estimate, Error> {
        let cost = from.cost;
        let reached = lower::<_, _, Error>(
            (from, cost),
            STEPS,
            Damping { first: 1e-3, fall: 0.1, tries: 10, ..USUAL },
            by_more_than(least_gain),
            |at, _| Ok(self.linearised(at)),
            |at, system, damping| {
                let solution = system.solve(damping)?;
                let scale = self.shortened(&solution.shared);
                let mut parameters = at.parameters;
                for (&i, step) in self.free.iter().zip(&solution.shared) {
                    parameters[i] += scale * step;
                }
                let moved_start = |(start, step): (&InitialState, &Vec<f64>)| {
                    std::array::from_fn(|i| start[i] + scale * step[i])
                };
                let initial_states: Vec<InitialState> =
                    at.initial_states.iter().zip(&solution.own).map(moved_start).collect();
                let cost = self.cost(&parameters, &initial_states, at.long_run_variance);
                let trial = |cost| (Estimate { parameters, initial_states, cost, ..*at }, cost);
                Ok(cost.map(trial))
            },
        )?;
        Ok(reached.point)
    }

    /// The factor that shortens a step, so that no parameter moves too far at once.
    fn shortened(&self, step: &[f64]) -> f64 {
        let largest = self
            .free
            .iter()
            .zip(step)
            .map(|(&i, s)| {
                let unit = match i {
                    DELAY | STEERING_OFFSET | YAW_RATE_OFFSET => self.priors[i].deviation,
                    _ => 1.0,
                };
                (s / unit).abs()
            })
            .fold(0.0, f64::max);
        if largest > LARGEST_STEP { LARGEST_STEP / largest } else { 1.0 }
    }

    fn linearised(&self, at: &Estimate) -> Option<Elimination> {
        const OWN: usize = ALL - PARAMETERS;
        let free = self.free.len();
        let s = at.long_run_variance.sqrt();
        let mut system = Elimination::new(free, OWN);
        for (k, (segment, start)) in self.segments.iter().zip(&at.initial_states).enumerate() {
            let found = self.sensitivities(&at.parameters, segment, start)?;
            let mut rows = RFactor::new(OWN + free + 1);
            let mut row = vec![0.0; OWN + free + 1];
            for (t, by) in found.by.iter().enumerate() {
                row[..OWN].copy_from_slice(&by[PARAMETERS..]);
                for (value, &i) in row[OWN..].iter_mut().zip(&self.free) {
                    *value = by[i];
                }
                row[OWN + free] = segment.yaw_rate[t] - found.yaw_rate[t];
                rows.push(&row);
            }
            // The priors come with the first segment's rows.
            if k == 0 {
                for (j, &i) in self.free.iter().enumerate() {
                    row.fill(0.0);
                    row[OWN + j] = s / self.priors[i].deviation;
                    row[OWN + free] = -s * self.deviation(&at.parameters, i);
                    rows.push(&row);
                }
            }
            system.segment(rows.finish().as_ref());
        }
        Some(system)
    }

    pub(super) fn sensitivities(
        &self,
        p: &[f64; PARAMETERS],
        segment: &SpeedSegment<'_>,
        start: &InitialState,
    ) -> Option<crate::structures::bicycle::simulate::Sensitivities> {
        sensitivities(p, self.share, segment, start, self.free.contains(&DELAY))
    }

    /// The best initial states for given parameters; `None` where the model leaves all bounds.
    pub(super) fn initial_states(
        &self,
        p: &[f64; PARAMETERS],
    ) -> Result<Option<Vec<InitialState>>, Error> {
        let mut all = Vec::new();
        for segment in &self.segments {
            let from = segment.measured();
            let Some(found) = sensitivities(p, self.share, segment, &from, false) else {
                return Ok(None);
            };
            let by = Mat::from_fn(segment.len(), 2, |t, j| found.by[t][PARAMETERS + j]);
            let rest =
                Mat::from_fn(segment.len(), 1, |t, _| segment.yaw_rate[t] - found.yaw_rate[t]);
            let step = least_squares(by.as_ref(), rest.as_ref(), 1e-9)?;
            all.push(std::array::from_fn(|i| from[i] + step[(i, 0)]));
        }
        Ok(Some(all))
    }
}
