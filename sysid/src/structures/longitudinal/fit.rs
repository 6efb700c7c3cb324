//! Least squares of the prediction errors, and the covariance of the parameters.

use crate::Error;
use crate::linalg::bounded_step::{Normal, bounded_step};
use crate::linalg::dual::{Dual, Scalar};
use crate::linalg::levenberg_marquardt::{Damping, USUAL, lower};
use crate::linalg::sandwich::{ScoreBin, andrews_lags, sandwich};
use crate::structures::longitudinal::model::{
    BRAKE_DELAY, BRAKE_GAIN, BRAKE_LAG, COUNT, DELAY, DRAG, GRADE, LAG, PEDAL, Point, RESISTANCE,
    RESISTANCE_PER_SPEED, Schedule, Simulation,
};
use crate::structures::longitudinal::noise::{self, Noise};
use crate::structures::longitudinal::signals::{Piece, Signals, samples};
use crate::structures::longitudinal::start::{priors, schedules};
use faer::Mat;
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{Estimate, Intersample, NORMAL_95};

/// Steps of each search.
const STEPS: usize = 30;
/// A step that lowers the cost, half a sum of squares in deviations, by less is the last.
const LEAST_GAIN: f64 = 1e-4;
/// Time over which scores are summed, s.
const BIN_S: f64 = 1.0;
/// Delays that the search begins with, s.
const DELAYS: [f64; 4] = [0.05, 0.2, 0.45, 0.75];
/// Rounds of parameters and noise in turn.
const ROUNDS: usize = 3;
/// Standard deviation of g·sin(grade) from which the coefficient of the grade is estimated, m/s².
const LEAST_GRAVITY: f64 = 0.03;

/// The estimate.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) schedule: Schedule,
    pub(super) point: Point,
    /// Places of the parameters that are estimated.
    pub(super) free: Vec<usize>,
    pub(super) priors: [Normal; COUNT],
    /// COUNT by COUNT, zeros of those that are not estimated.
    pub(super) covariance: Mat<f64>,
    pub(super) noise: Noise,
    /// Share of each gain in what the command does on the estimation data.
    pub(super) shares: Vec<f64>,
    /// Longest period of accelerator and brake, s, where the log does not show whether they are held over it.
    pub(super) open_hold_s: Option<f64>,
}

/// The least-squares problem of one schedule and noise.
struct Problem<'a> {
    signals: &'a Signals<'a>,
    pieces: &'a [Piece],
    schedule: Schedule,
    noise: Noise,
    free: Vec<usize>,
    priors: [Normal; COUNT],
}

struct Normals {
    gradient: Point,
    hessian: [[f64; COUNT]; COUNT],
}

impl Fit {
    pub(super) fn estimate(signals: &Signals<'_>, pieces: &[Piece]) -> Result<Self, Error> {
        let failed = || Error::Numerical { what: "the longitudinal model" };
        let schedule = Schedule::Speeds(vec![0.0]);
        let mut problem = Problem::new(signals, pieces, schedule);
        let mut best: Option<(Point, f64)> = None;
        for delay in DELAYS {
            let mut start = problem.priors.map(|prior| prior.mean);
            start[DELAY] = delay;
            let Some(now) = problem.refined(&start) else { continue };
            if best.is_none_or(|(_, cost)| now.1 < cost) {
                best = Some(now);
            }
        }
        let (mut point, _) = best.ok_or_else(failed)?;
        point = problem.alternated(point, ROUNDS).ok_or_else(failed)?;
        // Simpler models go before others that are hardly better.
        let mut cost = problem.criterion(&point).ok_or_else(failed)?;
        for schedule in schedules(signals, pieces) {
            let gain = average_gain(&problem.schedule, &point);
            let mut other = Problem::new(signals, pieces, schedule);
            other.noise = problem.noise;
            let mut start = point;
            start[..other.schedule.len()].fill(gain);
            let Some((found, _)) = other.refined(&start) else { continue };
            let Some(now) = other.criterion(&found) else { continue };
            if now < cost {
                (problem.schedule, problem.free) = (other.schedule, other.free);
                (point, cost) = (found, now);
            }
        }
        let further: &[usize] = if signals.is_acceleration { &[] } else { &[PEDAL] };
        for place in further.iter().chain(&[RESISTANCE_PER_SPEED]) {
            let without = problem.free.clone();
            problem.free.push(*place);
            let refined = problem.refined(&point).map(|(found, _)| found);
            match refined.map(|found| (found, problem.criterion(&found))) {
                Some((found, Some(now))) if now < cost => (point, cost) = (found, now),
                _ => problem.free = without,
            }
        }
        problem.free.sort_unstable();
        point = problem.alternated(point, ROUNDS).ok_or_else(failed)?;
        let mut covariance = problem.covariance(&point)?;
        let open_hold_s = widen_delays(&mut covariance, signals.log);
        let shares = problem.shares_of_gains();
        let Problem { schedule, noise, free, priors, .. } = problem;
        Ok(Self { schedule, point, free, priors, covariance, noise, shares, open_hold_s })
    }

