//! A log whose compressed file is damaged after its start.

use super::{Group, Pieces, Recording, Request, Wanted};
use crate::Error;

/// The log up to the damage, which is one of its losses.
pub(super) struct Damaged<'a> {
    pub(super) recording: Box<dyn Recording + 'a>,
    pub(super) damage: Error,
}

impl Recording for Damaged<'_> {
    fn groups(&self) -> &[Group] {
        self.recording.groups()
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        self.recording.rows(request)
    }

    fn first_s(&self, wanted: &Wanted) -> Option<f64> {
        self.recording.first_s(wanted)
    }

    fn tolerate(&mut self, clock: Option<usize>, optional: Vec<usize>) {
        self.recording.tolerate(clock, optional);
    }

    fn losses(&self) -> Vec<String> {
        let damage = format!("{}: what comes after it is not read", self.damage);
        self.recording.losses().into_iter().chain([damage]).collect()
    }

    fn hashes_bytes(&self) -> bool {
        self.recording.hashes_bytes()
    }

    fn sha256(&mut self) -> Option<String> {
        self.recording.sha256()
    }
}
