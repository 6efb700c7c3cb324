//! Whether the steering is held between its samples, where neither name, unit nor values show it.
//!
//! Models of a vehicle, with and without a delay, are fitted to the log once as if the steering moved on between its
//! samples and once as if it was held. Of a steering that moves on, the second would have to lead the yaw rate by half a
//! period, which no model does. Of one that is held, the first has a delay of half a period: it fits nearly as well, and
//! a logger may have such a delay. So the data can exclude that the steering is held, but not that it moves on.
//!
//! These models have one speed. Where the speed varies, the difference of their fits is that of what they lack, in either
//! direction and however many samples there are. So the delay of a bicycle with the speed of each sample
//! ([`crate::structures::bicycle::reference`]) after the steering as it was read has to agree: half a period where it is
//! held, and none where it moves on and nothing else delays it. At one speed that delay may exclude a hold, but a drive may
//! leave it open whether there is a delay or a lag, so that a hold does not need it.
//!
//! Where it stays open, the steering is read as moving on unless half a period matters and it is likelier to
//! be held; the truth may be the other one.
//!
//! Nor does an angle have to be band-limited: that of a servo behind the steps of a controller goes most of its way right
//! after each step, which lies at a sample where one clock runs both. Straight lines from sample to sample are near to that.
//! What a band-limited angle would do between its samples differs at 2 Hz and 10 Hz by 13 % in gain, which models of high
//! order make up for: they fit, and their response is wrong by tens of percent. So straight lines are fitted too, and used
//! where the criterion excludes the band-limited angle. What lies between a straight line and a lag is a time that the
//! phase leaves uncertain.
//!
//! A command is held by the one who sends it, and read so. But it may be set more often than it is logged: then the yaw rate
//! comes before the command as held, by half a period less what a lag of the model makes up for. That lag hides part of the
//! evidence, and it makes a loop that is designed on it overshoot. So a hold that was read is excluded where fits and delay
//! agree, and open where the delay or, at one speed, the fits doubt it.

use crate::data::held_input::ContinuousResponse;
use crate::model::StateSpace;
use crate::model::conversion::ContinuousModel;
use crate::validation::response::uncertain_response::{HIGHEST_HZ, LARGEST_GAIN_ERROR};
use faer::c64;
use std::f64::consts::TAU;
use steerwright_formats::{NORMAL_95, Uncertainty};

/// Difference of the criterion from which a steering that is held is excluded: twice the 10 from which evidence is very
/// strong (Kass and Raftery 1995), which no simulated drive with a held steering exceeded.
const EXCLUDED: f64 = 20.0;

/// Difference of the criterion from which a steering in a column with the name of an angle is read as held all the same:
/// positive evidence (Kass and Raftery 1995).
const PREFERRED: f64 = 2.0;

/// Change of the gain at [`HIGHEST_HZ`], from which straight lines between the samples are tried.
const LEAST_GAIN_CHANGE: f64 = 0.1 * LARGEST_GAIN_ERROR;
/// Standard error of the time of a steering along straight lines, in its periods: a step at a sample behind a lag of three
/// quarters of a period comes two of these before the middle of its line.
const LINE_ERROR: f64 = 0.05;

/// Delay of a steering that is held, in its periods, where it is read as moving on.
const HOLD: f64 = 0.5;
/// Standard errors from which a delay is certain.
const CLEAR: f64 = 2.0;

/// What the data show of a steering between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HoldEvidence {
    /// Least criterion of the models of one speed by a steering that moves on.
    pub(crate) moving_on: Option<f64>,
    /// … and by one that is held.
    pub(crate) held: Option<f64>,
    /// Delay of a bicycle with the speed of each sample after the steering as it was read, with its standard error, s.
    pub(crate) delay_s: Option<[f64; 2]>,
    /// Whether the speed hardly varies.
    pub(crate) is_one_speed: bool,
}

impl HoldEvidence {
    /// Whether the delay is certainly rather that of a hold than none.
    fn is_delayed(&self, period_s: f64) -> bool {
        self.delay_s.is_some_and(|[delay, error]| delay - CLEAR * error > 0.5 * HOLD * period_s)
    }

    /// Whether the yaw rate certainly comes before a steering that was read as held, by more than `share` of half a period.
    fn leads_the_hold_read(&self, share: f64, period_s: f64) -> bool {
        let least_s = -share * HOLD * period_s;
        self.delay_s.is_some_and(|[delay, error]| delay + CLEAR * error < least_s)
    }

    /// Whether a steering that was read as held over `period_s` certainly moves on between its samples. A yaw rate that
    /// comes before both is early, which is a fault of the recording.
    pub(crate) fn excludes_the_hold_read(&self, period_s: f64) -> bool {
        let Some(more) = self.excess_of_held() else { return false };
        let agree = more > PREFERRED && self.leads_the_hold_read(0.5, period_s);
        (agree || more > EXCLUDED && self.is_one_speed) && !self.leads_the_hold_read(1.0, period_s)
    }

