//! The closed loops of the comparison: every controller on every plant, as packed FMUs.

use super::guidance;
use super::models::{Controller, Model};
use crate::failure::Failure;
use crate::fmu_track::{self, CONTROLLER, Loop, add, drive_at};
use crate::pipeline::BEFORE_STEP_S;
use crate::{fmu_step, package};
use control::Sideslip;
use fmi2_host::{Archive, Connection, Coupling, InputTable, Recording, System};
use formats::{Document, Path as PathFile, StepMetrics};
use report::{StepResponse, Track, TrackErrors};

/// Lateral acceleration of the turn in which a plant's gain and sideslip are read, m/s².
const TURN_MPS2: f64 = 0.5;
/// How long the steering takes to get there, and how long the turn is held, s.
const RAMP_S: f64 = 2.0;
const TURN_S: f64 = 8.0;
/// Yaw acceleration over that of the steering's ramp, in a plant that follows it.
const FOLLOWED: std::ops::Range<f64> = 0.5..2.0;
/// From what is read to either side of an instant, s.
const ABOUT_S: f64 = 0.1;
/// Steering gains of one car are within this factor of each other; a steering wheel's and a road
/// wheel's are not.
const SAME_STEERING: f64 = 3.0;
/// Sideslips are told to this, s and s².
const SIDESLIP_DIGITS: f64 = 1e6;

/// A vehicle to drive.
pub(crate) struct Plant {
    /// A model's label, or the truth's.
    pub(crate) label: String,
    /// Which of the models; absent for the truth.
    pub(crate) model: Option<usize>,
    archive: Archive,
    /// Steady-state yaw rate per steering angle, 1/s.
    pub(crate) gain: f64,
    /// Of that turn and the way into it.
    pub(crate) sideslip: Sideslip,
}

/// A controller on a plant.
pub(crate) struct Run {
    pub(crate) controller: usize,
    pub(crate) plant: usize,
    pub(crate) csv: String,
    pub(crate) track: Track,
    pub(crate) errors: TrackErrors,
    pub(crate) effort: Effort,
    /// Where the path was left, m along it.
    pub(crate) off_path_at_m: Option<f64>,
    /// The specification's step.
    pub(crate) step: StepMetrics,
    pub(crate) response: StepResponse,
    /// Of the linear loop; absent where the plant has none.
    pub(crate) modulus_margin: Option<f64>,
}

/// What the commanded steering angle does, in steering coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) angle_max_rad: f64,
    pub(crate) rate_rms_radps: f64,
    pub(crate) rate_max_radps: f64,
}

/// What every loop has in common.
pub(crate) struct Setting<'a> {
    pub(crate) models: &'a [Model],
    pub(crate) controllers: &'a [Controller],
    /// Guidance apart: that is each controller's own.
    pub(crate) road: &'a PathFile,
    pub(crate) master: Coupling,
    /// A cross-track error beyond this is off the path, m.
    pub(crate) max_cross_track_error_m: f64,
}

