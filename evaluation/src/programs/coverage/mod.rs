//! Whether stated confidence bands hold what they state: `cargo xtask evaluate coverage`.
//!
//! Known linear cars are driven for two minutes each, as [`LinearDrive::realistic`] describes, and what
//! is identified from their logs is compared with the car. A 95 % band is to hold the truth in 95 % of
//! the drives; over 240 drives the standard error of that share is 1.4 %. `bias` and `error` are the
//! median and the median size of estimate less truth, in the unit next to them; `bias/s.e.` and
//! `error/s.e.` the same over the stated standard error, the second scaled to be 1 where that is right.
//!
//! `--without` leaves a disturbance out of every drive, which shows what causes which error. `--steering` is what
//! the log has of the steering, and `--intersample` what is stated about it.

mod arguments;
mod tally;

use super::options;
use arguments::{Column, Disturbance, DriveKind, StatedIntersample};
use clap::Parser;
use std::error::Error;
use steerwright_drivelog::{LogOptions, read_log};
use steerwright_evaluation::measure::median;
use steerwright_evaluation::{LinearCar, LinearDrive, Random, on_all_cores};
use steerwright_sysid::bicycle::{BicycleOptions, IdentifiedBicycle, identify_bicycle};
use steerwright_sysid::{Identified, IdentifyOptions, identify};
use tally::{Tally, header};

/// Prints in how many simulated drives each stated 95 % band holds the truth.
#[derive(Parser)]
struct Arguments {
    /// Drives, each of a car of its own
    #[arg(long, default_value_t = 240)]
    drives: usize,
    /// Seed of cars and drives
    #[arg(long, default_value_t = 9)]
    seed: u64,
    /// What is left out of every drive
    #[arg(long, value_enum, value_delimiter = ',')]
    without: Vec<Disturbance>,
    /// Sample time to bring the logs to, s, in place of the automatic one
    #[arg(long)]
    sample_time: Option<f64>,
    /// Order of the state-space model, in place of the automatic one
    #[arg(long)]
    order: Option<usize>,
    /// Delay of the input, s, in place of the automatic one
    #[arg(long)]
    delay: Option<f64>,
    /// Rows of the logs a second
    #[arg(long, default_value_t = 100.0)]
    rate: f64,
    /// Length of the drives, s
    #[arg(long, default_value_t = 120.0)]
    seconds: f64,
    /// What is driven; a table for each
    #[arg(long, value_enum, value_delimiter = ',', default_value = "realistic")]
    kind: Vec<DriveKind>,
    /// What the log has of the steering
    #[arg(long, value_enum, default_value_t = Column::Measured)]
    steering: Column,
    /// What is stated about the steering between its samples; without it, nothing is stated
    #[arg(long, value_enum)]
    intersample: Option<StatedIntersample>,
    /// Print a line for each drive
    #[arg(long)]
    list: bool,
    /// Folder to write the logs to
    #[arg(long, value_name = "DIR")]
    write: Option<std::path::PathBuf>,
}

/// Frequencies of the bands, Hz.
const FREQUENCIES_HZ: [f64; 3] = [0.3, 1.0, 2.0];
/// The response error is that from one to the other, Hz.
const BAND_HZ: (f64, f64) = (0.1, 2.0);

pub(crate) fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Arguments = options();
    for (i, kind) in arguments.kind.iter().enumerate() {
        if arguments.kind.len() > 1 {
            println!("{}{}", if i > 0 { "\n" } else { "" }, kind.name());
        }
        table(&arguments, *kind);
    }
    Ok(())
}

fn table(arguments: &Arguments, kind: DriveKind) {
    let drives: Vec<Result<Drive, String>> = on_all_cores("drives", arguments.drives, |k| {
        Drive::new(arguments, kind, k).map_err(|e| format!("drive {k}: {e}"))
    });
    let mut table = Table::default();
    for (k, drive) in drives.iter().enumerate() {
        match drive {
            Ok(drive) => {
                if arguments.list {
                    println!("{k:>4} {}", drive.line());
                }
                table.add(drive);
            }
            Err(problem) => {
                table.refused += 1;
                eprintln!("{problem}");
            }
        }
    }
    table.print();
}

