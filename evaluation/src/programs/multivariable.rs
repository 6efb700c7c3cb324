//! Plants of several named channels: fits on recorded sets beside SLICOT's, short records, and whether stated bands hold the
//! truth: `cargo xtask evaluate multivariable`.
//!
//! Sets are read as `steerwright identify` reads them, with default options: the first half estimates and the second
//! validates. SLICOT's N4SID (ctrlsys) runs in the same process group with a grid of settings; its best of the grid is chosen
//! by the validation data, which no user can do.

use super::options;
use clap::Parser;
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_evaluation::measure::median;
use steerwright_evaluation::{Random, on_all_cores, request};
use steerwright_sysid::multivariable::{IdentifiedPlant, identify_channels};
use steerwright_sysid::{IdentifyOptions, StateSpace, simulate};

/// Prints fits on recorded and simulated plants of several channels, and the coverage of their bands.
#[derive(Parser)]
struct Arguments {
    /// Folder of the recordings that are not in the repository: daisy
    #[arg(long)]
    data: Option<PathBuf>,
    /// Simulated systems of each kind
    #[arg(long, default_value_t = 100)]
    systems: usize,
    /// Samples of the systems whose bands are counted
    #[arg(long, default_value_t = 1000)]
    samples: usize,
    /// Seed of the systems
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print a line for each system
    #[arg(long)]
    list: bool,
}

const PEERS: &str = include_str!("../../python/multivariable.py");

/// A log as CSV with its inputs and outputs.
struct Set {
    name: String,
    csv: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
    period_s: f64,
}

impl Set {
    fn read(file: &Path, inputs: &[&str], outputs: &[&str], period_s: f64) -> Result<Self, String> {
        let csv = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
        let names = |all: &[&str]| all.iter().map(ToString::to_string).collect();
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, csv, inputs: names(inputs), outputs: names(outputs), period_s })
    }

    fn identified(&self) -> Result<IdentifiedPlant, Box<dyn Error>> {
        let options = LogOptions {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            row_period_s: Some(self.period_s),
            ..LogOptions::default()
        };
        let files = [(format!("{}.csv", self.name), self.csv.clone().into_bytes())];
        let log = read_log(&files, &options)?;
        Ok(identify_channels(&log, &IdentifyOptions::default())?)
    }

    /// The columns, input after input and output after output.
    fn numbers(&self) -> Vec<f64> {
        let mut lines = self.csv.lines();
        let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| line.split(',').map(|x| x.trim().parse().unwrap_or(f64::NAN)).collect())
            .collect();
        let place = |name: &String| header.iter().position(|h| h == name).unwrap_or_default();
        let columns = self.inputs.iter().chain(&self.outputs).map(place);
        columns.flat_map(|c| rows.iter().map(move |row| row[c])).collect()
    }

    /// The best of SLICOT's grid: mean fit of the outputs on the validation data, fits by output, and the seconds of one
    /// model and of the grid.
    fn slicots(&self) -> Result<(f64, String, f64, f64), String> {
        let arguments = [self.inputs.len(), self.outputs.len()].map(|n| n.to_string());
        let lines = request(PEERS, &self.numbers(), &arguments)?;
        let line = lines.last().ok_or("no line")?;
        let (numbers, text) = line.split_once('|').ok_or("no fits")?;
        let mut numbers = numbers.split_whitespace().filter_map(|x| x.parse::<f64>().ok());
        let mut next = || numbers.next().unwrap_or(f64::NAN);
        Ok((next(), text.trim().to_owned(), next(), next()))
    }
}

