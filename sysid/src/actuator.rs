//! The steering actuator, from the command beside the measured angle of a drive: `T δ̇ + δ = g u(t − τ) + c`, and no faster
//! than its largest rate. The error of the simulation from the command is made small over all segments; standard errors are
//! those of the scatter of the scores' sums over blocks of time.

use crate::Error;
use crate::data::fit_percent;
use crate::linalg::dense::{identity, least_squares, r_factor, solve};
use crate::linalg::levenberg_marquardt::{USUAL, by_more_than, lower};
use crate::pem::damped_step;
use faer::Mat;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{BLOCK_S, IdentifiedActuator, LEAST_BLOCKS};

/// Time constants and delays from which the search starts, s.
const LAGS_S: [f64; 4] = [0.01, 0.04, 0.15, 0.5];
const DELAYS_S: [f64; 12] = [0.0, 0.01, 0.02, 0.04, 0.06, 0.09, 0.12, 0.17, 0.25, 0.4, 0.6, 0.9];
/// Bounds of both, s.
const LAG_BOUNDS_S: [f64; 2] = [0.001, 3.0];
const LONGEST_DELAY_S: f64 = 1.5;
/// Start of a segment whose errors are those of the unknown past, s.
const SETTLING_S: f64 = 1.0;
/// Share of a step from which the samples of the command are those of the log.
const LEAST_PERIOD: f64 = 0.9;
const STEPS: usize = 60;
const LEAST_GAIN: f64 = 1e-7;
/// Squared errors of one reading of the command over those of the other below which it is the right one: both err by
/// what the command does between its samples.
const DECISIVE: f64 = 0.7;
/// Standard errors by which a largest rate has to lower the squared errors.
const SIGNIFICANT: f64 = 3.0;

/// The actuator of a log with a steering command beside its measured angle; `None` without one. What cannot be identified
/// is a warning.
pub(crate) fn identified_actuator(
    log: &DriveLog,
    warnings: &mut Vec<String>,
) -> Option<IdentifiedActuator> {
    let command = log.others.get(&Role::SteeringCommand)?;
    let angle = log.others.get(&Role::Steering).unwrap_or(&log.input);
    let channel = log.channels.iter().find(|c| c.role == Role::SteeringCommand.key());
    let period_s = channel.map_or(log.sample_time_s, |c| 1.0 / c.rate_hz);
    let found =
        Problem::new(log, command, angle).and_then(|problem| problem.of_best_reading(period_s));
    match found {
        Ok(actuator) => {
            warnings.extend(actuator.fault().map(|fault| {
                format!(
                    "{fault}: no controller is designed for the actuator of the steering command"
                )
            }));
            Some(actuator)
        }
        Err(error) => {
            warnings.push(format!("no actuator is identified from the steering command: {error}"));
            None
        }
    }
}

/// Command and measured angle of a run without a gap.
#[derive(Clone)]
struct ActuatorRun<'a> {
    command: &'a [f64],
    angle: &'a [f64],
    /// Samples at its start that count for nothing.
    settling: usize,
}

impl ActuatorRun<'_> {
    /// The command at a time in steps, on a straight line between its samples.
    fn command_at(&self, steps: f64) -> f64 {
        let steps = steps.clamp(0.0, (self.command.len() - 1) as f64);
        let before = steps.floor() as usize;
        let after = (before + 1).min(self.command.len() - 1);
        let share = steps - steps.floor();
        (1.0 - share) * self.command[before] + share * self.command[after]
    }
}

#[derive(Clone)]
struct Problem<'a> {
    runs: Vec<ActuatorRun<'a>>,
    step_s: f64,
    /// Whether the command goes on straight between its samples, as one that is logged more slowly than it is set;
    /// otherwise it is held.
    moves_on: bool,
}

/// Parts of a step in which a command that moves on is held.
const PARTS: usize = 4;

/// A lag behind a delay, within a largest rate.
#[derive(Clone, Copy)]
struct Parameters {
    lag_s: f64,
    delay_s: f64,
    gain: f64,
    offset_rad: f64,
    max_rate_radps: Option<f64>,
}

impl Parameters {
    /// Moved along the coordinates: logarithms of lag and rate.
    fn moved(&self, by: &[f64]) -> Self {
        let [shortest, longest] = LAG_BOUNDS_S;
        Self {
            lag_s: (self.lag_s * by[0].clamp(-3.0, 3.0).exp()).clamp(shortest, longest),
            delay_s: (self.delay_s + by[1]).clamp(0.0, LONGEST_DELAY_S),
            gain: self.gain + by[2],
            offset_rad: self.offset_rad + by[3],
            max_rate_radps: self
                .max_rate_radps
                .map(|rate| rate * by.get(4).copied().unwrap_or_default().clamp(-1.0, 1.0).exp()),
        }
    }

