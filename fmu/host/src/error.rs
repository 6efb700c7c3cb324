//! Errors between an archive and a recording, with suggested fixes.

use std::path::PathBuf;

use miette::Diagnostic;
use model_description::{Causality, Kind};

use crate::c_types::Status;
use crate::log::LogLine;
use crate::names::near_text;

/// The library of Python's C interface, in messages.
pub(crate) const LIBPYTHON: &str = "libpython";

/// An error of this crate; [`Error::hint`] is the suggested fix.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[non_exhaustive]
#[allow(missing_docs)] // each variant's message describes its fields
pub enum Error {
    // --- archives
    #[error("{}: {source}", path.display())]
    #[diagnostic(help("check that the path exists, is readable and the disk is not full"))]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{archive}: not a readable zip archive: {reason}")]
    #[diagnostic(help("{}", DAMAGED))]
    NotAnArchive { archive: String, reason: String },
    #[error("{archive}: {got} entries, more than {limit}")]
    #[diagnostic(help("{}", LIMITS))]
    TooManyEntries { archive: String, got: usize, limit: usize },
    #[error("{archive}: two entries have the same name{}", entry.as_ref().map(|e| format!(", {e:?}")).unwrap_or_default())]
    #[diagnostic(help("{}", UNTRUSTED))]
    DuplicateEntry { archive: String, entry: Option<String> },
    #[error("{archive}: entry {entry:?} is refused: {reason}")]
    #[diagnostic(help("{}", UNTRUSTED))]
    UnsafeEntry { archive: String, entry: String, reason: &'static str },
    #[error("{archive}: entry {entry:?} is refused: {got} {what}, more than {limit}")]
    #[diagnostic(help("{}", LIMITS))]
    TooLarge { archive: String, entry: String, what: &'static str, got: u64, limit: u64 },
    #[error("{archive}: entry {entry:?} is damaged: {reason}")]
    #[diagnostic(help("{}", DAMAGED))]
    CorruptEntry { archive: String, entry: String, reason: String },
    #[error("{archive}: no modelDescription.xml at the top of the archive")]
    #[diagnostic(help(
        "modelDescription.xml has to lie at the top of the archive, not in a folder"
    ))]
    NoModelDescription { archive: String },
    #[error("{archive}: modelDescription.xml is not UTF-8 from byte {at} on")]
    #[diagnostic(help("{}", STANDARD))]
    NotUtf8 { archive: String, at: usize },
    #[error("{archive}: {source}")]
    #[diagnostic(help("{}", source.hint()))]
    ModelDescription { archive: String, source: model_description::Error },
    #[error("{archive}: two variables are named {name:?}")]
    #[diagnostic(help("{}", STANDARD))]
    DuplicateVariable { archive: String, name: String },
    #[error("{archive}: the FMU has no co-simulation interface")]
    #[diagnostic(help("export the model as FMI 2.0 for Co-Simulation"))]
    NotCoSimulation { archive: String },
    #[error("{archive}: modelIdentifier {got:?} is not the name of a file")]
    #[diagnostic(help("{}", STANDARD))]
    BadModelIdentifier { archive: String, got: String },

    // --- binaries
    #[error("{archive}: no binary for this platform, looked for {}; the archive has {}", looked_for.join(", "), list_or(present, "no binaries at all"))]
    #[diagnostic(help("export the FMU for this platform, or run it on one it has"))]
    NoBinary { archive: String, looked_for: Vec<String>, present: Vec<String> },
    #[error("{archive}: {expected} is missing; the archive has {}, which modelIdentifier does not name", present.join(", "))]
    #[diagnostic(help(
        "the FMU breaks the FMI 2.0 standard (2.3): rename the binary or modelIdentifier"
    ))]
    OtherBinary { archive: String, expected: String, present: Vec<String> },
    #[error("{}: cannot be loaded: {reason}", path.display())]
    #[diagnostic(help("{}", load_hint(reason)))]
    Load { path: PathBuf, reason: String },
    #[error("{}: {} missing: {}", path.display(), if missing.len() == 1 { "a function is" } else { "functions are" }, missing.join(", "))]
    #[diagnostic(help("{}", STANDARD))]
    MissingFunctions { path: PathBuf, missing: Vec<&'static str> },
    #[error("{}: {function} returns {got:?}, not {expected:?}", path.display())]
    #[diagnostic(help("{}", STANDARD))]
    WrongVersion { path: PathBuf, function: &'static str, got: String, expected: &'static str },

    // --- instances
    #[error("{name:?} cannot be the name of an instance: {reason}")]
    #[diagnostic(help("choose another name for the instance"))]
    InstanceName { name: String, reason: &'static str },
    #[error("{instance}: fmi2Instantiate refused{}", lines(log))]
    #[diagnostic(help("see the log lines; without any, the GUIDs of XML and binary may differ"))]
    Instantiate { instance: String, log: Vec<LogLine> },
    #[error("{instance}: {model} can be instantiated only once per process")]
    #[diagnostic(help("drop the first instance before making another"))]
    OnlyOnce { instance: String, model: String },
    #[error("{instance}: {call} returned {status}{}", lines(log))]
    #[diagnostic(help("{}", LOG_LINES))]
    Call { instance: String, call: &'static str, status: Status, log: Vec<LogLine> },
    #[error("{instance}: the FMU ended the simulation at t = {time} s (fmi2Terminated)")]
    #[diagnostic(help("stop the run before, or change the model's parameters"))]
    Terminated { instance: String, time: f64, log: Vec<LogLine> },
    #[error("{instance}: {call} returned {status} at t = {time} s, step {step} s{}", lines(log))]
    #[diagnostic(help("{}", LOG_LINES))]
    Step {
        instance: String,
        call: &'static str,
        time: f64,
        step: f64,
        status: Status,
        log: Vec<LogLine>,
    },
    #[error("{instance}: {call} is not possible any more: the FMU ended in a fatal error")]
    #[diagnostic(help("start again in a new process"))]
    Fatal { instance: String, call: &'static str },
    #[error("{instance}: {call} is not legal {phase}")]
    #[diagnostic(help("see table 4.2.4 of the FMI 2.0 standard for the order of calls"))]
    Phase { instance: String, call: &'static str, phase: &'static str },
    #[error(
        "{instance}: the FMU cannot do that: {capability} is false in its modelDescription.xml"
    )]
    #[diagnostic(help("do without it, or use an FMU that has this capability"))]
    Unsupported { instance: String, capability: &'static str },
    #[error("{instance}: the FMU state belongs to another instance")]
    #[diagnostic(help("use the state with the instance it was taken from"))]
    ForeignState { instance: String },
    #[error("{instance}: {call} got {references} value references and {values} values")]
    #[diagnostic(help("pass one value for each value reference"))]
    Lengths { instance: String, call: &'static str, references: usize, values: usize },
    #[error("{instance}: {what} of {call} is {value}, which is not a finite number")]
    #[diagnostic(help("{}", TIMES))]
    NotFinite { instance: String, call: &'static str, what: &'static str, value: f64 },
    #[error("{instance}: a text contains a NUL: {text:?}")]
    #[diagnostic(help("remove the NUL character"))]
    NulInText { instance: String, text: String },
    #[error("{instance}: {call} returned ok without a value")]
    #[diagnostic(help("{}", STANDARD))]
    NullResult { instance: String, call: &'static str },

    // --- variables
    #[error("{instance} has no variable {name:?}{}", near_text(near))]
    #[diagnostic(help("check the spelling"))]
    UnknownVariable { instance: String, name: String, near: Vec<String> },
    #[error("{instance}.{variable} is {need}, not {got}")]
    #[diagnostic(help("{}", VALUE))]
    WrongKind { instance: String, variable: String, need: Kind, got: Kind },
    #[error("{instance}.{variable} cannot be set {phase}: {reason}")]
    #[diagnostic(help("set parameters before initialization, inputs from initialization on"))]
    NotSettable { instance: String, variable: String, phase: &'static str, reason: &'static str },
    #[error("{instance}.{variable}: {text:?} is not a value of kind {kind}")]
    #[diagnostic(help("{}", VALUE))]
    BadValue { instance: String, variable: String, text: String, kind: Kind },

    // --- systems
    #[error("the system has no instance {name:?}; it has {}", list_or(instances, "none"))]
    #[diagnostic(help("check the spelling"))]
    UnknownInstance { name: String, instances: Vec<String> },
    #[error("two instances are named {name:?}")]
    #[diagnostic(help("use a different name for each instance"))]
    DuplicateInstance { name: String },
    #[error("{text:?} is not of the form instance.variable{}", if *with_value { "=value" } else { "" })]
    #[diagnostic(help(
        "write the name of the FMU before that of the variable, as in LateralPid.kp"
    ))]
    BadPath { text: String, with_value: bool },
    #[error("{end} is no {need}: its causality is {got}")]
    #[diagnostic(help("connect outputs to inputs"))]
    WrongCausality { end: String, need: &'static str, got: Causality },
    #[error("{from} is {from_kind} and {to} is {to_kind}: they cannot be connected")]
    #[diagnostic(help("{}", SAME_TYPE))]
    KindMismatch { from: String, from_kind: Kind, to: String, to_kind: Kind },
    #[error("{from} cannot be scaled on its way to {to}, which is {kind}")]
    #[diagnostic(help("scale values of the type Real only"))]
    ScaledKind { from: String, to: String, kind: Kind },
    #[error("{from} is in {from_unit:?} and {to} is in {to_unit:?}: they cannot be connected")]
    #[diagnostic(help("{}", SAME_TYPE))]
    UnitMismatch { from: String, from_unit: String, to: String, to_unit: String },
    #[error("{to} is already connected to {present}, it cannot be connected to {from} as well")]
    #[diagnostic(help("an input has one source: remove a connection"))]
    AlreadyConnected { to: String, present: String, from: String },
    #[error("{to} could be connected to any of {}", candidates.join(", "))]
    #[diagnostic(help("connect this input explicitly"))]
    Ambiguous { to: String, candidates: Vec<String> },
    #[error("{input} is set to a value, but it is fed by {source_name}")]
    #[diagnostic(help("remove the value, the table's column or the connection"))]
    SetAndFed { input: String, source_name: String },
    #[error("the order {} is not an order of the instances {}", order.join(", "), instances.join(", "))]
    #[diagnostic(help("name each instance exactly once"))]
    BadOrder { order: Vec<String>, instances: Vec<String> },
    #[error("{variable} is a text and cannot be recorded")]
    #[diagnostic(help("record numbers and Booleans only"))]
    NotRecordable { variable: String },
    #[error("{variable} is {value} at t = {time} s")]
    #[diagnostic(help(
        "the model diverged: check its parameters, the step size and the loop's stability"
    ))]
    NonFiniteOutput { variable: String, value: f64, time: f64 },
    #[error("no time grid from {start} s to {stop} s by {step} s: {reason}")]
    #[diagnostic(help("{}", TIMES))]
    BadGrid { start: f64, stop: f64, step: f64, reason: &'static str },

    // --- system structure packages
    #[error("{package}: no SystemStructure.ssd at the top of the package")]
    #[diagnostic(help(
        "SystemStructure.ssd has to lie at the top of the package, not in a folder"
    ))]
    NoSystemStructure { package: String },
    #[error("{package} has no {variant}.ssd, only {}", variants.join(", "))]
    #[diagnostic(help("name one of its structures, without .ssd"))]
    NoVariant { package: String, variant: String, variants: Vec<String> },
    #[error("{package}: {file}:{line}: {problem}")]
    #[diagnostic(help("the file breaks SSP 1.0: report it to the vendor"))]
    SystemStructure { package: String, file: String, line: u32, problem: String },
    #[error("{package}: {file}:{line}: {what} is not supported")]
    #[diagnostic(help(
        "use FMI 2.0 co-simulation FMUs, connections with at most a LinearTransformation, and parameter values"
    ))]
    SystemNotSupported { package: String, file: String, line: u32, what: String },
    #[error("{package}: the source {source_name:?} cannot be read: {reason}")]
    #[diagnostic(help(
        "pack the file into the SSP and name it by its path there, as in resources/A.fmu"
    ))]
    SystemSource { package: String, source_name: String, reason: &'static str },
    #[error(
        "{at}: {variable} is in {unit:?}, its value is given in {given:?}, \
         which nothing converts to it"
    )]
    #[diagnostic(help(
        "state the value in the variable's unit or a display unit of it, or define its unit in Units"
    ))]
    ParameterUnit { at: String, variable: String, unit: String, given: String },
    #[error("{package}: {file}:{line}: the connection of {start} and {end}: {source}")]
    #[diagnostic(help("{}", source.hint()))]
    SystemConnection {
        package: String,
        file: String,
        line: u32,
        start: String,
        end: String,
        source: Box<Error>,
    },
    #[error("{from} is in {from_unit:?} and {to} is in {to_unit:?}, a unit of another dimension")]
    #[diagnostic(help("connect variables of the same quantity"))]
    UnitDimension { from: String, from_unit: String, to: String, to_unit: String },

    // --- input tables
    #[error("{table}: line {line}, column {column:?}: {text:?} is not {need}")]
    #[diagnostic(help("{}", TABLE))]
    TableCell { table: String, line: u64, column: String, text: String, need: &'static str },
    #[error("{table}: {reason}")]
    #[diagnostic(help("{}", TABLE))]
    Table { table: String, reason: String },
    #[error("{table}: line {line}: time {time} s does not come after {previous} s")]
    #[diagnostic(help("{}", TABLE))]
    TableTime { table: String, line: u64, time: f64, previous: f64 },
    #[error("{table}: column {column:?} names no input{}", near_text(near))]
    #[diagnostic(help(
        "name columns after inputs: instance.variable, or variable for all of that name"
    ))]
    TableColumn { table: String, column: String, near: Vec<String> },
    #[error("{table}: starts at {first} s, after the start of the run at {start} s")]
    #[diagnostic(help("let the table begin at the start of the run or before"))]
    TableStart { table: String, first: f64, start: f64 },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}

