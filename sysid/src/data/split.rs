//! Which part of a log validates the model (docs/methods/validation.md). By default the end does.
//! Where either part is hardly excited, or the speed varies, the excited parts are shared instead: of each run of [`PAIR_S`]
//! excited seconds the first part is estimation data and the rest validation data, and what is not excited stays with the
//! estimation data. Excited are windows of [`WINDOW_S`] whose input has a share of the log's mean power about its mean.

use crate::Error;
use std::collections::BTreeMap;
use std::ops::Range;
use steerwright_drivelog::DriveLog;
use steerwright_drivelog::signal::{mean, standard_deviation};
use steerwright_formats::LEAST_SPREAD;

/// Which part of a log validates the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValidationData {
    /// Share of the log.
    pub fraction: f64,
    /// Where that share is.
    pub place: ValidationPlace,
}

impl Default for ValidationData {
    fn default() -> Self {
        Self { fraction: 0.5, place: ValidationPlace::Auto }
    }
}

/// Where the validation data of a log are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValidationPlace {
    /// The end; where a part is hardly excited, or the speed varies, blocks over the whole log.
    Auto,
    /// The end, whatever was driven there.
    End,
}

steerwright_formats::words!(ValidationPlace { Auto = "auto", End = "end" });

impl ValidationData {
    pub(crate) fn check(&self) -> Result<(), Error> {
        if (0.1..=0.9).contains(&self.fraction) {
            return Ok(());
        }
        let value = format!("{}%", 100.0 * self.fraction);
        Err(Error::option("validation fraction", value, "10% to 90%"))
    }

    /// Adds the options to those of an identification.
    pub(crate) fn describe(&self, options: &mut BTreeMap<String, String>) {
        options.insert("validation_fraction".into(), self.fraction.to_string());
        if self.place != ValidationPlace::Auto {
            options.insert("validation_place".into(), self.place.name().into());
        }
    }
}

/// Shorter pieces of a segment have no column in a block Hankel matrix of 30 block rows.
pub(crate) const CRUMB: usize = 60;
/// A window, s: a manoeuvre has a reversal within it.
const WINDOW_S: f64 = 2.0;
/// Share of the mean power from which a window is excited.
const EXCITED: f64 = 0.15;
/// Share of the power, relative to their lengths, that both parts of a split at the end hold.
const FAIR_SHARE: f64 = 0.5;
/// … or that share of their windows is excited, as in a drive that is steered less strongly than another.
const EXCITED_SHARE: f64 = 0.5;
/// Length of the blocks that estimate where the log holds more than is used, s.
const BLOCK_S: f64 = 60.0;
/// Excited time of which one part estimates and the other validates, s.
const PAIR_S: f64 = 40.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Selection {
    End,
    /// Blocks, since a part of a split at the end is hardly excited.
    ExcitedBlocks,
    /// Blocks, since the speed varies: both parts hold all speeds and lateral accelerations of the drive.
    SpeedBlocks,
}

impl Selection {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::End => "end",
            Self::ExcitedBlocks => "excited-blocks",
            Self::SpeedBlocks => "speed-blocks",
        }
    }
}

/// Samples to estimate from and to validate on, each as ranges within segments, in order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Split {
    pub(crate) estimation: Vec<Range<usize>>,
    pub(crate) validation: Vec<Range<usize>>,
    pub(crate) selection: Selection,
}

impl Split {
    /// The end of the log, moved to the nearest end of a segment where it would leave a crumb of one.
    pub(crate) fn end(log: &DriveLog, n: usize, fraction: f64) -> Self {
        let split = n - (fraction * n as f64).round() as usize;
        let ends = log.segments.iter().map(|s| s.range.end).filter(|end| *end < n);
        let split = ends
            .min_by_key(|end| end.abs_diff(split))
            .filter(|end| end.abs_diff(split) < CRUMB)
            .unwrap_or(split);
        let within = |range: Range<usize>| -> Vec<Range<usize>> {
            let pieces = log
                .segments
                .iter()
                .map(|s| s.range.start.max(range.start)..s.range.end.min(range.end));
            pieces.filter(|r| !r.is_empty()).collect()
        };
        Self {
            estimation: within(0..split),
            validation: within(split..n),
            selection: Selection::End,
        }
    }

