//! A controller for a range of speeds: a table of designs, linear between them.
//!
//! The table begins with both ends of the range and the speed of the model. The interval in whose middle
//! interpolation performs worst, compared with a design at that speed alone, is divided there, until
//! interpolation passes in all intervals. A design in the middle of an interval is either the reference of
//! that comparison or the next entry, so no search is lost.

mod frozen;
mod ramps;

use crate::Error;
use crate::closed_loop::feedforward::Advice;
use crate::closed_loop::simulate::Simulator;
use crate::design::ensemble::Ensemble;
use crate::design::options::DesignOptions;
use crate::design::target::{LEAST_RESERVE, capped};
use crate::design::{Tuned, advised, documented};
use crate::error::require;
use crate::plants::design_plant::DesignPlant;
use crate::requirement::Reached;
use steerwright_formats::{Document, OverSpeed, Pid, ScheduleEntry, SourceFile};
use steerwright_models::{PidParameters, PidSchedule};

/// Lowest speed of a range, m/s: below it limits and sideslip do not follow the speed.
const LOWEST_MPS: f64 = 1.0;
/// Least ratio of the ends of a range.
const LEAST_RATIO: f64 = 1.05;
/// Most entries of a table.
const MOST_ENTRIES: usize = 12;
/// Ratio of the speeds of neighbouring entries below which their interval is not divided: where the designs of
/// nearly the same speed differ, further entries do not help.
const LEAST_STEP: f64 = 1.1;
/// By how much the cost of interpolated gains may exceed that of a design at that speed alone. The cost of a
/// loop that keeps its requirements is mostly the logarithm of its settling time.
const ALLOWED_COST: f64 = 0.1;
/// By how much more, as a share of its bound and of its shortfall, interpolated gains may miss a requirement that
/// is out of reach.
const ALLOWED_SHORTFALL: f64 = 0.1;

/// Designs a controller for a range of speeds, m/s: gains and guidance at the speed of the model (the nearest
/// speed of the range), a table over speed, and evidence at and between its entries.
///
/// # Errors
/// [`Error::NotScheduled`] for a model that holds at one speed, [`Error::Option`] for the range, and as
/// [`design`](crate::design()) at each speed.
pub fn design_over_speeds(
    plant: &DesignPlant,
    source: &SourceFile,
    options: &DesignOptions,
    speeds: [f64; 2],
    now: &dyn Fn(&str),
) -> Result<Pid, Error> {
    options.check()?;
    let options = &options.with_actuator_of(plant);
    let plant = &plant.behind(options.actuator);
    let [low, high] = speeds;
    require(low >= LOWEST_MPS, "lowest speed", (low, " m/s"), "at least 1 m/s")?;
    let wide = high.is_finite() && high >= LEAST_RATIO * low;
    require(wide, "highest speed", (high, " m/s"), "at least 5 % above the lowest")?;
    let own = plant.speed.clamp(low, high);
    let mut starts = vec![low, own, high];
    starts.dedup();
    let (designs, limited) = Table { plant, options, now }.designs(&starts)?;
    let schedule: Vec<ScheduleEntry> = designs.iter().map(|d| d.entry(options)).collect();
    let at_own = designs.into_iter().find(|d| d.plant.speed == own);
    let Some(Design { plant: own_plant, tuned, .. }) = at_own else {
        return Err(Error::Optimiser(format!("the table has no entry at {own} m/s")));
    };
    now("evaluating the range of speeds");
    let mut pid = documented(&own_plant, source, options, tuned, schedule)?;
    if limited {
        pid.evidence.advice.push(format!(
            "between the {} entries of the table interpolation is worse than a design at each speed alone \
             by more than it should be: design for a narrower range, or for a faster actuator",
            pid.schedule.len()
        ));
    }
    let frozen = frozen::frozen(plant, &pid, options)?;
    let ramps = ramps::ramps(plant, &pid, speeds)?;
    pid.evidence.over_speed = Some(OverSpeed { met: frozen.iter().all(|f| f.met), frozen, ramps });
    pid.checked("the designed controller")?;
    Ok(pid)
}

/// The design at one speed alone.
struct Design {
    plant: DesignPlant,
    tuned: Tuned,
    /// Of its gains on the nominal plant.
    reached: Reached,
    cost: f64,
    /// Share of the plants of the ensemble that keep every requirement; 1 without an ensemble.
    kept: f64,
}

impl Design {
    fn entry(&self, options: &DesignOptions) -> ScheduleEntry {
        ScheduleEntry {
            speed_mps: self.plant.speed,
            gains: self.tuned.gains,
            yaw_rate_lag_s: self.tuned.limits.large_errors.map(|l| l.yaw_rate_lag_s),
            rate_reserve_time_s: self.tuned.limits.large_errors.map(|l| l.rate_reserve_time_s),
            guidance: advised(&self.tuned.feedforward, options),
        }
    }

