//! Bicycle models: the textbook's transfer function, and the errors of wrong files.

use nalgebra::{Complex, DMatrix, DVector};
use steerwright_control::{DesignPlant, Error, bicycle_from_toml};
use steerwright_formats::{Bicycle, Document};

const CAR: &str = r#"name = "car"
mass_kg = 1093.3
yaw_inertia_kgm2 = 1791.6
distance_front_m = 1.156
distance_rear_m = 1.422
cornering_stiffness_front_npr = 110000.0
cornering_stiffness_rear_npr = 105000.0
actuator_time_constant_s = 0.05
steering_ratio = 15.0
speed_mps = 15.0
"#;

/// r(s)/steering(s) of the two-wheel model as vehicle dynamics texts print it, with the actuator.
fn textbook(b: &Bicycle, s: Complex<f64>) -> Complex<f64> {
    let v = &b.vehicle;
    let (m, j, speed) = (v.mass_kg, v.yaw_inertia_kgm2, v.speed_mps);
    let (lf, lr) = (v.distance_front_m, v.distance_rear_m);
    let (cf, cr) = (v.cornering_stiffness_front_npr, v.cornering_stiffness_rear_npr);
    let l = lf + lr;
    let numerator = s * (lf * cf / j) + l * cf * cr / (m * j * speed);
    let damping = (cf + cr) / (m * speed) + (lf * lf * cf + lr * lr * cr) / (j * speed);
    let stiffness = l * l * cf * cr / (m * j * speed * speed) + (lr * cr - lf * cf) / j;
    let actuator = (s * v.actuator_time_constant_s + 1.0) * v.steering_ratio;
    numerator / (s * s + s * damping + stiffness) / actuator
}

/// ψ̇ of eq 13, whose states are (y, ẏ, ψ, ψ̇, δ).
fn eq13(b: &Bicycle, s: Complex<f64>) -> Complex<f64> {
    let a = DMatrix::from_fn(5, 5, |i, k| {
        let diagonal = if i == k { s } else { Complex::new(0.0, 0.0) };
        diagonal - b.state_matrix.entry(i, k)
    });
    let input = DVector::from_fn(5, |i, _| Complex::new(b.input_matrix.entry(i, 0), 0.0));
    a.lu().solve(&input).expect("a regular matrix")[3]
}

#[test]
fn eq_13_has_the_textbook_frequency_response() {
    for speed in [3.0, 15.0, 40.0] {
        let text = CAR.replace("speed_mps = 15.0", &format!("speed_mps = {speed:?}"));
        let b = bicycle_from_toml(&text, "car.toml").expect("a bicycle");
        for omega in [0.01, 0.3, 1.0, 4.0, 10.0, 50.0] {
            let s = Complex::new(0.0, omega);
            let (expected, printed) = (textbook(&b, s), eq13(&b, s));
            assert!((printed - expected).norm() < 1e-9 * expected.norm(), "{speed} {omega}");
        }
    }
}

/// v/(L + K·v²), K = m·(lr·Cr − lf·Cf)/(Cf·Cr·L), over the steering ratio.
#[test]
fn the_steady_state_gain_is_that_of_the_understeer_gradient() {
    let b = bicycle_from_toml(CAR, "car.toml").expect("a bicycle");
    let l = 1.156 + 1.422;
    let k = 1093.3 * (1.422 * 105e3 - 1.156 * 110e3) / (110e3 * 105e3 * l);
    let expected = 15.0 / (l + k * 225.0) / 15.0;
    let plant = DesignPlant::from_bicycle(&b).expect("a plant");
    assert!((plant.gain() / expected - 1.0).abs() < 1e-12);
    assert_eq!((plant.speed, plant.steering_ratio, plant.model.as_str()), (15.0, 15.0, "bicycle"));
}

#[test]
fn the_document_is_read_back_and_names_its_source() {
    let b = bicycle_from_toml(CAR, "folder/car.toml").expect("a bicycle");
    assert_eq!(Bicycle::from_json(&b.to_json(), "bicycle.json").expect("the same"), b);
    assert_eq!(b.provenance.sources[0].name, "car.toml");
    assert_eq!(b.coefficients.a1, -(110e3 + 105e3) / 1093.3);
    assert_eq!(b.coefficients.n, 1.0 / 15.0);
}

#[test]
fn faults_in_the_file_have_a_place() {
    let refused = |from: &str, to: &str| {
        let error = bicycle_from_toml(&CAR.replace(from, to), "car.toml").expect_err("a fault");
        assert!(!error.hint().is_empty());
        error.to_string()
    };
    assert!(refused("mass_kg = 1093.3", "mass_kg = -1.0").starts_with("car.toml:2:11: mass_kg"));
    assert!(refused("1791.6", "\"heavy\"").starts_with("car.toml:3:20: "));
    assert!(refused("speed_mps = 15.0", "speed_kmh = 54.0").starts_with("car.toml:10:1: unknown"));
    assert!(refused("distance_rear_m = 1.422\n", "").contains("distance_rear_m"));
    assert!(refused("0.05", "0.0").starts_with("car.toml:8:28: actuator_time_constant_s"));
    assert!(refused("1.156", "nan").starts_with("car.toml:4:20: distance_front_m"));
    assert!(refused("name = \"car\"", "name = car").starts_with("car.toml:1:"));
}

#[test]
fn the_hint_of_a_fault_lists_every_key_of_the_file() {
    let error = bicycle_from_toml("", "car.toml").expect_err("a fault");
    let mut b = bicycle_from_toml(CAR, "car.toml").expect("a bicycle");
    // Left out where it is 0.
    b.vehicle.actuator_delay_s = 0.1;
    let json = b.to_json();
    let vehicle = json.split("\"vehicle\": {").nth(1).and_then(|rest| rest.split('}').next());
    let keys: Vec<&str> =
        vehicle.unwrap_or_default().lines().filter_map(|line| line.split('"').nth(1)).collect();
    assert!(keys.len() >= 11, "{keys:?}");
    for key in keys {
        assert!(error.hint().contains(key), "{key}: {}", error.hint());
    }
}

/// An oversteering car above its critical speed √(−L/K).
#[test]
fn an_unstable_vehicle_is_refused() {
    let loose = CAR.replace("rear_npr = 105000.0", "rear_npr = 60000.0");
    let slow = bicycle_from_toml(&loose, "car.toml").expect("a bicycle");
    let l = 2.578_f64;
    let k = 1093.3 * (1.422 * 60e3 - 1.156 * 110e3) / (110e3 * 60e3 * l);
    let critical = (-l / k).sqrt();
    assert!(critical > 15.0 && DesignPlant::from_bicycle(&slow).is_ok());
    for (share, stable) in [(0.99, true), (1.01, false)] {
        let mut fast = slow.clone();
        fast.vehicle.speed_mps = share * critical;
        match DesignPlant::from_bicycle(&fast) {
            Ok(_) => assert!(stable),
            Err(error) => {
                assert!(!stable && matches!(error, Error::UnstablePlant { .. }), "{error}");
                assert!(error.hint().contains("lower speed"));
            }
        }
    }
}
