//! `steerwright inspect`: what is in a log.

use crate::documents::files;
use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::options::log::{SourceArguments, log_file};
use crate::output::{OutputKind, Outputs};
use crate::terminal::console;
use crate::terminal::progress::Progress;
use std::fmt::Write;
use std::path::PathBuf;
use steerwright_drivelog::{
    InspectedChannel, InspectedGroup, Inspection, LOG_FORMATS, LogOptions, inspect,
};
use steerwright_report::{
    Block, Figure, Panel, Section, Series, Style, Table, palette, report_html,
};

/// Most panels of a page where no channel is named.
const PANELS: usize = 24;

/// List the channels of a log: units, rates, ranges, gaps, and which of them look like steering, yaw rate,
/// speed, lateral acceleration or GNSS
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[arg(value_name = "LOG", help = format!("The log: {LOG_FORMATS} with --dbc"))]
    log: PathBuf,
    /// List and draw this channel only, named as it is listed; may be repeated
    #[arg(long = "channel", value_name = "CHANNEL")]
    channels: Vec<String>,
    /// Draw the channels over time on a page (HTML): those of --channel, by default those with a recognised role,
    /// else the first 24
    #[arg(long, value_name = "HTML")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    source: SourceArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let plot = Outputs::new(global.force, [&arguments.log])
        .optional(arguments.plot.as_ref(), OutputKind::Html)?;
    let options = arguments.source.complete(LogOptions::default())?;
    let progress = Progress::start(format!("reading {}", arguments.log.display()));
    let file = files::of_one_log(&arguments.log)?;
    let mut found = inspect(log_file(&file, &progress)?, &options)?;
    drop(progress);
    let empty = nothing_read(&found);
    select(&mut found, &arguments.channels)?;
    for loss in &found.losses {
        console::warning(loss);
    }
    if let Some(plot) = &plot {
        plot.write(page(&found, !arguments.channels.is_empty()).as_bytes())?;
    }
    console::result(&text(&found), &found)?;
    if let Some(plot) = &plot {
        console::note(format!("written to {plot}"));
    }
    empty.map_or(Ok(Outcome::Done), Err)
}

/// Why a log without any number is refused.
fn nothing_read(found: &Inspection) -> Option<Failure> {
    let groups = &found.groups;
    if groups.iter().any(|group| group.channels.iter().any(|channel| channel.values > 0)) {
        return None;
    }
    let what = if groups.iter().all(|group| group.rows == 0) { "row" } else { "numeric channel" };
    let hint = if found.losses.is_empty() {
        format!(
            "check that the log holds numbers: {LOG_FORMATS} with its database; a table has a header line and a row for each sample"
        )
    } else {
        "the warnings give the reasons; a table needs a header line and a row of numbers for each sample".into()
    };
    Some(Failure::new(format!("{}: no {what} was read", found.file), hint))
}

/// A channel as the options of the other commands name it.
fn label(group: &InspectedGroup, channel: &InspectedChannel) -> String {
    if group.name.is_empty() {
        channel.name.clone()
    } else {
        format!("{}.{}", group.name, channel.name)
    }
}

fn is_named(group: &InspectedGroup, channel: &InspectedChannel, name: &str) -> bool {
    channel.name == name || label(group, channel) == name
}

/// Leaves the named channels.
fn select(found: &mut Inspection, names: &[String]) -> Result<(), Failure> {
    for name in names {
        if !found.groups.iter().any(|g| g.channels.iter().any(|c| is_named(g, c, name))) {
            return Err(Failure::new(
                format!("--channel {name}: {} has no such channel", found.file),
                "spell it as it is listed without the option",
            ));
        }
    }
    if names.is_empty() {
        return Ok(());
    }
    for group in &mut found.groups {
        let all = std::mem::take(&mut group.channels);
        let named = all.into_iter().filter(|c| names.iter().any(|name| is_named(group, c, name)));
        group.channels = named.collect();
    }
    found.groups.retain(|group| !group.channels.is_empty());
    Ok(())
}

fn start_in_words(found: &Inspection) -> String {
    format!(
        "Time counts from the first sample, which is at {:.3} s on the log's clock.",
        found.log_start_s
    )
}

