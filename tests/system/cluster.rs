//! The scripts of the book's page on clusters, run as a SLURM array runs them.

use crate::support;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const TASKS: usize = 5;

/// The page's scripts, in order: a task of a sweep, its merge, a task of a fleet, its identification.
fn scripts() -> Vec<&'static str> {
    let page = include_str!("../../docs/cluster.md");
    page.split("```bash\n").skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

fn run(script: &str, folder: &Path, task: Option<usize>) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_steerwright")).parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([program].into_iter().chain(std::env::split_paths(&path)));
    let mut command = Command::new("bash");
    command.args(["-c", script]).current_dir(folder).env("PATH", path.unwrap());
    if let Some(task) = task {
        command.env("SLURM_ARRAY_TASK_ID", task.to_string());
        command.env("SLURM_ARRAY_TASK_COUNT", TASKS.to_string());
    }
    command.output().unwrap()
}

fn ok(script: &str, folder: &Path, task: Option<usize>) {
    let output = run(script, folder, task);
    assert!(output.status.success(), "{script}{}", support::text_of(&output));
}

#[test]
fn an_array_of_shards_is_the_bytes_of_one_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let package = support::demo().folder.join("multibody/fmu/LateralLoop.ssp");
    fs::copy(package, folder.join("LateralLoop.ssp")).unwrap();
    let study = r#"
seed = 2
runs = 22
step_s = 0.01
stop_s = 2.0
ssp = "LateralLoop.ssp"
[[vary]]
name = "speed"
variables = ["IdentifiedPlant.speed", "ReferencePath.speed"]
distribution = "uniform"
minimum = 14.0
maximum = 16.0
[[metric]]
name = "largest"
variable = "ReferencePath.cross_track_error"
kind = "max-abs"
"#;
    fs::write(folder.join("study.toml"), study).unwrap();
    let whole = support::steerwright(folder, &["sweep", "study.toml", "-o", "whole.csv"]);
    assert!(whole.status.success(), "{}", support::text_of(&whole));
    let [task, merge, ..] = scripts()[..] else { panic!("the page has fewer scripts") };
    for k in [3, 0, 4, 1] {
        ok(task, folder, Some(k));
    }
    let gap = run(merge, folder, None);
    assert_eq!(gap.status.code(), Some(2));
    let text = support::text_of(&gap);
    assert!(text.contains("runs 8 to 12 of 22 are in no piece"), "{text}");
    ok(task, folder, Some(2));
    // Again, as a cluster may.
    ok(task, folder, Some(2));
    ok(merge, folder, None);
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    assert_eq!(read("results.csv"), read("whole.csv"));
    let late = run(&task.replace("$SLURM_ARRAY_TASK_ID/", "5/"), folder, Some(0));
    let text = support::text_of(&late);
    assert!(text.contains("the last is 4/5"), "{text}");
}

#[test]
fn an_array_over_logs_is_a_fleet() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let drive = fs::read_to_string(support::data().join("multibody/drive.csv")).unwrap();
    let lines: Vec<&str> = drive.lines().collect();
    let mut names = String::new();
    for (k, rows) in lines[1..].chunks(lines.len().div_ceil(TASKS)).enumerate() {
        fs::write(folder.join(format!("{k}.csv")), [&[lines[0]], rows].concat().join("\n"))
            .unwrap();
        names += &format!("{k}.csv\n");
    }
    fs::write(folder.join("logs.txt"), names).unwrap();
    let [_, _, task, identify] = scripts()[..] else { panic!("the page has other scripts") };
    fs::create_dir(folder.join("factors")).unwrap();
    (0..TASKS).for_each(|k| ok(task, folder, Some(k)));
    // 1: the parts of one drive validate worse than the whole of it.
    let identified = run(identify, folder, None);
    assert!(matches!(identified.status.code(), Some(0 | 1)), "{}", support::text_of(&identified));
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let (plant, fleet) = (read("plant.json"), read("fleet.rfactor"));
    // Merged with its own parts it is the same.
    let again = ["accumulate", "fleet.rfactor", "factors/1.rfactor", "-o", "again.rfactor"];
    let again = support::steerwright(folder, &again);
    assert!(support::text_of(&again).contains("1: its logs are there already"), "{again:?}");
    assert_eq!(read("again.rfactor"), fleet);
    assert!(plant.contains("\"4.csv\""));
}
