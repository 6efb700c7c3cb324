//! MCAP files with messages of ROS 2 or in JSON: a topic is a group, a number in its messages a channel.
//!
//! The summary at the end of the file states which chunks hold which topics and times, and only those that are
//! wanted are read. A file without one is read once when it is opened. Messages come in the order of their log
//! times, and of a topic in that of its stamps.

mod chunk;
mod content;
mod file;
mod json;
mod records;
mod rows;
mod topic;

use super::bytes::{Head, LogFile};
use super::ros::Definitions;
use super::{Group, Pieces, Recording, Request};
use crate::Error;
use crate::options::LogOptions;
use content::Content;
use file::Mcap;
use records::{MAGIC, View};
use rows::McapReader;
use std::io;
use topic::{Messages, Topic};

pub(super) fn recognises(head: &Head<'_>) -> bool {
    head.start.starts_with(MAGIC)
}

/// Opens a file; reads its summary, or all of it.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    options: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let failed = |error: io::Error| Error::Read {
        file: file.name.clone(),
        byte: 0,
        problem: error.to_string(),
    };
    let mut view = View::new(file.sought()?).map_err(failed)?;
    let content = Content::open(&mut view).map_err(failed)?;
    let (groups, topics) =
        topic::topics(&file.name, &content, Definitions(&options.ros_definitions));
    if groups.is_empty() {
        let problem = content.losses.first().cloned();
        let problem = problem.unwrap_or_else(|| "the MCAP file has no messages".into());
        return Err(Error::Read { file: file.name, byte: MAGIC.len() as u64, problem });
    }
    Ok(Box::new(Mcap { file: file.name, view, content, groups, topics }))
}

impl Topic {
    /// Why its messages are not read, or not to their end.
    fn unread(&self) -> Option<String> {
        match &self.messages {
            Messages::Unread(why) => Some(why.clone()),
            Messages::Ros(layout) => {
                layout.ends_at.as_ref().map(|what| format!("{what} are not read"))
            }
            Messages::Json(_) => None,
        }
    }
}

impl Recording for Mcap {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        Ok(Box::new(McapReader::new(self, &request)))
    }

    fn losses(&self) -> Vec<String> {
        self.content.losses.clone()
    }
}
