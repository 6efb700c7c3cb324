//! Files written below a folder that is new, and the list of them.

use crate::failure::Failure;
use std::fs;
use std::path::{Path, PathBuf};
use steerwright_formats::{Document, SourceFile};

/// Writes files below a new folder and keeps the list.
pub(crate) struct Writer {
    folder: PathBuf,
    written: Vec<SourceFile>,
}

impl Writer {
    pub(crate) fn new(folder: &Path) -> Self {
        Self { folder: folder.into(), written: Vec::new() }
    }

    /// Writes bytes under a name relative to the folder.
    pub(crate) fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let path = self.folder.join(name);
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(&path, bytes))
            .map_err(|e| Failure::file(&path, &e))?;
        self.written
            .push(SourceFile { name: name.into(), sha256: steerwright_formats::sha256_hex(bytes) });
        Ok(path)
    }

    /// Writes a document; returns its reference for the files made from it.
    pub(crate) fn document<D: Document>(
        &mut self,
        name: &str,
        document: &D,
    ) -> Result<SourceFile, Failure> {
        document.checked(name)?;
        let text = document.to_json();
        self.bytes(name, text.as_bytes())?;
        Ok(SourceFile::of(Path::new(name), text.as_bytes()))
    }

    /// Packs a document's FMU into a folder below.
    pub(crate) fn archive<D: Document>(
        &mut self,
        folder: &str,
        document: &D,
    ) -> Result<PathBuf, Failure> {
        let packed = steerwright_comparison::pack(&document.to_json(), folder, None)?;
        self.bytes(&format!("{folder}/{}.fmu", packed.fmu.name()), &packed.bytes)
    }

    /// The files written, in order.
    pub(crate) fn into_written(self) -> Vec<SourceFile> {
        self.written
    }

    /// The files written so far.
    pub(crate) fn written(&self) -> &[SourceFile] {
        &self.written
    }
}
