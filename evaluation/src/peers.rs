//! Other people's identification, run in a Python process on the same data.

use faer::Mat;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use steerwright_sysid::{Innovation, StateSpace};

/// A Python process that holds one set of data.
#[derive(Debug)]
pub struct Peers {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

/// What a peer made of the data.
#[derive(Debug, Clone)]
pub struct PeerModel {
    /// Processor seconds of one run.
    pub seconds: f64,
    /// Its model; the gain is zero where it has none.
    pub model: Innovation,
}

impl Peers {
    /// Starts the process, with one thread for its linear algebra.
    ///
    /// # Errors
    /// Where no interpreter is named or it does not start.
    pub fn start() -> Result<Self, String> {
        let mut child = crate::python()?
            .arg("-c")
            .arg(include_str!("../python/peers.py"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| format!("the interpreter: {e}"))?;
        let (Some(requests), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipes to the interpreter".into());
        };
        Ok(Self { child, requests, answers: BufReader::new(answers) })
    }

    /// Loads `count` samples of one input and one output, as [`write_signals`] wrote them.
    ///
    /// # Errors
    /// Where the process fails.
    pub fn load(&mut self, path: &Path, count: usize) -> Result<(), String> {
        self.request(&json!({ "do": "load", "path": path, "count": count })).map(drop)
    }

    /// SLICOT's combined method with the algorithm `C` (Cholesky) or `Q` (QR) for the factor.
    ///
    /// # Errors
    /// Where it returns no model.
    pub fn slicot(
        &mut self,
        s: usize,
        order: usize,
        algorithm: char,
        repeat: usize,
    ) -> Result<PeerModel, String> {
        let request =
            json!({ "do": "slicot", "s": s, "n": order, "alg": algorithm, "repeat": repeat });
        self.request(&request).and_then(|v| model(&v))
    }

    /// `sippy` or `nfoursid`.
    ///
    /// # Errors
    /// Where it returns no model.
    pub fn other(&mut self, name: &str, s: usize, order: usize) -> Result<PeerModel, String> {
        self.request(&json!({ "do": name, "s": s, "n": order })).and_then(|v| model(&v))
    }

    fn request(&mut self, request: &Value) -> Result<Value, String> {
        writeln!(self.requests, "{request}").map_err(|e| format!("the interpreter: {e}"))?;
        let mut line = String::new();
        self.answers.read_line(&mut line).map_err(|e| format!("the interpreter: {e}"))?;
        if line.is_empty() {
            return Err("the process ended".into());
        }
        let answer: Value = serde_json::from_str(&line).map_err(|e| format!("{line}: {e}"))?;
        match answer.get("error") {
            Some(problem) => Err(problem.as_str().unwrap_or("?").into()),
            None => Ok(answer),
        }
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // A process that has ended already is what is wanted.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn model(answer: &Value) -> Result<PeerModel, String> {
    let matrix = |name: &str| -> Result<Mat<f64>, String> {
        let rows: Vec<Vec<f64>> = serde_json::from_value(answer[name].clone())
            .map_err(|e| format!("matrix {name}: {e}"))?;
        let columns = rows.first().map_or(0, Vec::len);
        if rows.iter().any(|r| r.len() != columns) {
            return Err(format!("matrix {name} is ragged"));
        }
        Ok(Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]))
    };
    let model = StateSpace { a: matrix("a")?, b: matrix("b")?, c: matrix("c")?, d: matrix("d")? };
    let gain = matrix("k").unwrap_or_else(|_| Mat::zeros(model.order(), model.outputs()));
    let seconds = answer["seconds"].as_f64().ok_or("no time")?;
    Ok(PeerModel { seconds, model: Innovation { model, gain } })
}

/// Writes the input, then the output, as little-endian doubles.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_signals(path: &Path, u: &[f64], y: &[f64]) -> std::io::Result<()> {
    let bytes: Vec<u8> = u.iter().chain(y).flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(path, bytes)
}

/// Reads what [`write_signals`] wrote, without more memory than the signals'.
///
/// # Errors
/// Where the file cannot be read.
pub fn read_signals(path: &Path, count: usize) -> std::io::Result<(Vec<f64>, Vec<f64>)> {
    use std::io::Read;
    let mut file = BufReader::new(std::fs::File::open(path)?);
    let mut read = || -> std::io::Result<Vec<f64>> {
        let mut bytes = [0; 8];
        (0..count)
            .map(|_| file.read_exact(&mut bytes).map(|()| f64::from_le_bytes(bytes)))
            .collect()
    };
    Ok((read()?, read()?))
}
