//! The time of a call of an FMU, compared with the same arithmetic in C and in pythonfmu.
//!
//! `cargo xtask bench fmu` prepares the inputs and runs it: the libraries of `bench-fmus/`, built
//! with the profile of the FMUs, in `STEERWRIGHT_BENCH_FMUS`, and an unpacked FMU of pythonfmu in
//! `STEERWRIGHT_BENCH_PYTHONFMU` (without it the ratios are left out), which finds the symbols of
//! Python only if the library `STEERWRIGHT_BENCH_LIBPYTHON` is loaded before. A C program measures
//! the processor time of its thread in rounds, each of all subjects in turn.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a tool of developers

mod documents;
mod examples;
mod table;
mod timing;

use fmi2_export::{CoSimulationUnit, Resources};
use model_description::{Causality, Kind};
use std::path::{Path, PathBuf};
use steerwright_host::Archive;
use steerwright_packaging::Binary;
use table::{Row, Statistics};
use timing::{Subject, compile};

/// Rounds, of which each times every subject.
const ROUNDS: usize = 15;
/// Calls of a subject in a round, and of one that is slow.
const CALLS: [u32; 2] = [1_000_000, 5_000];

fn main() {
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    // A check that everything runs; the times are imprecise.
    let short = std::env::args().any(|argument| argument == "--short");
    let rounds = if short { 3 } else { ROUNDS };
    let [calls, slow_calls] = CALLS.map(|calls| if short { calls / 100 } else { calls });
    let folder = tempfile::tempdir().unwrap();
    let timer = timing::compile_timer(folder.path()).expect("a C compiler, cc");
    let bare = folder.path().join("bare.so");
    compile(&["-O3", "-shared", "-fPIC", "bench/bare.c", "-lm"], &bare).unwrap();

    let mut subjects = Vec::new();
    let mut names = Vec::new();
    let mut add = |name: &str, subject: Subject| {
        names.push(name.to_owned());
        subjects.push(subject);
    };
    for function in ["linear_step", "pid_step"] {
        let (library, guid) = (bare.clone(), function.to_owned());
        let subject = Subject {
            kind: "bare",
            library,
            guid,
            uri: "-".into(),
            count: calls,
            reference: 0,
            range: [0.0; 2],
            start: String::new(),
        };
        add(&format!("bare {function}"), subject);
    }
    let archives = archives();
    let mut fmus = own(&archives);
    if let Some(fmus_folder) = std::env::var_os("STEERWRIGHT_BENCH_FMUS") {
        fmus.extend(of_the_benchmark(Path::new(&fmus_folder)));
    }
    for fmu in &fmus {
        for kind in ["empty", "get", "set", "step", "setstep"] {
            add(&format!("{} {kind}", fmu.name), fmu.subject(kind, calls));
        }
    }
    if let Some(unpacked) = std::env::var_os("STEERWRIGHT_BENCH_PYTHONFMU") {
        let fmu = pythonfmu(Path::new(&unpacked));
        for kind in ["step", "setstep"] {
            add(&format!("{} {kind}", fmu.name), fmu.subject(kind, slow_calls));
        }
    }

    let times = timing::time(&timer, rounds, &subjects);
    let rows: Vec<Row> = names
        .into_iter()
        .enumerate()
        .map(|(i, name)| Row { name, ns: Statistics::of(times.iter().map(|r| r[i]).collect()) })
        .collect();
    table::print(&rows, rounds);
}

/// An FMU to be timed: a Real that is set and one that is read.
struct Timed {
    name: String,
    library: PathBuf,
    guid: String,
    uri: String,
    input: u32,
    /// First and last value of the input.
    range: [f64; 2],
    output: u32,
    /// Inputs before the start, see [`Subject`].
    start: String,
}

impl Timed {
    fn subject(&self, kind: &'static str, count: u32) -> Subject {
        Subject {
            kind,
            library: self.library.clone(),
            guid: self.guid.clone(),
            uri: self.uri.clone(),
            count,
            reference: if kind == "get" { self.output } else { self.input },
            range: self.range,
            start: self.start.clone(),
        }
    }
}

