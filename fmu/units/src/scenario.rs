//! The inputs of a reference run, as each unit states them.

use std::f64::consts::TAU;

/// An instant of a reference run.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Seconds from the start of the run.
    pub time: f64,
    /// Seconds of the scenario, which is ten long whatever the length of the run.
    pub course: f64,
}

/// The value of the input of that name from a moment on; `None` where it keeps its start value. Of a
/// Boolean 0 is false, of an Integer the whole part is meant.
type Script = dyn Fn(&str, Moment) -> Option<f64>;

/// What the inputs of a unit do in its reference run.
pub struct Scenario(Box<Script>);

impl std::fmt::Debug for Scenario {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Scenario")
    }
}

impl Scenario {
    pub(crate) fn new(script: impl Fn(&str, Moment) -> Option<f64> + 'static) -> Self {
        Self(Box::new(script))
    }

    /// The value of an input from that moment on; `None` where it keeps its start value.
    #[must_use]
    pub fn value(&self, input: &str, moment: Moment) -> Option<f64> {
        (self.0)(input, moment)
    }
}

/// Steering of a plant that was not identified from a drive, at the road wheel, rad.
pub(crate) const SCENARIO_ANGLE: f64 = 0.02;

/// Steering about a centre (rad) to both sides and in a weave, at a speed (m/s) that falls at the end.
pub(crate) fn steered(centre: f64, amplitude: f64, speed: f64) -> Scenario {
    Scenario::new(move |input, Moment { course: t, .. }| match input {
        "steering_angle" => Some(centre + amplitude * weave(t)),
        "speed" => Some(speed * if t < 8.0 { 1.0 } else { 0.95 }),
        _ => None,
    })
}

/// Nothing, left, right, then to and fro at 0.5 Hz and 1 Hz; in [−1, 1].
pub(crate) fn weave(t: f64) -> f64 {
    match t {
        t if t < 0.5 => 0.0,
        t if t < 2.0 => 1.0,
        t if t < 3.5 => -1.0,
        t if t < 7.5 => (TAU * 0.5 * (t - 3.5)).sin(),
        t => 0.5 * (TAU * (t - 7.5)).sin(),
    }
}
