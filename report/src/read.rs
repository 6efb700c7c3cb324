//! The tables of the other stages, by meaning: [`Traces`], [`StepResponse`], [`Track`].

use crate::Error;

/// `traces.csv`: the drive and its simulation by the model. All of equal length; NaN is a gap.
/// Steering is in the log's coordinates, yaw the integral of the yaw rate.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)]
pub struct Traces {
    pub time_s: Vec<f64>,
    pub steering_rad: Vec<f64>,
    pub yaw_rate_radps: Vec<f64>,
    pub simulated_yaw_rate_radps: Vec<f64>,
    pub is_validation: Vec<bool>,
    pub yaw_rad: Vec<f64>,
    pub simulated_yaw_rad: Vec<f64>,
    /// Yaw rate of the bicycle model, rad/s (column `bicycle_yaw_rate_radps`), where it is there.
    pub bicycle_yaw_rate_radps: Option<Vec<f64>>,
}

/// `step_*.csv`: a yaw step from 0 at time 0, in steering coordinates.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)]
pub struct StepResponse {
    pub time_s: Vec<f64>,
    pub yaw_rad: Vec<f64>,
    pub steering_rad: Vec<f64>,
}

/// One run along the reference path, from a co-simulation result. Distance and steering are empty where
/// the result does not have them.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)]
pub struct Track {
    pub time_s: Vec<f64>,
    pub distance_m: Vec<f64>,
    pub x_m: Vec<f64>,
    pub y_m: Vec<f64>,
    /// Positive to the left of the path.
    pub cross_track_error_m: Vec<f64>,
    pub heading_error_rad: Vec<f64>,
    pub steering_rad: Vec<f64>,
}

/// Root mean square and largest magnitude of the errors of a [`Track`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct TrackErrors {
    pub cross_track_rms_m: f64,
    pub cross_track_max_m: f64,
    pub heading_rms_rad: f64,
    pub heading_max_rad: f64,
}

impl Traces {
    /// Reads `traces.csv`; `file` is named in errors.
    ///
    /// # Errors
    /// [`Error::Csv`], [`Error::Number`], [`Error::NoRows`] and [`Error::MissingColumn`].
    pub fn from_csv(text: &[u8], file: &str) -> Result<Self, Error> {
        let t = Columns::from_csv(text, file)?;
        let column = |name| t.column(name).map(<[f64]>::to_vec);
        Ok(Self {
            time_s: column("time_s")?,
            steering_rad: column("steering_rad")?,
            yaw_rate_radps: column("yaw_rate_radps")?,
            simulated_yaw_rate_radps: column("simulated_yaw_rate_radps")?,
            is_validation: t.column("held_out")?.iter().map(|h| *h > 0.5).collect(),
            yaw_rad: column("yaw_rad")?,
            simulated_yaw_rad: column("simulated_yaw_rad")?,
            bicycle_yaw_rate_radps: t.get("bicycle_yaw_rate_radps").map(<[f64]>::to_vec),
        })
    }

    /// The times on an axis, s: each drive counts from its own first sample, so a later drive is shifted to the
    /// end of the one before.
    #[must_use]
    pub fn axis_time_s(&self) -> Vec<f64> {
        let (mut shift, mut end) = (0.0, f64::NEG_INFINITY);
        let shifted = |t: &f64| {
            if t + shift < end {
                shift = end - t;
            }
            end = t + shift;
            end
        };
        self.time_s.iter().map(shifted).collect()
    }

    /// The label of that axis.
    #[must_use]
    pub fn axis_label(&self) -> &'static str {
        let starts_again = self.time_s.windows(2).any(|t| t[1] < t[0]);
        if starts_again { "Time (s), one drive after the other" } else { "Time (s)" }
    }

    /// The ranges of the validation data on the axis of [`Traces::axis_time_s`].
    #[must_use]
    pub fn validation_ranges(&self) -> Vec<(f64, f64)> {
        let mut out: Vec<(f64, f64)> = Vec::new();
        let mut before = false;
        for (t, held) in self.axis_time_s().into_iter().zip(&self.is_validation) {
            match (held, before, out.last_mut()) {
                (true, true, Some(range)) => range.1 = t,
                (true, ..) => out.push((t, t)),
                _ => {}
            }
            before = *held;
        }
        out
    }
}

