//! What is shown of documents in memory, for the Python package: figures, pages, and notebooks.

use crate::commands::design as design_command;
use crate::failure::Failure;
use steerwright_control::DesignPlant;
use steerwright_formats::{
    Document, Manoeuvre, Model, Path as PathFile, Pid, SpeedController, schema_of,
};
use steerwright_report::figures;
use steerwright_report::{
    Block, Controller, Report, Section, WIDTH, controller_section, manoeuvre_sections,
    notebook_html, speed_controller_section,
};
use steerwright_sysid::Traces;

/// The figures of an identified model as SVG, by name.
///
/// # Errors
/// A document that is no model.
pub fn figures_of_model(document: &str, traces: &Traces) -> Result<Vec<(String, String)>, Failure> {
    let model = Model::from_json(document, "the model")?;
    let drawn = figures::of_identification(&model, &drawn_traces(traces), None);
    let figures = drawn.into_iter().filter_map(|(name, height, figure)| {
        // A short log leaves some of them empty.
        Some((name.to_owned(), figure.to_svg(WIDTH, height).ok()?))
    });
    Ok(figures.collect())
}

/// The figures of a controller on its model as SVG, by name.
///
/// # Errors
/// Documents that are none, or a loop that cannot be evaluated.
pub fn figures_of_controller(
    document: &str,
    controller: &str,
) -> Result<Vec<(String, String)>, Failure> {
    let plant = DesignPlant::from_model(&Model::from_json(document, "the model")?)?;
    let pid = Pid::from_json(controller, "pid.json")?;
    let drawn = design_command::figures(&plant, &pid)?;
    let figures = drawn.into_iter().filter_map(|(name, figure, height)| {
        Some((name.trim_end_matches(".svg").to_owned(), figure.to_svg(WIDTH, height).ok()?))
    });
    Ok(figures.collect())
}

/// A document for a notebook, HTML; a steering controller with its figures where its model is there, and a model with
/// those of its signals.
///
/// # Errors
/// Documents that are none, or a loop that cannot be evaluated.
pub fn notebook(
    document: &str,
    model: Option<&str>,
    traces: Option<&Traces>,
) -> Result<String, Failure> {
    let sections = match schema_of(document).as_deref() {
        Some(SpeedController::SCHEMA) => {
            vec![speed_controller_section(&SpeedController::from_json(document, "the text")?)]
        }
        Some(Manoeuvre::SCHEMA) => manoeuvre_sections(&Manoeuvre::from_json(document, "the text")?),
        Some(Pid::SCHEMA) => {
            vec![section_of_controller(&Pid::from_json(document, "the text")?, model)?]
        }
        Some(PathFile::SCHEMA) => {
            let path = PathFile::from_json(document, "the text")?;
            Report { path: Some(&path), ..Report::default() }.sections()
        }
        _ => {
            let model = Model::from_json(document, "the model")?;
            let traces = traces.map(drawn_traces);
            Report { model: Some(&model), traces: traces.as_ref(), ..Report::default() }.sections()
        }
    };
    Ok(notebook_html(&sections))
}

fn section_of_controller(pid: &Pid, model: Option<&str>) -> Result<Section, Failure> {
    let mut section = controller_section(&Controller { name: &pid.name, pid, in_loop: None });
    if let Some(model) = model {
        let plant = DesignPlant::from_model(&Model::from_json(model, "the model")?)?;
        let figures = design_command::figures(&plant, pid)?.into_iter();
        section.blocks.extend(figures.map(|(_, figure, height)| Block::figure(figure, height, "")));
    }
    Ok(section)
}

/// The page of an identified model, as `identify --report` writes it.
///
/// # Errors
/// A document that is no model.
pub fn page_of_model(document: &str, traces: &Traces) -> Result<String, Failure> {
    let model = Model::from_json(document, "the model")?;
    let traces = drawn_traces(traces);
    let page = Report {
        title: format!("{}: the identified model", model.name()),
        model: Some(&model),
        traces: Some(&traces),
        ..Report::default()
    };
    Ok(page.to_html())
}

fn drawn_traces(traces: &Traces) -> steerwright_report::Traces {
    let Traces {
        time_s,
        steering_rad,
        yaw_rate_radps,
        simulated_yaw_rate_radps,
        is_validation,
        yaw_rad,
        simulated_yaw_rad,
    } = traces.clone();
    steerwright_report::Traces {
        time_s,
        steering_rad,
        yaw_rate_radps,
        simulated_yaw_rate_radps,
        is_validation,
        yaw_rad,
        simulated_yaw_rad,
        bicycle_yaw_rate_radps: None,
    }
}
