//! The last column of the table of programs in evaluation/README.md.

use super::programs::Program;
use crate::files::read;
use crate::run::root;
use std::fs;

/// Writes the recorded line of a program's output into its row.
pub(super) fn record(program: &Program, arguments: &[String], output: &str) -> Result<(), String> {
    let path = root().join("evaluation/README.md");
    let line = recorded(program, output)?;
    let cell = if arguments == program.short {
        line
    } else {
        format!("`{}`: {line}", arguments.join(" "))
    };
    let text = with_cell(&read(&path)?, program.name, &cell)?;
    fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// The line that [`Program::recorded`] states.
fn recorded(program: &Program, output: &str) -> Result<String, String> {
    let mut lines = output.lines().map(plain).filter(|line| !line.is_empty());
    let found = if program.recorded.is_empty() {
        lines.next_back()
    } else {
        lines.find(|line| line.starts_with(program.recorded))
    };
    found.ok_or_else(|| {
        format!("{} printed no line that begins with `{}`", program.name, program.recorded)
    })
}

/// A line without its layout, as it fits the cell of a table: its own cells are separated by commas.
fn plain(line: &str) -> String {
    let cells: Vec<&str> = line.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect();
    cells.join(", ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A document with another last cell in the row of a program.
fn with_cell(text: &str, name: &str, cell: &str) -> Result<String, String> {
    let start = format!("| `{name}` |");
    let row = text.lines().find(|line| line.starts_with(&start));
    let cells = row.and_then(|row| row.trim_end_matches([' ', '|']).rsplit_once(" | "));
    let (Some(row), Some((kept, _))) = (row, cells) else {
        return Err(format!("evaluation/README.md has no row {start}"));
    };
    Ok(text.replace(row, &format!("{kept} | {cell} |")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::programs::PROGRAMS;

    #[test]
    fn the_recorded_line_takes_the_place_of_the_last_cell() {
        let program = |recorded| Program { name: "p", shows: "", short: &[], recorded };
        let output = "title\n| 1000 | 0.4  |\n\n  right   orders 3/3\n right orders 4/4\nend\n";
        assert_eq!(recorded(&program("right orders"), output).unwrap(), "right orders 3/3");
        assert_eq!(recorded(&program("1000,"), output).unwrap(), "1000, 0.4");
        assert_eq!(recorded(&program(""), output).unwrap(), "end");
        assert!(recorded(&program("other"), output).is_err());
        let text = "| `o` | x | 1 |\n| `p` | y | 2 |\n";
        assert_eq!(with_cell(text, "p", "3 %").unwrap(), "| `o` | x | 1 |\n| `p` | y | 3 % |\n");
        assert!(with_cell(text, "q", "").is_err());
    }

    #[test]
    fn every_program_has_a_row() {
        let text = read(&root().join("evaluation/README.md")).unwrap();
        for program in PROGRAMS {
            with_cell(&text, program.name, "").unwrap();
        }
    }
}
