//! Why requirements are not met, in words: which of the others, or which limit, blocks them, and what
//! value of it would let them be met.

use crate::Error;
use crate::design::aim::{Aim, BARELY, QUICKEST};
use crate::design::nominal::Found;
use crate::design::objective::Objective;
use crate::design::optimise::{QUICK, TWICE};
use crate::design::search::{search, starts};
use crate::plants::zeros::nearest_right_half_plane;
use crate::requirement::Requirement;
use crate::{DesignOptions, DesignPlant};
use formats::Limits;

/// Starts beside the loop found, and the multiple of the plant's scale about which.
const STARTS: u32 = 6;
const SCALE: f64 = 1.5;
/// A limit that is as good as none.
const NONE: f64 = 1e6;

/// Sentences for a design that misses something; none for one that meets all.
pub(crate) fn blocked(
    objective: &Objective,
    plant: &DesignPlant,
    options: &DesignOptions,
    found: &Found,
) -> Result<Vec<String>, Error> {
    let missed: Vec<(Requirement, f64)> = objective
        .required()
        .into_iter()
        .filter(|(r, required)| !r.is_met(*required, found.reached.value(*r)))
        .collect();
    let mut words: Vec<String> = missed
        .iter()
        .map(|(r, required)| {
            let best = if *r == Requirement::Settling {
                "the shortest found that keeps the rest is"
            } else {
                "what was found reaches"
            };
            let (asked, reached) = (r.text(*required), r.text(found.reached.value(*r)));
            format!("a {} of {asked} is out of reach: {best} {reached}", r.label())
        })
        .collect();
    if missed.is_empty() {
        return Ok(words);
    }
    let before = words.len();
    let search_from = |objective: &Objective, aim: &Aim| -> Result<Found, Error> {
        Ok(Found::of(
            objective,
            search(objective, aim, std::slice::from_ref(&found.variables), QUICK)?,
        ))
    };
    // Another plant, or other limits, may want quite other gains.
    let anew = |objective: &Objective| -> Result<Found, Error> {
        let mut begin = starts(objective, SCALE, STARTS, options.seed);
        begin.push(found.variables.clone());
        Ok(Found::of(objective, search(objective, &QUICKEST, &begin, TWICE)?))
    };
    // Another requirement that gives way.
    for (r, required) in objective.required() {
        if missed.iter().any(|(m, _)| *m == r) {
            continue;
        }
        let given = search_from(objective, &BARELY.giving(r))?;
        let rest_met = given
            .reached
            .shortfalls(&objective.spec)
            .iter()
            .all(|s| Requirement::of(&s.requirement) == Some(r));
        if rest_met && !given.met {
            let (value, asked) = (r.text(given.reached.value(r)), r.text(required));
            words.push(format!(
                "a {} of {value} instead of {asked} would let the rest be met",
                r.label()
            ));
        } else if given.met {
            // The search from there found what the one before did not.
            words.push("a longer search may meet it: try another seed".into());
            return Ok(words);
        }
    }
    // A limit that is taken away; what the loop then uses is what it takes.
    let limits = objective.limits;
    let largest_angle = limits.largest_angle_rad(plant.speed);
    let free = Limits { max_angle_rad: NONE, lateral_acceleration: None, ..limits };
    let fast = Limits { max_increment_rad: NONE, max_rate_radps: NONE, ..limits };
    for (changed, is_angle) in [(free, true), (fast, false)] {
        let given = anew(&objective.limited(changed))?;
        if given.met {
            let step = &given.reached.step;
            let degrees = |rad: f64| rad.to_degrees();
            words.push(if is_angle {
                format!(
                    "the steering angle of {:.1}° holds it back: a loop without that limit meets it \
                     with up to {:.1}°",
                    degrees(largest_angle),
                    degrees(step.largest_angle_rad)
                )
            } else {
                format!(
                    "the steering's rate of {:.0}°/s holds it back: a loop without that limit meets it \
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
        if anew(&undelayed)?.met {
            let ms = 1e3 * delay;
            words.push(format!("without the delay of {ms:.0} ms in the loop it could be met"));
        }
    }
    if words.len() == before {
        words.push(
            "no single other requirement or limit blocks it: the plant itself is too slow for it"
                .into(),
        );
    }
    Ok(words)
}

/// A zero in the right half-plane that holds the loop back.
pub(crate) fn wrong_way(plant: &DesignPlant, crossover: Option<f64>) -> Option<String> {
    let zero = nearest_right_half_plane(plant)?;
    let limit = 0.5 * zero;
    // Far beyond the loop's own bandwidth it is of no account, or an artefact of sampling.
    (crossover.unwrap_or(0.0) > 0.3 * limit).then(|| {
        format!(
            "the plant first turns the wrong way: it is non-minimum-phase, with a zero in the right \
             half-plane at {zero:.2} rad/s, which keeps the crossover below about {limit:.2} rad/s \
             whatever the controller"
        )
    })
}
