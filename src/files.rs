//! Reading the stages' files.

use crate::failure::Failure;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use steerwright_formats::{Document, SourceFile};

pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|e| Failure::file(path, &e))
}

/// A file to be read from its start to its end.
pub(crate) fn open(path: &Path) -> Result<fs::File, Failure> {
    let file = fs::File::open(path).map_err(|e| Failure::file(path, &e))?;
    let metadata = file.metadata().map_err(|e| Failure::file(path, &e))?;
    if metadata.is_dir() {
        return Err(Failure::file(path, &ErrorKind::IsADirectory.into()));
    }
    Ok(file)
}

pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    let text = String::from_utf8(read(path)?).ok().filter(|text| !text.contains('\0'));
    text.ok_or_else(|| {
        Failure::new(format!("{}: not UTF-8 text", path.display()), "use a text file in UTF-8")
    })
}

/// A versioned document and where it came from.
pub(crate) fn read_document<D: Document>(path: &Path) -> Result<(D, SourceFile), Failure> {
    let text = read_text(path)?;
    let document = D::from_json(&text, &path.display().to_string())?;
    Ok((document, SourceFile::of(path, text.as_bytes())))
}