pub(crate) fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Arguments = options();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drives");
    let mut sets =
        vec![Set::read(&own.join("dryer2/dryer2_slicot_ib01ad.csv"), &["u"], &["y"], 0.08)?];
    if let Some(folder) = &arguments.data {
        let daisy = |name: &str, inputs: &[&str], outputs: &[&str]| {
            Set::read(&folder.join("daisy").join(name), inputs, outputs, 1.0)
        };
        sets.push(daisy("robot_arm.csv", &["reaction_torque"], &["acceleration"])?);
        sets.push(daisy("exchanger.csv", &["flow_rate"], &["outlet_temperature"])?);
        let outputs = ["tracking_error_1", "tracking_error_2"];
        sets.push(daisy("CD_player_arm.csv", &["force_1", "force_2"], &outputs)?);
    }
    println!("recorded sets, first half to second half, default options; fits on validation data");
    for set in &sets {
        let before = Instant::now();
        let found = set.identified()?;
        let seconds = before.elapsed().as_secs_f64();
        println!(
            "  {:<14} order {:<2} {} in {seconds:.2} s",
            set.name,
            found.plant.order(),
            fits(&found)
        );
        match set.slicots() {
            Ok((_, text, one, all)) => println!(
                "  {:<14} SLICOT's best of the grid: {text}; {one:.3} s a model, {all:.2} s the grid",
                ""
            ),
            Err(problem) => println!("  SLICOT: {problem}"),
        }
    }
    short_records(&arguments);
    coverage(&arguments);
    Ok(())
}

fn fits(found: &IdentifiedPlant) -> String {
    let fits: Vec<String> = found
        .plant
        .evidence
        .outputs
        .iter()
        .map(|o| format!("{} {:.2}", o.output, o.fit.validation))
        .collect();
    fits.join(", ")
}

/// Random systems, driven by coloured inputs, with noise of a signal-to-noise ratio of 10 to 30 dB.
struct Simulated {
    truth: StateSpace,
    set: Set,
}

impl Simulated {
    fn new(seed: u64, samples: usize, channels: (usize, usize), most: usize) -> Self {
        let mut random = Random(seed);
        let (m, p) = channels;
        let order = 1 + (random.uniform() * most as f64) as usize;
        let mut truth = random.system(order, m, p);
        truth.d = faer::Mat::zeros(p, m);
        // Inputs move at random frequencies below a cut-off of their own.
        let pole = 0.3 + 0.5 * random.uniform();
        let mut state = vec![0.0; m];
        let inputs: Vec<Vec<f64>> = {
            let mut rows = vec![Vec::with_capacity(samples); m];
            for _ in 0..samples {
                for (j, row) in rows.iter_mut().enumerate() {
                    state[j] = pole * state[j] + (1.0 - pole * pole).sqrt() * random.normal();
                    row.push(state[j]);
                }
            }
            rows
        };
        let u = faer::Mat::from_fn(m, samples, |i, t| inputs[i][t]);
        let y = simulate(&truth, u.as_ref(), &vec![0.0; order]);
        let decibel = 10.0 + 20.0 * random.uniform();
        let noise_pole = 0.7 * random.uniform();
        let mut csv = String::new();
        let names = |letter: &str, n: usize| -> Vec<String> {
            (1..=n).map(|k| format!("{letter}{k}")).collect()
        };
        let (input_names, output_names) = (names("u", m), names("y", p));
        let _ = writeln!(csv, "{},{}", input_names.join(","), output_names.join(","));
        let size: Vec<f64> = (0..p)
            .map(|i| {
                let power = y.row(i).iter().map(|x| x * x).sum::<f64>() / samples as f64;
                power.sqrt() * 10_f64.powf(-decibel / 20.0)
            })
            .collect();
        let mut noise = vec![0.0; p];
        for t in 0..samples {
            let mut cells: Vec<f64> = (0..m).map(|j| 3.0 + inputs[j][t]).collect();
            for i in 0..p {
                let white = (1.0 - noise_pole * noise_pole).sqrt() * random.normal();
                noise[i] = noise_pole * noise[i] + white;
                cells.push(-7.0 + y[(i, t)] + size[i] * noise[i]);
            }
            let cells: Vec<String> = cells.iter().map(|x| format!("{x:.9}")).collect();
            let _ = writeln!(csv, "{}", cells.join(","));
        }
        let set = Set {
            name: format!("system {seed}"),
            csv,
            inputs: input_names,
            outputs: output_names,
            period_s: 1.0,
        };
        Self { truth, set }
    }
}

