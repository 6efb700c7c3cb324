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
use crate::documents::chosen;
use importer::Importer;
use std::path::PathBuf;
use std::sync::OnceLock;
use steerwright_units::{Definition, Visitor};

/// Calls in one sequence, at most.
const LONGEST: usize = 400;

/// Runs the sequence that the bytes encode.
pub(crate) fn calls(bytes: &[u8]) {
    let mut cursor = Cursor::new(bytes);
    let (fmu, document) = chosen(cursor.byte());
    fmu.visit(Sequence { cursor, document: document.as_bytes() });
}

/// The calls that the bytes encode, of one FMU.
struct Sequence<'a> {
    cursor: Cursor<'a>,
    document: &'static [u8],
}

impl Visitor for Sequence<'_> {
    type Output = ();

    fn visit<S: Definition>(mut self) {
        let folder = folder(S::RESOURCE, self.document);
        let mut importer = Importer::<S>::new(&folder, S::RESOURCE, self.document);
        let mut made = 0;
        while made < LONGEST && !self.cursor.is_empty() {
            importer.call(&mut self.cursor);
            made += 1;
        }
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
