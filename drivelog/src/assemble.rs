//! Brings drives onto the grid, segment by segment, and reports what was left out.

use crate::Error;
use crate::drive::Drive;
use crate::error::{Place, counted};
use crate::log::{DriveLog, Segment};
use crate::options::LogOptions;
use crate::resample::Grid;
use crate::role::Role;
use crate::segments::{self, Clock, LEAST_SEGMENT, Span, Split};
use crate::series::{LEAST_SAMPLES, MOST_SAMPLES, Series};
use std::ops::Range;

impl DriveLog {
    pub(super) fn fill(&mut self, drives: &[Drive], options: &LogOptions) -> Result<(), Error> {
        let (mut plans, mut kept) = (Vec::new(), Kept::default());
        for drive in drives {
            match segments::covered(drive, options, drives.len() > 1)? {
                Some(spans) => {
                    let (spans, splits) = segments::without_gaps(drive, spans, options);
                    segments::warn_splits(drive, &splits, &mut self.warnings);
                    kept.splits.extend(splits);
                    let (spans, reversing) = segments::without_reversing(drive, spans);
                    kept.add_reversing(drive, &reversing, &mut self.warnings)?;
                    plans.push((drive, Clock::from_drive(drive), spans));
                }
                None => self.warnings.push(format!("{}: no window meets this drive", drive.name)),
            }
        }
        if let (true, Some(drive)) = (plans.is_empty(), drives.first()) {
            // The error is that of a single drive.
            segments::covered(drive, options, false)?;
        }
        let clocks: Vec<&Clock> = plans.iter().map(|(_, clock, _)| clock).collect();
        self.sample_time_s = segments::sample_time(&clocks, options)?;
        check_size(&plans, self.sample_time_s)?;
        for (drive, clock, spans) in plans {
            self.add(drive, &clock, spans, options, &mut kept)?;
        }
        kept.check(self, options)
    }

    fn add(
        &mut self,
        drive: &Drive,
        clock: &Clock,
        spans: Vec<Span>,
        options: &LogOptions,
        kept: &mut Kept,
    ) -> Result<(), Error> {
        let step = self.sample_time_s;
        for span in spans {
            let grid = clock.grid(drive, span, step);
            kept.samples += grid.count;
            kept.spans.push(span);
            if grid.count < LEAST_SEGMENT {
                kept.short.push(span);
                continue;
            }
            let margin = step * clock.margin(step);
            let end = grid.start + (grid.count as f64 - 1.0) * step;
            for channel in &drive.channels {
                let (from, to) = (grid.start - margin, end + margin);
                channel.warn_bridged(from, to, options.max_gap_s, &mut self.warnings);
            }
            let on_grid = |role: Role| Some(drive.channel(role)?.interpolate(&grid));
            let [input, output] = options.response.roles().map(on_grid);
            let output = output.unwrap_or_default();
            let speed = self.speed.as_ref().and_then(|_| on_grid(Role::Speed));
            let speed: Option<Vec<f64>> =
                speed.map(|v| v.into_iter().map(|x| x.max(0.0)).collect());
            if let Some(speed) = &speed {
                kept.speed.0 += speed.iter().sum::<f64>();
                kept.speed.1 += speed.len();
            }
            let runs = match (options.speed_window, &speed) {
                (Some(window), Some(speed)) => {
                    kept.speeds.extend_from_slice(speed);
                    segments::within_speeds(speed, step, window)
                }
                _ => std::iter::once(0..grid.count).collect(),
            };
            let runs = match segments::engaged(drive, &grid) {
                Some(engaged) => {
                    let runs = segments::within(runs, &engaged);
                    let samples: usize = runs.iter().map(Range::len).sum();
                    *kept.engaged.get_or_insert(0) += samples;
                    runs
                }
                None => runs,
            };
            for run in runs {
                for (role, samples) in &mut self.others {
                    let own = drive.channel(*role).map(|channel| match role {
                        Role::Brake | Role::SteeringCommand | Role::Input(_) => {
                            channel.interpolate(&grid)
                        }
                        _ => channel.samples_on(&grid),
                    });
                    samples.extend_from_slice(&own.unwrap_or_default()[run.clone()]);
                }
                self.push(&grid, run, input.as_deref(), &output, speed.as_deref());
            }
        }
        kept.warn_short(drive, step, &mut self.warnings);
        kept.check_moves(drive.channel(Role::Speed))
    }

    fn push(
        &mut self,
        grid: &Grid,
        run: Range<usize>,
        input: Option<&[f64]>,
        output: &[f64],
        speed: Option<&[f64]>,
    ) {
        let from = self.output.len();
        self.input.extend_from_slice(&input.unwrap_or_default()[run.clone()]);
        self.output.extend_from_slice(&output[run.clone()]);
        if let (Some(all), Some(speed)) = (&mut self.speed, speed) {
            all.extend_from_slice(&speed[run.clone()]);
        }
        let time0_s = grid.start + run.start as f64 * grid.step;
        self.segments.push(Segment { time0_s, range: from..self.output.len() });
    }
}

