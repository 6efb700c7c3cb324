//! The sideslip of a vehicle from its files to the path follower and the pose estimator.

use crate::support::{chain, document, done, run, text_of};
use std::path::Path;
use steerwright_formats::{Document, SideslipTerm};
use steerwright_host::Archive;

/// The start value of an FMU's variable in a folder of archives.
fn start(folder: &Path, fmu: &str, name: &str) -> f64 {
    let archive = Archive::open(folder.join(format!("{fmu}.fmu"))).unwrap();
    match archive.model().variable(name).unwrap().start {
        Some(steerwright_host::Value::Real(value)) => value,
        ref other => panic!("{other:?}"),
    }
}

/// The bicycle model's own sideslip reaches path and estimator, unless their files state one.
#[test]
fn the_sideslip_of_the_plant_is_that_of_path_and_estimator() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let loop_of = |plant: &str, path: &str| {
        let rest = "{chain}/pid.json {data}/multibody/estimator.json";
        done(folder, &format!("package {plant} {path} {rest} --ssp L.ssp"));
        ["ReferencePath", "PoseEstimator"].map(|fmu| start(folder, fmu, "sideslip_per_yaw_rate"))
    };
    let bicycle = document::<steerwright_formats::Bicycle>(&chain().join("bicycle.json")).vehicle;
    let expected = steerwright_models::files::bicycle_parameters(&bicycle)
        .sideslip_per_yaw_rate(bicycle.speed_mps);
    assert!(expected.abs() > 0.005, "{expected}");
    assert_eq!(loop_of("{chain}/bicycle.json", "{chain}/path.json"), [expected; 2]);
    // At the speed of the path, which is that of the loop.
    let slow = "path --pid {chain}/pid.json --speed 8m/s -o slow.json";
    done(folder, slow);
    let at_8 = steerwright_models::files::bicycle_parameters(&bicycle).sideslip_per_yaw_rate(8.0);
    assert!((at_8 - expected).abs() > 0.05, "{at_8} {expected}");
    assert_eq!(loop_of("{chain}/bicycle.json", "slow.json"), [at_8; 2]);
    // From there it follows the speed.
    for fmu in ["ReferencePath", "PoseEstimator"] {
        assert_eq!(start(folder, fmu, "distance_rear"), bicycle.distance_rear_m);
        assert_eq!(start(folder, fmu, "sideslip_reference_speed"), 8.0);
    }
    // This drive's log has no fixes.
    assert_eq!(loop_of("{chain}/plant.json", "{chain}/path.json"), [0.0; 2]);
    done(folder, "path --pid {chain}/pid.json --sideslip-per-yaw-rate=-30ms -o own.json");
    assert_eq!(loop_of("{chain}/bicycle.json", "own.json"), [-0.03, expected]);
    done(folder, "path --pid {chain}/pid.json --plant {chain}/bicycle.json -o of_plant.json");
    let path = document::<steerwright_formats::Path>(&folder.join("of_plant.json"));
    let at_15 = steerwright_models::files::bicycle_parameters(&bicycle).sideslip_per_yaw_rate(15.0);
    assert_eq!(path.guidance.sideslip_per_yaw_rate_s, at_15);
    let lead =
        steerwright_models::files::bicycle_parameters(&bicycle).sideslip_per_yaw_acceleration(15.0);
    assert_eq!(path.guidance.sideslip_per_yaw_acceleration_s2, lead);
    // A vehicle is a bicycle in gentle driving.
    done(folder, "path --plant {data}/multibody/vehicle.json --speed 15m/s -o of_vehicle.json");
    let of_vehicle = document::<steerwright_formats::Path>(&folder.join("of_vehicle.json"));
    assert!((of_vehicle.guidance.sideslip_per_yaw_rate_s - at_15).abs() < 0.05, "{of_vehicle:?}");
    assert!(of_vehicle.guidance.sideslip_per_yaw_rate_s != 0.0);
    let output = run(folder, "path --plant {chain}/pid.json");
    assert_eq!(output.status.code(), Some(2));
    assert!(text_of(&output).contains("no plant"), "{}", text_of(&output));
}

