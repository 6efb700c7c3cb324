//! Which times of a drive are used: where every channel is there, within the windows, without gaps.

use crate::drive::Drive;
use crate::error::{Place, counted, round_ms, short, shortened};
use crate::options::LogOptions;
use crate::resample::{Grid, MARGIN};
use crate::role::Role;
use crate::series::Series;
use crate::signal::mean;
use crate::{Error, noise};
use std::ops::Range;
use steerwright_formats::Intersample;

/// Sample time that is aimed at where there is noise: a Nyquist frequency of five times the about 5 Hz up to
/// which lateral dynamics respond.
const AIMED_SAMPLE_TIME: f64 = 0.02;
/// The same of a response of the speed, of up to about 2 Hz: the vibration in a command that was measured, which moves no vehicle,
/// would hide the gain in faster samples.
const AIMED_SAMPLE_TIME_OF_SPEED: f64 = 0.05;
/// Shorter segments are of no use: a block Hankel matrix of 30 block rows has no column in them.
pub(crate) const LEAST_SEGMENT: usize = 60;
/// Speed is averaged over this time, s: noise at the window's edge does not break a segment.
const SPEED_AVERAGE: f64 = 1.0;

/// From and to, s from the drive's first sample.
pub(crate) type Span = (f64, f64);

pub(crate) struct Split {
    at: Box<Place>,
    from: f64,
    to: f64,
    limit: f64,
}

/// The time that all channels of the drive cover, within the windows. `None` where no window meets
/// the drive and it is one of `several`.
pub(crate) fn covered(
    drive: &Drive,
    options: &LogOptions,
    several: bool,
) -> Result<Option<Vec<Span>>, Error> {
    let channels: Vec<&Series> = needed(drive, options).collect();
    let latest = |a: usize, b: usize| if channels[b].start() > channels[a].start() { b } else { a };
    let earliest = |a: usize, b: usize| if channels[b].end() < channels[a].end() { b } else { a };
    let first = (1..channels.len()).fold(0, latest);
    let last = (1..channels.len()).fold(0, earliest);
    let (from, to) = (channels[first].start(), channels[last].end());
    if from >= to {
        let (a, b) = (channels[last], channels[first]);
        return Err(Error::NoOverlap {
            first: format!("{} ({})", shortened(&a.column), a.file),
            first_from: a.start(),
            first_to: a.end(),
            second: format!("{} ({})", shortened(&b.column), b.file),
            second_from: b.start(),
            second_to: b.end(),
        });
    }
    if options.windows.is_empty() {
        return Ok(Some(vec![(from, to)]));
    }
    let mut spans: Vec<Span> = options
        .windows
        .iter()
        .map(|(a, b)| (a.max(from), b.min(to)))
        .filter(|(a, b)| a < b)
        .collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Windows that meet are one.
    let mut merged: Vec<Span> = Vec::new();
    for span in spans {
        match merged.last_mut() {
            Some(last) if span.0 <= last.1 => last.1 = last.1.max(span.1),
            _ => merged.push(span),
        }
    }
    match (merged.is_empty(), options.windows.first()) {
        (false, _) => Ok(Some(merged)),
        (true, Some(window)) if !several => Err(Error::NoOverlap {
            first: "the window".into(),
            first_from: window.0,
            first_to: window.1,
            second: "the log".into(),
            second_from: from,
            second_to: to,
        }),
        _ => Ok(None),
    }
}

/// The channels without which there is no sample.
fn needed<'d>(drive: &'d Drive, options: &'d LogOptions) -> impl Iterator<Item = &'d Series> {
    drive.channels.iter().filter(|channel| !options.is_optional(channel.role))
}

