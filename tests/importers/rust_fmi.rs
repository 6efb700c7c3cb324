//! The archives of `steerwright demo` under rust-fmi's importer; STEERWRIGHT_OUT names their folder.
//!
//! What rust-fmi 0.8 does not do as it says, and how it is kept out of the way:
//! - Its logger reads the category without asking for NULL. Our FMUs pass one always.
//! - An instance does not keep the unpacked archive: the import has to live longer.
//! - A status `fmi2Pending` panics, in its `From` and in its logger. No step here is asynchronous.
//! - `do_step` passes its `new_step` as `noSetFMUStatePriorToCurrentPoint`.
//! - Its XML reader knows neither `min`, `max` nor `unit`, nor `start` of a string: not used.

mod functions;
mod support;

use fmi::fmi2::Fmi2Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::ScalarVariableElement;
use fmi::traits::FmiImport;
use functions::functions;
use std::collections::HashMap;
use std::sync::Mutex;
use support::run::Unit;
use support::{LoopCoupling, archive, archives, compare};

#[derive(Clone, Copy)]
enum Kind {
    Real,
    Integer,
    Boolean,
}

/// One FMU, with its variables by name.
struct Rust {
    variables: HashMap<String, (u32, Kind)>,
    // Freed in this order: the instance, then the folder that its library and resources are in.
    instance: InstanceCS,
    import: Fmi2Import,
}

impl Rust {
    /// Unpacks, loads and instantiates an archive.
    fn open(name: &str, logging_on: bool) -> Self {
        let archive = archive(name);
        let import: Fmi2Import = fmi::import::from_path(&archive)
            .unwrap_or_else(|e| panic!("{}: {e}", archive.display()));
        let description = import.model_description();
        assert_eq!(description.model_name, name);
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
        let instance = import.instantiate_cs(name, false, logging_on).unwrap();
        Self { variables, instance, import }
    }

    fn find(&self, variable: &str) -> ([u32; 1], Kind) {
        let (reference, kind) = self.variables[variable];
        ([reference], kind)
    }
}

impl Unit for Rust {
    fn enter_initialization(&mut self) {
        self.instance.setup_experiment(None, 0.0, None).unwrap();
        self.instance.enter_initialization_mode().unwrap();
    }

    fn exit_initialization(&mut self) {
        self.instance.exit_initialization_mode().unwrap();
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

    fn step(&mut self, time: f64, step: f64) {
        self.instance.do_step(time, step, true).unwrap();
    }

    fn terminate(&mut self) {
        self.instance.terminate().unwrap();
    }
}

#[test]
fn rust_fmi_runs_the_closed_loop_of_the_pure_functions() {
    for coupling in [LoopCoupling::GaussSeidel, LoopCoupling::Jacobi] {
        compare("rust-fmi", coupling, |name| Rust::open(name, true));
    }
}

macro_rules! missing {
    ($($name:ident $kind:ident($($parameter:ty),*) -> $result:ty;)*) => {
        |binding: &fmi::fmi2::binding::Fmi2Binding| -> Vec<&str> {
            let found = [$((stringify!($name), binding.$name.is_ok())),*];
            found.into_iter().filter(|(_, found)| !found).map(|(name, _)| name).collect()
        }
    };
}

#[test]
fn every_archive_exports_every_function() {
    for name in &archives() {
        let unit = Rust::open(name, false);
        let binding = unit.import.binding(name).unwrap();
        assert_eq!(functions!(missing)(&binding), [""; 0], "{name}");
        // Co-simulation alone: what the other kind of FMU has is not there.
        assert!(binding.fmi2SetTime.is_err(), "{name}");
        assert_eq!(unit.instance.get_version(), "2.0");
        assert_eq!(unit.instance.get_types_platform(), "default");
    }
}

/// What reached rust-fmi's side of the logger: instance, level and text.
static LOGGED: Mutex<Vec<(String, log::Level, String)>> = Mutex::new(Vec::new());

struct Listener;

impl log::Log for Listener {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        let logged = (record.target().into(), record.level(), record.args().to_string());
        LOGGED.lock().unwrap().push(logged);
    }

    fn flush(&self) {}
}

#[test]
fn an_error_is_reported_through_the_callbacks() {
    log::set_logger(&Listener).unwrap();
    let mut unit = Rust::open("LateralPid", true);
    let no_such_reference = [4_000_000_000];
    unit.instance.setup_experiment(None, 0.0, None).unwrap();
    unit.instance.enter_initialization_mode().unwrap();
    let result = unit.instance.get_real(&no_such_reference, &mut [0.0]);
    assert!(matches!(result, Err(Fmi2Error::Error)), "{result:?}");
    let logged = LOGGED.lock().unwrap();
    let of_this_call = |(instance, level, text): &&(String, log::Level, String)| {
        instance == "LateralPid" && *level == log::Level::Error && text.contains("4000000000")
    };
    assert_eq!(logged.iter().filter(of_this_call).count(), 1, "{logged:?}");
}
