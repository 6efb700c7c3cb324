//! The demo's archives with the libraries of every platform inside.

use super::platform::Platform;
use super::{LIBRARIES, binaries, folder};
use crate::every_fmu;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// Builds `steerwright` around the libraries and writes the demo's archives into the folder that it
/// returns.
pub(crate) fn archives(platforms: &[Platform]) -> Result<PathBuf, String> {
    let out = folder().join("archives");
    if out.exists() {
        fs::remove_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    }
    every_fmu::pack(&out, Some(&binaries()))?;
    let archives = find(&out)?;
    for archive in &archives {
        let name = stem(archive);
        if !LIBRARIES.iter().any(|(_, library)| *library == name) {
            continue;
        }
        let packed = File::open(archive).map_err(|e| format!("{}: {e}", archive.display()))?;
        let packed = ZipArchive::new(packed).map_err(|e| format!("{}: {e}", archive.display()))?;
        for platform in platforms {
            let file = format!("binaries/{}/{name}.{}", platform.name(), platform.extension());
            if packed.index_for_name(&file).is_none() {
                return Err(format!("{}: no {file}", archive.display()));
            }
        }
    }
    let names: Vec<_> = platforms.iter().map(|platform| platform.name()).collect();
    eprintln!("{} archives for {} in {}", archives.len(), names.join(", "), out.display());
    Ok(out)
}

/// Every FMU below a folder, in order.
pub(crate) fn find(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "fmu") {
                found.push(path);
            }
        }
    }
    if found.is_empty() {
        return Err(format!("{}: no archives", folder.display()));
    }
    found.sort();
    Ok(found)
}

/// A file's name without its extension.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