    /// Whether a steering that was read as held over `period_s` may move on between its samples. Not of a yaw rate that is
    /// early: the steering is not what is wrong.
    pub(crate) fn doubts_the_hold_read(&self, period_s: f64) -> bool {
        let fits_better = self.excess_of_held().is_some_and(|more| more > PREFERRED);
        let leads = self.leads_the_hold_read(0.5, period_s);
        (leads || fits_better && self.is_one_speed) && !self.leads_the_hold_read(1.0, period_s)
    }

    /// The criterion of a steering that is held less that of one that moves on.
    fn excess_of_held(&self) -> Option<f64> {
        self.moving_on.zip(self.held).map(|(moving_on, held)| held - moving_on)
    }

    /// Whether a steering that is held would certainly lead the yaw rate.
    fn would_lead(&self, period_s: f64) -> bool {
        self.delay_s.is_some_and(|[delay, error]| delay + CLEAR * error < HOLD * period_s)
    }
}

/// What the data prefer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Preferred {
    /// The steering moves on between its samples.
    MovingOn,
    /// It rather moves on, and may be held.
    OpenMovingOn,
    /// It rather is held, and may move on.
    OpenHeld,
}

/// Whether half a period changes the response by more than a pass may leave uncertain.
pub(crate) fn matters(period_s: f64) -> bool {
    0.5 * TAU * HIGHEST_HZ * period_s > LARGEST_GAIN_ERROR
}

/// Whether straight lines from sample to sample change the gain by more than is negligible.
pub(crate) fn lines_matter(period_s: f64) -> bool {
    let half = 0.5 * TAU * HIGHEST_HZ * period_s;
    // Of cos(x)·x/sin(x), the ratio of what an integrator gets.
    1.0 - half / half.tan() > LEAST_GAIN_CHANGE
}

/// Whether a steering along straight lines excludes the band-limited one, by their criteria.
pub(crate) fn lines_exclude(band_limited: Option<f64>, lines: Option<f64>) -> bool {
    band_limited.zip(lines).is_some_and(|(band_limited, lines)| band_limited - lines > EXCLUDED)
}

/// The uncertainty of a steering that was read as straight lines over each `period_s`.
pub(crate) fn with_uncertain_lines(stated: &mut Uncertainty, period_s: f64) {
    for band in &mut stated.frequency_response {
        let phase_rad = TAU * band.frequency_hz * LINE_ERROR * period_s;
        band.phase_standard_error_rad = band.phase_standard_error_rad.hypot(phase_rad);
    }
}

/// By the evidence of a steering that moves on and of one that is held over `period_s`. Where half a period changes the
/// response by less than a pass may leave uncertain, the steering stays as it was read.
pub(crate) fn preferred(period_s: f64, evidence: &HoldEvidence) -> Preferred {
    let is_delayed = evidence.is_delayed(period_s);
    let (may_move_on, may_be_held) = match evidence.is_one_speed {
        true => (true, !evidence.would_lead(period_s)),
        false => (!is_delayed, is_delayed),
    };
    match evidence.excess_of_held() {
        Some(more) if more > EXCLUDED && may_move_on => Preferred::MovingOn,
        Some(more) if more < -PREFERRED && may_be_held && matters(period_s) => Preferred::OpenHeld,
        _ => Preferred::OpenMovingOn,
    }
}

/// What to do about a hold that is open and matters.
pub(crate) fn advice(period_s: f64) -> String {
    format!(
        "state whether the steering is held between its samples, which are {period_s:.3} s apart (option intersample: zoh, foh or bl): the log does not show it, and it changes the phase by half a sample"
    )
}

