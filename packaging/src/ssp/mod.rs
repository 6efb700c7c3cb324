//! Loops as system structure packages (SSP 1.0).
//!
//! Only elements that the common importers share are written:
//!
//! - components and nothing else: no connector of the system, no nested system, no transformation;
//! - the prefixes `ssd:`, `ssc:` and `ssv:`, which libcosim takes literally;
//! - a component's connectors are its outputs and its connected inputs: to an input that nothing
//!   feeds fmpy would set 0;
//! - the base step as `osp:FixedStepAlgorithm`, since SSP 1.0 itself has no place for it;
//! - values inline in one parameter set a component. fmpy and FMU containers ignore those, so the
//!   archives should start with the same values by themselves: [`Start`].
//!
//! [`Start`]: steerwright_formats::Start

mod start;
mod structure;
mod wiring;

use crate::Error;
use crate::archive::{Packed, zipped};
use std::iter::once;
use steerwright_host::Connection;
use zip::CompressionMethod;

pub use start::{REFERENCE_SPEED, own_start, receiver_values, sideslip_values, start_values};
pub use wiring::{MEASUREMENTS, connections_by_name, loop_order};

/// A component of a system, named after its FMU.
#[derive(Debug, Clone)]
pub struct Component<'a> {
    /// The FMU.
    pub packed: &'a Packed,
    /// Start values of its Real parameters and inputs, by name.
    pub start: Vec<(String, f64)>,
}

impl Component<'_> {
    fn name(&self) -> &'static str {
        self.packed.fmu.name()
    }
}

/// Default experiment, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Base step of the master.
    pub step: f64,
    /// Length of the run, from time 0.
    pub stop: f64,
}

/// The package of a system. `name` is the system's.
///
/// # Errors
/// A connection or value of a missing variable, or an invalid step.
pub fn ssp(
    name: &str,
    components: &[Component<'_>],
    connections: &[Connection],
    experiment: Experiment,
) -> Result<Vec<u8>, Error> {
    let Experiment { step, stop } = experiment;
    for time in [step, stop] {
        if !(time.is_finite() && time > 0.0) {
            return Err(Error::Step { step: time });
        }
    }
    let xml = structure::to_xml(name, components, connections, experiment)?;
    // The archives are compressed already, so they are stored.
    let archives = components.iter().map(|component| {
        (structure::source(component), &*component.packed.bytes, CompressionMethod::Stored)
    });
    let xml = ("SystemStructure.ssd".to_owned(), xml.as_bytes(), CompressionMethod::Deflated);
    zipped(once(xml).chain(archives)).map_err(|source| Error::Package { name: name.into(), source })
}