impl Track {
    /// Reads a co-simulation result with columns `time,<instance>.<variable>…`: variables `x`, `y`,
    /// `cross_track_error`, `heading_error` and, where they are there, `distance`,
    /// `steering_angle` and `finished`. Rows from the first finished one on are left out, but for
    /// that one: the vehicle runs on beyond the path's end.
    ///
    /// # Errors
    /// [`Error::Csv`], [`Error::Number`], [`Error::NoRows`] and [`Error::MissingColumn`].
    pub fn from_csv(text: &[u8], file: &str) -> Result<Self, Error> {
        let t = Columns::from_csv(text, file)?;
        let rows = t.column("time")?.len();
        let end = t
            .variable("finished")
            .and_then(|f| f.iter().position(|v| *v > 0.5))
            .map_or(rows, |first| (first + 1).min(rows));
        let optional = |name: &str| t.variable(name).map(|c| c[..end].to_vec()).unwrap_or_default();
        let needed =
            |name: &str| t.variable(name).map(|c| c[..end].to_vec()).ok_or_else(|| t.missing(name));
        Ok(Self {
            time_s: t.column("time")?[..end].to_vec(),
            distance_m: optional("distance"),
            x_m: needed("x")?,
            y_m: needed("y")?,
            cross_track_error_m: needed("cross_track_error")?,
            heading_error_rad: needed("heading_error")?,
            steering_rad: optional("steering_angle"),
        })
    }

    /// The errors in numbers, over the samples that have them; NaN where none has.
    #[must_use]
    pub fn errors(&self) -> TrackErrors {
        let (cross_track_rms_m, cross_track_max_m) = rms_and_max(&self.cross_track_error_m);
        let (heading_rms_rad, heading_max_rad) = rms_and_max(&self.heading_error_rad);
        TrackErrors { cross_track_rms_m, cross_track_max_m, heading_rms_rad, heading_max_rad }
    }
}

fn rms_and_max(values: &[f64]) -> (f64, f64) {
    let finite = || values.iter().filter(|v| v.is_finite());
    let count = finite().count();
    if count == 0 {
        return (f64::NAN, f64::NAN);
    }
    let square: f64 = finite().map(|v| v * v).sum();
    ((square / count as f64).sqrt(), finite().fold(0.0, |m, v| v.abs().max(m)))
}

/// Named columns of equal length, of a CSV file: a row of names, then rows of numbers. An empty cell is
/// a gap (NaN); `true` and `false` are 1 and 0.
#[derive(Debug, Clone, PartialEq, Default)]
struct Columns {
    file: String,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
}

impl Columns {
    /// Reads a table; `file` is named in errors.
    ///
    /// # Errors
    /// [`Error::Csv`], [`Error::Number`] with line and column, or [`Error::NoRows`].
    fn from_csv(text: &[u8], file: &str) -> Result<Self, Error> {
        // A byte-order mark would become part of the first name.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let refused = |e: csv::Error| Error::Csv {
            file: file.into(),
            line: e.position().map_or(0, csv::Position::line),
            problem: problem(&e),
        };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
        let names: Vec<String> =
            reader.headers().map_err(refused)?.iter().map(str::to_owned).collect();
        let mut values = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record.map_err(refused)?;
            for ((cell, column), name) in record.iter().zip(&mut values).zip(&names) {
                column.push(number(cell).ok_or_else(|| Error::Number {
                    file: file.into(),
                    line: record.position().map_or(0, csv::Position::line),
                    column: name.clone(),
                    text: cell.chars().take(40).collect(),
                })?);
            }
        }
        if values.first().is_none_or(Vec::is_empty) {
            return Err(Error::NoRows { file: file.into() });
        }
        Ok(Self { file: file.into(), names, values })
    }

    /// The column of that name, if there is one.
    fn get(&self, name: &str) -> Option<&[f64]> {
        let at = self.names.iter().position(|n| n == name)?;
        self.values.get(at).map(Vec::as_slice)
    }

    /// The column of that name.
    ///
    /// # Errors
    /// [`Error::MissingColumn`] naming those there are.
    fn column(&self, name: &str) -> Result<&[f64], Error> {
        self.get(name).ok_or_else(|| self.missing(name))
    }

    /// The first column `<instance>.<variable>` of a co-simulation result, whatever the instance.
    fn variable(&self, variable: &str) -> Option<&[f64]> {
        let named = |n: &String| n.rsplit_once('.').is_some_and(|(_, v)| v == variable);
        self.values.get(self.names.iter().position(named)?).map(Vec::as_slice)
    }

    fn missing(&self, name: &str) -> Error {
        let shown: Vec<_> = self.names.iter().take(20).map(|n| format!("`{n}`")).collect();
        Error::MissingColumn {
            file: self.file.clone(),
            column: name.into(),
            found: if shown.is_empty() { "none".into() } else { shown.join(", ") },
        }
    }
}