impl Setting<'_> {
    fn sample_time(&self) -> f64 {
        self.controllers.first().map_or(0.01, |c| c.pid.sample_time_s)
    }

    /// The plants of the models, and the truth after them.
    pub(crate) fn plants(&self, truth: Option<Archive>) -> Result<Vec<Plant>, Failure> {
        let mut plants = Vec::new();
        for (index, model) in self.models.iter().enumerate() {
            let packed = package::pack(&model.text(), &model.label, None)?;
            let archive = Archive::from_bytes(&packed.bytes, &model.label)?;
            plants.push(self.plant(model.label.clone(), Some(index), archive)?);
        }
        if let Some(archive) = truth {
            let name = &archive.model().description().model_name;
            plants.push(self.plant(format!("truth ({name})"), None, archive)?);
        }
        Ok(plants)
    }

    fn plant(
        &self,
        label: String,
        model: Option<usize>,
        archive: Archive,
    ) -> Result<Plant, Failure> {
        let expected = self.expected_gain();
        let angle = TURN_MPS2 / (self.road.speed_mps * expected);
        let turn = |angle: f64| self.turn(&archive, angle).map_err(|e| e.about(&label));
        let (left, right) = (turn(angle)?, turn(-angle)?);
        // Half the difference of both: what is the same to either side is no answer to the steering.
        let [turning, held] = [0, 1].map(|i| left[i].less(&right[i]));
        let gain = held.yaw_rate / angle;
        let ratio = gain / expected;
        let steering = || {
            format!(
                "{label} turns at {gain:.3} rad/s per rad of steering, the models at about {expected:.3}"
            )
        };
        if ratio <= 0.0 || !ratio.is_finite() {
            let hint = "steering, yaw rate and yaw must be positive to the left (ISO 8855), and the \
                        vehicle must move";
            return Err(Failure::new(steering(), hint));
        }
        if !(1.0 / SAME_STEERING..=SAME_STEERING).contains(&ratio) {
            let hint = format!(
                "a factor of {ratio:.2} is that of a steering wheel to a road wheel: give a vehicle \
                 with the models' steering ratio of {}, or models with the vehicle's",
                self.models.first().map_or(1.0, |m| m.design.steering_ratio)
            );
            return Err(Failure::new(steering(), hint));
        }
        let told = |value: f64| (value * SIDESLIP_DIGITS).round() / SIDESLIP_DIGITS;
        let exact = held.sideslip / held.yaw_rate;
        let per_yaw_rate_s = told(exact);
        let rest = turning.sideslip - exact * turning.yaw_rate;
        // Only a plant that follows the steering into the turn tells what leads there.
        let followed = turning.yaw_acceleration * RAMP_S / held.yaw_rate;
        let per_yaw_acceleration_s2 = match told(rest / turning.yaw_acceleration) {
            _ if !FOLLOWED.contains(&followed) => 0.0,
            // 0 would say "not known" of a sideslip that is.
            0.0 if per_yaw_rate_s != 0.0 => 1.0 / SIDESLIP_DIGITS,
            lead => lead,
        };
        let sideslip = Sideslip { per_yaw_rate_s, per_yaw_acceleration_s2, growth_s5pm2: 0.0 };
        Ok(Plant { label, model, archive, gain, sideslip })
    }

    /// The middle of the models' gains, whatever their order.
    fn expected_gain(&self) -> f64 {
        let mut gains: Vec<f64> = self.models.iter().map(|m| m.design.gain()).collect();
        gains.sort_by(f64::total_cmp);
        gains.get(gains.len() / 2).copied().unwrap_or(1.0)
    }

    /// A turn at a steering angle from a straight course, as on a test track: at the end of the way into
    /// it, and when it is steady.
    fn turn(&self, archive: &Archive, angle: f64) -> Result<[Turn; 2], Failure> {
        let plant = fmu_track::name_of(archive);
        let step = self.sample_time();
        let mut system = System::new();
        add(&mut system, archive, &plant)?;
        drive_at(&mut system, archive, self.road.speed_mps)?;
        let (ramped, steps) = (RAMP_S / step, ((RAMP_S + TURN_S) / step).round());
        let mut table = "time,steering_angle\n".to_owned();
        for k in 0..=ramped.round() as usize {
            let share = (k as f64 / ramped).min(1.0);
            table += &format!("{},{}\n", k as f64 * step, share * angle);
        }
        system.feed(InputTable::read(table.as_bytes(), "the turn")?);
        let names = ["x", "y", "yaw"].map(|v| format!("{plant}.{v}"));
        system.record(&names.each_ref().map(String::as_str))?;
        let recording = system.run(self.master, 0.0, steps * step, step)?;
        let about = (ABOUT_S / step).round().max(1.0) as usize;
        let ramped = ramped.round() as usize;
        let rows = &recording.rows;
        let at = |end: usize| -> Option<Turn> {
            let middle = end.checked_sub(about)?;
            let [a, b, c] =
                [rows.get(middle.checked_sub(about)?)?, rows.get(middle)?, rows.get(end)?];
            // The chord has the mean course, and Simpson's rule the mean yaw.
            let course = (c[1] - a[1]).atan2(c[0] - a[0]);
            let yaw = (a[2] + 4.0 * b[2] + c[2]) / 6.0;
            let time = about as f64 * step;
            Some(Turn {
                yaw_rate: (c[2] - a[2]) / (2.0 * time),
                yaw_acceleration: (c[2] - 2.0 * b[2] + a[2]) / (time * time),
                sideslip: (course - yaw).sin().asin(),
            })
        };
        let few = || Failure::new("a turn has too few steps", "shorten the sample time");
        let last = rows.len().saturating_sub(1);
        Ok([at(ramped).ok_or_else(few)?, at(last).ok_or_else(few)?])
    }

    /// Every controller on every plant, controller by controller.
    pub(crate) fn runs(&self, plants: &[Plant]) -> Result<Vec<Run>, Failure> {
        let mut runs = Vec::new();
        for (index, controller) in self.controllers.iter().enumerate() {
            let road = self.road_for(controller);
            let pack = |text: &str, what: &str| -> Result<Archive, Failure> {
                Ok(Archive::from_bytes(&package::pack(text, what, None)?.bytes, what)?)
            };
            let path = pack(&road.to_json(), "the road")?;
            let pid = pack(&controller.pid.to_json(), "the controller")?;
            for (place, plant) in plants.iter().enumerate() {
                let run = self.run((index, controller), (place, plant), &road, &path, &pid);
                let what = format!("the controller of {} on {}", controller.label, plant.label);
                runs.push(run.map_err(|e| e.about(what))?);
            }
        }
        Ok(runs)
    }

    /// The road with a controller's guidance.
    pub(crate) fn road_for(&self, controller: &Controller) -> PathFile {
        PathFile { guidance: guidance(self.road, controller), ..self.road.clone() }
    }

    fn run(
        &self,
        (controller_index, controller): (usize, &Controller),
        (plant_index, plant): (usize, &Plant),
        road: &PathFile,
        path: &Archive,
        pid: &Archive,
    ) -> Result<Run, Failure> {
        let step = controller.pid.sample_time_s;
        let archives = Loop { plant: &plant.archive, path, controller: pid };
        let recording = archives.track(road, step, self.master, &plant.sideslip)?;
        let csv = recording.to_csv();
        let known = only_known(recording, &fmu_track::name_of(&plant.archive));
        let track = Track::from_csv(known.to_csv().as_bytes(), "the run")?;
        let (metrics, response) = self.step(&plant.archive, controller, pid)?;
        let margin = |model: usize| control::evaluate(&self.models[model].design, &controller.pid);
        let modulus_margin = plant.model.map(margin).transpose()?.map(|e| e.margins.modulus_margin);
        Ok(Run {
            controller: controller_index,
            plant: plant_index,
            errors: track.errors(),
            effort: Effort::of(&track),
            off_path_at_m: self.off_path_at(&track),
            csv,
            track,
            step: metrics,
            response,
            modulus_margin,
        })
    }

    /// The specification's step, at the road's speed.
    fn step(
        &self,
        plant: &Archive,
        controller: &Controller,
        pid: &Archive,
    ) -> Result<(StepMetrics, StepResponse), Failure> {
        let name = fmu_track::name_of(plant);
        let mut system = System::new();
        add(&mut system, plant, &name)?;
        add(&mut system, pid, CONTROLLER)?;
        system.connect(Connection::new(&name, "yaw", CONTROLLER, "yaw"))?;
        let steering = "steering_angle";
        system.connect(Connection::new(CONTROLLER, steering, &name, steering))?;
        drive_at(&mut system, plant, self.road.speed_mps)?;
        // A crooked wheel is taken up before.
        let first = (BEFORE_STEP_S / controller.pid.sample_time_s).round() as usize;
        let step = fmu_step::step_of(system, &name, &controller.pid, first, self.master)?;
        let response = StepResponse {
            time_s: step.trace.time,
            yaw_rad: step.trace.yaw,
            steering_rad: step.trace.steering,
        };
        Ok((step.metrics, response))
    }

    /// Where the path is left: beside it, or short of its end by more than a second's way.
    fn off_path_at(&self, track: &Track) -> Option<f64> {
        let at = |k: usize| track.distance_m.get(k).copied().unwrap_or(f64::NAN);
        let beside = track
            .cross_track_error_m
            .iter()
            .position(|e| e.abs() > self.max_cross_track_error_m || e.is_nan());
        let (first, last) = (self.road.points.first()?, self.road.points.last()?);
        let length = last.distance_m - first.distance_m;
        let end = at(track.distance_m.len().saturating_sub(1));
        let short = end < length - self.road.speed_mps || end.is_nan();
        beside.map(at).or_else(|| short.then_some(end))
    }
}

