//! The outputs of the commands as files of a folder, and two such folders compared.

use crate::files::{all_below, write};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Lines that are shown of a file that differs.
const SHOWN_LINES: usize = 3;

/// Characters that are shown of a line, from a few before its difference on.
const SHOWN: usize = 160;
const BEFORE: usize = 40;

/// An output of a command: its exit status, what it printed, a file or a member of an archive.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Output {
    pub(super) command: String,
    pub(super) file: String,
    pub(super) content: Vec<u8>,
}

/// Writes a recording into a folder, which must be new.
pub(super) fn save(outputs: &[Output], folder: &Path) -> Result<(), String> {
    for output in outputs {
        write(&folder.join(&output.command).join(&output.file), &output.content)?;
    }
    Ok(())
}

/// Prints how two recordings differ; returns in how many files.
pub(super) fn compare(before: &Path, now: &Path) -> Result<usize, String> {
    let (before, now) = (read(before)?, read(now)?);
    let mut names: Vec<_> = before.keys().chain(now.keys()).collect();
    names.sort();
    names.dedup();
    let mut count = 0;
    for name in names {
        let difference = match (before.get(name), now.get(name)) {
            (Some(before), Some(now)) if before == now => continue,
            (Some(before), Some(now)) => lines(before, now),
            (Some(_), None) => "  is no longer written\n".into(),
            (None, _) => "  was not written before\n".into(),
        };
        println!("{name}\n{difference}");
        count += 1;
    }
    Ok(count)
}

fn read(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let content = |file: &Path| {
        let name = file.strip_prefix(folder).unwrap_or(file).display().to_string();
        Ok((name, fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?))
    };
    all_below(folder)?.iter().map(|file| content(file)).collect()
}

/// The first lines that differ between two contents.
fn lines(before: &[u8], now: &[u8]) -> String {
    let (Ok(before), Ok(now)) = (std::str::from_utf8(before), std::str::from_utf8(now)) else {
        return format!("  {} bytes, before {}, which differ\n", now.len(), before.len());
    };
    let count = before.lines().count().max(now.lines().count());
    let (mut before, mut now) = (before.split('\n'), now.split('\n'));
    let mut text = String::new();
    let pairs = (0..=count).map(|k| (k + 1, before.next(), now.next()));
    for (number, before, now) in pairs.filter(|(_, b, n)| b != n).take(SHOWN_LINES) {
        let (before, now) = (before.unwrap_or("(no line)"), now.unwrap_or("(no line)"));
        let (before, now) = around(before, now);
        text += &format!("  line {number}\n  - {before}\n  + {now}\n");
    }
    text
}

/// The part of two lines about their first difference.
fn around(before: &str, now: &str) -> (String, String) {
    let same = before.chars().zip(now.chars()).take_while(|(a, b)| a == b).count();
    let part = |line: &str| line.chars().skip(same.saturating_sub(BEFORE)).take(SHOWN).collect();
    (part(before), part(now))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_first_lines_that_differ_are_shown_about_their_difference() {
        let before = format!("same\n{}0.25 end\nb\nc\nd\ne", "x".repeat(300));
        let now = before.replace("0.25", "0.250001").replace("b\nc\nd\ne", "B\nC\nD");
        let text = lines(before.as_bytes(), now.as_bytes());
        let x = "x".repeat(36);
        let shown = format!("  line 2\n  - {x}0.25 end\n  + {x}0.250001 end\n");
        assert_eq!(text, shown + "  line 3\n  - b\n  + B\n  line 4\n  - c\n  + C\n");
        assert_eq!(lines(b"a", b"a\n"), "  line 2\n  - (no line)\n  + \n");
        assert_eq!(lines(b"a\nb", b"a"), "  line 2\n  - b\n  + (no line)\n");
        assert_eq!(lines(b"\xff", b"\xfe1"), "  2 bytes, before 1, which differ\n");
    }

    #[test]
    fn the_last_bit_a_missing_file_and_a_new_one_are_differences() {
        let folder = crate::run::target().join("tmp/snapshot-recordings");
        crate::files::remove(&folder).unwrap();
        let output = |file: &str, content: &str| Output {
            command: "demo".into(),
            file: file.into(),
            content: content.into(),
        };
        let (before, now) = (folder.join("before"), folder.join("now"));
        let same = output("A.fmu/modelDescription.xml", "<a/>");
        save(&[same.clone(), output("old", ""), output("pid.json", "0.3")], &before).unwrap();
        save(&[same, output("new", ""), output("pid.json", "0.30000000000000004")], &now).unwrap();
        assert_eq!(compare(&before, &before), Ok(0));
        assert_eq!(compare(&before, &now), Ok(3));
        assert!(compare(&before, &folder.join("none")).unwrap_err().contains("none"));
    }
}