/// A drive with what was identified from it.
struct Drive {
    drive: LinearDrive,
    state_space: Identified,
    bicycle: IdentifiedBicycle,
}

impl Drive {
    fn new(arguments: &Arguments, kind: DriveKind, k: usize) -> Result<Self, Box<dyn Error>> {
        let seed = arguments.seed.wrapping_mul(1_000_003).wrapping_add(7919 * k as u64);
        let mut random = Random(seed);
        let car = LinearCar::random(&mut random);
        let mut drive = match kind {
            DriveKind::Realistic => LinearDrive::realistic(car, &mut random),
            DriveKind::Ideal => LinearDrive::ideal(car, &mut random),
            DriveKind::Sweep => LinearDrive::clean_sweep(car, &mut random),
            DriveKind::HeldSteps => LinearDrive::held_steps(car, &mut random),
        };
        drive.driver = k % 2 == 1 && matches!(kind, DriveKind::Realistic | DriveKind::Ideal);
        drive.rate_hz = arguments.rate;
        drive.seconds = arguments.seconds;
        drive.steering = arguments.steering.into();
        for without in &arguments.without {
            match without {
                Disturbance::Jitter => drive.speed_spread = 0.0,
                Disturbance::Gusts => drive.gust_radps = 0.0,
                Disturbance::Quantisation => drive.quantum_deg = 0.0,
                Disturbance::Lash => drive.lash_deg = 0.0,
                Disturbance::Gyro => drive.gyro_noise_radps = 0.0,
                Disturbance::Driver => drive.driver = false,
            }
        }
        let csv = drive.record().csv();
        if let Some(folder) = &arguments.write {
            std::fs::write(folder.join(format!("{k}.csv")), &csv)?;
        }
        let options = LogOptions {
            steering_ratio: Some(1.0),
            sample_time_s: arguments.sample_time,
            intersample: arguments.intersample.map(Into::into),
            ..LogOptions::default()
        };
        let log = read_log(&[(format!("{k}.csv"), csv.into_bytes())], &options)?;
        let options = IdentifyOptions {
            order: arguments.order,
            delay_s: arguments.delay,
            ..IdentifyOptions::default()
        };
        let state_space = identify(&log, &options)?;
        let bicycle = identify_bicycle(&log, &BicycleOptions::default())?;
        Ok(Self { drive, state_space, bicycle })
    }

    /// Speed that the state-space model states, m/s.
    fn speed(&self) -> f64 {
        self.state_space.plant.operating_point.speed_mps
    }

    /// Response of the identified model at the road wheel, its delay included; the continuous one
    /// where there is one, else that of the sampled model less half a sample of hold.
    fn response(&self, hz: f64) -> (f64, f64) {
        let plant = &self.state_space.plant;
        let omega = std::f64::consts::TAU * hz;
        let discrete = &plant.discrete;
        let d = discrete.d.entry(0, 0);
        let n = plant.order();
        let delay = omega * plant.input_delay_s;
        let ((re, im), late) = match &plant.continuous {
            Some(c) => {
                let of = |i, j| c.f.entry(i, j);
                (pencil(n, of, |i| c.g.entry(i, 0), |j| c.h.entry(0, j), (0.0, omega)), delay)
            }
            None => {
                let angle = omega * discrete.sample_time_s;
                let z = (angle.cos(), angle.sin());
                let of = |i, j| discrete.a.entry(i, j);
                let (b, c) = (|i| discrete.b.entry(i, 0), |j| discrete.c.entry(0, j));
                (pencil(n, of, b, c, z), delay - 0.5 * angle)
            }
        };
        let re = re + d;
        let (sin, cos) = late.sin_cos();
        (re * cos + im * sin, im * cos - re * sin)
    }

