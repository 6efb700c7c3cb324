//! `cargo xtask evaluate command_line`: how long the command line takes from a CSV file to `plant.json`
//! with all evidence, and where the time goes; compared with reading the same file in Python and
//! SLICOT's subspace identification through `ctrlsys`.

use super::options;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use steerwright_drivelog::LogOptions;
use steerwright_evaluation::Drive;
use steerwright_evaluation::measure::peak_memory;
use steerwright_sysid::delay::estimate_delay;
use steerwright_sysid::{DataSet, IdentifyOptions};

/// How long the command line takes.
#[derive(Parser)]
struct Arguments {
    /// The `steerwright` to run; by default the one next to this program
    #[arg(long)]
    program: Option<PathBuf>,
    /// Rows of the log, at 100 Hz
    #[arg(long, default_value_t = 55_000)]
    rows: usize,
    /// Runs, of which the median counts
    #[arg(long, default_value_t = 5)]
    runs: usize,
    /// Read only: measures the reader on logs too long to identify from in a moment
    #[arg(long)]
    read_only: bool,
}

/// Reads as the command line does, picks every fourth sample, and identifies order 4 with SLICOT.
const PEER: &str = r#"
import json, sys, time
start = time.perf_counter()
import numpy, ctrlsys
loaded = time.perf_counter()
log = numpy.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
read = time.perf_counter()
u, y = (numpy.asfortranarray(log[::4, [c]] - log[::4, [c]].mean()) for c in (1, 2))
s, n = 15, 4
found = ctrlsys.ib01ad("N", "C", "N", "O", "N", "N", s, 1, 1, u, y, 0.0, -1.0)
order, r = found[0], found[1]
done = time.perf_counter()
print("import %.3f s, read %.3f s, R factor %.4f s" % (loaded - start, read - loaded, done - read))
"#;

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    let folder = std::env::temp_dir().join(format!("steerwright-evaluate-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let outcome = measure(&arguments, &folder);
    std::fs::remove_dir_all(&folder)?;
    outcome
}

fn measure(arguments: &Arguments, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let drive = Drive { sample_time: 0.01, delay: 0.0, servo: 0.05, noise: 0.002, seed: 1 };
    let text = drive.record(arguments.rows).csv();
    let log = folder.join("drive.csv");
    std::fs::write(&log, &text)?;
    println!("{} rows, {:.1} MB of CSV", arguments.rows, text.len() as f64 * 1e-6);

    let files = [("drive.csv".to_owned(), text.into_bytes())];
    let clock = Instant::now();
    let read = steerwright_drivelog::read_log(&files, &LogOptions::default())?;
    let reading = clock.elapsed().as_secs_f64();
    println!("in this process, once:");
    println!(
        "  {reading:8.3} s  reading: CSV to {} samples of {} s",
        read.len(),
        read.sample_time_s
    );
    println!(
        "  {:8.0} MB  most memory held so far, the CSV included",
        peak_memory().unwrap_or_default() * 1e-6
    );
    if arguments.read_only {
        return Ok(());
    }
    let row = |x: &[f64]| faer::Mat::from_fn(1, x.len(), |_, k| x[k]);
    let half = read.len() / 2;
    let data =
        DataSet::single(read.sample_time_s, row(&read.input[..half]), row(&read.output[..half]))?;
    let clock = Instant::now();
    estimate_delay(&data)?;
    println!("  {:8.3} s  input delay", clock.elapsed().as_secs_f64());
    let options = IdentifyOptions { delay_s: Some(0.0), ..IdentifyOptions::default() };
    let clock = Instant::now();
    let found = steerwright_sysid::identify(&read, &options)?;
    println!("  {:8.3} s  order, model, noise, evidence", clock.elapsed().as_secs_f64());
    println!("  validation fit {:.2} %", found.plant.evidence.fit.validation);

    let next_to_this = || Some(std::env::current_exe().ok()?.with_file_name("steerwright"));
    match arguments.program.clone().or_else(next_to_this).filter(|program| program.exists()) {
        Some(program) => {
            let mut times = Vec::new();
            for _ in 0..arguments.runs.max(1) {
                let mut command = Command::new(&program);
                command.arg("identify").arg(&log).arg("-o").arg(folder.join("plant.json"));
                let clock = Instant::now();
                let output = command.output()?;
                times.push(clock.elapsed().as_secs_f64());
                if !output.status.success() {
                    return Err(String::from_utf8_lossy(&output.stderr).into());
                }
            }
            times.sort_by(f64::total_cmp);
            let middle = times[times.len() / 2];
            println!(
                "steerwright identify, CSV to plant.json: {middle:.3} s (median of {}, {:.3} to {:.3} s); target 0.5 s",
                times.len(),
                times[0],
                times[times.len() - 1]
            );
        }
        None => println!("left out: steerwright (cargo build --release, or --program PATH)"),
    }
    peer(&log)
}

/// The peer, from the interpreter with the peers' packages.
fn peer(log: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut python = match steerwright_evaluation::python() {
        Ok(python) => python,
        Err(problem) => {
            println!("left out: Python with ctrlsys: {problem}");
            return Ok(());
        }
    };
    let clock = Instant::now();
    let output = python.args(["-c", PEER]).arg(log).output()?;
    let all = clock.elapsed().as_secs_f64();
    if output.status.success() {
        let message = String::from_utf8_lossy(&output.stdout);
        println!(
            "Python with numpy and ctrlsys, one R factor, no evidence: {all:.3} s ({})",
            message.trim()
        );
    } else {
        println!(
            "left out: Python with ctrlsys: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    Ok(())
}
