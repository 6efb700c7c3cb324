//! Whatever ends a command, nothing that it started runs on, what it left goes with the next run, and no two share
//! a file of results.

use crate::crashing::{Behaviour, binary_path, library, xml, zip_of};
use crate::support::text_of;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Runs of an FMU, with this behaviour each.
fn study(misbehaviour: &str) -> String {
    format!(
        "seed = 3\nruns = 1\nstep_s = 0.01\nstop_s = 0.5\nfmu = [{{ file = \"one.fmu\", name = \"plant\" }}]\n\
         [[vary]]\nvariables = [\"plant.misbehaviour\"]\ndistribution = \"grid\"\nvalues = [{misbehaviour}]\n\
         [[metric]]\nname = \"y\"\nvariable = \"plant.y\"\nkind = \"final\"\n"
    )
}

/// A folder with an FMU `one.fmu`, the folders `temporary` and `hanging`, and studies.
struct Place(tempfile::TempDir);

impl Place {
    /// `None` without a C compiler.
    fn new(behaviour: Behaviour) -> Option<Self> {
        let library = library(behaviour)?;
        let place = Self(tempfile::tempdir().unwrap());
        let described = xml(("u", ""), ("y", ""));
        let files = [("modelDescription.xml", described.as_bytes()), (&binary_path(), library)];
        fs::write(place.path().join("one.fmu"), zip_of(&files)).unwrap();
        for folder in ["temporary", "hanging"] {
            fs::create_dir(place.path().join(folder)).unwrap();
        }
        for (name, misbehaviour) in
            [("good", "0, 0, 0"), ("second", "0, 15, 0"), ("first", "15, 0, 0"), ("two", "15, 15")]
        {
            fs::write(place.path().join(format!("{name}.toml")), study(misbehaviour)).unwrap();
        }
        Some(place)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_steerwright"));
        command
            .args(line.split(' '))
            .current_dir(self.path())
            .env("TMPDIR", self.path().join("temporary"))
            .env("HANGS_IN", self.path().join("hanging"));
        command
    }