    /// Response of the identified bicycle at the road wheel.
    fn bicycle_response(&self, hz: f64) -> (f64, f64) {
        let found = &self.bicycle.bicycle.vehicle;
        let car = LinearCar {
            mass_kg: found.mass_kg,
            yaw_inertia_kgm2: found.yaw_inertia_kgm2,
            front_m: found.distance_front_m,
            rear_m: found.distance_rear_m,
            front_stiffness: found.cornering_stiffness_front_npr,
            rear_stiffness: found.cornering_stiffness_rear_npr,
            servo_s: found.actuator_time_constant_s,
        };
        let (re, im) = car.response(self.speed(), hz);
        let (sin, cos) = (std::f64::consts::TAU * hz * found.actuator_delay_s).sin_cos();
        (re * cos + im * sin, im * cos - re * sin)
    }

    /// ‖Ĝ − G‖/‖G‖ over the band.
    fn response_error(&self, response: impl Fn(f64) -> (f64, f64)) -> f64 {
        const POINTS: usize = 39;
        let (mut apart, mut size) = (0.0, 0.0);
        for k in 0..POINTS {
            let hz = BAND_HZ.0 + (BAND_HZ.1 - BAND_HZ.0) * k as f64 / (POINTS - 1) as f64;
            let (found, truth) = (response(hz), self.drive.car.response(self.speed(), hz));
            apart += (found.0 - truth.0).powi(2) + (found.1 - truth.1).powi(2);
            size += truth.0.powi(2) + truth.1.powi(2);
        }
        (apart / size).sqrt()
    }

    /// The grade of the state-space model by its name: pass, warn or fail.
    fn grade(&self) -> &'static str {
        self.state_space.plant.quality.grade.name()
    }

    /// Errors of the phase at [`FREQUENCIES_HZ`], in stated standard errors.
    fn phase_scores(&self) -> [f64; 3] {
        FREQUENCIES_HZ.map(|hz| {
            let uncertainty = self.state_space.plant.uncertainty.as_ref();
            let stated = uncertainty.and_then(|u| u.errors_at(hz)).map_or(f64::NAN, |e| e[1]);
            let (found, truth) = (self.response(hz), self.drive.car.response(self.speed(), hz));
            let apart = found.1.atan2(found.0) - truth.1.atan2(truth.0);
            apart.sin().atan2(apart.cos()) / stated
        })
    }

    /// Stated standard errors of gain, %, and phase, degrees, at [`FREQUENCIES_HZ`].
    fn stated_errors(&self) -> String {
        let Some(uncertainty) = &self.state_space.plant.uncertainty else { return "none".into() };
        let at = |hz| uncertainty.errors_at(hz).unwrap_or([f64::INFINITY; 2]);
        let errors = FREQUENCIES_HZ.map(at);
        let [gain, phase] = [0, 1].map(|i| errors.map(|e| e[i]));
        format!("{:.1?} % {:.1?}°", gain.map(|e| 100.0 * e), phase.map(f64::to_degrees))
    }

    fn line(&self) -> String {
        let plant = &self.state_space.plant;
        format!(
            "v {:>5.1} driver {:<5} order {} delay {:.3} {} fit {:>6.2} error {:>5.2} % stated {} phase off {:.1?} of these {} {}",
            self.drive.speed_mps,
            self.drive.driver,
            plant.order(),
            plant.input_delay_s,
            plant.evidence.method,
            plant.evidence.fit.validation,
            100.0 * self.response_error(|hz| self.response(hz)),
            self.stated_errors(),
            self.phase_scores(),
            self.grade(),
            plant.quality.codes()
        )
    }
}

