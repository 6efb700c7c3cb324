//! How fast the closed loop of plant, path and controller runs: a thread, two, and each plant.
//!
//! `cargo xtask bench sweep` makes the FMUs, names their folder in `STEERWRIGHT_BENCH_FMUS` and runs
//! this; the number of loops may follow as an argument. Times are wall time of whole sweeps, with
//! all that belongs to them: draws, initialization, metrics, the results file.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use sweep::{Options, Study, Sweep};

const STEPS: f64 = 2000.0;

fn study(plant: &str, runs: usize) -> String {
    format!(
        r#"
        seed = 1
        runs = {runs}
        step_s = 0.01
        stop_s = 20.0
        fmu = [{{ file = "{plant}.fmu" }}, {{ file = "ReferencePath.fmu" }}, {{ file = "LateralPid.fmu" }}]
        [[vary]]
        name = "speed"
        variables = ["{plant}.speed", "ReferencePath.speed"]
        distribution = "uniform"
        minimum = 14.0
        maximum = 16.0
        [[metric]]
        name = "cross_track_rms"
        variable = "ReferencePath.cross_track_error"
        kind = "rms"
        [[metric]]
        name = "cross_track_max"
        variable = "ReferencePath.cross_track_error"
        kind = "max-abs"
        "#
    )
}

/// Wall time of a sweep, s.
fn time(plant: &str, runs: usize, threads: usize, folder: &PathBuf, out: &PathBuf) -> f64 {
    let study = Study::read(study(plant, runs), "bench".into(), folder.clone()).unwrap();
    let sweep = Sweep::prepare(&study, &|_| true).unwrap();
    let stop = AtomicBool::new(false);
    let begun = Instant::now();
    let finished = sweep
        .run(&Options {
            results: out,
            threads: Some(threads),
            resume: false,
            overwrite: true,
            trajectories: None,
            stop: &stop,
            progress: &|_| {},
        })
        .unwrap();
    assert!(finished.summary.all_passed());
    begun.elapsed().as_secs_f64()
}

fn main() {
    // cargo adds an option of its own harness.
    let runs = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(10_000);
    let Some(folder) = std::env::var_os("STEERWRIGHT_BENCH_FMUS").map(PathBuf::from) else {
        println!("left out: run it by `cargo xtask bench sweep`");
        return;
    };
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("results.csv");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{cores} cores; loops of 20 s at 100 Hz");
    for plant in ["IdentifiedPlant", "NonlinearVehicle"] {
        // Warm, and the second time that a file's pages are touched.
        time(plant, runs.min(20), 1, &folder, &out);
        let one = time(plant, runs, 1, &folder, &out);
        let two = time(plant, runs, 2, &folder, &out);
        let step = |wall: f64, threads: f64| wall * threads / (runs as f64 * STEPS) * 1e9;
        println!(
            "{plant}: {runs} loops in {one:.2} s on one thread ({:.0} ns a step), {two:.2} s on \
             two ({:.0} ns of a core a step); scaling {:.2}",
            step(one, 1.0),
            step(two, 2.0),
            one / two,
        );
        println!("{plant}: {:.6} ms a loop on one thread", one / runs as f64 * 1e3);
    }
}
