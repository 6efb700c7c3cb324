//! The report page: self-contained, escaped, and true to the files.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::*;
use steerwright_formats::{Model, Quality};
use steerwright_report::{Controller, LoopStep, Report};

/// The page of a controller that meets its specification on its model, or not; and in the loop
/// likewise.
fn page_with_loop(met: bool, in_loop: bool) -> String {
    let (plant, traces, bicycle, path) = (plant(), traces(3000), bicycle(), path());
    let model = model();
    let (pid, step, run) = (pid(met), step(1.0), track(0.2));
    Report {
        title: "A <drive> & more".into(),
        model: Some(&model),
        traces: Some(&traces),
        channels: None,
        bicycle: Some(&bicycle),
        bicycle_fit: Some(61.0),
        controllers: vec![Controller {
            name: "identified",
            pid: &pid,
            in_loop: Some(LoopStep {
                plant: "the other plant",
                response: &step,
                metrics: &self::pid(in_loop).evidence.step,
            }),
        }],
        path: Some(&path),
        tracks: vec![("identified", &run)],
        remarks: vec!["the road <needs> more".into()],
        files: plant.provenance.sources.clone(),
    }
    .to_html()
}

fn page(met: bool) -> String {
    page_with_loop(met, met)
}

#[test]
fn remarks_are_warnings_even_without_a_model() {
    assert!(page(true).contains("the road &lt;needs&gt; more"));
    let report = Report { remarks: vec!["no controller".into()], ..Report::default() };
    let page = report.to_html();
    assert!(page.contains("Warnings") && page.contains("no controller"), "{page}");
}

#[test]
fn requirements_met_on_a_model_with_reservations_say_so() {
    let page = |quality: Quality| {
        let mut pid = pid(true);
        pid.evidence.robustness = None;
        pid.designed_for.quality = quality;
        let controllers = vec![Controller { name: "identified", pid: &pid, in_loop: None }];
        Report { controllers, ..Report::default() }.to_html()
    };
    assert!(page(Quality::new("good", vec![], vec![])).contains("Every requirement is met."));
    let doubtful = page(Quality::default());
    assert!(!doubtful.contains("Every requirement is met."), "{doubtful}");
    assert!(doubtful.contains("met on the model, which has reservations"), "{doubtful}");
    assert!(doubtful.contains("quality of the design: warn"), "{doubtful}");
    assert!(doubtful.contains("met on a model with reservations"), "{doubtful}");
}

#[test]
fn a_controller_that_fails_in_the_loop_is_not_called_good() {
    let good = page_with_loop(true, true);
    assert!(good.contains("Every requirement is met") && !good.contains("not met"), "{good}");
    let failing = page_with_loop(true, false);
    assert!(!failing.contains("Every requirement is met"));
    assert!(
        failing.contains("not in closed loop with the other plant") && failing.contains("not met")
    );
}

#[test]
fn requirements_that_plants_of_the_ensemble_miss_are_not_called_good() {
    let mut missed = pid(true);
    let mut robustness = missed.evidence.robustness.clone().unwrap_or_else(robustness);
    robustness.met = false;
    missed.evidence.robustness = Some(robustness);
    let report = Report {
        controllers: vec![Controller { name: "identified", pid: &missed, in_loop: None }],
        ..Report::default()
    };
    let page = report.to_html();
    assert!(page.contains("on the nominal plant, not on all plants"), "{page}");
    assert!(!page.contains("note good"), "{page}");
}

/// Of no plants.
fn robustness() -> steerwright_formats::Robustness {
    steerwright_formats::Robustness {
        met: true,
        members: 0,
        members_wanted: None,
        seed: 1,
        loop_delay_range_s: [0.0, 0.01],
        gain_range: [1.0, 1.0],
        speed_range_mps: None,
        plants: 1,
        requirements: Vec::new(),
        latency: Vec::new(),
        speed: Vec::new(),
    }
}

