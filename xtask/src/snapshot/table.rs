//! `tests/snapshot.csv`: the fingerprint of each output. The members of an archive are one output.

use super::fingerprint::{Fingerprint, to_text};
use super::recording::Output;
use std::collections::BTreeMap;

const HEADER: &str = "command,file,text,numbers,sum,norm";

/// Command and file of each fingerprint.
pub(super) type Table = BTreeMap<(String, String), Fingerprint>;

/// The fingerprints of a recording.
pub(super) fn table(outputs: &[Output]) -> Table {
    let mut texts: BTreeMap<(String, String), String> = BTreeMap::new();
    for output in outputs {
        let file = archive(&output.file);
        let text = texts.entry((output.command.clone(), file.to_owned())).or_default();
        if file != output.file {
            *text += &format!("{}\n", output.file);
        }
        *text += &to_text(&output.content);
    }
    texts.into_iter().map(|(key, text)| (key, Fingerprint::new(&text))).collect()
}

/// The archive that a member is in, or the file itself.
fn archive(file: &str) -> &str {
    let ends = [".fmu/", ".ssp/"].iter().filter_map(|end| Some(file.find(end)? + end.len() - 1));
    ends.min().map_or(file, |end| &file[..end])
}

pub(super) fn to_csv(table: &Table) -> String {
    let rows = table.iter().map(|((command, file), of)| format!("{command},{file},{of}\n"));
    format!("{HEADER}\n{}", rows.collect::<String>())
}

pub(super) fn from_csv(text: &str) -> Result<Table, String> {
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return Err(format!("the first line is not {HEADER}"));
    }
    let row = |line: &str| {
        let mut cells = line.splitn(3, ',');
        let mut cell = || cells.next().ok_or_else(|| format!("{line:?} is no row"));
        let key = (cell()?.to_owned(), cell()?.to_owned());
        Ok((key, cell()?.parse()?))
    };
    lines.map(row).collect()
}

/// What differs between an earlier table and one of now, a line an output.
pub(super) fn differences(before: &Table, now: &Table) -> Vec<String> {
    let mut keys: Vec<_> = before.keys().chain(now.keys()).collect();
    keys.sort();
    keys.dedup();
    let difference = |key: &(String, String)| match (before.get(key), now.get(key)) {
        (Some(before), Some(now)) => now.difference(before),
        (Some(_), None) => Some("is no longer written".into()),
        (None, _) => Some("was not written before".into()),
    };
    let line = |key: &(String, String)| {
        difference(key).map(|what| format!("{}: {}: {what}", key.0, key.1))
    };
    keys.into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn output(command: &str, file: &str, content: &str) -> Output {
        Output { command: command.into(), file: file.into(), content: content.into() }
    }

    #[test]
    fn a_table_is_read_as_it_is_written_and_members_are_those_of_their_archive() {
        let outputs = [
            output("demo", "a/A.fmu/modelDescription.xml", "<a v=\"1.5\"/>"),
            output("demo", "a/A.fmu/members", "a, b"),
            output("demo", "stdout", "gain 0.3"),
        ];
        let written = to_csv(&table(&outputs));
        let files: Vec<_> = written.lines().skip(1).map(|l| l.split(',').nth(1).unwrap()).collect();
        assert_eq!(files, ["a/A.fmu", "stdout"]);
        let read = from_csv(&written).unwrap();
        assert_eq!(to_csv(&read), written);
        assert_eq!(differences(&read, &table(&outputs)), [""; 0]);
        for broken in ["", "a,b\n", &format!("{HEADER}\na,b,c\n")] {
            assert!(from_csv(broken).is_err(), "{broken}");
        }
    }

    #[test]
    fn a_difference_names_command_and_file() {
        let before = [output("demo", "stdout", "gain 0.3"), output("demo", "pid.json", "{}")];
        let now = [
            output("demo", "stdout", "gain 0.4"),
            output("demo", "A.fmu/members", ""),
            output("design", "status", "0"),
        ];
        let found = differences(&table(&before), &table(&now));
        let expected = [
            "demo: A.fmu: was not written before",
            "demo: pid.json: is no longer written",
            "demo: stdout: of 1 numbers some differ",
            "design: status: was not written before",
        ];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (line, start) in found.iter().zip(expected) {
            assert!(line.starts_with(start), "{line}");
        }
    }
}
