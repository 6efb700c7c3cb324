//! From names to places: the [`Plan`] of a study on its wired system.

use std::collections::BTreeSet;

use fmi2_host::{Causality, Kind, Master, Variable};
use toml::Spanned;

use crate::class::{OFF_PATH_BEYOND_M, Shows};
use crate::connect::Wired;
use crate::disturbance::Disturbance;
use crate::draws::Key;
use crate::error::Error;
use crate::metric::{Metric, Target};
use crate::places::{Places, respanned};
use crate::plan::{Assigned, Assignment, Composed, Member, Plan, Varied};
use crate::quantity::{Linear, Number};
use crate::study::{Disturb, Instances, MasterName, Quantity, Shape, Study};
use crate::values::{Assignments, Found, UNIT_HINT, conversion, find, values};

/// More runs than this are taken for a slip.
const MOST_RUNS: usize = 1_000_000_000;
/// Columns that every results file has.
pub(crate) const OWN_COLUMNS: [&str; 5] = ["run", "passed", "outcome", "status", "study"];

/// Which instances reset exactly: asked with the FMU's generation tool.
pub(crate) type Resets<'a> = &'a dyn Fn(&str) -> bool;

/// Resolves a study.
pub(crate) fn resolve(study: &Study, wired: &Wired, resets: Resets<'_>) -> Result<Plan, Error> {
    let (assignments, varied) = values(study, wired)?;
    let points = points(study, &varied)?;
    let disturbed = disturbances(study, wired, &varied)?;
    let places = Places::new(study, wired, &disturbed)?;
    let metrics = metrics(study, wired, &varied, &places)?;
    unlike(study, &varied, &metrics)?;
    let mut recorded: Vec<(String, usize)> = Vec::new();
    for (index, variable) in &places.looked_at {
        let name = &wired.system.instances()[*index].name();
        recorded.push((format!("{name}.{variable}"), places.of(*index, variable)));
    }
    let members = members(study, wired, resets, &places, &assignments, &disturbed);
    Ok(Plan {
        members,
        slots: places.count,
        master: match study.raw.master {
            MasterName::GaussSeidel => Master::GaussSeidel,
            MasterName::Jacobi => Master::Jacobi,
        },
        start: wired.start,
        step: wired.step,
        steps: wired.steps,
        varied,
        disturbances: disturbed.into_iter().map(|(_, _, disturbance)| disturbance).collect(),
        metrics,
        recorded,
        draws: *study.raw.runs.get_ref(),
        points,
        same_draws_on_grid: study.raw.same_draws_on_grid,
    })
}

/// The points of the grid; refuses no runs and far too many.
fn points(study: &Study, varied: &[Varied]) -> Result<usize, Error> {
    let draws = *study.raw.runs.get_ref();
    if draws == 0 {
        let hint = "give the number of draws for each point of the grid, 1 or more";
        return Err(study.fault(&study.raw.runs, "runs is 0", hint));
    }
    let points = varied
        .iter()
        .try_fold(1usize, |product, v| product.checked_mul(v.distribution.points()))
        .filter(|points| points.checked_mul(draws).is_some_and(|runs| runs <= MOST_RUNS));
    points.ok_or_else(|| {
        let problem = format!("{draws} runs for each point of the grid are more than {MOST_RUNS}");
        study.fault(&study.raw.runs, problem, "thin the grid, or ask for fewer runs")
    })
}

/// A disturbance with the input that it is added to.
pub(crate) type Disturbed<'a> = (usize, &'a Variable, Disturbance);

fn disturbances<'a>(
    study: &Study,
    wired: &'a Wired,
    varied: &[Varied],
) -> Result<Vec<Disturbed<'a>>, Error> {
    let mut all = Vec::new();
    for (place, entry) in study.raw.disturb.iter().enumerate() {
        let stated = entry.get_ref();
        let (index, variable) = find(study, wired, &stated.input)?;
        let path = stated.input.get_ref();
        if variable.causality != Causality::Input || variable.kind != Kind::Real {
            let problem = format!(
                "{path} is a {} {}, and disturbances are added to Real inputs",
                variable.kind, variable.causality
            );
            let hint = "disturb the input that the signal arrives at";
            return Err(study.fault(&stated.input, problem, hint));
        }
        let convert = conversion(wired, (index, variable), stated.unit.as_deref())
            .map_err(|problem| study.fault(&stated.input, problem, UNIT_HINT))?;
        let number = |quantity: &Spanned<Quantity>| number(study, varied, quantity);
        let duration = stated.duration_s.as_ref().map(number).transpose()?;
        check_shape(study, entry, varied, duration)?;
        all.push((
            index,
            variable,
            Disturbance {
                shape: stated.shape,
                amplitude: number(&stated.amplitude)?,
                factor: convert.factor,
                start: match &stated.start_s {
                    Some(start) => number(start)?,
                    None => Number::Fixed(wired.start),
                },
                duration: duration.unwrap_or(Number::Fixed(f64::INFINITY)),
                bandwidth: stated.bandwidth_hz.unwrap_or(0.0),
                key: Key::new(study.raw.seed, &format!("disturb {place} {path}")),
            },
        ));
    }
    Ok(all)
}

