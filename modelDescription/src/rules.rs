//! The standard's rules that a schema cannot express (sections 2.2.1 to 2.2.8).

use crate::description::{ModelDescription, Variable};
use crate::legality::{allows_start, is_legal, needs_start};
use crate::table::{is_c_identifier, is_file_name};
use crate::units::Unit;
use crate::vocabulary::{Causality, Initial, Kind, Value, Variability};
use std::collections::{BTreeMap, BTreeSet};

mod aliases;
mod names;
mod place;
mod structure;

pub use place::{FindingPlace, List};

/// A breach of a rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The rule's name, stable for scripts.
    pub rule: &'static str,
    /// The element it is about.
    pub place: FindingPlace,
    /// The variable it is about, if any.
    pub variable: Option<String>,
    /// The violation.
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
        let states = self.variables.iter().filter_map(|v| v.derivative).collect();
        // Reversed, so that the first of a name counts.
        let units = self.units.iter().rev().map(|unit| (unit.name.as_str(), unit)).collect();
        let mut check = Check { description: self, states, units, findings: Vec::new() };
        check.header();
        check.variables();
        check.aliases();
        check.names();
        check.structure();
        check.findings
    }
}

struct Check<'a> {
    description: &'a ModelDescription,
    /// Indices of the variables of which another one is the derivative.
    states: BTreeSet<u32>,
    /// Units by name.
    units: BTreeMap<&'a str, &'a Unit>,
    findings: Vec<Finding>,
}

