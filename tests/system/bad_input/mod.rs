//! Bad input: exit status 2, one error that names the place, one hint, and nothing written.

mod files;
mod logs;

use crate::support::{names, run, text_of};

/// Files to write, arguments, and parts of the error and its hint.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a [&'a str]);

fn refused((files, line, says): Case<'_>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let before = names(folder.path());
    let output = run(folder.path(), line);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{line}: {text}");
    assert!(output.stdout.is_empty(), "{line}: something on stdout");
    let starting = |word: &str| text.lines().filter(|l| l.starts_with(word)).count();
    assert_eq!((starting("error: "), starting("hint: ")), (1, 1), "{line}: {text}");
    assert!(text.starts_with("error: "), "{line}: {text}");
    for part in says {
        assert!(text.contains(part), "{line}: no `{part}` in: {text}");
    }
    assert!(text.lines().all(|l| l.chars().count() < 700), "{line}: {text}");
    assert_eq!(names(folder.path()), before, "{line}: something was written");
}
