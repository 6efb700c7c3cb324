//! The specification of a controller: options of the command line, and a TOML file with the same names.
//!
//! ```toml
//! overshoot = "1%"
//! settling = "1s"
//! modulus-margin = 0.5
//! max-rate = "23deg/s"
//! ```

use crate::documents::files;
use crate::failure::Failure;
use crate::options::quantity::{
    Acceleration, Angle, AngleRate, Decibel, Jerk, Number, OrNone, Percent, Phase, Time,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use steerwright_control::{DesignOptions, RobustOptions, SpeedDesignOptions};
use steerwright_formats::{LoopCoupling, Specification, StatedActuator};
use toml::{Spanned, Table, Value};

/// The order of exchange between the FMUs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum CouplingName {
    /// One after the other, in the order plant, estimator, path, controller: no loop has a delay
    GaussSeidel,
    /// All with the values at the start of the step: the yaw loop is late by one step, the loop through the path by
    /// two, the loop through the estimator by three
    Jacobi,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Switch {
    On,
    Off,
}

/// The specification of a controller, for a 5° yaw step, or of a speed controller, for a step of 2 m/s.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Specification")]
pub(crate) struct SpecificationArguments {
    /// Read the specification from a file with the names of these options, such as `settling = "1s"`.
    /// An option overrides the file, and `none` removes a requirement. Without a file the requirements
    /// are 1% overshoot, 1s settling time, 2% steady-state error and a modulus margin of 0.5; of a speed controller
    /// 5% overshoot, 4s settling time and 2% steady-state error
    #[arg(long, value_name = "SPEC.toml")]
    requirements: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

/// The options of the command line and of the file; absent where not stated.
#[derive(clap::Args, Deserialize, Debug, Clone, Default, PartialEq)]
#[command(next_help_heading = "Specification")]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
struct Options {
    /// Largest overshoot
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    overshoot: Option<OrNone<Percent>>,
    /// Longest settling time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    settling: Option<OrNone<Time>>,
    /// Largest steady-state error: of the step, with a steering offset of 1° at the road wheel (0.8 of
    /// the largest angle where that is less), and on a curve of constant curvature with feedforward; of a speed
    /// controller: of the step, and on a grade that is not measured
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    steady_state_error: Option<OrNone<Percent>>,
    /// Longest rise time, 10 to 90 %
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    rise_time: Option<OrNone<Time>>,
    /// Largest integral of absolute error (IAE) of the step, divided by its height
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    iae: Option<OrNone<Time>>,
    /// Smallest gain margin, such as 6dB
    #[arg(long, value_name = "GAIN", allow_hyphen_values = true)]
    gain_margin: Option<OrNone<Decibel>>,
    /// Smallest phase margin
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    phase_margin: Option<OrNone<Phase>>,
    /// Smallest distance of the loop from −1
    #[arg(long, value_name = "MARGIN", allow_hyphen_values = true)]
    modulus_margin: Option<OrNone<Number>>,
    /// Smallest additional delay that makes the loop unstable
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    delay_margin: Option<OrNone<Time>>,
    /// Smallest disk margin with zero skew
    #[arg(long, value_name = "MARGIN", allow_hyphen_values = true)]
    disk_margin: Option<OrNone<Number>>,
    /// Band in which the response has settled; by default the steady-state error, or 2%
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    settling_band: Option<Percent>,
    /// Largest steering angle in steering coordinates; by default 22deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    max_angle: Option<OrNone<Angle>>,
    /// Largest change of the steering angle in a sample; by default 15deg at the road wheel
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    max_increment: Option<OrNone<Angle>>,
    /// Largest rate of the steering angle that the actuator follows; by default that of the model,
    /// which a command outran, or else twice the fastest steering of the drive. Required for a
    /// model without a drive
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    max_rate: Option<OrNone<AngleRate>>,
    /// Time constant of the actuator that moves the steering to the commanded angle, for a model whose drive has the measured
    /// angle: such a model has none
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    actuator_lag: Option<Time>,
    /// Delay of that actuator
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    actuator_delay: Option<Time>,
    /// Largest lateral acceleration of a steady turn; it limits the steering angle at each speed
    /// [default: 6m/s2]
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true)]
    max_lateral_acceleration: Option<Acceleration>,
    /// Largest acceleration that a speed controller demands [default: 2m/s2, that of ISO 15622]
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true)]
    max_acceleration: Option<Acceleration>,
    /// Largest deceleration that a speed controller demands [default: 3.5m/s2, that of ISO 15622]
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true)]
    max_deceleration: Option<Acceleration>,
    /// Largest jerk that a speed controller demands [default: 2.5m/s3, that of ISO 15622]
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    max_jerk: Option<Jerk>,
    /// Grade on which a speed controller keeps the steady-state error [default: 6%]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    grade: Option<Percent>,
    /// Sample time of the controller [default: 10ms]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pid_sample_time: Option<Time>,
    /// Coupling of the co-simulation that the loop is designed for [default: gauss-seidel]
    #[arg(long, alias = "master", value_enum)]
    #[serde(alias = "master")]
    coupling: Option<CouplingName>,
    /// Measured latency of every loop, in addition to the delays of the model and the coupling
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    latency: Option<Time>,
    /// Additional delay of the yaw loop
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    loop_delay: Option<Time>,
    /// Additional delay of the loop through the path; by default that of the yaw loop
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    path_delay: Option<Time>,
    /// Additional delay of the loop through pose estimator and path; by default that of the path
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    estimator_delay: Option<Time>,
    /// Design for all plants within the identified uncertainty, for other latencies, and for other
    /// speeds where the model was identified over speed [default: on]. Requirements that some of these plants miss
    /// are reported; with an explicit `on` they fail the design
    #[arg(long, value_enum)]
    robust: Option<Switch>,
    /// Latency above and below the designed one that the requirements must tolerate; by default 30ms
    /// with a stated latency, otherwise one sample
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    latency_spread: Option<Time>,
    /// Speed above and below the designed one that the requirements must tolerate, where the model was
    /// identified over speed [default: 20%, or 5% with a range of speeds]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    speed_spread: Option<Percent>,
    /// Number of plants drawn from the identified uncertainty [default: 100]
    #[arg(long, value_name = "N")]
    ensemble: Option<usize>,
    /// Seed of the starting points and the drawn plants [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

