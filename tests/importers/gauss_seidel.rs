//! A Gauss–Seidel co-simulation master over rust-fmi's importer.
//!
//! Written against the FMI 2.0 text and the interfaces of the FMUs alone, like the one in
//! tests/python: neither knows anything of the Rust host in fmu/host.
//!
//! What rust-fmi 0.8 does not do as it says, and how it is kept out of the way:
//! - Its logger reads the category without asking for NULL. Our FMUs pass one always.
//! - An instance does not keep the unpacked archive: the import has to live longer.
//! - A status `fmi2Pending` panics, in its `From` and in its logger. No step here is asynchronous.
//! - `do_step` passes its `new_step` as `noSetFMUStatePriorToCurrentPoint`.
//! - Its XML reader knows neither `min`, `max` nor `unit`, nor `start` of a string: not used.

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::ScalarVariableElement;
use fmi::traits::FmiImport;
use std::collections::HashMap;
use std::path::Path;

#[derive(Clone, Copy)]
enum Kind {
    Real,
    Integer,
    Boolean,
}

/// One FMU, with its variables by name.
pub(crate) struct Unit {
    pub(crate) name: String,
    variables: HashMap<String, (u32, Kind)>,
    // Freed in this order: the instance, then the folder that its library and resources are in.
    pub(crate) instance: InstanceCS,
    pub(crate) import: Fmi2Import,
}

impl Unit {
    /// Unpacks, loads and instantiates an archive.
    pub(crate) fn open(archive: &Path, logging_on: bool) -> Self {
        let import: Fmi2Import = fmi::import::from_path(archive)
            .unwrap_or_else(|e| panic!("{}: {e}", archive.display()));
        let description = import.model_description();
        let name = description.model_name.clone();
        let variables = description.get_model_variables().filter_map(|variable| {
            let kind = match variable.elem {
                ScalarVariableElement::Real(_) => Kind::Real,
                ScalarVariableElement::Integer(_) => Kind::Integer,
                ScalarVariableElement::Boolean(_) => Kind::Boolean,
                _ => return None,
            };
            Some((variable.name.clone(), (variable.value_reference, kind)))
        });
        let variables = variables.collect();
        let instance = import.instantiate_cs(&name, false, logging_on).unwrap();
        Self { name, variables, instance, import }
    }

    fn find(&self, variable: &str) -> ([u32; 1], Kind) {
        let (reference, kind) = self.variables[variable];
        ([reference], kind)
    }

    fn set(&mut self, variable: &str, value: f64) {
        let (reference, kind) = self.find(variable);
        match kind {
            Kind::Real => self.instance.set_real(&reference, &[value]),
            Kind::Integer => self.instance.set_integer(&reference, &[value as i32]),
            Kind::Boolean => self.instance.set_boolean(&reference, &[value as i32]),
        }
        .unwrap();
    }

    fn get(&mut self, variable: &str) -> f64 {
        let (reference, kind) = self.find(variable);
        let (mut real, mut integer) = ([f64::NAN], [i32::MIN]);
        match kind {
            Kind::Real => self.instance.get_real(&reference, &mut real).unwrap(),
            Kind::Integer => self.instance.get_integer(&reference, &mut integer).unwrap(),
            Kind::Boolean => self.instance.get_boolean(&reference, &mut integer).unwrap(),
        };
        if matches!(kind, Kind::Real) { real[0] } else { f64::from(integer[0]) }
    }
}

/// A variable of a unit: the unit's place in the order of steps, and the variable's name.
pub(crate) type Port<'a> = (usize, &'a str);

/// Steps the units in their order; gives time and the recorded variables, a row each point.
///
/// `wires` go from an output to an input.
pub(crate) fn run(
    units: &mut [Unit],
    wires: &[(Port<'_>, Port<'_>)],
    stop: f64,
    step: f64,
    record: &[Port<'_>],
) -> Vec<Vec<f64>> {
    let feed = |units: &mut [Unit], sink: usize| {
        for ((source, output), (_, input)) in wires.iter().filter(|wire| wire.1.0 == sink) {
            let value = units[*source].get(output);
            units[sink].set(input, value);
        }
    };
    let row = |units: &mut [Unit], time: f64| {
        let values = record.iter().map(|(unit, variable)| units[*unit].get(variable));
        std::iter::once(time).chain(values).collect()
    };
    for unit in &mut *units {
        unit.instance.setup_experiment(None, 0.0, None).unwrap();
        unit.instance.enter_initialization_mode().unwrap();
    }
    // No chain of wires is longer than the units are many.
    for _ in 0..=units.len() {
        for sink in 0..units.len() {
            feed(units, sink);
        }
    }
    for unit in &mut *units {
        unit.instance.exit_initialization_mode().unwrap();
    }
    let mut rows = vec![row(units, 0.0)];
    for k in 0..(stop / step).round() as u32 {
        for sink in 0..units.len() {
            feed(units, sink);
            units[sink].instance.do_step(f64::from(k) * step, step, true).unwrap();
        }
        rows.push(row(units, f64::from(k + 1) * step));
    }
    for unit in units {
        unit.instance.terminate().unwrap();
    }
    rows
}
