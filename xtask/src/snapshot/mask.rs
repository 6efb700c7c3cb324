//! What differs from run to run, or with the libraries of the FMUs, is replaced by a name of it.

use sha2::{Digest, Sha256};
use std::path::Path;

/// The masks of one recording.
pub(super) struct Masks {
    /// A text and what replaces it, in this order.
    texts: Vec<(String, &'static str)>,
}

impl Masks {
    /// `work` is the folder in which the commands run.
    pub(super) fn new(work: &Path, root: &Path) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        let texts = vec![
            (work.display().to_string(), "<work>"),
            (root.display().to_string(), "<root>"),
            (std::env::temp_dir().join("").display().to_string(), "<temporary>/"),
            (format!("steerwright {version}"), "steerwright <version>"),
        ];
        Self { texts }
    }

    /// A text without what differs from run to run.
    pub(super) fn mask(&self, text: &str) -> String {
        let mut lines = String::with_capacity(text.len());
        for line in text.split_inclusive('\n').filter(|line| !is_progress(line)) {
            lines += &without_needs(line);
        }
        replaced(lines, &self.texts)
    }
}

/// A text with replacements, one after the other.
pub(super) fn replaced(mut text: String, replacements: &[(String, &str)]) -> String {
    for (from, to) in replacements {
        if text.contains(from) {
            text = text.replace(from, to);
        }
    }
    text
}

/// What the libraries in an archive change of texts about it: its hash and its size.
pub(super) fn of_archive(archive: &[u8]) -> [(String, &'static str); 3] {
    let hash: String = Sha256::digest(archive).iter().map(|byte| format!("{byte:02x}")).collect();
    let size = archive.len();
    [
        (hash, "<hash of an archive>"),
        (format!("\"bytes\": {size}"), "\"bytes\": <size>"),
        (format!("{} kB", size.div_ceil(1000)), "<size>"),
    ]
}

/// A text without the hash of a sweep's study, which is also of the libraries: 16 hexadecimal digits.
pub(super) fn without_study(text: &str) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '.';
    let is_hash = |word: &str| {
        word.len() == 16
            && word.bytes().all(|byte| byte.is_ascii_hexdigit())
            && word.bytes().any(|byte| byte.is_ascii_alphabetic())
    };
    let mut masked = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let word = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
        let other = rest[word.len()..].chars().next();
        // A name of a file ends with its extension.
        let (stem, end) = word.split_at(word.find('.').unwrap_or(word.len()));
        if is_hash(stem) {
            masked += "<study>";
            masked += end;
        } else {
            masked += word;
        }
        masked.extend(other);
        rest = &rest[word.len() + other.map_or(0, char::len_utf8)..];
    }
    masked
}

/// A line without the libraries of the system and the glibc that a library of an FMU needs: those of its build.
fn without_needs(line: &str) -> String {
    const WORD: &str = "needs ";
    let Some(at) = line.find(WORD).map(|at| at + WORD.len()) else { return line.into() };
    let (before, after) = line.split_at(at);
    let end = after.find(['"', '[']).unwrap_or(after.len());
    let (needs, rest) = after.split_at(end);
    match needs.contains(".so") || needs.starts_with("glibc ") {
        true => format!("{before}<of the build>{rest}"),
        false => line.into(),
    }
}

/// Progress is printed by the clock.
fn is_progress(line: &str) -> bool {
    line.starts_with("progress: ") || line.starts_with("{\"progress\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_and_size_of_an_archive_are_masked() {
        let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let text = format!("{hash} \"bytes\": 3, 1 kB, 13");
        let masked = "<hash of an archive> \"bytes\": <size>, <size>, 13";
        assert_eq!(replaced(text, &of_archive(b"abc")), masked);
    }

    #[test]
    fn folders_versions_progress_and_the_hashes_of_studies_are_masked() {
        let masks = Masks::new(Path::new("/here/work"), Path::new("/here"));
        let version = env!("CARGO_PKG_VERSION");
        let text =
            format!("/here/work/a.csv /here/b steerwright {version}\nprogress: reading, 2 s\nend");
        assert_eq!(masks.mask(&text), "<work>/a.csv <root>/b steerwright <version>\nend");
        assert_eq!(masks.mask("{\"progress\":{}}\n{\"note\":1}\n"), "{\"note\":1}\n");
        assert_eq!(
            masks.mask("A.so: needs libc.so.6, libm.so.6 [2.3]\n"),
            "A.so: needs <of the build>[2.3]\n"
        );
        assert_eq!(masks.mask("\"needs glibc 2.14\",\n"), "\"needs <of the build>\",\n");
        assert_eq!(masks.mask("the road needs 0.4 rad/s\n"), "the road needs 0.4 rad/s\n");
        let study = "runs-0-3-0123456789abcdef.csv";
        assert_eq!(without_study(study), "runs-0-3-<study>.csv");
        let numbers = "1,0.1234567890123456,0.12345e-12,0123456789abcdef0";
        assert_eq!(without_study(numbers), numbers);
    }
}
