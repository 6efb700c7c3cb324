//! Code for the tests of all importers: the folder of the demo, the co-simulation, and the
//! comparison with the trajectory of the pure functions.

pub(crate) mod run;
#[path = "../../support/pure_loop.rs"]
mod pure_loop;

use run::{Port, Unit, Wire, run};
pub(crate) use steerwright_formats::LoopCoupling;
use pure_loop::{COLUMNS, Initialization};
use std::path::PathBuf;
use steerwright_formats::{Document, Path as PathFile, Pid, Plant};

/// Of any variable at any point; units are SI.
const LARGEST_DIFFERENCE: f64 = 1e-9;

/// In the order in which a Gauss–Seidel coupling steps them.
pub(crate) const UNITS: [&str; 3] = ["IdentifiedPlant", "ReferencePath", "LateralPid"];

const WIRES: [Wire<'static>; 7] = [
    ((2, "steering_angle"), (0, "steering_angle")),
    ((0, "x"), (1, "x")),
    ((0, "y"), (1, "y")),
    ((0, "yaw"), (1, "yaw")),
    ((1, "yaw_reference"), (2, "yaw_reference")),
    ((1, "steering_feedforward"), (2, "steering_feedforward")),
    ((0, "yaw"), (2, "yaw")),
];

/// The demo's folder of the multi-body drive.
fn out() -> PathBuf {
    let folder = std::env::var_os("STEERWRIGHT_OUT")
        .expect("STEERWRIGHT_OUT must name a folder of `steerwright demo`; see `cargo xtask test`");
    PathBuf::from(folder).join("multibody")
}

/// The FMUs of the demo's folder, which has one of each.
pub(crate) fn archives() -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(out().join("fmu")).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "fmu") {
            names.push(file.file_stem().unwrap().to_string_lossy().into_owned());
        }
    }
    assert!(names.len() >= 7, "{names:?}");
    names
}

/// An archive of the demo.
pub(crate) fn archive(name: &str) -> PathBuf {
    out().join("fmu").join(format!("{name}.fmu"))
}

fn document<D: Document>(name: &str) -> D {
    let file = out().join(name);
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    D::from_json(&text, name).unwrap()
}

/// Runs the closed loop of the demo's archives along its whole road under an importer, opened by
/// `open`, and holds it against the same loop of the pure functions.
pub(crate) fn compare<U: Unit>(importer: &str, coupling: LoopCoupling, open: impl Fn(&str) -> U) {
    let (plant, path, pid): (Plant, PathFile, Pid) =
        (document("plant.json"), document("path.json"), document("pid.json"));
    let (first, last) = (path.points.first().unwrap(), path.points.last().unwrap());
    let length = (last.distance_m - first.distance_m) / path.speed_mps;
    let steps = (length / pid.sample_time_s).floor() as usize;
    let initialization = Initialization::Settled;
    let expected = pure_loop::run(&plant, &path, &pid, coupling, initialization, steps);

    let record = COLUMNS.map(|column| {
        let (unit, variable) = column.split_once('.').unwrap();
        (UNITS.iter().position(|name| *name == unit).unwrap(), variable)
    });
    let record: Vec<Port<'_>> = record.to_vec();
    let mut units = UNITS.map(open);
    let got = run(&mut units, &WIRES, coupling, steps, pid.sample_time_s, &record);

    assert_eq!(got.len(), expected.len());
    let mut largest = (0.0, "");
    for (index, name) in ["time"].iter().chain(&COLUMNS).enumerate() {
        let pairs = got.iter().zip(&expected).map(|(a, b)| (a[index] - b[index]).abs());
        let difference = pairs.fold(0.0, not_less);
        println!("{importer}, {coupling:?}: {name}: largest difference {difference:.3e}");
        if not_less(largest.0, difference) != largest.0 {
            largest = (difference, *name);
        }
    }
    println!(
        "{importer}, {coupling:?}: largest difference to the pure functions, over {} points: {:.3e} {}",
        got.len(),
        largest.0,
        largest.1
    );
    assert!(largest.0 <= LARGEST_DIFFERENCE, "{largest:?}");
    // The loop did something: it steered, and it stayed on the road.
    let size = |name: &str| {
        let index = 1 + COLUMNS.iter().position(|known| *known == name).unwrap();
        got.iter().map(|row| row[index].abs()).fold(0.0, not_less)
    };
    assert!(size("LateralPid.steering_angle") > 0.01);
    assert!(size("ReferencePath.cross_track_error") < 0.5);
}

/// The greater one; a NaN, which `f64::max` would drop, stays.
fn not_less(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
