//! Reading documents, and what stops or warns before they are used.

pub(crate) mod feasibility;
pub(crate) mod files;
pub(crate) mod gate;
pub(crate) mod ros_definitions;
