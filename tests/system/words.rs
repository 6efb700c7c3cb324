//! Sources and documents use the terms of the field.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Words that are not used, with what replaces them; a `*` at the end also matches longer words.
const WORDS: &[(&str, &str)] = &[
    ("absorb*", "accumulate"),
    ("anew", "again"),
    ("beside", "compared with, next to, in addition to"),
    ("crooked*", "steering offset"),
    ("give way", "relaxed constraint, saturate"),
    ("gives way", "relaxed constraint, saturates"),
    ("hears of", "receives"),
    ("held out", "validation data"),
    ("held-out", "validation"),
    ("hold out", "validate"),
    ("hold-out", "validation data"),
    ("mend", "fix, correct"),
    ("mended", "fixed, corrected"),
    ("mends", "fixes, corrects"),
    ("nearness", "model error"),
    ("patience", "early-stopping bounds"),
    ("quickest", "bandwidth limit, fastest"),
    ("reckon*", "use, compute"),
    ("stand for", "represent"),
    ("stands for", "represents"),
    ("stretch", "segment"),
    ("stretches", "segments"),
    ("tell", "report, distinguish"),
    ("telling", "reporting"),
    ("tells", "reports"),
    ("told", "reported"),
    ("urgency", "slack"),
];

/// Terms and names in files that contain one of the words.
const TERMS: &[&str] = &["dead reckon", "dead-reckon", "horizon_absorbed"];

/// Files that are not searched: this list, texts that were published (the licences are part of each archive),
/// and a file whose hash identifies recorded results.
const EXCEPT: &[&str] = &[
    "tests/system/words.rs",
    "CHANGELOG.md",
    "xtask/src/licenses.rs",
    "tests/experiment/oracle.py",
];

/// Sources and documents below a folder; build products and hidden files apart.
fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        if name.starts_with('.') || name == "target" {
            continue;
        }
        if path.is_dir() {
            texts(&path, found);
        } else if path
            .extension()
            .is_some_and(|e| ["rs", "py", "toml", "md"].iter().any(|x| e == *x))
        {
            found.push(path);
        }
    }
}

/// The words of the list in a line, each with its replacement.
fn dialect(line: &str) -> Vec<(&'static str, &'static str)> {
    let mut line = line.to_lowercase();
    TERMS.iter().for_each(|term| line = line.replace(term, ""));
    let is_in = |word: &str| {
        let (stem, open) = word.strip_suffix('*').map_or((word, false), |stem| (stem, true));
        line.match_indices(stem).any(|(at, _)| {
            let before = line[..at].chars().next_back();
            let after = line[at + stem.len()..].chars().next();
            !before.is_some_and(char::is_alphabetic)
                && (open || !after.is_some_and(char::is_alphabetic))
        })
    };
    WORDS.iter().filter(|(word, _)| is_in(word)).copied().collect()
}

#[test]
fn the_words_are_those_of_the_field() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    texts(root, &mut files);
    assert!(files.len() > 200, "{} files", files.len());
    files.sort();
    let mut found = String::new();
    for file in &files {
        let name = file.strip_prefix(root).unwrap();
        if EXCEPT.iter().any(|except| name.starts_with(except)) {
            continue;
        }
        // In TOML the values are data.
        let comments_alone = file.extension().is_some_and(|e| e == "toml");
        let text = std::fs::read_to_string(file).unwrap();
        for (number, line) in text.lines().enumerate() {
            let line = match line.split_once('#') {
                _ if !comments_alone => line,
                Some((_, comment)) => comment,
                None => continue,
            };
            for (word, instead) in dialect(line) {
                let _ = writeln!(found, "{}:{}: `{word}`: {instead}", name.display(), number + 1);
            }
        }
    }
    assert!(found.is_empty(), "words that are not the field's:\n{found}");
}

#[test]
fn words_are_found_in_prose_and_names_and_terms_are_not() {
    let words = |line: &str| dialect(line).iter().map(|(word, _)| *word).collect::<Vec<_>>();
    assert_eq!(words("/// What cannot be met is Told."), ["told"]);
    assert_eq!(words("fn a_fault_is_told_twice()"), ["told"]);
    assert_eq!(words("absorbed drives, next to held-out data"), ["absorb*", "held-out"]);
    assert_eq!(words("the estimator dead-reckons; a saltold; \"held_out\": 1"), [""; 0]);
}
