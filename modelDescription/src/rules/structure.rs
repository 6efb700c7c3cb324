//! `ModelStructure`: required variables of each list, and legal dependencies (section 2.2.8).

use super::Check;
use super::place::{FindingPlace, List};
use crate::description::{Unknown, Variable};
use crate::vocabulary::{Causality, DependencyKind, Initial, Kind, Variability};
use std::collections::BTreeSet;

impl Check<'_> {
    pub(super) fn structure(&mut self) {
        let description = self.description;
        let indexed = || description.variables.iter().zip(1_u32..);
        let outputs: Vec<u32> = indexed()
            .filter(|(v, _)| v.causality == Causality::Output)
            .map(|(_, index)| index)
            .collect();
        self.same_set(List::Outputs, &outputs);
        let derivatives: BTreeSet<u32> = description.derivatives.iter().map(|u| u.index).collect();
        let states: BTreeSet<u32> = indexed()
            .filter(|(_, index)| derivatives.contains(index))
            .filter_map(|(v, _)| v.derivative)
            .collect();
        let initial: Vec<u32> = indexed()
            .filter(|(v, index)| {
                let free =
                    matches!(v.effective_initial(), Some(Initial::Approx | Initial::Calculated));
                v.causality == Causality::CalculatedParameter
                    || free
                        && (v.causality == Causality::Output
                            || derivatives.contains(index)
                            || states.contains(index))
            })
            .map(|(_, index)| index)
            .collect();
        self.same_set(List::InitialUnknowns, &initial);
        let listed: Vec<u32> = description.initial_unknowns.iter().map(|u| u.index).collect();
        if !listed.is_sorted() {
            let message = "InitialUnknowns are not in ascending order".into();
            self.report(
                "initial-unknowns-order",
                FindingPlace::List(List::InitialUnknowns),
                message,
            );
        }
        self.derivatives();
        for list in [List::Outputs, List::Derivatives, List::InitialUnknowns] {
            for (unknown, position) in list.unknowns(description).iter().zip(0..) {
                self.unknown(list, unknown, FindingPlace::Unknown { list, position });
            }
        }
    }

    /// Whether each entry of `Derivatives` is one, of a variable that can be a state.
    fn derivatives(&mut self) {
        let description = self.description;
        let list = List::Derivatives;
        let mut seen = BTreeSet::new();
        for (unknown, position) in description.derivatives.iter().zip(0..) {
            let place = FindingPlace::Unknown { list, position };
            if !seen.insert(unknown.index) {
                self.report("structure-twice", place, format!("stands twice under {list}"));
            }
            let Some(v) = description.variable_at(unknown.index) else {
                let message = format!("index {} is not a variable", unknown.index);
                self.report("structure-index", place, message);
                continue;
            };
            if v.derivative.is_none() {
                let message = "is listed under Derivatives but has no attribute derivative".into();
                self.report("derivatives-attribute", place, message);
            }
            let state = v.derivative.and_then(|index| description.variable_at(index));
            let continuous =
                |v: &Variable| v.kind == Kind::Real && v.variability == Variability::Continuous;
            if !continuous(v) || state.is_some_and(|state| !continuous(state)) {
                let message = "a state or its derivative is not a continuous Real".into();
                self.report("state-not-continuous", place, message);
            }
            if let Some(state) = state
                && !matches!(state.causality, Causality::Local | Causality::Output)
            {
                let message = format!("its state `{}` is neither local nor output", state.name);
                self.report("state-causality", place, message);
            }
        }
    }

    /// Reports missing, repeated and superfluous variables of `list`.
    fn same_set(&mut self, list: List, need: &[u32]) {
        let description = self.description;
        let mut listed = BTreeSet::new();
        for (unknown, position) in list.unknowns(description).iter().zip(0..) {
            let place = FindingPlace::Unknown { list, position };
            let index = unknown.index;
            if !listed.insert(index) {
                self.report("structure-twice", place, format!("stands twice under {list}"));
            } else if description.variable_at(index).is_none() {
                self.report("structure-index", place, format!("index {index} is not a variable"));
            } else if need.binary_search(&index).is_err() {
                let message = format!("index {index} is not allowed under {list}");
                self.report("structure-extra", place, message);
            }
        }
        for index in need.iter().filter(|index| !listed.contains(index)) {
            let place = FindingPlace::Variable(*index as usize - 1);
            self.report("structure-missing", place, format!("is not listed under {list}"));
        }
    }

    fn unknown(&mut self, list: List, unknown: &Unknown, place: FindingPlace) {
        let description = self.description;
        let states_count = description.model_exchange.is_some()
            || description.co_simulation.as_ref().is_none_or(|c| c.provides_directional_derivative);
        if let Some(dependencies) = &unknown.dependencies {
            if !dependencies.is_sorted_by(|a, b| a < b) {
                let message = format!("its dependencies under {list} are not in ascending order");
                self.report("dependencies-order", place, message);
            }
            for &index in dependencies {
                let known = description.variable_at(index);
                if known.is_none() {
                    let message =
                        format!("depends under {list} on index {index}, which is not a variable");
                    self.report("dependency-unknown", place, message);
                } else if known.is_some_and(|v| !is_known(v, list, self.states.contains(&index))) {
                    let message = format!(
                        "depends under {list} on index {index}, which is not a known there"
                    );
                    self.report("dependency-no-known", place, message);
                } else if list != List::InitialUnknowns
                    && !states_count
                    && known.is_some_and(|v| {
                        !matches!(v.causality, Causality::Input | Causality::Independent)
                    })
                {
                    let message = format!(
                        "depends under {list} on the state of index {index}, without \
                         providesDirectionalDerivative"
                    );
                    self.report("dependency-on-state", place, message);
                }
            }
        }
        if let Some(kinds) = &unknown.kinds {
            let entries = unknown.dependencies.as_ref().map_or(0, Vec::len);
            if unknown.dependencies.is_none() || kinds.len() != entries {
                let message = format!(
                    "under {list}: {} kinds of dependency for {entries} dependencies",
                    kinds.len()
                );
                self.report("dependencies-kind-count", place, message);
            }
            let plain = |kind: &DependencyKind| {
                matches!(kind, DependencyKind::Dependent | DependencyKind::Constant)
            };
            if list == List::InitialUnknowns && !kinds.iter().all(plain) {
                let message = "InitialUnknowns allow only the kinds dependent and constant".into();
                self.report("dependencies-kind", place, message);
            }
            let real = description.variable_at(unknown.index).is_some_and(|v| v.kind == Kind::Real);
            if !real && kinds.iter().any(|kind| *kind != DependencyKind::Dependent) {
                let message = "only Real unknowns allow kinds other than dependent".into();
                self.report("dependencies-kind", place, message);
            }
        }
    }
}

/// Whether a variable is among the knowns of a list of the model structure (section 2.2.8).
fn is_known(variable: &Variable, list: List, is_state: bool) -> bool {
    match variable.causality {
        Causality::Input | Causality::Independent => true,
        Causality::Parameter if list == List::InitialUnknowns => true,
        _ if list == List::InitialUnknowns => variable.effective_initial() == Some(Initial::Exact),
        _ => is_state,
    }
}
