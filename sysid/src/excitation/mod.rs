//! The manoeuvre that identifies a bicycle best: by the information matrix of the structure, within limits.
//!
//! ```text
//! model, limits, time ─▶ tones of a block ─▶ amplitudes (convex) ─▶ shape (amplitudes and phases within the peaks) ─▶ manoeuvre
//!                        signals of a driver ─▶ best selection of each kind ─────────────────────────────────────────▶ alternatives
//! ```
//!
//! The yaw rate of the structure has the sensitivities J by its parameters, of which the information is `M = JᵀJ/s² + M₀` with
//! the long-run variance s² of the errors and the information M₀ of the priors, as the identification has them. The standard
//! errors of the gain and of the phase of the response follow by the delta method; the largest in the band is minimised, and with
//! it the generalised variance of the parameters.
//!
//! A manoeuvre is made of blocks at steady speeds, of which each begins and ends straight on one line. The first half of the
//! recording estimates, the second validates, and both have the same signals. The design is locally optimal: at the parameters of the model.
//!
//! | module | content |
//! |---|---|
//! | `criterion` | the largest variance |
//! | `motion`, `limits` | what the vehicle does, and how much of the limits that uses |
//! | `amplitudes` | the convex problem |
//! | `shape` | amplitudes and phases within the peaks |
//! | `driver` | slalom, sweep, steps |
//! | `expected` | the standard errors of a manoeuvre |

mod amplitudes;
mod criterion;
mod driver;
mod expected;
mod limits;
mod motion;
mod shape;

use crate::Error;
use crate::structures::bicycle::information::BicycleInformation;
use amplitudes::Tones;
use criterion::{Criterion, Square};
use driver::{DriverSignal, selections};
use expected::{Driven, Expected};
use limits::{Mover, Peaks, limit_values};
use shape::{Block, Shape, TonesOfBlock};
use steerwright_formats::{
    Alternative, Bicycle, Document, ExpectedErrors, Manoeuvre, ManoeuvreBlock, ManoeuvreKind,
    ManoeuvreLimits, ManoeuvrePurpose, Provenance, SignalPeaks, SteeringSignal, VehicleDirection,
};

/// Share of a recording that estimates by default.
const ESTIMATION_SHARE: f64 = 0.5;
/// Straight driving after the signal of a block, s.
const REST_S: f64 = 2.0;
/// Shortest block, s.
const SHORTEST_BLOCK_S: f64 = 8.0;
/// Time in which a multisine fades in and out, s.
const TAPER_S: f64 = 1.5;
/// Shortest sample time of the design, s.
const DESIGN_S: f64 = 0.02;
/// Tones beyond the band in which the response is to be known, as factors on its ends.
const BEYOND: [f64; 2] = [0.5, 2.5];
/// Frequencies of a band at which the response is to be known.
const FREQUENCIES: usize = 9;
/// Most blocks of a half whose signals a driver's manoeuvre selects one by one.
const MOST_SELECTED: usize = 4;

/// What is to be designed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationOptions {
    /// Speeds, m/s.
    pub speeds_mps: Vec<f64>,
    /// Time of the recording, s.
    pub time_s: f64,
    /// Length of a block, s.
    pub block_s: f64,
    /// Band in which the response is to be known, Hz.
    pub band_hz: [f64; 2],
    /// Two standard errors of the response that are to be reached.
    pub max_error: Option<f64>,
    /// Limits.
    pub limits: ManoeuvreLimits,
    /// Spectral density of the errors of the yaw rate, (rad/s)²/Hz, two-sided: a variance times its sample time and, where the
    /// errors last, over the long run.
    pub noise_density: f64,
    /// Time from one sample of the signals to the next, s.
    pub sample_time_s: f64,
    /// Whether a driver steers, to a metronome, instead of a robot.
    pub by_driver: bool,
    /// Standard deviation of each axle's cornering stiffness, relative, of a model that states no uncertainty; the limits leave
    /// room for it.
    pub assumed_uncertainty: f64,
}

