//! Help that needs no build: the page in front of a program's source, and the fields of its
//! `Arguments`.

use super::programs::{PROGRAMS, Program};
use crate::files::read;
use crate::run::root;
use std::fmt::Write;
use std::path::PathBuf;

/// Of a program, or of all.
pub(crate) fn text(program: Option<&Program>) -> Result<String, String> {
    match program {
        None => Ok(list()),
        Some(program) => Ok(page(program, &read(&source(program.name))?)),
    }
}

fn list() -> String {
    let mut text = "How well the identification does, compared with its peers\n\n\
                    Usage: cargo xtask evaluate [--short] [--record] [PROGRAM [OPTIONS]]\n\n\
                    --short runs with little data, to see that it works; all programs if none is \
                    named.\n\
                    --record writes the figures into evaluation/README.md.\n`cargo xtask evaluate PROGRAM --help` prints a program's options.\n\n\
                    Programs:\n"
        .to_owned();
    for program in PROGRAMS {
        let _ = writeln!(text, "  {:<14}{}", program.name, program.shows);
    }
    text
}

fn source(name: &str) -> PathBuf {
    let folder = root().join("evaluation/src/programs");
    let file = folder.join(format!("{name}.rs"));
    if file.is_file() { file } else { folder.join(name).join("mod.rs") }
}

fn page(program: &Program, source: &str) -> String {
    let mut text = String::new();
    for line in source.lines().map_while(|line| line.strip_prefix("//!")) {
        let _ = writeln!(text, "{}", line.strip_prefix(' ').unwrap_or(line));
    }
    let _ = writeln!(text, "\nUsage: cargo xtask evaluate {} [OPTIONS]\n\nOptions:", program.name);
    for option in options(source) {
        let _ = writeln!(text, "  {option}");
    }
    let _ = writeln!(text, "\nShort form: {}", program.short.join(" "));
    text
}

/// The fields of `struct Arguments`, with their comments and defaults, a line each.
fn options(source: &str) -> Vec<String> {
    let fields = source
        .lines()
        .map(str::trim)
        .skip_while(|line| *line != "struct Arguments {")
        .skip(1)
        .take_while(|line| *line != "}");
    let (mut comment, mut attribute) = (Vec::new(), String::new());
    let mut options = Vec::new();
    for line in fields {
        if let Some(text) = line.strip_prefix("///") {
            comment.push(text.trim());
        } else if line.starts_with("#[arg(") {
            attribute = line.to_owned();
        } else if let Some((name, kind)) = line.split_once(':') {
            let value = if kind.trim() == "bool," { "" } else { " <VALUE>" };
            let name = format!("--{}{value}", name.trim().replace('_', "-"));
            if !attribute.contains("hide = true") {
                let (about, default) = (comment.join(" "), default(&attribute));
                options.push(format!("{name:<28}{about}{default}"));
            }
            comment.clear();
            attribute.clear();
        }
    }
    options
}

/// ` [default: 5]`, as it is written in the attribute.
fn default(attribute: &str) -> String {
    let value = ["default_value_t = ", "default_values_t = ", "default_value = "]
        .iter()
        .find_map(|key| attribute.split_once(key));
    let value = value.and_then(|(_, rest)| rest.strip_suffix(")]"));
    match value {
        Some(value) => format!(" [default: {}]", value.trim_matches('"')),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_those_of_the_source() {
        let source = "//! What it does.\n\n#[derive(Parser)]\nstruct Arguments {\n    \
                      /// Systems\n    #[arg(long, default_value_t = 200)]\n    systems: usize,\n    \
                      #[arg(long, hide = true)]\n    inner: bool,\n    \
                      /// Leave it\n    /// out\n    #[arg(long)]\n    no_delay: bool,\n}\n";
        let found = options(source);
        assert_eq!(found.len(), 2);
        assert!(found[0].starts_with("--systems <VALUE> "), "{}", found[0]);
        assert!(found[0].ends_with("Systems [default: 200]"), "{}", found[0]);
        assert!(found[1].starts_with("--no-delay ") && found[1].ends_with("Leave it out"));
    }
}
