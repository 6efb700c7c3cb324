//! Errors between an archive and a recording, with suggested fixes.

use std::path::PathBuf;

use model_description::{Causality, Kind};

use crate::c_types::Status;
use crate::log::LogLine;
use crate::names::near_text;

/// The library of Python's C interface, in messages.
pub(crate) const LIBPYTHON: &str = "libpython";

/// An error of this crate; [`Error::hint`] is the suggested fix.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // each variant's message describes its fields
pub enum Error {
    // --- archives
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{archive}: not a readable zip archive: {reason}")]
    NotAnArchive { archive: String, reason: String },
    #[error("{archive}: {got} entries, more than {limit}")]
    TooManyEntries { archive: String, got: usize, limit: usize },
    #[error("{archive}: two entries have the same name{}", entry.as_ref().map(|e| format!(", {e:?}")).unwrap_or_default())]
    DuplicateEntry { archive: String, entry: Option<String> },
    #[error("{archive}: entry {entry:?} is refused: {reason}")]
    UnsafeEntry { archive: String, entry: String, reason: &'static str },
    #[error("{archive}: entry {entry:?} is refused: {got} {what}, more than {limit}")]
    TooLarge { archive: String, entry: String, what: &'static str, got: u64, limit: u64 },
    #[error("{archive}: entry {entry:?} is damaged: {reason}")]
    CorruptEntry { archive: String, entry: String, reason: String },
    #[error("{archive}: no modelDescription.xml at the top of the archive")]
    NoModelDescription { archive: String },
    #[error("{archive}: modelDescription.xml is not UTF-8 from byte {at} on")]
    NotUtf8 { archive: String, at: usize },
    #[error("{archive}: {source}")]
    ModelDescription { archive: String, source: model_description::Error },
    #[error("{archive}: two variables are named {name:?}")]
    DuplicateVariable { archive: String, name: String },
    #[error("{archive}: the FMU has no co-simulation interface")]
    NotCoSimulation { archive: String },
    #[error("{archive}: modelIdentifier {got:?} is not the name of a file")]
    BadModelIdentifier { archive: String, got: String },

    // --- binaries
    #[error("{archive}: no binary for this platform, looked for {}; the archive has {}", looked_for.join(", "), list_or(present, "no binaries at all"))]
    NoBinary { archive: String, looked_for: Vec<String>, present: Vec<String> },
    #[error("{archive}: {expected} is missing; the archive has {}, which modelIdentifier does not name", present.join(", "))]
    OtherBinary { archive: String, expected: String, present: Vec<String> },
    #[error("{}: cannot be loaded: {reason}", path.display())]
    Load { path: PathBuf, reason: String },
    #[error("{}: {} missing: {}", path.display(), if missing.len() == 1 { "a function is" } else { "functions are" }, missing.join(", "))]
    MissingFunctions { path: PathBuf, missing: Vec<&'static str> },
    #[error("{}: {function} returns {got:?}, not {expected:?}", path.display())]
    WrongVersion { path: PathBuf, function: &'static str, got: String, expected: &'static str },

    // --- instances
    #[error("{name:?} cannot be the name of an instance: {reason}")]
    InstanceName { name: String, reason: &'static str },
    #[error("{instance}: fmi2Instantiate refused{}", lines(log))]
    Instantiate { instance: String, log: Vec<LogLine> },
    #[error("{instance}: {model} can be instantiated only once per process")]
    OnlyOnce { instance: String, model: String },
    #[error("{instance}: {call} returned {status}{}", lines(log))]
    Call { instance: String, call: &'static str, status: Status, log: Vec<LogLine> },
    #[error("{instance}: the FMU ended the simulation at t = {time} s (fmi2Terminated)")]
    Terminated { instance: String, time: f64, log: Vec<LogLine> },
    #[error("{instance}: {call} returned {status} at t = {time} s, step {step} s{}", lines(log))]
    Step {
        instance: String,
        call: &'static str,
        time: f64,
        step: f64,
        status: Status,
        log: Vec<LogLine>,
    },
    #[error("{instance}: {call} is not possible any more: the FMU ended in a fatal error")]
    Fatal { instance: String, call: &'static str },
    #[error("{instance}: {call} is not legal {phase}")]
    Phase { instance: String, call: &'static str, phase: &'static str },
    #[error(
        "{instance}: the FMU cannot do that: {capability} is false in its modelDescription.xml"
    )]
    Unsupported { instance: String, capability: &'static str },
    #[error("{instance}: the FMU state belongs to another instance")]
    ForeignState { instance: String },
    #[error("{instance}: {call} got {references} value references and {values} values")]
    Lengths { instance: String, call: &'static str, references: usize, values: usize },
    #[error("{instance}: {what} of {call} is {value}, which is not a finite number")]
    NotFinite { instance: String, call: &'static str, what: &'static str, value: f64 },
    #[error("{instance}: a text contains a NUL: {text:?}")]
    NulInText { instance: String, text: String },
    #[error("{instance}: {call} returned ok without a value")]
    NullResult { instance: String, call: &'static str },

    // --- variables
    #[error("{instance} has no variable {name:?}{}", near_text(near))]
    UnknownVariable { instance: String, name: String, near: Vec<String> },
    #[error("{instance}.{variable} is {need}, not {got}")]
    WrongKind { instance: String, variable: String, need: Kind, got: Kind },
    #[error("{instance}.{variable} cannot be set {phase}: {reason}")]
    NotSettable { instance: String, variable: String, phase: &'static str, reason: &'static str },
    #[error("{instance}.{variable}: {text:?} is not a value of kind {kind}")]
    BadValue { instance: String, variable: String, text: String, kind: Kind },

    // --- systems
    #[error("the system has no instance {name:?}; it has {}", list_or(instances, "none"))]
    UnknownInstance { name: String, instances: Vec<String> },
    #[error("two instances are named {name:?}")]
    DuplicateInstance { name: String },
    #[error("{text:?} is not of the form instance.variable{}", if *with_value { "=value" } else { "" })]
    BadPath { text: String, with_value: bool },
    #[error("{end} is no {need}: its causality is {got}")]
    WrongCausality { end: String, need: &'static str, got: Causality },
    #[error("{from} is {from_kind} and {to} is {to_kind}: they cannot be connected")]
    KindMismatch { from: String, from_kind: Kind, to: String, to_kind: Kind },
    #[error("{from} is in {from_unit:?} and {to} is in {to_unit:?}: they cannot be connected")]
    UnitMismatch { from: String, from_unit: String, to: String, to_unit: String },
    #[error("{to} is already connected to {present}, it cannot be connected to {from} as well")]
    AlreadyConnected { to: String, present: String, from: String },
    #[error("{to} could be connected to any of {}", candidates.join(", "))]
    Ambiguous { to: String, candidates: Vec<String> },
    #[error("{input} is set to a value, but it is fed by {source_name}")]
    SetAndFed { input: String, source_name: String },
    #[error("the order {} is not an order of the instances {}", order.join(", "), instances.join(", "))]
    BadOrder { order: Vec<String>, instances: Vec<String> },
    #[error("{variable} is a text and cannot be recorded")]
    NotRecordable { variable: String },
    #[error("{variable} is {value} at t = {time} s")]
    NonFiniteOutput { variable: String, value: f64, time: f64 },
    #[error("no time grid from {start} s to {stop} s by {step} s: {reason}")]
    BadGrid { start: f64, stop: f64, step: f64, reason: &'static str },

    // --- system structure packages
    #[error("{package}: no SystemStructure.ssd at the top of the package")]
    NoSystemStructure { package: String },
    #[error("{package}: {file}:{line}: {problem}")]
    SystemStructure { package: String, file: String, line: u32, problem: String },
    #[error("{package}: {file}:{line}: {what} is not supported")]
    SystemNotSupported { package: String, file: String, line: u32, what: String },
    #[error("{package}: the source {source_name:?} cannot be read: {reason}")]
    SystemSource { package: String, source_name: String, reason: &'static str },
    #[error(
        "{at}: {variable} is in {unit:?}, its value is given in {given:?}, \
         which nothing converts to it"
    )]
    ParameterUnit { at: String, variable: String, unit: String, given: String },
    #[error("{package}: {file}:{line}: the connection of {start} and {end}: {source}")]
    SystemConnection {
        package: String,
        file: String,
        line: u32,
        start: String,
        end: String,
        source: Box<Error>,
    },
    #[error("{from} is in {from_unit:?} and {to} is in {to_unit:?}, a unit of another dimension")]
    UnitDimension { from: String, from_unit: String, to: String, to_unit: String },
    #[error(
        "{from} is in {from_unit:?} and {to} is in {to_unit:?}, where a value is {factor} times as \
         large{}, and units of connections are not converted",
        if *offset == 0.0 { String::new() } else { format!(" plus {offset}") }
    )]
    UnitFactor {
        from: String,
        from_unit: String,
        to: String,
        to_unit: String,
        factor: f64,
        offset: f64,
    },

    // --- input tables
    #[error("{table}: line {line}, column {column:?}: {text:?} is not {need}")]
    TableCell { table: String, line: u64, column: String, text: String, need: &'static str },
    #[error("{table}: {reason}")]
    Table { table: String, reason: String },
    #[error("{table}: line {line}: time {time} s does not come after {previous} s")]
    TableTime { table: String, line: u64, time: f64, previous: f64 },
    #[error("{table}: column {column:?} names no input{}", near_text(near))]
    TableColumn { table: String, column: String, near: Vec<String> },
    #[error("{table}: starts at {first} s, after the start of the run at {start} s")]
    TableStart { table: String, first: f64, start: f64 },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::ModelDescription { source, .. } => source.hint(),
            Self::SystemConnection { source, .. } => source.hint(),
            _ => self.own_hint().to_owned(),
        }
    }

    fn own_hint(&self) -> &'static str {
        match self {
            Self::Io { .. } => "check that the path exists, is readable and the disk is not full",
            Self::NotAnArchive { .. } | Self::CorruptEntry { .. } => {
                "the file is damaged or no FMU: get or export it again"
            }
            Self::TooManyEntries { .. } | Self::TooLarge { .. } => {
                "no ordinary FMU is like that; if this one is trusted, open it with wider limits"
            }
            Self::DuplicateEntry { .. } | Self::UnsafeEntry { .. } => {
                "do not use this archive unless you know who made it; export it with another tool"
            }
            Self::NoModelDescription { .. } => {
                "modelDescription.xml has to lie at the top of the archive, not in a folder"
            }
            // Never used: `hint` is that of the wrapped error.
            Self::SystemConnection { .. } => "see the wrapped error",
            Self::ModelDescription { .. }
            | Self::NotUtf8 { .. }
            | Self::DuplicateVariable { .. }
            | Self::BadModelIdentifier { .. }
            | Self::MissingFunctions { .. }
            | Self::WrongVersion { .. }
            | Self::NullResult { .. } => {
                "the FMU breaks the FMI 2.0 standard: report it to the vendor"
            }
            Self::NotCoSimulation { .. } => "export the model as FMI 2.0 for Co-Simulation",
            Self::OtherBinary { .. } => {
                "the FMU breaks the FMI 2.0 standard (2.3): rename the binary or modelIdentifier"
            }
            Self::NoBinary { .. } => "export the FMU for this platform, or run it on one it has",
            Self::Load { reason, .. } if reason.contains(LIBPYTHON) => {
                "install the version of Python that the FMU was made for and load its library \
                 first, as in LD_PRELOAD=libpython3.11.so.1.0 steerwright simulate ..."
            }
            Self::Load { .. } => {
                "a library it needs may be missing, the binary may be of another platform, or the \
                 temporary folder may forbid execution (set TMPDIR)"
            }
            Self::InstanceName { .. } => "choose another name for the instance",
            Self::Instantiate { .. } => {
                "see the log lines; without any, the GUIDs of XML and binary may differ"
            }
            Self::OnlyOnce { .. } => "drop the first instance before making another",
            Self::Call { .. } | Self::Step { .. } => {
                "see the log lines; without any, instantiate with logging on"
            }
            Self::Terminated { .. } => "stop the run before, or change the model's parameters",
            Self::Fatal { .. } => "start again in a new process",
            Self::Phase { .. } => "see table 4.2.4 of the FMI 2.0 standard for the order of calls",
            Self::Unsupported { .. } => "do without it, or use an FMU that has this capability",
            Self::ForeignState { .. } => "use the state with the instance it was taken from",
            Self::Lengths { .. } => "pass one value for each value reference",
            Self::NotFinite { .. } | Self::BadGrid { .. } => {
                "use finite times, a step above 0, and a stop that is whole steps after the start"
            }
            Self::NulInText { .. } => "remove the NUL character",
            Self::UnknownVariable { .. } | Self::UnknownInstance { .. } => "check the spelling",
            Self::WrongKind { .. } | Self::BadValue { .. } => {
                "state a value of the variable's type: a number, a whole number, true or false"
            }
            Self::NotSettable { .. } => {
                "set parameters before initialization, inputs from initialization on"
            }
            Self::DuplicateInstance { .. } => "use a different name for each instance",
            Self::BadPath { .. } => "write it as in pid.kp=2.5",
            Self::WrongCausality { .. } => "connect outputs to inputs",
            Self::KindMismatch { .. } | Self::UnitMismatch { .. } => {
                "connect variables of the same type and unit"
            }
            Self::AlreadyConnected { .. } => "an input has one source: remove a connection",
            Self::Ambiguous { .. } => "connect this input explicitly",
            Self::SetAndFed { .. } => "remove the value, the table's column or the connection",
            Self::BadOrder { .. } => "name each instance exactly once",
            Self::NotRecordable { .. } => "record numbers and Booleans only",
            Self::NonFiniteOutput { .. } => {
                "the model diverged: check its parameters, the step size and the loop's stability"
            }
            Self::NoSystemStructure { .. } => {
                "SystemStructure.ssd has to lie at the top of the package, not in a folder"
            }
            Self::SystemStructure { .. } => "the file breaks SSP 1.0: report it to the vendor",
            Self::SystemNotSupported { .. } => {
                "use a flat SSP 1.0 system: FMI 2.0 co-simulation FMUs, plain connections and \
                 parameter values"
            }
            Self::SystemSource { .. } => {
                "pack the file into the SSP and name it by its path there, as in resources/A.fmu"
            }
            Self::ParameterUnit { .. } => {
                "state the value in the variable's unit or a display unit of it, or define its unit \
                 in Units"
            }
            Self::UnitDimension { .. } => "connect variables of the same quantity",
            Self::UnitFactor { .. } => {
                "connect variables of the same unit, or put an FMU between that scales; where the \
                 values are meant as they are, write suppressUnitConversion=\"true\""
            }
            Self::Table { .. } | Self::TableCell { .. } | Self::TableTime { .. } => {
                "the table is CSV with a header, a first column `time` in s that rises, and numbers"
            }
            Self::TableColumn { .. } => {
                "name columns after inputs: instance.variable, or variable for all of that name"
            }
            Self::TableStart { .. } => "let the table begin at the start of the run or before",
        }
    }
}

fn list_or(items: &[String], none: &str) -> String {
    if items.is_empty() { none.to_owned() } else { items.join(", ") }
}

fn lines(log: &[LogLine]) -> String {
    log.iter().map(|line| format!("\n  {line}")).collect()
}
