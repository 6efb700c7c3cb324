//! Which output feeds which input of a loop, and in which order its FMUs are stepped.

use crate::{Error, Fmu, Packed};
use fmi2_host::Connection;
use model_description::{Causality, Variable};

/// The FMUs in the order plant, pose estimator, path, controller: no delay enters the loop when a Gauss–Seidel
/// master steps them so.
#[must_use]
pub fn loop_order(packed: &[Packed]) -> Vec<&Packed> {
    let mut ordered: Vec<&Packed> = packed.iter().collect();
    ordered.sort_by_key(|p| match p.fmu {
        Fmu::IdentifiedPlant | Fmu::BicyclePlant | Fmu::NonlinearVehicle => 0,
        Fmu::PoseEstimator => 1,
        Fmu::ReferencePath => 2,
        Fmu::LateralPid => 3,
    });
    ordered
}

/// Each input with the output of the same name in another FMU; an input without one stays free.
///
/// # Errors
/// [`Error::Ambiguous`] where two FMUs have such an output.
pub fn connections_by_name(packed: &[&Packed]) -> Result<Vec<Connection>, Error> {
    let mut connections = Vec::new();
    for to in packed {
        for input in of(to, Causality::Input) {
            let has_it = |from: &&&Packed| {
                from.fmu != to.fmu && of(from, Causality::Output).any(|o| o.name == input.name)
            };
            let sources: Vec<&&Packed> = packed.iter().filter(has_it).collect();
            match sources[..] {
                [] => {}
                [from] => connections.push(Connection::new(
                    from.fmu.name(),
                    &input.name,
                    to.fmu.name(),
                    &input.name,
                )),
                _ => {
                    return Err(Error::Ambiguous {
                        input: format!("{}.{}", to.fmu.name(), input.name),
                        sources: sources.iter().map(|p| p.fmu.name()).collect(),
                    });
                }
            }
        }
    }
    Ok(connections)
}

fn of(packed: &Packed, causality: Causality) -> impl Iterator<Item = &Variable> {
    packed.description.variables.iter().filter(move |v| v.causality == causality)
}
