//! The structure of the model that `identify` estimates, and the options of each structure.

use crate::commands::identify::auto;
use crate::failure::Failure;
use crate::options::log::{Auto, IdentifyArguments, or_auto};
use crate::options::quantity;
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::Structure;
use steerwright_sysid::bicycle::BicycleOptions;
use steerwright_sysid::longitudinal::LongitudinalOptions;
use steerwright_sysid::single_track::IdentifyVehicleOptions;
use steerwright_sysid::torque::TorqueOptions;
use steerwright_sysid::{
    ChoiceOptions, IdentifiedModel, IdentifyOptions, InputKind, StructureOptions, ValidationData,
};

/// The structure of the model, and options of one structure.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Structure")]
pub(crate) struct StructureArguments {
    /// Structure of the model: state-space, linear at one speed; the bicycle of eq 13 scheduled by the speed, for
    /// drives of varying speed; single-track, a vehicle up to the limit of its grip; torque, the lateral
    /// acceleration that a steering torque or its normalised command causes; or longitudinal, the speed that accelerator
    /// and brake, or an acceleration command, cause. auto is the one of the first three with
    /// the smallest error on the validation data. With an option of state-space (all under Identification but
    /// --max-samples and those of the validation data) and from R factors, auto is state-space
    #[arg(long, value_name = or_auto(Structure::WORDS), default_value = "auto")]
    structure: Auto<Structure>,
    /// Mass in bicycle.json or vehicle.json, kg; the fit does not depend on it. By default 1500
    #[arg(long, value_name = "KG", allow_hyphen_values = true)]
    mass: Option<f64>,
    /// Wheelbase of the bicycle or vehicle, m; the steering ratio is then identified. By default the wheelbase
    /// is identified, with the steering ratio of the log
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    wheelbase: Option<f64>,
    /// Share of the weight on the front axle of the bicycle or vehicle; the yaw rate hardly depends on it. From 10%
    /// to 90% for the bicycle, by default 50%; from 20% to 80% for the vehicle, by default identified
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    front_share: Option<f64>,
    /// Left to right wheel in vehicle.json, m; nothing that is fitted depends on it. By default 0.58 wheelbases
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    track_width: Option<f64>,
    /// Prior of a parameter of the structure single-track: its mean, and the standard deviation of the parameter or
    /// of its logarithm, 0 to fix it. The table of the results has names and priors; may be repeated
    #[arg(long = "prior", value_name = "NAME=MEAN,DEVIATION", value_parser = prior)]
    priors: Vec<(String, [f64; 2])>,
    /// Whether the structure single-track fits the logged sideslip or lateral velocity too, or only compares it. By
    /// default fit
    #[arg(long, value_name = SideslipUse::WORDS)]
    sideslip: Option<SideslipUse>,
    /// Lowest speed that is used. By default 15 m/s for the structure torque, 3 m/s for
    /// longitudinal, otherwise 3 m/s times the root of the
    /// wheelbase over 2.6 m
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = quantity::speed)]
    min_speed: Option<f64>,
    /// The drive of the structure longitudinal has one gear, as most electric ones: a log without a gear that is too short
    /// to show this is then no reason to doubt the model
    #[arg(long)]
    single_gear: bool,
    /// Rate of the steering angle at which the friction of the structure torque reaches 76 % of its value, in
    /// coordinates of the log. By default 0.05rad/s
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    friction_rate: Option<f64>,
}

/// Use of the logged sideslip by the structure single-track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SideslipUse {
    Fit,
    Compare,
}

steerwright_formats::words!(SideslipUse { Fit = "fit", Compare = "compare" });

/// The wanted structure with its options.
#[derive(Debug)]
pub(crate) enum Wanted {
    /// The one with the smallest error on the validation data.
    Auto(Box<ChoiceOptions>),
    One(Box<dyn StructureOptions>),
}

impl Wanted {
    /// Which structure; `None` where the data choose it.
    pub(crate) fn structure(&self) -> Option<Structure> {
        match self {
            Self::Auto(_) => None,
            Self::One(options) => Some(options.structure()),
        }
    }

    /// What a log is read for.
    pub(crate) fn response(&self) -> Response {
        match self {
            Self::Auto(options) => options.single_track.response(),
            Self::One(options) => options.response(),
        }
    }

    /// Identifies the model; with the table of the structures where the data choose among some.
    pub(crate) fn identify(
        &self,
        log: &DriveLog,
    ) -> Result<(IdentifiedModel, Option<String>), Failure> {
        match self {
            Self::Auto(options) => auto::identify(log, options),
            Self::One(options) => Ok((options.identify(log)?, None)),
        }
    }
}

