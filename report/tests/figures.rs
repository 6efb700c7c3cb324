//! Requirements of every figure: valid, labelled, bounded, deterministic, without a panic on bad data.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::*;
use proptest::prelude::*;
use steerwright_report::figures::{Driven, Simulated, YawStep};
use steerwright_report::{
    Error, Figure, Mark, MarkPlace, Panel, Series, StepResponse, Style, figures, palette,
};

const LIMIT: usize = 150_000;

fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let node = |n: &roxmltree::Node<'_, '_>| n.has_tag_name(("http://www.w3.org/2000/svg", "text"));
    let text = |n: roxmltree::Node<'_, '_>| n.text().unwrap_or_default().trim().to_owned();
    document.descendants().filter(node).map(text).collect()
}

/// Every x and y of polylines, in pixels.
fn polylines(svg: &str) -> Vec<Vec<(f64, f64)>> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let pair = |p: &str| {
        let (x, y) = p.split_once(',').unwrap();
        (x.parse::<f64>().unwrap() / 10.0, y.parse::<f64>().unwrap() / 10.0)
    };
    let points = |n: roxmltree::Node<'_, '_>| -> Option<Vec<_>> {
        Some(n.attribute("points")?.split_whitespace().map(pair).collect())
    };
    document.descendants().filter_map(points).collect()
}

fn all() -> Vec<Figure> {
    let (plant, pid, path) = (plant(), pid(true), path());
    let (near, far) = (track(0.2), track(0.5));
    let (measured, own) = (traces(3000), step(1.0));
    let tracks = [("identified model", &near), ("bicycle model", &far)];
    let (e, s) = (&plant.evidence, &pid.specification);
    vec![
        figures::drive(&traces(30_000)),
        figures::comparison(&traces(30_000), model().fits(), Some(61.0)),
        figures::coherence(&e.excitation),
        figures::order_table(&e.order_table, 2),
        figures::prediction(e.held_out.as_ref().unwrap()),
        figures::residuals(e.residuals.as_ref().unwrap(), 0.05),
        figures::frequency_response(e.frequency_response.as_ref().unwrap(), plant.input),
        figures::poles_and_zeros(e.poles_and_zeros.as_ref().unwrap()),
        figures::yaw_step("Yaw step", &step(1.0), s, &pid.evidence.step, pid.largest_angle_rad()),
        figures::reference_road(&path.points, true, &tracks),
        figures::tracking_errors(&tracks),
        figures::models_against_drive(driven(&measured), &simulated(&measured)),
        figures::road_and_curvature(&path.points, true, 10.0),
        figures::tracking("A controller along the road", &path.points, true, &tracks),
        figures::yaw_steps(0.0873, 2.0, &[yaw_step("plant on its own model", true, &own)]),
    ]
}

fn driven(t: &steerwright_report::Traces) -> Driven<'_> {
    Driven { time_s: &t.time_s, yaw_rate_radps: &t.yaw_rate_radps, yaw_rad: &t.yaw_rad }
}

fn simulated(t: &steerwright_report::Traces) -> [Simulated<'_>; 2] {
    ["identified", "bicycle"].map(|name| Simulated {
        name,
        fit: 77.9,
        yaw_rate_radps: &t.simulated_yaw_rate_radps,
        yaw_rad: &t.simulated_yaw_rad,
    })
}

fn yaw_step<'a>(name: &'a str, predicted: bool, response: &'a StepResponse) -> YawStep<'a> {
    YawStep { name, rank: 0, predicted, response }
}

#[test]
fn every_figure_is_valid_labelled_bounded_and_repeatable() {
    for figure in all() {
        let svg = figure.to_svg(900, 700).unwrap();
        assert_eq!(svg, figure.to_svg(900, 700).unwrap(), "{}", figure.title);
        assert!(svg.len() < LIMIT, "{}: {} bytes", figure.title, svg.len());
        let texts = texts(&svg);
        assert!(texts.contains(&figure.title));
        for panel in &figure.panels {
            assert!(texts.contains(&panel.x_label), "{}: {}", figure.title, panel.x_label);
            assert!(texts.contains(&panel.y_label), "{}: {}", figure.title, panel.y_label);
            let names = panel.series.iter().map(|s| &s.name);
            for name in names.chain(panel.marks.iter().map(|m| &m.name)).filter(|n| !n.is_empty()) {
                let listed = texts.iter().any(|text| text.starts_with(name));
                assert!(listed, "{}: {name} not in {texts:?}", figure.title);
            }
        }
    }
}