pub(crate) struct Specified {
    pub(crate) design: DesignOptions,
    /// The coupling that the loop is designed for.
    pub(crate) coupling: LoopCoupling,
    /// Whether a requirement that not all plants keep fails the design: `on` was written.
    pub(crate) must_be_robust: bool,
    /// Whether a spread of the speed is stated.
    states_speed_spread: bool,
}

pub(crate) struct SpeedSpecified {
    pub(crate) design: SpeedDesignOptions,
    /// Whether a requirement that not all vehicles keep fails the design: `on` was written.
    pub(crate) must_be_robust: bool,
}

/// Spread of the speed about each entry of a table over speed, where none is stated: the error of a measured
/// speed.
const SPEED_SPREAD_OVER_SPEEDS: f64 = 0.05;

impl Specified {
    /// The design at each speed of a range.
    pub(crate) fn over_speeds(&self) -> DesignOptions {
        let speed_share = SPEED_SPREAD_OVER_SPEEDS;
        let robust = |r| RobustOptions { speed_share, ..r };
        match self.states_speed_spread {
            true => self.design,
            false => DesignOptions { robust: self.design.robust.map(robust), ..self.design },
        }
    }
}

impl SpecificationArguments {
    /// Whether an option or a file states anything.
    pub(crate) fn is_stated(&self) -> bool {
        self.requirements.is_some() || self.options != Options::default()
    }

    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.requirements.iter()
    }

    /// The options of a speed controller, of the file and of the command line.
    pub(crate) fn read_speed(&self, speeds: Option<[f64; 2]>) -> Result<SpeedSpecified, Failure> {
        let (options, usual) = match &self.requirements {
            Some(file) => (self.options.clone().or(read(file)?), false),
            None => (self.options.clone(), true),
        };
        let specified = options.speed(usual, speeds)?;
        specified.design.check()?;
        Ok(specified)
    }

    /// The options of the file and of the command line.
    pub(crate) fn read(&self) -> Result<Specified, Failure> {
        let Some(file) = &self.requirements else {
            let options = self.options.clone();
            options.refuse_those_of_speed()?;
            let specified = options.specified(Specification::default());
            specified.design.check()?;
            return Ok(specified);
        };
        let options = self.options.clone().or(read(file)?);
        options.refuse_those_of_speed()?;
        let specified = options.specified(Specification::none());
        let checked = specified.design.check();
        checked.map_err(|error| Failure::in_file(file, &error, error.hint()))?;
        Ok(specified)
    }
}

/// Uncertainty of a stated latency, s.
const LATENCY_SPREAD: f64 = 0.03;

/// Fields with the names of their options and whether they are stated.
macro_rules! stated {
    ($of:ident: $($field:ident)*) => { [$((stringify!($field), $of.$field.is_some())),*] };
}

