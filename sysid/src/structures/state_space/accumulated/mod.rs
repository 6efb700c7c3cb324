//! Drives accumulated into a state of a few hundred kilobytes, however long and many they are, and
//! the plant identified from it (docs/methods/accumulate.md): the R factor of all windows of
//! 2·horizon samples with a column of ones ([`Accumulator`](crate::subspace::Accumulator) of kind
//! [`Decomposition::Qr`]), the same of every fourth block of samples as validation data, and the
//! sums of Welch's spectra of all samples.

mod evidence;
mod file;
mod in_windows;
mod prediction;
mod windows;

use crate::Error;
use crate::data::Signals;
use crate::data::moving_pieces::MovingPieces;
use crate::data::scaled::driving_input;
use crate::subspace::{Accumulator, Decomposition};
use crate::validation::response::spectra::Sums;
use std::collections::BTreeMap;
use steerwright_drivelog::{LogFile, LogOptions, Piece, Recording, StreamStart, open, stream};
use steerwright_formats::{ChannelSummary, InputKind, SourceFile};

/// Samples of a block, some seconds, so that validation windows come from all of a drive.
const BLOCK: usize = 500;
/// One block in so many is validation data.
const VALIDATION_PERIOD: usize = 4;

/// How drives are accumulated.
#[derive(Debug, Clone, PartialEq)]
pub struct AccumulateOptions {
    /// How each log is read. Time windows are not for reading in chunks.
    pub log: LogOptions,
    /// What drives the model.
    pub input_kind: InputKind,
    /// Block rows of past and of future, the most that can be identified with later.
    pub horizon: usize,
}

impl Default for AccumulateOptions {
    fn default() -> Self {
        Self { log: LogOptions::default(), input_kind: InputKind::Steering, horizon: 30 }
    }
}

/// Windows of drives, with the properties of the drives.
#[derive(Debug, Clone)]
pub struct Accumulated {
    name: String,
    input_kind: InputKind,
    steering_ratio: f64,
    horizon: usize,
    estimation: Accumulator,
    validation: Accumulator,
    spectra: Sums,
    /// Number of samples, mean, and sum of squares about it, of the speed where every drive has one.
    speed: Option<(f64, f64, f64)>,
    channels: Vec<ChannelSummary>,
    warnings: Vec<String>,
    sources: Vec<SourceFile>,
    options: BTreeMap<String, String>,
    version: String,
}

impl Accumulated {
    /// Accumulates one log, a file that brings steering and yaw rate.
    ///
    /// # Errors
    /// As [`read_drives`](steerwright_drivelog::read_drives); [`steerwright_drivelog::Error::NotADrive`] for a file that does not bring both
    /// channels, [`steerwright_drivelog::Error::ClockChanged`] where its rate changes, [`Error::Option`] for a horizon that
    /// is not within 2 to 200.
    pub fn of_log(file: LogFile<'_>, options: &AccumulateOptions) -> Result<Self, Error> {
        Self::of_recording(open(file, &options.log)?, options)
    }

    /// Accumulates one recording, such as columns in memory.
    ///
    /// # Errors
    /// As [`Self::of_log`].
    pub fn of_recording(
        recording: Box<dyn Recording + '_>,
        options: &AccumulateOptions,
    ) -> Result<Self, Error> {
        if !(2..=200).contains(&options.horizon) {
            return Err(Error::option("horizon", options.horizon, "2 to 200"));
        }
        let mut taking = Taking {
            horizon: options.horizon,
            input_kind: options.input_kind,
            states: None,
            taken: 0,
            speed: Some((0.0, 0.0, 0.0)),
        };
        let mut moving = MovingPieces::default();
        let all_is_used = options.log.speed_window.is_some();
        let mut step = 0.0;
        let mut read = stream(recording, &options.log, &mut |start: StreamStart, piece| {
            step = start.sample_time_s;
            if all_is_used {
                return taking.take(step, piece);
            }
            moving.take(start, piece, &mut |piece| taking.take(step, piece))
        })?;
        let slow = moving.end(&mut |piece| taking.take(step, piece))?;
        let Some(([estimation, validation], mut spectra)) = taking.states else {
            return Err(Error::too_few(0, 2 * options.horizon, 0.0));
        };
        spectra.end_segment();
        let mut used = options.log.to_map();
        used.insert("sample_time_used_s".into(), estimation.sample_time_s().to_string());
        if let Some((least_mps, warning)) = slow {
            used.insert("least_speed_mps".into(), least_mps.to_string());
            read.warnings.extend(warning);
        }
        Ok(Self {
            name: read.name,
            input_kind: options.input_kind,
            steering_ratio: read.steering_ratio,
            horizon: options.horizon,
            estimation,
            validation,
            spectra,
            speed: taking.speed.filter(|(count, _, _)| *count > 0.0),
            channels: read.channels,
            warnings: read.warnings,
            sources: vec![read.source],
            options: used,
            version: env!("CARGO_PKG_VERSION").into(),
        })
    }

