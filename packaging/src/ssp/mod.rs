//! Loops as system structure packages (SSP 1.0).
//!
//! Only elements that the common importers share are written in `SystemStructure.ssd`:
//!
//! - components and nothing else: no connector of the system, no nested system, no transformation.
//!   libcosim refuses a connection to a connector of the system, and fmpy feeds 0 from one without a
//!   source, so that the vehicle would stand;
//! - the prefixes `ssd:`, `ssc:` and `ssv:`, which libcosim takes literally;
//! - a component's connectors are its outputs and its connected inputs: to an input that nothing
//!   feeds fmpy would set 0;
//! - the base step as `osp:FixedStepAlgorithm`, since SSP 1.0 itself has no place for it;
//! - values inline in one parameter set a component. fmpy and FMU containers ignore those, so the
//!   archives should start with the same values by themselves: [`Start`].
//!
//! The speed is an input of each component. To drive a system over speed, the package has a second
//! structure, the variant [`SPEED_INPUT`], with one connector of the system, `speed`, that feeds them all;
//! without a source it has the start value that the components have in `SystemStructure.ssd`.
//!
//! [`Start`]: steerwright_formats::Start

mod inputs;
mod start;
mod structure;
mod wiring;

use crate::Error;
use crate::archive::{Packed, zipped};
use steerwright_host::Connection;
use zip::CompressionMethod;

pub use start::{REFERENCE_SPEED, own_start, receiver_values, sideslip_values, start_values};
pub use wiring::{MEASUREMENTS, connections_by_name, loop_order};

/// The variant of a package whose system has connectors: the name of its file, without `.ssd`.
pub const SPEED_INPUT: &str = "SpeedInput";

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
    /// Base step of the co-simulation.
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
    let inputs = inputs::system_inputs(components, connections);
    let structure = structure::Structure {
        title: name,
        name,
        components,
        connections,
        inputs: &[],
        experiment,
    };
    let mut files = vec![("SystemStructure.ssd".to_owned(), structure.to_xml()?)];
    if !inputs.is_empty() {
        let title = format!("{name}{SPEED_INPUT}");
        let variant = structure::Structure { title: &title, inputs: &inputs, ..structure };
        files.push((format!("{SPEED_INPUT}.ssd"), variant.to_xml()?));
    }
    let files =
        files.iter().map(|(file, xml)| (file.clone(), xml.as_bytes(), CompressionMethod::Deflated));
    // The archives are compressed already, so they are stored.
    let archives = components.iter().map(|component| {
        (structure::source(component), &*component.packed.bytes, CompressionMethod::Stored)
    });
    zipped(files.chain(archives)).map_err(|source| Error::Package { name: name.into(), source })
}
