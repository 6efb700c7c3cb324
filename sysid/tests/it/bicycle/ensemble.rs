//! The ensemble of vehicles around the identified one.

use super::{DRIVE, Drive, at_end, car, drive, estimated, evidence, known};
use steerwright_formats::VehicleData;
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};

/// The vehicles that may be drawn differ by the standard errors of the combinations.
#[test]
fn the_ensemble_varies_by_the_standard_errors() {
    let steady = |v: &VehicleData| {
        let (a, b) = (v.distance_front_m, v.distance_rear_m);
        let (f, r) = (v.cornering_stiffness_front_npr, v.cornering_stiffness_rear_npr);
        let gradient = v.mass_kg * (b * r - a * f) / (f * r * (a + b));
        v.speed_mps / (a + b + gradient * v.speed_mps.powi(2)) / v.steering_ratio
    };
    for wheelbase_m in [None, Some(2.6)] {
        let noisy = drive(car(), Drive { noise: 0.01, ..DRIVE });
        let options = BicycleOptions { wheelbase_m, validation: at_end(), ..known() };
        let found = identify_bicycle(&noisy, &options).unwrap();
        let (e, n) = (evidence(&found), found.bicycle.ensemble_dimension());
        // Two axles, inertia, lag, and the wheelbase or the steering's factor.
        assert_eq!(n, 5);
        // Angles are those of the road wheel by the log's steering ratio.
        let ratio = noisy.steering_ratio;
        type Of<'a> = &'a dyn Fn(&VehicleData) -> f64;
        let combinations: [(&str, Of<'_>); 4] = [
            ("yaw_rate_gain", &|v| steady(v) * ratio),
            ("dynamic_index", &|v| {
                v.yaw_inertia_kgm2 / (v.mass_kg * v.distance_front_m * v.distance_rear_m)
            }),
            ("rear_stiffness_per_mass", &|v| v.cornering_stiffness_rear_npr / v.mass_kg),
            ("actuator_time_constant", &|v| v.actuator_time_constant_s),
        ];
        for (name, of) in combinations {
            let (value, error) = estimated(e, name);
            assert!((of(&found.bicycle.vehicle) / value - 1.0).abs() < 1e-9, "{name}");
            let h = 1e-3;
            let variance: f64 = (0..n)
                .map(|k| {
                    let along = |times: f64| {
                        let xi: Vec<f64> =
                            (0..n).map(|i| if i == k { times } else { 0.0 }).collect();
                        of(&found.bicycle.ensemble_member(&xi).unwrap())
                    };
                    ((along(h) - along(-h)) / (2.0 * h)).powi(2)
                })
                .sum();
            assert!((variance.sqrt() / error - 1.0).abs() < 1e-4, "{name}: {variance} {error}");
        }
        assert!(found.bicycle.ensemble_member(&[0.0; 4]).is_none());
        assert!(found.bicycle.ensemble_member(&[1e6; 5]).is_none());
    }
}