/// `c·(zI − a)⁻¹·b` for a z given as (real, imaginary), by elimination.
fn pencil(
    n: usize,
    a: impl Fn(usize, usize) -> f64,
    b: impl Fn(usize) -> f64,
    c: impl Fn(usize) -> f64,
    z: (f64, f64),
) -> (f64, f64) {
    use faer::{Mat, c64, linalg::solvers::Solve};
    let z = c64::new(z.0, z.1);
    let m = Mat::from_fn(n, n, |i, j| {
        (if i == j { z } else { c64::new(0.0, 0.0) }) - c64::new(a(i, j), 0.0)
    });
    let x = m.partial_piv_lu().solve(Mat::from_fn(n, 1, |i, _| c64::new(b(i), 0.0)));
    let sum =
        (0..n).map(|j| c64::new(c(j), 0.0) * x[(j, 0)]).fold(c64::new(0.0, 0.0), |a, b| a + b);
    (sum.re, sum.im)
}

/// What would be wrong with a grade, as response errors.
const GRADES: [(&str, &str, std::ops::Range<f64>); 3] = [
    ("pass", "above 10 %", 0.1..f64::INFINITY),
    ("warn", "above 10 %", 0.1..f64::INFINITY),
    ("fail", "below 3 %", 0.0..0.03),
];