impl Default for ExcitationOptions {
    /// 0.2 to 2 Hz, two minutes at 15 m/s and 3 m/s², and a gyro of 0.1 °/s at 100 Hz.
    fn default() -> Self {
        Self {
            speeds_mps: vec![15.0],
            time_s: 120.0,
            block_s: 20.0,
            band_hz: [0.2, 2.0],
            max_error: None,
            limits: ManoeuvreLimits {
                max_lateral_acceleration_mps2: 3.0,
                max_angle_rad: None,
                max_rate_radps: None,
                max_offset_m: None,
            },
            noise_density: 0.1_f64.to_radians().powi(2) * 0.01,
            sample_time_s: 0.01,
            by_driver: false,
            assumed_uncertainty: 0.1,
        }
    }
}

impl ExcitationOptions {
    fn check(&self) -> Result<(), Error> {
        let within = |option, value: f64, [low, high]: [f64; 2], unit: &str| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                let expected = format!("{low} to {high}{unit}");
                Err(Error::option(option, format!("{value}{unit}"), expected))
            }
        };
        if self.speeds_mps.is_empty() || self.speeds_mps.len() > 5 {
            let got = self.speeds_mps.len();
            return Err(Error::option("number of speeds", got, "1 to 5"));
        }
        for speed in &self.speeds_mps {
            within("speed", *speed, [1.0, 100.0], " m/s")?;
        }
        within("block", self.block_s, [SHORTEST_BLOCK_S, 60.0], " s")?;
        let least = 2.0 * self.block_s * self.speeds_mps.len() as f64;
        within("time", self.time_s, [least, 3600.0], " s")?;
        let [low, high] = self.band_hz;
        let least_hz = 2.0 / (self.block_s - REST_S);
        within("lower end of the band", low, [least_hz, 5.0], " Hz")?;
        within("upper end of the band", high, [1.2 * low, 5.0], " Hz")?;
        within("sample time", self.sample_time_s, [0.001, 0.1 / high], " s")?;
        if let Some(error) = self.max_error {
            within("response error", 100.0 * error, [0.1, 100.0], " %")?;
        }
        let limits = &self.limits;
        within("lateral acceleration", limits.max_lateral_acceleration_mps2, [0.1, 50.0], " m/s²")?;
        let positive = [
            ("steering angle", limits.max_angle_rad, " rad"),
            ("steering rate", limits.max_rate_radps, " rad/s"),
            ("lateral offset", limits.max_offset_m, " m"),
        ];
        for (option, limit, unit) in positive {
            within(option, limit.unwrap_or(1.0), [1e-3, 1e3], unit)?;
        }
        within("uncertainty", 100.0 * self.assumed_uncertainty, [0.0, 50.0], " %")?;
        within("noise density", self.noise_density.sqrt(), [1e-9, 1.0], " (rad/s)/√Hz")
    }

    /// Signal without the straight driving after it, s.
    fn signal_s(&self) -> f64 {
        self.block_s - REST_S
    }

    /// Blocks of each half at each speed.
    fn repeats(&self) -> usize {
        let blocks = (self.time_s / self.block_s + 1e-9).floor() as usize;
        (blocks / (2 * self.speeds_mps.len())).max(1)
    }

    fn frequencies_hz(&self) -> Vec<f64> {
        let [low, high] = self.band_hz;
        let at = |i: usize| low * (high / low).powf(i as f64 / (FREQUENCIES - 1) as f64);
        (0..FREQUENCIES).map(at).collect()
    }
}

/// A bicycle at the speeds of a design.
struct Design<'a> {
    bicycle: &'a Bicycle,
    options: &'a ExcitationOptions,
    information: BicycleInformation,
    criterion: Criterion,
    /// M₀ of the parameters of the dynamics.
    prior: Square,
}