/// The recording without what another tool's plant tells beside its pose: its `distance` may be
/// anything.
fn only_known(mut recording: Recording, plant: &str) -> Recording {
    let own =
        |name: &str| name.strip_prefix(plant).and_then(|n| n.strip_prefix('.')).map(str::to_owned);
    let keep: Vec<bool> = recording
        .names
        .iter()
        .map(|name| own(name).is_none_or(|v| matches!(v.as_str(), "x" | "y" | "yaw")))
        .collect();
    let mut kept = keep.iter();
    recording.names.retain(|_| kept.next().copied().unwrap_or(true));
    let mut kept = keep.iter();
    recording.units.retain(|_| kept.next().copied().unwrap_or(true));
    for row in &mut recording.rows {
        let mut kept = keep.iter();
        row.retain(|_| kept.next().copied().unwrap_or(true));
    }
    recording
}

struct Turn {
    yaw_rate: f64,
    yaw_acceleration: f64,
    sideslip: f64,
}

impl Turn {
    /// Half the difference of this turn and one to the other side.
    fn less(&self, other: &Self) -> Self {
        let half = |a: f64, b: f64| 0.5 * (a - b);
        Self {
            yaw_rate: half(self.yaw_rate, other.yaw_rate),
            yaw_acceleration: half(self.yaw_acceleration, other.yaw_acceleration),
            sideslip: half(self.sideslip, other.sideslip),
        }
    }
}

