//! No output destroys a file: not what is read, not what somebody else wrote, no device, no folder.

use crate::support::{chain, data, run, text_of, words};
use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const LOG: &str = "log.csv --input-channel steering_command_rad --order 2 --horizon 10";
const STUDY: &str = r#"
seed = 1
runs = 1
step_s = 0.01
stop_s = 0.1
[[fmu]]
file = "fmu/IdentifiedPlant.fmu"
[[fmu]]
file = "fmu/ReferencePath.fmu"
[[fmu]]
file = "fmu/LateralPid.fmu"
[[metric]]
name = "largest_m"
variable = "ReferencePath.cross_track_error"
kind = "max-abs"
"#;

/// A folder with a file of each kind that is read.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let copy = |from: PathBuf, to: &str| fs::copy(from, folder.path().join(to)).unwrap();
    fs::create_dir(folder.path().join("fmu")).unwrap();
    copy(data().join("multibody/drive.csv"), "log.csv");
    copy(data().join("multibody/vehicle.toml"), "vehicle.toml");
    copy(data().join("multibody/position.csv"), "track.csv");
    for file in ["plant.json", "bicycle.json", "pid.json", "path.json"] {
        copy(chain().join(file), file);
    }
    for fmu in ["IdentifiedPlant", "LateralPid", "ReferencePath"] {
        copy(chain().join(format!("fmu/{fmu}.fmu")), &format!("fmu/{fmu}.fmu"));
    }
    fs::write(folder.path().join("input.csv"), "time,yaw\n0,0\n1,0\n").unwrap();
    fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    fs::write(folder.path().join("asked.toml"), "settling = \"1s\"\n").unwrap();
    folder
}

/// Refused before any work: exit status 2, one error and one hint, nothing on stdout.
fn refused(folder: &Path, line: &str, says: &[&str]) {
    let output = run(folder, line);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{line}: {text}");
    assert!(output.stdout.is_empty(), "{line}");
    assert!(text.starts_with("error: ") && text.contains("\nhint: "), "{line}: {text}");
    for part in says {
        assert!(text.contains(part), "{line}: no `{part}` in: {text}");
    }
}

fn done(folder: &Path, line: &str) -> Output {
    let output = run(folder, line);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{line}: {}", text_of(&output));
    output
}

/// Every output of every command that writes files, each with what it reads: `OUT` is the output.
const EVERY: [(&str, &[&str]); 16] = [
    ("identify LOG -o OUT", &["log.csv"]),
    ("identify LOG --traces OUT", &["log.csv"]),
    ("identify LOG --report OUT", &["log.csv"]),
    ("identify --drive log.csv,track.csv -o OUT", &["log.csv", "track.csv"]),
    ("accumulate log.csv --input-channel steering_command_rad -o OUT", &["log.csv"]),
    ("bicycle vehicle.toml -o OUT", &["vehicle.toml"]),
    ("design plant.json --requirements asked.toml -o OUT", &["plant.json", "asked.toml"]),
    (
        "path track.csv --pid pid.json --plant plant.json -o OUT",
        &["track.csv", "pid.json", "plant.json"],
    ),
    ("simulate fmu/LateralPid.fmu --input input.csv -o OUT", &["fmu/LateralPid.fmu", "input.csv"]),
    ("sweep study.toml -o OUT", &["study.toml", "fmu/LateralPid.fmu"]),
    ("sweep study.toml --resume -o OUT", &["study.toml", "fmu/LateralPid.fmu"]),
    // Files whose names the command gives.
    ("design plant.json --plots DIR/bode.svg", &["plant.json"]),
    ("identify LOG --plots DIR/drive.svg", &["log.csv"]),
    ("package plant.json pid.json --out DIR/LateralPid.fmu", &["plant.json", "pid.json"]),
    ("package plant.json --ssp Loop.ssp --out DIR/Loop.ssp", &["plant.json"]),
    ("sweep study.toml --of 0 --trajectories DIR/run-0.csv", &["study.toml", "fmu/LateralPid.fmu"]),
];