    /// Adds what another has accumulated, and returns whether it did: where all logs of one are in the other,
    /// each counts once, and the larger stays.
    ///
    /// # Errors
    /// [`Error::Differ`] where the two were made by another version or with other options, and
    /// [`steerwright_drivelog::Error::RepeatedDrive`] where they share some of their logs: those cannot be removed
    /// from one.
    pub fn merge(&mut self, other: Self) -> Result<bool, Error> {
        self.check_same(&other)?;
        let has =
            |a: &Self, source: &SourceFile| a.sources.iter().any(|s| s.sha256 == source.sha256);
        if other.sources.iter().all(|source| has(self, source)) {
            return Ok(false);
        }
        if self.sources.iter().all(|source| has(&other, source)) {
            *self = other;
            return Ok(false);
        }
        if let Some(source) = other.sources.iter().find(|source| has(self, source)) {
            let mine = self.sources.iter().find(|s| s.sha256 == source.sha256).unwrap_or(source);
            let (first, second) = (mine.name.clone(), source.name.clone());
            return Err(steerwright_drivelog::Error::RepeatedDrive { first, second }.into());
        }
        self.estimation.merge(other.estimation)?;
        self.validation.merge(other.validation)?;
        self.spectra.merge(&other.spectra);
        self.speed = match (self.speed, other.speed) {
            (Some(a), Some(b)) => Some(together(a, b)),
            _ => None,
        };
        for channel in other.channels {
            let same = |c: &&mut ChannelSummary| {
                (&c.role, &c.column, &c.unit) == (&channel.role, &channel.column, &channel.unit)
                    && (c.rate_hz / channel.rate_hz - 1.0).abs() < 0.01
            };
            match self.channels.iter_mut().find(same) {
                Some(c) => {
                    let (n, more) = (c.rows as f64, channel.rows as f64);
                    c.mean = (c.mean * n + channel.mean * more) / (n + more);
                    c.rows += channel.rows;
                    (c.min, c.max) = (c.min.min(channel.min), c.max.max(channel.max));
                    c.resolution =
                        c.resolution.into_iter().chain(channel.resolution).reduce(f64::max);
                    c.spikes_s.extend(channel.spikes_s);
                    c.spikes_s.sort_by(f64::total_cmp);
                    c.frozen_s.extend(channel.frozen_s);
                    c.frozen_s.sort_by(|a, b| a[0].total_cmp(&b[0]));
                }
                None => self.channels.push(channel),
            }
        }
        for warning in other.warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        self.sources.extend(other.sources);
        Ok(true)
    }