#[derive(Default)]
struct Kept {
    /// Samples of all spans, those too short included.
    samples: usize,
    spans: Vec<Span>,
    short: Vec<Span>,
    splits: Vec<Split>,
    /// Speeds before the speed window.
    speeds: Vec<f64>,
    /// Samples with the controller engaged.
    engaged: Option<usize>,
    /// Sum and number of one drive's speeds.
    speed: (f64, usize),
    /// Time in which the vehicle reverses, s, and the channel that reports it.
    reversing: Option<(f64, Box<Place>)>,
}

impl Kept {
    fn add_reversing(
        &mut self,
        drive: &Drive,
        runs: &[Span],
        warnings: &mut Vec<String>,
    ) -> Result<(), Error> {
        let (Some(first), Some(speed)) = (runs.first(), drive.channel(Role::Speed)) else {
            return Ok(());
        };
        for run in runs {
            segments::check_reversing(speed, *run)?;
        }
        let seconds: f64 = runs.iter().map(|(from, to)| to - from).sum();
        warnings.push(segments::reversing_in_words(&drive.name, seconds, first.0));
        let (all_s, _) = self.reversing.get_or_insert_with(|| (0.0, speed.place_at(first.0)));
        *all_s += seconds;
        Ok(())
    }

    /// Reports the parts of a drive that are too short.
    fn warn_short(&mut self, drive: &Drive, step: f64, warnings: &mut Vec<String>) {
        let short = std::mem::take(&mut self.short);
        let Some((from, to)) = short.first() else { return };
        warnings.push(format!(
            "{}: {} shorter than {:.1} s left out, the first from {:.2} s to {:.2} s",
            drive.name,
            counted(short.len(), "segment"),
            LEAST_SEGMENT as f64 * step,
            from,
            to
        ));
    }

    /// The mean speed of the samples in use is not that of a standstill: a vehicle at rest has no yaw
    /// dynamics, and a column that is 0 while the vehicle turns is dead, in another unit or another signal.
    fn check_moves(&mut self, channel: Option<&Series>) -> Result<(), Error> {
        let (sum, count) = std::mem::take(&mut self.speed);
        let mean_mps = sum / count.max(1) as f64;
        channel.filter(|_| count > 0).map_or(Ok(()), |channel| channel.check_moves(mean_mps))
    }

    /// Rejects a log of too few samples, and reports the effect of the speed window.
    fn check(mut self, log: &mut DriveLog, options: &LogOptions) -> Result<(), Error> {
        let step = log.sample_time_s;
        let used = log.output.len();
        if let Some((from, to)) = options.speed_window.filter(|_| !self.speeds.is_empty()) {
            let all = self.speeds.len();
            self.speeds.sort_by(f64::total_cmp);
            let at = |share: f64| self.speeds[(share * (all - 1) as f64).round() as usize];
            if used < LEAST_SAMPLES {
                return Err(Error::SpeedWindow {
                    from,
                    to,
                    kept_s: used as f64 * step,
                    shortest_s: LEAST_SEGMENT as f64 * step,
                    least: at(0.0),
                    most: at(1.0),
                    quartiles: (at(0.25), at(0.75)),
                });
            }
            log.warnings.push(format!(
                "speed window {from:.1} to {to:.1} m/s: {:.1} s of {:.1} s used, in {}",
                used as f64 * step,
                all as f64 * step,
                counted(log.segments.len(), "segment")
            ));
        }
        if let Some(engaged) = self.engaged {
            let (kept_s, shortest_s) = (engaged as f64 * step, LEAST_SEGMENT as f64 * step);
            if engaged < LEAST_SAMPLES {
                return Err(Error::NotEngaged { kept_s, shortest_s });
            }
            log.warnings.push(format!(
                "controller engaged, and not overridden, in {kept_s:.1} s of {:.1} s: only these are used",
                self.samples as f64 * step
            ));
        }
        if used >= LEAST_SAMPLES {
            return Ok(());
        }
        if let Some((reversing_s, at)) = self.reversing {
            let forward_s = self.samples as f64 * step;
            return Err(Error::Reversing { at, reversing_s, forward_s });
        }
        // Gaps that cause it are named.
        let (got, need, sample_time_s) = (self.samples, LEAST_SAMPLES, step);
        let gap = segments::refused_gap(&self.splits, &self.spans);
        Err(gap.unwrap_or(Error::TooFewSamples { got, need, sample_time_s }))
    }
}

/// Rejects a sample time that requires more samples than can be held.
fn check_size(plans: &[(&Drive, Clock, Vec<Span>)], step: f64) -> Result<(), Error> {
    let mut total = 0.0;
    for (_, clock, spans) in plans {
        let per_step = clock.per_step(step);
        let duration_s: f64 = spans.iter().map(|(a, b)| b - a).sum();
        total += per_step * (duration_s / step + 20.0);
        if total > MOST_SAMPLES as f64 {
            let sample_time_s = step / per_step;
            return Err(Error::TooManySamples { duration_s, sample_time_s, limit: MOST_SAMPLES });
        }
    }
    Ok(())
}
