//! Manoeuvres that a driver can steer: slaloms to the beat of a metronome, a slalom whose rhythm rises, and lane changes there
//! and back. Each of these signals has no integral and no first moment, as a multisine: it is the second difference of a windowed
//! wave, or pulses `+, −, −, +` of equal length, whose edges are ramps. An angle that rises slowly turns the vehicle.

use super::shape::{second_differences, window};
use std::f64::consts::TAU;
use steerwright_formats::ManoeuvreKind;

/// Rhythms of a slalom, Hz: 30 to 180 beats a minute, two beats a cycle.
const RHYTHMS_HZ: [f64; 8] = [0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 0.8, 1.0, 1.25, 1.5];
/// Ends of sweeps, Hz.
const SWEEPS_HZ: [[f64; 2]; 6] =
    [[0.1, 1.0], [0.1, 2.0], [0.2, 1.5], [0.2, 2.0], [0.3, 2.5], [0.5, 2.0]];
/// Times for which a step is held, s, and the time of an edge.
const HOLDS_S: [f64; 5] = [0.4, 0.6, 0.9, 1.3, 1.9];
const EDGE_S: f64 = 0.2;
/// Amplitude with which a growing slalom begins, as a share of the last.
const FIRST: f64 = 0.25;
/// Shares of the time for which an angle rises.
const RISES: [f64; 3] = [0.5, 0.7, 0.85];

/// A signal that a driver steers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum DriverSignal {
    Slalom {
        hz: f64,
    },
    Sweep {
        hz: [f64; 2],
    },
    Steps {
        hold_s: f64,
    },
    /// A slalom whose amplitude grows.
    GrowingSlalom {
        hz: f64,
    },
    /// An angle that rises for a share of the time, and returns.
    RisingAngle {
        share: f64,
    },
}

impl DriverSignal {
    /// The signals of a kind.
    pub(super) fn of_kind(kind: ManoeuvreKind) -> Vec<Self> {
        match kind {
            ManoeuvreKind::Multisine => Vec::new(),
            ManoeuvreKind::Slalom => RHYTHMS_HZ.map(|hz| Self::Slalom { hz }).to_vec(),
            ManoeuvreKind::Sweep => SWEEPS_HZ.map(|hz| Self::Sweep { hz }).to_vec(),
            ManoeuvreKind::Steps => HOLDS_S.map(|hold_s| Self::Steps { hold_s }).to_vec(),
            ManoeuvreKind::GrowingSlalom => {
                RHYTHMS_HZ.map(|hz| Self::GrowingSlalom { hz }).to_vec()
            }
            ManoeuvreKind::RisingAngle => RISES.map(|share| Self::RisingAngle { share }).to_vec(),
        }
    }

    pub(super) fn frequency_hz(self) -> Option<[f64; 2]> {
        match self {
            Self::Slalom { hz } | Self::GrowingSlalom { hz } => Some([hz; 2]),
            Self::Sweep { hz } => Some(hz),
            Self::Steps { .. } | Self::RisingAngle { .. } => None,
        }
    }

    pub(super) fn hold_s(self) -> Option<f64> {
        match self {
            Self::Steps { hold_s } => Some(hold_s),
            _ => None,
        }
    }