/// The manoeuvre that identifies a bicycle best within the options.
///
/// # Errors
/// [`Error::Option`] for values out of range; [`Error::Unstable`] where the vehicle is unstable at a speed.
pub fn excite(bicycle: &Bicycle, options: &ExcitationOptions) -> Result<Manoeuvre, Error> {
    options.check()?;
    let design = Design::new(bicycle, options)?;
    let multisine = design.multisine()?;
    let mut all = vec![multisine];
    for kind in [ManoeuvreKind::Sweep, ManoeuvreKind::Slalom, ManoeuvreKind::Steps] {
        all.push(design.of_driver(kind)?);
    }
    let alternatives =
        all.iter().map(|m| Alternative { kind: m.kind, largest_error: m.expected.largest_error });
    let alternatives = alternatives.collect();
    let is_wanted = |m: &&Manoeuvre| (m.kind != ManoeuvreKind::Multisine) == options.by_driver;
    let error = |m: &Manoeuvre| m.expected.largest_error;
    let best = all.iter().filter(is_wanted).min_by(|a, b| error(a).total_cmp(&error(b)));
    let Some(best) = best else {
        return Err(Error::Numerical { what: "the design of the manoeuvre" });
    };
    Ok(Manoeuvre { alternatives, ..best.clone() })
}

/// A signal with the samples to steer and what it uses of the limits.
struct Scaled {
    steering_rad: Vec<f64>,
    peaks: Peaks,
}

impl<'a> Design<'a> {
    fn new(bicycle: &'a Bicycle, options: &'a ExcitationOptions) -> Result<Self, Error> {
        let information = BicycleInformation::new(&bicycle.vehicle);
        let size = information.len();
        let mut prior = vec![0.0; size * size];
        for (i, own) in information.prior().into_iter().take(size).enumerate() {
            prior[i * size + i] = own;
        }
        let mut gradients = Vec::new();
        for speed in &options.speeds_mps {
            check_stable(bicycle, *speed)?;
            for hz in options.frequencies_hz() {
                gradients.extend(information.response_gradients(*speed, hz));
            }
        }
        Ok(Self { bicycle, options, information, criterion: Criterion { size, gradients }, prior })
    }

    fn mover(&self, speed_mps: f64, sample_time_s: f64) -> Mover {
        let stated = self.bicycle.evidence.as_ref().map_or(&[][..], |e| &e.directions);
        let assumed = [
            VehicleDirection {
                cornering_stiffness_front: self.options.assumed_uncertainty,
                ..VehicleDirection::default()
            },
            VehicleDirection {
                cornering_stiffness_rear: self.options.assumed_uncertainty,
                ..VehicleDirection::default()
            },
        ];
        let directions = if stated.is_empty() { &assumed } else { stated };
        Mover::new(&self.bicycle.vehicle, directions, speed_mps, sample_time_s)
    }

    /// Sensitivities of the yaw rate over the noise, of a signal with some sample time.
    fn sensitivities(&self, signal: &[f64], speed_mps: f64, step_s: f64) -> Option<Vec<Vec<f64>>> {
        let ratio = self.bicycle.vehicle.steering_ratio;
        let road_wheel: Vec<f64> = signal.iter().map(|u| u / ratio).collect();
        let mut rows = self.information.sensitivities(&road_wheel, speed_mps, step_s)?;
        let weight = (step_s / self.options.noise_density).sqrt();
        rows.iter_mut().flatten().for_each(|x| *x *= weight);
        Some(rows)
    }

    /// A signal of any amplitude at full use of the limits.
    fn scaled(&self, signal: &[f64], speed_mps: f64) -> Scaled {
        let mover = self.mover(speed_mps, self.options.sample_time_s);
        let factor = mover.factor(signal, &self.options.limits);
        let steering_rad: Vec<f64> = signal.iter().map(|u| factor * u).collect();
        let peaks = mover.peaks(&steering_rad);
        Scaled { steering_rad, peaks }
    }

