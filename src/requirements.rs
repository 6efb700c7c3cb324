//! What a controller is asked for: flags, and a TOML file with the same names, which the flags
//! override.
//!
//! ```toml
//! overshoot = "1%"
//! settling = "1s"
//! modulus-margin = 0.5
//! max-rate = "23deg/s"
//! ```

use crate::failure::Failure;
use crate::{files, quantity};
use control::{DesignOptions, RobustOptions};
use formats::Specification;
use std::path::{Path, PathBuf};

/// A requirement's value, or `none` for one that is not asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Asked(Option<f64>);

fn or_none(parse: fn(&str) -> Result<f64, String>, text: &str) -> Result<Asked, String> {
    if text.trim() == "none" { Ok(Asked(None)) } else { parse(text).map(|v| Asked(Some(v))) }
}

fn percent(text: &str) -> Result<Asked, String> {
    or_none(quantity::percent, text)
}

fn time(text: &str) -> Result<Asked, String> {
    or_none(quantity::time, text)
}

fn decibel(text: &str) -> Result<Asked, String> {
    or_none(quantity::decibel, text)
}

fn phase(text: &str) -> Result<Asked, String> {
    // Phases are kept in degrees, as everybody writes them.
    or_none(|text| quantity::angle(text).map(f64::to_degrees), text)
}

fn plain(text: &str) -> Result<Asked, String> {
    or_none(quantity::plain, text)
}

/// How FMUs wait for each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MasterName {
    /// Plant, estimator, path and controller one after the other: no loop has a delay
    GaussSeidel,
    /// All at once: the yaw loop is late by a sample, that through the path by two, through the
    /// estimator by three
    Jacobi,
}

/// What the controller must reach, on a 5° yaw step.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Specification")]
pub(crate) struct SpecificationArguments {
    /// Read the specification from a file with these names, such as `settling = "1s"`; without a
    /// file 1% overshoot, 1s settling, 2% error and a modulus margin of 0.5 are asked for. A flag
    /// overrides the file, and `none` takes a requirement back
    #[arg(long, value_name = "SPEC.toml")]
    requirements: Option<PathBuf>,
    /// Largest overshoot
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = percent)]
    overshoot: Option<Asked>,
    /// Longest settling time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time)]
    settling: Option<Asked>,
    /// Largest steady-state error: on the step, with a steering offset of 1° at the road wheel, and on
    /// a curve of constant curvature with feedforward
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = percent)]
    steady_state_error: Option<Asked>,
    /// Longest rise time, 10 to 90 %
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time)]
    rise_time: Option<Asked>,
    /// Largest integral of absolute error (IAE) of the step, divided by its height
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time)]
    iae: Option<Asked>,
    /// Smallest gain margin, such as 6dB
    #[arg(long, value_name = "GAIN", allow_hyphen_values = true, value_parser = decibel)]
    gain_margin: Option<Asked>,
    /// Smallest phase margin
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = phase)]
    phase_margin: Option<Asked>,
    /// Smallest distance of the loop from −1
    #[arg(long, value_name = "MARGIN", allow_hyphen_values = true, value_parser = plain)]
    modulus_margin: Option<Asked>,
    /// Smallest further delay that makes the loop unstable
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time)]
    delay_margin: Option<Asked>,
    /// Smallest disk margin with zero skew
    #[arg(long, value_name = "MARGIN", allow_hyphen_values = true, value_parser = plain)]
    disk_margin: Option<Asked>,
    /// Band within which the response has settled; by default the steady-state error, or 2%
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    settling_band: Option<f64>,
    /// Largest steering angle in steering coordinates; by default 22deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_angle: Option<f64>,
    /// Largest change of the steering angle in a sample; by default 15deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = quantity::angle)]
    max_increment: Option<f64>,
    /// Largest rate of the steering angle that the actuator follows; by default twice the fastest steering
    /// of the drive, and a model without a drive needs it
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    max_rate: Option<f64>,
    /// Largest lateral acceleration that the steering angle may ask for, which bounds it at each speed
    /// [default: 6m/s2]
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true, value_parser = quantity::acceleration)]
    max_lateral_acceleration: Option<f64>,
    /// The controller's sample time [default: 10ms]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    pid_sample_time: Option<f64>,
    /// The master that the loop is designed for [default: gauss-seidel]
    #[arg(long, value_enum)]
    master: Option<MasterName>,
    /// Measured latency of every loop, beyond the model's own and the master's
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    latency: Option<f64>,
    /// Further delay of the yaw loop
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    loop_delay: Option<f64>,
    /// Further delay of the loop through the path; by default the yaw loop's
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    path_delay: Option<f64>,
    /// Further delay of the loop through pose estimator and path; by default the path's
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    estimator_delay: Option<f64>,
    /// Hold the gains against the plants within the identified uncertainty, other latencies, and
    /// other speeds where the model holds there [default: on]. What they do not all keep is advice, and
    /// where `on` is written a requirement that is not met
    #[arg(long, value_enum)]
    robust: Option<Switch>,
    /// Latency to either side that must change nothing; by default 30ms where a latency is stated,
    /// a sample elsewhere
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    latency_spread: Option<f64>,
    /// Speed to either side that must change nothing, where the model holds there [default: 20%]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    speed_spread: Option<f64>,
    /// Plants drawn from the identified uncertainty [default: 100]
    #[arg(long, value_name = "N")]
    ensemble: Option<usize>,
    /// Names the starting points and the plants drawn [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Switch {
    On,
    Off,
}

