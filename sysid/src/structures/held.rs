//! The steering of a drive as the model takes it: held over each sample as suits the vehicle.

use crate::Error;
use crate::data::held_input::{Between, ContinuousResponse, held_for};
use crate::data::scaled::{Data, Detrend};
use crate::selection::delay::{Estimated, estimate};
use crate::selection::options::IdentifyOptions;
use crate::sideslip::{FromFixes, sideslip};
use crate::structures::bicycle::wheelbase;
use crate::validation::faults::open_hold::{
    HoldEvidence, Preferred, lines_exclude, lines_matter, matters, preferred,
};
use crate::validation::faults::steering_faults::SteeringFaults;
use crate::validation::response::uncertain_response::{
    ResponseError, uncertain_response, with_half_a_period,
};
use std::borrow::Cow;
use std::cell::OnceCell;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::{Intersample, LEAST_SPREAD};

/// Most times that the input is held as suits the vehicle that the input before it determines. Of a log of few samples in a
/// period of the bandwidth, estimates in a row lie on either side of the one that agrees with its input, each about half as
/// far from it as the one before.
const MOST_TURNS: usize = 12;
/// Change of the input, as a share of its largest value, from which it is held again.
const LEAST_CHANGE: f64 = 1e-4;
/// Difference of the criterion from which a vehicle is not kept, very strong evidence (Kass and Raftery 1995): where no
/// input agrees with its vehicle, turns may go from a good one to a bad one.
const MUCH_WORSE: f64 = 10.0;

/// A drive whose steering is held over each sample as suits the vehicle.
pub(crate) struct Held<'a> {
    pub(crate) log: Cow<'a, DriveLog>,
    /// That vehicle; `None` where the steering is as it was read, or held as of any vehicle.
    pub(crate) vehicle: Option<ContinuousResponse>,
    /// What its samples show, the stated delay applied; `None` of a log that is too short.
    pub(crate) estimated: Option<Estimated>,
}

impl<'a> Held<'a> {
    fn new(log: &'a DriveLog, between: Between, options: &IdentifyOptions) -> Result<Self, Error> {
        let preparation =
            IdentifyOptions { detrend: Detrend::Mean, ..options.clone() }.preparation();
        let of = |held: &DriveLog| {
            let late = options.delay_s.map(|seconds| held.with_input_delayed(seconds));
            let data = Data::new(late.as_ref().unwrap_or(held), &preparation)?;
            Ok::<_, Error>(estimate(&data.estimation.data).ok())
        };
        let input = held_for(log, between, None);
        let estimated = of(&input)?;
        let mut last = Self { log: input, vehicle: None, estimated };
        let (mut kept, mut least) = (None, f64::INFINITY);
        for _ in 0..MOST_TURNS {
            let Some(vehicle) = last.estimated.as_ref().and_then(|e| e.vehicle.clone()) else {
                break;
            };
            let input = held_for(log, between, Some(&vehicle));
            if matches!(input, Cow::Borrowed(_)) {
                break;
            }
            let is_settled = change(&last.log.input, &input.input) <= LEAST_CHANGE;
            let estimated = of(&input)?;
            let before = std::mem::replace(
                &mut last,
                Self { log: input, vehicle: Some(vehicle), estimated },
            );
            if before.is_kept(&mut least) {
                kept = Some(before);
            }
            if is_settled {
                break;
            }
        }
        Ok(match kept {
            Some(kept) if !last.is_kept(&mut least) => kept,
            _ => last,
        })
    }

    /// Whether the vehicle fits about as well as that of any turn so far, whose least criterion is `least`.
    fn is_kept(&self, least: &mut f64) -> bool {
        if self.vehicle.is_none() {
            return false;
        }
        let criterion = self.criterion().unwrap_or(f64::INFINITY);
        *least = least.min(criterion);
        criterion <= *least + MUCH_WORSE
    }

    fn criterion(&self) -> Option<f64> {
        self.estimated.as_ref().map(|e| e.criterion)
    }

    fn column(&self) -> &str {
        let mut channels = self.log.channels.iter().filter(|c| c.role == Role::Steering.key());
        channels.next().map_or("steering", |channel| &channel.column)
    }

