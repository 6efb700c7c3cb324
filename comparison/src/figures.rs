//! The figures of a comparison.

use crate::compare::Comparison;
use crate::runs::ComparedRun;
use steerwright_report::figures::{self, Driven, Simulated, YawStep};
use steerwright_report::{Figure, Track, WIDTH};

/// A figure with the name of its file, its height at the usual width, and what it shows.
pub(crate) struct Drawn {
    pub(crate) name: String,
    pub(crate) figure: Figure,
    pub(crate) height: u32,
    pub(crate) caption: String,
}

/// The figures, in the paper's order.
pub(crate) fn all(c: &Comparison) -> Vec<Drawn> {
    let mut all: Vec<Drawn> = drive(c).into_iter().collect();
    let (points, closed) = (&c.road.points, c.road.closed);
    let plane = figures::road_height(WIDTH, points, &[]);
    all.push(Drawn {
        name: "fig5-road".into(),
        figure: figures::road_and_curvature(points, closed, c.road.speed_mps),
        height: plane.min(420) + 250,
        caption: "After the paper's Fig. 5. The plane has the same scale on both axes.".into(),
    });
    for (index, controller) in c.controllers.iter().enumerate() {
        let runs: Vec<&ComparedRun> =
            (0..c.plants.len()).map(|plant| c.run(index, plant)).collect();
        let names: Vec<String> = runs.iter().map(|run| plant_legend(c, run)).collect();
        let tracks: Vec<(&str, &Track)> =
            names.iter().zip(&runs).map(|(name, run)| (name.as_str(), &run.track)).collect();
        let title = format!("Controller of {} along the road", controller.label);
        all.push(Drawn {
            name: format!("fig6-7-{}", file_name(&controller.label)),
            figure: figures::tracking(&title, points, closed, &tracks),
            height: 1080,
            caption: format!(
                "After the paper's Fig. 6 and 7: {} designed on {}, on the plant of each model{}. \
                 Positive errors are to the left. In a bend a part of the yaw error is sideslip, \
                 which no controller can remove.",
                controller.pid.name,
                c.models[controller.model].label,
                if c.truth().is_some() { " and on the truth" } else { "" }
            ),
        });
    }
    all.push(steps(c));
    all
}

fn drive(c: &Comparison) -> Option<Drawn> {
    let drive = c.drive.as_ref()?;
    let driven = Driven {
        time_s: &drive.time_s,
        yaw_rate_radps: &drive.yaw_rate_radps,
        yaw_rad: &drive.yaw_rad,
    };
    let models: Vec<Simulated<'_>> = c
        .models
        .iter()
        .zip(&drive.models)
        .map(|(model, on)| Simulated {
            name: &model.label,
            fit: on.fit_percent,
            yaw_rate_radps: &on.yaw_rate_radps,
            yaw_rad: &on.yaw_rad,
        })
        .collect();
    Some(Drawn {
        name: "fig3-drive".into(),
        figure: figures::models_against_drive(driven, &models),
        height: 1000,
        caption: format!(
            "After the paper's Fig. 3: {}, {} s of validation data at its end, every {} s. The \
             steering is the only input of the models; yaw is the integral of the yaw rate from the \
             start of the validation data, so that a constant error of the yaw rate drifts.",
            drive.name,
            (drive.samples as f64 * drive.sample_time_s).round(),
            drive.sample_time_s
        ),
    })
}

/// The yaw step of every controller: predicted, and on the truth or on the other plants.
fn steps(c: &Comparison) -> Drawn {
    let truth = c.truth();
    let wanted = |run: &&ComparedRun| truth.is_none_or(|truth| c.is_own(run) || run.plant == truth);
    let runs: Vec<(String, &ComparedRun)> = c
        .runs
        .iter()
        .filter(wanted)
        .map(|run| {
            let controller = &c.controllers[run.controller].label;
            (format!("{controller} {}", plant_legend(c, run)), run)
        })
        .collect();
    let steps: Vec<YawStep<'_>> = runs
        .iter()
        .map(|(name, run)| YawStep {
            name,
            rank: run.controller,
            predicted: c.is_own(run),
            response: &run.response,
        })
        .collect();
    let specification = c.controllers.first().map(|k| &k.pid.specification);
    let height = specification.map_or(0.0, |s| s.step_rad);
    let settling = specification.and_then(|s| s.settling_time_s).unwrap_or(1.0);
    Drawn {
        name: "steps".into(),
        figure: figures::yaw_steps(height, 2.0 * settling, &steps),
        height: 640,
        caption: "The specification's yaw step in the loop of the FMUs: on the plant that the \
                  controller was designed on (dashed), and on the other plants."
            .into(),
    }
}

/// The plant of a run, for a legend.
fn plant_legend(c: &Comparison, run: &ComparedRun) -> String {
    if c.is_own(run) {
        "on its own model".into()
    } else {
        format!("on {}", c.plants[run.plant].label)
    }
}

/// A label as a part of a file's name.
pub(crate) fn file_name(label: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let name: String = label.chars().map(|c| if plain(c) { c } else { '-' }).collect();
    name.trim_matches('-').replace("--", "-")
}
