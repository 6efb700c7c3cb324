//! From names to places: the [`Plan`] of a study on its wired system.

use crate::Error;
use crate::connect::{Wired, host};
use crate::disturbance::Disturbance;
use crate::draws::{Key as DrawKey, Number};
use crate::metric::{Metric, OFF_PATH_BEYOND_M, Shows, Target};
use crate::plan::{Plan, Reuse, Varied};
use crate::study::{Disturb, Instances, Quantity, Shape, Study};
use crate::values::{Found, UNIT_HINT, conversion, find, values};
use std::collections::{BTreeMap, BTreeSet};
use steerwright_host::{
    Causality, Composition, Instance, Key, Kind, Linear, PlanOptions, Variable,
};
use toml::Spanned;

/// More runs than this are refused as a mistake.
const MOST_RUNS: usize = 1_000_000_000;
/// Columns that every results file has.
pub(crate) const OWN_COLUMNS: [&str; 5] = ["run", "passed", "outcome", "status", "study"];

/// Whether the instances of a generation tool's FMUs reset exactly.
pub(crate) type Resets<'a> = &'a dyn Fn(&str) -> bool;

pub(crate) fn resolve(study: &Study, wired: &Wired, resets: Resets<'_>) -> Result<Plan, Error> {
    let (assigned, varied) = values(study, wired)?;
    let points = points(study, &varied)?;
    let disturbed = disturbances(study, wired, &varied)?;
    let observed = observed(study, wired)?;
    let composed = composed(&disturbed);
    let signals = disturbed.len();
    let read = observed.clone();
    let options = PlanOptions { read, assigned, signals, composed, ..PlanOptions::default() };
    let system = wired.system.plan(study.raw.coupling, wired.grid, &options);
    let system = system.map_err(|e| host(study, study.raw.ssp.as_ref(), e))?;
    let metrics = metrics(study, wired, &varied, &system)?;
    unlike(study, &varied, &metrics)?;
    let all = wired.system.instances();
    let column = |key: &Key| {
        let place = system.place(key)?;
        Some((format!("{}.{}", all[key.0].name(), key.1), place))
    };
    let reuse = |instance: &Instance| Reuse {
        name: instance.name().to_owned(),
        reused: match study.raw.instances {
            Instances::Auto => {
                let description = instance.model().description();
                resets(description.generation_tool.as_deref().unwrap_or_default())
            }
            Instances::Fresh => false,
            Instances::Reset => true,
        },
    };
    Ok(Plan {
        recorded: observed.iter().filter_map(column).collect(),
        instances: all.iter().map(reuse).collect(),
        system,
        varied,
        disturbances: disturbed.into_iter().map(|(_, _, disturbance)| disturbance).collect(),
        metrics,
        draws: *study.raw.runs.get_ref(),
        points,
        same_draws_on_grid: study.raw.same_draws_on_grid,
    })
}

/// The variables that metrics and trajectories use: connected outputs, then those that the study
/// names.
fn observed(study: &Study, wired: &Wired) -> Result<Vec<Key>, Error> {
    let all = wired.system.instances();
    let index = |name: &str| all.iter().position(|i| i.name() == name).unwrap_or(0);
    let mut observed: Vec<Key> = Vec::new();
    let mut add = |key: Key| {
        if !observed.contains(&key) {
            observed.push(key);
        }
    };
    for c in wired.system.connections() {
        let from = index(&c.from);
        if all[from].variable(&c.output).is_ok_and(|v| v.kind == Kind::String) {
            return Err(Error::Study {
                at: study.top(),
                problem: format!("{}.{} is a text, and it is connected", c.from, c.output),
                hint: "sweeps pass numbers and Booleans between FMUs",
            });
        }
        add((from, c.output.clone()));
    }
    let mut named = |path: &Spanned<String>| {
        let (index, variable) = find(study, wired, path)?;
        if variable.kind == Kind::String {
            let problem = format!("{} is a text", path.get_ref());
            return Err(study.fault(path, problem, "use numbers and Booleans"));
        }
        add((index, variable.name.clone()));
        Ok(())
    };
    for entry in &study.raw.metric {
        named(&entry.get_ref().variable)?;
        if let Some(target) = &entry.get_ref().target
            && let Quantity::Name(name) = target.get_ref()
            && name.contains('.')
            && !study.raw.vary.iter().any(|v| {
                let first = v.get_ref().variables.first().map(Spanned::get_ref);
                v.get_ref().name.as_ref().or(first) == Some(name)
            })
        {
            named(&respanned(target, name))?;
        }
    }
    study.raw.record.iter().try_for_each(&mut named)?;
    Ok(observed)
}