    /// The end of the log where both parts are excited by the input and the speed is one, else blocks.
    pub(crate) fn new(log: &DriveLog, input: &[f64], wanted: ValidationData) -> Self {
        let fraction = wanted.fraction;
        let end = Self::end(log, input.len(), fraction);
        if wanted.place == ValidationPlace::End {
            return end;
        }
        let mean = mean(input);
        let power = |ranges: &[Range<usize>]| -> f64 {
            ranges.iter().flat_map(|r| &input[r.clone()]).map(|u| (u - mean).powi(2)).sum()
        };
        let count = |ranges: &[Range<usize>]| ranges.iter().map(Range::len).sum::<usize>() as f64;
        let all = power(&end.estimation) + power(&end.validation);
        let samples = count(&end.estimation) + count(&end.validation);
        if all <= 0.0 {
            return end;
        }
        let excited = excited(log, input, mean, all / samples);
        let fair = |part: &[Range<usize>]| {
            let windows = part.iter().flat_map(|r| &excited[r.clone()]).filter(|e| **e).count();
            windows as f64 >= EXCITED_SHARE * count(part)
                || power(part) / all >= FAIR_SHARE * count(part) / samples
        };
        let selection = if !fair(&end.estimation) || !fair(&end.validation) {
            Selection::ExcitedBlocks
        } else if varies(log) {
            Selection::SpeedBlocks
        } else {
            return end;
        };
        Self::blocks(log, &excited, fraction, selection).unwrap_or(end)
    }

    /// At most so many samples of estimation data, in blocks of [`BLOCK_S`] spread evenly; `None`: all.
    pub(crate) fn thinned(mut self, most: Option<usize>, sample_time_s: f64) -> Self {
        let Some(most) = most else { return self };
        let count: usize = self.estimation.iter().map(Range::len).sum();
        let block = ((BLOCK_S / sample_time_s).round() as usize).clamp(1, most.max(1));
        let blocks = most / block;
        if count <= most || blocks == 0 {
            return self;
        }
        let mut thinned = Vec::new();
        for from in (0..blocks).map(|b| b * count / blocks) {
            let mut at = 0;
            for r in &self.estimation {
                let (start, end) = (from.max(at), (from + block).min(at + r.len()));
                if start + CRUMB <= end {
                    thinned.push(r.start + start - at..r.start + end - at);
                }
                at += r.len();
            }
        }
        // Of a log in crumbs nothing would be left.
        if 2 * thinned.iter().map(Range::len).sum::<usize>() > most {
            self.estimation = thinned;
        }
        self
    }

    pub(crate) fn unused(log: &DriveLog, parts: [&[Range<usize>]; 2]) -> Vec<Range<usize>> {
        let mut used: Vec<&Range<usize>> = parts.into_iter().flatten().collect();
        used.sort_by_key(|r| r.start);
        let mut unused = Vec::new();
        for s in &log.segments {
            let mut from = s.range.start;
            let within = used.iter().filter(|r| s.range.contains(&r.start));
            for range in within.copied().chain([&(s.range.end..s.range.end)]) {
                if from < range.start {
                    unused.push(from..range.start);
                }
                from = range.end;
            }
        }
        unused
    }

    fn blocks(
        log: &DriveLog,
        excited: &[bool],
        fraction: f64,
        selection: Selection,
    ) -> Option<Self> {
        let total = excited.iter().filter(|e| **e).count();
        let pairs = ((total as f64 * log.sample_time_s / PAIR_S).floor() as usize).max(1);
        let pair = total as f64 / pairs as f64;
        let mut validates = vec![false; excited.len()];
        let mut seen = 0.0;
        for (validates, _) in validates.iter_mut().zip(excited).filter(|(_, e)| **e) {
            *validates = (seen % pair) >= (1.0 - fraction) * pair;
            seen += 1.0;
        }
        let mut out = Self { estimation: Vec::new(), validation: Vec::new(), selection };
        for s in &log.segments {
            let range = s.range.start..s.range.end.min(excited.len());
            let mut from = range.start;
            for k in range.clone() {
                if k + 1 == range.end || validates[k + 1] != validates[from] {
                    let part =
                        if validates[from] { &mut out.validation } else { &mut out.estimation };
                    // Crumbs validate and estimate nothing.
                    if k + 1 - from >= CRUMB.min(range.len()) {
                        part.push(from..k + 1);
                    }
                    from = k + 1;
                }
            }
        }
        let long = |part: &[Range<usize>]| part.iter().any(|r| r.len() >= 2 * CRUMB);
        if long(&out.estimation) && long(&out.validation) { Some(out) } else { None }
    }
}

/// Whether the speed varies: a part of the drive then judges no model of the whole.
fn varies(log: &DriveLog) -> bool {
    let speed = log.speed.as_ref().filter(|v| v.len() == log.len());
    speed.is_some_and(|v| standard_deviation(v) >= LEAST_SPREAD * mean(v))
}

