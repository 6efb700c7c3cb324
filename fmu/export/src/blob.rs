//! FMU states as bytes, to be loaded by another instance of the same FMU, in any process.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | [`MAGIC`] |
//! | 4 | [`VERSION`] of this layout |
//! | 4 + n | GUID: library, table and resources |
//! | 1 | state of the machine |
//! | 1 (+ 8) + 1 (+ 8) | start and stop time, each after a byte that says whether it is there, s |
//! | 8 | where the next step begins, s |
//! | 1 | whether something was set since the last step |
//! | 4 + 4 n | value references of inputs whose clipping was told |
//! | 4 + 12 n | value references and derivatives of inputs that grow within the next step |
//! | 4 + n | what [`Slave::save`] gave |
//! | 32 | SHA-256 of all bytes before |
//!
//! Numbers are little-endian. The digest is the one that makes the GUID already, so that it costs no
//! further code, and finds any corruption, not only short ones as a CRC does. It is no signature:
//! everything is looked at again when it is read. What is missing on purpose: what was told, which
//! is the importer's log and no state, and the settings of that log.

use crate::calls::State;
use crate::instance::{Core, Experiment, Instance, Snapshot};
use crate::{Slave, VariableId};
use model_description::{Causality, Variability};
use sha2::{Digest, Sha256};

const MAGIC: [u8; 8] = *b"FMU2SNAP";
const VERSION: u32 = 1;
const DIGEST: usize = 32;

/// The bytes of a state.
pub(crate) fn encode<S: Slave>(snapshot: &Snapshot<S>) -> Vec<u8> {
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
    blob(&mut bytes, &core.slave.save());
    let digest = Sha256::digest(&bytes);
    bytes.extend(&digest[..]);
    bytes
}

fn length<T>(list: &[T]) -> u32 {
    // No slave's state is that long; if one were, the reader would find the lengths wrong.
    u32::try_from(list.len()).unwrap_or(u32::MAX)
}

impl<S: Slave> Instance<S> {
    /// The state in some bytes; nothing changes.
    pub(crate) fn decode(&self, bytes: &[u8]) -> Result<Snapshot<S>, String> {
        if !bytes.starts_with(&MAGIC) {
            return Err("the bytes are no serialized FMU state of this layer".into());
        }
        let truncated = || {
            format!(
                "the serialized FMU state is damaged: it ends too soon, at {} bytes",
                bytes.len()
            )
        };
        let (content, digest) = bytes
            .split_last_chunk::<DIGEST>()
            .filter(|(c, _)| c.len() >= MAGIC.len())
            .ok_or_else(truncated)?;
        let mut reader = Reader { rest: &content[MAGIC.len()..] };
        let version = reader.u32().ok_or_else(truncated)?;
        if version != VERSION {
            return Err(format!(
                "the serialized FMU state has the layout version {version}, this library reads \
                 version {VERSION} only"
            ));
        }
        let guid = reader.blob().ok_or_else(truncated)?;
        if guid != self.guid.as_bytes() {
            return Err(format!(
                "the serialized FMU state is of another FMU: its GUID is \"{}\", that of this one \
                 is \"{}\"",
                String::from_utf8_lossy(guid),
                self.guid
            ));
        }
        if Sha256::digest(content)[..] != digest[..] {
            return Err("the serialized FMU state is damaged: its checksum is wrong".into());
        }
        let core = self.decode_core(&mut reader).ok_or(
            "the serialized FMU state has values that none can have, or others than it should",
        )?;
        Ok(Snapshot { core: core?, guid: self.guid.clone() })
    }

    /// The rest of the bytes, which are whole but may still be anything: `None` if they are no
    /// state, an error if the slave refuses its part.
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
            && input_derivatives.iter().all(|(reference, _)| grows::<S>(*reference))
            && reader.rest.is_empty();
        if !possible {
            return None;
        }
        let mut slave = self.pristine.clone();
        if let Err(problem) = slave.load(saved) {
            return Some(Err(format!("the serialized FMU state cannot be loaded: {problem}")));
        }
        // Whether the slave saves them or not.
        for &(reference, derivative) in &input_derivatives {
            slave.set_input_derivative(S::Variable::from_reference(reference)?, derivative);
        }
        let core = Core {
            state,
            experiment,
            time,
            set_since_step,
            clipped,
            input_derivatives,
            ..Core::new(slave)
        };
        Some(Ok(core))
    }
}

fn is_input<S: Slave>(reference: u32) -> bool {
    S::Variable::from_reference(reference)
        .is_some_and(|variable| variable.spec().causality == Causality::Input)
}

/// Whether it is an input whose derivative can be set.
pub(crate) fn grows<S: Slave>(reference: u32) -> bool {
    S::Variable::from_reference(reference).is_some_and(|variable| {
        let row = variable.spec();
        row.causality == Causality::Input && row.variability == Variability::Continuous
    })
}

/// What is left to read.
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
        value.is_finite().then_some(value)
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
        // No memory is taken for a count that the bytes do not bear out.
        (0..count).map(|_| item(self)).collect()
    }
}
