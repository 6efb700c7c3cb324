//! FMUs for the tests, made from files as importers make them.
#![allow(dead_code, unreachable_pub)]

use fmi2_export::model_description::Value;
use fmi2_export::{CoSimulationUnit, Log, Resources, VariableId};
use steerwright_formats::{Document, InputKind, Longitudinal, Matrix, Plant};
use steerwright_models::linear::discretize;
use steerwright_units::{
    BicyclePlant, Definition, Excitation, Fmu, IdentifiedPlant, LateralPid, LongitudinalPlant,
    NonlinearVehicle, PoseEstimator, ReferencePath, SpeedController,
};

fn column(entries: &[f64]) -> Matrix {
    Matrix(entries.iter().map(|&x| vec![x]).collect())
}

/// A car of third order at 15 m/s. `F[2][0]` is zero.
pub const F: [[f64; 3]; 3] = [[-6.0, 11.0, 0.5], [-9.0, -5.0, 14.0], [0.0, 0.3, -8.0]];
pub const G: [f64; 3] = [0.4, 0.0, 8.0];
pub const H: [f64; 3] = [0.8, 1.1, 0.0];

/// What is different from plant to plant.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    pub d: f64,
    pub delay: f64,
    pub product: bool,
    pub continuous: bool,
    /// Whether the sideslip follows the speed.
    pub over_speed: bool,
}

pub const PLAIN: Kind =
    Kind { d: 0.0, delay: 0.0, product: false, continuous: true, over_speed: false };

/// Every combination that changes the structure.
pub fn kinds() -> Vec<Kind> {
    let mut kinds = Vec::new();
    for d in [0.0, 0.3] {
        for delay in [0.0, 0.033] {
            for product in [false, true] {
                for continuous in [true, false] {
                    for over_speed in [false, true] {
                        kinds.push(Kind { d, delay, product, continuous, over_speed });
                    }
                }
            }
        }
    }
    kinds
}

pub fn plant_file(kind: Kind) -> Plant {
    let f = nalgebra::DMatrix::from_fn(3, 3, |i, j| F[i][j]);
    let g = nalgebra::DMatrix::from_row_slice(3, 1, &G);
    let (a, b) = discretize(&f, &g, 0.02).unwrap();
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "car".into(),
        input: if kind.product { InputKind::SteeringTimesSpeed } else { InputKind::Steering },
        steering_ratio: 1.0,
        input_delay_s: kind.delay,
        operating_point: steerwright_formats::OperatingPoint {
            speed_mps: 15.0,
            steering_offset_rad: 0.01,
            yaw_rate_offset_radps: 0.02,
        },
        discrete: steerwright_formats::Discrete {
            sample_time_s: 0.02,
            a: Matrix((0..3).map(|i| (0..3).map(|j| a[(i, j)]).collect()).collect()),
            b: column(b.as_slice()),
            c: Matrix(vec![H.to_vec()]),
            d: Matrix(vec![vec![kind.d]]),
            k: column(&[0.3, 0.2, 0.1]),
            x0: vec![0.0; 3],
        },
        continuous: kind.continuous.then(|| steerwright_formats::Continuous {
            f: Matrix(F.map(|row| row.to_vec()).to_vec()),
            g: column(&G),
            h: Matrix(vec![H.to_vec()]),
        }),
        noise: steerwright_formats::Noise { innovation_variance: 1e-4 },
        sideslip: Some(steerwright_formats::Sideslip {
            speed_mps: None,
            sideslip_per_yaw_rate_s: -0.06,
            standard_error_s: 0.001,
            sideslip_growth_s5pm2: Some(term(-0.001)),
            sideslip_per_yaw_acceleration_s2: Some(term(0.003)),
            distance_rear_m: kind.over_speed.then(|| term(1.4)),
            gnss_latency_s: 0.0,
            gnss_latency_standard_error_s: None,
            antenna_x_m: 0.0,
        }),
        uncertainty: None,
        evidence: steerwright_formats::Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: steerwright_formats::Provenance::default(),
    }
}

fn term(value: f64) -> steerwright_formats::SideslipTerm {
    steerwright_formats::SideslipTerm { value, standard_error: 0.0002 }
}

pub fn identified(kind: Kind) -> IdentifiedPlant {
    let file = plant_file(kind).to_json().into_bytes();
    IdentifiedPlant::open(&Resources::from(vec![("plant.json".into(), file)])).unwrap()
}

pub fn bicycle() -> BicyclePlant {
    BicyclePlant::open(&Resources::default()).unwrap()
}

/// With a delay of 0.025 s.
pub fn nonlinear() -> NonlinearVehicle {
    let mut vehicle = NonlinearVehicle::open(&Resources::default()).unwrap();
    set(&mut vehicle, "actuator_delay", 0.025);
    vehicle
}