fn excited(log: &DriveLog, input: &[f64], mean: f64, mean_power: f64) -> Vec<bool> {
    let window = ((WINDOW_S / log.sample_time_s).round() as usize).max(1);
    let mut excited = vec![false; input.len()];
    for s in &log.segments {
        let range = s.range.start..s.range.end.min(input.len());
        for from in range.clone().step_by(window) {
            let piece = from..(from + window).min(range.end);
            let power = input[piece.clone()].iter().map(|u| (u - mean).powi(2)).sum::<f64>();
            if power > EXCITED * mean_power * piece.len() as f64 {
                excited[piece].fill(true);
            }
        }
    }
    excited
}

#[cfg(test)]
#[allow(clippy::single_range_in_vec_init)]
mod tests {
    use super::*;
    use steerwright_drivelog::Segment;

    fn log(input: Vec<f64>) -> DriveLog {
        DriveLog {
            name: String::new(),
            sample_time_s: 0.04,
            segments: vec![Segment { time0_s: 0.0, range: 0..input.len() }],
            output: input.clone(),
            input,
            speed: None,
            steering_ratio: 1.0,
            vehicle_class: None,
            response: Default::default(),
            others: Default::default(),
            gnss: None,
            channels: Vec::new(),
            warnings: Vec::new(),
            sources: Vec::new(),
            options: std::collections::BTreeMap::new(),
        }
    }

    fn slalom(seconds: std::ops::Range<f64>, until: f64) -> DriveLog {
        let t = (0..(until / 0.04) as usize).map(|k| 0.04 * k as f64);
        log(t.map(|t| if seconds.contains(&t) { (3.0 * t).sin() } else { 0.0 }).collect())
    }

    #[test]
    fn the_end_validates_where_it_is_excited() {
        let log = slalom(0.0..60.0, 60.0);
        let split = Split::new(&log, &log.input, ValidationData::default());
        assert_eq!(split, Split::end(&log, log.len(), 0.5));
        assert_eq!((split.estimation, split.validation), (vec![0..750], vec![750..1500]));
    }

    #[test]
    fn both_parts_hold_the_speeds_of_the_drive() {
        let mut log = slalom(0.0..160.0, 160.0);
        let n = log.len();
        let rising: Vec<f64> = (0..n).map(|k| 5.0 + 25.0 * k as f64 / n as f64).collect();
        log.speed = Some(rising.clone());
        let split = Split::new(&log, &log.input, ValidationData::default());
        assert_eq!(split.selection, Selection::SpeedBlocks);
        let at_end = ValidationData { place: ValidationPlace::End, ..ValidationData::default() };
        assert_eq!(Split::new(&log, &log.input, at_end), Split::end(&log, n, 0.5));
        for part in [&split.estimation, &split.validation] {
            let speeds: Vec<f64> = part.iter().flat_map(|r| &rising[r.clone()]).copied().collect();
            assert!((mean(&speeds) / mean(&rising) - 1.0).abs() < 0.2, "{part:?}");
        }
        log.speed = Some(rising.iter().map(|v| 15.0 + 0.01 * v).collect());
        assert_eq!(
            Split::new(&log, &log.input, ValidationData::default()).selection,
            Selection::End
        );
    }

    #[test]
    fn a_long_log_is_thinned_evenly() {
        let log = slalom(0.0..1000.0, 1000.0);
        let whole = Split::new(&log, &log.input, ValidationData::default());
        assert_eq!(whole.clone().thinned(Some(12_500), 0.04), whole);
        let split = whole.clone().thinned(Some(3_000), 0.04);
        assert_eq!(split.estimation, [0..1500, 6250..7750]);
        assert_eq!(split.validation, whole.validation);
        let unused = Split::unused(&log, [&split.estimation, &split.validation]);
        assert_eq!(unused, [1500..6250, 7750..12_500]);
    }

    #[test]
    fn a_straight_does_not_validate() {
        // 12 s of slalom, 8 s straight.
        let log = slalom(0.0..12.0, 20.0);
        let split = Split::new(&log, &log.input, ValidationData::default());
        assert_eq!(split.selection, Selection::ExcitedBlocks);
        assert_eq!((split.estimation, split.validation), (vec![0..150, 300..500], vec![150..300]));
        // Half as strong is not weak.
        let t = (0..1500).map(|k| (0.04 * f64::from(k), if k < 750 { 1.0 } else { 0.5 }));
        let log = self::log(t.map(|(t, size)| size * (3.0 * t).sin()).collect());
        assert_eq!(
            Split::new(&log, &log.input, ValidationData::default()).selection,
            Selection::End
        );
        // A straight at the start, and pairs of a long log.
        let log = slalom(100.0..200.0, 200.0);
        let split = Split::new(&log, &log.input, ValidationData::default());
        assert_eq!(split.selection, Selection::ExcitedBlocks);
        assert_eq!(split.validation.len(), 2);
        assert!(split.validation.iter().all(|r| r.start >= 2500));
    }
}
