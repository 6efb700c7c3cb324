//! `ReferencePath`: the glue from [`steerwright_models::PathFollower`] to the export trait.

use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::reference_path::Variable as V;
use fmi2_export::{Capabilities, Log, Resources, Slave};
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use steerwright_models::{GuidanceParameters, GuidanceSchedule, PathFollower, PathOutput};

/// A reference road and the guidance along it.
#[derive(Debug, Clone)]
pub struct ReferencePath {
    guidance: GuidanceParameters,
    /// The guidance over speed, where the path states it.
    schedule: Option<GuidanceSchedule>,
    inputs: Inputs,
    follower: PathFollower,
    phase: Phase,
    /// The last outputs before the first step, and the inputs that they are of: each read of an
    /// output would search the whole path again.
    searched: Option<(Inputs, PathOutput)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Inputs {
    x: f64,
    y: f64,
    yaw: f64,
    speed: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum Phase {
    /// Before the first step: outputs are those of the present inputs at each read. The first step
    /// goes on from the place on the path of `last_read`.
    BeforeFirstStep { last_read: Inputs },
    /// From then on: outputs are those of the last step.
    Running(PathOutput),
}

/// All but the path itself.
#[derive(Serialize, Deserialize)]
struct Saved {
    guidance: GuidanceParameters,
    inputs: Inputs,
    progress: Option<f64>,
    integral: f64,
    phase: Phase,
}

impl ReferencePath {
    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    #[inline]
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let g = &mut self.guidance;
        Some(match variable {
            V::X => &mut self.inputs.x,
            V::Y => &mut self.inputs.y,
            V::Yaw => &mut self.inputs.yaw,
            V::Speed => &mut self.inputs.speed,
            V::LookaheadTime => &mut g.lookahead_time,
            V::LookaheadMin => &mut g.lookahead_min,
            V::PreviewTime => &mut g.preview_time,
            V::FeedforwardGain => &mut g.feedforward_gain,
            V::SideslipPerYawRate => &mut g.sideslip.per_yaw_rate,
            V::CrossTrackIntegralGain => &mut g.cross_track_integral_gain,
            V::YawAccelerationGain => &mut g.yaw_acceleration_gain,
            V::YawJerkGain => &mut g.yaw_jerk_gain,
            V::SideslipPerYawAcceleration => &mut g.sideslip.per_yaw_acceleration,
            V::SideslipGrowth => &mut g.sideslip.growth,
            V::SideslipReferenceSpeed => &mut g.sideslip.reference_speed,
            V::DistanceRear => &mut g.sideslip.distance_rear,
            V::YawReference | V::SteeringFeedforward | V::CrossTrackError | V::HeadingError => {
                return None;
            }
            V::Curvature | V::Distance | V::Finished => return None,
        })
    }

    /// The parameters that act at a speed, m/s.
    fn acting(&self, speed: f64) -> GuidanceParameters {
        let schedule = self.schedule.as_ref();
        schedule.map_or(self.guidance, |schedule| schedule.at(&self.guidance, speed))
    }

    fn evaluate(&self, inputs: &Inputs) -> PathOutput {
        let Inputs { x, y, yaw, speed } = *inputs;
        self.follower.evaluate(&self.acting(speed), x, y, yaw, speed)
    }

    /// The outputs before the first step.
    fn search(&mut self, inputs: Inputs) -> PathOutput {
        match self.searched {
            Some((of, output)) if of == inputs => output,
            _ => {
                let output = self.evaluate(&inputs);
                self.searched = Some((inputs, output));
                output
            }
        }
    }

    fn output(&mut self) -> PathOutput {
        match &mut self.phase {
            Phase::Running(output) => *output,
            Phase::BeforeFirstStep { last_read } => {
                *last_read = self.inputs;
                self.search(self.inputs)
            }
        }
    }
}

impl Slave for ReferencePath {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between steps, and a path of points has no derivatives by the inputs.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let path = required::<steerwright_formats::Path>(resources, "path.json")?;
        let geometry = steerwright_loading::path_geometry(&path)
            .map_err(|e| format!("path.json: {e}; hint: {}", e.hint()))?;
        let (x, y, yaw) =
            path.points.first().map_or((0.0, 0.0, 0.0), |p| (p.x_m, p.y_m, p.heading_rad));
        let inputs = Inputs { x, y, yaw, speed: path.speed_mps };
        let slave = Self {
            guidance: steerwright_loading::guidance_parameters(&path.guidance, path.speed_mps),
            schedule: steerwright_loading::guidance_schedule(&path),
            inputs,
            follower: PathFollower::new(Arc::new(geometry)),
            phase: Phase::BeforeFirstStep { last_read: inputs },
            searched: None,
        };
        with_start_values(slave, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::YawReference => self.output().yaw_reference,
            V::SteeringFeedforward => self.output().steering_feedforward,
            V::CrossTrackError => self.output().cross_track_error,
            V::HeadingError => self.output().heading_error,
            V::Curvature => self.output().curvature,
            V::Distance => self.output().distance,
            V::Finished => return Value::Boolean(self.output().finished),
            other => self.number(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        // A parameter may change the outputs of the same inputs.
        if !matches!(variable, V::X | V::Y | V::Yaw | V::Speed) {
            self.searched = None;
        }
        if let (Value::Real(value), Some(place)) = (value, self.number(variable)) {
            *place = *value;
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.phase = Phase::BeforeFirstStep { last_read: self.inputs };
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log) -> Result<(), String> {
        if let Phase::BeforeFirstStep { last_read } = self.phase {
            let start = self.search(last_read);
            start.check().map_err(|e| refuse(&e))?;
            self.follower.commit(&start);
        }
        let output = self.evaluate(&self.inputs);
        output.check().map_err(|e| refuse(&e))?;
        self.follower.commit(&output);
        let guidance = self.acting(self.inputs.speed);
        self.follower.integrate(&guidance, &output, self.inputs.speed, step);
        self.phase = Phase::Running(output);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&Saved {
            guidance: self.guidance,
            inputs: self.inputs,
            progress: self.follower.progress(),
            integral: self.follower.integral(),
            phase: self.phase.clone(),
        })
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let saved: Saved = decode(bytes)?;
        let mut loaded = self.clone();
        loaded.follower.restore(saved.progress, saved.integral).map_err(|e| refuse(&e))?;
        match &saved.phase {
            Phase::BeforeFirstStep { last_read: Inputs { x, y, yaw, speed } } => {
                if [x, y, yaw, speed].iter().any(|value| !value.is_finite()) {
                    return Err("an input of the saved state is not finite".into());
                }
            }
            Phase::Running(output) => output.check().map_err(|e| refuse(&e))?,
        }
        loaded.guidance = saved.guidance;
        loaded.inputs = saved.inputs;
        loaded.phase = saved.phase;
        loaded.searched = None;
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
