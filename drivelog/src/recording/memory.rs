//! Channels that are in memory already, such as the columns of a data frame.

use super::{Channel, Columns, Group, Pieces, Recording, Request, Rows};
use crate::Error;
use std::rc::Rc;

struct Memory {
    groups: [Group; 1],
    values: Vec<Vec<f64>>,
}

/// A table of named columns of equal length; a missing value is NaN. Of a table within a file the name is `FILE: TABLE`.
///
/// # Errors
/// [`Error::Columns`] where the lengths differ or a name is repeated.
pub fn in_memory(
    name: &str,
    columns: Vec<(String, Vec<f64>)>,
) -> Result<Box<dyn Recording>, Error> {
    let refused = |problem: String| Error::Columns { file: name.into(), problem };
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    for (i, (column, values)) in columns.iter().enumerate() {
        if values.len() != rows {
            let problem = format!("`{column}` has {} values, the first has {rows}", values.len());
            return Err(refused(problem));
        }
        if columns[..i].iter().any(|(other, _)| other == column) {
            return Err(refused(format!("`{column}` is there twice")));
        }
    }
    let channels = columns.iter().map(|(column, _)| Channel::new(column, None)).collect();
    let (file, table) = name.split_once(": ").unwrap_or((name, ""));
    let mut group = Group::new(file, table, channels);
    group.rows = Some(rows as u64);
    let values = columns.into_iter().map(|(_, values)| values).collect();
    Ok(Box::new(Memory { groups: [group], values }))
}

impl Recording for Memory {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let rows = self.values.first().map_or(0, Vec::len);
        let values = &self.values;
        let pieces = request.wanted.iter().enumerate().flat_map(move |(index, wanted)| {
            (0..rows).step_by(request.most).map(move |from| {
                let part = from..from.saturating_add(request.most).min(rows);
                let lines = (from as u64 + 1..=part.end as u64).collect();
                let values = wanted.channels.iter().map(|&c| values[c][part.clone()].to_vec());
                let columns = Columns { values: values.collect(), lines: Rc::new(lines) };
                Ok(Rows { wanted: index, columns })
            })
        });
        Ok(Box::new(pieces))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_within_a_file_is_a_group_of_that_name() {
        let columns = || vec![("time_s".into(), vec![0.0]), ("GyrZ [rad/s]".into(), vec![0.1])];
        let tables = in_memory("drive.bin: IMU[0]", columns()).unwrap();
        let group = &tables.groups()[0];
        assert_eq!((group.file.as_str(), group.name.as_str()), ("drive.bin", "IMU[0]"));
        for name in ["IMU[0].GyrZ", "IMU[0].GyrZ [rad/s]", "GyrZ"] {
            assert_eq!(group.find(name), Some(1), "{name}");
        }
        assert_eq!(group.find("IMU[1].GyrZ"), None);
        assert_eq!(in_memory("drive.csv", columns()).unwrap().groups()[0].name, "");
    }
}
