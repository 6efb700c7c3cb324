//! `ReferencePath`: the glue from [`steerwright_models::PathFollower`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario};
use fmi2_export::{Capabilities, CoSimulationUnit, Log, Resources, variables};
use model_description::DependsOn::Nothing;
use model_description::{Table, Value};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;
use steerwright_formats::{Path, PathPoint};
use steerwright_models::{
    GuidanceParameters, GuidanceSchedule, GuidanceState, PathFollower, PathOutput, SpeedReference,
};

variables! {
    /// Variables of the path follower. Its outputs are evaluated in a step, from the inputs set
    /// before it, so at a communication point they depend on no input.
    Variable of ReferencePath, "ReferencePath", "reference road and guidance along it: pose in, yaw reference, feedforward and speed reference out";
    X = 0, real "x", Input, Continuous, at inputs.x,
        .unit("m").nominal(100.0).description("position of the vehicle");
    Y = 1, real "y", Input, Continuous, at inputs.y,
        .unit("m").nominal(100.0).description("position of the vehicle");
    Yaw = 2, real "yaw", Input, Continuous, at inputs.yaw,
        .unit("rad").display_unit("deg").description("yaw of the vehicle, positive to the left");
    Speed = 3, real "speed", Input, Continuous, at inputs.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed of the vehicle");
    SideslipPerYawRateOffset = 4, real "sideslip_per_yaw_rate_offset", Input, Continuous, at parameters.sideslip_per_yaw_rate_offset,
        .unit("s").nominal(0.01).description("what the sideslip angle per yaw rate is beyond that of the parameters, as an estimator has learnt");
    YawReference = 10, real "yaw_reference", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).description("yaw to steer for, not wrapped");
    SteeringFeedforward = 11, real "steering_feedforward", Output, Continuous,
        .unit("rad").display_unit("deg").nominal(0.1).depends_on(Nothing).description("steering angle for the curvature");
    CrossTrackError = 12, real "cross_track_error", Output, Continuous,
        .unit("m").depends_on(Nothing).description("distance from the path, positive to its left");
    HeadingError = 13, real "heading_error", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).description("yaw minus the path's heading, in (-pi, pi]");
    Curvature = 14, real "curvature", Output, Continuous,
        .unit("1/m").nominal(0.01).depends_on(Nothing).description("curvature of the path at the vehicle, positive to the left");
    Distance = 15, real "distance", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).description("distance along the path");
    Finished = 16, boolean "finished", Output, Discrete,
        .depends_on(Nothing).description("whether the path's end is reached");
    SideslipCorrection = 17, real "sideslip_correction", Output, Continuous,
        .unit("s").nominal(0.1).depends_on(Nothing).description("what the cross-track error of turns has added to the sideslip angle per yaw rate");
    SpeedReference = 18, real "speed_reference", Output, Continuous,
        .unit("m/s").display_unit("km/h").nominal(10.0).depends_on(Nothing).description("speed of the profile at the vehicle, or a preview time ahead; without a profile the speed that the path was made for");
    AccelerationReference = 19, real "acceleration_reference", Output, Continuous,
        .unit("m/s2").depends_on(Nothing).description("acceleration of the profile at the vehicle, or a preview time ahead; without a profile 0");
    LookaheadTime = 20, real "lookahead_time", Parameter, Tunable, at parameters.guidance.lookahead_time_s,
        .unit("s").min(0.0).description("look-ahead distance over speed");
    LookaheadMin = 21, real "lookahead_min", Parameter, Tunable, at parameters.guidance.lookahead_min_m,
        .unit("m").min(0.01).nominal(10.0).description("least look-ahead distance");
    PreviewTime = 22, real "preview_time", Parameter, Tunable, at parameters.guidance.preview_time_s,
        .unit("s").min(0.0).description("how far ahead heading and curvature are read");
    FeedforwardGain = 23, real "feedforward_gain", Parameter, Tunable, at parameters.guidance.feedforward_gain_radm,
        .unit("rad.m").display_unit("deg.m").nominal(10.0).description("steering angle per curvature");
    SideslipPerYawRate = 24, real "sideslip_per_yaw_rate", Parameter, Tunable, at parameters.guidance.sideslip_per_yaw_rate_s,
        .unit("s").nominal(0.1).description("sideslip angle per yaw rate in a steady turn");
    CrossTrackIntegralGain = 25, real "cross_track_integral_gain", Parameter, Tunable, at parameters.guidance.cross_track_integral_gain_per_s,
        .unit("1/s").min(0.0).nominal(0.1).description("how fast the integral of the cross-track error grows; 0: there is none");
    SideslipPerYawAcceleration = 26, real "sideslip_per_yaw_acceleration", Parameter, Tunable, at parameters.guidance.sideslip_per_yaw_acceleration_s2,
        .unit("s2").nominal(0.01).description("sideslip angle per yaw acceleration; 0: not known");
    SideslipGrowth = 27, real "sideslip_growth", Parameter, Tunable, at parameters.guidance.sideslip_growth_s5pm2,
        .unit("s5/m2").nominal(0.001).description("what the sideslip per yaw rate grows by, per squared lateral acceleration");
    YawAccelerationGain = 28, real "yaw_acceleration_gain", Parameter, Tunable, at parameters.guidance.yaw_acceleration_gain_s2,
        .unit("s2").nominal(0.01).description("what of the path's yaw acceleration is added to the yaw reference");
    YawJerkGain = 29, real "yaw_jerk_gain", Parameter, Tunable, at parameters.guidance.yaw_jerk_gain_s3,
        .unit("s3").nominal(0.001).description("what of the path's yaw jerk is added to the yaw reference");
    SideslipReferenceSpeed = 30, real "sideslip_reference_speed", Parameter, Tunable, at parameters.reference_speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("speed at which the sideslip parameters hold");
    DistanceRear = 31, real "distance_rear", Parameter, Tunable, at parameters.guidance.distance_rear_m,
        .unit("m").min(0.0).description("distance from centre of gravity to rear axle, by which the sideslip follows the speed; 0: not known, the sideslip parameters hold at all speeds");
    SideslipCorrectionTime = 32, real "sideslip_correction_time", Parameter, Tunable, at parameters.guidance.sideslip_correction_time_s,
        .unit("s").min(0.0).description("how long the cross-track error of turns takes to correct the sideslip angle per yaw rate; 0: there is no correction");
    SpeedPreviewTime = 33, real "speed_preview_time", Parameter, Tunable, at parameters.guidance.speed_preview_time_s,
        .unit("s").min(0.0).description("how far ahead in time the speed profile is read: lag and delay of the drive");
    BrakePreviewTime = 34, real "brake_preview_time", Parameter, Tunable, at parameters.guidance.brake_preview_time_s,
        .unit("s").min(0.0).description("the same where the profile decelerates: lag and delay of the brake");
}

