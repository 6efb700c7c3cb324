//! An open file: its records, what they declare, and its groups.

use super::content::Content;
use super::records::View;
use super::topic::Topic;
use crate::Error;
use crate::recording::Group;
use std::io;

pub(super) struct Mcap {
    pub(super) file: String,
    pub(super) view: View,
    pub(super) content: Content,
    pub(super) groups: Vec<Group>,
    pub(super) topics: Vec<Topic>,
}

impl Mcap {
    pub(super) fn failed(&self, byte: u64, error: &io::Error) -> Error {
        Error::Read { file: self.file.clone(), byte, problem: error.to_string() }
    }
}
