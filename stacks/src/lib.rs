//! The parameters that driving stacks require, from an identified model: each with its standard error, its unit
//! and the formula in which the stack uses it.
//!
//! [`Lateral`] reduces a plant or a bicycle to what the stacks' models have: a delay, a first-order lag, and the
//! effective wheelbase v·δ/r at the road wheel. A file for each stack maps these to its parameters; what the model
//! does not determine is listed in [`Export`]. Signs are those of ISO 8855, positive to the left.

mod ardupilot;
mod autoware;
mod error;
mod export;
mod lateral;
mod openpilot;
mod px4;
mod text;
mod torque;

pub use error::Error;
pub use export::{Export, Missing, Parameter, StatedValues};
pub use lateral::{Lateral, Quantity, Timing};
pub use text::MARK;

use export::FileForm;
use steerwright_formats::Torque;

/// A driving stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stack {
    /// `simple_planning_simulator` and `mpc_lateral_controller` of Autoware.
    Autoware,
    /// openpilot's `CarParams`.
    Openpilot,
    /// Rover of ArduPilot, with Ackermann steering.
    Ardupilot,
    /// The Ackermann rover of PX4.
    Px4,
}

steerwright_formats::words!(Stack {
    Autoware = "autoware",
    Openpilot = "openpilot",
    Ardupilot = "ardupilot",
    Px4 = "px4",
});

/// The parameters of a stack.
///
/// # Errors
/// Limits or a wheelbase that are not greater than 0.
pub fn export(stack: Stack, lateral: &Lateral, stated: &StatedValues) -> Result<Export, Error> {
    stated.check()?;
    let (form, fill): (FileForm, fn(&mut Export, &Lateral, &StatedValues)) = match stack {
        Stack::Autoware => (FileForm::Ros2, autoware::fill),
        Stack::Openpilot => (FileForm::Toml, openpilot::fill),
        Stack::Ardupilot => (FileForm::Csv, ardupilot::fill),
        Stack::Px4 => (FileForm::QGroundControl, px4::fill),
    };
    let mut export = Export::new(stack.name(), form, &lateral.name, &lateral.quality);
    fill(&mut export, lateral, stated);
    Ok(export)
}

/// The parameters of a stack that steers by torque.
///
/// # Errors
/// [`Error::NotByTorque`] for other stacks, [`Error::NotNormalised`] if the command is not from −1 to 1.
pub fn export_torque(stack: Stack, torque: &Torque) -> Result<Export, Error> {
    match stack {
        Stack::Openpilot => torque::export(stack.name(), torque),
        _ => Err(Error::NotByTorque { stack: stack.name() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use steerwright_formats::{Bicycle, VehicleData};

    /// A rate that is stated takes precedence, and one that no model has is named.
    #[test]
    fn a_servo_that_was_outrun_has_its_rate() {
        let parameter = |rate: Option<f64>, stated: Option<f64>, stack: Stack, key: &str| {
            let vehicle = VehicleData { actuator_rate_max_radps: rate, ..VehicleData::default() };
            let lateral = Lateral::of_bicycle(&Bicycle::new(vehicle)).unwrap();
            let stated = StatedValues { max_rate_radps: stated, ..StatedValues::default() };
            let export = export(stack, &lateral, &stated).unwrap();
            let set = export.parameters.iter().find(|p| p.key == key).map(|p| p.quantity.value);
            assert_eq!(set.is_none(), export.missing.iter().any(|m| m.key == key));
            set
        };
        let (autoware, px4) =
            ((Stack::Autoware, "steer_rate_lim"), (Stack::Px4, "RA_STR_RATE_LIM"));
        assert_eq!(parameter(Some(0.2), None, autoware.0, autoware.1), Some(0.2));
        assert_eq!(parameter(Some(0.2), None, px4.0, px4.1), Some(0.2_f64.to_degrees()));
        assert_eq!(parameter(Some(0.2), Some(0.3), autoware.0, autoware.1), Some(0.3));
        assert_eq!(parameter(None, None, autoware.0, autoware.1), None);
    }
}