fn number(cell: &str) -> Option<f64> {
    match cell {
        "" => Some(f64::NAN),
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => cell.parse().ok(),
    }
}

fn problem(e: &csv::Error) -> String {
    match e.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} cells, expected {expected_len} as in the first row")
        }
        csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        _ => e.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_ends_where_the_path_does_and_has_its_rms() {
        let csv = "time,Plant.x,Plant.y,Path.cross_track_error,Path.heading_error,Path.finished\n\
                   0,0,0,3,0.1,false\n1,1,0,-4,-0.1,false\n2,2,0,0,,true\n3,3,0,99,9,true\n";
        let track = Track::from_csv(csv.as_bytes(), "r.csv").unwrap();
        let e = track.errors();
        assert_eq!(track.time_s, [0.0, 1.0, 2.0]);
        assert!((e.cross_track_rms_m - (25.0f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(e.cross_track_max_m, 4.0);
        assert!((e.heading_rms_rad - 0.1).abs() < 1e-15);
        assert!(track.distance_m.is_empty());
    }

    #[test]
    fn errors_name_file_line_and_column() {
        let text = |r: Result<Columns, Error>| r.unwrap_err().to_string();
        assert_eq!(
            text(Columns::from_csv(b"a,b\n1,2\n3,x\n", "f.csv")),
            "f.csv:3: column `b`: `x` is not a number"
        );
        assert_eq!(
            text(Columns::from_csv(b"a,b\n1\n", "f.csv")),
            "f.csv:2: 1 cells, expected 2 as in the first row"
        );
        assert_eq!(text(Columns::from_csv(b"a,b\n", "f.csv")), "f.csv: the table has no rows");
        assert_eq!(text(Columns::from_csv(b"", "f.csv")), "f.csv: the table has no rows");
        assert_eq!(
            Traces::from_csv(b"time_s,yaw\n0,1\n", "s.csv").unwrap_err().to_string(),
            "s.csv: no column `steering_rad`; there are `time_s`, `yaw`"
        );
    }

    #[test]
    fn validation_data_are_ranges() {
        let traces = Traces {
            time_s: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
            is_validation: vec![true, false, false, true, true, true],
            ..Traces::default()
        };
        assert_eq!(traces.validation_ranges(), [(0.0, 0.0), (3.0, 5.0)]);
        assert_eq!(traces.axis_time_s(), traces.time_s);
        assert_eq!(traces.axis_label(), "Time (s)");
    }

    #[test]
    fn drives_are_drawn_one_after_the_other() {
        let traces = Traces {
            time_s: vec![7.0, 8.0, 9.0, 2.0, 3.0],
            is_validation: vec![false, false, true, true, true],
            ..Traces::default()
        };
        assert_eq!(traces.axis_time_s(), [7.0, 8.0, 9.0, 9.0, 10.0]);
        assert_eq!(traces.validation_ranges(), [(9.0, 10.0)]);
        assert_eq!(traces.axis_label(), "Time (s), one drive after the other");
    }
}
