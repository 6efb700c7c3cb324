//! `steerwright design`: a PID controller to a specification.

use crate::failure::{Failure, Outcome};
use crate::tell::Tell;
use crate::{files, quantity};
use control::{DesignOptions, DesignPlant};
use formats::{Bicycle, Document, Pid, Plant, SourceFile, StepMetrics};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Design a PID steering controller (eq 14) on a plant or bicycle file
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// plant.json or bicycle.json
    #[arg(value_name = "PLANT.json")]
    plant: PathBuf,
    /// Write the controller here
    #[arg(long = "out", short = 'o', value_name = "FILE", default_value = "pid.json")]
    out: PathBuf,
    /// Print the controller as JSON on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    specification: SpecificationArguments,
}

/// What the controller must reach, on a 5° yaw step.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Specification")]
pub(crate) struct SpecificationArguments {
    /// Largest overshoot
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent, default_value = "1%")]
    overshoot: f64,
    /// Longest settling time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "1s")]
    settling: f64,
    /// Largest steady-state error, also with a steering offset of 1° at the road wheel
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent, default_value = "2%")]
    steady_state_error: f64,
    /// Largest steering angle in steering coordinates; by default 22deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_angle: Option<f64>,
    /// Largest change of the steering angle in a sample; by default 15deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_increment: Option<f64>,
    /// Largest rate of the steering angle; by default what the increment allows
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    max_rate: Option<f64>,
    /// The controller's sample time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "10ms")]
    pid_sample_time: f64,
    /// Delay of the loop beyond the plant's own: 0 under a Gauss–Seidel master, a sample under Jacobi
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time, default_value = "0s")]
    loop_delay: f64,
    /// Smallest distance of the loop from −1
    #[arg(long, value_name = "MARGIN", allow_hyphen_values = true, default_value = "0.5")]
    modulus_margin: f64,
}

impl SpecificationArguments {
    /// The options of the design.
    pub(crate) fn options(&self) -> DesignOptions {
        DesignOptions {
            overshoot_percent: self.overshoot,
            settling_time_s: self.settling,
            steady_state_error_percent: self.steady_state_error,
            max_angle_rad: self.max_angle,
            max_increment_rad: self.max_increment,
            max_rate_radps: self.max_rate,
            sample_time_s: self.pid_sample_time,
            loop_delay_s: self.loop_delay,
            modulus_margin: self.modulus_margin,
            ..DesignOptions::default()
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let (plant, source) = read_plant(&arguments.plant)?;
    let pid = control::design(&plant, &source, &arguments.specification.options())?;
    files::write_document(&arguments.out, &pid)?;
    let text = format!("{}\nwritten to {}", summary(&pid), arguments.out.display());
    Tell::new(arguments.json).result(&text, &pid)?;
    Ok(if pid.evidence.met { Outcome::Done } else { Outcome::RequirementNotMet })
}

/// The model in a plant or bicycle file.
fn read_plant(path: &Path) -> Result<(DesignPlant, SourceFile), Failure> {
    let text = files::read_text(path)?;
    let source = SourceFile::of(path, text.as_bytes());
    let file = path.display().to_string();
    // A bicycle of any version, so that another one is refused as such.
    let bicycle = "steerwright/bicycle/";
    let plant = match formats::schema_of(&text) {
        Some(schema) if schema.starts_with(bicycle) => {
            DesignPlant::from_bicycle(&Bicycle::from_json(&text, &file)?)
        }
        _ => DesignPlant::from_plant(&Plant::from_json(&text, &file)?),
    };
    Ok((plant.map_err(|e| Failure::in_file(path, &e, e.hint()))?, source))
}

/// Gains, requirements and margins, for people.
pub(crate) fn summary(pid: &Pid) -> String {
    let g = &pid.gains;
    let s = &pid.specification;
    let e = &pid.evidence;
    let mut text = format!(
        "designed on {} {} at {:.1} m/s\n\
         gains    kp {:.4}, ki {:.4} 1/s, kd {:.4} s, filter {:.4} s, weights {:.3} and {:.3}\n\n",
        pid.designed_for.model,
        pid.designed_for.name,
        pid.designed_for.speed_mps,
        g.kp,
        g.ki,
        g.kd,
        g.derivative_filter_time_s,
        g.setpoint_weight_proportional,
        g.setpoint_weight_derivative
    );
    let mut table = report::Table::new(["requirement", "at most", "on the step", "with 1° offset"]);
    let settling =
        |m: &StepMetrics| m.settling_time_s.map_or_else(|| "never".into(), |t| format!("{t:.3} s"));
    table = table.row([
        "overshoot".into(),
        format!("{} %", s.overshoot_percent),
        format!("{:.3} %", e.step.overshoot_percent),
        String::new(),
    ]);
    table = table.row([
        "settling time".into(),
        format!("{} s", s.settling_time_s),
        settling(&e.step),
        String::new(),
    ]);
    table = table.row([
        format!("error at {} s", s.steady_state_time_s),
        format!("{} %", s.steady_state_error_percent),
        format!("{:.3} %", e.step.steady_state_error_percent),
        format!("{:.3} %", e.step_with_offset.steady_state_error_percent),
    ]);
    let _ = writeln!(text, "{table}");
    let unlimited = |value: Option<f64>, unit: &str, digits: usize| {
        value.map_or_else(|| "unlimited".into(), |v| format!("{v:.digits$}{unit}"))
    };
    let m = &e.margins;
    let _ = writeln!(
        text,
        "margins  modulus {:.3} (at least {}), gain {}, phase {}, delay {}",
        m.modulus_margin,
        s.modulus_margin,
        unlimited(m.gain_margin_db, " dB", 1),
        unlimited(m.phase_margin_deg, "°", 1),
        unlimited(m.delay_margin_s, " s", 3)
    );
    if e.met {
        text.push_str("every requirement is met");
    }
    for shortfall in &e.shortfalls {
        let _ = writeln!(
            text,
            "not met: {} is {:.4}, required {:.4}",
            shortfall.requirement, shortfall.reached, shortfall.required
        );
    }
    text
}
