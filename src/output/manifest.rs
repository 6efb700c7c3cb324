//! The list of the files that a command wrote into a folder, which identifies the folder later.

use crate::failure::Failure;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;
use steerwright_formats::SourceFile;

/// Its name in the folder.
pub(super) const NAME: &str = "manifest.json";
const SCHEMA: &str = "steerwright/manifest/1";
/// Files that file browsers create.
const IGNORED: [&str; 2] = [".DS_Store", "Thumbs.db"];

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Manifest {
    schema: String,
    version: String,
    command: String,
    files: Vec<SourceFile>,
}

impl Manifest {
    /// Of the files of a folder, in the order of their names.
    pub(super) fn from_folder(folder: &Path, command: &str) -> std::io::Result<Self> {
        let mut names = Vec::new();
        walk(folder, "", &mut names)?;
        names.sort();
        let files = names.into_iter().map(|name| {
            let sha256 = steerwright_formats::sha256_hex(&fs::read(folder.join(&name))?);
            Ok(SourceFile { name, sha256, of_samples: false })
        });
        Ok(Self {
            schema: SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            command: command.into(),
            files: files.collect::<std::io::Result<_>>()?,
        })
    }

    pub(super) fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    fn read(folder: &Path) -> Option<Self> {
        let text = fs::read_to_string(folder.join(NAME)).ok()?;
        serde_json::from_str(&text).ok().filter(|m: &Self| m.schema == SCHEMA)
    }
}

/// Refuses a folder whose files an earlier run of the command did not write; with `force`, files that
/// it wrote and that were changed since may be lost, and those of another command.
pub(super) fn check(folder: &Path, command: &str, force: bool) -> Result<(), Failure> {
    let shown = folder.display();
    let mut found = Vec::new();
    walk(folder, "", &mut found).map_err(|e| Failure::file(folder, &e))?;
    found.sort();
    if found.is_empty() {
        return Ok(());
    }
    let manifest = Manifest::read(folder);
    let listed =
        |name: &str| manifest.as_ref().and_then(|m| m.files.iter().find(|file| file.name == name));
    let foreign: Vec<&str> = found
        .iter()
        .map(String::as_str)
        .filter(|name| listed(name).is_none() && !(manifest.is_some() && *name == NAME))
        .collect();
    if !foreign.is_empty() {
        return Err(Failure::new(
            format!(
                "{shown}: this folder holds files that {command} did not write: {}",
                few(&foreign)
            ),
            "name another folder, or move these files: the folder is replaced as a whole, with \
             --force too",
        ));
    }
    if force {
        return Ok(());
    }
    const HINT: &str = "name another folder, or add --force to replace this one";
    if let Some(other) = manifest.as_ref().map(|m| m.command.as_str()).filter(|c| *c != command) {
        return Err(Failure::new(format!("{shown}: this folder was written by {other}"), HINT));
    }
    let mut changed = Vec::new();
    for name in found.iter().filter(|name| *name != NAME) {
        let bytes =
            fs::read(folder.join(name)).map_err(|e| Failure::file(&folder.join(name), &e))?;
        if listed(name).is_some_and(|file| file.sha256 != steerwright_formats::sha256_hex(&bytes)) {
            changed.push(name.as_str());
        }
    }
    if !changed.is_empty() {
        let message =
            format!("{shown}: files were changed since {command} wrote them: {}", few(&changed));
        return Err(Failure::new(message, HINT));
    }
    Ok(())
}

/// Names of everything below a folder that is no folder, with slashes between.
fn walk(folder: &Path, prefix: &str, names: &mut Vec<String>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if IGNORED.contains(&name.as_str()) {
            continue;
        }
        let name = format!("{prefix}{name}");
        if entry.file_type()?.is_dir() {
            walk(&entry.path(), &format!("{name}/"), names)?;
        } else {
            names.push(name);
        }
    }
    Ok(())
}

/// The first names, and how many more.
fn few(names: &[&str]) -> String {
    const SHOWN: usize = 4;
    let shown = names.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