    fn lines_in_words(&self, period_s: f64) -> String {
        format!(
            "column `{}` is not band-limited: the yaw rate fits straight lines between its samples, {period_s:.3} s apart, better, as of steps of a controller behind a servo; it is read along straight lines, and the standard errors of the phase cover a lag; a stated behaviour between samples takes precedence",
            self.column()
        )
    }

    fn moving_on_in_words(&self, period_s: f64) -> String {
        format!(
            "column `{}`: held over {period_s:.3} s, the steering would come after the yaw rate that it causes; it is read as moving on between its samples, since it was set more often than it was logged; a stated behaviour between samples takes precedence",
            self.column()
        )
    }

    fn held_in_words(&self, period_s: f64) -> String {
        let column = self.column();
        format!(
            "column `{column}`: the yaw rate fits it better as held between its samples than as moving on; it is read as held over {period_s:.3} s, and the standard errors of the response cover both; a stated behaviour between samples takes precedence"
        )
    }
}

/// Largest change of an input, as a share of its largest value.
fn change(before: &[f64], after: &[f64]) -> f64 {
    let largest = after.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let apart = before.iter().zip(after).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    if largest > 0.0 { apart / largest } else { 0.0 }
}

/// What is found in a recording once, whatever the structure.
pub(crate) struct Steering<'a> {
    pub(crate) log: &'a DriveLog,
    options: &'a IdentifyOptions,
    faults_as_read: OnceCell<SteeringFaults>,
    faults: OnceCell<SteeringFaults>,
    read: OnceCell<Result<Read<'a>, Error>>,
    wheelbase: OnceCell<Option<[f64; 2]>>,
    from_fixes: OnceCell<FromFixes>,
}

impl<'a> Steering<'a> {
    /// Of a log whose delay, if one is stated, is that of the options.
    pub(crate) fn new(log: &'a DriveLog, options: &'a IdentifyOptions) -> Self {
        let (faults_as_read, faults) = (OnceCell::new(), OnceCell::new());
        let (read, wheelbase, from_fixes) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        Self { log, options, faults_as_read, faults, read, wheelbase, from_fixes }
    }

    /// Of the steering as the reader of the log took it.
    fn faults_as_read(&self) -> SteeringFaults {
        *self.faults_as_read.get_or_init(|| SteeringFaults::from_log(self.log))
    }

    /// Of the steering that moves on where the reader took it for held: the half period that the held one comes after the
    /// yaw rate looks like play.
    pub(crate) fn faults(&self) -> SteeringFaults {
        *self.faults.get_or_init(|| match self.read() {
            Ok(Read { held, moves_on_instead: true, .. }) => SteeringFaults::from_log(&held.log),
            _ => self.faults_as_read(),
        })
    }

    /// The wheelbase with its standard error, m, where the drive, held as it was read, determines it.
    pub(crate) fn wheelbase(&self) -> Option<[f64; 2]> {
        let log = self.read().map_or(self.log, |read| &*read.held.log);
        *self.wheelbase.get_or_init(|| wheelbase(log))
    }

    /// What the fixes of a receiver tell.
    pub(crate) fn fixes(&self) -> &FromFixes {
        self.from_fixes.get_or_init(|| sideslip(self.log))
    }

    /// Fails for a log that is too short to show how its steering is held.
    pub(crate) fn read(&self) -> Result<&Read<'a>, Error> {
        let delay_s = || self.faults_as_read().delay_s;
        let read = self.read.get_or_init(|| Read::new(self.log, self.options, delay_s));
        read.as_ref().map_err(Clone::clone)
    }

    /// Period of the steering, s, where it stays open whether it is held; of a log too short to show it, where its reader
    /// takes it for moving on.
    pub(crate) fn open_hold_s(&self) -> Option<f64> {
        match self.read() {
            Ok(read) => read.open_hold_s,
            Err(_) => self.log.assumed_period_s(Role::Steering, Intersample::Bl),
        }
    }
}

