//! Serialized FMU states: another instance of the same FMU can load them, in any process.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | [`MAGIC`] |
//! | 4 | [`VERSION`] of this layout |
//! | 4 + n | GUID: library, table and resources |
//! | 1 | [`State`] |
//! | 1 (+ 8) + 1 (+ 8) | start and stop time, s, each after a flag for its presence |
//! | 8 | start of the next step, s |
//! | 1 | flag: a variable was set since the last step |
//! | 4 + 4 n | value references of inputs whose clipping was logged |
//! | 4 + 12 n | value references and derivatives of inputs with a derivative in the next step |
//! | 4 + n | bytes of [`CoSimulationUnit::save`] |
//! | 32 | SHA-256 of all bytes before |
//!
//! Numbers are little-endian. The GUID needs SHA-256 already, so the digest adds no code; unlike a
//! CRC it detects corruption of any length. It is not a signature: all fields are checked when they
//! are read. Log settings and the counts of repeated lines are not saved, since they belong to the
//! importer's log.

use crate::calls::State;
use crate::instance::{Core, Experiment, Instance, Snapshot};
use crate::unit::{CoSimulationUnit, VariableId};
use model_description::{Causality, Variability};
use sha2::{Digest, Sha256};

const MAGIC: [u8; 8] = *b"FMU2SNAP";
const VERSION: u32 = 1;
const DIGEST: usize = 32;

