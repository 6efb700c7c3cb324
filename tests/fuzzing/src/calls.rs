//! Random sequences of calls through the C boundary, of every FMU.
//!
//! The bytes choose an FMU, then calls with their arguments: references and values that exist and
//! that do not, NULL, NaN, lengths of zero. What is held:
//!
//! * every call returns a status of the standard, and never `fmi2Fatal`, which only a panic makes;
//! * after `fmi2Error` no step succeeds until `fmi2Reset` or `fmi2SetFMUstate` did;
//! * what can be read is finite;
//! * an FMU state gives back, bit for bit, what could be read when it was taken, also after having
//!   been serialized; a blob with any byte changed is refused.

mod importer;

use crate::cursor::Cursor;
use crate::documents::{BICYCLE, DELAYED, ESTIMATOR, LONGITUDINAL, PATH, PID, PLANT, VEHICLE};
use fmi2_export::CoSimulationUnit;
use importer::Importer;
use std::path::PathBuf;
use std::sync::OnceLock;
use steerwright_units::{
    BicyclePlant, IdentifiedPlant, LateralPid, LongitudinalPlant, NonlinearVehicle, PoseEstimator,
    ReferencePath,
};

/// Calls in one sequence, at most.
const LONGEST: usize = 400;

/// Runs the sequence that the bytes encode.
pub(crate) fn calls(bytes: &[u8]) {
    let mut cursor = Cursor::new(bytes);
    match chosen(cursor.byte()) {
        0 => sequence::<IdentifiedPlant>(&mut cursor, "plant.json", PLANT),
        1 => sequence::<IdentifiedPlant>(&mut cursor, "plant.json", DELAYED),
        2 => sequence::<BicyclePlant>(&mut cursor, "bicycle.json", BICYCLE),
        3 => sequence::<LateralPid>(&mut cursor, "pid.json", PID),
        4 => sequence::<ReferencePath>(&mut cursor, "path.json", PATH),
        5 => sequence::<NonlinearVehicle>(&mut cursor, "vehicle.json", VEHICLE),
        7 => sequence::<LongitudinalPlant>(&mut cursor, "longitudinal.json", LONGITUDINAL),
        _ => sequence::<PoseEstimator>(&mut cursor, "estimator.json", ESTIMATOR),
    }
}

/// Which document a byte chooses: the six of old as before, so that the corpora keep their meaning,
/// and the newest from what was left over.
pub(crate) const fn chosen(byte: u8) -> u8 {
    match byte {
        0..204 => byte % 6,
        204..230 => 6,
        _ => 7,
    }
}

fn sequence<S: CoSimulationUnit>(cursor: &mut Cursor<'_>, name: &str, document: &'static [u8]) {
    let mut importer = Importer::<S>::new(&folder(name, document), name, document);
    let mut made = 0;
    while made < LONGEST && !cursor.is_empty() {
        importer.call(cursor);
        made += 1;
    }
}

/// A folder, made once, that holds the document alone.
fn folder(name: &str, document: &'static [u8]) -> PathBuf {
    static FOLDERS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let root = FOLDERS.get_or_init(|| tempfile::tempdir().expect("a temporary folder"));
    let folder = root.path().join(format!("{}-{}", document.len(), name));
    let file = folder.join(name);
    if !file.is_file() {
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(&file, document).expect("a file");
    }
    folder
}