/// Boxes of all upright texts, with the width that a usual font needs at least.
fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let upright = |n: &roxmltree::Node<'_, '_>| {
        n.has_tag_name(("http://www.w3.org/2000/svg", "text")) && n.attribute("transform").is_none()
    };
    let one = |n: roxmltree::Node<'_, '_>| {
        let number = |name| n.attribute(name).unwrap().parse::<f64>().unwrap() / 10.0;
        let text = n.text().unwrap().trim().to_owned();
        let size = number("font-size");
        let width = 0.5 * size * text.chars().count() as f64;
        let left = match n.attribute("text-anchor").unwrap() {
            "start" => number("x"),
            "middle" => number("x") - 0.5 * width,
            _ => number("x") - width,
        };
        let top = number("y") - 0.5 * size;
        (text, [left, top, left + width, top + size])
    };
    document.descendants().filter(upright).map(one).collect()
}

#[test]
fn no_text_covers_another_or_leaves_the_sheet() {
    for figure in all() {
        for (w, h) in [(900, 700), (620, 640)] {
            let boxes = boxes(&figure.to_svg(w, h).unwrap());
            for (k, (text, a)) in boxes.iter().enumerate() {
                let inside = a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= f64::from(w) + 6.0;
                assert!(inside && a[3] <= f64::from(h), "{}: {text} {a:?}", figure.title);
                for (other, b) in &boxes[k + 1..] {
                    let apart = a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1];
                    assert!(apart, "{} {w}: `{text}` covers `{other}`", figure.title);
                }
            }
        }
    }
}

#[test]
fn panels_stacked_share_left_edges_and_time() {
    let svg = figures::drive(&traces(3000)).to_svg(900, 700).unwrap();
    let frames: Vec<_> = polylines(&svg)
        .into_iter()
        .filter(|p| p.len() == 5 && p[0] == p[4])
        .map(|p| (p[0].0, p[1].0))
        .collect();
    assert_eq!(frames.len(), 3);
    assert!(frames.windows(2).all(|w| w[0] == w[1]), "{frames:?}");
}

#[test]
fn legends_carry_the_fits_and_the_rms() {
    let svg = figures::comparison(&traces(3000), model().fits(), None).to_svg(900, 700);
    assert!(svg.unwrap().contains("identified (fit 81.2 %, validation 77.9 %)"));
    let mut run = track(0.0);
    run.cross_track_error_m = [0.3, -0.4].repeat(1000);
    let svg = figures::tracking_errors(&[("A", &run)]).to_svg(900, 700).unwrap();
    // √((0.09 + 0.16)/2)
    assert!(svg.contains("A: RMS 0.354 m"));
}

#[test]
fn white_noise_of_a_million_samples_stays_small() {
    let mut seed = 1;
    let mut panel = Panel::new("Time (s)", "Noise (1)");
    for k in 0..6 {
        let points = (0..200_000).map(|i| (f64::from(i), noise(&mut seed))).collect();
        let style = Style { dashed: k % 2 == 1, ..Style::line(palette::nth(k)) };
        panel = panel.with(Series::new(format!("noise {k}"), points, style));
    }
    let svg = Figure::new("Noise", vec![panel]).to_svg(1200, 700).unwrap();
    assert!(svg.len() < LIMIT, "{}", svg.len());
}