impl Check<'_> {
    fn report(&mut self, rule: &'static str, place: FindingPlace, message: String) {
        let variable = match place {
            FindingPlace::Variable(position) => self.description.variables.get(position),
            FindingPlace::Unknown { list, position } => {
                let unknown = list.unknowns(self.description).get(position);
                unknown.and_then(|unknown| self.description.variable_at(unknown.index))
            }
            _ => None,
        };
        let variable = variable.map(|v| v.name.clone());
        self.findings.push(Finding { rule, place, variable, message });
    }

    fn header(&mut self) {
        let description = self.description;
        if description.co_simulation.is_none() && description.model_exchange.is_none() {
            self.report(
                "interface",
                FindingPlace::Root,
                "neither CoSimulation nor ModelExchange".into(),
            );
        }
        if let Some(c) = &description.co_simulation {
            let identifier = &c.model_identifier;
            if !is_file_name(identifier) {
                let message = format!("modelIdentifier \"{identifier}\" is not the name of a file");
                self.report("model-identifier-path", FindingPlace::CoSimulation, message);
            } else if !is_c_identifier(identifier) {
                let message = format!("modelIdentifier \"{identifier}\" is not a C identifier");
                self.report("model-identifier", FindingPlace::CoSimulation, message);
            }
            if c.can_serialize_fmu_state && !c.can_get_and_set_fmu_state {
                let message = "canSerializeFMUstate without canGetAndSetFMUstate".into();
                self.report("serialize-needs-get-and-set", FindingPlace::CoSimulation, message);
            }
        }
        if let Some(e) = description.default_experiment {
            if let (start, Some(stop)) = (e.start_time.unwrap_or(0.0), e.stop_time)
                && stop < start
            {
                let message = format!("stopTime {stop} is before startTime {start}");
                self.report("stop-before-start", FindingPlace::DefaultExperiment, message);
            }
            for (name, value) in [("stepSize", e.step_size), ("tolerance", e.tolerance)] {
                if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                    let message = format!("{name} {value} is not positive");
                    self.report("experiment", FindingPlace::DefaultExperiment, message);
                }
            }
        }
        let categories = description.log_categories.iter().map(|category| category.name.as_str());
        self.unique("log-category-twice", categories, FindingPlace::LogCategory);
        let units = description.units.iter().map(|unit| unit.name.as_str());
        self.unique("unit-twice", units, FindingPlace::Unit);
        for (unit, position) in description.units.iter().zip(0..) {
            let names = unit.display_units.iter().map(|display| display.name.as_str());
            self.unique("display-unit-twice", names, |display| FindingPlace::DisplayUnit {
                unit: position,
                position: display,
            });
        }
        let tools =
            description.vendor_annotations.iter().map(|annotation| annotation.tool.as_str());
        self.unique("annotation-twice", tools, FindingPlace::VendorAnnotation);
    }

    fn unique<'n>(
        &mut self,
        rule: &'static str,
        names: impl Iterator<Item = &'n str>,
        place: impl Fn(usize) -> FindingPlace,
    ) {
        let mut seen = BTreeSet::new();
        for (name, position) in names.zip(0..) {
            if !seen.insert(name) {
                self.report(rule, place(position), format!("\"{name}\" is defined twice"));
            }
        }
    }

    fn variables(&mut self) {
        let description = self.description;
        let mut names = BTreeSet::new();
        let mut independent = false;
        let only_co_simulation = description.model_exchange.is_none();
        for (variable, position) in description.variables.iter().zip(0..) {
            let place = FindingPlace::Variable(position);
            if !names.insert(&variable.name) {
                self.report("name-twice", place, "the name is used twice".into());
            }
            if variable.causality == Causality::Independent
                && std::mem::replace(&mut independent, true)
            {
                let message = "a second independent variable".into();
                self.report("independent-twice", place, message);
            }
            if variable.can_handle_multiple_set.is_some() && only_co_simulation {
                let message = "canHandleMultipleSetPerTimeInstant is only for ModelExchange".into();
                self.report("multiple-set", place, message);
            }
            self.variable(variable, place);
            self.derivative(variable, place);
        }
    }

    /// The variable whose derivative this one is declared to be.
    fn derivative(&mut self, v: &Variable, place: FindingPlace) {
        let Some(index) = v.derivative else { return };
        let message = match self.description.variable_at(index) {
            None => format!("derivative of index {index}, which is not a variable"),
            Some(state) if std::ptr::eq(state, v) => "derivative of itself".into(),
            Some(state) if state.kind != Kind::Real => {
                format!("derivative of `{}`, which is {}", state.name, state.kind)
            }
            Some(_) => return,
        };
        self.report("derivative-reference", place, message);
    }

    fn variable(&mut self, v: &Variable, place: FindingPlace) {
        if !is_legal(v.causality, v.variability, v.initial) {
            let initial = v.initial.map_or("absent", Initial::as_str);
            let message = format!(
                "causality {}, variability {} and initial {initial} do not go together",
                v.causality, v.variability
            );
            self.report("illegal-combination", place, message);
        } else if v.start.is_none() && needs_start(v.causality, v.effective_initial()) {
            self.report("start-missing", place, "a start value is required".into());
        } else if v.start.is_some() && !allows_start(v.causality, v.effective_initial()) {
            self.report("start-forbidden", place, "a start value is forbidden".into());
        }
        if v.kind != Kind::Real && v.variability == Variability::Continuous {
            let message = format!("a variable of type {} is continuous", v.kind);
            self.report("continuous-not-real", place, message);
        }
        if let (Some(min), Some(max)) = (v.min, v.max)
            && min > max
        {
            self.report("min-above-max", place, format!("min {min} exceeds max {max}"));
        }
        if let Some(start) = v.start.as_ref().and_then(Value::as_number) {
            let (min, max) = (v.min.unwrap_or(f64::NEG_INFINITY), v.max.unwrap_or(f64::INFINITY));
            // Written so that NaN fails; limits that contradict each other are reported above.
            if min <= max && !(start >= min && start <= max) {
                let message = format!("start {start} is not within [{min}, {max}]");
                self.report("start-outside-limits", place, message);
            }
        }
        if let Some(nominal) = v.nominal.filter(|nominal| nominal.is_nan() || *nominal <= 0.0) {
            self.report("nominal", place, format!("nominal {nominal} is not positive"));
        }
        self.units(v, place);
    }

    fn units(&mut self, v: &Variable, place: FindingPlace) {
        match (&v.unit, &v.display_unit) {
            (None, None) => {}
            (None, Some(display)) => {
                let message = format!("displayUnit \"{display}\" without a unit");
                self.report("display-unit-without-unit", place, message);
            }
            (Some(unit), display) => {
                let Some(defined) = self.units.get(unit.as_str()) else {
                    let message = format!("unit \"{unit}\" is not defined under UnitDefinitions");
                    return self.report("unit-undefined", place, message);
                };
                if let Some(display) = display
                    && display != unit
                    && defined.display_units.iter().all(|known| known.name != *display)
                {
                    let message = format!("unit \"{unit}\" has no displayUnit \"{display}\"");
                    self.report("display-unit-undefined", place, message);
                }
            }
        }
    }
}
