//! The demo's archives with the libraries of every platform inside.

use super::platform::Platform;
use super::{LIBRARIES, binaries, folder};
use crate::every_fmu;
use crate::files::below;
use std::fs::File;
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// Builds `steerwright` around the libraries and writes the demo's archives into the folder that it
/// returns.
pub(crate) fn archives(platforms: &[Platform]) -> Result<PathBuf, String> {
    let out = folder().join("archives");
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
    let found = below(folder, "fmu")?;
    if found.is_empty() {
        return Err(format!("{}: no archives", folder.display()));
    }
    Ok(found)
}

/// A file's name without its extension.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
