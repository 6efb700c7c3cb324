//! Where a design's step asks for more steering than the drive had that its plant was identified from.
//!
//! A linear model knows neither that an actuator has a largest rate nor that tyres give way: beyond the
//! angle and the rate that were driven it is extrapolated.

use crate::closed_loop::scenario::{Step, simulated_step};
use crate::closed_loop::simulate::Simulator;
use crate::plants::DesignPlant;
use crate::plants::family::Family;
use crate::plants::sampled::Sampled;
use formats::{Excitation, Specification};
use vehicle_models::PidParameters;

/// How many times what was driven is clearly more: no less, beyond rounding, than a rate that is taken from
/// the drive.
const CLEARLY: f64 = 2.0 + 1e-9;

/// Sentences for what the step asks for beyond the drive; none where the plant's file does not tell.
pub(crate) fn beyond_the_drive(
    plant: &DesignPlant,
    sampled: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
) -> Vec<String> {
    let Family::Identified(file) = &plant.family else { return Vec::new() };
    let driven = &file.evidence.excitation;
    let mut simulator = Simulator::default();
    simulated_step(&mut simulator, sampled, pid, spec, Step::of(spec));
    let steering = &simulator.trace.steering;
    let angle = steering.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let rate = Excitation::largest_rate(&[&[0.0], &steering[..]].concat(), sampled.sample_time);
    let clearly = |asked: f64, driven: Option<f64>| {
        driven
            .filter(|d| *d > 0.0 && asked > CLEARLY * d)
            .map(|d| (asked.to_degrees(), d.to_degrees()))
    };
    let mut words = Vec::new();
    if let Some((asked, driven)) = clearly(rate, driven.largest_steering_rate_radps) {
        words.push(format!(
            "the step steers at up to {asked:.0}°/s over a tenth of a second, and the drive it was \
             identified from at no more than {driven:.0}°/s: if the actuator cannot follow, the step \
             overshoots; state the rate that it can follow"
        ));
    }
    if let Some((asked, driven)) = clearly(angle, driven.largest_steering_rad) {
        words.push(format!(
            "the step steers by up to {asked:.1}°, and the drive it was identified from by no more than \
             {driven:.1}°: what tyres and actuator do beyond it the model does not know"
        ));
    }
    words
}