/// Standard errors of a response, and the period of the steering, s, where these cover that it is held instead or moves
/// on instead: where a pass depends on it.
pub(crate) fn with_open_hold(
    errors: Vec<ResponseError>,
    open_hold_s: Option<f64>,
) -> (Vec<ResponseError>, Option<f64>) {
    let Some(period_s) = open_hold_s else { return (errors, None) };
    let wider = with_half_a_period(&errors, period_s);
    if uncertain_response(&wider) == uncertain_response(&errors) {
        return (errors, None);
    }
    (wider, Some(period_s))
}

/// Whether the speed hardly varies, or is not known to.
fn is_one_speed(log: &DriveLog) -> bool {
    let varies = |v: &Vec<f64>| standard_deviation(v) >= LEAST_SPREAD * mean(v);
    !log.speed.as_ref().is_some_and(varies)
}

/// A drive whose steering is read as held or as moving on between its samples.
pub(crate) struct Read<'a> {
    pub(crate) held: Held<'a>,
    /// Whether the reader of the log took it for held, but it moves on.
    moves_on_instead: bool,
    /// Period of the steering, s, where it stays open which of the two it is.
    open_hold_s: Option<f64>,
    /// Period of the steering, s, where it goes along straight lines between its samples, and the reader of the log took it
    /// for band-limited.
    pub(crate) lines_s: Option<f64>,
    pub(crate) warning: Option<String>,
}

impl<'a> Read<'a> {
    /// As the reader of the log took it, or as the data prefer where that is not stated; by the delay with its standard
    /// error, s, of a bicycle with the speed of each sample after the steering as it was read.
    fn new(
        log: &'a DriveLog,
        options: &IdentifyOptions,
        delay_s: impl Fn() -> Option<[f64; 2]>,
    ) -> Result<Self, Error> {
        let as_read = Held::new(log, Between::AsRead, options)?;
        let stated_s = options.delay_s.unwrap_or_default();
        let evidence = |moving_on: &Held<'_>, held: &Held<'_>| HoldEvidence {
            moving_on: moving_on.criterion(),
            held: held.criterion(),
            delay_s: delay_s().map(|[delay, error]| [delay - stated_s, error]),
            is_one_speed: is_one_speed(log),
        };
        let certain = |held| Self {
            held,
            moves_on_instead: false,
            open_hold_s: None,
            lines_s: None,
            warning: None,
        };
        if let Some(period_s) =
            log.assumed_period_s(Role::Steering, Intersample::Zoh).filter(|period| matters(*period))
        {
            let moving_on = Held::new(log, Between::MovingOn, options)?;
            let found = evidence(&moving_on, &as_read);
            if found.excludes_the_hold_read(period_s) {
                let warning = Some(moving_on.moving_on_in_words(period_s));
                return Ok(Self { moves_on_instead: true, warning, ..certain(moving_on) });
            }
            if found.doubts_the_hold_read(period_s) {
                return Ok(Self { open_hold_s: Some(period_s), ..certain(as_read) });
            }
        }
        let Some(period_s) = log.assumed_period_s(Role::Steering, Intersample::Bl) else {
            return Ok(certain(as_read));
        };
        // Lines between samples that are not those of the model are no lines of its input.
        let has_own_samples = (period_s / log.sample_time_s - 1.0).abs() < 1e-3;
        let lines = match has_own_samples && lines_matter(period_s) {
            true => Some(Held::new(log, Between::Lines, options)?),
            false => None,
        };
        let moving_on = match lines {
            Some(lines) if lines_exclude(as_read.criterion(), lines.criterion()) => {
                let warning = Some(lines.lines_in_words(period_s));
                Self { lines_s: Some(period_s), warning, ..certain(lines) }
            }
            _ => certain(as_read),
        };
        let as_held = Held::new(log, Between::Held(period_s), options)?;
        Ok(match preferred(period_s, &evidence(&moving_on.held, &as_held)) {
            Preferred::MovingOn => moving_on,
            Preferred::OpenMovingOn => Self { open_hold_s: Some(period_s), ..moving_on },
            Preferred::OpenHeld => {
                let warning = Some(as_held.held_in_words(period_s));
                Self { open_hold_s: Some(period_s), warning, ..certain(as_held) }
            }
        })
    }
}