/// Serializes a state.
pub(crate) fn encode<S: CoSimulationUnit>(snapshot: &Snapshot<S>) -> Vec<u8> {
    let core = &snapshot.core;
    let mut bytes = Vec::from(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    let blob = |bytes: &mut Vec<u8>, blob: &[u8]| {
        bytes.extend(length(blob).to_le_bytes());
        bytes.extend(blob);
    };
    blob(&mut bytes, snapshot.guid.as_bytes());
    bytes.push(core.state as u8);
    for time in [core.experiment.map(|e| e.start_time), core.experiment.and_then(|e| e.stop_time)] {
        bytes.push(u8::from(time.is_some()));
        bytes.extend(time.iter().flat_map(|time| time.to_le_bytes()));
    }
    bytes.extend(core.time.to_le_bytes());
    bytes.push(u8::from(core.set_since_step));
    bytes.extend(length(&core.clipped).to_le_bytes());
    bytes.extend(core.clipped.iter().flat_map(|reference| reference.to_le_bytes()));
    bytes.extend(length(&core.input_derivatives).to_le_bytes());
    for (reference, derivative) in &core.input_derivatives {
        bytes.extend(reference.to_le_bytes());
        bytes.extend(derivative.to_le_bytes());
    }
    blob(&mut bytes, &core.unit.save());
    let digest = Sha256::digest(&bytes);
    bytes.extend(&digest[..]);
    bytes
}

fn length<T>(list: &[T]) -> u32 {
    // No state is that long; if one were, `decode` would reject the lengths.
    u32::try_from(list.len()).unwrap_or(u32::MAX)
}

impl<S: CoSimulationUnit> Instance<S> {
    /// Deserializes a state; the instance does not change.
    ///
    /// # Errors
    /// The reason why the bytes are not a state of this FMU.
    pub(crate) fn decode(&self, bytes: &[u8]) -> Result<Snapshot<S>, String> {
        if !bytes.starts_with(&MAGIC) {
            return Err("the bytes are not a serialized FMU state of this library".into());
        }
        let truncated = || {
            format!("the serialized FMU state is damaged: it is truncated to {} bytes", bytes.len())
        };
        let (content, digest) = bytes
            .split_last_chunk::<DIGEST>()
            .filter(|(c, _)| c.len() >= MAGIC.len())
            .ok_or_else(truncated)?;
        let mut reader = Reader { rest: &content[MAGIC.len()..] };
        let version = reader.u32().ok_or_else(truncated)?;
        if version != VERSION {
            return Err(format!(
                "the serialized FMU state has the layout version {version}; this library reads \
                 version {VERSION}"
            ));
        }
        let guid = reader.blob().ok_or_else(truncated)?;
        if guid != self.guid.as_bytes() {
            return Err(format!(
                "the serialized FMU state is of another FMU: its GUID is \"{}\", the GUID of this FMU \
                 is \"{}\"",
                String::from_utf8_lossy(guid),
                self.guid
            ));
        }
        if Sha256::digest(content)[..] != digest[..] {
            return Err("the serialized FMU state is damaged: its checksum is wrong".into());
        }
        let core = self
            .decode_core(&mut reader)
            .ok_or("the serialized FMU state has invalid values, or values of another model")?;
        Ok(Snapshot { core: core?, guid: self.guid.clone() })
    }

    /// The fields after the GUID, whose checksum is correct: `None` if they are invalid, an error if
    /// the unit rejects its bytes.
    fn decode_core(&self, reader: &mut Reader<'_>) -> Option<Result<Core<S>, String>> {
        let code = reader.byte()?;
        let state = State::ALL.into_iter().find(|state| *state as u8 == code)?;
        let (start_time, stop_time) = (reader.optional()?, reader.optional()?);
        let experiment = start_time.map(|start_time| Experiment { start_time, stop_time });
        let time = reader.finite()?;
        let set_since_step = reader.flag()?;
        let clipped = reader.list(Reader::u32)?;
        let input_derivatives = reader.list(|reader| Some((reader.u32()?, reader.finite()?)))?;
        let saved = reader.blob()?;
        let possible = state != State::Fatal
            && (experiment.is_some() || stop_time.is_none())
            && (experiment.is_some()
                || !matches!(state, State::Initialization | State::StepComplete))
            && clipped.iter().all(|reference| is_input::<S>(*reference))
            && input_derivatives.iter().all(|(reference, _)| is_continuous_input::<S>(*reference))
            && reader.rest.is_empty();
        if !possible {
            return None;
        }
        let mut unit = self.pristine.clone();
        if let Err(problem) = unit.load(saved) {
            return Some(Err(format!("the serialized FMU state cannot be loaded: {problem}")));
        }
        // The unit need not save them.
        for &(reference, derivative) in &input_derivatives {
            unit.set_input_derivative(S::Variable::from_reference(reference)?, derivative);
        }
        let core = Core {
            state,
            experiment,
            time,
            set_since_step,
            clipped,
            input_derivatives,
            ..Core::new(unit)
        };
        Some(Ok(core))
    }
}

fn is_input<S: CoSimulationUnit>(reference: u32) -> bool {
    S::Variable::from_reference(reference)
        .is_some_and(|variable| variable.spec().causality == Causality::Input)
}

/// Whether a value reference is an input whose derivative can be set.
fn is_continuous_input<S: CoSimulationUnit>(reference: u32) -> bool {
    S::Variable::from_reference(reference).is_some_and(|variable| {
        let row = variable.spec();
        row.causality == Causality::Input && row.variability == Variability::Continuous
    })
}

/// The bytes left to read.
struct Reader<'b> {
    rest: &'b [u8],
}

impl<'b> Reader<'b> {
    fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1)?.first().copied()
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    fn flag(&mut self) -> Option<bool> {
        match self.byte()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    fn finite(&mut self) -> Option<f64> {
        let value = f64::from_le_bytes(*self.take(8)?.first_chunk()?);
        if value.is_finite() { Some(value) } else { None }
    }

    fn optional(&mut self) -> Option<Option<f64>> {
        if self.flag()? { Some(Some(self.finite()?)) } else { Some(None) }
    }

    fn blob(&mut self) -> Option<&'b [u8]> {
        let length = self.u32()?;
        self.take(usize::try_from(length).ok()?)
    }

    fn list<T>(&mut self, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()?;
        // Memory is allocated item by item, so a wrong count allocates nothing.
        (0..count).map(|_| item(self)).collect()
    }
}
