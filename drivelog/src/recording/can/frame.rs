//! A frame of a bus, and what a line of a text is.

/// A frame with data.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Frame {
    /// Instant, s.
    pub(super) time: f64,
    pub(super) bus: String,
    pub(super) id: u32,
    pub(super) is_extended: bool,
    pub(super) data: Vec<u8>,
    /// Whether it is to be sent (`TxRq`), which is logged again when it was.
    pub(super) is_request: bool,
}

/// What a line is.
#[derive(Debug, PartialEq)]
pub(super) enum Line {
    Frame(Frame),
    /// A remote frame, an error frame, a comment or the like.
    Other,
    Fault,
}
