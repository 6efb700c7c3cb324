//! The three kinds of derivatives, if an FMU declares them: the calls must succeed and return finite values.

use super::exercise::{ExerciseRun, Stop};
use model_description::{Causality, Kind, Value, Variability, Variable};
use steerwright_host::Instance;

impl ExerciseRun<'_> {
    /// Names and references of the continuous Reals of a causality.
    pub(super) fn continuous(&self, causality: Causality) -> Vec<(String, u32)> {
        let wanted = |v: &&Variable| {
            v.causality == causality
                && v.kind == Kind::Real
                && v.variability == Variability::Continuous
        };
        let variables = self.description().variables.iter().filter(wanted);
        variables.map(|v| (v.name.clone(), v.reference)).collect()
    }

    pub(super) fn input_derivatives(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2SetRealInputDerivatives");
        for (_, reference) in self.continuous(Causality::Input) {
            self.legal(instance.set_real_input_derivatives(&[reference], &[1], &[0.0]))?;
        }
        Ok(())
    }

    pub(super) fn output_derivatives(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2GetRealOutputDerivatives");
        for (name, reference) in self.continuous(Causality::Output) {
            let mut value = [0.0];
            self.legal(instance.get_real_output_derivatives(&[reference], &[1], &mut value))?;
            self.finite(&format!("derivative of {name}"), &Value::Real(value[0]));
        }
        Ok(())
    }

    /// Each unknown with each of its declared dependencies.
    pub(super) fn directional_derivatives(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2GetDirectionalDerivative");
        let description = self.description();
        let real = |index: u32| {
            let variable = description.variable_at(index).filter(|v| v.kind == Kind::Real)?;
            Some((variable.name.clone(), variable.reference))
        };
        let mut pairs = Vec::new();
        for unknown in description.outputs.iter().chain(&description.derivatives) {
            for known in unknown.dependencies.iter().flatten() {
                let is_time = description
                    .variable_at(*known)
                    .is_some_and(|v| v.causality == Causality::Independent);
                if let (Some(unknown), Some(known), false) =
                    (real(unknown.index), real(*known), is_time)
                {
                    pairs.push((unknown, known));
                }
            }
        }
        for ((of, unknown), (by, known)) in pairs.into_iter().take(1000) {
            let mut value = [0.0];
            let got = instance.get_directional_derivative(&[unknown], &[known], &[1.0], &mut value);
            self.legal(got)?;
            let name = format!("derivative of {of} by {by}");
            self.finite(&name, &Value::Real(value[0]));
        }
        Ok(())
    }
}
