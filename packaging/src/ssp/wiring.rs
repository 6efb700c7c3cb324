//! Which output feeds which input of a loop, and in which order its FMUs are stepped.

use crate::Error;
use crate::archive::Packed;
use steerwright_host::{Connection, Measurement, Unit};

/// Measurements of the pose estimator: in a loop without receiver the fixes are the true position, and
/// path and controller use the estimate.
pub const MEASUREMENTS: [Measurement<'_>; 2] =
    [Measurement { input: "gnss_x", output: "x" }, Measurement { input: "gnss_y", output: "y" }];

/// The FMUs in the order plant, pose estimator, path, controller: no delay enters the loop when a
/// Gauss–Seidel coupling steps them so.
#[must_use]
pub fn loop_order(packed: &[Packed]) -> Vec<&Packed> {
    let mut ordered: Vec<&Packed> = packed.iter().collect();
    ordered.sort_by_key(|p| p.fmu.role());
    ordered
}

/// The connections that names make ([`steerwright_host::wires_by_name`]): an input is fed by the output of
/// its name in another FMU, a pose estimator's `gnss_x` and `gnss_y` by the plant's `x` and `y`.
///
/// # Errors
/// [`Error::Wiring`] where two FMUs have such an output.
pub fn connections_by_name(packed: &[&Packed]) -> Result<Vec<Connection>, Error> {
    let units: Vec<Unit<'_>> =
        packed.iter().map(|p| Unit::new(p.fmu.name(), &p.description.variables)).collect();
    steerwright_host::wires_by_name(&units, &MEASUREMENTS, &|_, _| false)
        .map_err(|e| Error::Wiring(Box::new(e)))
}
