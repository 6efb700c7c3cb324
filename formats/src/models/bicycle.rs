//! `bicycle.json`: the two-wheel bicycle model of eq 13.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::matrix::Matrix;
use crate::models::bicycle_evidence::{BicycleEvidence, Estimated, VehicleDirection};
use crate::models::sideslip::Sideslip;
use crate::models::vehicle::{Body, SteeringActuator, Tyres, Vehicle};
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// Vehicle data (also the TOML that `steerwright bicycle` reads).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleData {
    /// A name.
    pub name: String,
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Yaw inertia J, kg·m².
    pub yaw_inertia_kgm2: f64,
    /// Centre of gravity to front axle L_f, m.
    pub distance_front_m: f64,
    /// Centre of gravity to rear axle L_r, m.
    pub distance_rear_m: f64,
    /// Cornering stiffness of the front axle C_f, N/rad.
    pub cornering_stiffness_front_npr: f64,
    /// Cornering stiffness of the rear axle C_r, N/rad.
    pub cornering_stiffness_rear_npr: f64,
    /// Time constant of the steering actuator T_n, s.
    pub actuator_time_constant_s: f64,
    /// Pure delay of the steering angle before the actuator, s; 0 if omitted.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub actuator_delay_s: f64,
    /// Largest rate of the road wheels, rad/s; beyond that of any drive if omitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator_rate_max_radps: Option<f64>,
    /// Steering angle over road-wheel angle, 1/n.
    pub steering_ratio: f64,
    /// Longitudinal velocity V, m/s.
    pub speed_mps: f64,
}

impl Default for VehicleData {
    /// A mid-size car with its steering at the road wheel, mildly understeering.
    fn default() -> Self {
        Self {
            name: String::new(),
            mass_kg: 1500.0,
            yaw_inertia_kgm2: 2500.0,
            distance_front_m: 1.2,
            distance_rear_m: 1.5,
            cornering_stiffness_front_npr: 100_000.0,
            cornering_stiffness_rear_npr: 110_000.0,
            actuator_time_constant_s: 0.05,
            actuator_delay_s: 0.0,
            actuator_rate_max_radps: None,
            steering_ratio: 1.0,
            speed_mps: 15.0,
        }
    }
}

/// The five-state model of eq 13 at constant speed, with the vehicle data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bicycle {
    /// `steerwright/bicycle/1`.
    pub schema: String,
    /// The vehicle.
    pub vehicle: VehicleData,
    /// The coefficients of eq 13.
    pub coefficients: BicycleCoefficients,
    /// State matrix of eq 13 for (y, ẏ, ψ, ψ̇, δ), 5 by 5.
    pub state_matrix: Matrix,
    /// Input matrix of eq 13, 5 by 1.
    pub input_matrix: Matrix,
    /// The sideslip that the drive determines, which may differ from that of the model; absent if it determines none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip: Option<Sideslip>,
    /// The evidence for its quality, if it was identified from a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<BicycleEvidence>,
    /// Whether a controller may be designed on it.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// The coefficients of eq 13 in the paper's letters.
#[allow(missing_docs)]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BicycleCoefficients {
    #[serde(rename = "A1")]
    pub a1: f64,
    #[serde(rename = "A2")]
    pub a2: f64,
    #[serde(rename = "A3")]
    pub a3: f64,
    #[serde(rename = "A4")]
    pub a4: f64,
    #[serde(rename = "B1")]
    pub b1: f64,
    #[serde(rename = "B2")]
    pub b2: f64,
    pub n: f64,
    #[serde(rename = "Tn")]
    pub tn: f64,
}

/// Numbers in a file may be rounded: largest difference, as a share of the number.
const ROUNDED: f64 = 1e-3;

impl BicycleCoefficients {
    /// Of mass and yaw inertia, distances and cornering stiffnesses of front and rear, steering ratio and time constant
    /// of the actuator, all SI.
    #[inline]
    #[must_use]
    pub fn new(
        [m, j]: [f64; 2],
        [lf, lr]: [f64; 2],
        [cf, cr]: [f64; 2],
        steering_ratio: f64,
        time_constant: f64,
    ) -> Self {
        Self {
            a1: -(cf + cr) / m,
            a2: -(cf * lf - cr * lr) / m,
            a3: (-cf * lf + cr * lr) / j,
            a4: -(cf * lf * lf + cr * lr * lr) / j,
            b1: cf / m,
            b2: cf * lf / j,
            n: 1.0 / steering_ratio,
            tn: time_constant,
        }
    }

