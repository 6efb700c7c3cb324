//! The static table of an FMU's variables: written once, checked by the compiler.
//!
//! Every function here is `const`: in a `const` or `static` item a row or table that the standard
//! forbids stops the compilation with the message of the assertion that failed.

use crate::legality::{default_initial, is_legal};
use crate::units::{UnitSpec, same};
use crate::vocabulary::{Causality, Initial, Kind, Variability};

/// The dependencies of an unknown, by the names of variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DependsOn {
    /// Nothing: an empty list in the XML.
    Nothing,
    /// Everything: no list in the XML.
    All,
    /// These variables.
    On(&'static [&'static str]),
}

/// One variable of a static table. Made by [`VariableSpec::new`] and the setters after it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // the names are those of the standard
pub struct VariableSpec {
    pub name: &'static str,
    /// Value reference, unique over all types.
    pub reference: u32,
    pub kind: Kind,
    pub causality: Causality,
    pub variability: Variability,
    /// How it is initialized; `None` is the standard's default.
    pub initial: Option<Initial>,
    /// Unit, one of [`crate::UNITS`]; only Real variables.
    pub unit: Option<&'static str>,
    pub display_unit: Option<&'static str>,
    /// Smallest value; Real and Integer.
    pub min: Option<f64>,
    /// Largest value; Real and Integer.
    pub max: Option<f64>,
    /// Typical magnitude; only Real variables.
    pub nominal: Option<f64>,
    pub description: &'static str,
    /// Dependencies of an output at a communication point: inputs only.
    pub depends_on: DependsOn,
    /// Dependencies of an output or calculated parameter in initialization mode: inputs, and
    /// variables with `initial="exact"`.
    pub initial_depends_on: DependsOn,
}

/// Declares the constructors of the types.
macro_rules! of_kind {
    ($($name:ident: $kind:ident;)*) => {$(
        #[doc = concat!("A variable of type ", stringify!($kind), "; see [`VariableSpec::new`].")]
        #[must_use]
        pub const fn $name(
            name: &'static str,
            reference: u32,
            causality: Causality,
            variability: Variability,
        ) -> Self {
            Self::new(name, reference, Kind::$kind, causality, variability)
        }
    )*};
}

impl VariableSpec {
    /// A variable with the default `initial`, no unit and no limits, that depends on everything.
    #[must_use]
    pub const fn new(
        name: &'static str,
        reference: u32,
        kind: Kind,
        causality: Causality,
        variability: Variability,
    ) -> Self {
        assert!(!name.is_empty(), "a variable needs a name");
        assert!(
            is_legal(causality, variability, None),
            "FMI 2.0 forbids this combination of causality and variability"
        );
        assert!(
            matches!(kind, Kind::Real) || !matches!(variability, Variability::Continuous),
            "only Real variables are continuous"
        );
        assert!(
            !matches!(causality, Causality::Independent),
            "no independent variable here: importers misread it"
        );
        Self {
            name,
            reference,
            kind,
            causality,
            variability,
            initial: None,
            unit: None,
            display_unit: None,
            min: None,
            max: None,
            nominal: None,
            description: "",
            depends_on: DependsOn::All,
            initial_depends_on: DependsOn::All,
        }
    }

    of_kind! { real: Real; integer: Integer; boolean: Boolean; string: String; }

    /// Sets how it is initialized.
    #[must_use]
    pub const fn initial(mut self, initial: Initial) -> Self {
        assert!(
            is_legal(self.causality, self.variability, Some(initial)),
            "FMI 2.0 forbids this `initial` with this causality and variability"
        );
        self.initial = Some(initial);
        self
    }

    /// Sets the unit, one of [`crate::UNITS`].
    #[must_use]
    pub const fn unit(mut self, unit: &'static str) -> Self {
        assert!(matches!(self.kind, Kind::Real), "only Real variables have units");
        assert!(UnitSpec::named(unit).is_some(), "this unit is not in UNITS");
        self.unit = Some(unit);
        self
    }

    /// Sets the unit to show it in, one of its unit's display units.
    #[must_use]
    pub const fn display_unit(mut self, display_unit: &'static str) -> Self {
        let known = match self.unit {
            None => false,
            Some(unit) => match UnitSpec::named(unit) {
                None => false,
                Some(unit) => unit.shows_as(display_unit),
            },
        };
        assert!(known, "the unit, set before this, has no such display unit in UNITS");
        self.display_unit = Some(display_unit);
        self
    }

    /// Sets the smallest value.
    #[must_use]
    pub const fn min(mut self, min: f64) -> Self {
        assert!(matches!(self.kind, Kind::Real | Kind::Integer), "only numbers have a minimum");
        assert!(min.is_finite(), "the minimum is not finite");
        self.min = Some(min);
        self.limits_in_order()
    }

