//! System structure packages (SSP 1.0): a zip of FMUs and the `SystemStructure.ssd` that wires them.
//!
//! [`SystemPackage`] reads systems of FMI 2.0 co-simulation FMUs, of any tool, with systems inside them, and with
//! parameter values inline or in `.ssv` files of the package; [`SystemPackage::system`] makes the [`System`]
//! to run. The package is extracted as an FMU is: checked entry by entry, see
//! [`Limits`].

mod checks;
mod element;
mod read;
mod structure;
mod wires;

use std::fs;
use std::io::{Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use model_description::{Causality, Kind, Unit, Value, Variable};

pub use structure::{Component, Connector, Parameter, SspPlace, SystemInput, SystemStructure};

use crate::archive::{Archive, Limits, extract};
use crate::instance::Instance;
use crate::names::near_text;
use crate::system::{Connection, Linear, System};
use crate::{Error, units};

/// The file that describes a package.
const STRUCTURE: &str = "SystemStructure.ssd";
/// Longest XML file that is read, bytes.
const XML_LIMIT: u64 = 64 << 20;

/// An opened package.
#[derive(Debug)]
pub struct SystemPackage {
    name: String,
    structure: SystemStructure,
    /// One for each component; components of one source share it.
    archives: Vec<std::sync::Arc<Archive>>,
}

impl SystemPackage {
    /// Opens a `.ssp` file with the structure of its `SystemStructure.ssd`.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let (file, name) = extract::open(path.as_ref())?;
        Self::from_reader(file, &name, None, &Limits::default())
    }

    /// Opens a `.ssp` file with the structure of a variant, its file `variant.ssd`.
    pub fn open_variant(path: impl AsRef<Path>, variant: &str) -> Result<Self, Error> {
        let (file, name) = extract::open(path.as_ref())?;
        Self::from_reader(file, &name, Some(variant), &Limits::default())
    }

    /// Opens a package in memory; `name` is its name in errors.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, Error> {
        Self::from_reader(Cursor::new(bytes), name, None, &Limits::default())
    }

    fn from_reader<R: Read + Seek>(
        reader: R,
        name: &str,
        variant: Option<&str>,
        limits: &Limits,
    ) -> Result<Self, Error> {
        // The FMUs have folders of their own, so this one may go when they are open.
        let folder = extract::extract(reader, name, limits)?;
        if !folder.path().join(STRUCTURE).is_file() {
            return Err(Error::NoSystemStructure { package: name.to_owned() });
        }
        let file_name = match variant {
            None => STRUCTURE.to_owned(),
            Some(variant) => variant_file(folder.path(), name, variant)?,
        };
        let load = |source: &str| text_of(folder.path(), name, source);
        let text = load(&file_name)?;
        let text = element::without_mark(&text);
        let line_ends = element::line_ends(text);
        let file = element::File { package: name, name: &file_name, line_ends: &line_ends };
        let structure = read::structure(text, file, &load)?;
        let mut archives: Vec<std::sync::Arc<Archive>> = Vec::new();
        for (index, component) in structure.components.iter().enumerate() {
            let same =
                structure.components[..index].iter().position(|c| c.source == component.source);
            archives.push(match same {
                Some(other) => std::sync::Arc::clone(&archives[other]),
                None => {
                    let path = inside(folder.path(), name, &component.source)?;
                    std::sync::Arc::new(Archive::open(path)?)
                }
            });
        }
        Ok(Self { name: name.to_owned(), structure, archives })
    }

    /// The name of the package in errors.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The content of its `SystemStructure.ssd`, or of the variant.
    #[must_use]
    pub fn structure(&self) -> &SystemStructure {
        &self.structure
    }

    /// The components' FMUs, in the order of [`SystemStructure::components`].
    pub fn archives(&self) -> impl Iterator<Item = &Archive> {
        self.archives.iter().map(AsRef::as_ref)
    }

    /// The system: an instance of each component, connected, with its values set; and remarks on
    /// ignored content: values for variables that an FMU does not have, which SSP allows, start
    /// values of connected inputs, connectors that differ from their FMUs, connections written from
    /// an input to an output.
    pub fn system(&self) -> Result<(System, Vec<String>), Error> {
        let mut remarks = self.structure.remarks.clone();
        let mut system = System::new();
        for (component, archive) in self.structure.components.iter().zip(self.archives()) {
            system.add(Instance::new(archive, &component.name)?)?;
        }
        for (component, archive) in self.structure.components.iter().zip(self.archives()) {
            remarks.extend(checks::connectors(component, archive));
        }
        for (connection, how) in self.structure.connections.iter().zip(&self.structure.written) {
            self.connect(&mut system, connection, how, &mut remarks)
                .map_err(|error| checks::error_at(&self.name, &how.place, connection, error))?;
        }
        for input in &self.structure.inputs {
            self.connect_input(&mut system, input, &mut remarks)?;
        }
        for component in &self.structure.components {
            for parameter in &component.parameters {
                let path = format!("{}.{}", component.name, parameter.name);
                let instance = system.instance_mut(&component.name)?;
                let place = &parameter.place;
                let Ok(variable) = instance.variable(&parameter.name) else {
                    let near = near_text(&instance.model().near(&parameter.name));
                    remarks
                        .push(format!("{place}: {path} is given a value and does not exist{near}"));
                    continue;
                };
                let units = &instance.model().description().units;
                let value = self.fitting(variable, parameter, &path, units)?;
                let fed = |c: &Connection| c.to == component.name && c.input == parameter.name;
                if system.connections().iter().any(fed) {
                    remarks.push(format!(
                        "{place}: {path} is given a value, but a connection feeds it"
                    ));
                    continue;
                }
                system.start_with(&component.name, &parameter.name, value)?;
            }
        }
        for parameter in &self.structure.parameters {
            self.start_inputs(&mut system, parameter)?;
        }
        Ok((system, remarks))
    }

    /// Feeds an input of a component from a connector of the system.
    fn connect_input(
        &self,
        system: &mut System,
        written: &SystemInput,
        remarks: &mut Vec<String>,
    ) -> Result<(), Error> {
        let SystemInput { connector, component, input, written: how } = written;
        let connection = Connection::new(&self.structure.name, connector, component, input);
        let all = || self.structure.components.iter().zip(self.archives());
        let start = self.structure.input_connector(connector).map(checks::End::of_system);
        let result = match (start, checks::End::find(all(), component, input)) {
            (Some(start), Some(end)) => {
                let ends = (&start, &end);
                checks::units(&connection, ends, &self.structure.units, how.suppressed)
            }
            // Unknown ends are refused while reading.
            _ => Ok((Linear::IDENTITY, None)),
        };
        let result = result.and_then(|(conversion, remark)| {
            remarks.extend(remark.map(|remark| format!("{}: {remark}", how.place)));
            let scale = how.transformation.after(conversion);
            system.connect_input(connector, component, input, scale)
        });
        result.map_err(|error| checks::error_at(&self.name, &how.place, &connection, error))
    }

    /// Lets the inputs that a connector of the system feeds start with its value.
    fn start_inputs(&self, system: &mut System, parameter: &Parameter) -> Result<(), Error> {
        let fed = self.structure.inputs.iter().filter(|input| input.connector == parameter.name);
        for SystemInput { component, input, written, .. } in fed {
            let path = format!("{component}.{input}");
            let instance = system.instance_mut(component)?;
            let units = &instance.model().description().units;
            let value = match self.fitting(instance.variable(input)?, parameter, &path, units)? {
                Value::Real(value) => Value::Real(written.transformation.apply(value)),
                value => value,
            };
            system.start_with(component, input, value)?;
        }
        Ok(())
    }

    /// Makes a connection from its output to its input, whichever end was written first.
    fn connect(
        &self,
        system: &mut System,
        written: &Connection,
        how: &structure::WrittenConnection,
        remarks: &mut Vec<String>,
    ) -> Result<(), Error> {
        let all = || self.structure.components.iter().zip(self.archives());
        let start = checks::End::find(all(), &written.from, &written.output);
        let end = checks::End::find(all(), &written.to, &written.input);
        // Unknown components are refused while reading; `System::connect` names them again.
        let (Some(start), Some(end)) = (start, end) else {
            return system.connect(written.clone()).map(drop);
        };
        let backwards = start.causality() == Some(Causality::Input)
            && end.causality() == Some(Causality::Output);
        let (connection, ends) = if backwards {
            let c = written;
            (Connection::new(&c.to, &c.input, &c.from, &c.output), (&end, &start))
        } else {
            (written.clone(), (&start, &end))
        };
        if backwards {
            remarks.push(format!(
                "{}: the connection starts at the input {} and ends at the output {}: taken as \
                 {connection}",
                how.place,
                written.source(),
                written.target()
            ));
        }
        let (conversion, remark) =
            checks::units(&connection, ends, &self.structure.units, how.suppressed)?;
        remarks.extend(remark.map(|remark| format!("{}: {remark}", how.place)));
        // A transformation is in addition to the conversion of units.
        system.connect_scaled(connection, how.transformation.after(conversion))
    }

    /// A parameter's value as the variable takes it, in the variable's type and unit.
    fn fitting(
        &self,
        variable: &Variable,
        parameter: &Parameter,
        path: &str,
        of_fmu: &[Unit],
    ) -> Result<Value, Error> {
        let value = match (&parameter.value, variable.kind) {
            (Value::Integer(value), Kind::Real) => Value::Real(f64::from(*value)),
            (value, _) => value.clone(),
        };
        let (Some(given), Some(unit)) = (&parameter.unit, &variable.unit) else { return Ok(value) };
        let Value::Real(number) = value else { return Ok(value) };
        if given == unit {
            return Ok(value);
        }
        // Units of the value's own file come before those of the structure.
        let own = Unit { name: given.clone(), base: parameter.base, display_units: Vec::new() };
        let mut defined = vec![own];
        defined.retain(|own| own.base.is_some());
        defined.extend_from_slice(&self.structure.units);
        let refused = || Error::ParameterUnit {
            at: format!("{}: {}", self.name, parameter.place),
            variable: path.to_owned(),
            unit: unit.clone(),
            given: given.clone(),
        };
        units::converted(number, given, unit, of_fmu, &defined).map(Value::Real).ok_or_else(refused)
    }
}