fn mean_fit(found: &IdentifiedPlant) -> f64 {
    let fits = found.plant.evidence.outputs.iter().map(|o| o.fit.validation);
    fits.sum::<f64>() / found.plant.outputs.len() as f64
}

/// 200 samples, 5 inputs, 3 outputs.
fn short_records(arguments: &Arguments) {
    const SAMPLES: usize = 200;
    let found: Vec<Option<[f64; 4]>> = on_all_cores("short records", arguments.systems, |k| {
        let system = Simulated::new(arguments.seed + 1000 + k as u64, SAMPLES, (5, 3), 4);
        let found = match system.set.identified() {
            Ok(found) => found,
            Err(problem) => {
                eprintln!("{}: {problem}", system.set.name);
                return None;
            }
        };
        let slicots = system.set.slicots().map_or(f64::NAN, |(fit, ..)| fit);
        let tried = found.plant.evidence.order_table.len() as f64;
        Some([mean_fit(&found), slicots, found.plant.order() as f64, tried])
    });
    let all: Vec<[f64; 4]> = found.iter().flatten().copied().collect();
    let of = |k: usize| median(&all.iter().map(|row| row[k]).collect::<Vec<_>>());
    let behind = all.iter().filter(|row| row[0] < row[1] - 1.0).count();
    if arguments.list {
        for row in &all {
            println!(
                "    fit {:.2}, SLICOT {:.2}, order {}, tried {}",
                row[0], row[1], row[2], row[3]
            );
        }
    }
    println!("\n{SAMPLES} samples, 5 inputs, 3 outputs, {} of {} systems", all.len(), found.len());
    println!(
        "  median of the mean fits {:.2} %, SLICOT's best of the grid {:.2} %; more than a point behind it {behind}; median of the orders tried {}",
        of(0),
        of(1),
        of(3)
    );
}

/// Frequencies of the bands over half the sample rate.
const FREQUENCIES: [f64; 3] = [0.05, 0.2, 0.5];

fn coverage(arguments: &Arguments) {
    let found: Vec<Option<Vec<[bool; 3]>>> = on_all_cores("coverage", arguments.systems, |k| {
        let seed = arguments.seed + 5000 + k as u64;
        let channels = (1 + k % 3, 1 + (k / 3) % 3);
        let system = Simulated::new(seed, arguments.samples, channels, 5);
        let found = system.set.identified().map_err(|e| eprintln!("system {k}: {e}")).ok()?;
        let plant = &found.plant;
        plant.uncertainty.as_ref()?;
        let mut held = Vec::new();
        for (pair, i, j) in (0..channels.1)
            .flat_map(|i| (0..channels.0).map(move |j| (i, j)))
            .map(|(i, j)| (&plant.evidence.pairs[i * channels.0 + j], i, j))
        {
            let mut row = [false; 3];
            for (row, share) in row.iter_mut().zip(FREQUENCIES) {
                let near = |hz: f64| (hz / (0.5 * share)).ln().abs();
                let bands = pair.frequency_response.iter();
                let band =
                    bands.min_by(|a, b| near(a.frequency_hz).total_cmp(&near(b.frequency_hz)));
                let Some(band) = band else { continue };
                let omega = std::f64::consts::TAU * band.frequency_hz;
                let (re, im) = system.truth.frequency_response(i, j, omega);
                let apart = (band.magnitude - re.hypot(im)).abs();
                *row = apart <= 1.96 * band.magnitude_standard_error;
            }
            held.push(row);
        }
        Some(held)
    });
    let all: Vec<[bool; 3]> = found.iter().flatten().flatten().copied().collect();
    let share =
        |k: usize| 100.0 * all.iter().filter(|row| row[k]).count() as f64 / all.len() as f64;
    let systems = found.iter().flatten().count();
    println!(
        "\n95 % bands of the gain of {} pairs of {systems} of {} systems, {} samples",
        all.len(),
        found.len(),
        arguments.samples
    );
    println!(
        "coverage: {:.1}, {:.1}, {:.1} % at 0.05, 0.2, 0.5 of half the sample rate",
        share(0),
        share(1),
        share(2)
    );
}