    fn multisine(&self) -> Result<Manoeuvre, Error> {
        let options = self.options;
        let beyond = [BEYOND[0] * options.band_hz[0], BEYOND[1] * options.band_hz[1]];
        let tones = TonesOfBlock::new(options.signal_s(), TAPER_S, beyond);
        let size = self.criterion.size;
        let step_s = options.sample_time_s.max(DESIGN_S);
        let limited =
            limit_values(&options.limits).iter().filter(|limit| limit.is_finite()).count();
        // A signal within the limits with their uncertainty is scaled to them in the end.
        let mut blocks = Vec::new();
        for speed in &options.speeds_mps {
            let block = Block::new(
                &tones,
                &self.mover(*speed, step_s),
                &options.limits,
                step_s,
                options.repeats() as f64,
                size,
                |signal| self.sensitivities(signal, *speed, step_s),
            );
            blocks.push(block.ok_or(Error::Numerical { what: "sensitivities of the design" })?);
        }
        let count = tones.frequencies_hz.len();
        let mut information = Vec::new();
        let mut shares = vec![vec![0.0; count * blocks.len()]; limited * blocks.len()];
        for (b, block) in blocks.iter().enumerate() {
            for tone in 0..count {
                information.push(block.of_tone(tone, size));
                for (j, share) in block.shares_of_tone(tone, limited).into_iter().enumerate() {
                    shares[b * limited + j][b * count + tone] = share;
                }
            }
        }
        let problem = Tones { criterion: &self.criterion, prior: &self.prior, information, shares };
        let singular = Error::Numerical { what: "the amplitudes of the tones" };
        let amplitudes = problem.optimise().ok_or(singular)?;
        let power: Vec<Vec<f64>> = amplitudes.power.chunks(count).map(<[f64]>::to_vec).collect();
        let shape = Shape { criterion: &self.criterion, prior: &self.prior, blocks: &blocks };
        let coefficients = shape.optimise(&power);
        let mut signals = Vec::new();
        for (speed, own) in options.speeds_mps.iter().zip(coefficients.chunks(2 * count)) {
            let scaled = self.scaled(&tones.signal(own, options.sample_time_s), *speed);
            let ends = [tones.frequencies_hz[0], tones.frequencies_hz[count - 1]];
            signals.push(signal(*speed, Some(ends), None, scaled));
        }
        // Signals of a speed alternate in their side.
        let mut order = Vec::new();
        for number in 0..signals.len() {
            for repeat in 0..2 * options.repeats() {
                order.push((number, repeat % 2 == 1));
            }
        }
        let mut manoeuvre = self.manoeuvre(ManoeuvreKind::Multisine, signals, order)?;
        manoeuvre.expected.bound = Some(amplitudes.bound.max(0.0).sqrt());
        manoeuvre.expected.gap =
            Some((amplitudes.largest - amplitudes.bound).max(0.0) / amplitudes.largest);
        Ok(manoeuvre)
    }

    /// The best selection of signals of a kind, the same at each speed.
    fn of_driver(&self, kind: ManoeuvreKind) -> Result<Manoeuvre, Error> {
        let options = self.options;
        let candidates = DriverSignal::of_kind(kind);
        let length = options.signal_s();
        let size = self.criterion.size;
        let mut information: Vec<Square> = Vec::new();
        let mut scaled = Vec::new();
        for candidate in &candidates {
            let mut sum = vec![0.0; size * size];
            let signal = candidate.signal(length, options.sample_time_s);
            for speed in &options.speeds_mps {
                let own = self.scaled(&signal, *speed);
                let rows = self
                    .sensitivities(&own.steering_rad, *speed, options.sample_time_s)
                    .ok_or(Error::Numerical { what: "sensitivities of the design" })?;
                for row in &rows {
                    for i in 0..size {
                        for j in 0..size {
                            sum[i * size + j] += row[i] * row[j];
                        }
                    }
                }
                scaled.push(own);
            }
            information.push(sum);
        }
        let repeats = options.repeats();
        let selected = repeats.min(MOST_SELECTED);
        let cost = |selection: &Vec<usize>| {
            let weight = repeats as f64 / selected as f64;
            let mut sum = self.prior.clone();
            for k in selection {
                for (s, m) in sum.iter_mut().zip(&information[*k]) {
                    *s += weight * m;
                }
            }
            self.criterion.cost(&sum)
        };
        let all = selections(candidates.len(), selected);
        let best = all.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let best = best.unwrap_or_default();
        let mut used = best.clone();
        used.dedup();
        let mut signals = Vec::new();
        let mut order = Vec::new();
        let speeds = options.speeds_mps.len();
        for (at, speed) in options.speeds_mps.iter().enumerate() {
            let first = signals.len();
            for k in &used {
                let own = &scaled[k * speeds + at];
                let own = Scaled { steering_rad: own.steering_rad.clone(), peaks: own.peaks };
                signals.push(signal(
                    *speed,
                    candidates[*k].frequency_hz(),
                    candidates[*k].hold_s(),
                    own,
                ));
            }
            // Both halves have the same signals, the second to the other side.
            for half in 0..2 {
                for repeat in 0..repeats {
                    let k = best.get(repeat % selected.max(1)).copied().unwrap_or(0);
                    let place = used.iter().position(|other| *other == k).unwrap_or(0);
                    order.push((first + place, half == 1));
                }
            }
        }
        self.manoeuvre(kind, signals, order)
    }