/// The inputs that disturbances are added to.
fn composed(disturbed: &[Disturbed<'_>]) -> BTreeMap<Key, Composition> {
    let mut composed = BTreeMap::new();
    let copy = || Composition { scale: Linear::IDENTITY, added: Vec::new() };
    for (signal, (index, variable, _)) in disturbed.iter().enumerate() {
        let input = composed.entry((*index, variable.name.clone())).or_insert_with(copy);
        input.added.push(signal);
    }
    composed
}

/// A text of an entry, at the entry's place.
fn respanned<T>(entry: &Spanned<T>, text: &str) -> Spanned<String> {
    Spanned::new(entry.span(), text.to_owned())
}

/// The points of the grid; refuses no runs and far too many.
fn points(study: &Study, varied: &[Varied]) -> Result<usize, Error> {
    let draws = *study.raw.runs.get_ref();
    if draws == 0 {
        let hint = "set the number of draws for each point of the grid, 1 or more";
        return Err(study.fault(&study.raw.runs, "runs is 0", hint));
    }
    let points = varied
        .iter()
        .try_fold(1usize, |product, v| product.checked_mul(v.distribution.points()))
        .filter(|points| points.checked_mul(draws).is_some_and(|runs| runs <= MOST_RUNS));
    points.ok_or_else(|| {
        let problem = format!("{draws} runs for each point of the grid are more than {MOST_RUNS}");
        study.fault(&study.raw.runs, problem, "reduce the points of the grid, or runs")
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
                    None => Number::Fixed(wired.grid.start),
                },
                duration: duration.unwrap_or(Number::Fixed(f64::INFINITY)),
                bandwidth: stated.bandwidth_hz.unwrap_or(0.0),
                key: DrawKey::new(study.raw.seed, &format!("disturb {place} {path}")),
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
            Err(study.fault(quantity, format!("{value} is no finite number"), "use a number"))
        }
        Quantity::Name(name) => {
            varied.iter().position(|v| v.name == *name).map(Number::Drawn).ok_or_else(|| {
                let names: Vec<&str> = varied.iter().map(|v| v.name.as_str()).collect();
                let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                let problem = format!("no [[vary]] is named {name:?}; there is {known}");
                study.fault(quantity, problem, "use a number, or the name of a [[vary]]")
            })
        }
    }
}

fn metrics(
    study: &Study,
    wired: &Wired,
    varied: &[Varied],
    system: &steerwright_host::Plan,
) -> Result<Vec<Metric>, Error> {
    let mut metrics = Vec::new();
    let max_cross_track_error_m = max_cross_track_error(study)?;
    let stop = wired.grid.stop;
    // All that the study names is read.
    let place =
        |found: Found<'_>| system.place(&(found.0, found.1.name.clone())).unwrap_or_default();
    for entry in &study.raw.metric {
        let stated = entry.get_ref();
        let fault = |problem: String| {
            let problem = format!("{}: {problem}", stated.name);
            study.fault(entry, problem, "see the metrics in the example that ships")
        };
        stated.check().map_err(fault)?;
        let (from, to) = (stated.from_s.unwrap_or(wired.grid.start), stated.to_s.unwrap_or(stop));
        if !(from <= to && from >= wired.grid.start && to <= stop + 1e-6 * wired.grid.step) {
            let run = format!("{} s to {stop} s", wired.grid.start);
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
                    Target::Variable(place(target), to_metric(target)?)
                }
                _ => Target::Number(number(study, varied, quantity)?),
            },
        };
        let convert = to_metric(found)?;
        let (kind, allowed) = (stated.kind, stated.at_most);
        let shows =
            Shows::new(&found.1.name, kind, target, convert, allowed, max_cross_track_error_m);
        let own = stated.unit.clone().or_else(|| found.1.unit.clone());
        metrics.push(Metric {
            name: stated.name.clone(),
            kind,
            unit: stated.kind.unit().map(str::to_owned).or(own),
            slot: place(found),
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
    let hint = "set the distance from the lane's centre to its edge, such as 1.75";
    Err(study.fault(stated, problem, hint))
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
            let hint = "use a different name for each [[vary]] and [[metric]]";
            return Err(study.fault(&Spanned::new(span, ()), problem, hint));
        }
    }
    Ok(())
}
