//! The faults: small changes of the valid archive, each with the one rule that it violates.

mod archive;
mod model;
mod text;

use super::{Files, base};

/// A fault.
pub(crate) struct Fault {
    /// Its name, for messages and files.
    pub(crate) name: &'static str,
    /// The rule that it violates.
    pub(crate) rule: &'static str,
    edit: Edit,
}

/// The change of the archive.
enum Edit {
    /// A replacement in modelDescription.xml.
    Xml(&'static str, &'static str),
    /// A change of the files.
    Files(fn(&mut Files)),
    /// A change of the archive's bytes.
    Bytes(fn(&mut Vec<u8>)),
    /// A change of the files and of the archive's bytes.
    Both(fn(&mut Files), fn(&mut Vec<u8>)),
}

impl Fault {
    /// The archive with the fault.
    pub(crate) fn archive(&self) -> Vec<u8> {
        let mut files = base();
        match self.edit {
            Edit::Xml(from, to) => files.replace(from, to),
            Edit::Files(edit) => edit(&mut files),
            Edit::Bytes(_) => {}
            Edit::Both(edit, _) => edit(&mut files),
        }
        let mut bytes = files.zip();
        if let Edit::Bytes(edit) | Edit::Both(_, edit) = self.edit {
            edit(&mut bytes);
        }
        bytes
    }
}

const fn fault(name: &'static str, rule: &'static str, edit: Edit) -> Fault {
    Fault { name, rule, edit }
}

/// Every fault.
pub(crate) fn faults() -> Vec<&'static Fault> {
    [text::FAULTS, model::FAULTS, archive::FAULTS].into_iter().flatten().collect()
}