/// Delays as stated, before they are added up.
#[derive(Debug, Clone, Copy, Default)]
struct Stated {
    jacobi: bool,
    latency: f64,
    yaw: f64,
    path: Option<f64>,
    estimator: Option<f64>,
    spread: Option<f64>,
    band: Option<f64>,
}

type Key = (&'static str, fn(&str) -> Result<Asked, String>, Setter);
type Setter = fn(&mut DesignOptions, &mut Stated, Option<f64>);

fn time_only(text: &str) -> Result<Asked, String> {
    quantity::time(text).map(|v| Asked(Some(v)))
}

fn acceleration_only(text: &str) -> Result<Asked, String> {
    quantity::acceleration(text).map(|v| Asked(Some(v)))
}

fn percent_only(text: &str) -> Result<Asked, String> {
    quantity::percent(text).map(|v| Asked(Some(v)))
}

fn master(text: &str) -> Result<Asked, String> {
    match text {
        "gauss-seidel" => Ok(Asked(Some(0.0))),
        "jacobi" => Ok(Asked(Some(1.0))),
        _ => Err("`gauss-seidel` or `jacobi` is expected".into()),
    }
}

/// The names of the file: those of the flags.
const KEYS: &[Key] = &[
    ("overshoot", percent, |o, _, v| o.requirements.overshoot_percent = v),
    ("settling", time, |o, _, v| o.requirements.settling_time_s = v),
    ("steady-state-error", percent, |o, _, v| o.requirements.steady_state_error_percent = v),
    ("rise-time", time, |o, _, v| o.requirements.rise_time_s = v),
    ("iae", time, |o, _, v| o.requirements.integral_absolute_error_s = v),
    ("gain-margin", decibel, |o, _, v| o.requirements.gain_margin_db = v),
    ("phase-margin", phase, |o, _, v| o.requirements.phase_margin_deg = v),
    ("modulus-margin", plain, |o, _, v| o.requirements.modulus_margin = v),
    ("delay-margin", time, |o, _, v| o.requirements.delay_margin_s = v),
    ("disk-margin", plain, |o, _, v| o.requirements.disk_margin = v),
    ("settling-band", percent_only, |_, s, v| s.band = v),
    ("max-angle", |t| or_none(quantity::angle, t), |o, _, v| o.max_angle_rad = v),
    ("max-increment", |t| or_none(quantity::angle, t), |o, _, v| o.max_increment_rad = v),
    ("max-rate", |t| or_none(quantity::angle_rate, t), |o, _, v| o.max_rate_radps = v),
    ("max-lateral-acceleration", acceleration_only, |o, _, v| {
        o.max_lateral_acceleration_mps2 = v.unwrap_or(o.max_lateral_acceleration_mps2);
    }),
    ("pid-sample-time", time_only, |o, _, v| o.sample_time_s = v.unwrap_or(o.sample_time_s)),
    ("master", master, |_, s, v| s.jacobi = v == Some(1.0)),
    ("latency", time_only, |_, s, v| s.latency = v.unwrap_or(0.0)),
    ("loop-delay", time_only, |_, s, v| s.yaw = v.unwrap_or(0.0)),
    ("path-delay", time_only, |_, s, v| s.path = v),
    ("estimator-delay", time_only, |_, s, v| s.estimator = v),
    ("latency-spread", time_only, |_, s, v| s.spread = v),
];

impl SpecificationArguments {
    /// The files that are read.
    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.requirements.iter()
    }

    /// Whether a design that not all plants keep is none: `--robust on` was written, not only meant.
    pub(crate) fn must_be_robust(&self) -> bool {
        self.robust == Some(Switch::On)
    }

    /// The options of the design.
    pub(crate) fn options(&self) -> Result<DesignOptions, Failure> {
        let mut options = DesignOptions::default();
        let mut stated = Stated::default();
        if let Some(file) = &self.requirements {
            options.requirements = Specification::none();
            read(file, &mut options, &mut stated)?;
        }
        let asked = |v: Option<f64>| v.map(|v| Asked(Some(v)));
        let flags = [
            self.overshoot,
            self.settling,
            self.steady_state_error,
            self.rise_time,
            self.iae,
            self.gain_margin,
            self.phase_margin,
            self.modulus_margin,
            self.delay_margin,
            self.disk_margin,
            asked(self.settling_band),
            asked(self.max_angle),
            asked(self.max_increment),
            asked(self.max_rate),
            asked(self.max_lateral_acceleration),
            asked(self.pid_sample_time),
            self.master.map(|m| Asked(Some(f64::from(u8::from(m == MasterName::Jacobi))))),
            asked(self.latency),
            asked(self.loop_delay),
            asked(self.path_delay),
            asked(self.estimator_delay),
            asked(self.latency_spread),
        ];
        for ((_, _, set), flag) in KEYS.iter().zip(flags) {
            if let Some(Asked(value)) = flag {
                set(&mut options, &mut stated, value);
            }
        }
        if let Some(seed) = self.seed {
            options.seed = seed;
        }
        options.robust = (self.robust != Some(Switch::Off)).then(|| {
            let usual = RobustOptions::default();
            RobustOptions {
                members: self.ensemble.unwrap_or(usual.members),
                speed_share: self.speed_spread.map_or(usual.speed_share, |percent| percent / 100.0),
                ..usual
            }
        });
        finish(&mut options, &stated);
        match (options.check(), &self.requirements) {
            (Err(error), Some(file)) => Err(Failure::in_file(file, &error, error.hint())),
            (checked, _) => Ok(checked.map(|()| options)?),
        }
    }
}