    /// Starts a command and waits until that many processes hang in an FMU; a file of each, which it has locked.
    fn hanging(&self, line: &str, count: usize) -> (Child, Vec<PathBuf>) {
        let hanging = self.path().join("hanging");
        for file in names(&hanging) {
            fs::remove_file(hanging.join(file)).unwrap();
        }
        let child =
            self.command(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        wait(line, || names(&hanging).len() == count);
        (child, names(&hanging).iter().map(|name| hanging.join(name)).collect())
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// What commands left in the folder for temporary files.
    fn left(&self) -> Vec<String> {
        names(&self.path().join("temporary"))
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// The unfinished pieces in a folder.
fn parts(folder: PathBuf) -> usize {
    names(&folder).iter().filter(|name| name.ends_with(".part")).count()
}

fn wait(what: &str, mut until: impl FnMut() -> bool) {
    let began = Instant::now();
    while !until() {
        assert!(began.elapsed() < Duration::from_secs(120), "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Whether this process ignores SIGINT, as the shell has it for background commands of scripts; its children then do.
fn interrupts_are_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.unwrap_or_default() & (1 << (Signal::INT.as_raw() - 1)) != 0
}

#[test]
fn a_child_ends_with_its_parent_however_that_ends() {
    let Some(place) = Place::new(Behaviour::Hanging) else { return };
    for (line, count) in [
        ("check --run --time-limit 900s one.fmu", 1),
        ("sweep two.toml --isolate --threads 2 --force -o results.csv", 2),
    ] {
        for how in [Signal::INT, Signal::TERM, Signal::KILL] {
            if how == Signal::INT && interrupts_are_ignored() {
                println!("not interrupted: in the background of a script nothing is");
                continue;
            }
            let (mut child, processes) = place.hanging(line, count);
            signal(&child, how);
            child.wait().unwrap();
            let runs_on = |file: &PathBuf| fs::File::open(file).unwrap().try_lock().is_err();
            wait(line, || !processes.iter().any(runs_on));
        }
    }
    // What the killed ones left goes with the next run.
    assert_ne!(place.left(), [""; 0]);
    place.run("check --run --time-limit 1s one.fmu");
    assert_eq!(place.left(), [""; 0]);
}

#[test]
fn an_interrupted_sweep_waits_for_no_hanging_fmu() {
    let Some(place) = Place::new(Behaviour::Integrator) else { return };
    for how in ["--isolate", "--timeout 600s"] {
        let line = format!("sweep second.toml --threads 1 {how} -o results.csv --force");
        let (child, _) = place.hanging(&line, 1);
        let began = Instant::now();
        signal(&child, Signal::INT);
        let ended = child.wait_with_output().unwrap();
        assert!(began.elapsed() < Duration::from_secs(60), "that is a tenth of the time limit");
        assert_eq!(ended.status.code(), Some(2), "{}", text_of(&ended));
        let text = text_of(&ended);
        assert!(text.contains("interrupted: ") && text.contains("holds 1 of 3 runs"), "{text}");
    }
}

#[test]
fn two_sweeps_share_no_results() {
    let Some(place) = Place::new(Behaviour::Integrator) else { return };
    let (mut first, _) = place.hanging("sweep second.toml --isolate --threads 1 -o one.csv", 1);
    // The row of the run before the one that hangs may be written a little later.
    let read = || fs::read(place.path().join("one.csv")).unwrap();
    wait("the first row", || read().iter().filter(|byte| **byte == b'\n').count() == 2);
    let before = read();
    std::os::unix::fs::symlink("one.csv", place.path().join("link.csv")).unwrap();
    for other in ["-o one.csv", "-o one.csv --force", "-o one.csv --resume", "-o link.csv --force"]
    {
        let refused = place.run(&format!("sweep good.toml {other}"));
        assert_eq!(refused.status.code(), Some(2), "{other}: {}", text_of(&refused));
        let text = text_of(&refused);
        assert!(text.contains("another run is writing this file"), "{other}: {text}");
    }
    // Nor does another command write over them.
    let refused = place.run("simulate one.fmu --stop 1s -o one.csv --force");
    assert_eq!(refused.status.code(), Some(2), "{}", text_of(&refused));
    assert!(
        text_of(&refused).contains("another run is writing this file"),
        "{}",
        text_of(&refused)
    );
    assert!(before == read());
    first.kill().unwrap();
    first.wait().unwrap();
    let next = place.run("sweep good.toml -o one.csv --force");
    assert_eq!(next.status.code(), Some(0), "{}", text_of(&next));
    assert_eq!(names(place.path()).iter().filter(|name| name.contains("one.csv")).count(), 1);
}

#[test]
fn parts_of_killed_shards_go_with_the_next_run_and_no_others() {
    let Some(place) = Place::new(Behaviour::Integrator) else { return };
    let pieces = || place.path().join("pieces");
    let shard = |k: usize| format!("sweep first.toml --isolate --threads 1 --shard {k}/3");
    let (mut first, _) = place.hanging(&shard(0), 1);
    assert_eq!(parts(pieces()), 1);
    let output = place.run(&shard(1));
    assert_eq!((output.status.code(), parts(pieces())), (Some(0), 1), "{}", text_of(&output));
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(parts(pieces()), 1);
    place.run(&shard(2));
    assert_eq!(parts(pieces()), 0);
}

#[test]
fn an_ignored_hangup_stays_ignored() {
    let Some(place) = Place::new(Behaviour::Integrator) else { return };
    // As `nohup` starts it.
    let sweep = "sweep second.toml --threads 1 --isolate --timeout 2s -o results.csv";
    let mut ignoring = Command::new("sh");
    ignoring
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_steerwright")])
        .args(sweep.split(' '))
        .current_dir(place.path())
        .env("HANGS_IN", place.path().join("hanging"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let child = ignoring.spawn().unwrap();
    wait("no FMU hangs", || !names(&place.path().join("hanging")).is_empty());
    signal(&child, Signal::HUP);
    let ended = child.wait_with_output().unwrap();
    assert!(!text_of(&ended).contains("interrupted"), "{}", text_of(&ended));
    assert_eq!(fs::read_to_string(place.path().join("results.csv")).unwrap().lines().count(), 4);
}
