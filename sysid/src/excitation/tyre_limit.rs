//! The manoeuvre that determines the grip of the tyres: the single-track model, which saturates, steered up to the largest
//! lateral acceleration.
//!
//! No multiple of a signal has the information of the signal times the multiple's square here. The signals are those that a
//! driver or a robot can steer, of which the amplitude grows, by simulation, until a limit is reached: the lateral acceleration,
//! of which no more than a share of the grip is used, the lateral offset, the angle, its rate, or the sideslip. The vehicles that are
//! two standard deviations away along each axis of the uncertainty of stiffnesses and friction keep the sideslip, too. The
//! best selection of each kind is that with the least standard error of the friction.

use super::criterion::{Criterion, Factor, Square};
use super::driver::DriverSignal;
use super::limits::{Peaks, limit_values, rates};
use super::options::{ExcitationOptions, REST_S, within_actuator};
use super::schedule::{Scaled, Subject, best_of, best_selection, needed_times, of_selection};
use crate::Error;
use crate::structures::single_track::information::SingleTrackInformation;
use crate::structures::single_track::vehicle::ROAD_WHEEL_LIMITS;
use crate::structures::single_track::{Parameter, SingleTrackModel};
use steerwright_formats::{
    Bicycle, Estimated, ExpectedErrors, Manoeuvre, ManoeuvreGoal, ManoeuvreKind, NORMAL_95, Vehicle,
};

/// Share of the grip of the axle with less of it that is used: near its peak a tyre holds no disturbance.
const GRIP_USED: f64 = 0.95;
/// Largest sideslip, as a tangent: that of a guarded simulation of the identification.
const MOST_SIDESLIP: f64 = 0.2;
/// The amplitude from which one is searched, rad at the road wheel, and steps of the search.
const FIRST_ANGLE_RAD: f64 = 0.002;
const BISECTIONS: usize = 12;
/// Sample time of the search, s.
const SEARCH_S: f64 = 0.02;
/// Reduction of an amplitude that exceeds a limit between the samples of the search.
const REDUCTION: f64 = 0.995;
const REDUCTIONS: usize = 20;
/// Parameters whose uncertainty the limits leave room for.
const UNCERTAIN: [Parameter; 4] = [
    Parameter::StiffnessFront,
    Parameter::StiffnessRear,
    Parameter::FrictionFront,
    Parameter::FrictionBalance,
];
const COUNT: usize = Parameter::ALL.len();
const KINDS: [ManoeuvreKind; 5] = [
    ManoeuvreKind::GrowingSlalom,
    ManoeuvreKind::RisingAngle,
    ManoeuvreKind::Sweep,
    ManoeuvreKind::Slalom,
    ManoeuvreKind::Steps,
];

/// The manoeuvre that determines the friction of a vehicle best within the options.
///
/// # Errors
/// [`Error::Option`] for values out of range and another goal than the tyre limit; [`Error::Unstable`] where the vehicle is
/// unstable at a speed.
pub fn excite_vehicle(vehicle: &Vehicle, options: &ExcitationOptions) -> Result<Manoeuvre, Error> {
    let subject = Subject {
        name: &vehicle.name,
        steering_ratio: vehicle.actuator.steering_ratio,
        quality: &vehicle.quality,
    };
    let stated = vehicle.evidence.as_ref().map(|e| &e.covariance.0);
    let model = SingleTrackModel::from_vehicle(vehicle);
    design(subject, &model, stated, &within_actuator(vehicle, options))
}

/// The same of a bicycle with the tyres of the priors.
pub(super) fn excite_with_usual_tyres(
    bicycle: &Bicycle,
    options: &ExcitationOptions,
) -> Result<Manoeuvre, Error> {
    let data = &bicycle.vehicle;
    let subject = Subject {
        name: &data.name,
        steering_ratio: data.steering_ratio,
        quality: &bicycle.quality,
    };
    // Of the friction nothing but the prior is known.
    let friction = [Parameter::FrictionFront, Parameter::FrictionBalance];
    let variance = |i: usize| {
        let parameter = Parameter::ALL[i];
        if friction.contains(&parameter) {
            parameter.default_prior().standard_deviation.powi(2)
        } else if UNCERTAIN.contains(&parameter) {
            options.assumed_uncertainty.powi(2)
        } else {
            0.0
        }
    };
    let row = |i: usize| (0..COUNT).map(|j| if i == j { variance(i) } else { 0.0 }).collect();
    let covariance: Vec<Vec<f64>> = (0..COUNT).map(row).collect();
    design(subject, &SingleTrackModel::from_bicycle(data), Some(&covariance), options)
}

