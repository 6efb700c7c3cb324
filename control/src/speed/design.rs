//! Gains by rule, by search where the rule misses a requirement, and the document with its evidence.
//!
//! From the demanded acceleration to the speed the vehicle is an integrator with the delay θ = d + τ + T/2. The rule is
//! SIMC (Skogestad 2003): kp = 1/(τc + θ) and ki = kp/(4·(τc + θ)), with the closed-loop time τc = θ. The reference model
//! approaches with a rate of 8 over the settling time.

use crate::Error;
use crate::design::parallel::each;
use crate::speed::ensemble::draw;
use crate::speed::limits;
use crate::speed::options::{REQUIREMENTS, SpeedDesignOptions, required};
use crate::speed::quality::quality;
use crate::speed::simulate::{reached, responses};
use std::collections::BTreeMap;
use std::sync::Arc;
use steerwright_formats::{
    Document, Longitudinal, Provenance, Quality, Requirement, Shortfall, SourceFile,
    SpeedController, SpeedEnsemble, SpeedEvidence, SpeedGains, SpeedLimits, SpeedResponses,
};

/// Speeds of the range at which responses are computed.
const SPEEDS: u32 = 5;
/// Vehicles that the gains are searched on, besides the nominal one; those of the evidence are others.
const SEARCHED_ON: usize = 8;
/// Closed-loop times over the delay, and rates of the reference model times the settling time; the rule first.
const CLOSED_LOOP: [f64; 5] = [1.0, 0.7, 1.4, 2.0, 0.5];
const RATES: [f64; 5] = [8.0, 6.0, 11.0, 16.0, 5.0];
/// Settling time of the rates where none is required, s.
const USUAL_SETTLING: f64 = 4.0;
/// Least hysteresis of the pedals, m/s², and its multiple of the noise that the controller passes on.
const LEAST_HYSTERESIS: f64 = 0.1;
const NOISE_HYSTERESIS: f64 = 4.0;
/// Speed below which the vehicle is held, m/s, and the deceleration of the held brake, m/s².
const HOLD_SPEED: f64 = 0.3;
const HOLD_DECELERATION: f64 = 2.0;

/// Designs a speed controller on a longitudinal model. `source` names the model's file.
///
/// Requirements that cannot be met are no error: the best controller is returned with its shortfalls, with advice, and with
/// the quality `fail`.
///
/// # Errors
/// [`Error::Option`] for options, [`Error::Model`] for a model without a positive gain.
pub fn design_speed(
    model: &Longitudinal,
    source: &SourceFile,
    options: &SpeedDesignOptions,
) -> Result<SpeedController, Error> {
    options.check()?;
    let specification = options.specification(model)?;
    let is_weak = |speed: f64| model.gain_in(0, speed) <= 0.0;
    if let Some(speed) = specification.speeds_mps.into_iter().find(|speed| is_weak(*speed)) {
        return Err(Error::Model {
            model: model.name.clone(),
            problem: format!("the gain of the drive at {speed:.1} m/s is not positive"),
        });
    }
    let mut controller = SpeedController {
        schema: SpeedController::SCHEMA.into(),
        name: format!("speed of {}", model.name),
        sample_time_s: options.sample_time_s,
        gains: gains(model, options, CLOSED_LOOP[0], RATES[0]),
        limits: SpeedLimits {
            max_acceleration_mps2: options.max_acceleration_mps2,
            max_deceleration_mps2: options.max_deceleration_mps2,
            max_jerk_mps3: options.max_jerk_mps3,
            pedal_hysteresis_mps2: LEAST_HYSTERESIS,
            hold_speed_mps: HOLD_SPEED,
            hold_deceleration_mps2: HOLD_DECELERATION,
        },
        specification,
        evidence: SpeedEvidence::default(),
        quality: Quality::default(),
        model: model.clone(),
        provenance: provenance(source, options),
    };
    let inverted = Arc::new(model.clone());
    let mut vehicles = vec![Arc::clone(&inverted)];
    if options.members > 0 {
        vehicles.extend(draw(model, options.seed, 0, SEARCHED_ON).into_iter().map(Arc::new));
    }
    search(&mut controller, options, &inverted, &vehicles)?;

    controller.evidence.speeds = at_speeds(&controller, &inverted, &inverted)?;
    for requirement in REQUIREMENTS {
        let Some(bound) = required(requirement, &controller.specification) else { continue };
        let value = reached(requirement, &controller.evidence.speeds, &controller.specification);
        if !requirement.is_met(bound, value) {
            controller.evidence.shortfalls.push(Shortfall {
                requirement: requirement.name().into(),
                required: bound,
                reached: value,
            });
        }
    }
    controller.evidence.met = controller.evidence.shortfalls.is_empty();
    if options.members > 0 {
        controller.evidence.ensemble = Some(ensemble(&controller, &inverted, options)?);
    }
    controller.evidence.advice = limits::advice(&controller);
    controller.quality = quality(&controller);
    controller.checked("the designed controller")?;
    Ok(controller)
}

/// The gains of a closed-loop time, over the delay, and of a rate of the reference model, times the settling time.
fn gains(
    model: &Longitudinal,
    options: &SpeedDesignOptions,
    closed_loop: f64,
    rate: f64,
) -> SpeedGains {
    let delay = model.delay_s.value + model.time_constant_s.value + 0.5 * options.sample_time_s;
    let kp = 1.0 / (delay * (1.0 + closed_loop));
    SpeedGains {
        kp_per_s: significant(kp),
        ki_per_s2: significant(0.25 * kp * kp),
        reference_rate_per_s: significant(rate / options.settling_time_s.unwrap_or(USUAL_SETTLING)),
    }
}