/// The uncertainty with standard errors of the frequency response that leave it open whether the steering is held over
/// `period_s`: the 95 % bands are wider by what lies between the two, by the model where it is continuous, and at least
/// half a period.
pub(crate) fn widened(
    stated: Uncertainty,
    period_s: f64,
    continuous: Option<&ContinuousModel>,
    model: &StateSpace,
) -> Uncertainty {
    let response = continuous.map(|m| ContinuousResponse {
        f: m.f.clone(),
        g: m.g.clone(),
        h: model.c.clone(),
        d: model.d[(0, 0)],
    });
    let held = response.as_ref().map(|response| response.held(period_s));
    let mut stated = stated;
    for band in &mut stated.frequency_response {
        let omega = TAU * band.frequency_hz;
        let half = 0.5 * omega * period_s;
        let by_model = response.as_ref().zip(held.as_ref());
        let apart = by_model.map(|(moving_on, held)| held(omega) / moving_on.value_at(omega));
        let apart = apart.filter(|a| a.re.is_finite() && a.im.is_finite());
        let apart = apart.unwrap_or_else(|| c64::cis(-half));
        let gain = (apart.re.hypot(apart.im) - 1.0).abs();
        band.phase_standard_error_rad += apart.im.atan2(apart.re).abs().max(half) / NORMAL_95;
        band.magnitude_standard_error += gain * band.magnitude / NORMAL_95;
    }
    stated.open_hold_s = Some(period_s);
    stated
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by(moving_on: Option<f64>, held: Option<f64>) -> HoldEvidence {
        HoldEvidence { moving_on, held, delay_s: Some([0.05, 0.01]), is_one_speed: true }
    }

    #[test]
    fn only_a_steering_that_moves_on_is_certain() {
        let of = |period_s, moving_on, held| preferred(period_s, &by(moving_on, held));
        assert_eq!(of(0.1, Some(-1000.0), Some(-950.0)), Preferred::MovingOn);
        assert_eq!(of(0.1, Some(-1000.0), Some(-990.0)), Preferred::OpenMovingOn);
        assert_eq!(of(0.1, Some(-1000.0), Some(-1001.0)), Preferred::OpenMovingOn);
        assert_eq!(of(0.1, Some(-1000.0), Some(-1100.0)), Preferred::OpenHeld);
        assert_eq!(of(0.01, Some(-1000.0), Some(-1100.0)), Preferred::OpenMovingOn);
        assert_eq!(of(0.1, None, Some(0.0)), Preferred::OpenMovingOn);
        assert_eq!(of(0.1, Some(f64::NAN), Some(0.0)), Preferred::OpenMovingOn);
    }

    #[test]
    fn lines_are_tried_in_slow_logs_and_need_evidence() {
        assert!(lines_matter(0.1) && lines_matter(0.05));
        assert!(!lines_matter(0.02) && !lines_matter(0.01));
        assert!(lines_exclude(Some(-1000.0), Some(-1021.0)));
        assert!(!lines_exclude(Some(-1000.0), Some(-1019.0)));
        assert!(!lines_exclude(None, Some(-1000.0)) && !lines_exclude(Some(f64::NAN), Some(0.0)));
    }

    /// Figures of three cars at 15 m/s, with a command of 20 Hz that was set at 100 Hz or at 20 Hz.
    #[test]
    fn a_hold_that_was_read_is_excluded_or_doubted() {
        let of = |more: f64, delay_s, is_one_speed| {
            let (moving_on, held) = (Some(-7800.0), Some(-7800.0 + more));
            let evidence = HoldEvidence { moving_on, held, delay_s, is_one_speed };
            (evidence.excludes_the_hold_read(0.05), evidence.doubts_the_hold_read(0.05))
        };
        let (leads, none) = (Some([-0.0161, 0.0015]), Some([0.001, 0.001]));
        let (certain, open, held) = ((true, true), (false, true), (false, false));
        assert_eq!(of(15.4, leads, true), certain);
        assert_eq!(of(77.2, none, true), certain);
        assert_eq!(of(15.4, none, true), open);
        assert_eq!(of(1.1, leads, true), open);
        assert_eq!(of(1.1, none, true), held);
        assert_eq!(of(77.2, none, false), held, "fits at one speed do not count");
        assert_eq!(of(15.4, leads, false), certain);
        let early = Some([-0.04, 0.001]);
        assert_eq!(of(77.2, early, true), held, "more than half a period");
    }

    /// Whatever models of one speed prefer.
    #[test]
    fn the_delay_at_the_speed_of_each_sample_has_to_agree() {
        let by_more = |more: f64| (Some(-1000.0), Some(-1000.0 + more));
        let [is_held, moves_on] = [-100.0, 50.0].map(by_more);
        let of = |(moving_on, held), delay_s, is_one_speed| {
            let evidence = HoldEvidence { delay_s, is_one_speed, ..by(moving_on, held) };
            preferred(0.1, &evidence)
        };
        let (none, half, unknown) = (Some([0.0, 0.01]), Some([0.05, 0.01]), Some([0.05, 0.05]));
        for delay_s in [none, half, unknown, None] {
            let held = if delay_s == none { Preferred::OpenMovingOn } else { Preferred::OpenHeld };
            assert_eq!(of(is_held, delay_s, true), held, "{delay_s:?}");
            assert_eq!(of(moves_on, delay_s, true), Preferred::MovingOn, "{delay_s:?}");
            let held = if delay_s == half { Preferred::OpenHeld } else { Preferred::OpenMovingOn };
            assert_eq!(of(is_held, delay_s, false), held, "{delay_s:?}");
            let moves = if delay_s == half { Preferred::OpenMovingOn } else { Preferred::MovingOn };
            assert_eq!(of(moves_on, delay_s, false), moves, "{delay_s:?}");
        }
    }
}
