//! Reading the stages' files.

use crate::failure::Failure;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
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

/// The files of a log: of a ROS 2 bag, which is a folder, its MCAP files in the order of their names.
pub(crate) fn of_log(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.join("metadata.yaml").is_file() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = fs::read_dir(path).map_err(|e| Failure::file(path, &e))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let has = |file: &PathBuf, ends: &[&str]| {
        let name = file.to_string_lossy();
        ends.iter().any(|end| name.ends_with(end))
    };
    if let Some(database) = files.iter().find(|file| has(file, &[".db3", ".db3.zstd"])) {
        return Err(Failure::new(
            format!("{}: a ROS 2 bag in SQLite (.db3), which is not read here", database.display()),
            "read it in Python: pip install ./python, then steerwright.read(FILE); or convert it to MCAP: ros2 bag convert",
        ));
    }
    files.retain(|file| has(file, &[".mcap", ".mcap.zstd"]));
    if files.is_empty() {
        return Err(Failure::new(
            format!("{}: the folder has a metadata.yaml and no MCAP file", path.display()),
            "name the folder of a ROS 2 bag, or the log itself",
        ));
    }
    Ok(files)
}

/// The file of a log that is one.
pub(crate) fn of_one_log(path: &Path) -> Result<PathBuf, Failure> {
    match &of_log(path)?[..] {
        [file] => Ok(file.clone()),
        files => Err(Failure::new(
            format!("{}: a bag of {} files", path.display(), files.len()),
            format!("name one of them, such as {}", files[0].display()),
        )),
    }
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
    Ok((document, SourceFile::from_bytes(path, text.as_bytes())))
}