/// Refuses the first of some options that is stated.
fn refuse(options: &[(&str, bool)], reason: &str) -> Result<(), Failure> {
    for (name, is_stated) in options {
        if *is_stated {
            let message = format!("--{} {reason}", name.replace('_', "-"));
            return Err(Failure::new(message, "omit it"));
        }
    }
    Ok(())
}

impl Options {
    /// These options, or where they are absent the others.
    fn or(self, other: Self) -> Self {
        macro_rules! either {
            ($($field:ident)*) => { Options { $($field: self.$field.or(other.$field)),* } };
        }
        either!(
            overshoot settling steady_state_error rise_time iae gain_margin phase_margin
            modulus_margin delay_margin disk_margin settling_band max_angle max_increment max_rate
            actuator_lag actuator_delay
            max_lateral_acceleration max_acceleration max_deceleration max_jerk grade
            pid_sample_time coupling latency loop_delay path_delay
            estimator_delay robust latency_spread speed_spread ensemble seed
        )
    }

    /// Refuses options that a speed controller alone has.
    fn refuse_those_of_speed(&self) -> Result<(), Failure> {
        refuse(
            &stated!(self: max_acceleration max_deceleration max_jerk grade),
            "is an option of a speed controller, and the model is one of the steering",
        )
    }

    /// The design of a speed controller; `usual` states whether requirements that are absent have their defaults.
    fn speed(self, usual: bool, speeds: Option<[f64; 2]>) -> Result<SpeedSpecified, Failure> {
        refuse(
            &stated!(self: rise_time iae gain_margin phase_margin modulus_margin delay_margin
                disk_margin max_angle max_increment max_rate actuator_lag actuator_delay
                max_lateral_acceleration coupling latency loop_delay path_delay estimator_delay
                latency_spread speed_spread),
            "is an option of a steering controller, and the model is one of the speed",
        )?;
        fn bound<T: Into<f64>>(stated: Option<OrNone<T>>, usual: Option<f64>) -> Option<f64> {
            stated.map_or(usual, |value| value.0.map(Into::into))
        }
        let defaults = SpeedDesignOptions::default();
        let or_none = |value: Option<f64>| value.filter(|_| usual);
        let steady_state_error_percent =
            bound(self.steady_state_error, or_none(defaults.steady_state_error_percent));
        let band = self.settling_band.map(f64::from).or(steady_state_error_percent);
        let value = |stated: Option<Acceleration>, usual: f64| stated.map_or(usual, f64::from);
        let design = SpeedDesignOptions {
            overshoot_percent: bound(self.overshoot, or_none(defaults.overshoot_percent)),
            settling_time_s: bound(self.settling, or_none(defaults.settling_time_s)),
            steady_state_error_percent,
            settling_band_percent: band.unwrap_or(defaults.settling_band_percent),
            grade_percent: self.grade.map_or(defaults.grade_percent, f64::from),
            speeds_mps: speeds,
            max_acceleration_mps2: value(self.max_acceleration, defaults.max_acceleration_mps2),
            max_deceleration_mps2: value(self.max_deceleration, defaults.max_deceleration_mps2),
            max_jerk_mps3: self.max_jerk.map_or(defaults.max_jerk_mps3, f64::from),
            sample_time_s: self.pid_sample_time.map_or(defaults.sample_time_s, f64::from),
            members: match self.robust {
                Some(Switch::Off) => 0,
                _ => self.ensemble.unwrap_or(defaults.members),
            },
            seed: self.seed.unwrap_or(defaults.seed),
        };
        Ok(SpeedSpecified { design, must_be_robust: self.robust == Some(Switch::On) })
    }

