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
        let text = String::from_utf8(bytes).map_err(|e| Error::NotUtf8 {
            archive: name.to_owned(),
            at: e.utf8_error().valid_up_to(),
        })?;
        let model = Model::read(&text, name)?;
        Ok(Self {
            name: name.to_owned(),
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
        places.iter().map(|place| self.folder().join(place)).find(|path| path.is_file()).ok_or_else(
            || Error::NoBinary {
                archive: self.name.clone(),
                looked_for: places.clone(),
                present: self.platforms(),
            },
        )
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
