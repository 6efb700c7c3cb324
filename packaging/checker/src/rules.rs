//! All rules: name, severity, section of FMI 2.0.5, and how to correct a violation.

use serde::Serialize;

/// The severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Information, not a violation.
    Note,
    /// A violation of a recommendation of the standard, or a problem for importers.
    Warning,
    /// A violation of the standard.
    Error,
}

impl std::fmt::Display for Severity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// A rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rule {
    /// Its name, stable for scripts.
    pub name: &'static str,
    /// The severity of a violation.
    pub severity: Severity,
    /// The section of FMI 2.0.5.
    pub section: &'static str,
    /// How to correct a violation.
    pub hint: &'static str,
}

/// The rule of a name. The tests exclude unknown names.
pub(crate) fn rule(name: &'static str) -> &'static Rule {
    RULES.iter().find(|rule| rule.name == name).unwrap_or(&UNKNOWN)
}

const UNKNOWN: Rule = error("unknown-rule", "2", "report it to the authors of the checker");

const fn error(name: &'static str, section: &'static str, hint: &'static str) -> Rule {
    Rule { name, severity: Severity::Error, section, hint }
}

const fn warning(name: &'static str, section: &'static str, hint: &'static str) -> Rule {
    Rule { name, severity: Severity::Warning, section, hint }
}

const fn note(name: &'static str, section: &'static str, hint: &'static str) -> Rule {
    Rule { name, severity: Severity::Note, section, hint }
}

const ZIP: &str =
    "write the archive again with a plain zip writer: deflate or store, no extensions";
const CUT: &str =
    "the file is damaged or no FMU: name an .fmu file, or download or export it again";
const XSD: &str = "validate modelDescription.xml with fmi2ModelDescription.xsd";
const LIMIT: &str = "a limit of the checker, not of FMI: what exceeds it is not checked";
const RUN: &str = "correct the binary: its behaviour violates the standard";

/// Every rule, in the order in which archives are checked.
pub static RULES: &[Rule] = &[
    // Limits of the checker.
    warning("not-examined", "2.3", LIMIT),
    // The archive.
    error("file-extension", "2.3", "name the file with the ending .fmu"),
    error("zip-unreadable", "2.3", CUT),
    error("zip-split", "2.3", "write the archive as one file"),
    error("zip-version", "2.3", ZIP),
    error("zip-method", "2.3", ZIP),
    error("zip-encrypted", "2.3", "write the archive without encryption"),
    error("zip-stored-descriptor", "2.3", "write the sizes of stored entries before their data"),
    error("zip-link", "2.3", "replace the link with a copy of the file"),
    error("zip-backslash", "2.3", "separate folders with forward slashes"),
    error("zip-unsafe-name", "2.3", "use relative paths without .. for entries"),
    warning(
        "zip-dot-name",
        "2.3",
        "write names without the part \".\": not every importer finds them",
    ),
    error("zip-duplicate", "2.3", "give each entry a unique name"),
    error("zip-local-header", "2.3", CUT),
    error("zip-entry-damaged", "2.3", CUT),
    error("zip-overlap", "2.3", CUT),
    warning("zip-outside-data", "2.3", "remove them: some importers read from the file's start"),
    warning("zip-case-collision", "2.3", "rename one: on Windows and macOS they are the same file"),
    warning("zip-name-encoding", "2.3", "mark names as UTF-8 (general purpose bit 11)"),
    warning("zip-non-ascii", "2.3", "use ASCII names, as the standard recommends"),
    // The description's text.
    error("no-description", "2.3", "put modelDescription.xml at the top of the archive"),
    error("xml-undecodable", "2.2", "write the description again, in UTF-8"),
    error("xml-encoding", "2.2", "use UTF-8 and <?xml version=\"1.0\" encoding=\"UTF-8\"?>"),
    error("xml-refused", "2.2", "export the FMU again: no modeling tool writes such a description"),
    error("xml-malformed", "2.2", "correct the description: it is not well-formed XML"),
    error("xml-unreadable", "2.2", XSD),
    // The schema.
    error("xsd-element", "2.2", XSD),
    error("xsd-element-missing", "2.2", XSD),
    error("xsd-attribute", "2.2", XSD),
    error("xsd-attribute-missing", "2.2", XSD),
    error("xsd-value", "2.2", XSD),
    error("xsd-text", "2.2", XSD),
    error("special-value", "2.2", "omit the attribute, or use a finite number"),
    // The model as a whole.
    error("interface", "2.2.1", "declare <CoSimulation>"),
    error("interface-twice", "2.2.1", "declare each interface once"),
    error("not-co-simulation", "4.3.1", "export the model for co-simulation too"),
    error("model-identifier-path", "4.3.1", "use a name, not a path, for the binary"),
    warning(
        "model-identifier",
        "4.3.1",
        "use letters, digits and _, and do not begin with a digit: it is a prefix in sources",
    ),
    error("serialize-needs-get-and-set", "4.3.1", "declare canGetAndSetFMUstate too"),
    error("guid-empty", "2.2.1", "use a unique text in the XML and in the binary"),
    note("guid-braces", "2.2.1", "omit the braces: one importer encodes them twice and fails"),
    warning("date-format", "2.2.1", "write the date as 2009-12-08T14:33:22Z"),
    // Units.
    error("unit-twice", "2.2.2", "define each unit once"),
    error("display-unit-twice", "2.2.2", "define each display unit of a unit once"),
    warning("unit-factor", "2.2.2", "use a factor other than zero"),
    error("fmi-version", "2.2.1", "use a checker for that version, or export as FMI 2.0"),
    // Types.
    error("type-twice", "2.2.3", "define each type once"),
    error("type-named-as-variable", "2.2.3", "use different names for types and variables"),
    error("enumeration-item-twice", "2.2.3", "use a unique name and value for each item"),
    error("unit-undefined", "2.2.3", "define the unit under UnitDefinitions"),
    error("display-unit-without-unit", "2.2.3", "specify a unit, or omit the display unit"),
    warning("display-unit-undefined", "2.2.3", "define it as DisplayUnit"),
    error("min-above-max", "2.2.3", "set min to at most max"),
    error("nominal", "2.2.3", "use a positive nominal, or omit it"),
    // Categories, experiment, annotations.
    error("log-category-twice", "2.2.4", "define each category once"),
    error("stop-before-start", "2.2.5", "set stopTime to at least startTime (default 0)"),
    error("experiment", "2.2.5", "use a positive number, or omit the attribute"),
    error("annotation-twice", "2.2.6", "write one annotation for each tool"),
    // Variables.
    error("name-twice", "2.2.7", "use a unique name for each variable"),
    warning("name-time", "2.2.7", "declare it as independent, or rename it"),
    error("illegal-combination", "2.2.7", "see the two tables of the section"),
    error("continuous-not-real", "2.2.7", "set another variability: the default is continuous"),
    error("independent-twice", "2.2.7", "declare at most one independent variable"),
    error("multiple-set", "2.2.7", "omit canHandleMultipleSetPerTimeInstant"),
    error("reinit", "2.2.7", "omit reinit"),
    error("start-missing", "2.2.7", "inputs and variables with initial exact or approx need one"),
    error("start-forbidden", "2.2.7", "calculated and independent variables have none"),
    error("start-outside-limits", "2.2.7", "choose a start value with min ≤ start ≤ max"),
    error("alias-both-settable", "2.2.7", "use a unique value reference for each of them"),
    error("alias-start-twice", "2.2.7", "set the start value of one variable of an alias set only"),
    error("alias-constant", "2.2.7", "only constants with equal values can be aliases"),
    error("alias-unit", "2.2.7", "use the same unit for all aliases, or no unit"),
    error("declared-type-undefined", "2.2.7", "define the type under TypeDefinitions"),
    error("declared-type-kind", "2.2.7", "use a declared type of the variable's own kind"),
    warning("enumeration-start", "2.2.7", "use the value of an item as start value"),
    error("derivative-reference", "2.2.7", "use the index, from 1, of a Real variable"),
    // Model structure.
    error("structure-index", "2.2.8", "use the index of a ScalarVariable, from 1"),
    error("structure-missing", "2.2.8", "list every variable that the section requires"),
    error("structure-extra", "2.2.8", "list only the variables that the section requires"),
    error("structure-twice", "2.2.8", "list each variable once"),
    error("initial-unknowns-order", "2.2.8", "sort InitialUnknowns by index"),
    error("derivatives-attribute", "2.2.7", "add the attribute derivative to the variable"),
    error("state-not-continuous", "2.2.8", "declare states and derivatives as continuous Reals"),
    error("state-causality", "2.2.7", "declare a state as local or output"),
    error("dependencies-order", "2.2.8", "sort dependencies by index, each once"),
    error("dependency-unknown", "2.2.8", "use the index of a ScalarVariable, from 1"),
    error("dependency-no-known", "2.2.8", "list inputs, states, or variables with initial exact"),
    warning("dependency-on-state", "2.2.8", "list states only if the model has derivatives"),
    error("dependencies-kind", "2.2.8", "see the section for the kinds that each list allows"),
    error("dependencies-kind-count", "2.2.8", "list one kind for each dependency"),
    // Names.
    error("name-empty", "2.2.9", "name the variable"),
    error("name-characters", "2.2.9", "remove line breaks and tabs"),
    error("name-structured", "2.2.9", "follow the grammar, or declare names as flat"),
    error("array-order", "2.2.9", "list array elements consecutively, in row-major order"),
    // The folders.
    error("no-implementation", "2.3", "add a binary or the sources"),
    error("binary-name", "2.3", "name it <modelIdentifier>.dll, .so or .dylib"),
    note("platform-name", "2.3", "importers recognise win32, win64, linux32, linux64, darwin64 …"),
    error("source-missing", "2.3", "add every file that SourceFiles lists to sources/"),
    error("source-name", "2.2.1", "write a relative path with forward slashes"),
    error("sources-unlisted", "2.3", "list the files to compile under SourceFiles"),
    warning("source-header", "2.3", "remove the FMI headers: the importer provides them"),
    note("no-documentation", "2.3", "add documentation/index.html"),
    warning("documentation-entry", "2.3", "use documentation/index.html as entry page"),
    warning("license-entry", "2.3", "use documentation/licenses/license.txt or .html"),
    warning("icon", "2.3", "store model.png as a PNG image"),
    error("terminals", "2.3", "write terminalsAndIcons/terminalsAndIcons.xml as well-formed XML"),
    warning("extra-name", "2.3.1", "use a reversed domain, such as extra/com.example/"),
    note("unknown-entry", "2.3", "move it to extra/ or resources/"),
    // The binaries.
    error("binary-format", "2.3", "build a shared library for the platform of the folder"),
    error("binary-functions", "2.3", "export all functions, even of unsupported capabilities"),
    warning(
        "binary-dependencies",
        "2.3",
        "link statically, or document it in externalDependencies.txt",
    ),
    note("binary-glibc", "2.3", ""),
    note("binary-needs", "2.3", ""),
    note("binary-build-path", "2.3", ""),
    // The running binary.
    note("run-skipped", "2.3", ""),
    note("run-span", "2.2.5", ""),
    error("run-load", "2.3", "the libraries of archive and system must suffice for loading"),
    error("run-version", "2.1.4", "fmi2GetVersion is 2.0, fmi2GetTypesPlatform is default"),
    error("run-instantiate", "2.1.5", RUN),
    error("run-guid", "2.1.5", "compare the GUID and return NULL if it differs"),
    error("run-null", "2.1.5", "ignore a NULL instance in fmi2FreeInstance"),
    error("run-crash", "2.1", RUN),
    error("run-hang", "2.1", RUN),
    error("run-call", "4.2.4", RUN),
    error("run-start", "2.2.7", "use the same start values in the XML and in the binary"),
    note("run-start-rounding", "2.2.7", ""),
    error("run-value", "2.1.7", "return finite numbers"),
    error("run-reset", "2.1.6", "restore the state after fmi2Instantiate in fmi2Reset"),
    error("run-state", "2.1.8", "restore everything that later calls depend on"),
    warning("run-nondeterministic", "2.1.6", "seed random numbers by a parameter, also at reset"),
    error("run-instances", "4.3.1", "avoid global data, or allow one instance per process"),
    error("run-step-size", "4.3.1", "do not declare canHandleVariableCommunicationStepSize"),
    error("run-dependency", "2.2.8", "list the input among the output's dependencies"),
    note("run-output", "2.1.5", ""),
    error("run-log-category", "2.1.5", "use only categories that LogCategories lists"),
    error(
        "run-reference",
        "4.2",
        "build the binary and the reference from the same model, or record the reference again",
    ),
    error("run-reference-form", "2.3.1", "correct reference.json and its tables"),
    note("run-reference-difference", "4.2", ""),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn rule_names_are_unique_and_violations_have_hints() {
        let names: BTreeSet<&str> = RULES.iter().map(|rule| rule.name).collect();
        assert_eq!(names.len(), RULES.len());
        for rule in RULES {
            assert!(rule.severity == Severity::Note || !rule.hint.is_empty(), "{}", rule.name);
        }
    }
}
