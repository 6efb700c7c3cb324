//! Running the program, and the folder of one demo that a test binary shares.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use steerwright_formats::Document;
use steerwright_packaging::Fmu;

/// Runs `steerwright` with arguments, in a folder.
pub(crate) fn steerwright<S: AsRef<std::ffi::OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_steerwright"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// What a run printed for people: stderr without its progress, then stdout where that is no JSON.
pub(crate) fn text_of(output: &Output) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr);
    let lines = stderr.lines().filter(|line| !line.starts_with("progress: "));
    let mut text: String = lines.flat_map(|line| [line, "\n"]).collect();
    if !output.stdout.starts_with(b"{") && !output.stdout.starts_with(b"[") {
        text += &String::from_utf8_lossy(&output.stdout);
    }
    text
}

/// The data that ships with the repository.
pub(crate) fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drives")
}

/// A demo: its folder, and the JSON it printed.
pub(crate) struct Demo {
    pub(crate) folder: PathBuf,
    pub(crate) overview: Value,
}

/// The demo of this test binary, run once.
pub(crate) fn demo() -> &'static Demo {
    static DEMO: OnceLock<Demo> = OnceLock::new();
    DEMO.get_or_init(|| run_demo("demo"))
}

/// The folder with the archives of all FMUs, made once for a test binary: those of the demo's
/// multi-body drive, and those of the examples that it does not make.
pub(crate) fn archives() -> &'static Path {
    static ARCHIVES: OnceLock<PathBuf> = OnceLock::new();
    ARCHIVES.get_or_init(|| {
        let folder = shared("archives");
        std::fs::create_dir_all(&folder).unwrap();
        for entry in std::fs::read_dir(demo().folder.join("multibody/fmu")).unwrap() {
            let file = entry.unwrap();
            std::fs::copy(file.path(), folder.join(file.file_name())).unwrap();
        }
        package_others(&folder);
        folder
    })
}

/// Packs the examples of the FMUs that are not in a folder into it.
pub(crate) fn package_others(folder: &Path) {
    let mut line = "package --out .".to_owned();
    for fmu in Fmu::ALL {
        if !folder.join(format!("{}.fmu", fmu.name())).is_file() {
            let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("fmu").join(fmu.folder());
            line.push_str(&format!(" {}", example.join("example.json").display()));
        }
    }
    let output = steerwright(folder, &words(&line, folder));
    assert!(output.status.success(), "{}", text_of(&output));
}

/// A folder of that name for this test binary, not there yet: what is shared by tests lives until
/// the next run, since nothing is dropped when a test binary ends.
fn shared(name: &str) -> PathBuf {
    // The test binary's name keeps binaries that run at the same time apart.
    let exe = std::env::current_exe().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(exe.file_stem().unwrap()).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// Runs the demo into a folder of that name, made again.
pub(crate) fn run_demo(name: &str) -> Demo {
    let folder = shared(name);
    let output = steerwright(
        &std::env::temp_dir(),
        &["demo".as_ref(), "--json".as_ref(), "--out".as_ref(), folder.as_os_str()],
    );
    assert!(output.status.success(), "{}", text_of(&output));
    Demo { folder, overview: serde_json::from_slice(&output.stdout).unwrap() }
}

/// The multi-body drive's files, each made by its subcommand, once for a test binary: `plant.json`,
/// `bicycle.json`, `pid.json`, `path.json`, and `fmu/` with their archives.
pub(crate) fn chain() -> &'static Path {
    static CHAIN: OnceLock<PathBuf> = OnceLock::new();
    CHAIN.get_or_init(|| {
        let folder = shared("chain");
        std::fs::create_dir_all(&folder).unwrap();
        for arguments in [
            "identify {data}/multibody/drive.csv --input-channel steering_command_rad",
            "bicycle {data}/multibody/vehicle.toml",
            "design plant.json",
            "path --pid pid.json",
            "package plant.json bicycle.json pid.json path.json --out fmu",
        ] {
            let output = steerwright(&folder, &words(arguments, Path::new("")));
            assert!(output.status.success(), "{arguments}: {}", text_of(&output));
        }
        folder
    })
}

