//! Reading and writing the stages' files.

use crate::failure::Failure;
use formats::{Document, SourceFile};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// A file's bytes.
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

/// A file's text.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    let text = String::from_utf8(read(path)?).ok().filter(|text| !text.contains('\0'));
    text.ok_or_else(|| {
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
    let slash = path.as_os_str().as_encoded_bytes().ends_with(b"/");
    let Some(name) = path.file_name().filter(|_| !slash && !path.is_dir()) else {
        let message = format!("{}: this is a folder", path.display());
        return Err(Failure::new(message, "name a file in it"));
    };
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(|e| match e.kind() {
            ErrorKind::AlreadyExists => Failure::new(
                format!("{}: this is a file, not a folder", folder.display()),
                "name another folder",
            ),
            _ => Failure::file(folder, &e),
        })?;
    }
    let mut name = name.to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).map_err(|e| {
        // What is half written goes; that it may not exist is no second failure.
        let _ = fs::remove_file(&part);
        Failure::file(path, &e)
    })
}
