//! What a slave tells people during a call.

/// How much a line matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Shown where the importer has debug logging on.
    Info,
    /// Shown, and the call returns `fmi2Warning`.
    Warning,
}

/// Collects lines; the layer passes them to the importer's logger after the call.
#[derive(Debug, Default)]
pub struct Log {
    lines: Vec<(Level, String)>,
}

impl Log {
    /// Tells something of interest when looking for a fault.
    pub fn info(&mut self, text: impl Into<String>) {
        self.lines.push((Level::Info, text.into()));
    }

    /// Tells something that is not quite right, and makes the call return `fmi2Warning`. Of lines
    /// that differ in numbers only, the layer shows the first, the 10th, the 100th and so on.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.lines.push((Level::Warning, text.into()));
    }

    /// What was told so far.
    #[must_use]
    pub fn lines(&self) -> &[(Level, String)] {
        &self.lines
    }

    /// Takes the lines out, and keeps the memory where there are none.
    pub(crate) fn take(&mut self) -> Vec<(Level, String)> {
        std::mem::take(&mut self.lines)
    }
}
