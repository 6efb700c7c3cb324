//! The recording of a run.

use std::fmt::Write;

/// Variables at each communication point, the first included. Booleans are 1 and 0.
///
/// An input's value is that of its source at the time, held by the input from there on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// The variables, `instance.variable`.
    pub names: Vec<String>,
    /// Their units, where modelDescription.xml states any.
    pub units: Vec<Option<String>>,
    /// The communication points, s.
    pub times: Vec<f64>,
    /// For each communication point the values, in the order of the names.
    pub rows: Vec<Vec<f64>>,
    /// Passes over the system that initialization took.
    pub initial_passes: usize,
    /// Whether the last of them changed nothing. If it did, an algebraic loop did not settle.
    pub initially_settled: bool,
}

impl Recording {
    /// A variable over time.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.names.iter().position(|n| n == name)?;
        Some(self.rows.iter().map(|row| row[index]).collect())
    }

    /// As CSV: `time` first, then the names, numbers in the shortest form that reads back exactly.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = self.csv_header();
        for (time, row) in self.times.iter().zip(&self.rows) {
            write_row(&mut text, *time, row);
        }
        text
    }

    /// The first line of [`Recording::to_csv`].
    #[must_use]
    pub fn csv_header(&self) -> String {
        let mut text = String::from("time");
        for name in &self.names {
            text.push(',');
            // Names of arrays may contain commas: x[1,2].
            if name.contains([',', '"', '\n']) {
                let _ = write!(text, "\"{}\"", name.replace('"', "\"\""));
            } else {
                text.push_str(name);
            }
        }
        text.push('\n');
        text
    }

    /// The line of [`Recording::to_csv`] with the last row; empty without rows.
    #[must_use]
    pub fn csv_last_row(&self) -> String {
        let mut text = String::new();
        if let (Some(time), Some(row)) = (self.times.last(), self.rows.last()) {
            write_row(&mut text, *time, row);
        }
        text
    }
}

fn write_row(text: &mut String, time: f64, row: &[f64]) {
    // Writing to a String cannot fail.
    let _ = write!(text, "{}", Shortest(time));
    for value in row {
        let _ = write!(text, ",{}", Shortest(*value));
    }
    text.push('\n');
}

/// A float in the shortest decimal that reads back as the same float, with an exponent where
/// positional notation would be long.
struct Shortest(f64);

impl std::fmt::Display for Shortest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let magnitude = self.0.abs();
        if magnitude != 0.0 && !(1e-5..1e16).contains(&magnitude) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_reads_back_bit_for_bit() {
        let values = vec![0.1 + 0.2, -1.5e-300, f64::MAX, 0.0, -0.0, 1.0, 1e16, 1.0 / 3.0, 5e-324];
        let recording = Recording {
            names: (0..values.len()).map(|i| format!("a.v[{i},0]")).collect(),
            units: vec![None; values.len()],
            times: vec![3.0 * 0.1],
            rows: vec![values.clone()],
            initial_passes: 1,
            initially_settled: true,
        };
        let text = recording.to_csv();
        assert_eq!(text, recording.csv_header() + &recording.csv_last_row());
        let mut csv = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(&csv.headers().unwrap()[1], "a.v[0,0]");
        let row = csv.records().next().unwrap().unwrap();
        let read: Vec<u64> = row.iter().map(|t| t.parse::<f64>().unwrap().to_bits()).collect();
        assert_eq!(read[0], (3.0f64 * 0.1).to_bits());
        assert_eq!(read[1..], values.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
        assert!(text.contains(",1,") && text.contains("0.30000000000000004"));
    }
}
