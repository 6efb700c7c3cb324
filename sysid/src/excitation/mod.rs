//! The manoeuvre that identifies a bicycle best: by the information matrix of the structure, within limits.
//!
//! ```text
//! model, limits, time ─▶ tones of a block ─▶ amplitudes (convex) ─▶ shape (amplitudes and phases within the peaks) ─▶ manoeuvre
//!                        signals of a driver ─▶ best selection of each kind ─────────────────────────────────────────▶ alternatives
//! ```
//!
//! The yaw rate of the structure has the sensitivities J by its parameters, of which the information is `M = JᵀJ/s² + M₀` with
//! the long-run variance s² of the errors and the information M₀ of the priors, as the identification has them. The standard
//! errors of the goal (the gain and the phase of the response, the understeer gradient, or the friction) follow by the delta
//! method; the largest is minimised, and with it the generalised variance of the parameters.
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
//! | `schedule` | the blocks of a recording |
//! | `tyre_limit` | the growing manoeuvres that reach the limit of grip, by the single-track model |
//! | `expected` | the standard errors of a manoeuvre |

mod amplitudes;
mod criterion;
mod driver;
mod expected;
mod limits;
mod motion;
mod options;
mod schedule;
mod shape;
mod tyre_limit;

use crate::Error;
use crate::structures::bicycle::information::BicycleInformation;
use amplitudes::Tones;
use criterion::{Criterion, Square};
use driver::DriverSignal;
use expected::{Driven, Expected};
use limits::{Mover, limit_values};
pub use options::ExcitationOptions;
use options::within_rate;
use schedule::{Scaled, Subject, best_of, best_selection, of_selection};
use shape::{Block, Shape, TonesOfBlock};
use steerwright_formats::{
    Bicycle, ExpectedErrors, Manoeuvre, ManoeuvreGoal, ManoeuvreKind, SteeringSignal,
    VehicleDirection,
};
pub use tyre_limit::excite_vehicle;

/// Time in which a multisine fades in and out, s.
const TAPER_S: f64 = 1.5;
/// Shortest sample time of the design, s.
const DESIGN_S: f64 = 0.02;
/// Tones beyond the band in which the response is to be known, as factors on its ends.
const BEYOND: [f64; 2] = [0.5, 2.5];

/// A bicycle at the speeds of a design.
struct Design<'a> {
    bicycle: &'a Bicycle,
    options: &'a ExcitationOptions,
    information: BicycleInformation,
    criterion: Criterion,
    /// M₀ of the parameters of the dynamics.
    prior: Square,
}

/// The manoeuvre that identifies a bicycle best within the options. The goal `tyre-limit` has the tyres beyond their cornering
/// stiffness from the priors of the single-track model; [`excite_vehicle`] has those of a vehicle.
///
/// # Errors
/// [`Error::Option`] for values out of range; [`Error::Unstable`] where the vehicle is unstable at a speed.
pub fn excite(bicycle: &Bicycle, options: &ExcitationOptions) -> Result<Manoeuvre, Error> {
    options.check()?;
    let options = &within_rate(bicycle, options);
    if options.goal == ManoeuvreGoal::TyreLimit {
        return tyre_limit::excite_with_usual_tyres(bicycle, options);
    }
    let design = Design::new(bicycle, options)?;
    let multisine = design.multisine()?;
    let mut all = vec![multisine];
    for kind in [ManoeuvreKind::Sweep, ManoeuvreKind::Slalom, ManoeuvreKind::Steps] {
        all.push(design.of_driver(kind)?);
    }
    best_of(&all, |kind| (kind != ManoeuvreKind::Multisine) == options.by_driver)
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
            if options.goal == ManoeuvreGoal::Response {
                for hz in options.frequencies_hz() {
                    gradients.extend(information.response_gradients(*speed, hz));
                }
            }
        }
        if options.goal == ManoeuvreGoal::Understeer {
            // The offsets do not change it.
            gradients.push(information.understeer_gradient()[..size].to_vec());
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
            signals.push(scaled.signal(*speed, Some(ends), None));
        }
        // Each half has all speeds, since one estimates; signals of a speed alternate in their side.
        let repeats = options.repeats();
        let mut order = Vec::new();
        for half in 0..2 {
            for number in 0..signals.len() {
                for repeat in 0..repeats {
                    order.push((number, (half * repeats + repeat) % 2 == 1));
                }
            }
        }
        let mut manoeuvre = self.manoeuvre(ManoeuvreKind::Multisine, signals, order)?;
        // The convex problem has no products of different tones. Those of neighbours at low frequency, by which the window joins
        // them, inform about the understeer gradient, which may then be known better.
        if options.goal == ManoeuvreGoal::Response {
            manoeuvre.expected.bound = Some(amplitudes.bound.max(0.0).sqrt());
            manoeuvre.expected.gap =
                Some((amplitudes.largest - amplitudes.bound).max(0.0) / amplitudes.largest);
        }
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
        let best = best_selection(&information, repeats, &self.prior, &self.criterion);
        // Both halves have the same signals, the second to the other side.
        let (signals, order) =
            of_selection(&best, &candidates, &options.speeds_mps, &scaled, repeats, |_, half| {
                half == 1
            });
        self.manoeuvre(kind, signals, order)
    }

    fn manoeuvre(
        &self,
        kind: ManoeuvreKind,
        signals: Vec<SteeringSignal>,
        order: Vec<(usize, bool)>,
    ) -> Result<Manoeuvre, Error> {
        let vehicle = &self.bicycle.vehicle;
        let subject = Subject {
            name: &vehicle.name,
            steering_ratio: vehicle.steering_ratio,
            quality: &self.bicycle.quality,
        };
        let mut manoeuvre = subject.manoeuvre(self.options, kind, signals, order);
        manoeuvre.expected = self.expected(&manoeuvre)?;
        Ok(manoeuvre)
    }

    /// The standard errors by the blocks of the first half at each speed.
    fn expected(&self, manoeuvre: &Manoeuvre) -> Result<ExpectedErrors, Error> {
        let options = self.options;
        let count = manoeuvre.block_samples();
        let mut driven = Driven::new(&self.information);
        for block in manoeuvre.estimation_blocks() {
            let speed = manoeuvre.signals[block.signal].speed_mps;
            let signal: Vec<f64> = (0..count).map(|i| manoeuvre.steering_rad(block, i)).collect();
            let rows = self
                .sensitivities(&signal, speed, options.sample_time_s)
                .ok_or(Error::Numerical { what: "sensitivities of the design" })?;
            driven.add(&rows)?;
        }
        let expected = Expected {
            information: &self.information,
            driven: &driven,
            speeds_mps: &options.speeds_mps,
            frequencies_hz: &options.frequencies_hz(),
            goal: options.goal,
        };
        expected.errors(options.max_error, manoeuvre.time_s(), manoeuvre.steering_ratio)
    }
}

fn check_stable(bicycle: &Bicycle, speed_mps: f64) -> Result<(), Error> {
    let [a, b, c, d] = bicycle.vehicle.coefficients().lateral(speed_mps);
    // Both coefficients of the characteristic polynomial of (v_y, r) are positive.
    if a + d < 0.0 && a * d - b * c > 0.0 { Ok(()) } else { Err(Error::Unstable { speed_mps }) }
}