/// A reference road and the guidance along it.
#[derive(Debug, Clone)]
pub struct ReferencePath {
    parameters: GuidanceParameters,
    /// The guidance over speed, where the path states it.
    schedule: Option<GuidanceSchedule>,
    /// The speed along the path.
    speed: SpeedReference,
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
    parameters: GuidanceParameters,
    inputs: Inputs,
    followed: GuidanceState,
    phase: Phase,
}

impl ReferencePath {
    /// The parameters that act at a speed, m/s.
    fn acting(&self, speed: f64) -> GuidanceParameters {
        let schedule = self.schedule.as_ref();
        schedule.map_or(self.parameters, |schedule| schedule.parameters_at(&self.parameters, speed))
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

    /// Speed and acceleration to drive.
    fn reference(&mut self) -> [f64; 2] {
        let distance = self.output().distance;
        let guidance = &self.parameters.guidance;
        let preview = [guidance.speed_preview_time_s, guidance.brake_preview_time_s];
        self.speed.reference(distance, preview)
    }
}

impl Definition for ReferencePath {
    type File = Path;
    const RESOURCE: &'static str = "path.json";
    const ROLE: Role = Role::Guidance;

    /// Along the path, a quarter of a metre to either side and a degree or so off the heading.
    fn scenario(file: Path) -> Scenario {
        Scenario::new(move |input, Moment { time, course: t }| match input {
            "x" | "y" | "yaw" => {
                let place = along(&file.points, file.speed_mps * time)?;
                let offset = 0.25 * (TAU * 0.2 * t).sin();
                Some(match input {
                    "x" => place.x_m - offset * place.heading_rad.sin(),
                    "y" => place.y_m + offset * place.heading_rad.cos(),
                    _ => place.heading_rad + 0.02 * (TAU * 0.2 * t).cos(),
                })
            }
            "sideslip_per_yaw_rate_offset" if t < 2.0 => Some(0.0),
            "sideslip_per_yaw_rate_offset" => Some(0.02 * (TAU * 0.1 * (t - 2.0)).sin()),
            _ => None,
        })
    }
}

/// The place at that distance along the path, at most its end.
fn along(points: &[PathPoint], distance: f64) -> Option<PathPoint> {
    let last = points.last()?;
    let distance = (points.first()?.distance_m + distance).min(last.distance_m);
    let after = points.partition_point(|p| p.distance_m <= distance);
    let (Some(a), Some(b)) = (points.get(after.checked_sub(1)?), points.get(after)) else {
        return Some(*last);
    };
    let part = (distance - a.distance_m) / (b.distance_m - a.distance_m);
    let between = |a: f64, b: f64| a + part * (b - a);
    Some(PathPoint {
        distance_m: distance,
        x_m: between(a.x_m, b.x_m),
        y_m: between(a.y_m, b.y_m),
        heading_rad: between(a.heading_rad, b.heading_rad),
        curvature_per_m: between(a.curvature_per_m, b.curvature_per_m),
    })
}

impl CoSimulationUnit for ReferencePath {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are held between steps, and a path of points has no derivatives by the inputs.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let path = required::<Path>(resources, Self::RESOURCE)?;
        let geometry = steerwright_models::files::path_geometry(&path)
            .map_err(|e| format!("path.json: {e}; hint: {}", e.hint()))?;
        let (x, y, yaw) =
            path.points.first().map_or((0.0, 0.0, 0.0), |p| (p.x_m, p.y_m, p.heading_rad));
        let inputs = Inputs { x, y, yaw, speed: path.speed_mps };
        let unit = Self {
            parameters: steerwright_models::files::guidance_parameters(
                &path.guidance,
                path.speed_mps,
            ),
            schedule: steerwright_models::files::guidance_schedule(&path),
            speed: steerwright_models::files::speed_reference(&path),
            inputs,
            follower: PathFollower::new(Arc::new(geometry)),
            phase: Phase::BeforeFirstStep { last_read: inputs },
            searched: None,
        };
        with_start_values(unit, resources)
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
            V::SpeedReference => self.reference()[0],
            V::AccelerationReference => self.reference()[1],
            V::SideslipCorrection => self.follower.state().sideslip_correction,
            V::Finished => return Value::Boolean(self.output().finished),
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        // A parameter may change the outputs of the same inputs.
        if !matches!(variable, V::X | V::Y | V::Yaw | V::Speed) {
            self.searched = None;
        }
        if let (Value::Real(value), Some(place)) = (value, variable.place(self)) {
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
        let acting = self.acting(self.inputs.speed);
        self.follower.integrate(&acting, &output, self.inputs.speed, step);
        self.phase = Phase::Running(output);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&Saved {
            parameters: self.parameters,
            inputs: self.inputs,
            followed: *self.follower.state(),
            phase: self.phase.clone(),
        })
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let saved: Saved = decode(bytes)?;
        let mut loaded = self.clone();
        loaded.follower.restore(saved.followed).map_err(|e| refuse(&e))?;
        match &saved.phase {
            Phase::BeforeFirstStep { last_read: Inputs { x, y, yaw, speed } } => {
                if [x, y, yaw, speed].iter().any(|value| !value.is_finite()) {
                    return Err("an input of the saved state is not finite".into());
                }
            }
            Phase::Running(output) => output.check().map_err(|e| refuse(&e))?,
        }
        loaded.parameters = saved.parameters;
        loaded.inputs = saved.inputs;
        loaded.phase = saved.phase;
        loaded.searched = None;
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}
