//! The commands of the snapshot: those of `commands.txt`, and those on further logs.

use std::path::Path;

/// A command with its name, which is also that of the folder it runs in.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Command {
    pub(super) name: String,
    pub(super) arguments: Vec<String>,
}

/// Commands on each further log; `{log}` is its file.
const ON_LOGS: [(&str, &str); 9] = [
    ("inspect", "inspect {log}"),
    ("inspect-json", "inspect {log} --json --plot page.html"),
    ("auto", "identify {log} --steering-ratio 1"),
    ("wheel", "identify {log} --steering-ratio 15 --report page.html --traces traces.csv"),
    ("state-space", "identify {log} --steering-ratio 1 --structure state-space --json"),
    ("bicycle", "identify {log} --steering-ratio 1 --structure bicycle"),
    ("single-track", "identify {log} --steering-ratio 1 --structure single-track"),
    ("accumulate", "accumulate {log} --steering-ratio 1"),
    ("build", "build {log} --steering-ratio 15 --json"),
];

/// All commands; `cases` are the names of further logs below the folder `cases`.
pub(super) fn commands(cases: &[String]) -> Result<Vec<Command>, String> {
    let mut commands = parse(include_str!("commands.txt"))?;
    for case in cases {
        let name =
            Path::new(case).with_extension("").display().to_string().replace(['/', '\\'], "-");
        for (what, line) in ON_LOGS {
            let line = line.replace("{log}", &format!("\"../cases/{case}\""));
            commands
                .push(Command { name: format!("case-{name}-{what}"), arguments: words(&line)? });
        }
    }
    Ok(commands)
}

/// A command a line, `name: arguments`.
fn parse(text: &str) -> Result<Vec<Command>, String> {
    let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let command = |line: &str| {
        let (name, arguments) = line.split_once(':').ok_or(format!("{line:?} has no name"))?;
        Ok(Command { name: name.into(), arguments: words(arguments)? })
    };
    lines.map(command).collect()
}

/// The words of a line; one in quotation marks may have spaces.
fn words(line: &str) -> Result<Vec<String>, String> {
    let parts: Vec<&str> = line.split('"').collect();
    if parts.len().is_multiple_of(2) {
        return Err(format!("{line:?}: a quotation mark is missing"));
    }
    let mut words = Vec::new();
    for (index, part) in parts.into_iter().enumerate() {
        match index % 2 {
            0 => words.extend(part.split_whitespace().map(String::from)),
            _ => words.push(part.to_owned()),
        }
    }
    Ok(words)
}

impl Command {
    /// Whether it reads what another command wrote: names its folder.
    pub(super) fn needs(&self, other: &Self) -> bool {
        let folder = format!("../{}/", other.name);
        self.arguments.iter().any(|argument| argument.contains(&folder))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn words_in_quotation_marks_have_spaces() {
        assert_eq!(words(" a --unit \"x y=m\"  b").unwrap(), ["a", "--unit", "x y=m", "b"]);
        assert!(words("a \"b").is_err());
    }

    #[test]
    fn each_command_has_its_own_name_and_needs_earlier_ones_alone() {
        let commands = commands(&["a/b.csv".into()]).unwrap();
        let names: BTreeSet<_> = commands.iter().map(|command| &command.name).collect();
        assert_eq!(names.len(), commands.len());
        assert!(names.contains(&"case-a-b-auto".to_owned()));
        for (index, command) in commands.iter().enumerate() {
            let later = commands[index..].iter().find(|other| command.needs(other));
            assert_eq!(later, None, "{}", command.name);
        }
    }
}
