//! Reading and writing the stages' files.

use crate::failure::Failure;
use formats::{Document, SourceFile};
use std::fs;
use std::path::Path;

/// A file's bytes.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|e| Failure::file(path, &e))
}

/// A file's text.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    String::from_utf8(read(path)?).map_err(|_| {
        Failure::new(format!("{}: not UTF-8 text", path.display()), "give a text file")
    })
}

/// A versioned document and where it came from.
pub(crate) fn read_document<D: Document>(path: &Path) -> Result<(D, SourceFile), Failure> {
    let text = read_text(path)?;
    let document = D::from_json(&text, &path.display().to_string())?;
    Ok((document, SourceFile::of(path, text.as_bytes())))
}

/// Writes a document after the checks its reader makes.
pub(crate) fn write_document<D: Document>(
    path: &Path,
    document: &D,
) -> Result<SourceFile, Failure> {
    document.checked(&path.display().to_string())?;
    let text = document.to_json();
    write(path, text.as_bytes())?;
    Ok(SourceFile::of(path, text.as_bytes()))
}

/// Writes a file whole or not at all, making its folder.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(|e| Failure::file(folder, &e))?;
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    fs::write(&part, bytes).map_err(|e| Failure::file(&part, &e))?;
    fs::rename(&part, path).map_err(|e| Failure::file(path, &e))
}