/// A bend to each side between straights, away from the origin.
const WHOLE_ROAD: &str = r#"
name = "two bends"
start = { x_m = 20.0, y_m = -5.0, heading_rad = 2.0 }
segments = [
    { length_m = 60.0 },
    { length_m = 20.0, end_curvature_per_m = 0.03 },
    { length_m = 25.0, curvature_per_m = 0.03 },
    { length_m = 20.0, curvature_per_m = 0.03, end_curvature_per_m = 0.0 },
    { length_m = 150.0 },
    { length_m = 25.0, end_curvature_per_m = -0.02 },
    { length_m = 40.0, curvature_per_m = -0.02 },
    { length_m = 25.0, curvature_per_m = -0.02, end_curvature_per_m = 0.0 },
    { length_m = 60.0 },
]
"#;

/// The package of all units along a road with a speed profile, `fmu/WholeRoad.ssp` in a folder.
pub(crate) fn package_whole_road(folder: &Path, bicycle: &Path) {
    std::fs::write(folder.join("road.toml"), WHOLE_ROAD).unwrap();
    std::fs::write(folder.join("longitudinal.json"), Fmu::LongitudinalPlant.example()).unwrap();
    let bicycle = bicycle.display();
    let given =
        format!("--pid pid.json --plant {bicycle} --speed-controller speed_controller.json");
    let limits = "--profile --speed 20m/s --max-lateral-acceleration 3m/s2";
    for line in [
        format!("design {bicycle} --speeds 4..25 --max-rate 0.4rad/s --force -o pid.json"),
        "design longitudinal.json --force -o speed_controller.json".to_owned(),
        format!("path road.toml {given} {limits} --force -o path.json"),
        // The order of the files does not matter.
        format!(
            "package longitudinal.json speed_controller.json pid.json path.json {bicycle} \
             {{data}}/multibody/estimator.json --out fmu --ssp WholeRoad.ssp --force"
        ),
    ] {
        let output = steerwright(folder, &words(&line, folder));
        assert!(output.status.success(), "{line}: {}", text_of(&output));
    }
}

/// The command line with a line of arguments, in which the chain's files may be named.
pub(crate) fn run(folder: &Path, line: &str) -> Output {
    let chain = if line.contains("{chain}") { chain() } else { Path::new("") };
    steerwright(folder, &words(line, chain))
}

/// The same, which must end well.
pub(crate) fn done(folder: &Path, line: &str) -> Output {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", text_of(&output));
    output
}

/// A command line's arguments, with the folders that stand in it as `{data}` and `{chain}`.
pub(crate) fn words(line: &str, chain: &Path) -> Vec<String> {
    let (data, chain) = (data().display().to_string(), chain.display().to_string());
    let word = |w: &str| w.replace("{data}", &data).replace("{chain}", &chain);
    line.split_whitespace().map(word).collect()
}

/// A JSON file.
pub(crate) fn read_json(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}

/// A JSON file, by its type.
pub(crate) fn document<D: Document>(file: &Path) -> D {
    D::from_json(&std::fs::read_to_string(file).unwrap(), "file").unwrap()
}

/// A column of a CSV file.
pub(crate) fn column(file: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let index = lines.next().unwrap().split(',').position(|n| n == name).unwrap();
    lines.map(|line| line.split(',').nth(index).unwrap().parse().unwrap()).collect()
}

/// The entries of a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut all: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    all.sort();
    all
}

/// Every file below a folder, by its path there, with its bytes.
pub(crate) fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            let below = content(&path).into_iter();
            all.extend(below.map(|(file, bytes)| (Path::new(&name).join(file), bytes)));
        } else {
            all.insert(name.into(), std::fs::read(&path).unwrap());
        }
    }
    all
}
