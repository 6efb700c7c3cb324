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
