//! The signals behind the plots of a model whose inputs and outputs have names: of any system, or of another
//! response than that of the yaw rate.

/// Signals on the recording's grid, in the units of the channels, or of the names where these have units.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelTraces {
    /// The log's time, s.
    pub time_s: Vec<f64>,
    /// Name and samples of each input.
    pub inputs: Vec<(String, Vec<f64>)>,
    /// Name, measured and simulated samples of each output, NaN where nothing is simulated; the simulation starts from an
    /// initial state at the first sample of each part of each segment; that of a lateral acceleration has none.
    pub outputs: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Whether the sample is validation data.
    pub is_validation: Vec<bool>,
}