    /// Sets the largest value.
    #[must_use]
    pub const fn max(mut self, max: f64) -> Self {
        assert!(matches!(self.kind, Kind::Real | Kind::Integer), "only numbers have a maximum");
        assert!(max.is_finite(), "the maximum is not finite");
        self.max = Some(max);
        self.limits_in_order()
    }

    const fn limits_in_order(self) -> Self {
        if let (Some(min), Some(max)) = (self.min, self.max) {
            assert!(min <= max, "the minimum is above the maximum");
        }
        self
    }

    /// Sets the typical magnitude.
    #[must_use]
    pub const fn nominal(mut self, nominal: f64) -> Self {
        assert!(matches!(self.kind, Kind::Real), "only Real variables have a nominal value");
        assert!(nominal.is_finite() && nominal > 0.0, "the nominal value is not above zero");
        self.nominal = Some(nominal);
        self
    }

    /// Sets the description.
    #[must_use]
    pub const fn description(mut self, description: &'static str) -> Self {
        self.description = description;
        self
    }

    /// Sets the dependencies of an output at a communication point.
    #[must_use]
    pub const fn depends_on(mut self, depends_on: DependsOn) -> Self {
        self.depends_on = depends_on;
        self
    }

    /// Sets the dependencies of an output or calculated parameter in initialization mode.
    #[must_use]
    pub const fn initial_depends_on(mut self, depends_on: DependsOn) -> Self {
        self.initial_depends_on = depends_on;
        self
    }

    /// The `initial` that holds: the one given or the standard's default.
    #[must_use]
    pub const fn effective_initial(&self) -> Option<Initial> {
        match self.initial {
            Some(initial) => Some(initial),
            None => default_initial(self.causality, self.variability),
        }
    }
}

/// Everything static about an FMU.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    /// Name of the model and `modelIdentifier`: a C identifier.
    pub model_name: &'static str,
    /// Version of the code; part of the GUID.
    pub version: &'static str,
    /// A description of one line.
    pub description: &'static str,
    /// The variables, in the order of the XML.
    pub variables: &'static [VariableSpec],
}

impl Table {
    /// A table whose rows are legal, whose names and value references are unique, and whose
    /// dependencies name knowns of the standard (section 2.2.8).
    #[must_use]
    pub const fn new(
        model_name: &'static str,
        version: &'static str,
        description: &'static str,
        variables: &'static [VariableSpec],
    ) -> Self {
        assert!(is_c_identifier(model_name), "the model's name is not a C identifier");
        let mut i = 0;
        while i < variables.len() {
            let row = &variables[i];
            assert!(
                is_legal(row.causality, row.variability, row.initial),
                "FMI 2.0 forbids a combination of causality, variability and initial"
            );
            let mut j = i + 1;
            while j < variables.len() {
                assert!(
                    row.reference != variables[j].reference,
                    "two variables share a value reference"
                );
                assert!(!same(row.name, variables[j].name), "two variables share a name");
                j += 1;
            }
            if let DependsOn::On(names) = row.depends_on {
                assert!(
                    matches!(row.causality, Causality::Output),
                    "only outputs have dependencies at communication points"
                );
                assert!(
                    all_known(variables, names, false),
                    "an output depends on a variable that is not an input"
                );
            }
            if let DependsOn::On(names) = row.initial_depends_on {
                assert!(
                    all_known(variables, names, true),
                    "an initial dependency is neither an input nor initial=\"exact\""
                );
            }
            i += 1;
        }
        Self { model_name, version, description, variables }
    }

    /// The row with that name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&'static VariableSpec> {
        self.variables.iter().find(|row| row.name == name)
    }
}

/// Whether every name is an input's or, in initialization mode, of a variable with `initial="exact"`.
const fn all_known(variables: &[VariableSpec], names: &[&str], initialization: bool) -> bool {
    let mut i = 0;
    while i < names.len() {
        let mut found = false;
        let mut j = 0;
        while j < variables.len() {
            let row = &variables[j];
            if same(row.name, names[i]) {
                found = matches!(row.causality, Causality::Input)
                    || (initialization && matches!(row.effective_initial(), Some(Initial::Exact)));
            }
            j += 1;
        }
        if !found {
            return false;
        }
        i += 1;
    }
    true
}

/// Whether the text can be the name of a file in a folder: a plain name, without a way to another folder.
#[must_use]
pub fn is_file_name(text: &str) -> bool {
    !matches!(text.trim(), "" | "." | "..") && !text.contains(['/', '\\', ':', '\0'])
}

/// Whether the text is a letter or underscore followed by letters, digits and underscores.
#[must_use]
pub const fn is_c_identifier(text: &str) -> bool {
    let bytes = text.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        let letter = bytes[i].is_ascii_alphabetic() || bytes[i] == b'_';
        if !letter && (i == 0 || !bytes[i].is_ascii_digit()) {
            return false;
        }
        i += 1;
    }
    !bytes.is_empty()
}
