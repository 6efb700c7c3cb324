//! The blocks of a recording, and the document of a manoeuvre.

use super::criterion::{Criterion, Square};
use super::driver::{DriverSignal, selections};
use super::limits::Peaks;
use super::options::ExcitationOptions;
use crate::Error;
use steerwright_formats::{
    Alternative, Document, ExpectedErrors, Manoeuvre, ManoeuvreBlock, ManoeuvreKind,
    ManoeuvrePurpose, Provenance, Quality, SignalPeaks, SteeringSignal,
};

/// Share of a recording that estimates by default.
const ESTIMATION_SHARE: f64 = 0.5;
/// Most blocks of a half whose signals a selection names one by one.
const MOST_SELECTED: usize = 4;
/// The longest time that is stated as needed, as a multiple of the manoeuvre's.
const LONGEST: f64 = 1e4;
const BISECTIONS: usize = 60;

/// A signal with the samples to steer and what it uses of the limits.
#[derive(Clone)]
pub(super) struct Scaled {
    pub(super) steering_rad: Vec<f64>,
    pub(super) peaks: Peaks,
}

impl Scaled {
    pub(super) fn signal(
        self,
        speed_mps: f64,
        frequency_hz: Option<[f64; 2]>,
        hold_s: Option<f64>,
    ) -> SteeringSignal {
        let Peaks { nominal, upper, end_offset_m } = self.peaks;
        SteeringSignal {
            speed_mps,
            frequency_hz,
            hold_s,
            peaks: SignalPeaks {
                lateral_acceleration_mps2: [nominal[0], upper[0]],
                offset_m: [nominal[1], upper[1]],
                angle_rad: nominal[2],
                rate_radps: nominal[3],
                end_offset_m,
            },
            steering_rad: self.steering_rad,
        }
    }
}

/// The vehicle that a manoeuvre is for.
pub(super) struct Subject<'a> {
    pub(super) name: &'a str,
    pub(super) steering_ratio: f64,
    pub(super) quality: &'a Quality,
}

impl Subject<'_> {
    /// The document of signals in an order, before its standard errors are known.
    pub(super) fn manoeuvre(
        &self,
        options: &ExcitationOptions,
        kind: ManoeuvreKind,
        signals: Vec<SteeringSignal>,
        order: Vec<(usize, bool)>,
    ) -> Manoeuvre {
        let block = |(k, (signal, mirrored)): (usize, &(usize, bool))| ManoeuvreBlock {
            start_s: k as f64 * options.block_s,
            signal: *signal,
            mirrored: *mirrored,
        };
        Manoeuvre {
            schema: Manoeuvre::SCHEMA.into(),
            name: self.name.into(),
            kind,
            purpose: ManoeuvrePurpose {
                goal: options.goal,
                band_hz: options.band_hz,
                max_error: options.max_error,
            },
            limits: options.limits,
            noise_density: options.noise_density,
            estimation_share: ESTIMATION_SHARE,
            steering_ratio: self.steering_ratio,
            sample_time_s: options.sample_time_s,
            block_s: options.block_s,
            schedule: order.iter().enumerate().map(block).collect(),
            signals,
            expected: ExpectedErrors {
                largest_error: 0.0,
                bound: None,
                gap: None,
                met: true,
                needed_time_s: None,
                response: Vec::new(),
                parameters: Vec::new(),
            },
            alternatives: Vec::new(),
            quality: self.quality.clone(),
            provenance: Provenance {
                version: env!("CARGO_PKG_VERSION").into(),
                ..Provenance::default()
            },
        }
    }
}

/// The selection of candidates, with repetition, of least cost by the information of each.
pub(super) fn best_selection(
    information: &[Square],
    repeats: usize,
    prior: &[f64],
    criterion: &Criterion,
) -> Vec<usize> {
    let selected = repeats.min(MOST_SELECTED);
    let weight = repeats as f64 / selected as f64;
    let cost = |selection: &Vec<usize>| {
        let mut sum = prior.to_vec();
        for k in selection {
            for (s, m) in sum.iter_mut().zip(&information[*k]) {
                *s += weight * m;
            }
        }
        criterion.cost(&sum)
    };
    let all = selections(information.len(), selected);
    all.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
}

/// The signals of a selection of candidates, and their order: both halves have the same signals at all speeds. `scaled` has
/// each candidate at each speed; `is_mirrored` takes the place in a half, and the half.
pub(super) fn of_selection(
    selection: &[usize],
    candidates: &[DriverSignal],
    speeds_mps: &[f64],
    scaled: &[Scaled],
    repeats: usize,
    is_mirrored: impl Fn(usize, usize) -> bool,
) -> (Vec<SteeringSignal>, Vec<(usize, bool)>) {
    let mut used = selection.to_vec();
    used.dedup();
    let mut signals: Vec<SteeringSignal> = Vec::new();
    for (at, speed) in speeds_mps.iter().enumerate() {
        for k in &used {
            let own = scaled[k * speeds_mps.len() + at].clone();
            signals.push(own.signal(
                *speed,
                candidates[*k].frequency_hz(),
                candidates[*k].hold_s(),
            ));
        }
    }
    let mut order = Vec::new();
    for half in 0..2 {
        for at in 0..speeds_mps.len() {
            for repeat in 0..repeats {
                let k = selection.get(repeat % selection.len().max(1)).copied().unwrap_or(0);
                let place = used.iter().position(|other| *other == k).unwrap_or(0);
                order.push((at * used.len() + place, is_mirrored(repeat, half)));
            }
        }
    }
    (signals, order)
}

/// The best manoeuvre of the wanted kinds, with all as alternatives.
pub(super) fn best_of(
    all: &[Manoeuvre],
    is_wanted: impl Fn(ManoeuvreKind) -> bool,
) -> Result<Manoeuvre, Error> {
    let error = |m: &Manoeuvre| m.expected.largest_error;
    let wanted = all.iter().filter(|m| is_wanted(m.kind));
    let best = wanted.min_by(|a, b| error(a).total_cmp(&error(b)));
    let Some(best) = best else {
        return Err(Error::Numerical { what: "the design of the manoeuvre" });
    };
    let alternative = |m: &Manoeuvre| Alternative { kind: m.kind, largest_error: error(m) };
    Ok(Manoeuvre { alternatives: all.iter().map(alternative).collect(), ..best.clone() })
}

/// The least multiple of the time that is enough; `None` where none is.
pub(super) fn needed_times(
    is_enough: impl Fn(f64) -> Result<bool, Error>,
) -> Result<Option<f64>, Error> {
    if !is_enough(LONGEST)? {
        return Ok(None);
    }
    let mut ends = [1.0 / LONGEST, LONGEST];
    for _ in 0..BISECTIONS {
        let middle = (ends[0] * ends[1]).sqrt();
        let end = usize::from(is_enough(middle)?);
        ends[end] = middle;
    }
    Ok(Some(ends[1]))
}
