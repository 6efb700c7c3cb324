//! Alias variables: those of one base type that share a value reference (section 2.2.7).

use super::Check;
use super::place::FindingPlace;
use crate::description::Variable;
use crate::vocabulary::{Causality, Variability};
use std::collections::BTreeMap;

impl Check<'_> {
    pub(super) fn aliases(&mut self) {
        let description = self.description;
        // Enumerations are read as Integer: they share the base type.
        let mut sets: BTreeMap<(&str, u32), Vec<usize>> = BTreeMap::new();
        for (variable, position) in description.variables.iter().zip(0..) {
            sets.entry((variable.kind.as_str(), variable.reference)).or_default().push(position);
        }
        for set in sets.values().filter(|set| set.len() > 1) {
            self.alias_set(set);
        }
    }

    /// Compares every member of an alias set with the members before it.
    fn alias_set(&mut self, set: &[usize]) {
        let description = self.description;
        let variable = |position: usize| &description.variables[position];
        let mut settable: Option<&Variable> = None;
        let mut independent: Option<&Variable> = None;
        let mut started: Option<&Variable> = None;
        let first = variable(set[0]);
        for &position in set {
            let (v, place) = (variable(position), FindingPlace::Variable(position));
            let constant = v.variability == Variability::Constant;
            let is_set = matches!(v.causality, Causality::Parameter | Causality::Input);
            let is_independent = v.causality == Causality::Independent;
            let other = match (is_set, is_independent) {
                (true, _) => settable.or(independent),
                (_, true) => settable,
                _ => None,
            };
            if let Some(other) = other {
                let message = format!(
                    "has the same value reference as `{}`, and both can be set",
                    other.name
                );
                self.report("alias-both-settable", place, message);
            } else if v.start.is_some()
                && !constant
                && let Some(other) = started
            {
                let message = format!("its alias `{}` has a start value too", other.name);
                self.report("alias-start-twice", place, message);
            }
            if std::ptr::eq(v, first) {
                // Nothing before it.
            } else if constant != (first.variability == Variability::Constant) {
                let message =
                    format!("either it or its alias `{}` is constant, but not both", first.name);
                self.report("alias-constant", place, message);
            } else if constant && v.start != first.start {
                let message =
                    format!("its alias `{}` is a constant with another value", first.name);
                self.report("alias-constant", place, message);
            }
            if v.unit != first.unit && other.is_none() {
                let message = format!("its alias `{}` has another unit", first.name);
                self.report("alias-unit", place, message);
            }
            settable = settable.or(Some(v).filter(|_| is_set));
            independent = independent.or(Some(v).filter(|_| is_independent));
            started = started.or(Some(v).filter(|_| v.start.is_some() && !constant));
        }
    }
}
