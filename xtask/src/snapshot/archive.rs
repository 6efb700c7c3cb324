//! Archives are recorded as folders of their members.

use std::io::{Cursor, Read};
use zip::ZipArchive;

/// How an archive begins.
const BEGINNING: &[u8] = b"PK\x03\x04";

/// Libraries are listed without their content, which a compiler may change.
const LIBRARIES: &str = "binaries/";

pub(super) fn is_archive(content: &[u8]) -> bool {
    content.starts_with(BEGINNING)
}

/// A file with its content; an archive as its members, below a folder of its name.
pub(super) fn opened(name: &str, bytes: Vec<u8>) -> Result<Vec<(String, Vec<u8>)>, String> {
    if !is_archive(&bytes) {
        return Ok(vec![(name.to_owned(), bytes)]);
    }
    let problem = |e: &dyn std::fmt::Display| format!("{name}: {e}");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| problem(&e))?;
    let (mut list, mut members) = (String::new(), Vec::new());
    for index in 0..archive.len() {
        let mut member = archive.by_index(index).map_err(|e| problem(&e))?;
        let path = member.name().map_err(|e| problem(&e))?.into_owned();
        let modified = member.last_modified().map(|time| time.to_string()).unwrap_or_default();
        list += &format!("{path} {} {modified}\n", member.compression());
        if member.is_file() && !path.starts_with(LIBRARIES) {
            let mut content = Vec::new();
            member.read_to_end(&mut content).map_err(|e| problem(&e))?;
            members.extend(opened(&format!("{name}/{path}"), content)?);
        }
    }
    members.push((format!("{name}/members"), list.into_bytes()));
    Ok(members)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use std::io::Write;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in members {
            writer.start_file(*name, SimpleFileOptions::default()).unwrap();
            writer.write_all(content).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn members_are_recorded_those_of_inner_archives_too_and_libraries_by_name() {
        let inner = archive(&[("modelDescription.xml", b"<a/>"), ("binaries/linux64/a.so", b"x")]);
        let outer = archive(&[("resources/A.fmu", &inner)]);
        let found = opened("Loop.ssp", outer).unwrap();
        let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
        let expected = ["A.fmu/modelDescription.xml", "A.fmu/members"]
            .map(|name| format!("Loop.ssp/resources/{name}"));
        assert_eq!(names, [&expected[0], &expected[1], "Loop.ssp/members"]);
        assert_eq!(found[0].1, b"<a/>");
        let list = String::from_utf8(found[1].1.clone()).unwrap();
        assert!(list.contains("binaries/linux64/a.so Deflated"), "{list}");
        assert_eq!(opened("a.csv", b"1,2".to_vec()).unwrap(), [("a.csv".into(), b"1,2".to_vec())]);
        assert!(opened("broken.fmu", BEGINNING.to_vec()).unwrap_err().starts_with("broken.fmu: "));
    }
}