/// Refuses a disturbance whose keys do not fit its shape.
fn check_shape(
    study: &Study,
    entry: &Spanned<Disturb>,
    varied: &[Varied],
    duration: Option<Number>,
) -> Result<(), Error> {
    let stated = entry.get_ref();
    let fault = |problem: String| {
        let hint = "step: start_s; pulse and gust: start_s, duration_s; noise: bandwidth_hz";
        Err(study.fault(entry, problem, hint))
    };
    let lasting = matches!(stated.shape, Shape::Pulse | Shape::Gust);
    if lasting != duration.is_some() {
        return fault(format!(
            "this shape {} duration_s",
            if lasting { "needs" } else { "has no" }
        ));
    }
    let least = match duration {
        Some(Number::Fixed(value)) => value,
        Some(Number::Drawn(index)) => varied[index].distribution.reach().0,
        None => 1.0,
    };
    if least.is_nan() || least <= 0.0 {
        return fault(format!("duration_s can be {least}, which is not above 0"));
    }
    match (stated.shape, stated.bandwidth_hz) {
        (Shape::Noise, Some(bandwidth)) if bandwidth > 0.0 && bandwidth.is_finite() => {}
        (Shape::Noise, Some(bandwidth)) => {
            return fault(format!("bandwidth_hz {bandwidth} is not above 0"));
        }
        (Shape::Noise, None) => return fault("noise needs bandwidth_hz".to_owned()),
        (_, Some(_)) => return fault("only noise has a bandwidth_hz".to_owned()),
        (_, None) => {}
    }
    if stated.shape == Shape::Noise && stated.start_s.is_some() {
        return fault("noise goes on from the start to the stop: it has no start_s".to_owned());
    }
    Ok(())
}

/// A number, or a varied quantity by name.
fn number(study: &Study, varied: &[Varied], quantity: &Spanned<Quantity>) -> Result<Number, Error> {
    match quantity.get_ref() {
        Quantity::Number(value) if value.is_finite() => Ok(Number::Fixed(*value)),
        Quantity::Number(value) => {
            Err(study.fault(quantity, format!("{value} is no finite number"), "give a number"))
        }
        Quantity::Name(name) => {
            varied.iter().position(|v| v.name == *name).map(Number::Drawn).ok_or_else(|| {
                let names: Vec<&str> = varied.iter().map(|v| v.name.as_str()).collect();
                let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                let problem = format!("no [[vary]] is named {name:?}; there is {known}");
                study.fault(quantity, problem, "give a number, or the name of a [[vary]]")
            })
        }
    }
}

fn metrics(
    study: &Study,
    wired: &Wired,
    varied: &[Varied],
    places: &Places,
) -> Result<Vec<Metric>, Error> {
    let mut metrics = Vec::new();
    let max_cross_track_error_m = max_cross_track_error(study)?;
    let stop = wired.start + wired.steps as f64 * wired.step;
    for entry in &study.raw.metric {
        let stated = entry.get_ref();
        let fault = |problem: String| {
            let problem = format!("{}: {problem}", stated.name);
            study.fault(entry, problem, "see the metrics in the example that ships")
        };
        stated.kind.check(stated).map_err(fault)?;
        let (from, to) = (stated.from_s.unwrap_or(wired.start), stated.to_s.unwrap_or(stop));
        if !(from <= to && from >= wired.start && to <= stop + 1e-6 * wired.step) {
            let run = format!("{} s to {stop} s", wired.start);
            return Err(fault(format!("{from} s to {to} s is no window of the run, {run}")));
        }
        let to_metric = |found: Found<'_>| {
            conversion(wired, found, stated.unit.as_deref()).map(Linear::inverse).map_err(fault)
        };
        let found = find(study, wired, &stated.variable)?;
        let target = match &stated.target {
            None => Target::Nothing,
            Some(quantity) => match quantity.get_ref() {
                Quantity::Name(name) if name.contains('.') && !is_varied(varied, name) => {
                    let path = respanned(quantity, name);
                    let target = find(study, wired, &path)?;
                    Target::Variable(places.of(target.0, &target.1.name), to_metric(target)?)
                }
                _ => Target::Number(number(study, varied, quantity)?),
            },
        };
        let convert = to_metric(found)?;
        let (kind, allowed) = (stated.kind, stated.at_most);
        let shows =
            Shows::of(&found.1.name, kind, target, convert, allowed, max_cross_track_error_m);
        let own = stated.unit.clone().or_else(|| found.1.unit.clone());
        metrics.push(Metric {
            name: stated.name.clone(),
            kind,
            unit: stated.kind.unit().map(str::to_owned).or(own),
            slot: places.of(found.0, &found.1.name),
            convert,
            target,
            absolute: stated.absolute,
            from,
            to,
            above: stated.above,
            below: stated.below,
            band: stated.band.or(stated.band_percent).unwrap_or(0.0),
            band_is_relative: stated.band_percent.is_some(),
            at_most: stated.at_most,
            at_least: stated.at_least,
            shows,
        });
    }
    Ok(metrics)
}

