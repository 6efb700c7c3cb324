//! Sections on a terminal, on a page and in a notebook: the same statements, and the details where they are asked for.

use crate::common;
use common::*;
use std::collections::BTreeSet;
use steerwright_report::{
    Block, Controller, Figure, Report, Section, Table, TextStyle, Tone, controller_section,
    notebook_html, page_text, report_html,
};

fn text(sections: &[Section], details: bool) -> String {
    let paint = |tone: Tone, title: &str| format!("<{tone:?} {title}>");
    page_text(sections, &TextStyle { columns: 10_000, details, paint })
}

/// The words with a digit, without the punctuation around them.
fn numbers(text: &str) -> BTreeSet<String> {
    let words = text.split_whitespace().filter(|word| word.contains(|c: char| c.is_ascii_digit()));
    words.map(|word| word.trim_matches([',', ';', ':', '.', '(', ')']).to_owned()).collect()
}

/// What is read of a page, without figures and scripts.
fn read(page: &str) -> String {
    let page = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let document = roxmltree::Document::parse(page).unwrap();
    let main = document.descendants().find(|n| n.has_tag_name("main")).unwrap();
    let is_read = |n: &roxmltree::Node<'_, '_>| {
        n.is_text() && !n.ancestors().any(|a| a.has_tag_name("figure"))
    };
    main.descendants().filter(is_read).map(|n| format!("{} ", n.text().unwrap())).collect()
}

fn controller(met: bool) -> Section {
    let (mut pid, step) = (pid(met), step(1.0));
    pid.evidence.steps = vec![steerwright_formats::HeightStep {
        height_rad: 0.5,
        step: pid.evidence.step_with_offset,
    }];
    let in_loop = steerwright_report::LoopStep {
        plant: "the other plant",
        response: &step,
        metrics: &pid.evidence.step,
    };
    controller_section(&Controller { name: "identified", pid: &pid, in_loop: Some(in_loop) })
}

#[test]
fn a_terminal_and_a_page_show_the_same_numbers() {
    let model = model();
    let of_model = Report { model: Some(&model), ..Report::default() }.sections();
    for sections in [vec![controller(true)], vec![controller(false)], of_model] {
        let (terminal, page) = (text(&sections, true), read(&report_html("", "", &sections)));
        let (printed, shown) = (numbers(&terminal), numbers(&page));
        assert!(printed.len() > 40, "{printed:?}");
        assert_eq!(printed, shown);
    }
}

#[test]
fn the_first_line_is_the_verdict_with_its_reason() {
    let first_of = |sections: &[Section]| text(sections, false).lines().next().unwrap().to_owned();
    let first = |met| first_of(&[controller(met)]);
    let model = model();
    let quality = model.quality();
    let title =
        format!("<Neutral quality {} ({})>: {}", quality.grade, quality.codes(), quality.summary);
    let of_model = first_of(&Report { model: Some(&model), ..Report::default() }.sections());
    assert!(of_model.starts_with(&title), "{of_model}");
    assert_eq!(
        first(true),
        "<Neutral every requirement is met on the model, which has reservations>"
    );
    assert_eq!(
        first(false),
        "<Bad not every requirement is met>: settling time is 1.4 s, 1 s is required"
    );
}

#[test]
fn details_are_printed_where_they_are_asked_for() {
    let sections = [controller(true)];
    let (brief, full) = (text(&sections, false), text(&sections, true));
    for detail in ["Steps of other heights", "anti-windup time", "with steering offset"] {
        assert!(full.contains(detail) && !brief.contains(detail), "{full}");
        assert!(report_html("", "", &sections).contains(detail));
        assert!(!notebook_html(&sections).contains(detail));
    }
    // All that is brief is there in full.
    let full: BTreeSet<&str> = full.lines().collect();
    assert!(brief.lines().all(|line| full.contains(line)), "{brief}");
}

#[test]
fn a_notebook_has_the_figures_and_no_script() {
    let html = notebook_html(&[controller(true)]);
    assert!(html.contains("<svg") && !html.contains("<script"), "{html}");
    assert!(html.contains("Every requirement is met"));
    roxmltree::Document::parse(&format!("<div>{html}</div>")).unwrap();
}

#[test]
fn blocks_are_laid_out_with_blank_lines_around_tables_and_before_headings() {
    let table = || Block::Table(Table::new(["a"]).row(["1"]));
    let figure = || Block::figure(Figure::new("f", vec![]), 100, "caption");
    let first = Section::new(
        "Left out",
        vec![
            Block::Text("a \u{1b}[31mname".into()),
            Block::Facts(vec![("fit".into(), "98\u{a0}%".into()), ("delay".into(), "none".into())]),
            table(),
            Block::List(vec!["one".into(), "two".into()]),
            Block::List(vec![]),
            Block::Heading("Of a figure".into()),
            figure(),
            Block::Heading("Of a table".into()),
            table(),
        ],
    );
    let figures = Section::new("Figures", vec![figure()]);
    let last = Section::new("Last", vec![Block::Text("end".into())]);
    assert_eq!(
        text(&[first, figures, last], false),
        "a \u{fffd}[31mname\nfit    98 %\ndelay  none\n\na\n─\n1\n\n- one\n- two\n\nOf a table\na\n─\n1\n\
         \nLast\nend\n"
    );
}
