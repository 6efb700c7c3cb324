//! The standard's rules that a schema cannot express (sections 2.2.1 to 2.2.8).

use crate::description::{ModelDescription, Unknown, Variable};
use crate::table::is_c_identifier;
use crate::{
    Causality, DependencyKind, Initial, Kind, Variability, allows_start, is_legal, needs_start,
};
use std::collections::{BTreeMap, BTreeSet};

/// A breach of a rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The rule's name, stable for scripts.
    pub rule: &'static str,
    /// The variable it is about, if any.
    pub variable: Option<String>,
    /// What is wrong.
    pub message: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.variable {
            Some(variable) => write!(f, "{}: `{variable}`: {}", self.rule, self.message),
            None => write!(f, "{}: {}", self.rule, self.message),
        }
    }
}

impl ModelDescription {
    /// Every breach of the standard's rules, in the order of the document.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let mut check = Check { description: self, findings: Vec::new() };
        check.header();
        check.variables();
        check.structure();
        check.findings
    }
}

struct Check<'a> {
    description: &'a ModelDescription,
    findings: Vec<Finding>,
}

impl Check<'_> {
    fn report(&mut self, rule: &'static str, variable: Option<&str>, message: String) {
        self.findings.push(Finding { rule, variable: variable.map(Into::into), message });
    }

    fn header(&mut self) {
        let description = self.description;
        if description.co_simulation.is_none() && description.model_exchange.is_none() {
            self.report("interface", None, "neither CoSimulation nor ModelExchange".into());
        }
        if let Some(c) = &description.co_simulation {
            if !is_c_identifier(&c.model_identifier) {
                let message =
                    format!("modelIdentifier \"{}\" is no C identifier", c.model_identifier);
                self.report("model-identifier", None, message);
            }
            if c.can_serialize_fmu_state && !c.can_get_and_set_fmu_state {
                let message = "canSerializeFMUstate without canGetAndSetFMUstate".into();
                self.report("serialize-needs-get-and-set", None, message);
            }
        }
        if let Some(e) = description.default_experiment {
            if let (start, Some(stop)) = (e.start_time.unwrap_or(0.0), e.stop_time)
                && stop < start
            {
                let message = format!("stopTime {stop} is before startTime {start}");
                self.report("stop-before-start", None, message);
            }
            for (name, value) in [("stepSize", e.step_size), ("tolerance", e.tolerance)] {
                if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                    self.report("experiment", None, format!("{name} {value} is not above zero"));
                }
            }
        }
        let categories = description.log_categories.iter().map(|category| &category.name);
        self.unique("log-category-twice", categories);
        self.unique("unit-twice", description.units.iter().map(|unit| &unit.name));
        for unit in &description.units {
            let names = unit.display_units.iter().map(|display| &display.name);
            self.unique("display-unit-twice", names);
        }
    }

    fn unique<'n>(&mut self, rule: &'static str, names: impl Iterator<Item = &'n String>) {
        let mut seen = BTreeSet::new();
        for name in names {
            if !seen.insert(name) {
                self.report(rule, None, format!("\"{name}\" stands there twice"));
            }
        }
    }

    fn variables(&mut self) {
        let description = self.description;
        let mut names = BTreeSet::new();
        let mut starts = BTreeMap::new();
        for variable in &description.variables {
            if !names.insert(&variable.name) {
                let message = "the name stands there twice".to_owned();
                self.report("name-twice", Some(&variable.name), message);
            }
            // Aliases are variables of one type that share a reference.
            if variable.start.is_some() && variable.variability != Variability::Constant {
                let key = (variable.kind.as_str(), variable.reference);
                if let Some(other) = starts.insert(key, &variable.name) {
                    let message = format!("its alias `{other}` has a start value too");
                    self.report("alias-start-twice", Some(&variable.name), message);
                }
            }
            self.variable(variable);
        }
        let independent =
            description.variables.iter().filter(|v| v.causality == Causality::Independent).count();
        if independent > 1 {
            let message = format!("{independent} independent variables, at most one is allowed");
            self.report("independent-twice", None, message);
        }
    }

    fn variable(&mut self, v: &Variable) {
        let name = Some(v.name.as_str());
        if !is_legal(v.causality, v.variability, v.initial) {
            let initial = v.initial.map_or("absent", Initial::as_str);
            let message = format!(
                "causality {}, variability {} and initial {initial} do not go together",
                v.causality, v.variability
            );
            self.report("illegal-combination", name, message);
        } else if v.start.is_none() && needs_start(v.causality, v.effective_initial()) {
            self.report("start-missing", name, "a start value is required".into());
        } else if v.start.is_some() && !allows_start(v.causality, v.effective_initial()) {
            self.report("start-forbidden", name, "a start value is forbidden".into());
        }
        if v.kind != Kind::Real && v.variability == Variability::Continuous {
            let message = format!("a variable of type {} is continuous", v.kind);
            self.report("continuous-not-real", name, message);
        }
        if let (Some(min), Some(max)) = (v.min, v.max)
            && min > max
        {
            self.report("min-above-max", name, format!("min {min} is above max {max}"));
        }
        if let Some(start) = v.start.as_ref().and_then(crate::Value::as_number) {
            let (min, max) = (v.min.unwrap_or(f64::NEG_INFINITY), v.max.unwrap_or(f64::INFINITY));
            // Written so that NaN fails.
            if !(start >= min && start <= max) {
                let message = format!("start {start} is not within [{min}, {max}]");
                self.report("start-outside-limits", name, message);
            }
        }
        self.units(v);
    }

    fn units(&mut self, v: &Variable) {
        let name = Some(v.name.as_str());
        let description = self.description;
        match (&v.unit, &v.display_unit) {
            (None, None) => {}
            (None, Some(display)) => {
                let message = format!("displayUnit \"{display}\" without a unit");
                self.report("display-unit-without-unit", name, message);
            }
            (Some(unit), display) => {
                let Some(defined) = description.units.iter().find(|known| known.name == *unit)
                else {
                    let message = format!("unit \"{unit}\" is not under UnitDefinitions");
                    return self.report("unit-undefined", name, message);
                };
                if let Some(display) = display
                    && display != unit
                    && defined.display_units.iter().all(|known| known.name != *display)
                {
                    let message = format!("unit \"{unit}\" has no displayUnit \"{display}\"");
                    self.report("display-unit-undefined", name, message);
                }
            }
        }
    }

    fn structure(&mut self) {
        let description = self.description;
        let indexed = || description.variables.iter().zip(1_u32..);
        let outputs: Vec<u32> = indexed()
            .filter(|(v, _)| v.causality == Causality::Output)
            .map(|(_, index)| index)
            .collect();
        self.same_set("Outputs", &outputs, &description.outputs);
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
        self.same_set("InitialUnknowns", &initial, &description.initial_unknowns);
        let listed: Vec<u32> = description.initial_unknowns.iter().map(|u| u.index).collect();
        if !listed.is_sorted() {
            let message = "InitialUnknowns are not in ascending order".into();
            self.report("initial-unknowns-order", None, message);
        }
        for (list, unknowns) in [
            ("Outputs", &description.outputs),
            ("Derivatives", &description.derivatives),
            ("InitialUnknowns", &description.initial_unknowns),
        ] {
            for unknown in unknowns {
                self.unknown(list, unknown);
            }
        }
    }

    /// Reports what `list` lacks, has twice or should not have.
    fn same_set(&mut self, list: &'static str, need: &[u32], unknowns: &[Unknown]) {
        let description = self.description;
        let name = |index| description.variable_at(index).map(|v| v.name.as_str());
        let mut listed = BTreeSet::new();
        for unknown in unknowns {
            if !listed.insert(unknown.index) {
                let message = format!("stands twice under {list}");
                self.report("structure-twice", name(unknown.index), message);
            }
        }
        for &index in need.iter().filter(|index| !listed.contains(index)) {
            self.report("structure-missing", name(index), format!("is not under {list}"));
        }
        for &index in listed.iter().filter(|index| !need.contains(index)) {
            let message = format!("index {index} has no place under {list}");
            self.report("structure-extra", name(index), message);
        }
    }

    fn unknown(&mut self, list: &'static str, unknown: &Unknown) {
        let description = self.description;
        let name = description.variable_at(unknown.index).map(|v| v.name.as_str());
        if let Some(dependencies) = &unknown.dependencies {
            if !dependencies.is_sorted_by(|a, b| a < b) {
                let message = format!("its dependencies under {list} do not ascend");
                self.report("dependencies-order", name, message);
            }
            for &index in dependencies {
                let known = description.variable_at(index);
                if known.is_none() {
                    let message = format!("depends under {list} on index {index}, which is none");
                    self.report("dependency-unknown", name, message);
                } else if known.is_some_and(|v| !is_known(v, list, self.is_state(index))) {
                    let message = format!("depends under {list} on index {index}, no known there");
                    self.report("dependency-no-known", name, message);
                }
            }
        }
        if let Some(kinds) = &unknown.kinds {
            let entries = unknown.dependencies.as_ref().map_or(0, Vec::len);
            if kinds.len() != entries {
                let message = format!(
                    "under {list}: {} kinds of dependency for {entries} dependencies",
                    kinds.len()
                );
                self.report("dependencies-kind-count", name, message);
            }
            let plain = |kind: &DependencyKind| {
                matches!(kind, DependencyKind::Dependent | DependencyKind::Constant)
            };
            if list == "InitialUnknowns" && !kinds.iter().all(plain) {
                let message = "InitialUnknowns take only the kinds dependent and constant".into();
                self.report("dependencies-kind", name, message);
            }
        }
    }

    /// Whether some variable is the derivative of this one.
    fn is_state(&self, index: u32) -> bool {
        self.description.variables.iter().any(|v| v.derivative == Some(index))
    }
}

/// Whether a variable is among the knowns of a list of the model structure (section 2.2.8).
fn is_known(variable: &Variable, list: &str, is_state: bool) -> bool {
    match variable.causality {
        Causality::Input | Causality::Independent => true,
        _ if list == "InitialUnknowns" => variable.effective_initial() == Some(Initial::Exact),
        _ => is_state,
    }
}
