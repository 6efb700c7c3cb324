//! Speed of the closed loop of plant, path and controller: a thread, two, and each plant.
//!
//! `cargo xtask bench sweep` makes the FMUs, names their folder in `STEERWRIGHT_BENCH_FMUS` and runs
//! this; `STEERWRIGHT_BENCH_LOOPS` may name another number of loops than 10,000,
//! `STEERWRIGHT_BENCH_PLANT` one plant alone. Times are of whole sweeps, with all that
//! belongs to them: draws, instances, initialization, metrics, the results file. Where others use
//! the machine too, wall times are theirs as well, and the processor's time is what a sweep takes.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use steerwright_sweep::{Options, Study, Sweep};

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

/// What a sweep takes, s.
struct Taken {
    wall: f64,
    processor: f64,
}

fn time(plant: &str, runs: usize, threads: usize, folder: &Path, out: &Path) -> Taken {
    let study = Study::read(study(plant, runs), "bench".into(), folder.to_path_buf()).unwrap();
    let sweep = Sweep::prepare(&study, &[], &|_| true).unwrap();
    let stop = AtomicBool::new(false);
    let (begun, before) = (Instant::now(), processor());
    let finished = sweep
        .run(&Options {
            results: out,
            runs: None,
            threads: Some(threads),
            resume: false,
            overwrite: true,
            trajectories: None,
            isolate: None,
            timeout: None,
            hung: &|_, _| {},
            stop: &stop,
            progress: &|_| {},
        })
        .unwrap();
    assert!(finished.summary.all_passed());
    Taken { wall: begun.elapsed().as_secs_f64(), processor: processor() - before }
}

/// The time that this process has had a processor, all threads together, s.
#[cfg(unix)]
fn processor() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(not(unix))]
fn processor() -> f64 {
    f64::NAN
}

fn main() {
    let stated = std::env::var("STEERWRIGHT_BENCH_LOOPS").ok();
    let runs = stated.map_or(10_000, |text| text.parse().expect("STEERWRIGHT_BENCH_LOOPS"));
    let Some(folder) = std::env::var_os("STEERWRIGHT_BENCH_FMUS").map(PathBuf::from) else {
        println!("left out: run it by `cargo xtask bench sweep`");
        return;
    };
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("results.csv");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{runs} loops of 20 s at 100 Hz, {cores} cores");
    println!("plant             threads   wall s   processor s   processor ns a step");
    let only = std::env::var("STEERWRIGHT_BENCH_PLANT").ok();
    for plant in ["IdentifiedPlant", "NonlinearVehicle"] {
        if only.as_deref().is_some_and(|only| only != plant) {
            continue;
        }
        // Pages and caches are warm from here on.
        time(plant, runs.min(20), 1, &folder, &out);
        let taken = [1, 2].map(|threads| {
            let taken = time(plant, runs, threads, &folder, &out);
            println!(
                "{plant:16}  {threads:7}  {:7.2}  {:12.2}  {:20.0}",
                taken.wall,
                taken.processor,
                taken.processor / (runs as f64 * STEPS) * 1e9
            );
            taken
        });
        println!(
            "{plant:16}  scaling {:.2}; the processor's time with two threads is {:.2} of one's",
            taken[0].wall / taken[1].wall,
            taken[1].processor / taken[0].processor
        );
        println!("ms a loop on one thread: {:.4}", taken[0].processor / runs as f64 * 1e3);
    }
}