    /// With their names.
    fn named(&self) -> [(&'static str, f64); 8] {
        let Self { a1, a2, a3, a4, b1, b2, n, tn } = *self;
        [
            ("A1", a1),
            ("A2", a2),
            ("A3", a3),
            ("A4", a4),
            ("B1", b1),
            ("B2", b2),
            ("n", n),
            ("Tn", tn),
        ]
    }

    /// The part (v_y, r) of the body-frame form at a speed, m/s: `[[a, b], [c, d]]`, row by row.
    #[inline]
    #[must_use]
    pub fn lateral(&self, speed: f64) -> [f64; 4] {
        let inverse = 1.0 / speed;
        [self.a1 * inverse, self.a2 * inverse - speed, self.a3 * inverse, self.a4 * inverse]
    }

    /// A bound on the rate of the fastest mode at a speed, 1/s.
    #[inline]
    #[must_use]
    pub fn fastest_rate(&self, speed: f64) -> f64 {
        let [a, b, c, d] = self.lateral(speed);
        // The norm of the matrix after scaling the states such that b and c are of one size.
        (a.abs().max(d.abs()) + (b * c).abs().sqrt()).max(1.0 / self.tn)
    }

    /// The matrices of eq 13 at a speed above zero, m/s.
    #[must_use]
    pub fn matrices(&self, speed: f64) -> (Matrix, Matrix) {
        let (v, Self { a1, a2, a3, a4, b1, b2, n, tn }) = (speed, *self);
        #[rustfmt::skip]
        let rows = [
            [0.0, 1.0,    0.0, 0.0,    0.0],
            [0.0, a1 / v, -a1, a2 / v, b1 * n],
            [0.0, 0.0,    0.0, 1.0,    0.0],
            [0.0, a3 / v, -a3, a4 / v, b2 * n],
            [0.0, 0.0,    0.0, 0.0,    -1.0 / tn],
        ];
        let input = Matrix::column(&[0.0, 0.0, 0.0, 0.0, 1.0 / tn]);
        (Matrix::from_fn(5, 5, |i, j| rows[i][j]), input)
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

impl Vehicle {
    /// The data of the bicycle that the vehicle is in gentle driving.
    #[must_use]
    pub fn in_gentle_driving(&self) -> VehicleData {
        VehicleData {
            name: self.name.clone(),
            speed_mps: self.speed_mps,
            ..VehicleData::in_gentle_driving(&self.body, &self.tyres, &self.actuator)
        }
    }
}

impl VehicleData {
    /// Its keys in a file, in words.
    pub const KEYS: &str = "name, mass_kg, yaw_inertia_kgm2, distance_front_m, distance_rear_m, cornering_stiffness_front_npr, cornering_stiffness_rear_npr, actuator_time_constant_s, actuator_delay_s and actuator_rate_max_radps (optional), steering_ratio and speed_mps";

    /// The data in words, each with its value and its unit.
    #[must_use]
    pub fn in_words(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut all = vec![
            ("mass", self.mass_kg, "kg"),
            ("yaw inertia", self.yaw_inertia_kgm2, "kg·m²"),
            ("centre of gravity to front axle", self.distance_front_m, "m"),
            ("centre of gravity to rear axle", self.distance_rear_m, "m"),
            ("cornering stiffness, front axle", self.cornering_stiffness_front_npr, "N/rad"),
            ("cornering stiffness, rear axle", self.cornering_stiffness_rear_npr, "N/rad"),
            ("time constant of the actuator", self.actuator_time_constant_s, "s"),
            ("delay of the actuator", self.actuator_delay_s, "s"),
            ("steering ratio", self.steering_ratio, ""),
            ("speed", self.speed_mps, "m/s"),
        ];
        let rate = self.actuator_rate_max_radps;
        all.extend(rate.map(|rate| ("largest rate of the road wheels", rate, "rad/s")));
        all
    }

    /// The data of the bicycle that a vehicle is in gentle driving, without its name and speed.
    #[must_use]
    pub fn in_gentle_driving(body: &Body, tyres: &Tyres, actuator: &SteeringActuator) -> Self {
        Self {
            mass_kg: body.mass_kg,
            yaw_inertia_kgm2: body.yaw_inertia_kgm2,
            distance_front_m: body.distance_front_m,
            distance_rear_m: body.distance_rear_m,
            cornering_stiffness_front_npr: tyres.cornering_stiffness_front_npr,
            cornering_stiffness_rear_npr: tyres.cornering_stiffness_rear_npr,
            actuator_time_constant_s: actuator.time_constant_s,
            actuator_delay_s: actuator.delay_s,
            steering_ratio: actuator.steering_ratio,
            ..Self::default()
        }
    }

    /// The coefficients of eq 13.
    #[must_use]
    pub fn coefficients(&self) -> BicycleCoefficients {
        BicycleCoefficients::new(
            [self.mass_kg, self.yaw_inertia_kgm2],
            [self.distance_front_m, self.distance_rear_m],
            self.axle_stiffness(),
            self.steering_ratio,
            self.actuator_time_constant_s,
        )
    }

    /// Lateral force over slip of the front and the rear axle at small slip, N/rad.
    #[must_use]
    pub fn axle_stiffness(&self) -> [f64; 2] {
        [self.cornering_stiffness_front_npr, self.cornering_stiffness_rear_npr]
    }

    /// Gives these data to a vehicle: the inverse of [`VehicleData::in_gentle_driving`], and the largest rate of the
    /// road wheels where it is known.
    pub fn give_to(&self, body: &mut Body, tyres: &mut Tyres, actuator: &mut SteeringActuator) {
        body.mass_kg = self.mass_kg;
        body.yaw_inertia_kgm2 = self.yaw_inertia_kgm2;
        body.distance_front_m = self.distance_front_m;
        body.distance_rear_m = self.distance_rear_m;
        [tyres.cornering_stiffness_front_npr, tyres.cornering_stiffness_rear_npr] =
            self.axle_stiffness();
        actuator.steering_ratio = self.steering_ratio;
        actuator.time_constant_s = self.actuator_time_constant_s;
        actuator.delay_s = self.actuator_delay_s;
        if let Some(rate) = self.actuator_rate_max_radps {
            actuator.road_wheel_rate_max_radps = rate;
        }
    }

    /// Reports impossible values; `at` is the prefix of each key, such as `vehicle.`.
    pub fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.positive(self, at): mass_kg yaw_inertia_kgm2 distance_front_m distance_rear_m
            cornering_stiffness_front_npr cornering_stiffness_rear_npr actuator_time_constant_s
            steering_ratio speed_mps);
        c.within(self.actuator_delay_s, 0.0, 10.0, &format!("{at}actuator_delay_s"));
        if let Some(rate) = self.actuator_rate_max_radps {
            c.within(rate, 1e-6, 1e6, &format!("{at}actuator_rate_max_radps"));
        }
    }

    /// The vehicle displaced by a multiple of a direction of its uncertainty.
    #[must_use]
    pub fn displaced(&self, direction: &VehicleDirection, times: f64) -> Self {
        let by = |logarithm: f64| (times * logarithm).exp();
        Self {
            distance_front_m: self.distance_front_m * by(direction.wheelbase),
            distance_rear_m: self.distance_rear_m * by(direction.wheelbase),
            yaw_inertia_kgm2: self.yaw_inertia_kgm2 * by(direction.yaw_inertia),
            cornering_stiffness_front_npr: self.cornering_stiffness_front_npr
                * by(direction.cornering_stiffness_front),
            cornering_stiffness_rear_npr: self.cornering_stiffness_rear_npr
                * by(direction.cornering_stiffness_rear),
            actuator_time_constant_s: self.actuator_time_constant_s
                * by(direction.actuator_time_constant),
            steering_ratio: self.steering_ratio * by(direction.steering_ratio),
            actuator_delay_s: (self.actuator_delay_s + times * direction.actuator_delay_s).max(0.0),
            ..self.clone()
        }
    }
}

impl Bicycle {
    /// Eq 13 of a vehicle, not validated and without sources.
    #[must_use]
    pub fn new(vehicle: VehicleData) -> Self {
        let coefficients = vehicle.coefficients();
        let (state_matrix, input_matrix) = coefficients.matrices(vehicle.speed_mps);
        Self {
            schema: Self::SCHEMA.into(),
            vehicle,
            coefficients,
            state_matrix,
            input_matrix,
            sideslip: None,
            evidence: None,
            quality: Quality::not_validated(),
            provenance: Provenance::default(),
        }
    }

