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
            lines += line;
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

/// A text without the platforms whose libraries a build may have beside those of linux64.
pub(super) fn without_other_platforms(text: &str) -> String {
    const OTHERS: [&str; 4] = ["win64", "aarch64-linux", "darwin64", "aarch64-darwin"];
    let is_of_other =
        |line: &str| OTHERS.iter().any(|platform| line.contains(&format!("binaries/{platform}/")));
    let mut rest: String = text.split_inclusive('\n').filter(|line| !is_of_other(line)).collect();
    // In tables after a blank, in JSON after a comma, on a line of its own.
    for platform in OTHERS {
        rest = rest.replace(&format!("linux64 {platform}"), "linux64");
        let quoted = format!("\"{platform}\"");
        while let Some(at) = rest.find(&quoted) {
            let before = rest[..at].trim_end();
            let Some(before) = before.strip_suffix(',') else { break };
            rest = format!("{before}{}", &rest[at + quoted.len()..]);
        }
    }
    rest
}

/// Progress is printed by the clock.
fn is_progress(line: &str) -> bool {
    line.starts_with("progress: ") || line.starts_with("{\"progress\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_platforms_than_linux64_are_left_out() {
        let own = "<td>binaries/linux64/A.so</td>\n\"platforms\": [\n  \"linux64\"\n], A.fmu linux64 {1}\n";
        let both = "<td>binaries/linux64/A.so</td>\n<td>binaries/win64/A.dll</td>\n\"platforms\": [\n  \
                    \"linux64\",\n  \"win64\"\n], A.fmu linux64 win64 {1}\n";
        assert_eq!(without_other_platforms(both), own);
        assert_eq!(without_other_platforms(own), own);
    }

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
        let study = "runs-0-3-0123456789abcdef.csv";
        assert_eq!(without_study(study), "runs-0-3-<study>.csv");
        let numbers = "1,0.1234567890123456,0.12345e-12,0123456789abcdef0";
        assert_eq!(without_study(numbers), numbers);
    }
}
