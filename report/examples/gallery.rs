//! Draws every figure and the report from made-up data: `cargo run -p steerwright-report --example gallery DIR`.

#[path = "../tests/common/mod.rs"]
mod common;

use steerwright_report::figures::{Driven, Simulated};
use steerwright_report::{Controller, LoopStep, Report, figures};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dir = std::path::PathBuf::from(std::env::args().nth(1).ok_or("name a folder")?);
    std::fs::create_dir_all(&dir)?;
    let (traces, plant, path) = (common::traces(30_000), common::plant(), common::path());
    let (good, bad) = (common::pid(true), common::pid(false));
    let step = common::step(1.0);
    let (near, far) = (common::track(0.21), common::track(0.55));
    let tracks = [("identified model", &near), ("bicycle model", &far)];
    let e = &plant.evidence;
    let model = common::model();
    let s = &good.specification;
    let driven = Driven {
        time_s: &traces.time_s,
        yaw_rate_radps: &traces.yaw_rate_radps,
        yaw_rad: &traces.yaw_rad,
    };
    let simulated = ["identified model", "bicycle model"].map(|name| Simulated {
        name,
        fit: e.fit.validation,
        yaw_rate_radps: &traces.simulated_yaw_rate_radps,
        yaw_rad: &traces.simulated_yaw_rad,
    });
    let (points, largest) = (&path.points, good.largest_angle_rad());
    let title = "Controller along the road";
    let mut all = figures::of_identification(&model, &traces, Some(61.0));
    all.extend([
        ("step", 700, figures::yaw_step("Yaw step", &step, s, &good.evidence.step, largest)),
        (
            "road",
            figures::road_height(900, points, &tracks),
            figures::reference_road(points, false, &tracks),
        ),
        ("errors", 660, figures::tracking_errors(&tracks)),
        ("models", 1000, figures::models_against_drive(driven, &simulated)),
        ("curvature", 600, figures::road_and_curvature(points, false, path.speed_mps)),
        ("tracking", 1080, figures::tracking(title, points, false, &tracks)),
    ]);
    for (name, height, figure) in all {
        let svg = figure.to_svg(900, height)?;
        println!("{name}: {} bytes", svg.len());
        std::fs::write(dir.join(format!("{name}.svg")), svg)?;
    }
    let bicycle = common::bicycle();
    let page = Report {
        title: "From a drive to a steering controller".into(),
        model: Some(&model),
        traces: Some(&traces),
        channels: None,
        bicycle: Some(&bicycle),
        bicycle_fit: Some(61.0),
        controllers: vec![
            Controller {
                name: "identified model",
                pid: &good,
                in_loop: Some(LoopStep {
                    plant: "the identified plant",
                    response: &step,
                    metrics: &good.evidence.step,
                }),
            },
            Controller { name: "bicycle model", pid: &bad, in_loop: None },
        ],
        path: Some(&path),
        tracks: tracks.to_vec(),
        remarks: vec!["the road needs 0.37 rad/s of steering rate at 212 m".into()],
        files: plant.provenance.sources.clone(),
    }
    .to_html();
    println!("report: {} bytes", page.len());
    std::fs::write(dir.join("report.html"), page)?;
    Ok(())
}
