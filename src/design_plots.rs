//! Bode, Nyquist and step plots of a design.

use crate::failure::Failure;
use crate::output::Files;
use std::path::Path;
use steerwright_control::DesignPlant;
use steerwright_formats::Pid;
use steerwright_report::figures::{self, OpenLoop};
use steerwright_report::{Figure, StepResponse, WIDTH};

/// Points of the loop's frequency response.
const POINTS: usize = 600;

/// Names of the files.
pub(crate) const NAMES: [&str; 4] = ["bode.svg", "nyquist.svg", "step.svg", "step-with-offset.svg"];

/// Writes the plots; where they are.
pub(crate) fn write<'a>(
    files: &'a Files,
    plant: &DesignPlant,
    pid: &Pid,
) -> Result<Vec<&'a Path>, Failure> {
    let points = steerwright_control::loop_response(plant, pid, POINTS)?;
    let open = OpenLoop {
        frequency_hz: points.iter().map(|p| p.frequency_hz).collect(),
        real: points.iter().map(|p| p.real).collect(),
        imaginary: points.iter().map(|p| p.imaginary).collect(),
        margins: pid.evidence.margins,
        required_modulus_margin: pid.specification.modulus_margin,
    };
    let until = pid.specification.settling_time_s.unwrap_or(1.0);
    let until = (3.0 * until).min(pid.specification.steady_state_time_s);
    let step = |with_offset: bool, until: f64| -> Result<StepResponse, Failure> {
        let trace = steerwright_control::step_response(plant, pid, with_offset, until)?;
        Ok(StepResponse { time_s: trace.time, yaw_rad: trace.yaw, steering_rad: trace.steering })
    };
    let s = &pid.specification;
    let figure = |title: &str, response: &StepResponse, reached| {
        figures::yaw_step(title, response, s, reached, pid.largest_angle_rad())
    };
    let e = &pid.evidence;
    let [bode, nyquist, plain, offset] = NAMES;
    let all: [(&str, Figure, u32); 4] = [
        (bode, figures::bode(&open), 620),
        (nyquist, figures::nyquist(&open), 620),
        (plain, figure("Yaw step on the model", &step(false, until)?, &e.step), 680),
        (
            offset,
            figure(
                "Yaw step on the model with a steering offset",
                &step(true, s.steady_state_time_s)?,
                &e.step_with_offset,
            ),
            680,
        ),
    ];
    all.iter()
        .map(|(name, figure, height)| files.write(name, figure.to_svg(WIDTH, *height)?.as_bytes()))
        .collect()
}