#[test]
fn a_series_torn_to_shreds_or_all_dots_stays_small() {
    let torn = (0..200_000).map(|i| (f64::from(i), if i % 3 == 0 { f64::NAN } else { 1.0 }));
    let dots = (0..200_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
    for (points, style) in
        [(torn.collect(), Style::line(palette::BLUE)), (dots, Style::dots(palette::BLUE))]
    {
        let panel = Panel::new("x", "y").with(Series::new("s", points, style));
        let svg = Figure::new("Shreds", vec![panel]).to_svg(900, 400).unwrap();
        assert!(svg.len() < LIMIT, "{}", svg.len());
    }
}

#[test]
fn a_value_that_is_no_number_is_a_gap() {
    let points = |gap: bool| {
        let y = |k: u32| if gap && k == 50 { f64::NAN } else { f64::from(k % 10) };
        (0..100).map(|k| (f64::from(k), y(k))).collect::<Vec<_>>()
    };
    let count = |gap| {
        let panel =
            Panel::new("x", "y").with(Series::new("", points(gap), Style::line(palette::BLUE)));
        let svg = Figure::new("Gap", vec![panel]).to_svg(600, 400).unwrap();
        assert!(!svg.contains("NaN"));
        polylines(&svg).len()
    };
    assert_eq!(count(true), count(false) + 1);
}

#[test]
fn nothing_to_draw_and_no_room_are_errors() {
    let empty = Figure::new("Empty", vec![Panel::new("x", "y")]);
    assert_eq!(empty.to_svg(900, 400), Err(Error::NoData { figure: "Empty".into(), panel: 1 }));
    let nan =
        Series::new("n", vec![(0.0, f64::NAN), (f64::INFINITY, 1.0)], Style::line(palette::BLUE));
    let full = Series::new("f", vec![(0.0, 1.0)], Style::line(palette::BLUE));
    let two = vec![Panel::new("x", "y").with(full.clone()), Panel::new("x", "y").with(nan.clone())];
    assert!(matches!(
        Figure::new("Two", two).to_svg(900, 600),
        Err(Error::NoData { panel: 2, .. })
    ));
    // One empty series next to a full one is no error.
    let panel = Panel::new("x", "y").with(full).with(nan);
    let figure = Figure::new("One", vec![panel]);
    assert!(figure.to_svg(900, 400).is_ok());
    for (w, h) in [(0, 0), (100, 100), (900, 60), (60, 900), (u32::MAX, 400), (900, u32::MAX)] {
        assert!(matches!(figure.to_svg(w, h), Err(Error::Size { .. })), "{w} {h}");
    }
    assert!(Figure::new("None", vec![]).to_svg(900, 400).is_ok());
}

#[test]
fn equal_aspect_makes_a_circle_round() {
    let circle = (0..=360).map(|k| f64::from(k).to_radians().sin_cos());
    let circle = circle.map(|(s, c)| (10.0 * c + 500.0, 10.0 * s)).collect();
    let mut panel =
        Panel::new("x (m)", "y (m)").with(Series::new("", circle, Style::line(palette::BLUE)));
    panel.equal_aspect = true;
    let svg = Figure::new("Circle", vec![panel]).to_svg(900, 400).unwrap();
    let longest = polylines(&svg).into_iter().max_by_key(Vec::len).unwrap();
    let extent = |f: fn(&(f64, f64)) -> f64| {
        let values = longest.iter().map(f);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let (w, h) = (extent(|p| p.0), extent(|p| p.1));
    assert!((w - h).abs() < 0.5 && w > 200.0, "{w} by {h}");
}

#[test]
fn markup_in_names_stays_text() {
    let evil = "</text><script>alert(1)</script>&\"'\u{0}\u{1b}";
    let panel = Panel::new(evil, evil)
        .with(Series::new(evil, vec![(0.0, 1.0), (1.0, 2.0)], Style::line(palette::BLUE)))
        .mark(Mark::new(evil, MarkPlace::XBand(0.0, 0.5), palette::GREY));
    let svg = Figure::new(evil, vec![panel]).to_svg(1200, 400).unwrap();
    let shown = texts(&svg);
    assert!(!svg.contains("<script"));
    assert!(
        shown.iter().filter(|t| t.starts_with("</text><script>alert(1)</script>&")).count() >= 4
    );
}

#[test]
fn a_simulation_that_runs_away_leaves_the_picture_and_not_the_axes() {
    let mut t = traces(3000);
    let grow = |k: usize| (k as f64 * 0.05).exp();
    t.simulated_yaw_rate_radps = (0..3000).map(grow).collect();
    let figure = figures::comparison(&t, model().fits(), None);
    let (low, high) = figure.panels[0].y_limits.unwrap();
    assert!(low > -100.0 && high < 100.0);
    for line in polylines(&figure.to_svg(900, 700).unwrap()) {
        assert!(line.iter().all(|p| (0.0..=900.0).contains(&p.0) && (0.0..=700.0).contains(&p.1)));
    }
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e3..1e3f64,
        1 => any::<f64>(),
        1 => Just(f64::NAN),
        1 => Just(0.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_numbers_crash_it(
        points in prop::collection::vec((any_value(), any_value()), 0..60),
        mark in (any_value(), any_value()),
        logs in any::<(bool, bool)>(),
        flags in any::<(bool, bool)>(),
        limits in prop::option::of((any_value(), any_value())),
        name in "\\PC{0,80}",
    ) {
        let style = Style { dashed: flags.0, ..Style::dots(palette::BLUE) };
        let mut panel = Panel::new("x", "y")
            .with(Series::new(name.clone(), points, style))
            .mark(Mark::new(name.clone(), MarkPlace::XBand(mark.0, mark.1), palette::GREY))
            .mark(Mark::new(name.clone(), MarkPlace::YBand(mark.1, mark.0), palette::GREY))
            .mark(Mark::new(name.clone(), MarkPlace::XLine(mark.0), palette::GREY))
            .mark(Mark::new(name.clone(), MarkPlace::YLine(mark.1), palette::GREY));
        (panel.x_log, panel.y_log) = logs;
        panel.equal_aspect = flags.1;
        panel.y_limits = limits;
        match Figure::new(name, vec![panel]).to_svg(700, 500) {
            Ok(svg) => {
                roxmltree::Document::parse(&svg).unwrap();
                prop_assert!(svg.len() < LIMIT);
            }
            Err(error) => {
                let expected = matches!(error, Error::NoData { .. } | Error::Size { .. });
                prop_assert!(expected, "{}", error);
            }
        }
    }
}
