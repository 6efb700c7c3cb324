//! The files of a comparison: tables, figures and one self-contained page.

use crate::compare::Comparison;
use crate::figures::{self, Drawn};
use crate::{Error, tables};
use steerwright_formats::SourceFile;
use steerwright_report::{Block, Section, Table, Tone, WIDTH, report_html};
use steerwright_sweep::Class;

/// The page.
pub const PAGE: &str = "comparison.html";

/// A file to write.
#[allow(missing_docs)]
pub struct OutputFile {
    pub source: SourceFile,
    pub bytes: Vec<u8>,
}

/// The files of a comparison: `results.csv`, a CSV of each run, figures (SVG) and `comparison.html`.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn files(c: &Comparison) -> Result<Vec<OutputFile>, Error> {
    let mut files = Vec::new();
    let mut add = |name: String, bytes: Vec<u8>| {
        let source = SourceFile::named(name, &bytes);
        files.push(OutputFile { source, bytes });
    };
    add("results.csv".into(), tables::csv(c).into_bytes());
    for run in &c.runs {
        let (controller, plant) =
            (&c.controllers[run.controller].label, &c.plants[run.plant].label);
        let name =
            format!("runs/{}-on-{}.csv", figures::file_name(controller), figures::file_name(plant));
        add(name, run.csv.clone().into_bytes());
    }
    let figures = figures::all(c);
    for drawn in &figures {
        let svg = drawn.figure.to_svg(WIDTH, drawn.height)?;
        add(format!("{}.svg", drawn.name), svg.into_bytes());
    }
    let written: Vec<SourceFile> = files.iter().map(|f: &OutputFile| f.source.clone()).collect();
    let bytes = html(c, figures, &written).into_bytes();
    let source = SourceFile::named(PAGE, &bytes);
    files.push(OutputFile { source, bytes });
    Ok(files)
}

/// The page; `written` are the other files.
fn html(c: &Comparison, figures: Vec<Drawn>, written: &[SourceFile]) -> String {
    let models: Vec<&str> = c.models.iter().map(|m| m.label.as_str()).collect();
    let title = format!("{}: compared", models.join(", "));
    let lead = "Angles are in degrees, positive to the left (ISO 8855), steering as commanded. Every \
                loop is one of packed FMUs; what differs between two rows of a plant is the \
                controller alone.";
    let drawn = figures.into_iter().map(|d| {
        let Drawn { name, figure, height, caption } = d;
        (name, Block::Figure { figure, height, caption })
    });
    let mut rest: Vec<(String, Block)> = drawn.collect();
    let mut sections = vec![verdict(c)];
    let mut take = |start: &str| -> Vec<Block> {
        let found: Vec<_> = rest.extract_if(.., |(name, _)| name.starts_with(start)).collect();
        found.into_iter().map(|(_, block)| block).collect()
    };
    if c.drive.is_some() {
        let mut blocks = vec![Block::Table(tables::drive_table(c))];
        blocks.extend(take("fig3"));
        sections.push(Section::new("Models against the drive", blocks));
    }
    let mut blocks = vec![Block::Text(format!(
        "{}: {:.1} m, driven at {:.2} m/s, with up to {:.2} m/s² of lateral acceleration.",
        c.road.name,
        c.length(),
        c.road.speed_mps,
        c.lateral_acceleration()
    ))];
    blocks.extend(take("fig5"));
    sections.push(Section::new("The road", blocks));
    let mut blocks = vec![
        Block::Table(tables::controller_table(c)),
        Block::Heading("Cross-track error, RMS / largest".into()),
        Block::Table(tables::matrix(c)),
        Block::Text("A star marks the model that the controller was designed on.".into()),
        Block::Heading("Along the road".into()),
        Block::Table(tables::road_table(c)),
    ];
    blocks.extend(take("fig6"));
    sections.push(Section::new("Controllers on every plant", blocks));
    let mut blocks = vec![Block::Table(tables::step_table(c))];
    blocks.extend(take("steps"));
    sections.push(Section::new("Predicted and achieved", blocks));
    sections.push(method(c));
    sections.push(provenance(c, written));
    report_html(&title, lead, &sections)
}

fn verdict(c: &Comparison) -> Section {
    let (tone, title) = match (c.worst(), &c.verdict.tracks_best) {
        (Class::Unstable, _) => (Tone::Bad, "A controller is unstable".to_owned()),
        (Class::OffThePath, _) => (Tone::Bad, "A controller is off the path".to_owned()),
        (_, Some(name)) => (Tone::Neutral, format!("The controller of {name} tracks best")),
        (_, None) => (Tone::Neutral, "No controller tracks better than the others".to_owned()),
    };
    let mut sentences = c.verdict.sentences.iter();
    let first = sentences.next().cloned().unwrap_or_default();
    let mut blocks =
        vec![Block::Note { tone, title, text: first }, Block::List(sentences.cloned().collect())];
    if !c.remarks.is_empty() {
        blocks.push(Block::Heading("Remarks".into()));
        blocks.push(Block::List(c.remarks.clone()));
    }
    Section::new("Result", blocks)
}

/// The conditions that are equal for all controllers.
fn method(c: &Comparison) -> Section {
    let mut table = Table::new([
        "plant",
        "yaw rate per steering",
        "sideslip per yaw rate",
        "per yaw acceleration",
    ]);
    for plant in &c.plants {
        table.push([
            plant.label.clone(),
            format!("{:.4} 1/s", plant.gain),
            format!("{:.1} ms", 1e3 * plant.sideslip.per_yaw_rate),
            format!("{:.5} s²", plant.sideslip.per_yaw_acceleration),
        ]);
    }
    let text = format!(
        "The coupling is {}, the step the controllers' sample time. Look-ahead, preview and feedforward \
         follow from each controller by one rule. The path follower uses the sideslip of the \
         plant that it guides, read in a turn of each, the same for all controllers; an identified \
         plant has that of its file. A cross-track error beyond {} m is off the path.",
        c.coupling, c.max_cross_track_error_m
    );
    let blocks = vec![Block::Text(text), Block::Table(table)];
    Section::new("What was held equal", blocks)
}

fn provenance(c: &Comparison, written: &[SourceFile]) -> Section {
    let table = |header: &str, files: &[SourceFile]| {
        let mut table = Table::new([header, "SHA-256"]);
        files.iter().for_each(|f| table.push([f.name.as_str(), &f.sha256]));
        Block::Table(table)
    };
    let mut blocks = vec![
        Block::Text(format!("Written by steerwright {}.", env!("CARGO_PKG_VERSION"))),
        table("file read", &c.sources),
        table("file written", written),
    ];
    if !c.road.provenance.options.is_empty() {
        let mut options = Table::new(["option of the road", "value"]);
        c.road.provenance.options.iter().for_each(|(k, v)| options.push([k, v]));
        blocks.push(Block::Table(options));
    }
    Section { folded: true, ..Section::new("Provenance", blocks) }
}
