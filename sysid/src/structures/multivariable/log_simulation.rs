//! A log simulated by a plant of named channels that is known, and how well it fits.

use crate::Error;
use crate::data::Segment;
use crate::model::StateSpace;
use crate::selection::initial_conditions::InitialConditions;
use crate::selection::order::errors;
use crate::structures::multivariable::evidence::fit_of;
use crate::structures::multivariable::{Channel, ChannelTraces, channels, delays, part};
use crate::structures::state_space::automatic::{Unit, Units};
use faer::Mat;
use steerwright_drivelog::{DriveLog, Response};
use steerwright_formats::{Matrix, MultivariablePlant};

/// A log and its simulation by a plant.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSimulation {
    /// The signals; every sample is validation data.
    pub traces: ChannelTraces,
    /// Fit of each output over all segments, `100·(1 − ‖y − ŷ‖/‖y − mean(y)‖)`, percent.
    pub fits: Vec<f64>,
}

/// Simulates the plant from the inputs of a log alone, each segment from the initial state that fits it best.
///
/// # Errors
/// [`Error::ChannelsNeeded`], and [`Error::OtherChannels`] where the log's number of channels, their units or the sample time
/// are not those of the plant.
pub fn simulate_log(plant: &MultivariablePlant, log: &DriveLog) -> Result<LogSimulation, Error> {
    if log.response != Response::Channels {
        return Err(Error::ChannelsNeeded { response: log.response });
    }
    let [inputs, outputs] = channels(log);
    check(plant, log, [&inputs, &outputs])?;
    let whole: Vec<_> = log.segments.iter().map(|segment| segment.range.clone()).collect();
    let units = Units {
        input: unit(plant.inputs.iter().map(|c| (c.offset, c.standard_deviation))),
        output: unit(plant.outputs.iter().map(|c| (c.offset, c.standard_deviation))),
    };
    let data = units.scaled(&part(log, &inputs, &outputs, &whole)?)?;
    let delay = plant.inputs.iter().map(|c| (c.delay_s / log.sample_time_s).round() as usize);
    let data = delays::delayed(&data, &delay.collect::<Vec<_>>())?;
    let discrete = &plant.discrete;
    let [a, b, c, d] = [&discrete.a, &discrete.b, &discrete.c, &discrete.d].map(dense);
    // Of signals in units of their deviations.
    let inverse = |scales: &[f64]| scales.iter().map(|scale| 1.0 / scale).collect::<Vec<_>>();
    let (u, y) = (inverse(&units.input.scales), inverse(&units.output.scales));
    let model = StateSpace { a, b, c, d }.scaled(&u, &y);
    let x0 = InitialConditions::new(&model, &data, false)?.x0;
    let left = errors(&model, &x0, &data);
    let mut simulated: Vec<Vec<f64>> = outputs.iter().map(|c| c.samples.to_vec()).collect();
    for ((errors, segment), range) in left.iter().zip(data.segments()).zip(&whole) {
        for (i, simulated) in simulated.iter_mut().enumerate() {
            for (t, at) in range.clone().enumerate().take(Segment::len(segment)) {
                simulated[at] -= units.output.scales[i] * errors[(i, t)];
            }
        }
    }
    let fits = (0..outputs.len()).map(|i| fit_of(&data, &left, i)).collect();
    let named = |c: &Channel<'_>| (c.name.clone(), c.samples.to_vec());
    let measured = outputs.iter().map(named);
    let traces = ChannelTraces {
        time_s: log.time_s(),
        inputs: inputs.iter().map(named).collect(),
        outputs: measured
            .zip(simulated)
            .map(|((name, y), simulated)| (name, y, simulated))
            .collect(),
        is_validation: vec![true; log.len()],
    };
    Ok(LogSimulation { traces, fits })
}

/// Rejects a log whose channels are not those of the plant.
fn check(
    plant: &MultivariablePlant,
    log: &DriveLog,
    [inputs, outputs]: [&[Channel<'_>]; 2],
) -> Result<(), Error> {
    let expected = [
        ("input", inputs, units_of(&plant.inputs, |c| &c.unit)),
        ("output", outputs, units_of(&plant.outputs, |c| &c.unit)),
    ];
    for (kind, found, expected) in expected {
        if found.len() != expected.len() {
            let problem = format!(
                "the plant has {} {kind}s, and {} are named in the log",
                expected.len(),
                found.len()
            );
            return Err(Error::OtherChannels { problem });
        }
        for (channel, unit) in found.iter().zip(expected) {
            if channel.unit != unit {
                let problem = format!(
                    "the {kind} `{}` of the log has the unit {}, that of the plant {unit}",
                    channel.column, channel.unit
                );
                return Err(Error::OtherChannels { problem });
            }
        }
    }
    let step = plant.discrete.sample_time_s;
    if (log.sample_time_s / step - 1.0).abs() > 1e-9 {
        let problem =
            format!("the log was sampled at {} s, the plant at {step} s", log.sample_time_s);
        return Err(Error::OtherChannels { problem });
    }
    Ok(())
}

fn units_of<C>(channels: &[C], unit: fn(&C) -> &String) -> Vec<&str> {
    channels.iter().map(|channel| unit(channel).as_str()).collect()
}

fn unit(channels: impl Iterator<Item = (f64, f64)>) -> Unit {
    let (means, scales) = channels.unzip();
    Unit { means, scales }
}

fn dense(matrix: &Matrix) -> Mat<f64> {
    Mat::from_fn(matrix.rows(), matrix.columns().unwrap_or(0), |i, j| matrix.entry(i, j))
}
