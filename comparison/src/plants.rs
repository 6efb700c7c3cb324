//! The vehicles that are driven, with the gain and the sideslip of each in a steady turn.

use crate::models::{ComparedModel, Controller};
use crate::track::{add, drive_at, name_of};
use crate::{Error, packed};
use steerwright_control::Sideslip;
use steerwright_formats::Path as PathFile;
use steerwright_host::{Archive, Coupling, InputTable, System};

/// Lateral acceleration of the turn in which a plant's gain and sideslip are read, m/s².
const TURN_MPS2: f64 = 0.5;
/// How long the steering takes to get there, and how long the turn is held, s.
const RAMP_S: f64 = 2.0;
const TURN_S: f64 = 8.0;
/// Yaw acceleration over that of the steering's ramp, in a plant that follows it.
const FOLLOWED: std::ops::Range<f64> = 0.5..2.0;
/// Rates are differences over this time to either side, s.
const DIFFERENCE_S: f64 = 0.1;
/// Steering gains of one car are within this factor of each other; a steering wheel's and a road
/// wheel's are not.
const SAME_STEERING: f64 = 3.0;
/// Sideslips are rounded to this, 1/s and 1/s².
const SIDESLIP_DIGITS: f64 = 1e6;

/// A vehicle to drive.
pub struct Plant {
    /// A model's label, or the truth's.
    pub label: String,
    /// Which of the models; absent for the truth.
    pub model: Option<usize>,
    pub(crate) archive: Archive,
    /// Steady-state yaw rate per steering angle, 1/s.
    pub gain: f64,
    /// Of that turn and the way into it.
    pub sideslip: Sideslip,
}

/// The settings of every loop.
pub(crate) struct Setting<'a> {
    pub(crate) models: &'a [ComparedModel],
    pub(crate) controllers: &'a [Controller],
    /// Guidance apart: that is each controller's own.
    pub(crate) road: &'a PathFile,
    pub(crate) coupling: Coupling,
    /// A cross-track error beyond this is off the path, m.
    pub(crate) max_cross_track_error_m: f64,
}

impl Setting<'_> {
    pub(crate) fn sample_time(&self) -> f64 {
        self.controllers.first().map_or(0.01, |c| c.pid.sample_time_s)
    }

    /// The plants of the models, and the truth after them.
    pub(crate) fn plants(&self, truth: Option<Archive>) -> Result<Vec<Plant>, Error> {
        let mut plants = Vec::new();
        for (index, model) in self.models.iter().enumerate() {
            let archive = packed::archive(&model.document.to_json(), &model.label)?;
            plants.push(self.plant(model.label.clone(), Some(index), archive)?);
        }
        if let Some(archive) = truth {
            let name = &archive.model().description().model_name;
            plants.push(self.plant(format!("truth ({name})"), None, archive)?);
        }
        Ok(plants)
    }

    fn plant(&self, label: String, model: Option<usize>, archive: Archive) -> Result<Plant, Error> {
        let expected = self.expected_gain();
        let angle = TURN_MPS2 / (self.road.speed_mps * expected);
        let turn = |angle: f64| self.turn(&archive, angle).map_err(|e| e.within(&label));
        let (left, right) = (turn(angle)?, turn(-angle)?);
        // Half the difference of both: a response that is the same to both sides has other causes.
        let [turning, held] = [0, 1].map(|i| left[i].less(&right[i]));
        let gain = held.yaw_rate / angle;
        let ratio = gain / expected;
        if ratio <= 0.0 || !ratio.is_finite() {
            let (gain_per_s, expected_per_s) = (gain, expected);
            return Err(Error::SteeringSign { plant: label, gain_per_s, expected_per_s });
        }
        if !(1.0 / SAME_STEERING..=SAME_STEERING).contains(&ratio) {
            return Err(Error::SteeringPlace {
                plant: label,
                gain_per_s: gain,
                expected_per_s: expected,
                steering_ratio: self.models.first().map_or(1.0, |m| m.design.steering_ratio),
            });
        }
        // Adding 0 removes the sign of a negative zero.
        let rounded = |value: f64| (value * SIDESLIP_DIGITS).round() / SIDESLIP_DIGITS + 0.0;
        let exact = held.sideslip / held.yaw_rate;
        let per_yaw_rate = rounded(exact);
        let rest = turning.sideslip - exact * turning.yaw_rate;
        // The lead is read only of a plant that follows the steering into the turn.
        let followed = turning.yaw_acceleration * RAMP_S / held.yaw_rate;
        let per_yaw_acceleration = match rounded(rest / turning.yaw_acceleration) {
            _ if !FOLLOWED.contains(&followed) => 0.0,
            // 0 would mean "not known".
            0.0 if per_yaw_rate != 0.0 => 1.0 / SIDESLIP_DIGITS,
            lead => lead,
        };
        let reference_speed = self.road.speed_mps;
        let sideslip =
            Sideslip { per_yaw_rate, per_yaw_acceleration, reference_speed, ..Sideslip::default() };
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
    fn turn(&self, archive: &Archive, angle: f64) -> Result<[Turn; 2], Error> {
        let plant = name_of(archive);
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
        let recording = system.run(self.coupling, 0.0, steps * step, step)?;
        let about = (DIFFERENCE_S / step).round().max(1.0) as usize;
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
        let last = rows.len().saturating_sub(1);
        Ok([at(ramped).ok_or(Error::ShortTurn)?, at(last).ok_or(Error::ShortTurn)?])
    }
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