pub fn longitudinal_file() -> Longitudinal {
    let text = include_str!("../../../longitudinal-plant/example.json");
    Longitudinal::from_json(text, "longitudinal.json").unwrap()
}

pub fn open_longitudinal(file: &Longitudinal) -> LongitudinalPlant {
    let file = file.to_json().into_bytes();
    LongitudinalPlant::open(&Resources::from(vec![("longitudinal.json".into(), file)])).unwrap()
}

/// An accelerator with a table of gains, a brake and both delays.
pub fn longitudinal() -> LongitudinalPlant {
    open_longitudinal(&longitudinal_file())
}

pub fn pid() -> LateralPid {
    LateralPid::open(&Resources::default()).unwrap()
}

/// The speed controller of the example, enabled.
pub fn speed_controller() -> SpeedController {
    let file = include_bytes!("../../../speed-controller/example.json").to_vec();
    SpeedController::open(&Resources::from(vec![("speed_controller.json".into(), file)])).unwrap()
}

/// The manoeuvre of the example, enabled.
pub fn excitation() -> Excitation {
    let file = include_bytes!("../../../excitation/example.json").to_vec();
    Excitation::open(&Resources::from(vec![("excitation.json".into(), file)])).unwrap()
}

/// With fixes that are 0.05 s late and an antenna elsewhere.
pub fn pose() -> PoseEstimator {
    let mut estimator = PoseEstimator::open(&Resources::default()).unwrap();
    set(&mut estimator, "gnss_latency", 0.05);
    set(&mut estimator, "antenna_x", 0.6);
    estimator
}

/// A circle of 30 m radius, closed or open.
pub fn path(closed: bool) -> ReferencePath {
    path_over_speed(closed, vec![])
}

/// The circle with a guidance over speed.
pub fn path_over_speed(
    closed: bool,
    schedule: Vec<steerwright_formats::GuidanceEntry>,
) -> ReferencePath {
    let radius = 30.0;
    let points = (0..60)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 60.0;
            steerwright_formats::PathPoint {
                distance_m: radius * angle,
                x_m: radius * angle.sin(),
                y_m: radius * (1.0 - angle.cos()),
                heading_rad: angle,
                curvature_per_m: 1.0 / radius,
            }
        })
        .collect();
    let file = steerwright_formats::Path {
        schema: steerwright_formats::Path::SCHEMA.into(),
        name: "circle".into(),
        closed,
        speed_mps: 10.0,
        points,
        profile: None,
        guidance: steerwright_formats::Guidance {
            lookahead_time_s: 1.0,
            lookahead_min_m: 5.0,
            preview_time_s: 0.2,
            feedforward_gain_radm: 2.7,
            sideslip_per_yaw_rate_s: 0.05,
            cross_track_integral_gain_per_s: 0.1,
            sideslip_per_yaw_acceleration_s2: 0.004,
            sideslip_growth_s5pm2: -0.001,
            distance_rear_m: 1.4,
            yaw_acceleration_gain_s2: -0.006,
            yaw_jerk_gain_s3: 0.0004,
            sideslip_correction_time_s: 4.0,
            speed_preview_time_s: 0.3,
            brake_preview_time_s: 0.2,
        },
        schedule,
        provenance: steerwright_formats::Provenance::default(),
    };
    let file = file.to_json().into_bytes();
    ReferencePath::open(&Resources::from(vec![("path.json".into(), file)])).unwrap()
}

/// The unit of an FMU's example.
pub fn example<S: Definition>() -> S {
    let fmu = Fmu::ALL.into_iter().find(|fmu| fmu.name() == S::TABLE.model_name).unwrap();
    let document = fmu.example().as_bytes().to_vec();
    S::open(&Resources::from(vec![(S::RESOURCE.into(), document)])).unwrap()
}

/// The variable of that name.
pub fn variable<S: CoSimulationUnit>(name: &str) -> S::Variable {
    S::Variable::from_reference(S::TABLE.named(name).unwrap().reference).unwrap()
}

pub fn set<S: CoSimulationUnit>(unit: &mut S, name: &str, value: f64) {
    unit.set(variable::<S>(name), &Value::Real(value));
}

pub fn get<S: CoSimulationUnit>(unit: &mut S, name: &str) -> f64 {
    match unit.get(variable::<S>(name)) {
        Value::Real(value) => value,
        Value::Integer(value) => f64::from(value),
        Value::Boolean(value) => f64::from(u8::from(value)),
        Value::String(_) => panic!("{name} is a text"),
    }
}

pub fn start<S: CoSimulationUnit>(unit: &mut S) {
    unit.exit_initialization(0.0, &mut Log::default()).unwrap();
}

pub fn step<S: CoSimulationUnit>(unit: &mut S, h: f64) {
    unit.step(0.0, h, &mut Log::default()).unwrap();
}