fn text(found: &Inspection) -> String {
    let mut text = String::new();
    if found.log_start_s != 0.0 {
        text = start_in_words(found) + "\n\n";
    }
    for group in &found.groups {
        match (group.name.as_str(), group.kind.as_str()) {
            ("", _) => {}
            (name, "") => text += &format!("{name}\n"),
            (name, kind) => text += &format!("{name} ({kind})\n"),
        }
        let _ = writeln!(text, "{}\n", clock_in_words(group));
        let mut table =
            Table::new(["channel", "unit", "values", "smallest", "largest", "looks like"]);
        for channel in &group.channels {
            let shown = |x: Option<f64>| match x {
                Some(value) => number(value),
                None => "–".into(),
            };
            let is_clock = group.clock.as_ref() == Some(&channel.name);
            table = table.row([
                shown_name(&channel.name),
                channel.unit.clone().unwrap_or_else(|| "not stated".into()),
                channel.values.to_string(),
                shown(channel.min),
                shown(channel.max),
                if is_clock { "time".into() } else { channel.candidate_for.join(", ") },
            ]);
        }
        // A name is copied from here: it is not broken, though the table is wider then.
        const OTHERS: usize = 60;
        let words = group.channels.iter().flat_map(|channel| channel.name.split(' '));
        let longest = words.map(|word| word.chars().count()).max().unwrap_or(0).min(LONGEST_NAME);
        let _ = writeln!(text, "{}", table.text(console::columns().max(longest + OTHERS)));
    }
    text
}

/// Characters of a name beyond which only its start is shown; `--json` has all of it.
const LONGEST_NAME: usize = 200;

fn shown_name(name: &str) -> String {
    let name = name.replace(['\r', '\n'], " ");
    match name.char_indices().nth(LONGEST_NAME) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name,
    }
}

fn number(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e7).contains(&x.abs()) {
        let digits = (4.0 - x.abs().log10().floor()).clamp(0.0, 6.0);
        format!("{x:.*}", digits as usize)
    } else {
        format!("{x:.3e}")
    }
}

fn clock_in_words(group: &InspectedGroup) -> String {
    let plural = if group.rows == 1 { "row" } else { "rows" };
    let mut text = format!("{} {plural}", group.rows);
    if let (Some(rate), Some([from, to])) = (group.rate_hz, group.span_s) {
        let _ = write!(text, " at {rate} Hz, {from:.3} to {to:.3} s ({:.2} s)", to - from);
    }
    if let Some([from, to]) = group.longest_gap_s {
        let plural = if group.gaps == 1 { "gap" } else { "gaps" };
        let _ = write!(
            text,
            ", {} {plural}, the longest {:.3} s at {:.3} s",
            group.gaps,
            to - from,
            from
        );
    }
    if let Some(hint) = &group.no_clock {
        let _ = write!(text, "; no clock: {hint}");
    }
    text
}

/// The channels over time, a panel each: the named ones, or those that look like something.
fn page(found: &Inspection, are_named: bool) -> String {
    let all = || found.groups.iter().flat_map(|g| g.channels.iter().map(move |c| (g, c)));
    let drawn = |c: &InspectedChannel| c.outline.len() > 1;
    let is_shown = |c: &InspectedChannel| are_named || !c.candidate_for.is_empty();
    let mut shown: Vec<_> = all().filter(|(_, c)| is_shown(c) && drawn(c)).collect();
    if shown.is_empty() {
        let others = all().filter(|(g, c)| g.clock.as_ref() != Some(&c.name) && drawn(c));
        shown = others.take(PANELS).collect();
    }
    let panel = |(group, channel): &(&InspectedGroup, &InspectedChannel)| {
        let unit = channel.unit.as_deref().unwrap_or("unit not stated");
        let x = if group.span_s.is_some() { "time, s" } else { "row" };
        // Where a part has several values, its outline is drawn down and up.
        let points = channel.outline.iter().flat_map(|&[t, least, most]| {
            let second = if most > least { Some((t, most)) } else { None };
            std::iter::once((t, least)).chain(second)
        });
        let name = label(group, channel);
        let series = Series::new(name.clone(), points.collect(), Style::line(palette::BLUE));
        let caption = match &channel.candidate_for[..] {
            [] => clock_in_words(group),
            roles => format!("looks like {}; {}", roles.join(", "), clock_in_words(group)),
        };
        let mut panel = Panel::new(x, unit).with(series);
        panel.link = "log";
        Block::Figure { figure: Figure::new(name, vec![panel]), height: 220, caption }
    };
    let name = found.file.rsplit(['/', '\\']).next().unwrap_or(&found.file);
    let mut sections = vec![Section::new("Channels", shown.iter().map(panel).collect())];
    if !found.losses.is_empty() {
        sections.push(Section::new("Not read", vec![Block::List(found.losses.clone())]));
    }
    let lead = format!("The channels of the log over time. {}", start_in_words(found));
    report_html(name, &lead, &sections)
}
