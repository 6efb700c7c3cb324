//! Files and folders; errors begin with the path.

use std::fs;
use std::path::{Path, PathBuf};

/// The content of a text file.
pub(crate) fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))
}

/// Removes a folder with its content, if it exists.
pub(crate) fn remove(folder: &Path) -> Result<(), String> {
    if !folder.exists() {
        return Ok(());
    }
    fs::remove_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

/// Writes a file, and the folder that it is in.
pub(crate) fn write(file: &Path, content: &[u8]) -> Result<(), String> {
    let folder = file.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    fs::write(file, content).map_err(|e| format!("{}: {e}", file.display()))
}

/// Copies a folder with all below it.
pub(crate) fn copy_below(from: &Path, to: &Path) -> Result<(), String> {
    for file in all_below(from)? {
        let content = fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        write(&to.join(file.strip_prefix(from).unwrap_or(&file)), &content)?;
    }
    Ok(())
}

/// The files of an extension in a folder and all below it, sorted.
pub(crate) fn below(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, String> {
    let has = |file: &PathBuf| file.extension().is_some_and(|end| end == extension);
    Ok(all_below(folder)?.into_iter().filter(has).collect())
}

/// The files in a folder and all below it, sorted.
pub(crate) fn all_below(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}