    /// The largest rate of the road wheels, rad/s, with its standard error where it was identified: of the data, or of the vehicle
    /// that is this bicycle in gentle driving.
    #[must_use]
    pub fn largest_rate(&self) -> Option<(f64, Option<f64>)> {
        let mut identified = self.evidence.iter().flat_map(|e| &e.identified);
        let identified = identified.find(|q| q.name == Estimated::LARGEST_RATE);
        let value = self.vehicle.actuator_rate_max_radps.or(identified.map(|q| q.value))?;
        Some((value, identified.map(|q| q.standard_error)))
    }

    /// The number of standard normal numbers that [`Bicycle::ensemble_member`] needs; 0 if the file has no
    /// uncertainty.
    #[must_use]
    pub fn ensemble_dimension(&self) -> usize {
        self.evidence.as_ref().map_or(0, |e| e.directions.len())
    }

    /// The vehicle whose data are `ln nominal + Σ ξ_i · direction_i` in their logarithms: for independent
    /// standard normal ξ a draw from the estimate's distribution.
    ///
    /// `None` if the file has no uncertainty, if the number of ξ is not [`Bicycle::ensemble_dimension`],
    /// or if the drawn data are impossible.
    #[must_use]
    pub fn ensemble_member(&self, xi: &[f64]) -> Option<VehicleData> {
        let directions = &self.evidence.as_ref()?.directions;
        if directions.is_empty() || xi.len() != directions.len() {
            return None;
        }
        let drawn =
            directions.iter().zip(xi).fold(self.vehicle.clone(), |vehicle, (direction, xi)| {
                vehicle.displaced(direction, *xi)
            });
        let mut checker = Checker::default();
        drawn.check(&mut checker, "");
        if checker.into_first().is_none() { Some(drawn) } else { None }
    }