    /// By how much gains interpolated to this speed are worse than its own; 0 if they pass.
    fn excess(&self, pid: &PidParameters, kept: f64) -> f64 {
        let objective = &self.tuned.objective;
        let interpolated = objective.whole(&mut Simulator::default(), pid);
        let missed: f64 = objective
            .required()
            .into_iter()
            .map(|(r, required)| {
                let alone = r.missed(required, self.reached.value(r));
                let missed = r.missed(required, interpolated.value(r));
                if alone > 0.0 {
                    let allowed = alone + ALLOWED_SHORTFALL * (1.0 + alone);
                    return ((missed - allowed) / (1.0 + alone)).max(0.0);
                }
                // A requirement that the design alone keeps comes first.
                if missed > 0.0 { 1.0 + capped(missed) } else { 0.0 }
            })
            .sum();
        let fewer = (self.kept - kept).max(0.0);
        if !self.tuned.found.met {
            // The cost of what is out of reach depends on more than the gains.
            return missed + fewer;
        }
        let variables = objective.variables(pid);
        let cost = objective.cost(&variables, &LEAST_RESERVE, f64::INFINITY);
        missed + fewer + (cost - self.cost - ALLOWED_COST).max(0.0)
    }
}

struct Table<'a> {
    plant: &'a DesignPlant,
    options: &'a DesignOptions,
    now: &'a dyn Fn(&str),
}

impl Table<'_> {
    /// `near` holds the gains at neighbouring speeds, where these are known.
    fn design(&self, speed: f64, near: &[PidParameters]) -> Result<Design, Error> {
        (self.now)(&format!("designing at {speed:.1} m/s"));
        let plant = self.plant.at_speed(speed)?;
        let tuned = Tuned::new(&plant, self.options, near)?;
        let objective = &tuned.objective;
        let reached = objective.whole(&mut Simulator::default(), &tuned.pid);
        let variables = objective.variables(&tuned.pid);
        let cost = objective.cost(&variables, &LEAST_RESERVE, f64::INFINITY);
        let kept = self.kept(&plant, &tuned, &tuned.pid, &tuned.feedforward)?;
        Ok(Design { plant, tuned, reached, cost, kept })
    }

    /// The design in the middle of an interval, and by how much interpolation is worse there.
    fn middle(&self, below: &Design, above: &Design) -> Result<(Design, f64), Error> {
        let speed = readable(0.5 * (below.plant.speed + above.plant.speed));
        let entries = [below, above].map(|d| (d.plant.speed, d.tuned.pid)).to_vec();
        let interpolated =
            PidSchedule::new(below.tuned.pid, entries).parameters_at(&below.tuned.pid, speed);
        let design = self.design(speed, &[interpolated])?;
        let share = (speed - below.plant.speed) / (above.plant.speed - below.plant.speed);
        let advice = between(&below.tuned.feedforward, &above.tuned.feedforward, share);
        let kept = self.kept(&design.plant, &design.tuned, &interpolated, &advice)?;
        let excess = design.excess(&interpolated, kept);
        Ok((design, excess))
    }

    /// Share of the plants of the ensemble at a speed that keep every requirement.
    fn kept(
        &self,
        plant: &DesignPlant,
        tuned: &Tuned,
        pid: &PidParameters,
        advice: &Advice,
    ) -> Result<f64, Error> {
        let ensemble = Ensemble::new(plant, self.options, &tuned.objective);
        ensemble.map_or(Ok(1.0), |e| Ok(e.kept(&tuned.objective, pid, advice)?.1))
    }

    /// The designs of the table, and whether their number was limited.
    fn designs(&self, starts: &[f64]) -> Result<(Vec<Design>, bool), Error> {
        let designs: Result<Vec<_>, Error> = starts.iter().map(|v| self.design(*v, &[])).collect();
        let mut designs = designs?;
        let middles: Result<Vec<_>, Error> =
            designs.windows(2).map(|pair| self.middle(&pair[0], &pair[1])).collect();
        let mut middles = middles?;
        loop {
            let speed = |k: usize| designs[k].plant.speed;
            let divisible = |k: &usize| {
                let wide = speed(k + 1) >= LEAST_STEP * speed(*k);
                middles[*k].1 > 0.0 && wide && designs.len() < MOST_ENTRIES
            };
            let all = (0..middles.len()).filter(divisible);
            let worst = all.max_by(|a, b| middles[*a].1.total_cmp(&middles[*b].1));
            let Some(worst) = worst else {
                let limited = middles.iter().any(|(_, excess)| *excess > 0.0);
                return Ok((designs, limited));
            };
            let (middle, _) = middles.remove(worst);
            let halves = [
                self.middle(&designs[worst], &middle)?,
                self.middle(&middle, &designs[worst + 1])?,
            ];
            designs.insert(worst + 1, middle);
            middles.splice(worst..worst, halves);
        }
    }
}

/// Preview, feedforward and path gains between two entries.
fn between(below: &Advice, above: &Advice, share: f64) -> Advice {
    let mix = |a: f64, b: f64| a + share * (b - a);
    Advice {
        feedforward_gain: mix(below.feedforward_gain, above.feedforward_gain),
        preview_time: mix(below.preview_time, above.preview_time),
        yaw_acceleration_gain: mix(below.yaw_acceleration_gain, above.yaw_acceleration_gain),
        yaw_jerk_gain: mix(below.yaw_jerk_gain, above.yaw_jerk_gain),
    }
}

/// A speed to a hundredth of a metre per second.
fn readable(speed: f64) -> f64 {
    (100.0 * speed).round() / 100.0
}
