//! `cargo xtask evaluate command_line`: how long the command line takes from a CSV file to `plant.json`
//! with all evidence, and where the time goes; the processor time compared with reading the same file in Python and
//! SLICOT's subspace identification through `ctrlsys`.

use super::options;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use steerwright_drivelog::LogOptions;
use steerwright_evaluation::Drive;
use steerwright_evaluation::measure::{median, peak_memory, processor_time_s};
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
    /// Largest ratio of the processor times, here over NumPy and ctrlsys: a larger one is an error
    #[arg(long)]
    limit: Option<f64>,
}

/// Reads the same file, takes every second sample as the reader of logs does, and identifies orders 1 to 8 with 15 and 30
/// block rows by SLICOT: 16 models, nothing of which is refined or validated. The last line is the processor time.
const PEER: &str = r#"
import sys, time
import numpy, ctrlsys
start = time.process_time()
log = numpy.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
read = time.process_time()
u, y = (numpy.asfortranarray(log[::2, [c]] - log[::2, [c]].mean()) for c in (1, 2))
models = 0
for s in (15, 30):
    _, r, _, _, info = ctrlsys.ib01ad("N", "C", "N", "O", "N", "N", s, 1, 1, u, y, 0.0, -1.0)
    for n in range(1, 9):
        # Without the gain, whose workspace is too short with 30 block rows; a copy, since R is overwritten.
        found = ctrlsys.ib01bd("C", "A", "N", s, n, 1, 1, len(u), r.copy(order="F"), 0.0)
        assert info == 0 and found[-1] == 0, (s, n)
        models += 1
done = time.process_time()
print("read %.3f s, %d models %.3f s" % (read - start, models, done - read))
print(done - start)
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
    peer(&log, arguments.runs.max(1), arguments.limit)
}

/// Processor time from the file to the model of the structure `state-space`, s.
fn own_time(log: &Path) -> Result<f64, Box<dyn std::error::Error>> {
    let start = processor_time_s();
    let files = [("drive.csv".to_owned(), std::fs::read(log)?)];
    let read = steerwright_drivelog::read_log(&files, &LogOptions::default())?;
    steerwright_sysid::identify(&read, &IdentifyOptions::default())?;
    Ok(processor_time_s() - start)
}

/// The peer, from the interpreter with the peers' packages, and the ratio of the processor times.
fn peer(log: &Path, runs: usize, limit: Option<f64>) -> Result<(), Box<dyn std::error::Error>> {
    let (mut own, mut theirs, mut parts) = (Vec::new(), Vec::new(), String::new());
    // In turn, so that what else the machine does is in both.
    for _ in 0..runs {
        own.push(own_time(log)?);
        match peer_time(log) {
            Ok((seconds, of)) => {
                theirs.push(seconds);
                parts = of;
            }
            Err(problem) => {
                println!("left out: Python with ctrlsys: {problem}");
                break;
            }
        }
    }
    if !theirs.is_empty() {
        own.truncate(theirs.len());
    }
    let own = median(&own);
    println!("processor time, CSV to the model of the structure state-space: {own:.3} s");
    if !theirs.is_empty() {
        let theirs = median(&theirs);
        println!("  NumPy and ctrlsys, not refined, no evidence: {theirs:.3} s ({parts})");
        let ratio = own / theirs;
        println!("  ratio {ratio:.2} (medians)");
        if let Some(limit) = limit.filter(|limit| ratio.is_nan() || ratio > *limit) {
            return Err(format!(
                "the identification takes {ratio:.1} times the processor time of NumPy and ctrlsys, at most {limit} is allowed: profile `identify` of the structure state-space"
            )
            .into());
        }
    }
    Ok(())
}

/// Processor time of the peer without its imports, s, and its parts in words.
fn peer_time(log: &Path) -> Result<(f64, String), String> {
    let mut python = steerwright_evaluation::python()?;
    let output = python.args(["-c", PEER]).arg(log).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
    }
    let message = String::from_utf8_lossy(&output.stdout);
    let mut lines = message.lines();
    let parts = lines.next().unwrap_or_default().to_owned();
    let seconds = lines.next().and_then(|line| line.parse().ok());
    Ok((seconds.ok_or("no processor time is printed")?, parts))
}