fn design(
    subject: Subject<'_>,
    model: &SingleTrackModel,
    covariance: Option<&Vec<Vec<f64>>>,
    options: &ExcitationOptions,
) -> Result<Manoeuvre, Error> {
    options.check()?;
    if options.goal != ManoeuvreGoal::TyreLimit {
        let expected = ManoeuvreGoal::TyreLimit.name();
        return Err(Error::option("goal", options.goal, expected));
    }
    let information = SingleTrackInformation::new(model, subject.steering_ratio)?;
    let size = information.len();
    let mut prior = vec![0.0; size * size];
    for (i, own) in information.prior().into_iter().enumerate() {
        prior[i * size + i] = own;
    }
    let gradients = information.friction_gradients().to_vec();
    let design = TyreLimit {
        axes: axes(covariance, options.assumed_uncertainty),
        grip_mps2: GRIP_USED * information.grip_mps2(),
        criterion: Criterion { size, gradients },
        subject,
        options,
        information,
        prior,
    };
    for speed in &options.speeds_mps {
        design.check_stable(*speed)?;
    }
    let all = KINDS.into_iter().map(|kind| design.of_kind(kind));
    let all: Vec<Manoeuvre> =
        all.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten().collect();
    if all.is_empty() {
        let speed = options.speeds_mps.iter().copied().fold(0.0, f64::max);
        let expected = "a speed at which all vehicles within the uncertainty of the model are stable, and limits that allow to steer";
        return Err(Error::option("speed", format!("{speed} m/s"), expected));
    }
    best_of(&all, |_| true)
}

/// One standard deviation of the coordinates along each independent axis of the uncertain parameters; the others move with them as
/// they are correlated.
fn axes(covariance: Option<&Vec<Vec<f64>>>, assumed: f64) -> Vec<[f64; COUNT]> {
    let count = UNCERTAIN.len();
    let own = |i: usize, j: usize| {
        let stated = covariance.and_then(|c| c.get(i)?.get(j)).copied();
        stated.unwrap_or(if i == j { assumed * assumed } else { 0.0 })
    };
    let mut square: Square = Vec::new();
    for (i, a) in UNCERTAIN.iter().enumerate() {
        for (j, b) in UNCERTAIN.iter().enumerate() {
            // A parameter that is stated has no variance: a ridge in place of a rank decision.
            square.push(own(a.index(), b.index()) + if i == j { 1e-12 } else { 0.0 });
        }
    }
    let Some(factor) = Factor::new(&square, count) else { return Vec::new() };
    let mut axes = vec![[0.0; COUNT]; count];
    for i in 0..COUNT {
        let with: Vec<f64> = UNCERTAIN
            .iter()
            .map(|p| if covariance.is_some() || p.index() == i { own(i, p.index()) } else { 0.0 })
            .collect();
        for (axis, value) in axes.iter_mut().zip(factor.half_solve(&with)) {
            axis[i] = value;
        }
    }
    axes
}

struct TyreLimit<'a> {
    subject: Subject<'a>,
    options: &'a ExcitationOptions,
    information: SingleTrackInformation,
    axes: Vec<[f64; COUNT]>,
    /// Most of the grip that is used, m/s².
    grip_mps2: f64,
    criterion: Criterion,
    /// M₀.
    prior: Square,
}

/// Largest lateral acceleration and offset, and the offset at the end.
struct Moved {
    largest: [f64; 2],
    end_offset_m: f64,
}

