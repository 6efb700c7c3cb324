//! Opening an FMU: the archive is extracted to a temporary folder, its modelDescription.xml read,
//! and its binary for the running platform found and, when first needed, loaded.
//!
//! Opening runs nothing. Instantiating runs the archive's machine code in this process, so
//! instantiate only FMUs from trusted sources; the protection against hostile archives (see
//! [`Limits`]) does not cover hostile binaries.

pub(crate) mod extract;
mod platform;

use std::fs;
use std::io::{Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

pub use extract::Limits;
pub use platform::{binary_name, platform_folders};

use crate::Error;
use crate::library::Library;
use crate::model::Model;
use crate::scratch::Scratch;

/// An opened FMU.
pub struct Archive {
    name: String,
    remarks: Vec<String>,
    model: Arc<Model>,
    /// Before `files`: the library is unloaded before its file is deleted.
    library: Mutex<Option<Arc<Library>>>,
    files: Arc<Extracted>,
}

/// The temporary folder of an archive; deleted when the archive and its last instance are dropped.
pub(crate) struct Extracted {
    folder: Scratch,
}

impl Archive {
    /// Opens a `.fmu` file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::open_with_limits(path, &Limits::default())
    }

    /// Opens a `.fmu` file that may be larger, or has to be smaller, than the default limits.
    pub fn open_with_limits(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, Error> {
        let (file, name) = extract::open(path.as_ref())?;
        Self::from_reader(file, &name, limits)
    }

    /// Opens an archive in memory; `name` is its name in errors.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, Error> {
        Self::from_reader(Cursor::new(bytes), name, &Limits::default())
    }

    fn from_reader<R: Read + Seek>(reader: R, name: &str, limits: &Limits) -> Result<Self, Error> {
        let folder = extract::extract(reader, name, limits)?;
        let xml = folder.path().join("modelDescription.xml");
        if !xml.is_file() {
            return Err(Error::NoModelDescription { archive: name.to_owned() });
        }
        let bytes = fs::read(&xml).map_err(|source| Error::Io { path: xml, source })?;
        let (text, encoding) = model_description::decoded(bytes)
            .map_err(|at| Error::NotUtf8 { archive: name.to_owned(), at })?;
        let model = Model::read(&text, name)?;
        let mut remarks = Vec::new();
        if let Some(encoding) = encoding {
            remarks.push(format!(
                "{name}: modelDescription.xml is in {encoding}, FMI 2.0 requires UTF-8 (2.2)"
            ));
        }
        let identifier = &model.co_simulation().model_identifier;
        if !model_description::is_c_identifier(identifier) {
            remarks.push(format!(
                "{name}: modelIdentifier {identifier:?} is not a C identifier, as FMI 2.0 requires \
                 (4.3.1)"
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            remarks,
            model: Arc::new(model),
            library: Mutex::new(None),
            files: Arc::new(Extracted { folder }),
        })
    }

    /// The name of the archive in errors.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Breaches of the standard with which the archive was opened all the same.
    #[must_use]
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// The name of a unit of this archive where no other is stated: that of the model or, where that is
    /// blank or has dots (`Plants.Car`), which separate a unit from its variables, that of the file.
    #[must_use]
    pub fn unit_name(&self) -> String {
        let model = &self.model.description().model_name;
        if !model.trim().is_empty() && !model.contains('.') {
            return model.clone();
        }
        let stem = Path::new(&self.name).file_stem().unwrap_or_default().to_string_lossy();
        stem.replace('.', "_")
    }

    /// The content of modelDescription.xml.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The folder with the archive's files; it is gone when the archive and its last instance are.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.files.folder.path()
    }

    /// The platforms that the archive has a shared library for, by their folder names, sorted.
    #[must_use]
    pub fn platforms(&self) -> Vec<String> {
        let identifier = &self.model.co_simulation().model_identifier;
        let names = ["so", "dll", "dylib"].map(|suffix| format!("{identifier}.{suffix}"));
        let Ok(folders) = fs::read_dir(self.folder().join("binaries")) else { return Vec::new() };
        let mut found: Vec<String> = folders
            .flatten()
            .filter(|entry| names.iter().any(|name| entry.path().join(name).is_file()))
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        found.sort();
        found
    }

    /// The binary for the running platform.
    pub fn binary(&self) -> Result<PathBuf, Error> {
        let name = binary_name(&self.model.co_simulation().model_identifier);
        let relative = |folder: &&str| format!("binaries/{folder}/{name}");
        let places: Vec<String> = platform_folders().iter().map(relative).collect();
        if let Some(place) = places.iter().find(|place| self.folder().join(place).is_file()) {
            return Ok(self.folder().join(place));
        }
        let archive = self.name.clone();
        for (folder, expected) in platform_folders().iter().zip(&places) {
            let present = self.libraries(folder);
            if !present.is_empty() {
                return Err(Error::OtherBinary { archive, expected: expected.clone(), present });
            }
        }
        Err(Error::NoBinary { archive, looked_for: places, present: self.platforms() })
    }

    /// The shared libraries in a folder of `binaries/`, whatever their names, sorted.
    fn libraries(&self, folder: &str) -> Vec<String> {
        let path = self.folder().join("binaries").join(folder);
        let Ok(entries) = fs::read_dir(path) else { return Vec::new() };
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        let libraries = names.filter(|name| name.ends_with(std::env::consts::DLL_SUFFIX));
        let mut found: Vec<String> =
            libraries.map(|name| format!("binaries/{folder}/{name}")).collect();
        found.sort();
        found
    }

    /// Loads the binary for the running platform, unless it is loaded, and checks that all
    /// functions are there and that it is FMI 2.0.
    pub fn load(&self) -> Result<(), Error> {
        self.library().map(drop)
    }

    /// Calls `fmi2FreeInstance` with NULL, which the standard has the FMU ignore: for checkers.
    pub fn free_null_instance(&self) -> Result<(), Error> {
        self.library().map(|library| library.free_null())
    }

    pub(crate) fn library(&self) -> Result<Arc<Library>, Error> {
        let mut library = self.library.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(library) = &*library {
            return Ok(Arc::clone(library));
        }
        let loaded = Arc::new(Library::load(&self.binary()?)?);
        *library = Some(Arc::clone(&loaded));
        Ok(loaded)
    }

    pub(crate) fn model_arc(&self) -> Arc<Model> {
        Arc::clone(&self.model)
    }

    pub(crate) fn files(&self) -> Arc<Extracted> {
        Arc::clone(&self.files)
    }

    /// The URI of the `resources` folder, whether or not the archive has one.
    pub(crate) fn resources_uri(&self) -> String {
        file_uri(&self.folder().join("resources"))
    }
}

impl std::fmt::Debug for Archive {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Archive")
            .field("name", &self.name)
            .field("folder", &self.folder())
            .finish_non_exhaustive()
    }
}

/// The `file:///` URI of an absolute path, percent-encoded as UTF-8; on Windows backslashes become
/// slashes and the drive stays readable (`file:///C:/…`).
fn file_uri(path: &Path) -> String {
    let text = path.to_string_lossy();
    let text = if cfg!(windows) {
        // A canonical Windows path may carry the `\\?\` prefix, which has no URI.
        text.trim_start_matches(r"\\?\").replace('\\', "/")
    } else {
        text.into_owned()
    };
    let mut uri = String::from("file://");
    if !text.starts_with('/') {
        uri.push('/');
    }
    for (i, byte) in text.bytes().enumerate() {
        let drive_colon = cfg!(windows) && i == 1 && byte == b':';
        // RFC 3986 unreserved characters and the path separator stay as they are.
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) || drive_colon {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn everything_but_unreserved_characters_is_percent_encoded() {
        assert_eq!(
            file_uri(Path::new("/tmp/ä b#c%d?/x-1._~")),
            "file:///tmp/%C3%A4%20b%23c%25d%3F/x-1._~"
        );
    }
}
