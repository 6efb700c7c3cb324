//! Recorded points from comma-separated tables, GPX and NMEA.

pub(crate) mod fixes;
mod geodesy;
mod gpx;
mod nmea;

use crate::Error;
use crate::error::point_fault;
use fixes::{FixOptions, RecordedPoints};
use geodesy::wgs84_to_local;

/// Reads recorded points: GPX where the text begins with `<`, NMEA where it begins with `$`, a table
/// otherwise. `file` is named in errors.
///
/// A table has the columns `x_m` and `y_m`, or `latitude_deg` and `longitude_deg` (with `altitude_m`
/// where there is one); other columns are ignored.
///
/// # Errors
/// [`Error::PointFile`] with the place of the first fault, [`Error::PoorFixes`] where no fix is good
/// enough.
pub fn read_points(text: &str, file: &str, options: &FixOptions) -> Result<RecordedPoints, Error> {
    let text = text.trim_start_matches('\u{feff}');
    let first = text.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with('#'));
    match first.and_then(|line| line.chars().next()) {
        Some('<') => {
            let (found, warnings) = gpx::fixes(text, file)?;
            let mut points = fixes::choose(&found, file, options)?;
            points.warnings.splice(0..0, warnings);
            Ok(points)
        }
        Some('$' | '!') => fixes::choose(&nmea::fixes(text, file)?, file, options),
        _ => read_table(text, file),
    }
}

fn read_table(text: &str, file: &str) -> Result<RecordedPoints, Error> {
    let fault = point_fault(file);
    let first = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#'));
    let has = |d: &u8| first.is_some_and(|l| l.as_bytes().contains(d));
    let delimiter = [b',', b';', b'\t'].into_iter().find(has).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .delimiter(delimiter)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| fault(1, 1, e.to_string()))?.clone();
    let place = |name: &str| header.iter().position(|h| h == name);
    let (columns, geodetic) = match (
        (place("x_m"), place("y_m")),
        (place("latitude_deg"), place("longitude_deg")),
    ) {
        ((Some(x), Some(y)), _) => (vec![("x_m", x), ("y_m", y)], false),
        (_, (Some(lat), Some(lon))) => {
            let mut columns = vec![("latitude_deg", lat), ("longitude_deg", lon)];
            columns.extend(place("altitude_m").map(|h| ("altitude_m", h)));
            (columns, true)
        }
        _ => {
            let line = header.position().map_or(1, csv::Position::line);
            let have = header.iter().collect::<Vec<_>>().join(", ");
            return Err(fault(
                line,
                1,
                format!(
                    "no columns x_m and y_m, nor latitude_deg and longitude_deg (there are: {have})"
                ),
            ));
        }
    };
    let mut values = vec![Vec::new(); columns.len()];
    for record in reader.records() {
        let record = record
            .map_err(|e| fault(e.position().map_or(1, csv::Position::line), 1, e.to_string()))?;
        let line = record.position().map_or(1, |p| line_of_record(text, p));
        for ((name, field), values) in columns.iter().zip(&mut values) {
            let column = 1 + record.iter().take(*field).map(|f| f.len() + 1).sum::<usize>();
            let text = record.get(*field).ok_or_else(|| {
                fault(
                    line,
                    column,
                    format!("the row has no {name}: it has {} fields", record.len()),
                )
            })?;
            let value = text.parse::<f64>().ok().filter(|x| !x.is_nan());
            let value = value
                .ok_or_else(|| fault(line, column, format!("{name} is `{text}`, not a number")))?;
            let limit = match *name {
                "latitude_deg" => 90.0,
                "longitude_deg" => 360.0,
                _ => 1e8,
            };
            if !(value.is_finite() && value.abs() <= limit) {
                return Err(fault(line, column, format!("{name} is {text}, beyond ±{limit}")));
            }
            values.push(value);
        }
    }
    let mut values = values.into_iter();
    let (first, second, third) =
        (values.next().unwrap_or_default(), values.next().unwrap_or_default(), values.next());
    let (x_m, y_m) =
        if geodetic { wgs84_to_local(&first, &second, third.as_deref()) } else { (first, second) };
    Ok(RecordedPoints { x_m, y_m, warnings: Vec::new() })
}

/// The reader counts blank lines and comments before a record as the record's own.
fn line_of_record(text: &str, position: &csv::Position) -> u64 {
    let start = usize::try_from(position.byte()).unwrap_or(usize::MAX);
    let rest = text.get(start..).unwrap_or_default();
    let skipped =
        rest.lines().take_while(|l| l.trim().is_empty() || l.trim_start().starts_with('#')).count();
    position.line() + skipped as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_points(text: &str, file: &str) -> Result<RecordedPoints, Error> {
        super::read_points(text, file, &FixOptions::default())
    }

    #[test]
    fn faults_name_file_line_and_column() {
        let error = read_points("time_s,x_m,y_m\n0,1,2\n0.1,3,oops\n", "track.csv").unwrap_err();
        assert_eq!(error.to_string(), "track.csv:3:7: y_m is `oops`, not a number");
        let error = read_points("x_m,y_m\n0,1\n\n2\n", "track.csv").unwrap_err();
        assert!(error.to_string().starts_with("track.csv:4:3: the row has no y_m"), "{error}");
        let error = read_points("a,b\n0,1\n", "track.csv").unwrap_err();
        assert!(error.to_string().contains("there are: a, b"), "{error}");
        assert!(error.hint().contains("latitude_deg"));
        let error = read_points("latitude_deg,longitude_deg\n91,1\n", "track.csv").unwrap_err();
        assert!(error.to_string().contains("beyond ±90"), "{error}");
        let error = read_points("x_m,y_m\nNaN,1\n", "track.csv").unwrap_err();
        assert!(error.to_string().contains("x_m is `NaN`, not a number"), "{error}");
        assert!(read_points("", "empty.csv").is_err());
    }

    #[test]
    fn metres_are_unchanged() {
        let points = read_points("\u{feff}x_m, y_m\n1.5, -2\n", "t.csv").unwrap();
        assert_eq!((points.x_m, points.y_m), (vec![1.5], vec![-2.0]));
    }
}
