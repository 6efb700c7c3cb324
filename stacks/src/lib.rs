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
pub use export::{Export, Missing, Parameter, Stack, Stated};
pub use lateral::{Lateral, Quantity, Timing};
pub use text::MARK;
pub use torque::export_torque;

/// The parameters of a stack.
///
/// # Errors
/// Limits or a wheelbase that are not greater than 0.
pub fn export(stack: Stack, lateral: &Lateral, stated: &Stated) -> Result<Export, Error> {
    stated.check()?;
    let mut export = Export::new(stack, &lateral.name, &lateral.quality);
    match stack {
        Stack::Autoware => autoware::fill(&mut export, lateral, stated),
        Stack::Openpilot => openpilot::fill(&mut export, lateral),
        Stack::Ardupilot => ardupilot::fill(&mut export, lateral, stated),
        Stack::Px4 => px4::fill(&mut export, lateral, stated),
    }
    Ok(export)
}
