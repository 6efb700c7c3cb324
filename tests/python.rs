//! Runs the tests in tests/python on a fresh demo, where there is a Python environment for them.
//!
//! `cargo xtask test` makes that environment and names its interpreter in STEERWRIGHT_PYTHON.
//! A plain `cargo test` says what it leaves out.
#![allow(clippy::unwrap_used)]

#[path = "support/pure_loop.rs"]
mod pure_loop;
mod support;

use formats::Document;
use pure_loop::{Initialization, Master};
use std::path::Path;
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let Some(python) = std::env::var_os("STEERWRIGHT_PYTHON") else {
        println!("left out: fmpy's validation of the archives (tests/python)");
        println!("left out: the closed loop in fmpy, libcosim and an FMU container (tests/python)");
        println!("left out: the closed loop in rust-fmi and fmi-rs (tests/importers)");
        println!("`cargo xtask test` makes the Python environment they need and runs them");
        return ExitCode::SUCCESS;
    };
    let out = &support::demo().folder;
    write_references(&out.join("multibody"));
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python");
    let status = Command::new(python)
        .args(["-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider"])
        .arg(&tests)
        .env("STEERWRIGHT_OUT", out)
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

/// The trajectories of the pure functions along the demo's roads, under each importer's master and
/// after its initialization.
fn write_references(folder: &Path) {
    fn read<D: Document>(file: &Path) -> D {
        D::from_json(&std::fs::read_to_string(file).unwrap(), "file").unwrap()
    }
    let (plant, pid): (formats::Plant, formats::Pid) =
        (read(&folder.join("plant.json")), read(&folder.join("pid.json")));
    std::fs::create_dir_all(folder.join("reference")).unwrap();
    for (road, file) in [("road", "path.json"), ("recorded", "path-recorded.json")] {
        let path: formats::Path = read(&folder.join(file));
        let (first, last) = (path.points.first().unwrap(), path.points.last().unwrap());
        let length = (last.distance_m - first.distance_m) / path.speed_mps;
        let steps = (length / pid.sample_time_s).floor() as usize;
        for (name, master, initialization) in [
            ("gauss_seidel-settled", Master::GaussSeidel, Initialization::Settled),
            ("jacobi-settled", Master::Jacobi, Initialization::Settled),
            ("jacobi-zeros", Master::Jacobi, Initialization::Zeros),
        ] {
            let rows = pure_loop::run(&plant, &path, &pid, master, initialization, steps);
            let file = folder.join(format!("reference/{road}-{name}.csv"));
            std::fs::write(file, pure_loop::to_csv(&rows)).unwrap();
        }
    }
}
