//! Made-up but plausible content of the files of the other stages.
#![allow(dead_code, missing_docs, unreachable_pub)]

mod evidence;
mod loops;

use steerwright_formats::*;
use steerwright_report::Traces;

pub use evidence::evidence;
pub use loops::{path, pid, step, track};

/// A small repeatable noise in −1…1 (a linear congruential generator).
pub fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as f64 / f64::from(1u32 << 30) - 1.0
}

pub fn traces(samples: usize) -> Traces {
    let mut t = Traces::default();
    let (mut seed, mut r, mut yaw, mut simulated_yaw) = (7, 0.0, 0.0, 0.0);
    let dt = 300.0 / samples as f64;
    for k in 0..samples {
        let time = k as f64 * dt;
        let steering = 0.06 * (0.21 * time).sin() + 0.04 * (0.83 * time + 1.0).sin().powi(3);
        r += dt / 0.25 * (3.2 * steering - r);
        let measured = r + 0.012 * noise(&mut seed) + 0.02 * (0.3 * time).cos();
        yaw += dt * measured;
        simulated_yaw += dt * r;
        t.time_s.push(time);
        t.steering_rad.push(steering);
        t.yaw_rate_radps.push(measured);
        t.simulated_yaw_rate_radps.push(r);
        t.is_validation.push(k >= samples / 2);
        t.yaw_rad.push(yaw);
        t.simulated_yaw_rad.push(simulated_yaw);
    }
    t.bicycle_yaw_rate_radps = Some(t.simulated_yaw_rate_radps.iter().map(|r| 1.25 * r).collect());
    t
}

pub fn provenance() -> Provenance {
    Provenance {
        version: "0.1.0".into(),
        sources: vec![SourceFile::from_bytes("drive \"<b>& 'one'.csv".as_ref(), b"drive")],
        options: [("order".to_owned(), "auto".to_owned()), ("horizon".into(), "20".into())].into(),
    }
}

/// The plant as a model.
pub fn model() -> Model {
    Model::StateSpace(Box::new(plant()))
}

pub fn plant() -> Plant {
    let m = |rows: &[&[f64]]| Matrix(rows.iter().map(|r| r.to_vec()).collect());
    Plant {
        schema: Plant::SCHEMA.into(),
        name: "250 LM".into(),
        input: InputKind::Steering,
        steering_ratio: 1.0,
        input_delay_s: 0.05,
        operating_point: OperatingPoint {
            speed_mps: 38.2,
            steering_offset_rad: 0.0012,
            yaw_rate_offset_radps: 0.0,
        },
        discrete: Discrete {
            sample_time_s: 0.05,
            a: m(&[&[0.8, 0.1], &[-0.1, 0.7]]),
            b: m(&[&[0.2], &[0.1]]),
            c: m(&[&[1.0, 0.0]]),
            d: m(&[&[0.0]]),
            k: m(&[&[0.1], &[0.0]]),
            x0: vec![0.0, 0.0],
        },
        continuous: None,
        noise: Noise { innovation_variance: 1e-5 },
        sideslip: None,
        uncertainty: None,
        evidence: evidence(),
        quality: steerwright_formats::Quality::default(),
        provenance: provenance(),
    }
}

pub fn bicycle() -> Bicycle {
    let vehicle = VehicleData {
        name: "sedan".into(),
        mass_kg: 1573.0,
        yaw_inertia_kgm2: 2873.0,
        distance_front_m: 1.1,
        distance_rear_m: 1.58,
        cornering_stiffness_front_npr: 160_000.0,
        cornering_stiffness_rear_npr: 160_000.0,
        actuator_time_constant_s: 0.1,
        steering_ratio: 15.0,
        speed_mps: 20.0,
        ..VehicleData::default()
    };
    Bicycle { provenance: provenance(), ..Bicycle::new(vehicle) }
}
