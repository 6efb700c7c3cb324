//! Vehicles and identified plants for the tests.

use nalgebra::DMatrix;
use steerwright_control::{DesignOptions, DesignPlant, bicycle_from_toml, design};
use steerwright_formats::{
    Bicycle, Continuous, Discrete, InputKind, Matrix, Noise, OperatingPoint, Pid, Plant,
    SourceFile, Specification,
};

/// The usual options, with an actuator that is faster than any increment and no bound of the angle by speed.
pub(crate) fn options() -> DesignOptions {
    DesignOptions {
        max_rate_radps: Some(1e3),
        max_lateral_acceleration_mps2: 1e3,
        ..DesignOptions::default()
    }
}

/// The usual options with other requirements.
pub(crate) fn requiring(change: impl Fn(&mut Specification)) -> DesignOptions {
    let mut options = options();
    change(&mut options.requirements);
    options
}

/// The file that the plants of the tests come from.
pub(crate) fn source() -> SourceFile {
    SourceFile::from_bytes(std::path::Path::new("plant.json"), b"{}")
}

pub(crate) fn designed(plant: &DesignPlant, options: &DesignOptions) -> Pid {
    design(plant, &source(), options).expect("a design")
}

/// A typical car at 15 m/s, with or without a steering wheel.
pub(crate) fn car(steering_ratio: f64) -> Bicycle {
    let text = format!(
        "name = \"car\"\nmass_kg = 1093.3\nyaw_inertia_kgm2 = 1791.6\ndistance_front_m = 1.156\n\
         distance_rear_m = 1.422\ncornering_stiffness_front_npr = 110000.0\n\
         cornering_stiffness_rear_npr = 105000.0\nactuator_time_constant_s = 0.05\n\
         steering_ratio = {steering_ratio:?}\nspeed_mps = 15.0\n"
    );
    bicycle_from_toml(&text, "car.toml").expect("a bicycle")
}

/// An identified plant with these continuous matrices, as `plant.json` holds it.
pub(crate) fn identified(f: &[f64], g: &[f64], h: &[f64], sample_time: f64, delay: f64) -> Plant {
    let n = g.len();
    let (a, b) = steerwright_models::linear::discretize(
        &DMatrix::from_row_slice(n, n, f),
        &DMatrix::from_row_slice(n, 1, g),
        sample_time,
    )
    .expect("a discrete model");
    let row = |v: &[f64]| Matrix(vec![v.to_vec()]);
    Plant {
        schema: "steerwright/plant/1".into(),
        name: "drive".into(),
        input: InputKind::Steering,
        steering_ratio: 1.0,
        input_delay_s: delay,
        operating_point: OperatingPoint {
            speed_mps: 15.0,
            steering_offset_rad: 0.01,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: sample_time,
            a: Matrix::from_fn(n, n, |i, j| a[(i, j)]),
            b: Matrix::from_fn(n, 1, |i, _| b[(i, 0)]),
            c: row(h),
            d: row(&[0.0]),
            k: Matrix::column(&vec![0.0; n]),
            x0: vec![0.0; n],
        },
        continuous: Some(Continuous {
            f: Matrix::from_fn(n, n, |i, j| f[i * n + j]),
            g: Matrix::column(g),
            h: row(h),
        }),
        noise: Noise { innovation_variance: 1e-4 },
        sideslip: None,
        uncertainty: None,
        evidence: steerwright_formats::Evidence::default(),
        quality: steerwright_formats::Quality::default(),
        provenance: steerwright_formats::Provenance::default(),
    }
}

/// The car's yaw rate as an identified plant would hold it.
pub(crate) fn identified_car() -> Plant {
    let car = car(1.0);
    let parameters = steerwright_models::files::bicycle_parameters(&car.vehicle);
    let (f, g) = steerwright_models::bicycle_body_frame(&parameters, 15.0);
    let f: Vec<f64> = (0..9).map(|i| f[(i / 3, i % 3)]).collect();
    identified(&f, g.as_slice(), &[0.0, 1.0, 0.0], 0.01, 0.0)
}

/// A plant from the coefficients of numerator and monic denominator, highest power first.
pub(crate) fn transfer(numerator: &[f64], denominator: &[f64], delay: f64) -> DesignPlant {
    let n = denominator.len();
    let mut f = vec![0.0; n * n];
    for j in 0..n {
        f[j] = -denominator[j];
    }
    for i in 1..n {
        f[i * n + i - 1] = 1.0;
    }
    let mut g = vec![0.0; n];
    g[0] = 1.0;
    let mut h = vec![0.0; n];
    h[n - numerator.len()..].copy_from_slice(numerator);
    DesignPlant::from_plant(&identified(&f, &g, &h, 0.01, delay)).expect("a plant")
}