    /// The FMU and the design compute eq 13 of the vehicle: a file whose coefficients or matrices are those of another one
    /// would mislead whoever reads them.
    fn check_eq_13(&self, c: &mut Checker) {
        let expected = self.vehicle.coefficients();
        // A difference of large numbers may be 0 but for their rounding.
        let negligible = 1e-9 * expected.a1.abs().max(expected.a4.abs());
        let mut compare = |at: &str, found: f64, expected: f64| {
            let apart = (found - expected).abs();
            c.require(apart <= ROUNDED * expected.abs() + negligible, at, || {
                format!(
                    "{found}, but {expected} by eq 13 of `vehicle`; `steerwright bicycle` computes it"
                )
            });
        };
        for ((name, found), (_, expected)) in
            self.coefficients.named().into_iter().zip(expected.named())
        {
            compare(&format!("coefficients.{name}"), found, expected);
        }
        let (state_matrix, input_matrix) = expected.matrices(self.vehicle.speed_mps);
        for (name, found, expected) in [
            ("state_matrix", &self.state_matrix, state_matrix),
            ("input_matrix", &self.input_matrix, input_matrix),
        ] {
            for (i, (found, expected)) in found.0.iter().zip(&expected.0).enumerate() {
                for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
                    compare(&format!("{name}[{i}][{j}]"), *found, *expected);
                }
            }
        }
    }
}

impl Document for Bicycle {
    const SCHEMA: &'static str = "steerwright/bicycle/1";

    fn check(&self, c: &mut Checker) {
        self.vehicle.check(c, "vehicle.");
        c.shape(&self.state_matrix, 5, 5, "state_matrix");
        c.shape(&self.input_matrix, 5, 1, "input_matrix");
        self.check_eq_13(c);
        if let Some(sideslip) = &self.sideslip {
            sideslip.check(c);
        }
        if let Some(evidence) = &self.evidence {
            evidence.check(c, "evidence.");
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for Bicycle {
    fn facts(self) -> Facts {
        let vehicle = self.vehicle;
        let mut facts = quality_facts(self.quality);
        facts.extend([
            Fact::new("speed", vehicle.speed_mps, "m/s"),
            Fact::new("steering_ratio", vehicle.steering_ratio, ""),
        ]);
        Facts { name: vehicle.name, provenance: Some(self.provenance), evidence: facts }
    }
}
