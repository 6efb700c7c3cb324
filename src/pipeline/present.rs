//! Figures and the report of a build.

use super::{Built, PAGE, RECORDED_ROAD, STANDARD_ROAD, Writer};
use crate::failure::Failure;
use steerwright_formats::Bicycle;
use steerwright_report::figures::{self, road_height};
use steerwright_report::{Figure, Report, Traces, Track, WIDTH};

/// Writes the figures as SVG files, and the report.
pub(super) fn write(
    out: &mut Writer,
    built: &Built,
    bicycle: Option<&Bicycle>,
    traces: &Traces,
) -> Result<(), Failure> {
    let model = &built.model;
    let mut draw = |name: &str, figure: &Figure, height: u32| -> Result<(), Failure> {
        let svg = figure.to_svg(WIDTH, height)?;
        out.bytes(&format!("figures/{name}.svg"), svg.as_bytes()).map(|_| ())
    };
    for (name, height, figure) in figures::of_identification(model, traces, built.bicycle_fit) {
        draw(name, &figure, height)?;
    }
    for c in &built.controllers {
        let title = format!("Yaw step, {} controller, loop of the FMUs", c.basis.name());
        let (s, largest) = (&c.pid.specification, c.pid.largest_angle_rad());
        let figure = figures::yaw_step(&title, &c.step, s, &c.step_metrics, largest);
        draw(&format!("step{}", c.basis.suffix()), &figure, 680)?;
    }
    for (road, suffix) in [(STANDARD_ROAD, ""), (RECORDED_ROAD, "-recorded")] {
        let tracks = tracks(built, road);
        let run = built.controllers.iter().flat_map(|c| &c.runs).find(|r| r.road == road);
        if let Some(run) = run {
            let height = road_height(WIDTH, &run.path.points, &tracks);
            let figure = figures::reference_road(&run.path.points, run.path.closed, &tracks);
            draw(&format!("road{suffix}"), &figure, height)?;
            draw(&format!("errors{suffix}"), &figures::tracking_errors(&tracks), 660)?;
        }
    }

    let mut page = built.report();
    (page.traces, page.bicycle, page.files) = (Some(traces), bicycle, out.written().to_vec());
    out.bytes(PAGE, page.to_html().as_bytes())?;
    Ok(())
}

impl Built {
    /// What is shown, but for the drive's signals and what is only in files.
    pub(crate) fn report(&self) -> Report<'_> {
        Report {
            title: format!("{}: from drive to controller", self.model.name()),
            model: Some(&self.model),
            bicycle_fit: self.bicycle_fit,
            controllers: self.controllers.iter().map(super::Controller::shown).collect(),
            path: self
                .controllers
                .iter()
                .flat_map(|c| &c.runs)
                .find(|r| r.road == STANDARD_ROAD)
                .map(|r| &r.path),
            tracks: tracks(self, STANDARD_ROAD),
            remarks: self.remarks.clone(),
            ..Report::default()
        }
    }
}

impl super::Controller {
    /// The controller with its step in the loop of the FMUs.
    pub(crate) fn shown(&self) -> steerwright_report::Controller<'_> {
        steerwright_report::Controller {
            name: self.basis.name(),
            pid: &self.pid,
            in_loop: Some(steerwright_report::LoopStep {
                plant: "the identified plant",
                response: &self.step,
                metrics: &self.step_metrics,
            }),
        }
    }
}

/// The runs of all controllers along one road, by the controller's name.
fn tracks<'a>(built: &'a Built, road: &str) -> Vec<(&'a str, &'a Track)> {
    let run = |c: &'a super::Controller| c.runs.iter().find(|r| r.road == road);
    built.controllers.iter().filter_map(|c| Some((c.basis.name(), &run(c)?.track))).collect()
}
