//! A run of a system: its settings, table and recorded variables compiled, stepped and recorded.

use std::collections::HashMap;

use model_description::{Causality, Kind, Variable};

use super::System;
use super::cosimulation::Cosimulation;
use super::inputs::InputTable;
use super::plan::{Assigned, Coupling, Grid, Key, Linear, PlanOptions};
use super::recording::Recording;
use crate::Error;
use crate::instance::{Phase, why_not_settable};

/// More steps are refused: a slip in a time.
const MAX_STEPS: f64 = 1e8;

impl System {
    /// The names of the recorded variables, `instance.variable`, in order.
    ///
    /// # Errors
    /// [`Error`] where an instance lacks a variable that is to be recorded.
    pub fn recorded(&self) -> Result<Vec<String>, Error> {
        let variables = self.recorded_variables()?;
        Ok(variables.into_iter().map(|(index, name)| self.path(index, &name)).collect())
    }

    /// Runs the system from `start` to `stop` by steps of `step`, all in s, and terminates the
    /// instances. Run again, they are reset first.
    ///
    /// # Errors
    /// [`Error`] of the system, its table, or an instance.
    pub fn run(
        &mut self,
        coupling: Coupling,
        start: f64,
        stop: f64,
        step: f64,
    ) -> Result<Recording, Error> {
        let mut recording = Recording::default();
        self.run_into(&mut recording, coupling, start, stop, step, |_| {})?;
        Ok(recording)
    }

    /// As [`System::run`], into a recording that keeps its rows where the run fails or an FMU ends it;
    /// `after_row` is called after each row.
    /// Where the FMU of a system of one ends it between two communication points, the last row is that
    /// of the time that the FMU reached.
    ///
    /// # Errors
    /// [`Error`] of the system, its table, or an instance; [`Error::Terminated`] where an FMU ends the
    /// simulation.
    pub fn run_into(
        &mut self,
        recording: &mut Recording,
        coupling: Coupling,
        start: f64,
        stop: f64,
        step: f64,
        mut after_row: impl FnMut(&Recording),
    ) -> Result<(), Error> {
        let steps = grid(start, stop, step)?;
        let mut grid = Grid { start, stop, step, steps };
        // The last point may lie an ulp past the stated stop time.
        grid.stop = stop.max(grid.time(steps));
        let recorded = self.recorded_variables()?;
        let mut feed = Feed::default();
        let mut options = PlanOptions { read: recorded.clone(), ..PlanOptions::default() };
        if let Some(table) = &self.table {
            feed = Feed::new(self, table, start, &mut options.fed_by_signals)?;
            options.signals = feed.columns.len();
        }
        options.assigned = self.assigned(&options.fed_by_signals)?;
        let plan = self.plan(coupling, grid, &options)?;

        let Self { instances, table, .. } = self;
        let mut signals = |time: f64, values: &mut [f64]| {
            if let Some(table) = table {
                feed.set_values(table, time, step, values);
            }
        };
        let mut run = Cosimulation::new(&plan);
        let settled = run.initialize(instances, &[], &mut signals)?;
        let of = |index: usize| &instances[index];
        let unit = |(index, name): &Key| Ok(of(*index).variable(name)?.unit.clone());
        *recording = Recording {
            names: recorded.iter().map(|(i, name)| format!("{}.{name}", of(*i).name())).collect(),
            units: recorded.iter().map(unit).collect::<Result<_, Error>>()?,
            times: Vec::new(),
            rows: Vec::new(),
            initial_passes: settled.passes,
            initially_settled: settled.converged,
        };
        let places: Vec<usize> = recorded.iter().filter_map(|key| plan.place(key)).collect();
        let mut record = |time: f64, values: &[f64]| {
            recording.times.push(time);
            recording.rows.push(places.iter().map(|place| values[*place]).collect());
            after_row(recording);
        };
        record(start, run.values());
        for k in 0..steps {
            match run.step(instances, k, &mut signals) {
                Ok(()) => record(grid.time(k + 1), run.values()),
                Err(error) => {
                    if let Error::Terminated { time, .. } = &error {
                        if instances.len() == 1 && *time > grid.time(k) + 1e-6 * step {
                            run.read_all(instances)?;
                            run.observe(instances)?;
                            record(*time, run.values());
                        }
                        for instance in instances {
                            // An FMU that has ended may refuse.
                            let _ = instance.terminate();
                        }
                    }
                    return Err(error);
                }
            }
        }
        for instance in instances {
            instance.terminate()?;
        }
        Ok(())
    }

    /// What to record: the stated variables, or all outputs and free inputs that are no texts.
    fn recorded_variables(&self) -> Result<Vec<Key>, Error> {
        if let Some(recorded) = &self.recorded {
            return recorded.iter().map(|(i, v)| Ok((self.index(i)?, v.clone()))).collect();
        }
        let mut variables = Vec::new();
        for (index, instance) in self.instances.iter().enumerate() {
            for variable in instance.model().variables() {
                let wanted = match variable.causality {
                    Causality::Output => true,
                    // A connected input has the values of its source.
                    Causality::Input => self.feeding(instance.name(), &variable.name).is_none(),
                    _ => false,
                };
                if wanted && variable.kind != Kind::String {
                    variables.push((index, variable.name.clone()));
                }
            }
        }
        Ok(variables)
    }