    fn manoeuvre(
        &self,
        kind: ManoeuvreKind,
        signals: Vec<SteeringSignal>,
        order: Vec<(usize, bool)>,
    ) -> Result<Manoeuvre, Error> {
        let options = self.options;
        let schedule: Vec<ManoeuvreBlock> = order
            .iter()
            .enumerate()
            .map(|(k, (signal, mirrored))| ManoeuvreBlock {
                start_s: k as f64 * options.block_s,
                signal: *signal,
                mirrored: *mirrored,
            })
            .collect();
        let mut manoeuvre = Manoeuvre {
            schema: Manoeuvre::SCHEMA.into(),
            name: self.bicycle.vehicle.name.clone(),
            kind,
            purpose: ManoeuvrePurpose { band_hz: options.band_hz, max_error: options.max_error },
            limits: options.limits,
            noise_density: options.noise_density,
            estimation_share: ESTIMATION_SHARE,
            steering_ratio: self.bicycle.vehicle.steering_ratio,
            sample_time_s: options.sample_time_s,
            block_s: options.block_s,
            schedule,
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
            quality: self.bicycle.quality.clone(),
            provenance: Provenance {
                version: env!("CARGO_PKG_VERSION").into(),
                ..Provenance::default()
            },
        };
        manoeuvre.expected = self.expected(&manoeuvre)?;
        Ok(manoeuvre)
    }

    /// The standard errors by the blocks of the first half at each speed.
    fn expected(&self, manoeuvre: &Manoeuvre) -> Result<ExpectedErrors, Error> {
        let options = self.options;
        let count = manoeuvre.block_samples();
        let mut driven = Driven::new(&self.information);
        for (k, speed) in options.speeds_mps.iter().enumerate() {
            let first = 2 * k * options.repeats();
            for block in &manoeuvre.schedule[first..first + options.repeats()] {
                let signal: Vec<f64> =
                    (0..count).map(|i| manoeuvre.steering_rad(block, i)).collect();
                let rows = self
                    .sensitivities(&signal, *speed, options.sample_time_s)
                    .ok_or(Error::Numerical { what: "sensitivities of the design" })?;
                driven.add(&rows)?;
            }
        }
        let expected = Expected {
            information: &self.information,
            driven: &driven,
            speeds_mps: &options.speeds_mps,
            frequencies_hz: &options.frequencies_hz(),
        };
        expected.errors(options.max_error, manoeuvre.time_s(), manoeuvre.steering_ratio)
    }
}

fn signal(
    speed_mps: f64,
    frequency_hz: Option<[f64; 2]>,
    hold_s: Option<f64>,
    scaled: Scaled,
) -> SteeringSignal {
    let Peaks { nominal, upper, end_offset_m } = scaled.peaks;
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
        steering_rad: scaled.steering_rad,
    }
}

fn check_stable(bicycle: &Bicycle, speed_mps: f64) -> Result<(), Error> {
    let [a, b, c, d] = bicycle.vehicle.coefficients().lateral(speed_mps);
    // Both coefficients of the characteristic polynomial of (v_y, r) are positive.
    if a + d < 0.0 && a * d - b * c > 0.0 { Ok(()) } else { Err(Error::Unstable { speed_mps }) }
}
