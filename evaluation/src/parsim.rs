//! PARSIM-K of the Python package SIPPY: a closed-loop subspace method by other people.

use std::io::Write;
use std::process::Stdio;
use steerwright_sysid::DataSet;

const SCRIPT: &str = "
import sys, warnings
import numpy as np
warnings.filterwarnings('ignore')
from sippy_unipi.Parsim_methods import PARSIM_K
horizon, order = int(sys.argv[1]), int(sys.argv[2])
u, y = np.loadtxt(sys.stdin).T
A = PARSIM_K(y.copy(), u.copy(), f=horizon, p=horizon, fixed_order=order)[5]
for z in np.linalg.eigvals(A):
    print(repr(float(z.real)), repr(float(z.imag)))
";

/// The poles that PARSIM-K finds in the first segment (one input, one output), with the Python
/// interpreter of the variable `STEERWRIGHT_PEERS_PYTHON`.
///
/// # Errors
/// What went wrong in a sentence.
pub fn poles(data: &DataSet, horizon: usize, order: usize) -> Result<Vec<(f64, f64)>, String> {
    let mut child = crate::python()?
        .args(["-c", SCRIPT, &horizon.to_string(), &order.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| format!("Python does not start: {e}"))?;
    let first = &data.segments()[0];
    let mut text = String::new();
    for t in 0..first.len() {
        text += &format!("{:e} {:e}\n", first.u[(0, t)], first.y[(0, t)]);
    }
    let mut input = child.stdin.take().ok_or("Python takes no input")?;
    input.write_all(text.as_bytes()).map_err(|e| format!("Python ended early: {e}"))?;
    drop(input);
    let output = child.wait_with_output().map_err(|e| format!("Python was lost: {e}"))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(message.lines().last().unwrap_or("Python failed").to_string());
    }
    let number = |x: Option<&str>| x.and_then(|x| x.parse::<f64>().ok());
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .map(|line| {
            let mut words = line.split_whitespace();
            number(words.next()).zip(number(words.next())).ok_or(format!("no pole: {line}"))
        })
        .collect()
}
