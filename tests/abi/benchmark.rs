//! The timer of `cargo xtask bench fmu` runs every FMU, with and without values to start from.

#[path = "bench/timing.rs"]
mod timing;

use crate::samples::{Sample, samples};
use model_description::{Causality, Kind};
use timing::Subject;

/// A timed function; `get` reads an output, the others set an input.
const KINDS: [&str; 5] = ["empty", "get", "set", "step", "setstep"];

fn subject(sample: &Sample, kind: &'static str, start: &str) -> Subject {
    let causality = if kind == "get" { Causality::Output } else { Causality::Input };
    Subject {
        kind,
        library: sample.library.clone(),
        guid: sample.description.guid.clone(),
        uri: sample.uri(),
        count: 3,
        reference: sample.of(Kind::Real, causality).next().unwrap().reference,
        range: [0.0, 0.01],
        start: start.to_owned(),
    }
}

#[test]
fn the_timer_runs_every_fmu() {
    let folder = tempfile::tempdir().unwrap();
    let Ok(timer) = timing::compile_timer(folder.path()) else {
        println!("left out: the timer of the benchmark, for there is no cc");
        return;
    };
    for sample in samples() {
        let input = sample.of(Kind::Real, Causality::Input).next().unwrap().reference;
        // The pose estimator has none of the inputs that the benchmark starts from.
        for start in [String::new(), format!("{input}=0.001")] {
            let subjects: Vec<Subject> =
                KINDS.iter().map(|kind| subject(sample, kind, &start)).collect();
            let rounds = timing::time(&timer, 2, &subjects);
            let is_whole = |round: &Vec<f64>| {
                round.len() == subjects.len() && round.iter().all(|ns| ns.is_finite())
            };
            assert!(rounds.len() == 2 && rounds.iter().all(is_whole), "{}", sample.name());
        }
    }
}
