//! The steering of a drive as the model takes it: held over each sample as suits the vehicle.

use crate::Error;
use crate::data::held_input::{Between, ContinuousResponse, held_for};
use crate::data::scaled::{Data, Detrend};
use crate::selection::delay::{Estimated, estimate};
use crate::selection::options::IdentifyOptions;
use crate::sideslip::{FromFixes, sideslip};
use crate::structures::bicycle::wheelbase;
use crate::validation::faults::open_hold::{HoldEvidence, Preferred, matters, preferred};
use crate::validation::faults::steering_faults::SteeringFaults;
use crate::validation::response::uncertain_response::{
    ResponseError, uncertain_response, with_half_a_period,
};
use std::borrow::Cow;
use std::cell::OnceCell;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_drivelog::{DriveLog, Role};
use steerwright_formats::LEAST_SPREAD;

/// Times that the input is held as suits the vehicle that the input before it determines.
const TURNS: usize = 2;

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
        let mut held = held_for(log, between, None);
        let mut estimated = of(&held)?;
        let mut vehicle = None;
        for _ in 0..TURNS {
            let Some(found) = estimated.as_ref().and_then(|e| e.vehicle.clone()) else { break };
            held = held_for(log, between, Some(&found));
            if matches!(held, Cow::Borrowed(_)) {
                break;
            }
            vehicle = Some(found);
            estimated = of(&held)?;
        }
        Ok(Self { log: held, vehicle, estimated })
    }

    fn column(&self) -> &str {
        let mut channels = self.log.channels.iter().filter(|c| c.role == Role::Steering.key());
        channels.next().map_or("steering", |channel| &channel.column)
    }

    fn moving_on_in_words(&self, period_s: f64) -> String {
        format!(
            "the yaw rate comes before column `{}` as held over {period_s:.3} s: it is read as moving on between its samples, since it was set more often than it was logged; a stated behaviour between samples decides it",
            self.column()
        )
    }

    fn held_in_words(&self, period_s: f64) -> String {
        let column = self.column();
        format!(
            "the yaw rate fits column `{column}` better as held between its samples than as moving on: it is read as held over {period_s:.3} s, and the standard errors of the response cover both; a stated behaviour between samples decides it"
        )
    }
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

    /// Period of the steering, s, where it stays open whether it is held.
    pub(crate) fn open_hold_s(&self) -> Option<f64> {
        self.read().map_or_else(|_| self.log.open_hold_s(), |read| read.open_hold_s)
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
    pub(crate) open_hold_s: Option<f64>,
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
        let criterion = |held: &Held<'_>| held.estimated.as_ref().map(|e| e.criterion);
        let stated_s = options.delay_s.unwrap_or_default();
        let evidence = |moving_on: &Held<'_>, held: &Held<'_>| HoldEvidence {
            moving_on: criterion(moving_on),
            held: criterion(held),
            delay_s: delay_s().map(|[delay, error]| [delay - stated_s, error]),
            is_one_speed: is_one_speed(log),
        };
        let certain =
            |held| Self { held, moves_on_instead: false, open_hold_s: None, warning: None };
        if let Some(period_s) = log.assumed_hold_s().filter(|period| matters(*period)) {
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
        let Some(period_s) = log.open_hold_s() else { return Ok(certain(as_read)) };
        let as_held = Held::new(log, Between::Held(period_s), options)?;
        Ok(match preferred(period_s, &evidence(&as_read, &as_held)) {
            Preferred::MovingOn => certain(as_read),
            Preferred::OpenMovingOn => Self { open_hold_s: Some(period_s), ..certain(as_read) },
            Preferred::OpenHeld => {
                let warning = Some(as_held.held_in_words(period_s));
                Self { open_hold_s: Some(period_s), warning, ..certain(as_held) }
            }
        })
    }
}
