//! Every rule: its name, weight, section of FMI 2.0.5 and what to do about a breach.

use crate::finding::Severity;
use serde::Serialize;

/// A rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rule {
    /// Its name, stable for scripts.
    pub name: &'static str,
    /// How much a breach weighs.
    pub severity: Severity,
    /// The section of FMI 2.0.5 it comes from.
    pub section: &'static str,
    /// What to do about a breach.
    pub hint: &'static str,
}

/// The rule of that name. An unknown name, which a test excludes, is a rule of that name's own.
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
const CUT: &str = "the file is damaged or was made to deceive: get or export it again";
const XSD: &str = "hold modelDescription.xml against fmi2ModelDescription.xsd";
const LIMIT: &str = "a limit of the checker, not of FMI: what is beyond it is neither good nor bad";
const RUN: &str = "the author of the binary has to correct it: the behaviour violates the standard";

/// Every rule, in the order in which archives are checked.
pub static RULES: &[Rule] = &[
    // The checker.
    warning("not-examined", "2.3", LIMIT),
    // The archive.
    error("file-extension", "2.3", "name the file with the ending .fmu"),
    error("zip-unreadable", "2.3", CUT),
    error("zip-split", "2.3", "write the archive as one file"),
    error("zip-version", "2.3", ZIP),
    error("zip-method", "2.3", ZIP),
    error("zip-encrypted", "2.3", "write the archive without encryption"),
    error("zip-stored-descriptor", "2.3", "write the sizes of stored entries before their data"),
    error("zip-link", "2.3", "put a copy of the file in the place of the link"),
    error("zip-backslash", "2.3", "separate folders with forward slashes"),
    error("zip-unsafe-name", "2.3", "give entries relative paths without . and .."),
    error("zip-duplicate", "2.3", "give each entry a unique name"),
    error("zip-local-header", "2.3", CUT),
    error("zip-entry-damaged", "2.3", CUT),
    error("zip-overlap", "2.3", CUT),
    warning("zip-outside-data", "2.3", "importers that read from the file's start will fail"),
    warning("zip-case-collision", "2.3", "on Windows and macOS the two are one file"),
    warning("zip-name-encoding", "2.3", "mark names as UTF-8 (general purpose bit 11)"),
    warning("zip-non-ascii", "2.3", "the standard advises against names beyond ASCII"),
    // The description's text.
    error("no-description", "2.3", "put modelDescription.xml at the top of the archive"),
    error(
        "xml-encoding",
        "2.2",
        "begin with <?xml version=\"1.0\" encoding=\"UTF-8\"?> and keep to it",
    ),
    error("xml-refused", "2.2", "export the FMU again: no honest description is like that"),
    error("xml-malformed", "2.2", "the description has to be well-formed XML"),
    error("xml-unreadable", "2.2", XSD),
    // The schema.
    error("xsd-element", "2.2", XSD),
    error("xsd-element-missing", "2.2", XSD),
    error("xsd-attribute", "2.2", XSD),
    error("xsd-attribute-missing", "2.2", XSD),
    error("xsd-value", "2.2", XSD),
    error("xsd-text", "2.2", XSD),
    error("special-value", "2.2", "leave the attribute out, or give a finite number"),
    // The model as a whole.
    error("interface", "2.2.1", "declare <CoSimulation>"),
    error("interface-twice", "2.2.1", "declare each interface once"),
    error("not-co-simulation", "4.3.1", "export the model for co-simulation too"),
    error("model-identifier", "4.3.1", "use letters, digits and _, and begin with no digit"),
    error("serialize-needs-get-and-set", "4.3.1", "declare canGetAndSetFMUstate too, or neither"),
    error("guid-empty", "2.2.1", "give the XML and the binary a unique text"),
    note("guid-braces", "2.2.1", "one importer encodes braces twice and then refuses the binary"),
    warning("date-format", "2.2.1", "write it as 2009-12-08T14:33:22Z"),
    // Units.
    error("unit-twice", "2.2.2", "define each unit once"),
    error("display-unit-twice", "2.2.2", "define each display unit of a unit once"),
    warning("unit-factor", "2.2.2", "a factor of zero cannot be converted back"),
    error("fmi-version", "2.2.1", "take a checker for that version, or export as FMI 2.0"),
    // Types.
    error("type-twice", "2.2.3", "define each type once"),
    error("type-named-as-variable", "2.2.3", "name types otherwise than variables"),
    error("enumeration-item-twice", "2.2.3", "give each item its own name and value"),
    error("unit-undefined", "2.2.3", "define the unit under UnitDefinitions"),
    error("display-unit-without-unit", "2.2.3", "give a unit, or no display unit"),
    warning("display-unit-undefined", "2.2.3", "define it as DisplayUnit; it is ignored as it is"),
    error("min-above-max", "2.2.3", "let min be at most max"),
    error("nominal", "2.2.3", "give a nominal above zero, or none"),
    // Categories, experiment, annotations.
    error("log-category-twice", "2.2.4", "define each category once"),
    error("stop-before-start", "2.2.5", "let stopTime be at least startTime (0 if absent)"),
    error("experiment", "2.2.5", "give a positive number, or leave the attribute out"),
    error("annotation-twice", "2.2.6", "give each tool one annotation"),
    // Variables.
    error("name-twice", "2.2.7", "give each variable a unique name"),
    warning("name-time", "2.2.7", "declare it as independent, or name it otherwise"),
    error("illegal-combination", "2.2.7", "see the two tables of the section"),
    error("continuous-not-real", "2.2.7", "give another variability: the default is continuous"),
    error("independent-twice", "2.2.7", "declare at most one independent variable"),
    error("multiple-set", "2.2.7", "leave out canHandleMultipleSetPerTimeInstant"),
    error("reinit", "2.2.7", "leave out reinit"),
    error("start-missing", "2.2.7", "exact, approx and inputs need a start value"),
    error("start-forbidden", "2.2.7", "calculated and independent variables have no start value"),
    error("start-outside-limits", "2.2.7", "let min ≤ start ≤ max"),
    error("alias-both-settable", "2.2.7", "give each settable variable its own value reference"),
    error("alias-start-twice", "2.2.7", "give a start value to one variable of an alias set"),
    error("alias-constant", "2.2.7", "constants are aliases of equal constants alone"),
    error("alias-unit", "2.2.7", "give aliases the same unit, or none of them any"),
    error("declared-type-undefined", "2.2.7", "define the type under TypeDefinitions"),
    error("declared-type-kind", "2.2.7", "cite a type of the variable's own kind"),
    warning("enumeration-start", "2.2.7", "start with the value of an item"),
    error("derivative-reference", "2.2.7", "cite the index, from 1, of a Real variable"),
    // Model structure.
    error("structure-index", "2.2.8", "indices count the ScalarVariables from 1"),
    error("structure-missing", "2.2.8", "list every variable that the section requires"),
    error("structure-extra", "2.2.8", "list only the variables that the section requires"),
    error("structure-twice", "2.2.8", "list each variable once"),
    error("initial-unknowns-order", "2.2.8", "sort InitialUnknowns by index"),
    error("derivatives-attribute", "2.2.7", "give the variable the attribute derivative"),
    error("state-not-continuous", "2.2.8", "states and derivatives are continuous Reals"),
    error("state-causality", "2.2.7", "a state is local or an output"),
    error("dependencies-order", "2.2.8", "sort dependencies by index, each once"),
    error("dependency-unknown", "2.2.8", "indices count the ScalarVariables from 1"),
    error("dependency-no-known", "2.2.8", "list inputs and states, or what is exact at the start"),
    warning("dependency-on-state", "2.2.8", "leave states out unless there are derivatives"),
    error("dependencies-kind", "2.2.8", "see the section for the kinds each list takes"),
    error("dependencies-kind-count", "2.2.8", "give one kind for each dependency"),
    // Names.
    error("name-empty", "2.2.9", "give the variable a name"),
    error("name-characters", "2.2.9", "leave out line ends and tabs"),
    error("name-structured", "2.2.9", "follow the grammar, or declare names as flat"),
    error("array-order", "2.2.9", "list an array's elements one after the other, in row order"),
    // The folders.
    error("no-implementation", "2.3", "ship a binary or the sources"),
    error("binary-name", "2.3", "name it <modelIdentifier>.dll, .so or .dylib"),
    note("platform-name", "2.3", "importers recognise win32, win64, linux32, linux64, darwin64 …"),
    error("source-missing", "2.3", "ship every file that SourceFiles lists, in sources/"),
    error("source-name", "2.2.1", "write a relative path with forward slashes"),
    error("sources-unlisted", "2.3", "list the files to compile under SourceFiles"),
    warning("source-header", "2.3", "leave the FMI headers to the importer"),
    note("no-documentation", "2.3", "ship documentation/index.html"),
    warning("documentation-entry", "2.3", "begin the documentation at documentation/index.html"),
    warning("license-entry", "2.3", "begin at documentation/licenses/license.txt or .html"),
    warning("icon", "2.3", "ship model.png as a PNG image"),
    error("terminals", "2.3", "ship terminalsAndIcons/terminalsAndIcons.xml as well-formed XML"),
    warning("extra-name", "2.3.1", "use folders named like extra/com.example/"),
    note("unknown-entry", "2.3", "put what the standard has no place for in extra/ or resources/"),
    // The binaries.
    error("binary-format", "2.3", "build a shared library for the platform the folder names"),
    error("binary-functions", "2.3", "export all functions, even those of absent capabilities"),
    warning(
        "binary-dependencies",
        "2.3",
        "link statically, or document it in externalDependencies.txt",
    ),
    note("binary-glibc", "2.3", ""),
    note("binary-needs", "2.3", ""),
    note("binary-build-path", "2.3", ""),
    // The binary at work.
    note("run-skipped", "2.3", ""),
    error("run-load", "2.3", "the library must load with what the archive and the system have"),
    error("run-version", "2.1.4", "fmi2GetVersion is 2.0, fmi2GetTypesPlatform is default"),
    error("run-instantiate", "2.1.5", RUN),
    error("run-guid", "2.1.5", "compare the GUID and return NULL where it differs"),
    error("run-null", "2.1.5", "ignore a NULL instance in fmi2FreeInstance"),
    error("run-crash", "2.1", RUN),
    error("run-hang", "2.1", RUN),
    error("run-call", "4.2.4", RUN),
    error("run-start", "2.2.7", "let the XML and the binary agree on start values"),
    note("run-start-rounding", "2.2.7", ""),
    error("run-value", "2.1.7", "return finite numbers"),
    error("run-reset", "2.1.6", "let fmi2Reset lead back to what instantiation gave"),
    error("run-state", "2.1.8", "let a restored state go on as it did the first time"),
    warning(
        "run-nondeterministic",
        "2.1.6",
        "seed random numbers by a parameter, and again at reset",
    ),
    error("run-instances", "4.3.1", "keep no global data, or declare one instance a process"),
    error("run-step-size", "4.3.1", "do not claim canHandleVariableCommunicationStepSize"),
    error("run-dependency", "2.2.8", "list the input among the output's dependencies"),
    note("run-output", "2.1.5", ""),
    error("run-log-category", "2.1.5", "log with the categories under LogCategories alone"),
    error(
        "run-reference",
        "4.2",
        "build binary and reference from the same model, or record the reference again",
    ),
    error("run-reference-form", "2.3.1", "correct reference.json and its tables"),
    note("run-reference-difference", "4.2", ""),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_rule_has_its_own_name_and_every_breach_a_hint() {
        let names: BTreeSet<&str> = RULES.iter().map(|rule| rule.name).collect();
        assert_eq!(names.len(), RULES.len());
        for rule in RULES {
            assert!(rule.severity == Severity::Note || !rule.hint.is_empty(), "{}", rule.name);
        }
    }
}