    /// The settings; refuses those of variables that are fed, or cannot be set.
    fn assigned(&self, fed: &HashMap<Key, usize>) -> Result<HashMap<Key, Assigned>, Error> {
        let mut assigned = HashMap::new();
        for setting in &self.settings {
            let (index, name) = (setting.instance, &setting.variable);
            let instance = &self.instances[index];
            let key = (index, name.clone());
            if setting.is_start && fed.contains_key(&key) {
                continue;
            }
            let column = || {
                let table = self.table.as_ref()?;
                let mut columns = table.columns().iter();
                let column = columns.find(|c| self.is_column_of(c, index, name))?;
                Some(format!("column {column:?} of {}", table.name()))
            };
            let source = match self.feeding(instance.name(), name) {
                Some(connection) => Some(connection.source()),
                None => fed.get(&key).and_then(|_| column()),
            };
            if let Some(source_name) = source {
                return Err(Error::SetAndFed { input: self.path(index, name), source_name });
            }
            let variable = instance.variable(name)?;
            let phase = match variable.causality {
                Causality::Input => Phase::Initialization,
                _ => Phase::Instantiated,
            };
            if let Some(reason) = why_not_settable(variable, phase) {
                let (instance, variable) = (instance.name().to_owned(), name.clone());
                return Err(Error::NotSettable { instance, variable, phase: phase.when(), reason });
            }
            assigned.insert(key, Assigned::Fixed(setting.value.clone()));
        }
        Ok(assigned)
    }
}

/// The number of steps of a time grid, all in s; refuses grids that are no whole steps, or more than
/// 100 million.
///
/// # Errors
/// [`Error::BadGrid`].
pub fn grid(start: f64, stop: f64, step: f64) -> Result<usize, Error> {
    let bad = |reason: &'static str| Err(Error::BadGrid { start, stop, step, reason });
    if !(start.is_finite() && stop.is_finite() && step.is_finite()) {
        return bad("a time is not finite");
    }
    if step <= 0.0 {
        return bad("the step is not above 0");
    }
    if stop <= start {
        return bad("the stop is not after the start");
    }
    let steps = (stop - start) / step;
    if steps > MAX_STEPS {
        return bad("more than 100 million steps");
    }
    if steps.round() < 1.0 || (steps - steps.round()).abs() > 1e-6 {
        return bad("the stop is not a whole number of steps after the start");
    }
    if start + step == start || stop - step == stop {
        return bad("the step is too small to change the times");
    }
    Ok(steps.round() as usize)
}

/// A table's columns as external signals.
#[derive(Default)]
struct Feed {
    /// The column of each signal, and the change of its values.
    columns: Vec<(usize, Linear)>,
    /// The table's present row.
    row: usize,
}

impl Feed {
    /// Assigns the table's columns to the inputs they name. A column named `instance.input` feeds
    /// that input, one named as a connector of the system the inputs that this feeds, another named
    /// `input` every input of that name without a connection.
    fn new(
        system: &System,
        table: &InputTable,
        start: f64,
        fed: &mut HashMap<Key, usize>,
    ) -> Result<Self, Error> {
        let first = table.times().first().copied().unwrap_or(f64::INFINITY);
        if first > start {
            return Err(Error::TableStart { table: table.name().to_owned(), first, start });
        }
        let mut columns: Vec<(usize, Linear)> = Vec::new();
        for (column, name) in table.columns().iter().enumerate() {
            // Names of variables may have dots in them, so a dot alone does not make a path.
            let named =
                |(index, v): &(usize, &Variable)| system.is_column_of(name, *index, &v.name);
            let all: Vec<(usize, &Variable)> = system.inputs().filter(named).collect();
            let Some(&any) = all.first() else {
                return Err(Error::TableColumn {
                    table: table.name().to_owned(),
                    column: name.clone(),
                    near: system.near_inputs(name),
                });
            };
            let set_and_fed = |(index, variable): (usize, &Variable), source: String| {
                Error::SetAndFed { input: system.path(index, &variable.name), source_name: source }
            };
            let mut free = all;
            free.retain(|(index, v)| {
                system.feeding(system.instances[*index].name(), &v.name).is_none()
            });
            if free.is_empty() {
                return Err(set_and_fed(any, format!("a connection and column {name:?}")));
            }
            for (index, variable) in free {
                table.fits(column, variable.kind)?;
                let of = |column: usize| {
                    format!("column {:?} of {}", table.columns()[column], table.name())
                };
                let key = (index, variable.name.clone());
                if let Some(other) = fed.insert(key, columns.len()) {
                    let both = format!("{} and {}", of(columns[other].0), of(column));
                    return Err(set_and_fed((index, variable), both));
                }
                let scale = system.scale_of_column(name, index, &variable.name);
                columns.push((column, scale));
            }
        }
        Ok(Self { columns, row: 0 })
    }

    /// Writes the table's values at a time.
    fn set_values(&mut self, table: &InputTable, time: f64, step: f64, values: &mut [f64]) {
        // k·step may fall an ulp short of the time that the table states.
        let due = time + 1e-6 * step;
        while table.times().get(self.row + 1).is_some_and(|next| *next <= due) {
            self.row += 1;
        }
        let row = table.row(self.row);
        for (value, (column, scale)) in values.iter_mut().zip(&self.columns) {
            *value = scale.apply(row[*column]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_whole_steps() {
        assert_eq!(grid(0.0, 1.0, 0.1).unwrap(), 10);
        assert_eq!(grid(5.0, 5.3, 0.1).unwrap(), 3);
        assert_eq!(grid(0.0, 20.0, 1.0 / 60.0).unwrap(), 1200);
        for (start, stop, step) in [
            (0.0, 1.0, 0.3),
            (0.0, 1.0, 0.0),
            (0.0, 1.0, -0.1),
            (1.0, 1.0, 0.1),
            (0.0, f64::NAN, 0.1),
            (0.0, f64::INFINITY, 0.1),
            (0.0, 1.0, 2.0),
            (0.0, 1e9, 0.1),
            (1e20, 1e20 + 1e6, 1.0),
        ] {
            assert!(grid(start, stop, step).is_err(), "{start} {stop} {step}");
        }
    }
}