/// The packed FMUs, each with every example there is of it.
fn archives() -> Vec<(String, Archive)> {
    let mut archives = Vec::new();
    for fmu in steerwright_packaging::Fmu::ALL {
        let binaries: Vec<Binary<'_>> = steerwright_binaries::libraries_of(fmu.name())
            .map(|library| Binary { platform: library.platform, bytes: library.bytes })
            .collect();
        for (what, document) in examples::timed_documents(fmu) {
            let packed =
                steerwright_packaging::package(&document, fmu.resource(), &binaries, None, None)
                    .unwrap();
            let archive = Archive::from_bytes(&packed.bytes, fmu.name()).unwrap();
            archives.push((format!("{}{what}", fmu.name()), archive));
        }
    }
    archives
}

fn own(archives: &[(String, Archive)]) -> Vec<Timed> {
    let timed = |(name, archive): &(String, Archive)| {
        let variable_of = |name: &str, causality: Causality| {
            archive.model().variable(name).filter(|variable| variable.causality == causality)
        };
        // The named ones, or the first that there is.
        let reference = |causality: Causality, names: &[&str]| {
            let named = names.iter().find_map(|name| variable_of(name, causality));
            let mut variables = archive.model().description().variables.iter();
            named
                .or_else(|| variables.find(|v| v.causality == causality && v.kind == Kind::Real))
                .expect("a variable")
                .reference
        };
        // A vehicle in a curve and a controller with an error: nothing is zero by chance.
        let start = [("steering_angle", 0.3), ("yaw_reference", 0.05), ("yaw", 0.01), ("x", 5.0)];
        let start: Vec<String> = start
            .iter()
            .filter_map(|(name, value)| {
                let input = variable_of(name, Causality::Input)?;
                Some(format!("{}={value}", input.reference))
            })
            .collect();
        let is_pedal = variable_of("accelerator", Causality::Input).is_some();
        let has_speed = variable_of("speed", Causality::Input).is_some();
        Timed {
            name: name.clone(),
            library: archive.binary().unwrap(),
            guid: archive.model().description().guid.clone(),
            uri: format!("file://{}", archive.folder().join("resources").display()),
            input: reference(Causality::Input, &["accelerator", "speed", "yaw"]),
            range: match (is_pedal, has_speed) {
                (true, _) => [0.1, 0.3],
                (false, true) => [14.0, 16.0],
                (false, false) => [0.0, 0.02],
            },
            start: start.join(","),
            output: reference(
                Causality::Output,
                &["yaw_rate", "steering_angle", "yaw_reference", "distance"],
            ),
        }
    };
    archives.iter().map(timed).collect()
}

fn of_the_benchmark(folder: &Path) -> Vec<Timed> {
    let timed = |name: &str, file: &str, guid: String| Timed {
        name: name.into(),
        library: folder.join(libloading::library_filename(file)),
        guid,
        uri: "file:///nothing".into(),
        input: 0,
        range: [0.5, 1.5],
        output: 1,
        start: "0=1".into(),
    };
    fn guid<S: CoSimulationUnit>() -> String {
        fmi2_export::guid::<S>(&Resources::default())
    }
    vec![
        timed("Empty", "empty", guid::<steerwright_bench_fmus::Empty>()),
        timed("Linear", "linear", guid::<steerwright_bench_fmus::Linear>()),
    ]
}

fn pythonfmu(unpacked: &Path) -> Timed {
    let xml = std::fs::read_to_string(unpacked.join("modelDescription.xml")).unwrap();
    let description = model_description::ModelDescription::from_xml(&xml).unwrap();
    let reference = |name| description.variable(name).unwrap().reference;
    Timed {
        name: "pythonfmu".into(),
        library: unpacked.join("binaries/linux64/Linear.so"),
        guid: description.guid.clone(),
        uri: format!("file://{}", unpacked.join("resources").display()),
        input: reference("u"),
        range: [0.5, 1.5],
        start: String::new(),
        output: reference("y"),
    }
}
