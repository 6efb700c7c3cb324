//! A state as a file, and back.

use crate::Error;
use crate::structures::state_space::accumulated::Accumulated;
use crate::subspace::Accumulator;
use crate::validation::response::spectra::Sums;
use steerwright_formats::{AccumulatedDrives, AccumulatedSpeed, Document, Provenance};

const INPUT: &str = "model_input";

impl Accumulated {
    /// As a file that states are merged from.
    #[must_use]
    pub fn to_file(&self) -> AccumulatedDrives {
        let mut options = self.options.clone();
        options.insert("horizon".into(), self.horizon.to_string());
        options.insert(INPUT.into(), self.input_kind.name().into());
        AccumulatedDrives {
            schema: AccumulatedDrives::SCHEMA.into(),
            name: self.name.clone(),
            input: self.input_kind,
            steering_ratio: self.steering_ratio,
            sample_time_s: self.sample_time_s(),
            horizon: self.horizon,
            estimation_samples: self.estimation.samples(),
            validation_samples: self.validation.samples(),
            speed: self.speed().map(|(mean_mps, standard_deviation_mps)| AccumulatedSpeed {
                mean_mps,
                standard_deviation_mps,
            }),
            channels: self.channels.clone(),
            warnings: self.warnings.clone(),
            provenance: Provenance {
                version: self.version.clone(),
                sources: self.sources.clone(),
                options,
            },
            estimation: hex(&self.estimation.to_bytes()),
            validation: hex(&self.validation.to_bytes()),
            spectra: self.spectra.to_numbers(),
            sha256: String::new(),
        }
        .sealed()
    }

    /// The accumulated drives of a file; `name` is used in errors.
    ///
    /// # Errors
    /// [`Error::NoFactor`] where its states are none, or do not agree with the rest of the file.
    pub fn from_file(file: &AccumulatedDrives, name: &str) -> Result<Self, Error> {
        let no = |problem: String| Error::NoFactor { file: name.into(), problem };
        file.checked(name).map_err(|e| no(e.to_string()))?;
        let state = |text: &str, samples: usize| {
            let bytes = bytes(text).ok_or_else(|| no("a state is not hexadecimal".into()))?;
            let state = Accumulator::from_bytes(&bytes).map_err(|e| no(e.to_string()))?;
            let expected = (file.horizon, 1, 1, samples);
            let is = (state.horizon, state.inputs, state.outputs, state.samples());
            // What was written is read to the last bit.
            let same_time = state.sample_time_s().to_bits() == file.sample_time_s.to_bits();
            if is == expected && same_time && state.is_r_factor() {
                Ok(state)
            } else {
                Err(no("a state is not of the horizon, samples and sample time in the file".into()))
            }
        };
        let estimation = state(&file.estimation, file.estimation_samples)?;
        let validation = state(&file.validation, file.validation_samples)?;
        let length = Sums::of_sample_time(file.sample_time_s).length();
        let spectra = Sums::from_numbers(&file.spectra)
            .filter(|s| s.length() == length)
            .ok_or_else(|| no("the spectra are not of the sample time in the file".into()))?;
        let count = (estimation.samples() + validation.samples()) as f64;
        Ok(Self {
            name: file.name.clone(),
            input_kind: file.input,
            steering_ratio: file.steering_ratio,
            horizon: file.horizon,
            estimation,
            validation,
            spectra,
            speed: file
                .speed
                .map(|v| (count, v.mean_mps, count * v.standard_deviation_mps.powi(2))),
            channels: file.channels.clone(),
            warnings: file.warnings.clone(),
            sources: file.provenance.sources.clone(),
            options: file.provenance.options.clone(),
            version: file.provenance.version.clone(),
        })
    }
}

fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |d: u8| char::from(DIGITS[usize::from(d)]);
    bytes.iter().flat_map(|b| [digit(b >> 4), digit(b & 15)]).collect()
}

fn bytes(text: &str) -> Option<Vec<u8>> {
    let (pairs, odd) = text.as_bytes().as_chunks::<2>();
    let digit = |d: u8| char::from(d).to_digit(16);
    let byte = |[a, b]: &[u8; 2]| u8::try_from(16 * digit(*a)? + digit(*b)?).ok();
    if odd.is_empty() { pairs.iter().map(byte).collect() } else { None }
}