/// The bound beyond which a cross-track error is off the path, m.
fn max_cross_track_error(study: &Study) -> Result<f64, Error> {
    let Some(stated) = &study.raw.max_cross_track_error_m else { return Ok(OFF_PATH_BEYOND_M) };
    let value = *stated.get_ref();
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    let problem = format!("max_cross_track_error_m {value} is not above 0");
    Err(study.fault(stated, problem, "give what is left of the lane, such as 1.75"))
}

fn is_varied(varied: &[Varied], name: &str) -> bool {
    varied.iter().any(|v| v.name == name)
}

/// Refuses two columns of one name.
fn unlike(study: &Study, varied: &[Varied], metrics: &[Metric]) -> Result<(), Error> {
    let mut seen: BTreeSet<&str> = OWN_COLUMNS.into();
    let of_varied = varied.iter().zip(&study.raw.vary).map(|(v, e)| (&v.name, e.span()));
    let of_metrics = metrics.iter().zip(&study.raw.metric).map(|(m, e)| (&m.name, e.span()));
    for (name, span) in of_varied.chain(of_metrics) {
        if name.trim().is_empty() || !seen.insert(name) {
            let problem = format!("a column of the results is already named {name:?}");
            let hint = "give each [[vary]] and [[metric]] a name of its own";
            return Err(study.fault(&Spanned::new(span, ()), problem, hint));
        }
    }
    Ok(())
}

fn members(
    study: &Study,
    wired: &Wired,
    resets: Resets<'_>,
    places: &Places,
    assignments: &Assignments,
    disturbed: &[Disturbed<'_>],
) -> Vec<Member> {
    let mut members = Vec::new();
    for (index, instance) in wired.system.instances().iter().enumerate() {
        let description = instance.model().description();
        let tool = description.generation_tool.as_deref().unwrap_or_default();
        let mut member = Member {
            name: instance.name().to_owned(),
            reused: match study.raw.instances {
                Instances::Auto => resets(tool),
                Instances::Fresh => false,
                Instances::Reset => true,
            },
            ..Member::default()
        };
        for variable in instance.model().variables() {
            let key = (index, variable.name.clone());
            let assigned = assignments.get(&key);
            let is_fed = places.fed.contains_key(&key);
            if let Some(&slot) = places.composed.get(&key) {
                let start = variable.start.clone();
                let constant = assigned.cloned().or_else(|| start.map(Assigned::Fixed));
                let source = places.fed.get(&key).and_then(|source| places.slots.get(source));
                let scale = (instance.name().to_owned(), variable.name.clone());
                let on_it = |(place, (i, v, _)): (usize, &Disturbed<'_>)| {
                    (*i == index && v.name == variable.name).then_some(place)
                };
                member.inputs.composed.push(Composed {
                    slot,
                    from: source.copied().unwrap_or(slot + 1),
                    scale: wired.scaled.get(&scale).copied().unwrap_or(Linear::SAME),
                    disturbances: disturbed.iter().enumerate().filter_map(on_it).collect(),
                    constant: if is_fed { None } else { constant },
                });
            } else if let (Some(assigned), false) = (assigned, is_fed) {
                let assignment = Assignment {
                    reference: variable.reference,
                    kind: variable.kind,
                    value: assigned.clone(),
                };
                match variable.causality {
                    Causality::Input => member.constants.push(assignment),
                    _ => member.parameters.push(assignment),
                }
            }
            if is_fed || places.composed.contains_key(&key) {
                let from = places.of(index, &variable.name);
                let inputs = &mut member.inputs;
                let (references, sources) = match variable.kind {
                    Kind::Real => (&mut inputs.real, &mut inputs.real_from),
                    Kind::Integer => (&mut inputs.integer, &mut inputs.integer_from),
                    // Texts were refused.
                    _ => (&mut inputs.boolean, &mut inputs.boolean_from),
                };
                references.push(variable.reference);
                sources.push(from);
            }
        }
        members.push(member);
    }
    for (member, (outputs, others)) in members.iter_mut().zip(&places.read) {
        member.outputs = outputs.clone();
        member.others = others.clone();
    }
    members
}