impl StructureArguments {
    /// The structure with its options; options of the others are rejected.
    pub(crate) fn with(&self, identify: &IdentifyArguments) -> Result<Wanted, Failure> {
        use Structure::{Bicycle, Longitudinal, SingleTrack, StateSpace, Torque};
        let (stated, default) = (identify.options(), IdentifyOptions::default());
        let of_state_space = [
            (stated.method.is_some(), "--method"),
            (stated.order.is_some(), "--order"),
            (stated.horizon.is_some(), "--horizon"),
            (stated.feedthrough.is_some(), "--feedthrough"),
            (stated.input_kind != InputKind::Steering, "--model-input"),
            (stated.max_order != default.max_order, "--max-order"),
            (stated.delay_s.is_some(), "--delay"),
            (stated.detrend != default.detrend, "--detrend"),
        ];
        let sampled = [
            (stated.max_samples != default.max_samples, "--max-samples"),
            (stated.validation.place != default.validation.place, "--validation-place"),
        ];
        let of_vehicles = [
            (self.mass.is_some(), "--mass"),
            (self.wheelbase.is_some(), "--wheelbase"),
            (self.front_share.is_some(), "--front-share"),
        ];
        let of_single_track = [
            (self.track_width.is_some(), "--track-width"),
            (!self.priors.is_empty(), "--prior"),
            (self.sideslip.is_some(), "--sideslip"),
        ];
        let of_torque = [(self.friction_rate.is_some(), "--friction-rate")];
        let of_longitudinal = [(self.single_gear, "--single-gear")];
        let scheduled = [(self.min_speed.is_some(), "--min-speed")];
        let is_stated = of_state_space.iter().any(|(is_stated, _)| *is_stated);
        let structure = match self.structure.0 {
            None if is_stated => Some(Structure::StateSpace),
            other => other,
        };
        // The structures that have them, whether `auto` has, too, and the options.
        let all = [
            (&[StateSpace][..], false, &of_state_space[..]),
            (&[Bicycle, SingleTrack], true, &of_vehicles),
            (&[SingleTrack], false, &of_single_track),
            (&[Torque], false, &of_torque),
            (&[Longitudinal], false, &of_longitudinal),
            (&[StateSpace, Bicycle, SingleTrack], true, &sampled),
            (&[Bicycle, SingleTrack, Torque, Longitudinal], true, &scheduled),
        ];
        for (structures, of_auto, options) in all {
            if structure.map_or(of_auto, |structure| structures.contains(&structure)) {
                continue;
            }
            if let Some((_, option)) = options.iter().find(|(is_stated, _)| *is_stated) {
                let names: Vec<&str> = structures.iter().map(|s| s.name()).collect();
                let of = names.join(" or ");
                return Err(Failure::new(
                    format!("{option} is an option of the structure {of}"),
                    format!("omit the option, or identify with --structure {of}"),
                ));
            }
        }
        let own = [
            (self.wheelbase.is_some(), "wheelbase", "--wheelbase"),
            (self.front_share.is_some(), "front_share", "--front-share"),
        ];
        for (_, name, option) in own.iter().filter(|(is_stated, ..)| *is_stated) {
            if self.priors.iter().any(|(of, _)| of == name) {
                let message = format!("{option} and --prior {name} state the same parameter");
                return Err(Failure::new(message, "omit one of them"));
            }
        }
        let (validation, most) = (stated.validation, stated.max_samples);
        let Some(structure) = structure else {
            return Ok(Wanted::Auto(Box::new(ChoiceOptions {
                state_space: stated,
                bicycle: self.bicycle(validation, most),
                single_track: self.single_track(validation, most),
            })));
        };
        Ok(Wanted::One(match structure {
            Structure::StateSpace => Box::new(stated),
            Structure::Bicycle => Box::new(self.bicycle(validation, most)),
            Structure::SingleTrack => Box::new(self.single_track(validation, most)),
            Structure::Torque => {
                let default = TorqueOptions::default();
                Box::new(TorqueOptions {
                    least_speed_mps: self.min_speed.unwrap_or(default.least_speed_mps),
                    friction_rate_radps: self.friction_rate.unwrap_or(default.friction_rate_radps),
                    validation_fraction: validation.fraction,
                })
            }
            Structure::Longitudinal => {
                let default = LongitudinalOptions::default();
                Box::new(LongitudinalOptions {
                    least_speed_mps: self.min_speed.unwrap_or(default.least_speed_mps),
                    validation_fraction: validation.fraction,
                    single_gear: self.single_gear,
                })
            }
        }))
    }

    fn front_share(&self) -> Option<f64> {
        self.front_share.map(|percent| percent / 100.0)
    }

    fn bicycle(&self, validation: ValidationData, max_samples: Option<usize>) -> BicycleOptions {
        BicycleOptions {
            mass_kg: self.mass,
            wheelbase_m: self.wheelbase,
            front_share: self.front_share(),
            least_speed_mps: self.min_speed,
            max_samples,
            validation,
        }
    }

    fn single_track(
        &self,
        validation: ValidationData,
        max_samples: Option<usize>,
    ) -> IdentifyVehicleOptions {
        let default = IdentifyVehicleOptions::default();
        IdentifyVehicleOptions {
            mass_kg: self.mass,
            wheelbase_m: self.wheelbase,
            front_share: self.front_share(),
            track_width_m: self.track_width,
            priors: self.priors.clone(),
            fit_lateral_velocity: match self.sideslip {
                Some(sideslip) => sideslip == SideslipUse::Fit,
                None => default.fit_lateral_velocity,
            },
            least_speed_mps: self.min_speed,
            max_samples,
            validation,
        }
    }
}

/// `NAME=MEAN,DEVIATION`.
fn prior(text: &str) -> Result<(String, [f64; 2]), String> {
    let expected = || "expected NAME=MEAN,DEVIATION, such as wheelbase=2.7,0.02".to_owned();
    let (name, numbers) = text.split_once('=').ok_or_else(expected)?;
    let (mean, deviation) = numbers.split_once(',').ok_or_else(expected)?;
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let numbers = number(mean).zip(number(deviation)).ok_or_else(expected)?;
    Ok((name.trim().into(), numbers.into()))
}
