//! The archives of all FMUs, packed, unpacked and loaded once.

use crate::api::Api;
use model_description::{
    Causality, CoSimulation, Initial, Kind, ModelDescription, Variability, Variable,
};
use std::ffi::c_int;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use steerwright_host::Archive;
use steerwright_packaging::{Binary, Fmu};

/// An unpacked FMU.
pub(crate) struct Sample {
    pub(crate) fmu: Fmu,
    pub(crate) description: ModelDescription,
    pub(crate) library: PathBuf,
    pub(crate) folder: PathBuf,
    pub(crate) api: Api,
    /// Keeps the unpacked folder.
    _archive: Archive,
}

static SAMPLES: OnceLock<Vec<Sample>> = OnceLock::new();

/// Every FMU.
pub(crate) fn samples() -> &'static [Sample] {
    SAMPLES.get_or_init(|| {
        // SAFETY: C's function of that name; what it is given is a function of this program.
        unsafe { atexit(clean_up) };
        Fmu::ALL.into_iter().map(unpacked).collect()
    })
}

// SAFETY: as C declares it (7.22.4.2).
unsafe extern "C" {
    fn atexit(function: extern "C" fn()) -> c_int;
}

/// Deletes the unpacked folders, since statics are not dropped.
extern "C" fn clean_up() {
    for sample in SAMPLES.get().into_iter().flatten() {
        let _ = std::fs::remove_dir_all(&sample.folder);
    }
}

/// The FMU of that name.
pub(crate) fn sample(name: &str) -> &'static Sample {
    samples().iter().find(|sample| sample.fmu.name() == name).expect(name)
}

/// Packs and unpacks an FMU.
fn unpacked(fmu: Fmu) -> Sample {
    let binaries: Vec<Binary<'_>> = steerwright_binaries::libraries_of(fmu.name())
        .map(|library| Binary { platform: library.platform, bytes: library.bytes })
        .collect();
    let packed =
        steerwright_packaging::package(fmu.example(), fmu.resource(), &binaries, None, None)
            .unwrap();
    let archive = Archive::from_bytes(&packed.bytes, fmu.name()).unwrap();
    let (library, folder) = (archive.binary().unwrap(), archive.folder().to_owned());
    let description = archive.model().description().clone();
    let api = Api::load(&library);
    Sample { fmu, description, library, folder, api, _archive: archive }
}

impl Sample {
    pub(crate) fn name(&self) -> &'static str {
        self.fmu.name()
    }

    /// The URI of its `resources` folder, as RFC 8089 has it.
    pub(crate) fn uri(&self) -> String {
        uri_of(&self.folder.join("resources"))
    }

    /// The capabilities in the description.
    pub(crate) fn flags(&self) -> &CoSimulation {
        self.description.co_simulation.as_ref().unwrap()
    }

    /// The step size that its description advises, s.
    pub(crate) fn step(&self) -> f64 {
        self.description.default_experiment.and_then(|e| e.step_size).unwrap()
    }

    pub(crate) fn variables(&self) -> &[Variable] {
        &self.description.variables
    }

    /// The variables of one kind and causality.
    pub(crate) fn of(&self, kind: Kind, causality: Causality) -> impl Iterator<Item = &Variable> {
        self.variables().iter().filter(move |v| v.kind == kind && v.causality == causality)
    }

    /// The value reference of a variable.
    pub(crate) fn reference(&self, name: &str) -> u32 {
        self.description.variable(name).expect(name).reference
    }

    /// The continuous Real variables of that causality.
    pub(crate) fn continuous(&self, causality: Causality) -> Vec<&Variable> {
        let continuous = |v: &&Variable| v.variability == Variability::Continuous;
        self.of(Kind::Real, causality).filter(continuous).collect()
    }
}

/// Whether a variable has a start value that may be set before the start.
pub(crate) fn is_exact(variable: &Variable) -> bool {
    variable.effective_initial() == Some(Initial::Exact)
}

/// The `file:` URI of a folder whose path needs no escapes.
pub(crate) fn uri_of(folder: &Path) -> String {
    let path = folder.display().to_string().replace('\\', "/");
    format!("file:///{}", path.trim_start_matches('/'))
}
