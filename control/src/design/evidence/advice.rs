//! Sentences about a plant that is less well known than the requirements assume.

use crate::closed_loop::scenario::{Step, simulated_step};
use crate::closed_loop::simulate::Simulator;
use crate::plants::design_plant::{DesignPlant, Family};
use crate::plants::dynamics::nearest_right_half_plane_zero;
use crate::plants::sampled::Sampled;
use steerwright_formats::{Excitation, Requirement, Robustness, Specification};
use steerwright_models::PidParameters;

/// Multiple of the steering of the drive that is reported: no less, except for rounding, than the default rate.
const CLEARLY: f64 = 2.0 + 1e-9;

/// The rate that is assumed where none was stated.
pub(crate) fn assumed_rate(max_rate_radps: f64) -> String {
    format!(
        "no rate of the steering was stated: the loop is designed for {:.0}°/s, twice the fastest \
         steering of the drive",
        max_rate_radps.to_degrees()
    )
}

/// Where the step steers further or faster than the drive, beyond which a linear model is extrapolated.
pub(crate) fn beyond_the_drive(
    plant: &DesignPlant,
    sampled: &Sampled,
    pid: &PidParameters,
    spec: &Specification,
) -> Vec<String> {
    let Family::Identified(file) = &plant.family else { return Vec::new() };
    let driven = &file.evidence.excitation;
    let mut simulator = Simulator::default();
    simulated_step(&mut simulator, sampled, pid, spec, Step::from_specification(spec));
    let steering = &simulator.trace.steering;
    let angle = steering.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let rate = Excitation::largest_rate(&[&[0.0], &steering[..]].concat(), sampled.sample_time);
    let clearly = |largest: f64, driven: Option<f64>| {
        driven
            .filter(|d| *d > 0.0 && largest > CLEARLY * d)
            .map(|d| (largest.to_degrees(), d.to_degrees()))
    };
    let mut words = Vec::new();
    if let Some((largest, driven)) = clearly(rate, driven.largest_steering_rate_radps) {
        words.push(format!(
            "the step steers at up to {largest:.0}°/s over a tenth of a second, and the drive it was \
             identified from at no more than {driven:.0}°/s: if the actuator cannot follow, the step \
             overshoots; state the rate that it can follow"
        ));
    }
    if let Some((largest, driven)) = clearly(angle, driven.largest_steering_rad) {
        words.push(format!(
            "the step steers by up to {largest:.1}°, and the drive it was identified from by no more than \
             {driven:.1}°: the model does not cover tyres and actuator beyond it"
        ));
    }
    words
}

pub(crate) fn non_minimum_phase(plant: &DesignPlant, crossover: Option<f64>) -> Option<String> {
    let zero = nearest_right_half_plane_zero(&plant.dynamics)?;
    let limit = 0.5 * zero;
    // Far beyond the loop's bandwidth it has no effect, or is an artefact of sampling.
    if crossover.unwrap_or(0.0) > 0.3 * limit {
        Some(format!(
            "the plant first turns the wrong way: it is non-minimum-phase, with a zero in the right \
             half-plane at {zero:.2} rad/s, which keeps the crossover below about {limit:.2} rad/s \
             whatever the controller"
        ))
    } else {
        None
    }
}

/// The settling time that all plants could keep, rounded up to a readable number.
pub(crate) fn common_settling(settling_time_s: f64) -> String {
    const SPARE: f64 = 1.03;
    let settling = (20.0 * SPARE * settling_time_s).ceil() / 20.0;
    format!(
        "all plants could keep a settling time of {}, with all other requirements unchanged",
        Requirement::Settling.text(settling)
    )
}

/// The requirements that the nominal plant keeps and other plants do not.
pub(crate) fn not_robust(r: &Robustness, met: bool) -> Vec<String> {
    if r.met || !met {
        return Vec::new();
    }
    r.requirements
        .iter()
        .filter(|x| x.share_kept < 1.0)
        .filter_map(|x| Some((Requirement::from_name(&x.requirement)?, x)))
        .map(|(requirement, x)| {
            format!(
                "over {} plants within the uncertainty and {:.0} to {:.0} ms of loop delay beyond the \
                 model's own the {} goes to {}, and {:.0} % of them keep it",
                r.plants,
                // Without + 0.0 some microseconds less would be −0.
                (1e3 * r.loop_delay_range_s[0]).round() + 0.0,
                1e3 * r.loop_delay_range_s[1],
                requirement.label(),
                requirement.text(x.worst),
                100.0 * x.share_kept
            )
        })
        .collect()
}