/// The sideslip identified from a drive with fixes reaches path and estimator in full: by `path
/// --plant`, and in a package whose files state none.
#[test]
fn growth_and_lead_of_a_drive_reach_path_and_estimator() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let drive = "{data}/multibody/drive.csv {data}/multibody/position.csv";
    let columns = "--input-channel steering_command_rad --output-channel yaw_rate_radps --steering-ratio 1 --gnss-latency 0s";
    let output = done(folder, &format!("identify {drive} {columns} --order 2 -o car.json"));
    for line in ["s per yaw rate", "ms of it per (m/s²)²", "s2 per yaw acceleration"] {
        assert!(text_of(&output).contains(line), "{line}: {}", text_of(&output));
    }
    let plant = document::<steerwright_formats::Plant>(&folder.join("car.json"));
    let found = plant.sideslip.unwrap();
    assert!(found.growth() < 0.0 && found.per_yaw_acceleration() > 0.0, "{found:?}");

    let output = done(folder, "path --pid {chain}/pid.json --plant car.json -o own.json");
    assert!(text_of(&output).contains("more per (m/s²)²"), "{}", text_of(&output));
    let path = document::<steerwright_formats::Path>(&folder.join("own.json"));
    // The drive was a little slower than the path.
    let law = steerwright_control::plant_sideslip(&plant).unwrap().at_speed(path.speed_mps);
    let (rate, growth, lead) = (law.per_yaw_rate, law.growth, law.per_yaw_acceleration);
    assert!((rate - found.sideslip_per_yaw_rate_s).abs() < 2e-4, "{rate} {found:?}");
    let guidance = path.guidance;
    assert_eq!(guidance.sideslip_per_yaw_rate_s, rate);
    assert_eq!(guidance.sideslip_growth_s5pm2, growth);
    assert_eq!(guidance.sideslip_per_yaw_acceleration_s2, lead);

    let rest = "{chain}/pid.json {data}/multibody/estimator.json --ssp L.ssp";
    done(folder, &format!("package car.json {{chain}}/path.json {rest}"));
    for (fmu, name, expected) in [
        ("ReferencePath", "sideslip_per_yaw_rate", rate),
        ("ReferencePath", "sideslip_growth", growth),
        ("ReferencePath", "sideslip_per_yaw_acceleration", lead),
        ("PoseEstimator", "sideslip_per_yaw_rate", rate),
        ("PoseEstimator", "sideslip_growth", growth),
        ("PoseEstimator", "sideslip_per_yaw_acceleration", lead),
    ] {
        assert_eq!(start(folder, fmu, name), expected, "{fmu} {name}");
    }
    assert_eq!(start(folder, "ReferencePath", "distance_rear"), found.distance_rear());

    // With the distance to the rear axle it is that of the path's speed.
    let mut plant = document::<steerwright_formats::Plant>(&folder.join("car.json"));
    let stated = plant.sideslip.as_mut().unwrap();
    stated.distance_rear_m = Some(SideslipTerm { value: 1.4, standard_error: 0.05 });
    std::fs::write(folder.join("over_speed.json"), plant.to_json()).unwrap();
    let output = done(folder, "path --plant over_speed.json --speed 8m/s -o slow.json");
    assert!(text_of(&output).contains("all at 8.0 m/s; rear axle 1.40 m"), "{}", text_of(&output));
    let guidance = document::<steerwright_formats::Path>(&folder.join("slow.json")).guidance;
    let speed = plant.operating_point.speed_mps;
    let rate = found.sideslip_per_yaw_rate_s;
    let at_8 = 1.4 / 8.0 - 8.0 * (1.4 / speed - rate) / speed;
    assert!((guidance.sideslip_per_yaw_rate_s - at_8).abs() < 1e-12, "{guidance:?} {at_8}");
    assert!((guidance.sideslip_growth_s5pm2 - found.growth() * 8.0 / speed).abs() < 1e-12);
    assert_eq!(guidance.distance_rear_m, 1.4);

    // One that is given by hand stands alone.
    done(folder, "path --plant car.json --sideslip-per-yaw-rate=-30ms -o given.json");
    let text = std::fs::read_to_string(folder.join("given.json")).unwrap();
    assert!(text.contains("-0.03") && !text.contains("sideslip_growth"), "{text}");
    done(folder, &format!("package car.json given.json {rest}"));
    assert_eq!(start(folder, "ReferencePath", "sideslip_growth"), 0.0);
}

/// Whatever the structure, the file states the sideslip of the fixes, and a path takes it from there.
#[test]
fn every_structure_states_the_sideslip_of_the_fixes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let drive = "{data}/multibody/drive.csv {data}/multibody/position.csv";
    let columns = "--input-channel steering_command_rad --steering-ratio 1 --gnss-latency 0s";
    let mut guided = Vec::new();
    for structure in ["state-space", "bicycle", "single-track"] {
        let line =
            format!("identify {drive} {columns} --structure {structure} -o model.json --force");
        let text = text_of(&run(folder, &line));
        assert!(text.contains("s per yaw rate, with fixes 0 s old"), "{structure}: {text}");
        assert!(!text.contains("the GNSS fixes are not used"), "{structure}: {text}");
        done(folder, "path --pid {chain}/pid.json --plant model.json -o path.json --force");
        let path = document::<steerwright_formats::Path>(&folder.join("path.json"));
        assert!(path.guidance.sideslip_growth_s5pm2 < 0.0, "{structure}: {:?}", path.guidance);
        guided.push(path.guidance);
    }
    let [plant, bicycle, vehicle] = [guided[0], guided[1], guided[2]];
    assert_eq!(plant, bicycle);
    assert_eq!(bicycle, vehicle);
}