/// Leaves out the optional channels that are constant, or have gaps too long to be bridged where the others have none.
pub(crate) fn leave_out_unusable(
    drive: &mut Drive,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) {
    if !drive.channels.iter().any(|channel| options.is_optional(channel.role)) {
        return;
    }
    let spans = covered(drive, options, true).ok().flatten().unwrap_or_default();
    let (spans, _) = without_gaps(drive, spans, options);
    let all_s: f64 = spans.iter().map(|(from, to)| to - from).sum();
    let reason = |channel: &Series| {
        if let Some(value) = channel.constant_value() {
            return Some(channel.constant(value).to_string());
        }
        let limit = channel.gap_limit(options.max_gap_s);
        let inside = spans.iter().flat_map(|span| channel.missing_within(*span));
        let missing: Vec<Span> = inside.filter(|(from, to)| to - from > limit).collect();
        let (from, to) = *missing.first()?;
        let missing_s: f64 = missing.iter().map(|(from, to)| to - from).sum();
        Some(format!(
            "{}: column `{}` has no value in {missing_s:.1} s of {all_s:.1} s, first from {} s to {} s",
            channel.file,
            shortened(&channel.column),
            round_ms(from),
            short(to)
        ))
    };
    drive.channels.retain(|channel| {
        let reason = if options.is_optional(channel.role) { reason(channel) } else { None };
        let is_used = reason.is_none();
        warnings.extend(
            reason.map(|reason| format!("{reason}: not used as the {}", channel.role.name())),
        );
        is_used
    });
}

/// Cuts the gaps of every channel that are too long to be bridged out of the spans.
pub(crate) fn without_gaps(
    drive: &Drive,
    mut spans: Vec<Span>,
    options: &LogOptions,
) -> (Vec<Span>, Vec<Split>) {
    let mut splits: Vec<Split> = Vec::new();
    for channel in needed(drive, options) {
        let ends = (spans.first().map_or(0.0, |s| s.0), spans.last().map_or(0.0, |s| s.1));
        for i in channel.gaps(ends.0, ends.1, options.max_gap_s) {
            let (from, to) = (channel.time[i], channel.time[i + 1]);
            let mut inside = false;
            let mut kept = Vec::with_capacity(spans.len() + 1);
            for (a, b) in spans {
                if to <= a || from >= b {
                    kept.push((a, b));
                    continue;
                }
                inside = true;
                kept.extend([(a, from.min(b)), (to.max(a), b)].into_iter().filter(|s| s.0 < s.1));
            }
            spans = kept;
            if inside {
                let line = channel.line_after(i);
                let at = Place::new(&channel.file, line, &channel.column);
                let limit = channel.gap_limit(options.max_gap_s);
                splits.push(Split { at, from, to, limit });
            }
        }
    }
    (spans, splits)
}

/// Half a metre a second backwards is sensor noise at standstill.
const REVERSING_MPS: f64 = -0.5;

/// The times within a span in which the vehicle reverses: between the last row before and the first row after that do
/// not. Its dynamics are others there.
pub(crate) fn reversing(speed: &Series, (from, to): Span) -> Vec<Span> {
    let mut runs: Vec<Span> = Vec::new();
    let (time, value) = (&speed.time, &speed.value);
    for i in (0..value.len()).filter(|&i| value[i] < REVERSING_MPS) {
        let start = if i > 0 { time[i - 1] } else { f64::NEG_INFINITY };
        let end = time.get(i + 1).copied().unwrap_or(f64::INFINITY);
        match runs.last_mut() {
            Some(run) if start < run.1 => run.1 = end,
            _ => runs.push((start, end)),
        }
    }
    runs.iter().map(|run| (run.0.max(from), run.1.min(to))).filter(|run| run.0 < run.1).collect()
}

/// Cuts the times in which the vehicle reverses out of the spans, and returns them.
pub(crate) fn without_reversing(drive: &Drive, spans: Vec<Span>) -> (Vec<Span>, Vec<Span>) {
    let Some(speed) = drive.channel(Role::Speed) else { return (spans, Vec::new()) };
    let (mut kept, mut cut) = (Vec::new(), Vec::new());
    for (mut from, to) in spans {
        for run in reversing(speed, (from, to)) {
            if from < run.0 {
                kept.push((from, run.0));
            }
            from = run.1;
            cut.push(run);
        }
        if from < to {
            kept.push((from, to));
        }
    }
    (kept, cut)
}

