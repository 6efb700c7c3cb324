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
    for (name, figure, height) in [
        ("drive", figures::drive(&traces), 640),
        ("comparison", figures::comparison(&traces, &e.fit, Some(61.0)), 720),
        ("coherence", figures::coherence(&e.excitation), 330),
        ("orders", figures::order_table(&e.order_table, 2), 320),
        ("prediction", figures::prediction(e.held_out.as_ref().ok_or("validation")?), 280),
        ("residuals", figures::residuals(e.residuals.as_ref().ok_or("residuals")?, 0.05), 320),
        (
            "frequency-response",
            figures::frequency_response(
                e.frequency_response.as_ref().ok_or("response")?,
                plant.input,
            ),
            760,
        ),
        ("poles", figures::poles_and_zeros(e.poles_and_zeros.as_ref().ok_or("poles")?), 440),
        (
            "step",
            figures::yaw_step(
                "Yaw step of 5 deg",
                &step,
                s,
                &good.evidence.step,
                good.largest_angle_rad(),
            ),
            700,
        ),
        (
            "road",
            figures::reference_road(&path.points, false, &tracks),
            figures::road_height(900, &path.points, &tracks),
        ),
        ("errors", figures::tracking_errors(&tracks), 660),
        ("models", figures::models_against_drive(driven, &simulated), 1000),
        ("curvature", figures::road_and_curvature(&path.points, false, path.speed_mps), 600),
        (
            "tracking",
            figures::tracking("Controller along the road", &path.points, false, &tracks),
            1080,
        ),
    ] {
        let svg = figure.to_svg(900, height)?;
        println!("{name}: {} bytes", svg.len());
        std::fs::write(dir.join(format!("{name}.svg")), svg)?;
    }
    let bicycle = common::bicycle();
    let page = Report {
        title: "From a drive to a steering controller".into(),
        plant: Some(&plant),
        traces: Some(&traces),
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
        files: plant.provenance.sources.clone(),
    }
    .to_html();
    println!("report: {} bytes", page.len());
    std::fs::write(dir.join("report.html"), page)?;
    Ok(())
}