    /// Mean of the gains as they are used, and its standard error.
    pub(super) fn mean_gain(&self) -> Estimate {
        let (mut value, mut variance) = (0.0, 0.0);
        for (i, share) in self.shares.iter().enumerate() {
            value += share * self.point[i];
            for (j, other) in self.shares.iter().enumerate() {
                variance += share * other * self.covariance[(i, j)];
            }
        }
        Estimate { value, standard_error: variance.max(0.0).sqrt() }
    }

    pub(super) fn standard_error(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0).sqrt()
    }
}

/// Widens the 95 % bands of the delays by what they are longer if an input is held that was read as moving on between its
/// samples: half a period. Returns the longest period.
///
/// Both fit equally well, since a delay of half a period is all that they differ by below half of the sample rate.
fn widen_delays(covariance: &mut Mat<f64>, log: &DriveLog) -> Option<f64> {
    let mut longest_s: Option<f64> = None;
    for (role, place) in [(Role::LongitudinalCommand, DELAY), (Role::Brake, BRAKE_DELAY)] {
        let Some(period_s) = log.assumed_period_s(role, Intersample::Bl) else { continue };
        longest_s = Some(longest_s.map_or(period_s, |longest| longest.max(period_s)));
        let error = covariance[(place, place)].max(0.0).sqrt();
        covariance[(place, place)] = (error + 0.5 * period_s / NORMAL_95).powi(2);
    }
    longest_s
}

fn average_gain(schedule: &Schedule, point: &Point) -> f64 {
    point[..schedule.len()].iter().sum::<f64>() / schedule.len() as f64
}

impl<'a> Problem<'a> {
    fn new(signals: &'a Signals<'a>, pieces: &'a [Piece], schedule: Schedule) -> Self {
        let mut free: Vec<usize> = (0..schedule.len()).collect();
        free.extend([LAG, DELAY, RESISTANCE, DRAG]);
        if signals.brake.is_some() {
            free.extend([BRAKE_GAIN, BRAKE_LAG, BRAKE_DELAY]);
        }
        if let Some(gravity) = &signals.gravity {
            let used = || pieces.iter().flat_map(|piece| &gravity[piece.range.clone()]);
            let count = used().count().max(1) as f64;
            let mean = used().sum::<f64>() / count;
            let variance = used().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
            if variance.sqrt() > LEAST_GRAVITY {
                free.push(GRADE);
            }
        }
        free.sort_unstable();
        let priors = priors(signals);
        Self { signals, pieces, schedule, noise: Noise::initial(), free, priors }
    }

    /// Share of each gain in the sum of the commands' sizes.
    fn shares_of_gains(&self) -> Vec<f64> {
        let signals = self.signals;
        let mut sums = vec![0.0; self.schedule.len()];
        for k in self.pieces.iter().flat_map(|piece| piece.range.clone()) {
            let gear = signals.gear.as_ref().map(|gear| gear[k]);
            let (low, high, share) = self.schedule.weights(signals.mean_speed[k], gear);
            let size = signals.log.input[k].abs();
            sums[low] += (1.0 - share) * size;
            sums[high] += share * size;
        }
        let all = sums.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        sums.iter().map(|sum| sum / all).collect()
    }