impl TyreLimit<'_> {
    /// A signal, and straight driving up to the end of its block.
    fn block(signal: &[f64], step_s: f64) -> Vec<f64> {
        let rest = (REST_S / step_s).round() as usize;
        signal.iter().copied().chain(std::iter::repeat_n(0.0, rest)).collect()
    }

    /// A vehicle that hardly steers does not slide.
    fn check_stable(&self, speed_mps: f64) -> Result<(), Error> {
        let step_s = self.options.sample_time_s;
        let count = (self.options.block_s / step_s).round() as usize;
        let mut signal = vec![0.0; count];
        let touch = (1.0 / step_s).round() as usize;
        signal[..touch].fill(FIRST_ANGLE_RAD * self.subject.steering_ratio);
        let at = self.information.moved(&[0.0; COUNT], 0.0);
        let moved = self.moved(&at, &signal, speed_mps, step_s);
        moved.map(|_| ()).ok_or(Error::Unstable { speed_mps })
    }

    /// `None` where the vehicle of coordinates slides.
    fn moved(
        &self,
        at: &[f64; COUNT],
        block: &[f64],
        speed_mps: f64,
        step_s: f64,
    ) -> Option<Moved> {
        let motion = self.information.motion(at, block, speed_mps, step_s)?;
        let (mut yaw, mut offset, mut largest) = (0.0_f64, 0.0_f64, [0.0_f64; 2]);
        for (k, lateral) in motion.lateral_velocity_mps.iter().enumerate() {
            if lateral.is_nan() || lateral.abs() > MOST_SIDESLIP * speed_mps {
                return None;
            }
            largest[0] = largest[0].max(motion.lateral_acceleration_mps2[k].abs());
            largest[1] = largest[1].max(offset.abs());
            offset += step_s * (speed_mps * yaw.sin() + lateral * yaw.cos());
            yaw += step_s * motion.yaw_rate_radps[k];
        }
        Some(Moved { largest, end_offset_m: offset })
    }

    fn peaks(&self, signal: &[f64], speed_mps: f64, step_s: f64) -> Option<Peaks> {
        let block = Self::block(signal, step_s);
        let nominal_at = self.information.moved(&[0.0; COUNT], 0.0);
        let nominal = self.moved(&nominal_at, &block, speed_mps, step_s)?;
        let mut squares = [0.0; 2];
        for axis in &self.axes {
            let mut more = [0.0_f64; 2];
            for by in [NORMAL_95, -NORMAL_95] {
                let at = self.information.moved(axis, by);
                let moved = self.moved(&at, &block, speed_mps, step_s)?;
                for (i, more) in more.iter_mut().enumerate() {
                    *more = more.max(moved.largest[i] - nominal.largest[i]);
                }
            }
            for (square, more) in squares.iter_mut().zip(more) {
                *square += more * more;
            }
        }
        let largest = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let [angle, rate] = [largest(signal), largest(&rates(&block, step_s))];
        let [acceleration, offset] = nominal.largest;
        Some(Peaks {
            nominal: [acceleration, offset, angle, rate],
            upper: [acceleration + squares[0].sqrt(), offset + squares[1].sqrt(), angle, rate],
            end_offset_m: nominal.end_offset_m,
        })
    }

    /// The peaks of a signal that keeps all limits.
    fn admissible(&self, signal: &[f64], speed_mps: f64, step_s: f64) -> Option<Peaks> {
        let most = ROAD_WHEEL_LIMITS[1] * self.subject.steering_ratio;
        if signal.iter().any(|angle| angle.abs() > most) {
            return None;
        }
        let peaks = self.peaks(signal, speed_mps, step_s)?;
        let limits = limit_values(&self.options.limits);
        let kept = limits.iter().zip(peaks.upper).all(|(limit, peak)| peak <= *limit);
        // More than the grip of the model is no acceleration of it, whatever the angle is.
        if kept && peaks.nominal[0] <= self.grip_mps2 { Some(peaks) } else { None }
    }

    /// A signal at full use of the limits; `None` where the least amplitude of the search exceeds one.
    fn scaled(&self, candidate: DriverSignal, speed_mps: f64) -> Option<Scaled> {
        let length = self.options.signal_s();
        let of = |factor: f64, step_s: f64| -> Vec<f64> {
            candidate.signal(length, step_s).iter().map(|u| factor * u).collect()
        };
        let step_s = self.options.sample_time_s.max(SEARCH_S);
        let keeps = |factor: f64| self.admissible(&of(factor, step_s), speed_mps, step_s).is_some();
        let mut ends = [0.0, FIRST_ANGLE_RAD * self.subject.steering_ratio];
        while keeps(ends[1]) {
            ends = [ends[1], 2.0 * ends[1]];
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (ends[0] + ends[1]);
            let end = usize::from(!keeps(middle));
            ends[end] = middle;
        }
        let mut factor = ends[0];
        for _ in 0..REDUCTIONS {
            let steering_rad = of(factor, self.options.sample_time_s);
            let peaks = self.admissible(&steering_rad, speed_mps, self.options.sample_time_s);
            if let Some(peaks) = peaks.filter(|_| factor > 0.0) {
                return Some(Scaled { steering_rad, peaks });
            }
            factor *= REDUCTION;
        }
        None
    }

    fn information(&self, signal: &[f64], speed_mps: f64, step_s: f64) -> Result<Square, Error> {
        let block = Self::block(signal, step_s);
        let density = self.options.noise_density;
        let found = self.information.information(&block, speed_mps, step_s, density);
        found.ok_or(Error::Unstable { speed_mps })
    }

    /// The best selection of the signals of a kind within the band; `None` where a limit leaves none.
    fn of_kind(&self, kind: ManoeuvreKind) -> Result<Option<Manoeuvre>, Error> {
        let options = self.options;
        let [low, high] = options.band_hz;
        let is_within = |signal: &DriverSignal| {
            signal.frequency_hz().is_none_or(|[from, to]| from >= low && to <= high)
        };
        let (mut candidates, mut scaled, mut information) = (Vec::new(), Vec::new(), Vec::new());
        for candidate in DriverSignal::of_kind(kind).into_iter().filter(is_within) {
            let at = |speed: &f64| self.scaled(candidate, *speed);
            let Some(own) = options.speeds_mps.iter().map(at).collect::<Option<Vec<_>>>() else {
                continue;
            };
            let mut sum = vec![0.0; self.criterion.size * self.criterion.size];
            for (own, speed) in own.iter().zip(&options.speeds_mps) {
                let found = self.information(&own.steering_rad, *speed, options.sample_time_s)?;
                let mirrored = self.information.mirrored(&found);
                for ((s, a), b) in sum.iter_mut().zip(&found).zip(&mirrored) {
                    *s += 0.5 * (a + b);
                }
            }
            candidates.push(candidate);
            scaled.extend(own);
            information.push(sum);
        }
        if candidates.is_empty() {
            return Ok(None);
        }
        let repeats = options.repeats();
        let best = best_selection(&information, repeats, &self.prior, &self.criterion);
        // Sides alternate within a half: a rising angle to one side does not tell an offset.
        let (signals, order) = of_selection(
            &best,
            &candidates,
            &options.speeds_mps,
            &scaled,
            repeats,
            |repeat, half| (repeat + half) % 2 == 1,
        );
        let mut manoeuvre = self.subject.manoeuvre(options, kind, signals, order);
        manoeuvre.expected = self.expected(&manoeuvre)?;
        Ok(Some(manoeuvre))
    }

    /// The standard errors by the blocks of the first half at each speed.
    fn expected(&self, manoeuvre: &Manoeuvre) -> Result<ExpectedErrors, Error> {
        let (options, size) = (self.options, self.criterion.size);
        let mut driven = vec![0.0; size * size];
        for block in manoeuvre.estimation_blocks() {
            let signal = &manoeuvre.signals[block.signal];
            let found =
                self.information(&signal.steering_rad, signal.speed_mps, options.sample_time_s)?;
            let found = if block.mirrored { self.information.mirrored(&found) } else { found };
            driven.iter_mut().zip(found).for_each(|(sum, own)| *sum += own);
        }
        let factor = |times: f64| {
            let sum: Square = driven.iter().zip(&self.prior).map(|(m, p)| times * m + p).collect();
            Factor::new(&sum, size).ok_or(Error::Numerical { what: "information of the design" })
        };
        let largest = |factor: &Factor| {
            let variances = self.criterion.gradients.iter().map(|c| factor.variance(c));
            variances.fold(0.0, f64::max).sqrt()
        };
        let is_met = |error: f64| options.max_error.is_none_or(|wanted| 2.0 * error <= wanted);
        let own = factor(1.0)?;
        let largest_error = largest(&own);
        let times =
            options.max_error.map(|_| needed_times(|times| Ok(is_met(largest(&factor(times)?)))));
        let stated = self.information.stated().into_iter();
        let parameters = stated.map(|(name, unit, value, gradient)| Estimated {
            name: name.into(),
            value,
            standard_error: own.variance(&gradient).sqrt(),
            unit: unit.into(),
        });
        Ok(ExpectedErrors {
            largest_error,
            bound: None,
            gap: None,
            met: is_met(largest_error),
            needed_time_s: times.transpose()?.flatten().map(|times| times * manoeuvre.time_s()),
            response: Vec::new(),
            parameters: parameters.collect(),
        })
    }
}