/// Rejects a speed that jumps to reverse and back, as no vehicle does.
pub(crate) fn check_reversing(speed: &Series, (from, to): Span) -> Result<(), Error> {
    const SHORTEST_S: f64 = 0.3;
    const LARGEST_STEP_MPS: f64 = 3.0;
    if to - from > SHORTEST_S {
        return Ok(());
    }
    let rows = (0..speed.value.len()).filter(|&i| from < speed.time[i] && speed.time[i] < to);
    let least = rows.min_by(|&a, &b| speed.value[a].total_cmp(&speed.value[b]));
    match least.filter(|&i| speed.value[i] < -LARGEST_STEP_MPS) {
        Some(row) => Err(speed.impossible(row, speed.value[row], (REVERSING_MPS, "m/s"))),
        None => Ok(()),
    }
}

/// What was left out since the vehicle reversed there.
pub(crate) fn reversing_in_words(name: &str, seconds: f64, first_s: f64) -> String {
    format!(
        "{name}: the vehicle reverses for {seconds:.1} s, first at {first_s:.2} s: left out, since its dynamics differ there"
    )
}

pub(crate) fn warn_splits(drive: &Drive, splits: &[Split], warnings: &mut Vec<String>) {
    const LISTED: usize = 5;
    for split in splits.iter().take(LISTED) {
        warnings.push(format!(
            "{}: nothing from {} s to {} s: the drive is split there",
            split.at,
            round_ms(split.from),
            short(split.to)
        ));
    }
    if splits.len() > LISTED {
        warnings.push(format!(
            "{}: split at {} more",
            drive.name,
            counted(splits.len() - LISTED, "gap")
        ));
    }
}

/// The longest gap, where nothing between gaps is long enough.
pub(crate) fn refused_gap(splits: &[Split], spans: &[Span]) -> Option<Error> {
    let worst = splits.iter().max_by(|a, b| (a.to - a.from).total_cmp(&(b.to - b.from)))?;
    let longest = spans.iter().copied().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let longest = longest.unwrap_or((worst.from, worst.from));
    Some(Error::Gap {
        at: worst.at.clone(),
        from_s: round_ms(worst.from),
        to_s: round_ms(worst.to),
        gap_s: round_ms(worst.to - worst.from),
        limit_s: round_ms(worst.limit),
        longest: (round_ms(longest.0), round_ms(longest.1)),
    })
}

/// The clock of a drive: what its channels allow for the sample time.
pub(crate) struct Clock {
    /// Period of the faster of input and output, s; a slower speed of a lateral response follows.
    pub(crate) fast: f64,
    /// The sample time that suits it, s.
    preferred: f64,
    shared: bool,
    /// Whether the steering, as it is logged, is held between its samples.
    held: bool,
}

impl Clock {
    pub(crate) fn from_drive(drive: &Drive) -> Self {
        if drive.channels[0].role.is_named_channel() {
            return Self::of_channels(&drive.channels);
        }
        let [input, output] = [&drive.channels[0], &drive.channels[1]];
        let (a, b) = (input.period, output.period);
        let fast = a.min(b);
        let shared = is_uniform(input) && same_clock(input, output);
        let is_of_speed = output.role == Role::Speed;
        let aimed = if is_of_speed { AIMED_SAMPLE_TIME_OF_SPEED } else { AIMED_SAMPLE_TIME };
        let preferred = if shared {
            let periods = (aimed / fast + 1e-6).floor().max(1.0);
            // Decimation is not exact: without noise to hide that, the log's own rate is kept.
            if periods > 1.0 && !is_of_speed && noise::is_negligible(input, output) {
                fast
            } else {
                fast * periods
            }
        } else {
            aimed.max(a.max(b))
        };
        let held = input.intersample == Intersample::Zoh;
        Self { fast, preferred, shared, held }
    }

    /// The clock of named channels: the log's own rate, of several rates the slowest.
    fn of_channels(channels: &[Series]) -> Self {
        let periods = || channels.iter().map(|c| c.period);
        let fast = periods().fold(f64::INFINITY, f64::min);
        let first = &channels[0];
        let shared = is_uniform(first) && channels.iter().all(|c| same_clock(first, c));
        let mut inputs = channels.iter().filter(|c| c.role.is_held());
        Self {
            fast,
            preferred: if shared { fast } else { periods().fold(0.0, f64::max) },
            shared,
            held: inputs.all(|c| c.intersample == Intersample::Zoh),
        }
    }