/// The file of a variant, which lies beside `SystemStructure.ssd`.
fn variant_file(folder: &Path, package: &str, variant: &str) -> Result<String, Error> {
    let io = |source: std::io::Error| Error::Io { path: folder.to_path_buf(), source };
    let mut variants: Vec<String> = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let file = PathBuf::from(entry.map_err(io)?.file_name());
        if file.extension().is_some_and(|ending| ending == "ssd") {
            variants.extend(file.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        }
    }
    variants.sort();
    if variants.iter().any(|known| known == variant) {
        return Ok(format!("{variant}.ssd"));
    }
    Err(Error::NoVariant { package: package.to_owned(), variant: variant.to_owned(), variants })
}

fn refused(package: &str, source: &str, reason: &'static str) -> Error {
    Error::SystemSource { package: package.to_owned(), source_name: source.to_owned(), reason }
}

/// The path of a file that the structure names, which has to lie in the package.
fn inside(folder: &Path, package: &str, source: &str) -> Result<PathBuf, Error> {
    let bad = |reason| refused(package, source, reason);
    let decoded = percent_decoded(source).ok_or_else(|| bad("it is no URI"))?;
    let plain = decoded.strip_prefix("./").unwrap_or(&decoded);
    let path = folder.join(extract::safe_path(plain).map_err(|_| bad("it leaves the package"))?);
    if path.is_file() { Ok(path) } else { Err(bad("the package has no such file")) }
}

fn text_of(folder: &Path, package: &str, source: &str) -> Result<String, Error> {
    let path = inside(folder, package, source)?;
    let io = |e: std::io::Error| Error::Io { path: path.clone(), source: e };
    let bad = |reason| refused(package, source, reason);
    if fs::metadata(&path).map_err(io)?.len() > XML_LIMIT {
        return Err(bad("it is larger than 64 MiB"));
    }
    String::from_utf8(fs::read(&path).map_err(io)?).map_err(|_| bad("it is not UTF-8"))
}

/// `%20` and the like as the bytes they represent; `None` where that is no text.
fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        rest = tail;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    String::from_utf8(bytes).ok()
}