impl Effort {
    fn of(track: &Track) -> Self {
        let angle = &track.steering_rad;
        let rates = angle
            .windows(2)
            .zip(track.time_s.windows(2))
            .map(|(u, t)| (u[1] - u[0]) / (t[1] - t[0]));
        let (sum, most) =
            rates.fold((0.0, 0.0_f64), |(sum, most), r| (sum + r * r, most.max(r.abs())));
        Self {
            angle_max_rad: angle.iter().fold(0.0, |m, u| u.abs().max(m)),
            rate_rms_radps: (sum / angle.len().saturating_sub(1).max(1) as f64).sqrt(),
            rate_max_radps: most,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a foreign plant calls `distance` is not the road's.
    #[test]
    fn of_a_plant_its_pose_is_kept_alone() {
        let names = ["car.distance", "car.x", "car.body.x", "ReferencePath.distance"];
        let recording = Recording {
            names: names.map(str::to_owned).to_vec(),
            units: vec![None; 4],
            times: vec![0.0],
            rows: vec![vec![1.0, 2.0, 3.0, 4.0]],
            initial_passes: 1,
            initially_settled: true,
        };
        let known = only_known(recording, "car");
        assert_eq!(known.names, ["car.x", "ReferencePath.distance"]);
        assert_eq!((known.rows, known.units.len()), (vec![vec![2.0, 4.0]], 2));
    }
}
