//! A folder of results is the old one or the new one, whole, whatever happens to the command.

use crate::support::{self, content, names, text_of, words};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

const BUILD: &str = "build {data}/multibody/drive.csv --input-channel steering_command_rad --horizon 10 --robust off";

/// A folder with a build in `out`; a copy for each test.
fn built() -> tempfile::TempDir {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("folders");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        run(&folder, &format!("{BUILD} --order 2"), &[0, 1]);
        folder
    });
    let copy = tempfile::tempdir().unwrap();
    let done = Command::new("cp").arg("-r").arg(built.join("out")).arg(copy.path()).status();
    assert!(done.unwrap().success());
    copy
}

/// Runs; returns the text on stderr.
fn run(folder: &Path, line: &str, status: &[i32]) -> String {
    let output = support::run(folder, line);
    let text = text_of(&output);
    assert!(output.status.code().is_some_and(|code| status.contains(&code)), "{line}: {text}");
    text
}

/// Starts a build of another model and waits until it has written a file.
fn started(folder: &Path) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(words(&format!("{BUILD} --order 3"), Path::new("")))
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let old = fs::read(folder.join("out/plant.json")).unwrap();
    loop {
        let siblings = fs::read_dir(folder).unwrap().filter_map(|e| Some(e.ok()?.path()));
        let begun = siblings.filter(|path| path.is_dir()).any(|path| {
            fs::read(path.join("plant.json")).is_ok_and(|plant| plant != old && !plant.is_empty())
        });
        if begun {
            return child;
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        assert!(began.elapsed() < Duration::from_secs(300), "it writes nothing");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_killed_build_leaves_the_old_result_and_the_next_one_cleans_up() {
    let folder = built();
    let out = folder.path().join("out");
    let before = content(&out);
    let mut child = started(folder.path());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(content(&out) == before, "the old result is no longer whole");
    run(folder.path(), &format!("{BUILD} --order 3"), &[0, 1]);
    assert!(content(&out) != before);
    assert_eq!(names(folder.path()), ["out"], "something is left");
}

#[test]
fn an_interrupted_build_leaves_the_old_result_and_nothing_else() {
    let folder = built();
    let out = folder.path().join("out");
    let before = content(&out);
    let child = started(folder.path());
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupt.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(
        text_of(&output).contains("error: interrupted: out is as it was"),
        "{}",
        text_of(&output)
    );
    assert!(content(&out) == before, "the old result is no longer whole");
    assert_eq!(names(folder.path()), ["out"], "something is left");
}

#[test]
fn two_builds_of_one_folder_exclude_each_other() {
    let folder = built();
    let mut first = started(folder.path());
    // By another name of the same folder too.
    std::os::unix::fs::symlink("out", folder.path().join("alias")).unwrap();
    for out in ["out", "alias"] {
        let text = run(folder.path(), &format!("{BUILD} --out {out}"), &[2]);
        assert!(text.contains(&format!("error: {out}: another run is writing")), "{text}");
    }
    assert!(first.try_wait().unwrap().is_none(), "it was decided after the work");
    // Another folder next to it is free.
    run(folder.path(), &format!("{BUILD} --out other --order 2"), &[0, 1]);
    first.wait().unwrap();
    assert_eq!(names(folder.path()).len(), 3, "{:?}", names(folder.path()));
}

#[test]
fn files_that_it_did_not_write_are_never_removed() {
    let folder = built();
    let out = folder.path().join("out");
    let build = format!("{BUILD} --order 3");
    fs::write(out.join("notes.txt"), "mine").unwrap();
    for line in [build.clone(), format!("{build} --force")] {
        let text = run(folder.path(), &line, &[2]);
        assert!(
            text.contains("out: this folder holds files that build did not write: notes.txt"),
            "{text}"
        );
    }
    fs::remove_file(out.join("notes.txt")).unwrap();
    // A file that was changed since is replaced with --force; so is the folder of another command.
    fs::write(out.join("pid.json"), "{}").unwrap();
    let text = run(folder.path(), &build, &[2]);
    assert!(text.contains("changed since build wrote them: pid.json"), "{text}");
    assert!(text.contains("--force"), "{text}");
    let text = run(folder.path(), "demo --out out", &[2]);
    assert!(text.contains("out: this folder was written by build"), "{text}");
    run(folder.path(), &format!("{build} --force"), &[0, 1]);
    // A folder of files without a list, and places that cannot be replaced.
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    fs::write(own.join("plant.json"), "{}").unwrap();
    let text = run(folder.path(), &format!("{build} --out own --force"), &[2]);
    assert!(text.contains("did not write: plant.json"), "{text}");
    let text = run(&out, &format!("{build} --out ."), &[2]);
    assert!(text.contains("the current one"), "{text}");
    let text = run(folder.path(), "build out/traces.csv", &[2]);
    assert!(text.contains("out/traces.csv is in this folder and is read"), "{text}");
    assert!(!names(folder.path()).iter().any(|name| name.starts_with('.')), "something is left");
}

#[test]
fn a_new_folder_is_made_with_those_above_it_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "build missing.csv --out a/b/c", &[2]);
    assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
    run(folder.path(), &format!("{BUILD} --order 2 --out a/b/c"), &[0, 1]);
    assert!(folder.path().join("a/b/c/report.html").is_file());
    assert_eq!(names(&folder.path().join("a/b")), ["c"]);
}