impl SpecificationArguments {
    /// The master that the loop is designed for.
    pub(crate) fn master(&self) -> Result<control::Master, Failure> {
        let mut stated = Stated::default();
        match (self.master, &self.requirements) {
            (Some(master), _) => stated.jacobi = master == MasterName::Jacobi,
            (None, Some(file)) => read(file, &mut DesignOptions::default(), &mut stated)?,
            (None, None) => {}
        }
        Ok(if stated.jacobi { control::Master::Jacobi } else { control::Master::GaussSeidel })
    }
}

/// Latency that is taken as known to this, s, where one is stated.
const LATENCY_SPREAD: f64 = 0.03;

/// Adds up what belongs together.
fn finish(options: &mut DesignOptions, stated: &Stated) {
    let sample = if stated.jacobi { options.sample_time_s } else { 0.0 };
    let path = stated.path.unwrap_or(stated.yaw);
    let estimator = stated.estimator.unwrap_or(path);
    options.loop_delay_s = stated.yaw + stated.latency + sample;
    options.path_delay_s = path + stated.latency + 2.0 * sample;
    options.estimator_delay_s = estimator + stated.latency + 3.0 * sample;
    // Without a measured latency, what another master would add.
    let spread = if stated.latency > 0.0 { LATENCY_SPREAD } else { options.sample_time_s };
    if let Some(robust) = &mut options.robust {
        robust.latency_s = stated.spread.unwrap_or(spread);
    }
    let error = options.requirements.steady_state_error_percent;
    let band = options.requirements.settling_band_percent;
    options.requirements.settling_band_percent = stated.band.or(error).unwrap_or(band);
}

/// Reads a file of requirements; each fault is told with its line and column.
fn read(file: &Path, options: &mut DesignOptions, stated: &mut Stated) -> Result<(), Failure> {
    let text = files::read_text(file)?;
    let at = |byte: usize, problem: &str| {
        let before = text.get(..byte).unwrap_or(&text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let names: Vec<&str> = KEYS.iter().map(|(name, ..)| *name).collect();
        Failure::new(
            format!("{}:{line}:{column}: {problem}", file.display()),
            format!("a line reads such as `settling = \"1s\"`; the names are {}", names.join(", ")),
        )
    };
    let table: std::collections::BTreeMap<toml::Spanned<String>, toml::Spanned<toml::Value>> =
        toml::from_str(&text).map_err(|e| {
            at(e.span().map_or(0, |span| span.start), &e.message().replace('\n', "; "))
        })?;
    let mut entries: Vec<_> = table.into_iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    for (name, value) in &entries {
        let key = name.get_ref().as_str();
        let Some((_, parse, set)) = KEYS.iter().find(|(known, ..)| *known == key) else {
            return Err(at(name.span().start, &format!("`{key}` is no requirement")));
        };
        let start = value.span().start;
        let written = match value.get_ref() {
            toml::Value::String(s) => s.clone(),
            toml::Value::Float(v) => v.to_string(),
            toml::Value::Integer(v) => v.to_string(),
            _ => return Err(at(start, &format!("{key}: a text with a unit is expected"))),
        };
        let Asked(asked) =
            parse(&written).map_err(|problem| at(start, &format!("{key}: {problem}")))?;
        set(options, stated, asked);
        // What cannot hold beside what stands above it is told here, where its line is known.
        let mut so_far = *options;
        finish(&mut so_far, stated);
        so_far.check().map_err(|e| at(start, &format!("{key}: {e}")))?;
    }
    if entries.is_empty() {
        return Err(at(0, "nothing is asked for"));
    }
    Ok(())
}