    /// Passes on the errors between measured and simulated speed of each piece; the simulation of a piece begins with
    /// its first measured speed.
    fn pieces<S: Scalar>(&self, p: [S; COUNT], mut each: impl FnMut(&Piece, &[S])) {
        let simulation = Simulation::new(self.signals, &self.schedule, p);
        let log = self.signals.log;
        for (place, segment) in log.segments.iter().enumerate() {
            let own: Vec<&Piece> =
                self.pieces.iter().filter(|piece| piece.segment == place).collect();
            let Some(last) = own.last() else { continue };
            let (from, to) = (segment.range.start, last.range.end);
            let mut changes = Vec::with_capacity(to - from);
            simulation.increments(&(from..to), |_, change| changes.push(change));
            let mut errors = Vec::new();
            for piece in own {
                errors.clear();
                let mut simulated = S::constant(log.output[piece.range.start]);
                for k in piece.range.clone() {
                    errors.push((-simulated).plus(log.output[k]));
                    simulated = simulated + changes[k - from];
                }
                each(piece, &errors);
            }
        }
    }

    /// Passes on the prediction errors over their deviations, with the piece and the place in it.
    fn errors<S: Scalar>(&self, p: [S; COUNT], mut each: impl FnMut(&Piece, usize, S)) {
        let longest = self.pieces.iter().map(|piece| piece.range.len()).max().unwrap_or(0);
        let filter = self.noise.filter(self.signals.log.sample_time_s, longest);
        self.pieces(p, |piece, errors| {
            filter.errors(errors.iter().copied(), |i, error| each(piece, i, error));
        });
    }

    fn deviation(&self, p: &Point, i: usize) -> f64 {
        (p[i] - self.priors[i].mean) / self.priors[i].deviation
    }

    fn cost(&self, p: &Point) -> Option<f64> {
        let mut sum = 0.0;
        self.errors(*p, |_, _, e: f64| sum += e * e);
        for &i in &self.free {
            sum += self.deviation(p, i).powi(2);
        }
        if (0.5 * sum).is_finite() { Some(0.5 * sum) } else { None }
    }

    /// The cost with half of BIC's penalty of each parameter.
    fn criterion(&self, p: &Point) -> Option<f64> {
        let count: usize = self.pieces.iter().map(|piece| piece.range.len()).sum();
        let penalty = 0.5 * self.free.len() as f64 * (count.max(2) as f64).ln();
        Some(self.cost(p)? + penalty)
    }

    fn duals(p: &Point) -> [Dual<{ COUNT + 1 }>; COUNT] {
        std::array::from_fn(|i| Dual::parameter(p[i], i))
    }

    fn normals(&self, p: &Point) -> Normals {
        let mut normals = Normals { gradient: [0.0; COUNT], hessian: [[0.0; COUNT]; COUNT] };
        self.errors(Self::duals(p), |_, _, e| {
            let by: [f64; COUNT] = e.by();
            for i in 0..COUNT {
                normals.gradient[i] += by[i] * e.value();
                for j in 0..=i {
                    normals.hessian[i][j] += by[i] * by[j];
                }
            }
        });
        for i in 0..COUNT {
            for j in 0..i {
                normals.hessian[j][i] = normals.hessian[i][j];
            }
        }
        for &i in &self.free {
            let deviation = self.priors[i].deviation;
            normals.gradient[i] += self.deviation(p, i) / deviation;
            normals.hessian[i][i] += deviation.powi(-2);
        }
        normals
    }

    /// The least cost from a point, and that cost.
    fn refined(&self, start: &Point) -> Option<(Point, f64)> {
        let cost = self.cost(start)?;
        let reached = lower::<_, _, Error>(
            (*start, cost),
            STEPS,
            Damping { first: 1e-3, ..USUAL },
            |before, now| before - now > LEAST_GAIN,
            |at, _| Ok(Some(self.normals(at))),
            |at, normals, damping| {
                let Normals { gradient, hessian } = normals;
                let next = bounded_step(&self.free, &self.priors, gradient, hessian, at, damping);
                let Some(next) = next else { return Ok(None) };
                Ok(self.cost(&next).map(|cost| (next, cost)))
            },
        );
        let reached = reached.ok()?;
        Some((reached.point, reached.cost))
    }

    /// Noise and parameters in turn.
    fn alternated(&mut self, mut point: Point, rounds: usize) -> Option<Point> {
        let log = self.signals.log;
        let speed = log.channels.iter().find(|c| c.role == Role::Speed.key());
        let resolution = speed.and_then(|channel| channel.resolution).unwrap_or(0.0);
        for _ in 0..rounds {
            let mut errors = vec![0.0; log.len()];
            self.pieces(point, |piece, own| errors[piece.range.clone()].copy_from_slice(own));
            self.noise =
                noise::estimate(&errors, self.pieces, log.sample_time_s, resolution, self.noise);
            point = self.refined(&point)?.0;
        }
        Some(point)
    }

