//! The structure of the model that `identify` estimates, and the options of each structure.

use crate::failure::Failure;
use crate::log_options::IdentifyArguments;
use crate::quantity;
use steerwright_drivelog::Response;
use steerwright_sysid::bicycle::BicycleOptions;
use steerwright_sysid::torque::TorqueOptions;
use steerwright_sysid::{IdentifyOptions, InputKind};

/// The structure of the model, and options of one structure.
#[derive(clap::Args, Debug, Clone)]
#[command(next_help_heading = "Structure")]
pub(crate) struct StructureArguments {
    /// Structure of the model: state-space; the bicycle of eq 13 scheduled by the speed, for drives of varying
    /// speed; or torque, the lateral acceleration that a steering torque or its normalised command causes. auto is
    /// state-space
    #[arg(long, value_name = "auto|state-space|bicycle|torque", default_value = "state-space", value_parser = structure)]
    structure: Name,
    /// Mass in bicycle.json, kg; the yaw rate does not depend on it. By default 1500
    #[arg(long, value_name = "KG", allow_hyphen_values = true)]
    mass: Option<f64>,
    /// Wheelbase of the bicycle, m; the steering ratio is then identified. By default the wheelbase
    /// is identified, with the steering ratio of the log
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    wheelbase: Option<f64>,
    /// Share of the weight on the front axle; the yaw rate hardly depends on it. By default 50%
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = quantity::percent)]
    front_share: Option<f64>,
    /// Lowest speed that is used. By default 1 m/s for the bicycle, 15 m/s for the structure torque
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = quantity::speed)]
    min_speed: Option<f64>,
    /// Rate of the steering angle at which the friction of the structure torque reaches 76 % of its value, in
    /// coordinates of the log. By default 0.05rad/s
    #[arg(long, value_name = "RATE", allow_hyphen_values = true, value_parser = quantity::angle_rate)]
    friction_rate: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Name {
    StateSpace,
    Bicycle,
    Torque,
}

/// A structure with its options.
#[derive(Debug)]
pub(crate) enum Structure {
    StateSpace(IdentifyOptions),
    Bicycle(BicycleOptions),
    Torque(TorqueOptions),
}

impl Structure {
    /// What a log is read for.
    pub(crate) fn response(&self) -> Response {
        match self {
            Self::StateSpace(_) | Self::Bicycle(_) => Response::YawRate,
            Self::Torque(_) => Response::LateralAcceleration,
        }
    }
}

impl StructureArguments {
    /// The structure with its options; options of the others are rejected.
    pub(crate) fn with(&self, identify: &IdentifyArguments) -> Result<Structure, Failure> {
        let stated = identify.options();
        let of_state_space = [
            (stated.method.is_some(), "--method"),
            (stated.order.is_some(), "--order"),
            (stated.horizon.is_some(), "--horizon"),
            (stated.feedthrough.is_some(), "--feedthrough"),
            (stated.input_kind != InputKind::Steering, "--model-input"),
        ];
        let of_bicycle = [
            (self.mass.is_some(), "--mass"),
            (self.wheelbase.is_some(), "--wheelbase"),
            (self.front_share.is_some(), "--front-share"),
        ];
        let of_torque = [(self.friction_rate.is_some(), "--friction-rate")];
        let all = [
            (Name::StateSpace, "state-space", &of_state_space[..]),
            (Name::Bicycle, "bicycle", &of_bicycle[..]),
            (Name::Torque, "torque", &of_torque[..]),
        ];
        for (_, structure, options) in all.iter().filter(|(name, ..)| *name != self.structure) {
            if let Some((_, option)) = options.iter().find(|(is_stated, _)| *is_stated) {
                return Err(Failure::new(
                    format!("{option} is an option of the structure {structure}"),
                    format!("omit the option, or identify with --structure {structure}"),
                ));
            }
        }
        if self.structure == Name::StateSpace && self.min_speed.is_some() {
            let message = "--min-speed is an option of the structures bicycle and torque";
            return Err(Failure::new(message, "omit it, or select speeds with --speed-window"));
        }
        let validation_fraction = stated.validation_fraction;
        Ok(match self.structure {
            Name::StateSpace => Structure::StateSpace(stated),
            Name::Bicycle => Structure::Bicycle(BicycleOptions {
                mass_kg: self.mass,
                wheelbase_m: self.wheelbase,
                front_share: self.front_share.map(|percent| percent / 100.0),
                least_speed_mps: self
                    .min_speed
                    .unwrap_or(BicycleOptions::default().least_speed_mps),
                validation_fraction,
            }),
            Name::Torque => {
                let default = TorqueOptions::default();
                Structure::Torque(TorqueOptions {
                    least_speed_mps: self.min_speed.unwrap_or(default.least_speed_mps),
                    friction_rate_radps: self.friction_rate.unwrap_or(default.friction_rate_radps),
                    validation_fraction,
                })
            }
        })
    }
}

fn structure(text: &str) -> Result<Name, String> {
    match text {
        "auto" | "state-space" => Ok(Name::StateSpace),
        "bicycle" => Ok(Name::Bicycle),
        "torque" => Ok(Name::Torque),
        _ => Err("expected auto, state-space, bicycle or torque".into()),
    }
}