/// A number with four digits, as it is written.
fn significant(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The first gains of the list that all vehicles keep the requirements with; otherwise those that miss them by least.
fn search(
    controller: &mut SpeedController,
    options: &SpeedDesignOptions,
    inverted: &Arc<Longitudinal>,
    vehicles: &[Arc<Longitudinal>],
) -> Result<(), Error> {
    let (mut best, mut least) = (controller.clone(), f64::INFINITY);
    for closed_loop in CLOSED_LOOP {
        for rate in RATES {
            controller.gains = gains(&controller.model, options, closed_loop, rate);
            let noise = controller.gains.kp_per_s * controller.model.noise.speed_mps;
            let hysteresis = LEAST_HYSTERESIS.max(NOISE_HYSTERESIS * noise);
            controller.limits.pedal_hysteresis_mps2 = significant(hysteresis);
            let missed = missed(controller, inverted, vehicles)?;
            if missed < least {
                (best, least) = (controller.clone(), missed);
            }
            if missed == 0.0 {
                return Ok(());
            }
        }
    }
    *controller = best;
    Ok(())
}

/// By how much vehicles miss the requirements, in shares of these.
fn missed(
    controller: &SpeedController,
    inverted: &Arc<Longitudinal>,
    vehicles: &[Arc<Longitudinal>],
) -> Result<f64, Error> {
    let s = &controller.specification;
    let of_each = each(vehicles, |vehicle| -> Result<f64, Error> {
        let responses = at_speeds(controller, inverted, vehicle)?;
        let mut sum = 0.0;
        for r in REQUIREMENTS {
            if let Some(bound) = required(r, s) {
                sum += r.missed(bound, reached(r, &responses, s));
            }
        }
        Ok(sum)
    })?;
    of_each.into_iter().sum()
}

/// The responses of a vehicle at the speeds of the range.
fn at_speeds(
    controller: &SpeedController,
    inverted: &Arc<Longitudinal>,
    vehicle: &Arc<Longitudinal>,
) -> Result<Vec<SpeedResponses>, Error> {
    let [low, high] = controller.specification.speeds_mps;
    let highest = high - controller.specification.step_mps;
    let mut all = Vec::new();
    for k in 0..SPEEDS {
        let speed = low + (highest - low) * f64::from(k) / f64::from(SPEEDS - 1);
        all.push(responses(controller, inverted, vehicle, speed)?);
    }
    Ok(all)
}

/// Vehicles drawn again, and how many of them keep every requirement.
fn ensemble(
    controller: &SpeedController,
    inverted: &Arc<Longitudinal>,
    options: &SpeedDesignOptions,
) -> Result<SpeedEnsemble, Error> {
    let s = &controller.specification;
    let vehicles: Vec<Arc<Longitudinal>> =
        draw(&controller.model, options.seed, 1, options.members)
            .into_iter()
            .map(Arc::new)
            .collect();
    let all = each(&vehicles, |vehicle| at_speeds(controller, inverted, vehicle))?;
    let mut found = SpeedEnsemble {
        vehicles: options.members,
        settling_time_s: Some(0.0),
        ..SpeedEnsemble::default()
    };
    for responses in all {
        let responses = responses?;
        let value = |r: Requirement| reached(r, &responses, s);
        let is_kept =
            REQUIREMENTS.iter().all(|r| required(*r, s).is_none_or(|b| r.is_met(b, value(*r))));
        found.keeping += usize::from(is_kept);
        found.overshoot_percent = found.overshoot_percent.max(value(Requirement::Overshoot));
        found.steady_state_error_percent =
            found.steady_state_error_percent.max(value(Requirement::SteadyState));
        for step in responses.iter().flat_map(|r| [r.up, r.down]) {
            let longest = found.settling_time_s.zip(step.settling_time_s);
            found.settling_time_s = longest.map(|(a, b)| a.max(b));
        }
    }
    Ok(found)
}

fn provenance(source: &SourceFile, options: &SpeedDesignOptions) -> Provenance {
    let text = |value: Option<f64>| value.map_or("none".to_owned(), |value| value.to_string());
    let speeds = options.speeds_mps;
    let mut all = BTreeMap::new();
    for (key, value) in [
        ("overshoot_percent", text(options.overshoot_percent)),
        ("settling_time_s", text(options.settling_time_s)),
        ("steady_state_error_percent", text(options.steady_state_error_percent)),
        ("settling_band_percent", options.settling_band_percent.to_string()),
        ("grade_percent", options.grade_percent.to_string()),
        ("speeds_mps", speeds.map_or("default".into(), |[low, high]| format!("{low}..{high}"))),
        ("max_acceleration_mps2", options.max_acceleration_mps2.to_string()),
        ("max_deceleration_mps2", options.max_deceleration_mps2.to_string()),
        ("max_jerk_mps3", options.max_jerk_mps3.to_string()),
        ("sample_time_s", options.sample_time_s.to_string()),
        ("ensemble", options.members.to_string()),
        ("seed", options.seed.to_string()),
    ] {
        all.insert(key.to_owned(), value);
    }
    Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        sources: vec![source.clone()],
        options: all,
    }
}
