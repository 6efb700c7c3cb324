//! `cargo xtask bench sweep`: makes the FMUs, and runs the benchmark of `sweep` and the same loop in
//! fmpy.

use crate::run::{cargo, root, run, target};
use crate::{every_fmu, python};

/// Loops that fmpy is given: it takes many times as long for each.
const FMPY_LOOPS: &str = "10";
/// Loops of the short form.
const SHORT_LOOPS: &str = "40";

/// 10,000 closed loops on a thread and on two, with each plant, compared with fmpy.
pub(crate) fn sweep(short: bool) -> Result<(), String> {
    let folder = target().join("bench-sweep");
    let fmus = folder.join("multibody/fmu");
    every_fmu::pack(&folder, None)?;
    let mut bench = cargo(&["bench", "--bench", "loops"]);
    if short {
        bench.env("STEERWRIGHT_BENCH_LOOPS", SHORT_LOOPS);
    }
    run(bench.env("STEERWRIGHT_BENCH_FMUS", &fmus))?;
    match python::environment() {
        Ok(python) => {
            let script = root().join("evaluation/sweep/fmpy_loop.py");
            let loops = if short { "1" } else { FMPY_LOOPS };
            run(python::command(&python).arg(script).arg(&fmus).arg(loops))
        }
        Err(problem) => {
            eprintln!("left out: fmpy: {problem}");
            Ok(())
        }
    }
}
