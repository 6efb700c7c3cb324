//! `cargo xtask evaluate long_log`: a log of some hundred megabytes accumulated in chunks, alone and in
//! two files that are merged, in time and peak memory; and the result of the same logs held in memory.

use super::options;
use clap::Parser;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use steerwright_drivelog::{LogFile, LogOptions};
use steerwright_evaluation::Drive;
use steerwright_evaluation::measure::{peak_memory, processor_time_s};
use steerwright_sysid::{AccumulateOptions, Accumulated, IdentifyOptions};

/// A long log, accumulated.
#[derive(Parser)]
struct Arguments {
    /// Size of the log
    #[arg(long, default_value_t = 300)]
    megabytes: usize,
    /// Leave out the same logs in memory
    #[arg(long)]
    no_memory: bool,
}

pub(crate) fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Arguments = options();
    let folder = tempfile::tempdir()?;
    let [long, short] = ["long.csv", "short.csv"].map(|name| folder.path().join(name));
    let size = write(&long, 1_000_000 * arguments.megabytes, 0)?;
    write(&short, 10_000_000, 1000)?;
    // The program's own memory with a log of 10 MB: what grows with the log is beyond that.
    let base = accumulate(&short)?;
    let before = peak_memory().ok_or("the system does not report the peak memory")?;
    let start = processor_time_s();
    let mut all = accumulate(&long)?;
    let seconds = processor_time_s() - start;
    let peak = peak_memory().unwrap_or_default();
    let (estimation, validation) = all.samples();
    println!(
        "{:.0} MB of CSV, {} samples: accumulated in {seconds:.1} s of processor time ({:.0} MB/s)",
        size * 1e-6,
        estimation + validation,
        size * 1e-6 / seconds
    );
    println!(
        "peak memory of the program {:.1} MB, after a log of 10 MB {:.1} MB; the factor is a file of {:.0} kB",
        peak * 1e-6,
        before * 1e-6,
        formats_size(&all)
    );
    all.merge(base)?;
    let start = processor_time_s();
    let plant = all.identify(&IdentifyOptions::default())?;
    println!(
        "merged with another and identified in {:.2} s: order {}, {:.2} % on validation windows",
        processor_time_s() - start,
        plant.order(),
        plant.evidence.fit.validation
    );
    if arguments.no_memory {
        return Ok(());
    }
    let drives = vec![vec![open(&long)?], vec![open(&short)?]];
    let log = steerwright_drivelog::read_drives(Vec::new(), drives, &LogOptions::default())?;
    let start = processor_time_s();
    let options = IdentifyOptions { delay_s: Some(0.0), ..IdentifyOptions::default() };
    let plant = steerwright_sysid::identify(&log, &options)?.plant;
    println!(
        "the same logs in memory: identified in {:.2} s: order {}, {:.2} % on validation data",
        processor_time_s() - start,
        plant.order(),
        plant.evidence.fit.validation
    );
    Ok(())
}

/// Kilobytes of the file.
fn formats_size(state: &Accumulated) -> f64 {
    let file = state.to_file();
    1e-3 * (file.estimation.len() + file.validation.len()) as f64
}

fn accumulate(path: &Path) -> Result<Accumulated, Box<dyn std::error::Error>> {
    Ok(Accumulated::of_log(open(path)?, &AccumulateOptions::default())?)
}

fn open(path: &Path) -> std::io::Result<LogFile<'static>> {
    Ok(LogFile::of_file(&path.display().to_string(), File::open(path)?))
}

/// Writes drive after drive on one clock, of seeds from the given one; the bytes written.
fn write(path: &Path, bytes: usize, seed: u64) -> Result<f64, Box<dyn std::error::Error>> {
    const ROWS: usize = 60_000;
    const STEP: f64 = 0.01;
    let mut out = BufWriter::new(File::create(path)?);
    let (mut written, mut part) = (0, 0);
    while written < bytes {
        let drive =
            Drive { sample_time: STEP, delay: 0.0, servo: 0.0, noise: 0.002, seed: seed + part };
        for (k, line) in drive.record(ROWS).csv().lines().enumerate() {
            if k == 0 {
                if part == 0 {
                    writeln!(out, "{line}")?;
                }
                continue;
            }
            let rest = line.split_once(',').map_or("", |(_, rest)| rest);
            // Between drives the logger rests for ten seconds.
            let t = STEP * (k - 1) as f64 + part as f64 * (STEP * ROWS as f64 + 10.0);
            writeln!(out, "{t:.2},{rest}")?;
            written += rest.len() + 10;
        }
        part += 1;
    }
    out.flush()?;
    drop(out);
    Ok(std::fs::metadata(path)?.len() as f64)
}