    fn count(&self) -> usize {
        if self.max_rate_radps.is_some() { 5 } else { 4 }
    }

    /// The angle after a time in which the command is held.
    fn advanced(&self, angle: f64, command: f64, time_s: f64) -> f64 {
        let aim = self.gain * command + self.offset_rad;
        let behind = aim - angle;
        let slow = self.max_rate_radps.map_or(f64::INFINITY, |rate| rate * self.lag_s);
        if behind.abs() <= slow {
            return aim - behind * (-time_s / self.lag_s).exp();
        }
        // At the largest rate, until the lag alone is slower.
        let rate = slow / self.lag_s;
        let at_rate_s = (behind.abs() - slow) / rate;
        if time_s <= at_rate_s {
            return angle + behind.signum() * rate * time_s;
        }
        aim - behind.signum() * slow * (-(time_s - at_rate_s) / self.lag_s).exp()
    }
}

impl<'a> Problem<'a> {
    fn new(log: &DriveLog, command: &'a [f64], angle: &'a [f64]) -> Result<Self, Error> {
        let step_s = log.sample_time_s;
        let settling = (SETTLING_S / step_s).ceil() as usize;
        let runs: Vec<_> = log
            .segments
            .iter()
            .map(|segment| segment.range.clone())
            .filter(|range| range.len() > 2 * settling)
            .map(|range| ActuatorRun {
                command: &command[range.clone()],
                angle: &angle[range],
                settling,
            })
            .collect();
        let moves = |signal: fn(&ActuatorRun<'a>) -> &'a [f64]| {
            runs.iter().any(|run| standard_deviation(signal(run)) > 0.0)
        };
        if !moves(|run| run.command) || !moves(|run| run.angle) {
            return Err(Error::no_model(
                "there is no segment of more than 2 s in which command and angle move",
            ));
        }
        Ok(Self { runs, step_s, moves_on: false })
    }

    /// The simulated angle of each run, from the measured one at its start.
    fn simulated(&self, p: &Parameters) -> Vec<Vec<f64>> {
        let steps = p.delay_s / self.step_s;
        let whole = steps.floor();
        let late_s = (steps - whole) * self.step_s;
        let whole = whole as usize;
        let of = |run: &ActuatorRun<'_>| {
            let mut angle = run.angle[0];
            let mut all = Vec::with_capacity(run.angle.len());
            for k in 0..run.angle.len() {
                all.push(angle);
                if self.moves_on {
                    let part = 1.0 / PARTS as f64;
                    for j in 0..PARTS {
                        let middle = k as f64 + part * (j as f64 + 0.5) - steps;
                        angle = p.advanced(angle, run.command_at(middle), part * self.step_s);
                    }
                    continue;
                }
                let before = run.command[k.saturating_sub(whole + 1)];
                let command = run.command[k.saturating_sub(whole)];
                angle = p.advanced(angle, before, late_s);
                angle = p.advanced(angle, command, self.step_s - late_s);
            }
            all
        };
        self.runs.iter().map(of).collect()
    }

    /// Measured minus simulated angle of the samples that count, run by run.
    fn errors(&self, p: &Parameters) -> Vec<f64> {
        let simulated = self.simulated(p);
        let pairs = self.runs.iter().zip(&simulated);
        pairs
            .flat_map(|(run, own)| {
                run.angle.iter().zip(own).skip(run.settling).map(|(measured, own)| measured - own)
            })
            .collect()
    }

    fn cost(&self, p: &Parameters) -> f64 {
        self.errors(p).iter().map(|e| e * e).sum()
    }

    /// Gain and offset of least squares at a lag and delay without a largest rate.
    fn start(&self, lag_s: f64, delay_s: f64) -> Result<Parameters, Error> {
        let plain = Parameters { lag_s, delay_s, gain: 1.0, offset_rad: 0.0, max_rate_radps: None };
        let simulated = self.simulated(&plain);
        let rows: Vec<[f64; 2]> = self
            .runs
            .iter()
            .zip(&simulated)
            .flat_map(|(run, own)| {
                own.iter().copied().zip(run.angle.iter().copied()).skip(run.settling)
            })
            .map(|(own, measured)| [own, measured])
            .collect();
        let a = Mat::from_fn(rows.len(), 2, |i, j| if j == 0 { rows[i][0] } else { 1.0 });
        let b = Mat::from_fn(rows.len(), 1, |i, _| rows[i][1]);
        let x = least_squares(a.as_ref(), b.as_ref(), 1e-12)?;
        Ok(Parameters { gain: x[(0, 0)], offset_rad: x[(1, 0)], ..plain })
    }

