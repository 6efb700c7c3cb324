//! The archives of `steerwright demo` under rust-fmi's importer; STEERWRIGHT_OUT names their folder.

mod functions;
mod gauss_seidel;

use fmi::fmi2::Fmi2Error;
use fmi::fmi2::instance::Common;
use fmi::traits::FmiImport;
use functions::functions;
use gauss_seidel::{Unit, run};
use std::path::PathBuf;
use std::sync::Mutex;

/// Of any variable at any point; units are SI.
const LARGEST_DIFFERENCE: f64 = 1e-9;

/// The demo's folder of the multi-body drive.
fn out() -> PathBuf {
    let folder = std::env::var_os("STEERWRIGHT_OUT")
        .expect("STEERWRIGHT_OUT must name a folder of `steerwright demo`; see `cargo xtask test`");
    PathBuf::from(folder).join("multibody")
}

fn open(name: &str, logging_on: bool) -> Unit {
    Unit::open(&out().join("fmu").join(format!("{name}.fmu")), logging_on)
}

/// The recorded trajectory: the header, and a row each point.
fn recorded() -> (Vec<String>, Vec<Vec<f64>>) {
    let file = out().join("result.csv");
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut lines = text.lines();
    let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (header, lines.map(row).collect())
}

#[test]
fn rust_fmi_and_the_host_agree_on_the_closed_loop() {
    let names = ["IdentifiedPlant", "ReferencePath", "LateralPid"];
    let [plant, path, pid] = [0, 1, 2];
    let wires = [
        ((pid, "steering_angle"), (plant, "steering_angle")),
        ((plant, "x"), (path, "x")),
        ((plant, "y"), (path, "y")),
        ((plant, "yaw"), (path, "yaw")),
        ((path, "yaw_reference"), (pid, "yaw_reference")),
        ((path, "steering_feedforward"), (pid, "steering_feedforward")),
        ((plant, "yaw"), (pid, "yaw")),
    ];
    let (header, expected) = recorded();
    let record = header[1..].iter().map(|column| {
        let (unit, variable) = column.split_once('.').unwrap();
        (names.iter().position(|name| *name == unit).unwrap(), variable)
    });
    let record: Vec<_> = record.collect();
    let stop = expected.last().unwrap()[0];
    let step = ((expected[1][0] - expected[0][0]) * 1e9).round() / 1e9;

    let mut units = names.map(|name| open(name, true));
    assert_eq!(units.each_ref().map(|unit| unit.name.as_str()), names);
    let got = run(&mut units, &wires, stop, step, &record);

    assert_eq!(got.len(), expected.len());
    let column = |rows: &[Vec<f64>], index: usize| -> Vec<f64> {
        rows.iter().map(|row| row[index]).collect()
    };
    let mut largest = 0.0;
    for (index, name) in header.iter().enumerate() {
        let (got, expected) = (column(&got, index), column(&expected, index));
        let difference = got.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, not_less);
        println!("{name}: largest difference {difference:.3e}");
        largest = not_less(largest, difference);
    }
    println!("largest difference of all, over {} points: {largest:.3e}", got.len());
    assert!(largest <= LARGEST_DIFFERENCE, "{largest:e}");
    // The loop did something: it steered, and it stayed on the road.
    let of = |name: &str| column(&got, header.iter().position(|known| known == name).unwrap());
    let size = |values: Vec<f64>| values.into_iter().map(f64::abs).fold(0.0, not_less);
    assert!(size(of("LateralPid.steering_angle")) > 0.01);
    assert!(size(of("ReferencePath.cross_track_error")) < 0.3);
}

/// The greater one; a NaN, which `f64::max` would drop, stays.
fn not_less(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

macro_rules! missing {
    ($($name:ident $kind:ident($($parameter:ty),*) -> $result:ty;)*) => {
        |binding: &fmi::fmi2::binding::Fmi2Binding| -> Vec<&str> {
            let found = [$((stringify!($name), binding.$name.is_ok())),*];
            found.into_iter().filter(|(_, found)| !found).map(|(name, _)| name).collect()
        }
    };
}

#[test]
fn every_archive_exports_every_function() {
    for name in ["IdentifiedPlant", "BicyclePlant", "ReferencePath", "LateralPid"] {
        let unit = open(name, false);
        let binding = unit.import.binding(name).unwrap();
        assert_eq!(functions!(missing)(&binding), [""; 0], "{name}");
        // Co-simulation alone: what the other kind of FMU has is not there.
        assert!(binding.fmi2SetTime.is_err(), "{name}");
        assert_eq!(unit.instance.get_version(), "2.0");
        assert_eq!(unit.instance.get_types_platform(), "default");
    }
}

/// What reached rust-fmi's side of the logger: instance, level and text.
static TOLD: Mutex<Vec<(String, log::Level, String)>> = Mutex::new(Vec::new());

struct Listener;

impl log::Log for Listener {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        let told = (record.target().into(), record.level(), record.args().to_string());
        TOLD.lock().unwrap().push(told);
    }

    fn flush(&self) {}
}

#[test]
fn an_error_is_told_through_the_callbacks() {
    log::set_logger(&Listener).unwrap();
    let mut unit = open("LateralPid", true);
    let no_such_reference = [4_000_000_000];
    unit.instance.setup_experiment(None, 0.0, None).unwrap();
    unit.instance.enter_initialization_mode().unwrap();
    let result = unit.instance.get_real(&no_such_reference, &mut [0.0]);
    assert!(matches!(result, Err(Fmi2Error::Error)), "{result:?}");
    let told = TOLD.lock().unwrap();
    let of_this_call = |(instance, level, text): &&(String, log::Level, String)| {
        instance == "LateralPid" && *level == log::Level::Error && text.contains("4000000000")
    };
    assert_eq!(told.iter().filter(of_this_call).count(), 1, "{told:?}");
}
