// Included by the build script next to it and by xtask.

/// Folder and FMU name of each library: the folders of `fmu/` that have an example of the FMU's document, by name.
/// The package is `steerwright-` and the folder.
fn libraries(fmu: &std::path::Path) -> std::io::Result<Vec<(String, String)>> {
    let mut libraries = Vec::new();
    for entry in std::fs::read_dir(fmu)? {
        let entry = entry?;
        if entry.path().join("example.json").is_file() {
            let folder = entry.file_name().to_string_lossy().into_owned();
            let mut name = String::new();
            for word in folder.split('-') {
                let (first, rest) = word.split_at(1);
                name.push_str(&first.to_uppercase());
                name.push_str(rest);
            }
            libraries.push((folder, name));
        }
    }
    libraries.sort();
    Ok(libraries)
}