/// All that is counted.
#[derive(Default)]
struct Table {
    gain: [Tally; 3],
    phase: [Tally; 3],
    steady: Tally,
    poles: Tally,
    bicycle: [Tally; 4],
    orders: [usize; 10],
    delays: usize,
    feedback: usize,
    /// Response error and grade of each drive.
    errors: Vec<(f64, &'static str)>,
    /// The same of the bicycle.
    bicycle_errors: Vec<(f64, &'static str)>,
    without_bands: usize,
    /// Validation fits, %.
    fits: Vec<f64>,
    discrete: usize,
    refused: usize,
}

/// The bicycle's quantities that are compared.
const OF_BICYCLE: [&str; 4] =
    ["yaw_rate_gain", "effective_wheelbase", "natural_frequency", "damping_ratio"];

impl Table {
    fn add(&mut self, drive: &Drive) {
        let plant = &drive.state_space.plant;
        self.errors.push((drive.response_error(|hz| drive.response(hz)), drive.grade()));
        self.fits.push(plant.evidence.fit.validation);
        self.discrete += usize::from(plant.continuous.is_none());
        let grade = drive.bicycle.bicycle.quality.grade.name();
        let error = drive.response_error(|hz| drive.bicycle_response(hz));
        self.bicycle_errors.push((error, grade));
        self.orders[plant.order().min(9)] += 1;
        self.delays += usize::from(plant.input_delay_s > 0.0);
        self.feedback += usize::from(plant.evidence.feedback.as_ref().is_some_and(|f| !f.pass));
        self.add_bicycle(drive);
        let Some(uncertainty) = &plant.uncertainty else {
            self.without_bands += 1;
            return;
        };
        let v = drive.speed();
        for (k, hz) in FREQUENCIES_HZ.into_iter().enumerate() {
            let Some([relative, phase]) = uncertainty.errors_at(hz) else { continue };
            let (found, truth) = (drive.response(hz), drive.drive.car.response(v, hz));
            let gain = found.0.hypot(found.1);
            self.gain[k].ratio(gain, relative * gain, truth.0.hypot(truth.1));
            self.phase[k].angle(found.1.atan2(found.0), phase, truth.1.atan2(truth.0));
        }
        if let Some(gain) = &uncertainty.steady_state_gain {
            let (value, error) = (gain.value, gain.standard_error);
            self.steady.ratio(value, error, drive.drive.car.steady_state_gain(v));
        }
        self.add_poles(drive);
    }

    /// Each true pole of the upper half plane in the 95 % ellipse of the nearest one identified.
    fn add_poles(&mut self, drive: &Drive) {
        let plant = &drive.state_space.plant;
        let Some(uncertainty) = &plant.uncertainty else { return };
        let t = plant.discrete.sample_time_s;
        for (re, im) in drive.drive.car.poles(drive.speed()).into_iter().filter(|p| p.1 >= 0.0) {
            let size = (t * re).exp();
            let (x, y) = (size * (t * im).cos(), size * (t * im).sin());
            let apart = |p: (f64, f64)| (p.0 - x).hypot(p.1 - y);
            let Some(p) = uncertainty
                .poles
                .iter()
                .min_by(|a, b| apart((a.re, a.im)).total_cmp(&apart((b.re, b.im))))
            else {
                continue;
            };
            let (dx, dy) = (p.re - x, p.im - y);
            let determinant = p.variance_re * p.variance_im - p.covariance * p.covariance;
            // Of a real pole the ellipse is a line.
            let (square, bound) = if determinant > 1e-9 * p.variance_re * p.variance_im {
                let form = p.variance_im * dx * dx - 2.0 * p.covariance * dx * dy
                    + p.variance_re * dy * dy;
                (form / determinant, 5.991)
            } else if dy.abs() < 1e-9 {
                (dx * dx / p.variance_re, 3.841)
            } else {
                (f64::INFINITY, 3.841)
            };
            self.poles.push(square.sqrt(), 100.0 * dx.hypot(dy) / (1.0 - x), square <= bound);
        }
    }

    fn add_bicycle(&mut self, drive: &Drive) {
        let Some(evidence) = &drive.bicycle.bicycle.evidence else { return };
        let v = evidence.speed.mean_mps;
        let [p, q] = drive.drive.car.poles(v);
        // s² − (p + q)·s + p·q.
        let frequency = (p.0 * q.0 - p.1 * q.1).sqrt();
        let damping = -0.5 * (p.0 + q.0) / frequency;
        let truth = [
            drive.drive.car.steady_state_gain(v),
            drive.drive.car.front_m + drive.drive.car.rear_m,
            frequency,
            damping,
        ];
        for ((tally, name), truth) in self.bicycle.iter_mut().zip(OF_BICYCLE).zip(truth) {
            if let Some(found) = evidence.identified.iter().find(|q| q.name == name) {
                tally.ratio(found.value, found.standard_error, truth);
            }
        }
    }

    fn print(&self) {
        println!("{}", header());
        for (of, name, unit) in [(&self.gain, "gain", "%"), (&self.phase, "phase", "°")] {
            for (tally, hz) in of.iter().zip(FREQUENCIES_HZ) {
                println!("{}", tally.row(&format!("{name} at {hz} Hz"), unit));
            }
        }
        println!("{}", self.steady.row("steady-state gain", "%"));
        println!("{}", self.poles.row("poles (nearest, ellipse)", "%"));
        for (tally, name) in self.bicycle.iter().zip(OF_BICYCLE) {
            println!("{}", tally.row(&format!("bicycle: {}", name.replace('_', " ")), "%"));
        }
        let errors: Vec<f64> = self.errors.iter().map(|e| 100.0 * e.0).collect();
        println!(
            "\nresponse error {} to {} Hz: median {:.2} %; feedback seen in {}, a delay in {}, no bands in {}, refused {}",
            BAND_HZ.0,
            BAND_HZ.1,
            median(&errors),
            self.feedback,
            self.delays,
            self.without_bands,
            self.refused
        );
        println!(
            "validation fit: median {:.2} %, least {:.2} %; no continuous model in {}",
            median(&self.fits),
            self.fits.iter().copied().fold(f64::INFINITY, f64::min),
            self.discrete
        );
        for (name, errors) in [("", &self.errors), ("bicycle: ", &self.bicycle_errors)] {
            for (grade, wrong, of) in GRADES {
                let all: Vec<f64> = errors.iter().filter(|e| e.1 == grade).map(|e| e.0).collect();
                let count = all.iter().filter(|e| of.contains(e)).count();
                println!("{name}{grade} {}, of which with an error {wrong} {count}", all.len());
            }
        }
        let orders: Vec<String> = (1..10)
            .filter(|n| self.orders[*n] > 0)
            .map(|n| format!("{n}: {}", self.orders[n]))
            .collect();
        println!("orders {}", orders.join(", "));
    }
}
