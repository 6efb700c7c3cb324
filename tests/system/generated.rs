//! Files that are generated as a whole state the command in their first line, and are what it writes.
//!
//! The figures and tables that commands write into other files have tests where they are made: those of the FMUs'
//! READMEs, the icons and the licences in `packaging/tests`.

#[path = "../../xtask/src/fmus.rs"]
mod fmus;
#[path = "../../xtask/src/formats.rs"]
mod formats;
#[path = "../../xtask/src/python_types.rs"]
mod python_types;
#[path = "../../xtask/src/stacks.rs"]
mod stacks;

use std::path::Path;

const DOCS: &str = "cargo xtask docs --update";

#[test]
fn generated_files_are_current_and_state_their_command() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = root.join("formats/src");
    for (file, command, generated) in [
        ("docs/formats.md", DOCS, Some(formats::page(&sources).unwrap())),
        ("python/steerwright/documents.py", DOCS, Some(python_types::module(&sources).unwrap())),
        // It needs the wheel: `test_options_are_those_of_the_command_line` compares it there.
        ("python/steerwright/options.py", "cargo xtask wheel --update", None),
    ] {
        let text = std::fs::read_to_string(root.join(file)).unwrap().replace("\r\n", "\n");
        let first = text.lines().next().unwrap_or_default();
        assert!(
            first.contains("Generated") && first.contains(&format!("by `{command}`")),
            "{file}: the first line does not state that `{command}` generates it: {first}"
        );
        if let Some(generated) = generated {
            assert!(text == generated, "{file} is out of date: run `{command}`");
        }
    }
}

#[test]
fn the_table_of_the_stacks_is_that_of_their_modules() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (file, generated) = stacks::page(root).unwrap();
    for stack in steerwright_stacks::Stack::ALL {
        assert!(generated.to_lowercase().contains(&format!("| {}", stack.name())), "{stack}");
    }
    let text = std::fs::read_to_string(root.join(&file)).unwrap();
    assert!(text.replace("\r\n", "\n") == generated, "{file} is out of date: run `{DOCS}`");
}

/// What each FMU has with nothing of its own in it, and the lists of all FMUs.
#[test]
fn each_fmu_has_what_is_generated_for_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fmus = fmus::fmus(root).unwrap();
    assert_eq!(fmus.len(), steerwright_packaging::Fmu::ALL.len(), "{fmus:?}");
    for (folder, name) in fmus {
        let fmu = steerwright_packaging::Fmu::ALL.into_iter().find(|fmu| fmu.name() == name);
        assert_eq!(fmu.map(steerwright_packaging::Fmu::folder), Some(folder.as_str()), "{name}");
    }
    for (file, generated) in fmus::files(root).unwrap() {
        let text = std::fs::read_to_string(root.join(&file)).unwrap_or_default();
        assert!(text.replace("\r\n", "\n") == generated, "{file} is out of date: run `{DOCS}`");
    }
}