const DAMAGED: &str = "the file is damaged or no FMU: get or export it again";
const LIMITS: &str =
    "no ordinary FMU is like that; if this one is trusted, open it with wider limits";
const UNTRUSTED: &str =
    "do not use this archive unless you know who made it; export it with another tool";
const STANDARD: &str = "the FMU breaks the FMI 2.0 standard: report it to the vendor";
const LOG_LINES: &str =
    "correct what the log lines state; without log lines, check the values that were set";
const TIMES: &str =
    "use finite times, a step above 0, and a stop that is whole steps after the start";
const VALUE: &str = "state a value of the variable's type: a number, a whole number, true or false";
const SAME_TYPE: &str = "connect variables of the same type and unit";
const TABLE: &str =
    "the table is CSV with a header, a first column `time` in s that rises, and numbers";

/// What to do about a library that cannot be loaded.
fn load_hint(reason: &str) -> &'static str {
    if reason.contains(LIBPYTHON) {
        "install the version of Python that the FMU was made for and load its library first, as in LD_PRELOAD=libpython3.11.so.1.0 steerwright simulate ..."
    } else {
        "a library it needs may be missing, the binary may be of another platform, or the temporary folder may forbid execution (set TMPDIR)"
    }
}

fn list_or(items: &[String], none: &str) -> String {
    if items.is_empty() { none.to_owned() } else { items.join(", ") }
}

fn lines(log: &[LogLine]) -> String {
    log.iter().map(|line| format!("\n  {line}")).collect()
}
