//! Recorded data from CSV files, and their halves.

use std::path::Path;
use steerwright_sysid::{DataSet, Error, Segment, Signals};

/// The first and the second half of each segment.
///
/// # Errors
/// [`Error::Data`] where a segment has one sample only.
pub fn halves(data: &DataSet) -> Result<[DataSet; 2], Error> {
    let of = |second: bool| {
        let cut = data.segments().iter().map(|s| {
            let half = s.len() / 2;
            let range = if second { half..s.len() } else { 0..half };
            Segment::new(s.u.columns(range.clone()), s.y.columns(range))
        });
        DataSet::new(data.sample_time_s(), cut.collect())
    };
    Ok([of(false)?, of(true)?])
}

/// The named columns of a CSV file as inputs and outputs.
///
/// # Errors
/// In words, where the file is not as expected.
pub fn recording(
    file: &Path,
    inputs: &[&str],
    outputs: &[&str],
    sample_time_s: f64,
) -> Result<DataSet, String> {
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let rows = lines
        .map(|l| l.split(',').map(|x| x.trim().parse::<f64>().map_err(|e| e.to_string())).collect())
        .collect::<Result<Vec<Vec<f64>>, String>>()?;
    let signals = |names: &[&str]| -> Result<Signals, String> {
        let columns = names
            .iter()
            .map(|n| header.iter().position(|h| h == n).ok_or(format!("no column {n}")))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Signals::from_fn(names.len(), rows.len(), |i, t| {
            rows[t].get(columns[i]).map_or(f64::NAN, |x| *x)
        }))
    };
    DataSet::single(sample_time_s, signals(inputs)?, signals(outputs)?).map_err(|e| e.to_string())
}