    /// Derivatives of the errors by the coordinates and, last, the errors.
    fn derivatives(&self, p: &Parameters) -> Mat<f64> {
        let count = p.count();
        let steps = [1e-4, 1e-2 * self.step_s, 1e-4, 1e-6, 1e-4];
        let columns: Vec<Vec<f64>> = (0..count)
            .map(|j| {
                let moved = |by: f64| {
                    let mut all = vec![0.0; count];
                    all[j] = by;
                    p.moved(&all)
                };
                let (up, down) = (moved(steps[j]), moved(-steps[j]));
                // At a bound one of both stays.
                let width = match j {
                    0 => (up.lag_s / down.lag_s).ln(),
                    1 => up.delay_s - down.delay_s,
                    _ => 2.0 * steps[j],
                };
                let errors = self.errors(&down).into_iter().zip(self.errors(&up));
                errors.map(|(down, up)| (down - up) / width.max(1e-12)).collect()
            })
            .collect();
        let errors = self.errors(p);
        Mat::from_fn(
            errors.len(),
            count + 1,
            |i, j| if j < count { columns[j][i] } else { errors[i] },
        )
    }

    fn refined(&self, start: Parameters) -> Result<(Parameters, f64), Error> {
        let reached = lower(
            (start, self.cost(&start)),
            STEPS,
            USUAL,
            by_more_than(LEAST_GAIN),
            |p: &Parameters, _| Ok::<_, Error>(Some(r_factor(self.derivatives(p).as_ref()))),
            |p, r, damping| {
                let n = p.count();
                let step = damped_step(r.get(..n, ..n), r.get(..n, n..), damping, 0)?;
                let next = p.moved(&step);
                let cost = self.cost(&next);
                Ok(Some((next, cost)).filter(|_| cost.is_finite()))
            },
        )?;
        Ok((reached.point, reached.cost))
    }

    /// The actuator with the command held between its samples or moving on, whichever explains the angle; of a command with
    /// more samples than the log has steps both are nearly the same.
    fn of_best_reading(self, period_s: f64) -> Result<IdentifiedActuator, Error> {
        let held = self.identified();
        if period_s < LEAST_PERIOD * self.step_s {
            let mut actuator = self.actuator(&held?)?;
            actuator.delay_standard_error_s =
                actuator.delay_standard_error_s.hypot(0.25 * period_s);
            return Ok(actuator);
        }
        let moving = Self { moves_on: true, ..self.clone() };
        let (held, moves_on) = match (held, moving.identified()) {
            (Ok(held), Ok(moves_on)) => (held, moves_on),
            (Ok(held), Err(_)) => return self.actuator(&held),
            (Err(_), moves_on) => return moving.actuator(&moves_on?),
        };
        let [of_held, of_moving] = [self.squares(&held), moving.squares(&moves_on)];
        let mean_squares = [mean(&of_held), mean(&of_moving)];
        let is_moving = mean_squares[1] < mean_squares[0];
        let mut actuator =
            if is_moving { moving.actuator(&moves_on) } else { self.actuator(&held) }?;
        if is_moving {
            // It is held for some part of the period.
            actuator.delay_standard_error_s =
                actuator.delay_standard_error_s.hypot(0.125 * period_s);
        }
        let [least, other] = if is_moving { [1, 0] } else { [0, 1] }.map(|i| mean_squares[i]);
        if least > DECISIVE * other {
            // Either of two delays.
            let [a, b] = [held.delay_s, moves_on.delay_s];
            actuator.delay_s = 0.5 * (a + b);
            actuator.delay_standard_error_s = actuator.delay_standard_error_s.hypot(0.5 * (a - b));
        }
        Ok(actuator)
    }

    fn squares(&self, p: &Parameters) -> Vec<f64> {
        self.errors(p).iter().map(|e| e * e).collect()
    }