    /// Its samples over a length, with amplitude 1 away from the ends.
    pub(super) fn signal(self, length_s: f64, sample_time_s: f64) -> Vec<f64> {
        let count = (length_s / sample_time_s).round() as usize + 1;
        let times = (0..count).map(|k| sample_time_s * k as f64);
        match self {
            // The taper of one cycle is what a driver steers towards the first cone.
            Self::Slalom { hz } | Self::GrowingSlalom { hz } => {
                let rate = TAU * hz;
                let taper = (1.0 / hz).min(length_s / 3.0);
                let first = if matches!(self, Self::Slalom { .. }) { 1.0 } else { FIRST };
                let size = |t: f64| (first + (1.0 - first) * t / length_s) / (rate * rate);
                let wave = times.map(|t| -window(t, length_s, taper) * size(t) * (rate * t).sin());
                second_differences(&wave.collect::<Vec<f64>>(), sample_time_s)
            }
            Self::Sweep { hz: [from, to] } => {
                let growth = (to / from).ln() / length_s;
                let taper = (1.0 / from).min(length_s / 6.0);
                let wave = times.map(|t| {
                    let hz = from * (growth * t).exp();
                    let rate = TAU * hz;
                    let phase = TAU * (hz - from) / growth;
                    // At the end the cycles are short.
                    let rises = window(t, 2.0 * length_s, taper);
                    let falls = window(length_s - t, 2.0 * length_s, (2.0 / to).min(taper));
                    -rises * falls * phase.sin() / (rate * rate)
                });
                second_differences(&wave.collect::<Vec<f64>>(), sample_time_s)
            }
            Self::Steps { hold_s } => steps(hold_s, length_s, sample_time_s),
            Self::RisingAngle { share } => {
                let top = share * length_s;
                let angle =
                    |t: f64| if t < top { t / top } else { (length_s - t) / (length_s - top) };
                times.map(|t| angle(t).max(0.0)).collect()
            }
        }
    }
}

/// Lane changes there and back, each `+, −, −, +` and a pause, to alternate sides.
fn steps(hold_s: f64, length_s: f64, sample_time_s: f64) -> Vec<f64> {
    let samples = |time: f64| ((time / sample_time_s).round() as usize).max(1);
    let (hold, edge, all) = (samples(hold_s), samples(EDGE_S), samples(length_s));
    let mut sharp = vec![0.0; all];
    let once = 4 * hold + hold.max(edge);
    let mut side = 1.0;
    let mut at = 0;
    while at + once <= all {
        for (piece, sign) in [1.0, -1.0, -1.0, 1.0].into_iter().enumerate() {
            sharp[at + piece * hold..at + (piece + 1) * hold].fill(side * sign);
        }
        side = -side;
        at += once;
    }
    // The mean over the time of an edge keeps integral and moment at zero.
    let mut smooth = vec![0.0; all + edge];
    for (k, value) in smooth.iter_mut().enumerate() {
        let from = (k + 1).saturating_sub(edge);
        *value = sharp[from.min(all)..(k + 1).min(all)].iter().sum::<f64>() / edge as f64;
    }
    smooth
}

/// Every selection of `count` of `kinds` signals, in ascending order, with repetition.
pub(super) fn selections(kinds: usize, count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..count {
        let mut longer = Vec::new();
        for selection in &all {
            for next in selection.last().copied().unwrap_or(0)..kinds {
                let mut selection: Vec<usize> = selection.clone();
                selection.push(next);
                longer.push(selection);
            }
        }
        all = longer;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral and first moment of every signal vanish, so that a vehicle ends where it would have been without it.
    #[test]
    fn signals_leave_no_yaw_and_no_offset() {
        for kind in [ManoeuvreKind::Slalom, ManoeuvreKind::Sweep, ManoeuvreKind::Steps] {
            for driven in DriverSignal::of_kind(kind) {
                let signal = driven.signal(18.0, 0.01);
                let size: f64 = signal.iter().map(|u| u.abs()).sum();
                let integral: f64 = signal.iter().sum();
                let moment: f64 = signal.iter().enumerate().map(|(k, u)| 0.01 * k as f64 * u).sum();
                assert!(size > 200.0, "{driven:?} {size}");
                assert!(integral.abs() < 1e-9 * size, "{driven:?} {integral}");
                assert!(moment.abs() < 1e-8 * size, "{driven:?} {moment}");
            }
        }
    }

    #[test]
    fn selections_with_repetition() {
        assert_eq!(selections(2, 2), [vec![0, 0], vec![0, 1], vec![1, 1]]);
        // 8 kinds, 4 of them: (8 + 4 − 1)!/(4!·7!).
        assert_eq!(selections(8, 4).len(), 330);
    }
}