#[test]
fn each_reason_is_stated_once_and_backticks_become_code() {
    use steerwright_formats::{Grade, Quality, Reason, ReasonCode};
    let reason = |code, message: &str| Reason::new(code, Grade::Fail, message);
    let mut plant = plant();
    plant.quality = Quality::new(
        "Validation failed: column `a_mps` is slow.",
        vec![
            reason(ReasonCode::SlowLog, "column `a_mps` is slow"),
            reason(ReasonCode::Spikes, "it has spikes"),
        ],
        vec!["check `b` and `c`; this ` stands alone".into()],
    )
    .with_remarks(vec!["above 2 Hz there is no information".into()]);
    let model = Model::StateSpace(Box::new(plant));
    let page = Report { model: Some(&model), ..Report::default() }.to_html();
    parse(&page);
    let body = page.split("<main>").nth(1).unwrap();
    assert_eq!(body.matches("column <code>a_mps</code> is slow").count(), 1, "{body}");
    assert_eq!(body.matches("it has spikes").count(), 1, "{body}");
    let advice = "check <code>b</code> and <code>c</code>; this ` stands alone";
    assert!(body.contains(advice), "{body}");
    // Statements stand apart from what to do.
    let [limits, remark, next, advice] =
        ["Limits of the model", "above 2 Hz there is no", "What to do next", advice]
            .map(|part| body.find(part).unwrap());
    assert!(limits < remark && remark < next && next < advice, "{body}");
}

fn parse(page: &str) -> roxmltree::Document<'_> {
    // The page is written as XML too, but for its document type.
    roxmltree::Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap()
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    let page = page(true);
    let document = parse(&page);
    assert_eq!(page, self::page(true));
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        let name = node.tag_name().name();
        assert!(!["link", "iframe", "object", "img", "image", "use"].contains(&name));
        for attribute in node.attributes() {
            let inner = attribute.name() != "href" || attribute.value().starts_with('#');
            assert!(inner, "{name} {attribute:?}");
            assert!(!attribute.name().starts_with("on") && attribute.name() != "src");
        }
    }
    let style = document.descendants().find(|n| n.has_tag_name("style")).unwrap();
    let style = style.text().unwrap();
    assert!(!style.contains("url(") && !style.contains("@import"));
    assert!(page.len() < 2_000_000, "{}", page.len());
    // What is referred to by its id is there.
    let refers = ["href", "aria-labelledby"];
    for (name, id) in refers
        .iter()
        .flat_map(|a| document.descendants().filter_map(move |n| Some((a, n.attribute(*a)?))))
    {
        let id = id.trim_start_matches('#');
        assert!(document.descendants().any(|n| n.attribute("id") == Some(id)), "{name} {id}");
    }
}

/// The text of the page's scripts: the figures' data, uPlot, and the page's own.
fn scripts<'a>(document: &'a roxmltree::Document<'_>) -> Vec<&'a str> {
    document.descendants().filter(|n| n.has_tag_name("script")).map(|n| n.text().unwrap()).collect()
}

#[test]
fn every_figure_is_there_as_svg_and_as_data_with_its_result_in_words() {
    let page = page(true);
    let document = parse(&page);
    let scripts = scripts(&document);
    assert_eq!(scripts.len(), 5);
    let data: serde_json::Value = serde_json::from_str(scripts[0]).unwrap();
    let figures = data["figures"].as_array().unwrap();
    let drawn: Vec<_> = document.descendants().filter(|n| n.has_tag_name("figure")).collect();
    assert!(drawn.len() > 8 && drawn.len() == figures.len());
    let svg = "http://www.w3.org/2000/svg";
    for (k, (node, figure)) in drawn.iter().zip(figures).enumerate() {
        assert_eq!(node.attribute("id"), Some(&*format!("f{k}")));
        assert!(node.descendants().any(|n| n.has_tag_name((svg, "svg"))));
        let title = figure["title"].as_str().unwrap();
        let result = node.descendants().find(|n| n.has_tag_name("b")).unwrap();
        assert!(result.text().is_some_and(|t| t.ends_with('.')), "{title} states nothing");
    }
    // The drive's samples are stored once for its own figure and the comparison.
    let column = |figure: usize, panel: usize, series: usize, axis: &str| {
        figures[figure]["panels"][panel]["series"][series][axis].as_u64().unwrap()
    };
    assert_eq!(column(0, 1, 0, "y"), column(2, 0, 0, "y"));
    assert_eq!(column(0, 1, 0, "x"), column(0, 0, 0, "x"));
}

