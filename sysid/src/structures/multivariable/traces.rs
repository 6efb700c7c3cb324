//! The signals behind the plots of a plant of named channels.

/// Signals on the recording's grid, in the units of the channels.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelTraces {
    /// The log's time, s.
    pub time_s: Vec<f64>,
    /// Name and samples of each input.
    pub inputs: Vec<(String, Vec<f64>)>,
    /// Name, measured and simulated samples of each output; the simulation starts from an initial state at the first
    /// sample of each part of each segment.
    pub outputs: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Whether the sample is validation data.
    pub is_validation: Vec<bool>,
}
