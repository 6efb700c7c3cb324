//! Definitions of messages of ROS as packages have them.

use crate::documents::files;
use crate::failure::Failure;
use std::collections::BTreeMap;
use std::path::Path;

/// The definitions of messages in a folder and those below it, by package and name; of a package that stands in it
/// twice, the first.
pub(crate) fn read(folder: &Path) -> Result<BTreeMap<String, String>, Failure> {
    const DEEPEST: usize = 12;
    const MOST_BYTES: u64 = 1 << 20;
    let fault = |path: &Path, e: &std::io::Error| Failure::file(path, e);
    let mut found = BTreeMap::new();
    let top = folder.canonicalize().map_err(|e| fault(folder, &e))?;
    let mut folders = vec![(top, 0)];
    while let Some((folder, depth)) = folders.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|e| fault(&folder, &e))?;
        let mut paths = entries
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|e| fault(&folder, &e))?;
        paths.sort_unstable_by(|a, b| b.cmp(a));
        for path in paths {
            // A link may lead back to a folder above.
            if path.is_dir() && depth < DEEPEST && !path.is_symlink() {
                folders.push((path, depth + 1));
            } else if path.extension().is_some_and(|end| end == "msg") {
                let Some(kind) = type_of(&path) else { continue };
                let metadata = std::fs::metadata(&path).map_err(|e| fault(&path, &e))?;
                if metadata.is_file() && metadata.len() <= MOST_BYTES {
                    found
                        .entry(kind)
                        .or_insert(String::from_utf8_lossy(&files::read(&path)?).into_owned());
                }
            }
        }
    }
    if found.is_empty() {
        return Err(Failure::new(
            format!("{}: no definition of a message (.msg) is in this folder", folder.display()),
            "name the folder of the package, or one above it, such as /opt/ros/humble/share",
        ));
    }
    Ok(found)
}

/// `PACKAGE/NAME` of a file `PACKAGE/msg/NAME.msg` or `PACKAGE/NAME.msg`.
fn type_of(path: &Path) -> Option<String> {
    let folders = path.ancestors().skip(1).filter_map(Path::file_name);
    let package = folders.map(|name| name.to_string_lossy()).find(|name| name != "msg")?;
    Some(format!("{package}/{}", path.file_stem()?.to_string_lossy()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_found_in_packages_and_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &[u8]| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let error = read(folder.path()).unwrap_err();
        assert!(error.message().contains("no definition of a message"), "{error:?}");
        write("share/a_msgs/msg/Wheel.msg", b"float64 angle # in \xb0\n");
        write("share/b_msgs/Axle.msg", b"float32 x\n");
        write("share/b_msgs/README.md", b"none\n");
        let found = |path: &str| -> Vec<String> {
            read(&folder.path().join(path)).unwrap().into_keys().collect()
        };
        assert_eq!(found(""), ["a_msgs/Wheel", "b_msgs/Axle"]);
        assert_eq!(found("share/a_msgs/msg"), ["a_msgs/Wheel"]);
        assert!(read(&folder.path().join("none")).is_err());
    }
}
