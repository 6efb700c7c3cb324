//! The infeasibility diagnosis in words: what prevents requirements from being met.

use crate::Error;
use crate::design::objective::Objective;
use crate::design::optimiser::{QUICK, TWICE};
use crate::design::options::DesignOptions;
use crate::design::search::{FoundDesign, starts};
use crate::design::target::{LEAST_RESERVE, SHORTEST_SETTLING};
use crate::plants::design_plant::DesignPlant;
use steerwright_formats::{Limits, Requirement};

/// Starting points in addition to the loop found, and the multiple of the plant's scale about which.
const STARTS: u32 = 6;
const SCALE: f64 = 1.5;
/// A limit that never acts.
const NONE: f64 = 1e6;

/// Sentences for a design that misses a requirement; none for one that meets all.
pub(crate) fn infeasibility(
    objective: &Objective,
    plant: &DesignPlant,
    options: &DesignOptions,
    found: &FoundDesign,
) -> Result<Vec<String>, Error> {
    let missed: Vec<(Requirement, f64)> = objective
        .required()
        .into_iter()
        .filter(|(r, required)| !r.is_met(*required, found.reached.value(*r)))
        .collect();
    let mut words: Vec<String> = missed
        .iter()
        .map(|(r, required)| {
            let best = match r {
                Requirement::Settling => "the shortest found that keeps the rest is",
                _ => "what was found reaches",
            };
            let (required, reached) = (r.text(*required), r.text(found.reached.value(*r)));
            format!("a {} of {required} is out of reach: {best} {reached}", r.label())
        })
        .collect();
    if missed.is_empty() {
        return Ok(words);
    }
    let before = words.len();
    // Another plant, or other limits, may require quite other gains.
    let fastest = |objective: &Objective| -> Result<FoundDesign, Error> {
        let mut begin = starts(objective, SCALE, STARTS, options.seed);
        begin.push(found.variables.clone());
        FoundDesign::by_search(objective, &SHORTEST_SETTLING, &begin, TWICE)
    };
    // With another relaxed requirement.
    for (r, required) in objective.required() {
        if missed.iter().any(|(m, _)| *m == r) {
            continue;
        }
        let target = LEAST_RESERVE.relaxing(r);
        let start = std::slice::from_ref(&found.variables);
        let relaxed = FoundDesign::by_search(objective, &target, start, QUICK)?;
        let rest_met = relaxed
            .reached
            .shortfalls(&objective.spec)
            .iter()
            .all(|s| Requirement::from_name(&s.requirement) == Some(r));
        if rest_met && !relaxed.met {
            let (value, required) = (r.text(relaxed.reached.value(r)), r.text(required));
            words.push(format!(
                "a {} of {value} instead of {required} would let the rest be met",
                r.label()
            ));
        } else if relaxed.met {
            // This search found what the one before it missed.
            words.push("a longer search may meet it: try another seed".into());
            return Ok(words);
        }
    }
    // Without a limit; the loop then uses as much of it as is needed.
    let limits = objective.limits;
    let largest_angle = limits.largest_angle_rad(plant.speed);
    let free = Limits { max_angle_rad: NONE, lateral_acceleration: None, ..limits };
    let fast = Limits { max_increment_rad: NONE, max_rate_radps: NONE, ..limits };
    for (changed, is_angle) in [(free, true), (fast, false)] {
        let unlimited = fastest(&objective.limited(changed))?;
        if unlimited.met {
            let step = &unlimited.reached.step;
            let degrees = |rad: f64| rad.to_degrees();
            words.push(if is_angle {
                format!(
                    "the limit of the steering angle, {:.1}°, prevents it: a loop without that limit meets it \
                     with up to {:.1}°",
                    degrees(largest_angle),
                    degrees(step.largest_angle_rad)
                )
            } else {
                format!(
                    "the limit of the steering rate, {:.0}°/s, prevents it: a loop without that limit meets it \
                     with up to {:.0}°/s",
                    degrees(objective.fastest()),
                    degrees(step.largest_increment_rad) / objective.sample_time
                )
            });
        }
    }
    let delay = plant.input_delay + options.loop_delay_s;
    if delay > 0.0 {
        let mut prompt = plant.clone();
        prompt.input_delay = 0.0;
        let without = DesignOptions { loop_delay_s: 0.0, ..*options };
        let mut undelayed = Objective::new(&prompt, &without)?;
        undelayed.scale = objective.scale;
        if fastest(&undelayed)?.met {
            let ms = 1e3 * delay;
            words.push(format!("without the delay of {ms:.0} ms in the loop it could be met"));
        }
    }
    if words.len() == before {
        words.push(
            "no other requirement or limit alone prevents it: the plant itself is too slow for it"
                .into(),
        );
    }
    Ok(words)
}