    /// The design; `usual` are the requirements where none is stated.
    fn specified(self, usual: Specification) -> Specified {
        fn bound<T: Into<f64>>(stated: Option<OrNone<T>>, usual: Option<f64>) -> Option<f64> {
            stated.map_or(usual, |value| value.0.map(Into::into))
        }
        let defaults = DesignOptions::default();
        let time = |stated: Option<Time>| stated.map_or(0.0, f64::from);
        let steady_state_error = bound(self.steady_state_error, usual.steady_state_error_percent);
        let band = self.settling_band.map(f64::from).or(steady_state_error);
        let requirements = Specification {
            overshoot_percent: bound(self.overshoot, usual.overshoot_percent),
            settling_time_s: bound(self.settling, usual.settling_time_s),
            steady_state_error_percent: steady_state_error,
            rise_time_s: bound(self.rise_time, usual.rise_time_s),
            integral_absolute_error_s: bound(self.iae, usual.integral_absolute_error_s),
            gain_margin_db: bound(self.gain_margin, usual.gain_margin_db),
            phase_margin_deg: bound(self.phase_margin, usual.phase_margin_deg),
            modulus_margin: bound(self.modulus_margin, usual.modulus_margin),
            delay_margin_s: bound(self.delay_margin, usual.delay_margin_s),
            disk_margin: bound(self.disk_margin, usual.disk_margin),
            settling_band_percent: band.unwrap_or(usual.settling_band_percent),
            ..usual
        };
        let sample_time_s = self.pid_sample_time.map_or(defaults.sample_time_s, f64::from);
        let latency = time(self.latency);
        let coupling = match self.coupling {
            Some(CouplingName::Jacobi) => LoopCoupling::Jacobi,
            Some(CouplingName::GaussSeidel) | None => LoopCoupling::GaussSeidel,
        };
        let late = coupling.loop_delay_s(sample_time_s);
        let yaw = time(self.loop_delay);
        let path = self.path_delay.map_or(yaw, f64::from);
        let estimator = self.estimator_delay.map_or(path, f64::from);
        // Without a measured latency, the delay of another coupling.
        let spread = if latency > 0.0 { LATENCY_SPREAD } else { sample_time_s };
        let usual = RobustOptions::default();
        let states_speed_spread = self.speed_spread.is_some();
        let robust_options = RobustOptions {
            members: self.ensemble.unwrap_or(usual.members),
            latency_s: self.latency_spread.map_or(spread, f64::from),
            speed_share: self.speed_spread.map_or(usual.speed_share, |p| f64::from(p) / 100.0),
            ..usual
        };
        let is_stated = self.actuator_lag.is_some() || self.actuator_delay.is_some();
        let actuator = StatedActuator {
            time_constant_s: time(self.actuator_lag),
            delay_s: time(self.actuator_delay),
        };
        let design = DesignOptions {
            requirements,
            actuator: if is_stated { Some(actuator) } else { None },
            max_angle_rad: bound(self.max_angle, defaults.max_angle_rad),
            max_increment_rad: bound(self.max_increment, defaults.max_increment_rad),
            max_rate_radps: bound(self.max_rate, defaults.max_rate_radps),
            max_lateral_acceleration_mps2: self
                .max_lateral_acceleration
                .map_or(defaults.max_lateral_acceleration_mps2, f64::from),
            sample_time_s,
            loop_delay_s: yaw + latency + late,
            path_delay_s: path + latency + 2.0 * late,
            estimator_delay_s: estimator + latency + 3.0 * late,
            robust: if self.robust != Some(Switch::Off) { Some(robust_options) } else { None },
            seed: self.seed.unwrap_or(defaults.seed),
            ..defaults
        };
        let must_be_robust = self.robust == Some(Switch::On);
        Specified { design, coupling, must_be_robust, states_speed_spread }
    }

    /// Their names, in the file and on the command line.
    fn names() -> Vec<String> {
        let command = <Self as clap::Args>::augment_args(clap::Command::new("file"));
        let names = command.get_arguments().filter_map(|argument| argument.get_long());
        names.map(str::to_owned).collect()
    }
}

/// Reads a file of requirements; each error names its line and column.
fn read(file: &Path) -> Result<Options, Failure> {
    let text = files::read_text(file)?;
    let names = Options::names();
    let at = |byte: usize, problem: &str| {
        let before = text.get(..byte).unwrap_or(&text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        Failure::new(
            format!("{}:{line}:{column}: {problem}", file.display()),
            "a line is such as `settling = \"1s\"`; the names are the options under Specification in `steerwright design --help`",
        )
    };
    let table: BTreeMap<Spanned<String>, Spanned<Value>> = toml::from_str(&text)
        .map_err(|e| at(e.span().map_or(0, |span| span.start), &e.message().replace('\n', "; ")))?;
    let mut entries: Vec<_> = table.into_iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let mut options = Err(at(0, "the file has no requirement"));
    // One more entry at a time, since a contradiction belongs to the line that completes it.
    let mut so_far = Table::new();
    for (name, value) in entries {
        let (key, start) = (name.get_ref().clone(), value.span().start);
        if !names.contains(&key) {
            let near = steerwright_host::near(&key, names.iter().map(String::as_str));
            let near = if near.is_empty() {
                String::new()
            } else {
                format!("; near it: {}", near.join(", "))
            };
            return Err(at(name.span().start, &format!("`{key}` is no requirement{near}")));
        }
        let here = |problem: &str| at(start, &format!("{key}: {problem}"));
        so_far.insert(key.clone(), value.into_inner());
        let stated: Options =
            so_far.clone().try_into().map_err(|e: toml::de::Error| here(e.message()))?;
        let specified = stated.clone().specified(Specification::none());
        specified.design.check().map_err(|e| here(&e.to_string()))?;
        options = Ok(stated);
    }
    options
}
