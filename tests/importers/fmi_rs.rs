//! The archives of `steerwright demo` under fmi-rs; STEERWRIGHT_OUT names their folder.
//!
//! fmi-rs is used with its default features, which unpack archives. Its builder keeps the unpacked
//! folder, so it has to live as long as the instance.

mod support;

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::VariableType;
use std::collections::HashMap;
use std::sync::Arc;
use support::run::Unit;
use support::{LoopCoupling, archive, compare};

/// One FMU, with its variables by name: value reference, and whether it is a Boolean.
struct Slave {
    variables: HashMap<String, (u32, bool)>,
    // Freed in this order.
    fmu: Arc<FMU2<CS>>,
    _folder: FMU2Builder,
}

impl Slave {
    fn open(name: &str) -> Self {
        let folder = FMU2Builder::new(&archive(name)).unwrap().loggingOn(true);
        let variables = folder.model_description.modelVariables.iter().map(|variable| {
            let is_boolean = match variable.variableType {
                VariableType::Real { .. } | VariableType::Integer { .. } => false,
                VariableType::Boolean { .. } => true,
                _ => panic!("{name}.{} is neither number nor Boolean", variable.name),
            };
            (variable.name.clone(), (variable.valueReference, is_boolean))
        });
        let variables = variables.collect();
        let fmu = folder.instantiate_cs(name).unwrap();
        assert_eq!(fmu.getVersion(), "2.0");
        Self { variables, fmu, _folder: folder }
    }
}

/// Neither warning nor worse.
fn ok(status: fmi2Status) {
    assert_eq!(status, fmi2Status::Ok);
}

impl Unit for Slave {
    fn enter_initialization(&mut self) {
        ok(self.fmu.setupExperiment(None, 0.0, None));
        ok(self.fmu.enterInitializationMode());
    }

    fn exit_initialization(&mut self) {
        ok(self.fmu.exitInitializationMode());
    }

    fn set(&mut self, variable: &str, value: f64) {
        let (reference, is_boolean) = self.variables[variable];
        ok(match is_boolean {
            false => self.fmu.setReal(&[reference], &[value]),
            true => self.fmu.setBoolean(&[reference], &[value as i32]),
        });
    }

    fn get(&mut self, variable: &str) -> f64 {
        let (reference, is_boolean) = self.variables[variable];
        let (mut real, mut boolean) = ([f64::NAN], [i32::MIN]);
        ok(match is_boolean {
            false => self.fmu.getReal(&[reference], &mut real),
            true => self.fmu.getBoolean(&[reference], &mut boolean),
        });
        if is_boolean { f64::from(boolean[0]) } else { real[0] }
    }

    fn step(&mut self, time: f64, step: f64) {
        ok(self.fmu.doStep(time, step, 1));
    }

    fn terminate(&mut self) {
        ok(self.fmu.terminate());
    }
}

#[test]
fn fmi_rs_runs_the_closed_loop_of_the_pure_functions() {
    for coupling in [LoopCoupling::GaussSeidel, LoopCoupling::Jacobi] {
        compare("fmi-rs", coupling, Slave::open);
    }
}