#[test]
fn untrusted_names_are_text() {
    let mut page = page(true);
    let document = parse(&page);
    let cells: Vec<_> =
        document.descendants().filter(|n| n.has_tag_name("td")).filter_map(|n| n.text()).collect();
    assert!(cells.contains(&"yawRate <script>"));
    assert!(cells.contains(&"drive \"<b>& 'one'.csv"));
    let ours = scripts(&document).len();
    assert_eq!(page.matches("<script").count(), ours);
    // In the data of a figure too.
    let evil = "</script><script>alert(1)</script>]]>&";
    let (track, path) = (track(0.2), path());
    let report = Report { tracks: vec![(evil, &track)], path: Some(&path), ..Report::default() };
    page = report.to_html();
    let document = parse(&page);
    assert_eq!(page.matches("<script").count(), ours);
    let data: serde_json::Value = serde_json::from_str(scripts(&document)[0]).unwrap();
    assert_eq!(data["figures"][0]["panels"][0]["series"][1]["name"], evil);
}

#[test]
fn a_long_drive_does_not_make_a_large_page() {
    let (model, traces) = (model(), traces(150_000));
    let page = Report { model: Some(&model), traces: Some(&traces), ..Report::default() }.to_html();
    assert!(page.len() < 2_000_000 && page.contains("To limit the size"), "{}", page.len());
}

#[test]
fn every_requirement_is_marked_met_or_not_met() {
    let row = |page: &str, requirement: &str| -> Vec<String> {
        let document = parse(page);
        let first = |n: &roxmltree::Node<'_, '_>| {
            n.has_tag_name("tr") && n.first_child().and_then(|c| c.text()) == Some(requirement)
        };
        let row = document.descendants().find(first).unwrap();
        row.children().map(|c| c.text().unwrap_or_default().replace('\u{a0}', " ")).collect()
    };
    let (good, bad) = (page(true), page(false));
    assert_eq!(row(&good, "settling time"), ["settling time", "≤ 1 s", "0.83 s ✓", "0.83 s ✓"]);
    assert_eq!(row(&bad, "settling time")[2..], ["1.4 s ✗", "1.4 s ✗"]);
    // On its model and in the loop are two questions.
    let in_loop = row(&page_with_loop(true, false), "settling time");
    assert_eq!(in_loop[2..], ["0.83 s ✓", "1.4 s ✗"]);
    assert_eq!(row(&bad, "overshoot")[2], "0.41 % ✓");
    assert!(good.contains("Every requirement is met") && bad.contains("Not every requirement"));
    assert!(bad.contains("Settling time is 1.4 s, 1 s is required"));
    // What else may be asked for has its place, and is empty where it was not.
    assert_eq!(row(&good, "modulus margin")[..3], ["modulus margin", "≥ 0.5", "0.71 ✓"]);
    assert_eq!(row(&good, "gain margin")[..3], ["gain margin", "", "13.4 dB"]);
    let mut asking = pid(true);
    asking.specification.rise_time_s = Some(0.3);
    asking.specification.phase_margin_deg = Some(60.0);
    let asking = Report {
        controllers: vec![Controller { name: "identified", pid: &asking, in_loop: None }],
        ..Report::default()
    }
    .to_html();
    let rise = row(&asking, "rise time");
    assert_eq!(rise[1..3], ["≤ 0.3 s", "0.37 s ✗"]);
    assert_eq!(row(&asking, "phase margin")[1], "≥ 60°");
}

#[test]
fn a_figure_without_data_leaves_a_remark_and_an_empty_report_a_page() {
    let model = model();
    let traces = steerwright_report::Traces::default();
    let report = Report { model: Some(&model), traces: Some(&traces), ..Report::default() };
    let page = report.to_html();
    parse(&page);
    assert!(page.contains("is missing"));
    parse(&Report::default().to_html());
}

#[test]
fn a_bicycle_has_its_parameters_with_their_bands() {
    let mut bicycle = bicycle();
    bicycle.evidence = Some(steerwright_formats::BicycleEvidence {
        identified: vec![steerwright_formats::Estimated {
            name: "wheelbase".into(),
            value: 2.7,
            standard_error: 0.05,
            unit: "m".into(),
        }],
        validation_samples: 100,
        validation_fit: 91.28,
        ..Default::default()
    });
    let (model, traces) = (Model::Bicycle(Box::new(bicycle)), traces(3000));
    let page = Report { model: Some(&model), traces: Some(&traces), ..Report::default() }.to_html();
    parse(&page);
    for text in
        ["identified bicycle", "2.60000 to 2.80000", "91.28\u{a0}%", "Measured and identified"]
    {
        assert!(page.contains(text), "{text}");
    }
}
