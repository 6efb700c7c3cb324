//! modelDescription.xml for an importer, with lookup of variables by name.

use std::collections::HashMap;

use model_description::{CoSimulation, ModelDescription, Variable, is_file_name};

use crate::Error;
use crate::names::near;

/// An FMU for co-simulation as its modelDescription.xml describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    description: ModelDescription,
    co_simulation: CoSimulation,
    by_name: HashMap<String, usize>,
}

impl Model {
    /// Reads modelDescription.xml; `archive` is for messages.
    pub(crate) fn read(xml: &str, archive: &str) -> Result<Self, Error> {
        let archive = || archive.to_owned();
        let description = ModelDescription::from_xml(xml)
            .map_err(|source| Error::ModelDescription { archive: archive(), source })?;
        let Some(co_simulation) = description.co_simulation.clone() else {
            return Err(Error::NotCoSimulation { archive: archive() });
        };
        // A name without separators: the path of the binary stays in its folder.
        let identifier = &co_simulation.model_identifier;
        if !is_file_name(identifier) {
            let got = identifier.clone();
            return Err(Error::BadModelIdentifier { archive: archive(), got });
        }
        let mut by_name = HashMap::new();
        for (index, variable) in description.variables.iter().enumerate() {
            if by_name.insert(variable.name.clone(), index).is_some() {
                let name = variable.name.clone();
                return Err(Error::DuplicateVariable { archive: archive(), name });
            }
        }
        Ok(Self { description, co_simulation, by_name })
    }

    /// All of modelDescription.xml.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// Its co-simulation side: the name and capabilities of the binary.
    #[must_use]
    pub fn co_simulation(&self) -> &CoSimulation {
        &self.co_simulation
    }

    /// The variables, in their order in the file.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.description.variables
    }

    /// A variable by name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.by_name.get(name).map(|index| &self.description.variables[*index])
    }

    /// A value that is given in a unit, as a variable takes it; `None` where the FMU does not
    /// relate that unit to the variable's.
    #[must_use]
    pub fn converted(&self, variable: &Variable, value: f64, unit: &str) -> Option<f64> {
        let of_variable = variable.unit.as_deref()?;
        if unit == of_variable {
            return Some(value);
        }
        crate::units::converted(value, unit, of_variable, &self.description.units, &[])
    }

    /// Names near a misspelt one.
    pub(crate) fn near(&self, name: &str) -> Vec<String> {
        near(name, self.variables().iter().map(|v| v.name.as_str()))
    }
}
