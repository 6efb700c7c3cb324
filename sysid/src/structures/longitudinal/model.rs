//! The model in discrete time: inputs held over a sample, delays of any fraction of one, and lags in closed form.

use crate::linalg::dual::Scalar;
use crate::structures::longitudinal::signals::Signals;
use std::ops::Range;

/// Most gains of a model.
pub(super) const GAINS: usize = 8;
pub(super) const BRAKE_GAIN: usize = GAINS;
pub(super) const LAG: usize = GAINS + 1;
pub(super) const DELAY: usize = GAINS + 2;
pub(super) const BRAKE_LAG: usize = GAINS + 3;
pub(super) const BRAKE_DELAY: usize = GAINS + 4;
pub(super) const RESISTANCE: usize = GAINS + 5;
pub(super) const RESISTANCE_PER_SPEED: usize = GAINS + 6;
pub(super) const DRAG: usize = GAINS + 7;
pub(super) const GRADE: usize = GAINS + 8;
pub(super) const PEDAL: usize = GAINS + 9;
/// Number of parameters.
pub(super) const COUNT: usize = GAINS + 10;

/// All parameters; those that a model does not have are 0.
pub(super) type Point = [f64; COUNT];

/// What the gain depends on.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Schedule {
    /// Speeds of the gains, m/s, increasing; one of a gain that does not depend on the speed.
    Speeds(Vec<f64>),
    /// Numbers of the gears.
    Gears(Vec<i64>),
}

impl Schedule {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Speeds(speeds) => speeds.len(),
            Self::Gears(gears) => gears.len(),
        }
    }

    /// The two gains between which the one at a speed, in a gear, is, and the share of the second.
    pub(super) fn weights(&self, speed: f64, gear: Option<i64>) -> (usize, usize, f64) {
        match self {
            Self::Speeds(speeds) => {
                let last = speeds.len() - 1;
                let above = speeds.partition_point(|knot| *knot <= speed);
                if above == 0 {
                    return (0, 0, 0.0);
                }
                if above > last {
                    return (last, last, 0.0);
                }
                let (low, high) = (speeds[above - 1], speeds[above]);
                (above - 1, above, (speed - low) / (high - low))
            }
            Self::Gears(gears) => {
                let place = gears.iter().position(|own| Some(*own) == gear).unwrap_or(0);
                (place, place, 0.0)
            }
        }
    }
}

/// A lag behind a delay, of an input that is held.
#[derive(Clone, Copy)]
struct Lag<S> {
    whole: usize,
    /// Times with the earlier and with the later value, s.
    times: [S; 2],
    /// Decay in these times, and lag times one less it.
    decays: [S; 2],
    areas: [S; 2],
}

impl<S: Scalar> Lag<S> {
    fn new(lag: S, delay: S, sample_time: f64) -> Self {
        let whole = (delay.value() / sample_time + 1e-9).floor().max(0.0);
        let earlier = delay.plus(-whole * sample_time);
        let times = [earlier, (-earlier).plus(sample_time)];
        let decays = times.map(|time| (-(time / lag)).exp());
        let areas = decays.map(|decay| (-decay).plus(1.0) * lag);
        Self { whole: whole as usize, times, decays, areas }
    }

    /// Follows the earlier and then the later value for a sample; returns the integral of the state.
    #[inline]
    fn follow(&self, state: &mut S, earlier: S, later: S) -> S {
        let away = *state - earlier;
        let between = earlier + away * self.decays[0];
        let mut area = earlier * self.times[0] + away * self.areas[0];
        let away = between - later;
        *state = later + away * self.decays[1];
        area = area + later * self.times[1] + away * self.areas[1];
        area
    }

    /// The values of an input that act in the step from sample `k`.
    #[inline]
    fn values(&self, input: &[f64], from: usize, k: usize) -> [f64; 2] {
        let later = k.saturating_sub(self.whole).max(from);
        let earlier = k.saturating_sub(self.whole + 1).max(from);
        [input[earlier], input[later]]
    }
}

/// The model with its constants of a sample time.
pub(super) struct Simulation<'a, S> {
    signals: &'a Signals<'a>,
    schedule: &'a Schedule,
    p: [S; COUNT],
    drive: Lag<S>,
    brake: Lag<S>,
}

/// State of the lags of drive and brake, m/s².
#[derive(Debug, Clone, Copy)]
pub(super) struct Lags<S> {
    drive: S,
    brake: S,
}

impl<'a, S: Scalar> Simulation<'a, S> {
    pub(super) fn new(signals: &'a Signals<'a>, schedule: &'a Schedule, p: [S; COUNT]) -> Self {
        let step = signals.log.sample_time_s;
        let drive = Lag::new(p[LAG], p[DELAY], step);
        let brake = Lag::new(p[BRAKE_LAG], p[BRAKE_DELAY], step);
        Self { signals, schedule, p, drive, brake }
    }

    #[inline]
    fn gain(&self, speed: f64, k: usize) -> S {
        let gear = self.signals.gear.as_ref().map(|gear| gear[k]);
        let (low, high, share) = self.schedule.weights(speed, gear);
        if share == 0.0 {
            return self.p[low];
        }
        self.p[low].times(1.0 - share) + self.p[high].times(share)
    }

    /// A command behind the curve of the pedal, which beyond 0 and 1 has none.
    #[inline]
    fn curved(&self, command: f64) -> S {
        let within = command.clamp(0.0, 1.0);
        self.p[PEDAL].times(within * (1.0 - within)).plus(command)
    }

    /// Lags in the steady state of the inputs at the start of a segment.
    pub(super) fn steady(&self, from: usize) -> Lags<S> {
        let signals = self.signals;
        let gain = self.gain(signals.mean_speed[from], from);
        let brake = signals.brake.map_or(0.0, |brake| brake[from]);
        Lags {
            drive: gain * self.curved(signals.log.input[from]),
            brake: self.p[BRAKE_GAIN].times(-brake),
        }
    }

    /// Change of the speed from sample `k` to the next at a speed, m/s; `from` is the start of the segment of the log.
    #[inline]
    pub(super) fn increment(&self, lags: &mut Lags<S>, from: usize, k: usize, speed: f64) -> S {
        let signals = self.signals;
        let step = signals.log.sample_time_s;
        let gain = self.gain(speed, k);
        let [earlier, later] = self.drive.values(&signals.log.input, from, k);
        let [earlier, later] = [earlier, later].map(|command| gain * self.curved(command));
        let mut change = self.drive.follow(&mut lags.drive, earlier, later);
        if let Some(brake) = signals.brake {
            let [earlier, later] = self.brake.values(brake, from, k);
            let gain = -self.p[BRAKE_GAIN];
            change =
                change + self.brake.follow(&mut lags.brake, gain.times(earlier), gain.times(later));
        }
        let resistance = self.p[RESISTANCE]
            + self.p[RESISTANCE_PER_SPEED].times(speed)
            + self.p[DRAG].times(speed * speed);
        change = change - resistance.times(step);
        if let Some(gravity) = &signals.gravity {
            change = change - self.p[GRADE].times(gravity[k] * step);
        }
        change
    }

    /// The change of the speed in each step of a segment of the log, scheduled by the measured speed.
    pub(super) fn increments(&self, segment: &Range<usize>, mut each: impl FnMut(usize, S)) {
        let mut lags = self.steady(segment.start);
        for k in segment.clone() {
            let speed = self.signals.mean_speed[k];
            each(k, self.increment(&mut lags, segment.start, k, speed));
        }
    }
}