    /// By how many of its standard errors the second of two squared errors is smaller; `None` where there are too few blocks
    /// of time.
    fn gain_in_deviations(&self, first: &[f64], second: &[f64]) -> Option<f64> {
        let gain = |range: std::ops::Range<usize>| range.map(|t| first[t] - second[t]).sum::<f64>();
        let gains: Vec<f64> = self.blocks(first.len()).map(gain).collect();
        let error = standard_deviation(&gains) / (gains.len() as f64).sqrt();
        if gains.len() >= LEAST_BLOCKS {
            Some(mean(&gains) / error.max(f64::MIN_POSITIVE))
        } else {
            None
        }
    }

    fn identified(&self) -> Result<Parameters, Error> {
        let mut starts = Vec::new();
        for lag_s in LAGS_S {
            for delay_s in DELAYS_S {
                let start = self.start(lag_s, delay_s)?;
                starts.push((self.cost(&start), start));
            }
        }
        let best = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, start)) = best else { return Err(Error::no_model("no finite start")) };
        let (free, _) = self.refined(start)?;
        Ok(self.limited(&free)?.unwrap_or(free))
    }

    fn actuator(&self, found: &Parameters) -> Result<IdentifiedActuator, Error> {
        let deviations = self.standard_errors(found)?;
        let errors = self.errors(found);
        let measured: Vec<f64> =
            self.runs.iter().flat_map(|run| run.angle[run.settling..].iter().copied()).collect();
        let simulated: Vec<f64> = measured.iter().zip(&errors).map(|(y, e)| y - e).collect();
        Ok(IdentifiedActuator {
            time_constant_s: found.lag_s,
            time_constant_standard_error_s: (found.lag_s * deviations[0])
                .min(found.lag_s + self.step_s),
            delay_s: found.delay_s,
            delay_standard_error_s: deviations[1],
            gain: found.gain,
            max_rate_radps: found.max_rate_radps,
            fit: fit_percent(&measured, &simulated),
        })
    }

    /// The actuator with a largest rate, where that lowers the errors by more than chance.
    fn limited(&self, free: &Parameters) -> Result<Option<Parameters>, Error> {
        let simulated = self.simulated(free);
        let rates = simulated
            .iter()
            .flat_map(|run| run.windows(2))
            .map(|pair| (pair[1] - pair[0]).abs() / self.step_s);
        let fastest = rates.fold(0.0, f64::max);
        let mut best: Option<(Parameters, f64)> = None;
        for share in [0.9, 0.6, 0.35] {
            for lag_s in [free.lag_s, 0.3 * free.lag_s] {
                let start = Parameters { lag_s, max_rate_radps: Some(share * fastest), ..*free };
                let found = self.refined(start)?;
                if best.as_ref().is_none_or(|(_, cost)| found.1 < *cost) {
                    best = Some(found);
                }
            }
        }
        let Some((limited, _)) = best
            .filter(|(p, _)| p.max_rate_radps < Some(fastest) && p.lag_s > 1.01 * LAG_BOUNDS_S[0])
        else {
            return Ok(None);
        };
        let gain = self.gain_in_deviations(&self.squares(free), &self.squares(&limited));
        Ok(Some(limited).filter(|_| gain > Some(SIGNIFICANT)))
    }

    /// Standard errors along the coordinates.
    fn standard_errors(&self, p: &Parameters) -> Result<Vec<f64>, Error> {
        let n = p.count();
        let all = self.derivatives(p);
        let r = r_factor(all.as_ref());
        let gram = r.get(..n, ..n).transpose() * r.get(..n, ..n);
        let inverse = solve(gram.as_ref(), identity(n).as_ref());
        let blocks: Vec<_> = self.blocks(all.nrows()).collect();
        let count = blocks.len() as f64;
        let mut scatter = Mat::<f64>::zeros(n, n);
        for range in blocks {
            let sum: Vec<f64> =
                (0..n).map(|j| range.clone().map(|t| all[(t, j)] * all[(t, n)]).sum()).collect();
            for j in 0..n {
                for i in 0..n {
                    scatter[(i, j)] += sum[i] * sum[j];
                }
            }
        }
        let covariance = &inverse * &scatter * &inverse;
        let few = count / (count - 1.0).max(1.0);
        let all: Vec<f64> = (0..n).map(|j| (few * covariance[(j, j)]).max(0.0).sqrt()).collect();
        if all.iter().any(|deviation| !deviation.is_finite()) {
            return Err(Error::no_model("command and angle do not determine a lag"));
        }
        Ok(all)
    }

    /// Blocks of the samples that count.
    fn blocks(&self, samples: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
        let length = ((BLOCK_S / self.step_s).ceil() as usize).max(1);
        let count = (samples / length).max(1);
        (0..count).map(move |b| b * samples / count..(b + 1) * samples / count)
    }
}