/// The line with its output at a path; the folder's file, where the command names it.
fn with_output(line: &str, out: &str) -> (String, String) {
    let line = line.replace("LOG", LOG);
    match line.split_once("DIR/") {
        None => (line.replace("OUT", out), out.to_owned()),
        Some((head, name)) => (format!("{head}{out}"), format!("{out}/{name}")),
    }
}

#[test]
fn what_is_read_is_never_written() {
    let folder = workplace();
    let here = folder.path();
    for (line, inputs) in EVERY {
        for input in inputs {
            let before = fs::read(here.join(input)).unwrap();
            for way in ["itself", "symlink", "hard link", "with --force"] {
                let by_name = line.contains("DIR/");
                if by_name && way == "itself" {
                    continue;
                }
                let (line, file) = match way {
                    "itself" => with_output(line, input),
                    _ => with_output(line, "other"),
                };
                let link = here.join(&file);
                if way != "itself" {
                    fs::create_dir_all(link.parent().unwrap()).unwrap();
                    match way {
                        "hard link" => fs::hard_link(here.join(input), &link).unwrap(),
                        _ => symlink(here.join(input), &link).unwrap(),
                    }
                }
                let force = if way == "with --force" { " --force" } else { "" };
                refused(
                    here,
                    &format!("{line}{force}"),
                    &["this output is", "input", "is never written"],
                );
                assert!(fs::read(here.join(input)).unwrap() == before, "{line}, {way}: {input}");
                if way != "itself" {
                    fs::remove_file(&link).unwrap();
                    let _ = fs::remove_dir(link.parent().unwrap());
                }
            }
        }
    }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn a_foreign_file_is_kept_and_force_replaces_it() {
    let folder = workplace();
    let here = folder.path();
    // What is resumed is another matter than what is replaced.
    let replaced = |line: &str| !line.contains("--drive") && !line.contains("--resume");
    for (line, _) in EVERY.into_iter().filter(|(line, _)| replaced(line)) {
        let (line, file) = with_output(line, "other");
        let out = here.join(&file);
        fs::create_dir_all(out.parent().unwrap()).unwrap();
        // Text, a table, a document of another kind.
        let contents = [
            "my notes\n",
            "time,x\n0,1\n",
            "time,car.yaw\n0,1\n",
            "{\"schema\": \"steerwright/path/1\"}",
        ];
        for content in contents {
            if line.starts_with("path ") && content.starts_with('{') {
                continue;
            }
            fs::write(&out, content).unwrap();
            refused(here, &line, &[&file, "--force"]);
            assert_eq!(fs::read_to_string(&out).unwrap(), content, "{line}");
        }
        done(here, &format!("{line} --force"));
        // Its own output is replaced without --force.
        done(here, &line);
        fs::remove_file(&out).unwrap();
        // Nothing can be lost of an empty file.
        fs::write(&out, "").unwrap();
        done(here, &line);
        fs::remove_file(&out).unwrap();
        fs::create_dir(&out).unwrap();
        refused(here, &line, &["this is a folder"]);
        fs::remove_dir(&out).unwrap();
    }
}

/// A device that swallows what is written: one of its own where that may be made, so that no fault
/// here harms /dev/null; who may not make one may not harm that either.
fn null(folder: &Path) -> PathBuf {
    let own = folder.join("null");
    let made = Command::new("mknod").arg(&own).args(["c", "1", "3"]).status();
    if made.is_ok_and(|status| status.success()) { own } else { "/dev/null".into() }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn devices_and_fifos_are_written_to_and_stay_what_they_are() {
    let folder = workplace();
    let here = folder.path();
    let null = null(here);
    let fifo = here.join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    symlink(&null, here.join("link")).unwrap();
    for (line, _) in EVERY.into_iter().filter(|(line, _)| line.contains("OUT")) {
        if line.contains("--drive") {
            continue;
        }
        for force in ["", " --force"] {
            done(here, &with_output(&format!("{line}{force}"), &null.display().to_string()).0);
            assert!(fs::metadata(&null).unwrap().file_type().is_char_device(), "{line}");
            done(here, &with_output(&format!("{line}{force}"), "link").0);
            assert!(fs::symlink_metadata(here.join("link")).unwrap().is_symlink(), "{line}");
        }
        // Into a file: a pipe would fill up before anyone reads it.
        let copy = here.join("copy");
        let reader =
            Command::new("cat").arg(&fifo).stdout(fs::File::create(&copy).unwrap()).spawn();
        done(here, &with_output(line, "fifo").0);
        assert!(reader.unwrap().wait().unwrap().success());
        assert!(fs::metadata(&copy).unwrap().len() > 0, "{line}");
        assert!(fs::metadata(&fifo).unwrap().file_type().is_fifo(), "{line}");
    }
    // Two outputs may both go to a device, and to no file.
    let two = format!("identify {LOG} -o {} --traces {}", null.display(), null.display());
    done(here, &two);
    symlink("same.json", here.join("alias.json")).unwrap();
    let two = format!("identify {LOG} -o same.json --traces alias.json");
    refused(here, &two, &["two outputs of this command are this file"]);
    refused(here, "bicycle vehicle.toml -o log.csv/b.json", &["this is a file, not a folder"]);
}

#[test]
fn standard_output_is_a_place_to_write_to() {
    let folder = workplace();
    for place in ["-", "/dev/stdout"] {
        let output = done(folder.path(), &format!("bicycle vehicle.toml -o {place}"));
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(document["schema"], "steerwright/bicycle/1");
    }
    // Standard input may be the file that is written.
    let log = fs::File::open(folder.path().join("log.csv")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(words(&format!("identify /dev/stdin {} --force -o log.csv", &LOG[7..]), chain()))
        .current_dir(folder.path())
        .stdin(log)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    let text = text_of(&output);
    assert!(text.contains("this output is the input /dev/stdin"), "{text}");
}

#[test]
fn links_and_permissions_are_kept() {
    let folder = workplace();
    let here = folder.path();
    let line = "bicycle vehicle.toml -o link.json";
    fs::create_dir(here.join("elsewhere")).unwrap();
    symlink("elsewhere/b.json", here.join("link.json")).unwrap();
    // A link to nothing yet, then to the file.
    for _ in 0..2 {
        done(here, line);
        assert!(fs::symlink_metadata(here.join("link.json")).unwrap().is_symlink());
        assert!(fs::metadata(here.join("elsewhere/b.json")).unwrap().is_file());
        let mode = fs::metadata(here.join("elsewhere/b.json")).unwrap().mode();
        assert_eq!(mode & 0o600, 0o600);
        assert_eq!(fs::read_dir(here.join("elsewhere")).unwrap().count(), 1, "something is left");
    }
    let file = here.join("elsewhere/b.json");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    done(here, line);
    assert_eq!(fs::metadata(&file).unwrap().mode() & 0o777, 0o640);
    // A read-only file is not replaced without --force.
    fs::set_permissions(&file, fs::Permissions::from_mode(0o440)).unwrap();
    refused(here, line, &["read-only", "--force"]);
    done(here, &format!("{line} --force"));
}

fn is_locked(path: &Path) -> bool {
    let Ok(file) = fs::File::open(path) else { return false };
    let is_locked = matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock));
    let _ = file.unlock();
    is_locked
}

/// Of two runs with one output file the second is refused before its work, and the end of the first, by whatever, frees the
/// file.
#[test]
fn two_runs_never_write_one_file() {
    let folder = workplace();
    let here = folder.path();
    let line = format!("identify - {} -o shared.json", &LOG[7..]);
    let mut first = Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(words(&line, chain()))
        .current_dir(here)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lock = here.join(".steerwright-new-shared.json.lock");
    // It is there a moment before it is locked.
    while !is_locked(&lock) {
        assert!(first.try_wait().unwrap().is_none(), "it waits for its log");
        std::thread::yield_now();
    }
    let other = "bicycle vehicle.toml -o shared.json --force";
    refused(here, other, &["shared.json: another run is writing this file", "name another file"]);
    done(here, "bicycle vehicle.toml -o other.json");
    first.kill().unwrap();
    first.wait().unwrap();
    done(here, other);
    assert!(!lock.exists(), "the lock of a killed run is left");
}