    fn check_same(&self, other: &Self) -> Result<(), Error> {
        let differ = |problem: String| {
            let (first, second) = (self.name.clone(), other.name.clone());
            Err(Error::Differ { first, second, problem })
        };
        if self.version != other.version {
            return differ(format!("versions {} and {}", self.version, other.version));
        }
        if self.horizon != other.horizon {
            return differ(format!("horizons of {} and {}", self.horizon, other.horizon));
        }
        let (a, b) = (self.sample_time_s(), other.sample_time_s());
        if (a - b).abs() > 1e-9 * a {
            return differ(format!("sample times of {a} s and {b} s"));
        }
        let (a, b) = (self.steering_ratio, other.steering_ratio);
        if (a - b).abs() > 1e-9 * a {
            return differ(format!("steering ratios of {a} and {b}"));
        }
        if self.input_kind != other.input_kind {
            return differ("one is driven by steering, one by steering*speed".into());
        }
        // Columns and units may differ from logger to logger; what is done with them may not.
        for key in ["max_gap_s", "speed_window_mps"] {
            let of = |map: &BTreeMap<String, String>| {
                map.get(key).cloned().unwrap_or_else(|| "nothing".into())
            };
            if of(&self.options) != of(&other.options) {
                let (a, b) = (of(&self.options), of(&other.options));
                return differ(format!("{key} is {a} and {b}"));
            }
        }
        Ok(())
    }

    /// Sample time T, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.estimation.sample_time_s()
    }

    /// Numbers of estimation and of validation samples.
    #[must_use]
    pub fn samples(&self) -> (usize, usize) {
        (self.estimation.samples(), self.validation.samples())
    }

    /// The channels that were read.
    #[must_use]
    pub fn channels(&self) -> &[ChannelSummary] {
        &self.channels
    }

    /// The name of the first log.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Warnings of the readers, each once.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Mean of the speed and its standard deviation, m/s.
    fn speed(&self) -> Option<(f64, f64)> {
        self.speed.map(|(count, mean, squares)| (mean, (squares / count).sqrt()))
    }
}

/// (count, mean, squares about it) of two sets together (Chan, Golub and LeVeque 1983).
fn together(a: (f64, f64, f64), b: (f64, f64, f64)) -> (f64, f64, f64) {
    let count = a.0 + b.0;
    if count == 0.0 {
        return a;
    }
    let apart = b.1 - a.1;
    (count, a.1 + apart * b.0 / count, a.2 + b.2 + apart * apart * a.0 * b.0 / count)
}

struct Taking {
    horizon: usize,
    input_kind: InputKind,
    states: Option<([Accumulator; 2], Sums)>,
    /// Samples so far, which determine whose block it is.
    taken: usize,
    speed: Option<(f64, f64, f64)>,
}

impl Taking {
    fn take(&mut self, sample_time_s: f64, piece: Piece<'_>) -> Result<(), Error> {
        if self.states.is_none() {
            let new = || Accumulator::new(Decomposition::Qr, self.horizon, (1, 1), sample_time_s);
            self.states = Some(([new()?, new()?], Sums::of_sample_time(sample_time_s)));
        }
        let Some((states, spectra)) = &mut self.states else { return Ok(()) };
        let Piece::Samples { steering, yaw_rate, speed } = piece else {
            states.iter_mut().for_each(Accumulator::end_segment);
            spectra.end_segment();
            return Ok(());
        };
        self.speed = match (self.speed, speed) {
            (Some(all), Some(speed)) => {
                let mean = steerwright_drivelog::signal::mean(speed);
                let squares = speed.iter().map(|v| (v - mean).powi(2)).sum();
                Some(together(all, (speed.len() as f64, mean, squares)))
            }
            _ => None,
        };
        let input = driving_input(steering, speed, self.input_kind)?;
        spectra.push(&input, yaw_rate);
        let input = Signals::from(input);
        let output = Signals::from(yaw_rate.to_vec());
        let mut from = 0;
        while from < output.ncols() {
            let (block, within) = (self.taken / BLOCK, self.taken % BLOCK);
            let to = output.ncols().min(from + BLOCK - within);
            let state =
                &mut states[usize::from(block % VALIDATION_PERIOD == VALIDATION_PERIOD - 1)];
            state.push(input.columns(from..to), output.columns(from..to))?;
            self.taken += to - from;
            if self.taken.is_multiple_of(BLOCK) {
                state.end_segment();
            }
            from = to;
        }
        Ok(())
    }
}