    fn covariance(&self, p: &Point) -> Result<Mat<f64>, Error> {
        let failed = || Error::Numerical { what: "the covariance of the longitudinal model" };
        let n = self.free.len();
        let scale = |j: usize| self.priors[self.free[j]].deviation;
        let per_bin = samples(BIN_S, self.signals.log);
        let mut all: Vec<Vec<ScoreBin>> = Vec::new();
        let mut sums: Vec<Vec<f64>> = Vec::new();
        let mut last = None;
        self.errors(Self::duals(p), |piece, i, e| {
            if last != Some(piece.range.start) {
                last = Some(piece.range.start);
                all.push(Vec::new());
                sums.push(Vec::new());
            }
            let (Some(bins), Some(sums)) = (all.last_mut(), sums.last_mut()) else { return };
            if (i - 1).is_multiple_of(per_bin) {
                bins.push(ScoreBin { score: Mat::zeros(n, 1), information: Mat::zeros(n, n) });
                sums.push(0.0);
            }
            let (Some(bin), Some(sum)) = (bins.last_mut(), sums.last_mut()) else { return };
            *sum += e.value();
            let all: [f64; COUNT] = e.by();
            for (a, &i) in self.free.iter().enumerate() {
                let by = all[i] * scale(a);
                bin.score[(a, 0)] += by * e.value();
                for (b, &j) in self.free.iter().enumerate() {
                    bin.information[(a, b)] += by * all[j] * scale(b);
                }
            }
        });
        let product = |lag: usize| -> f64 {
            sums.iter()
                .flat_map(|own| own.iter().zip(own.iter().skip(lag)))
                .map(|(a, b)| a * b)
                .sum()
        };
        let rho = (product(1) / product(0).max(f64::MIN_POSITIVE)).clamp(0.0, 0.95);
        let count = sums.iter().map(Vec::len).sum();
        let scaled = sandwich(&all, n, andrews_lags(rho, count), failed)?;
        let mut covariance = Mat::zeros(COUNT, COUNT);
        for (a, &i) in self.free.iter().enumerate() {
            for (b, &j) in self.free.iter().enumerate() {
                covariance[(i, j)] = scaled[(a, b)] * scale(a) * scale(b);
            }
        }
        Ok(covariance)
    }
}

/// Prediction errors over their deviations on other pieces, piece by piece.
pub(super) fn prediction_errors(
    fit: &Fit,
    signals: &Signals<'_>,
    pieces: &[Piece],
) -> Vec<Vec<f64>> {
    let mut problem = Problem::new(signals, pieces, fit.schedule.clone());
    problem.noise = fit.noise;
    let mut all: Vec<Vec<f64>> = Vec::new();
    problem.errors(fit.point, |_, i, e: f64| {
        if i == 1 {
            all.push(Vec::new());
        }
        if let Some(own) = all.last_mut() {
            own.push(e);
        }
    });
    all
}

/// Score and information of a relative change of the gain in one stretch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct GainScore {
    pub(super) score: f64,
    pub(super) information: f64,
}

/// Scores of a relative change of all gains, in stretches of the pieces.
pub(super) fn gain_scores(
    fit: &Fit,
    signals: &Signals<'_>,
    pieces: &[Piece],
    stretch_s: f64,
) -> Vec<GainScore> {
    let mut problem = Problem::new(signals, pieces, fit.schedule.clone());
    problem.noise = fit.noise;
    let per_stretch = samples(stretch_s, signals.log);
    let gains = fit.schedule.len();
    let mut all: Vec<GainScore> = Vec::new();
    problem.errors(Problem::duals(&fit.point), |_, i, e| {
        // The first sample of a piece has no error.
        if (i - 1).is_multiple_of(per_stretch) {
            all.push(GainScore::default());
        }
        let Some(own) = all.last_mut() else { return };
        let by: [f64; COUNT] = e.by();
        let by_gains: f64 = (0..gains).map(|gain| by[gain] * fit.point[gain]).sum();
        own.score += by_gains * e.value();
        own.information += by_gains * by_gains;
    });
    all
}