    /// Fine steps in a sample.
    pub(crate) fn per_step(&self, step: f64) -> f64 {
        (step / self.fast - 1e-3).ceil().max(1.0)
    }

    /// Samples of that step on either side that the filters need.
    pub(crate) fn margin(&self, step: f64) -> f64 {
        if self.per_step(step) > 1.0 || !self.held { MARGIN } else { 0.0 }
    }

    /// The grid of one span.
    pub(crate) fn grid(&self, drive: &Drive, span: Span, step: f64) -> Grid {
        let (mut from, to) = span;
        // Start on a sample of a shared clock, so that interpolation changes nothing.
        if self.shared {
            let time = &drive.channels[0].time;
            let i = time.partition_point(|t| *t < from - 1e-9);
            from = time.get(i).copied().unwrap_or(from);
        }
        Grid::within(from, to, step, self.per_step(step) as usize, self.margin(step))
    }
}

/// One sample time for all drives: the requested one, else the longest that suits one of them.
pub(crate) fn sample_time(clocks: &[&Clock], options: &LogOptions) -> Result<f64, Error> {
    let fastest = clocks.iter().map(|c| c.fast).fold(0.0, f64::max);
    let step = match options.sample_time_s {
        Some(requested) if requested < fastest * (1.0 - 1e-3) => {
            return Err(Error::SampleTimeTooShort { requested, least: fastest });
        }
        Some(requested) => requested,
        None => clocks.iter().map(|c| c.preferred).fold(0.0, f64::max),
    };
    // Decimal clocks leave digits like 0.03999999999999915.
    Ok((step * 1e9).round() / 1e9)
}

/// Within a twentieth of a period; rows that are left out are no irregularity.
fn is_uniform(series: &Series) -> bool {
    series.time.windows(2).all(|w| {
        let periods = (w[1] - w[0]) / series.period;
        (periods - periods.round().max(1.0)).abs() < 0.05 || periods > 3.0
    })
}

fn same_clock(a: &Series, b: &Series) -> bool {
    let apart = (a.start() - b.start()) / a.period;
    (a.period / b.period - 1.0).abs() < 1e-3 && (apart - apart.round()).abs() < 1e-3
}

/// Samples on either side of one over which its speed is averaged.
pub(crate) fn half_average(step: f64) -> usize {
    (0.5 * SPEED_AVERAGE / step).round() as usize
}

/// Whether the controller steers and the driver does not, on the grid; `None` where the log does not state it.
pub(crate) fn engaged(drive: &Drive, grid: &Grid) -> Option<Vec<bool>> {
    let on = |role| Some(drive.channel(role)?.samples_on(grid));
    let [engaged, overridden] = [Role::Engaged, Role::Override].map(on);
    if engaged.is_none() && overridden.is_none() {
        return None;
    }
    let at = |samples: &Option<Vec<f64>>, k: usize| samples.as_ref().map(|s| s[k] > 0.5);
    Some(
        (0..grid.count)
            .map(|k| at(&engaged, k).unwrap_or(true) && !at(&overridden, k).unwrap_or(false))
            .collect(),
    )
}

/// The parts of the runs in which `is_used` holds, and that are long enough.
pub(crate) fn within(runs: Vec<Range<usize>>, is_used: &[bool]) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    for run in runs {
        let first = parts.len();
        for k in run.filter(|&k| is_used[k]) {
            match parts[first..].last_mut() {
                Some(part) if part.end == k => part.end = k + 1,
                _ => parts.push(k..k + 1),
            }
        }
    }
    parts.retain(|part| part.len() >= LEAST_SEGMENT);
    parts
}

/// The runs of samples in which the averaged speed stays within `window`, and are long enough.
pub(crate) fn within_speeds(speed: &[f64], step: f64, window: (f64, f64)) -> Vec<Range<usize>> {
    let half = half_average(step);
    let inside = |k: usize| {
        let (a, b) = (k.saturating_sub(half), (k + half + 1).min(speed.len()));
        (window.0..=window.1).contains(&mean(&speed[a..b]))
    };
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in (0..speed.len()).filter(|&k| inside(k)) {
        match runs.last_mut() {
            Some(run) if run.end == k => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs.retain(|run| run.len() >= LEAST_SEGMENT);
    runs
}
