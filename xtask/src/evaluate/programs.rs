//! The programs of `evaluation/src/programs`. A new one is a line here.

/// A program.
pub(crate) struct Program {
    /// That of its file.
    pub(crate) name: &'static str,
    /// What it shows, in a line.
    pub(crate) shows: &'static str,
    /// Its arguments for a run of a few seconds, which shows that it works.
    pub(crate) short: &'static [&'static str],
    /// What `--record` writes into evaluation/README.md: the first line of its output that begins with this text, without
    /// its layout; the last line where the text is empty.
    pub(crate) recorded: &'static str,
}

const fn program(
    name: &'static str,
    shows: &'static str,
    short: &'static [&'static str],
    recorded: &'static str,
) -> Program {
    Program { name, shows, short, recorded }
}

pub(crate) const PROGRAMS: &[Program] = &[
    program(
        "orders",
        "how often the order of random systems is found",
        &["--systems", "6"],
        "right orders",
    ),
    program(
        "factor",
        "models from an R factor compared with models from the samples in memory",
        &["--systems", "6", "--drives", "2", "--drive-samples", "8000"],
        "fit to the output without noise",
    ),
    program(
        "closed_loop",
        "bias of the methods with a driver in the loop",
        &[
            "--samples",
            "4000",
            "--seeds",
            "4",
            "--past",
            "10",
            "--feedback-samples",
            "1000",
            "--feedback-seeds",
            "4",
            "--peer-samples",
            "1000",
            "--peer-seeds",
            "2",
        ],
        "10 ssarx",
    ),
    program(
        "coverage",
        "how often stated 95 % bands hold the truth of known cars",
        &["--drives", "3", "--kind", "realistic,sweep,held-steps", "--rate", "10"],
        "response error",
    ),
    program(
        "response",
        "the identified response of known cars at 100 to 10 Hz, and SciPy's",
        &["--short"],
        "realistic 100",
    ),
    program(
        "focus",
        "small simulation errors or small prediction errors",
        &["--drives", "4"],
        "dryer2 3",
    ),
    program(
        "refinement",
        "the refinement compared with SciPy's on the same criterion",
        &["--longest", "13750"],
        "mean square",
    ),
    program("records", "fits on recorded data compared with other packages", &[], "δ·v 0.05 s"),
    program("bicycle", "the bicycle structure compared with black-box models", &[], "bicycle"),
    program(
        "single_track",
        "the single-track model on known cars and on a race car's recording",
        &["--drives", "1"],
        "0: estimation",
    ),
    program(
        "command_line",
        "seconds from a CSV file to plant.json, and where they go",
        &["--rows", "12000", "--runs", "3", "--limit", "60"],
        "steerwright identify",
    ),
    program(
        "large",
        "time and memory of an identification from a million samples",
        &["--samples", "20000"],
        "",
    ),
    program(
        "long_log",
        "time and memory of a log of hundreds of megabytes",
        &["--megabytes", "12"],
        "peak memory",
    ),
    program(
        "multivariable",
        "plants of several named channels compared with SLICOT, and the coverage of their bands",
        &["--systems", "6", "--samples", "500"],
        "coverage",
    ),
    program(
        "speed",
        "time, memory and accuracy of the subspace methods compared with SLICOT",
        &["--longest", "1000", "--draws", "3"],
        "1000,",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::help;
    use crate::run::root;

    /// Nothing in the folder goes without a short form, and nothing here without a program.
    #[test]
    fn every_program_is_listed() {
        let folder = root().join("evaluation/src/programs");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
            .filter(|name| name != "mod")
            .collect();
        let mut listed: Vec<&str> = PROGRAMS.iter().map(|p| p.name).collect();
        files.sort();
        listed.sort_unstable();
        assert_eq!(listed, files, "xtask/src/evaluate/programs.rs lists the programs");
    }

    #[test]
    fn the_short_form_uses_options_that_the_program_has() {
        for program in PROGRAMS {
            let text = help::text(Some(program)).unwrap();
            for option in program.short.iter().filter(|word| word.starts_with("--")) {
                assert!(text.contains(&format!("  {option}")), "{}: {option}", program.name);
            }
        }
    }
}
