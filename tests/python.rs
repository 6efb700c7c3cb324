//! Runs the tests in tests/python on a fresh demo, where there is a Python environment for them.
//!
//! `cargo xtask test` makes that environment and names its interpreter in STEERWRIGHT_PYTHON.
//! A plain `cargo test` lists what it omits. In CI a missing interpreter is a failure, unless the
//! variable is empty.
#![allow(clippy::unwrap_used)]

#[path = "support/pure_loop.rs"]
mod pure_loop;
mod support;

use pure_loop::Initialization;
use std::path::Path;
use std::process::{Command, ExitCode};
use steerwright_formats::Document;
use steerwright_formats::LoopCoupling;

fn main() -> ExitCode {
    let stated = std::env::var_os("STEERWRIGHT_PYTHON");
    if stated.is_none() && std::env::var_os("CI").is_some() {
        eprintln!("STEERWRIGHT_PYTHON is not set: run `cargo xtask test`");
        return ExitCode::FAILURE;
    }
    let Some(python) = stated.filter(|interpreter| !interpreter.is_empty()) else {
        println!("left out: fmpy's validation of the archives (tests/python)");
        println!("left out: the closed loop in fmpy, libcosim and an FMU container (tests/python)");
        println!("left out: the closed loop in rust-fmi and fmi-rs (tests/importers)");
        println!("`cargo xtask test` makes the Python environment they need and runs them");
        return ExitCode::SUCCESS;
    };
    let out = &support::demo().folder;
    write_references(&out.join("multibody"));
    write_estimator(&out.join("multibody"));
    write_whole_road(&out.join("whole-road"), &out.join("multibody/bicycle.json"));
    support::package_others(&out.join("multibody/fmu"));
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python");
    let status = Command::new(python)
        .args(["-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider"])
        .arg(&tests)
        .env("STEERWRIGHT_OUT", out)
        .env(
            "STEERWRIGHT_FMUS",
            steerwright_packaging::Fmu::ALL.map(steerwright_packaging::Fmu::name).join(" "),
        )
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .status();
    match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("STEERWRIGHT_PYTHON: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The roads: the demo's, and the same moved away from the origin, for which the loop is packed
/// again; and the trajectories of the pure functions, under each importer's coupling and after
/// its initialization.
fn write_references(folder: &Path) {
    let plant: steerwright_formats::Plant = support::document(&folder.join("plant.json"));
    let pid: steerwright_formats::Pid = support::document(&folder.join("pid.json"));
    let path: steerwright_formats::Path = support::document(&folder.join("path.json"));
    let moved = moved(&path);
    std::fs::write(folder.join("path-moved.json"), moved.to_json()).unwrap();
    let files = ["plant.json", "path-moved.json", "pid.json"];
    let options = ["--out", "fmu-moved", "--ssp", "LateralLoop.ssp"];
    let packed = support::steerwright(folder, &[&["package"][..], &files, &options].concat());
    assert!(packed.status.success(), "{}", support::text_of(&packed));

    std::fs::create_dir_all(folder.join("reference")).unwrap();
    for (road, path) in [("road", &path), ("moved", &moved)] {
        let (first, last) = (path.points.first().unwrap(), path.points.last().unwrap());
        let length = (last.distance_m - first.distance_m) / path.speed_mps;
        let steps = (length / pid.sample_time_s).floor() as usize;
        for (name, coupling, initialization) in [
            ("gauss_seidel-settled", LoopCoupling::GaussSeidel, Initialization::Settled),
            ("jacobi-settled", LoopCoupling::Jacobi, Initialization::Settled),
            ("jacobi-zeros", LoopCoupling::Jacobi, Initialization::Zeros),
        ] {
            let rows = pure_loop::run(&plant, path, &pid, coupling, initialization, steps);
            let file = folder.join(format!("reference/{road}-{name}.csv"));
            std::fs::write(file, pure_loop::to_csv(&rows)).unwrap();
        }
    }
}

/// The loop with the pose estimator, and what it does in our host.
fn write_estimator(folder: &Path) {
    let package = "package plant.json path.json pid.json {data}/multibody/estimator.json \
                   --out fmu-estimator --ssp PoseLoop.ssp";
    let simulate = "simulate fmu-estimator/PoseLoop.ssp --coupling jacobi \
                    -o reference/estimator-jacobi.csv";
    for line in [package, simulate] {
        let output = support::steerwright(folder, &support::words(line, folder));
        assert!(output.status.success(), "{}", support::text_of(&output));
    }
}

/// All units along a road with its speed profile, and what they do in our host.
fn write_whole_road(folder: &Path, bicycle: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    support::package_whole_road(folder, bicycle);
    let line = "simulate fmu/WholeRoad.ssp --coupling jacobi -o jacobi.csv";
    let output = support::steerwright(folder, &support::words(line, folder));
    assert!(output.status.success(), "{}", support::text_of(&output));
}

/// A road elsewhere and in another direction, at a speed a little off that of the identification.
fn moved(path: &steerwright_formats::Path) -> steerwright_formats::Path {
    let (turn, x, y) = (2.0_f64, 1000.0, -500.0);
    let mut moved = path.clone();
    moved.speed_mps *= 1.05;
    for point in &mut moved.points {
        (point.x_m, point.y_m) = (
            x + turn.cos() * point.x_m - turn.sin() * point.y_m,
            y + turn.sin() * point.x_m + turn.cos() * point.y_m,
        );
        point.heading_rad += turn;
    }
    moved
}
