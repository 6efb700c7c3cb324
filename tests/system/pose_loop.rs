//! The loop with a pose from GNSS, gyro and speed alone: packed plant, estimator, path and
//! controller, the receiver and the gyro simulated here.

use crate::support::{archives, data, demo, document, done, run};
use std::path::Path;
use steerwright_control::paths::PathComposer;
use steerwright_formats::{Bicycle, Document, Path as PathFile, Pid, Vehicle};
use steerwright_host::{Archive, Instance};
use steerwright_models::noise::gaussian;

const H: f64 = 0.01;
const GYRO_BIAS: f64 = 0.005;
const LATENCY: f64 = 0.1;
/// Between fixes and between a fix and its arrival.
const STEPS_PER_FIX: usize = 10;

/// A unit between its initialization and its first step.
fn started(archives: &Path, name: &str, values: &[(&str, f64)]) -> Instance {
    let archive = Archive::open(archives.join(format!("{name}.fmu"))).unwrap();
    let mut unit = Instance::new(&archive, name).unwrap();
    unit.setup_experiment(0.0, None, None).unwrap();
    let (inputs, parameters): (Vec<_>, Vec<_>) =
        values.iter().partition(|(name, _)| *name == "speed");
    for (name, value) in parameters {
        unit.set(name, value).unwrap();
    }
    unit.enter_initialization_mode().unwrap();
    for (name, value) in inputs {
        unit.set(name, value).unwrap();
    }
    unit.exit_initialization_mode().unwrap();
    unit
}

/// Errors of a drive and of the estimated position.
#[derive(Debug, Default)]
struct Outcome {
    rms_cross_track_error: f64,
    largest_cross_track_error: f64,
    largest_position_error: f64,
    /// Share of the steps in which the position was within three of its deviations.
    within_three: f64,
    steered: f64,
}

struct Receiver {
    std: f64,
    /// No fix arrives between these times, s.
    silent: std::ops::Range<f64>,
    /// Whether the estimator learns what the sideslip is beyond the stated one.
    learns: bool,
    seed: i32,
}

/// The road of the demo at its speed.
fn drive(plant: &str, sideslip_per_yaw_rate: f64, receiver: &Receiver) -> Outcome {
    let path: PathFile = document(&demo().folder.join("multibody/path.json"));
    let (first, last) = (path.points[0], path.points[path.points.len() - 1]);
    let speed = path.speed_mps;
    let seconds = (last.distance_m - first.distance_m) / speed;
    let sideslip = [("sideslip_per_yaw_rate", sideslip_per_yaw_rate)];
    drive_along(archives(), plant, &path, (&|_| speed, seconds), &sideslip, receiver)
}

/// A speed over time, m/s, for so many seconds.
type Speed<'a> = (&'a dyn Fn(f64) -> f64, f64);

/// Gauss–Seidel, in the order plant, estimator, path, controller. The parameters of the sideslip are those
/// of estimator and path.
fn drive_along(
    archives: &Path,
    plant: &str,
    path: &PathFile,
    (speed, seconds): Speed<'_>,
    sideslip: &[(&str, f64)],
    receiver: &Receiver,
) -> Outcome {
    let first = path.points[0];
    let start =
        [("initial_x", first.x_m), ("initial_y", first.y_m), ("initial_yaw", first.heading_rad)];
    let with_speed = [&start[..], &[("speed", speed(0.0))]].concat();
    let mut plant = started(archives, plant, &with_speed);
    let uncertainty =
        [("gnss_latency", LATENCY), ("initial_position_std", 0.1), ("initial_yaw_std", 0.02)];
    let exact =
        [("initial_sideslip_per_yaw_rate_std", 0.0), ("sideslip_per_yaw_rate_density", 0.0)];
    let learning = if receiver.learns { &[] } else { &exact[..] };
    let of_pose = [&with_speed[..], &uncertainty, learning, sideslip].concat();
    let mut pose = started(archives, "PoseEstimator", &of_pose);
    let of_path = [&[("speed", speed(0.0))], sideslip].concat();
    let mut guide = started(archives, "ReferencePath", &of_path);
    let mut pid = started(archives, "LateralPid", &[]);
    let steps = (seconds / H).floor() as usize;
    let geometry = steerwright_models::files::path_geometry(path).unwrap();
    let (mut at, mut drawn, mut fixes) = (first.distance_m, 0, 0);
    let mut noise = || {
        drawn += 1;
        gaussian(receiver.seed, drawn)
    };
    let mut places = vec![[first.x_m, first.y_m]];
    let mut outcome = Outcome::default();
    let mut squares = 0.0;
    for k in 0..steps {
        let time = k as f64 * H;
        let steering = pid.real("steering_angle").unwrap();
        plant.set("steering_angle", steering).unwrap();
        // The plant holds it over the step.
        plant.set("speed", speed(time + 0.5 * H)).unwrap();
        plant.do_step(time, H).unwrap();
        for unit in [&mut pose, &mut guide, &mut pid] {
            unit.set("speed", speed(time + H)).unwrap();
        }
        outcome.steered = outcome.steered.max(steering.abs());
        let [x, y, yaw_rate] = ["x", "y", "yaw_rate"].map(|name| plant.real(name).unwrap());
        places.push([x, y]);

        // A gyro of 1e-3 (rad/s)/√Hz at this rate; a fix of where the vehicle was.
        pose.set("yaw_rate", yaw_rate + GYRO_BIAS + 0.01 * noise()).unwrap();
        let end = time + H;
        if (k + 1) % STEPS_PER_FIX == 0 && !receiver.silent.contains(&end) {
            let [x, y] = places[k + 1 - STEPS_PER_FIX];
            fixes += 1;
            pose.set("gnss_x", x + receiver.std * noise()).unwrap();
            pose.set("gnss_y", y + receiver.std * noise()).unwrap();
            pose.set("gnss_std", receiver.std).unwrap();
            pose.set("gnss_fix_count", fixes).unwrap();
        }
        pose.do_step(time, H).unwrap();
        let names = ["x", "y", "yaw", "sideslip_per_yaw_rate_offset"];
        let estimate = names.map(|name| pose.real(name).unwrap());
        for (name, value) in names.iter().zip(estimate) {
            guide.set(name, value).unwrap();
        }
        guide.do_step(time, H).unwrap();
        for name in ["yaw_reference", "steering_feedforward"] {
            pid.set(name, guide.real(name).unwrap()).unwrap();
        }
        pid.set("yaw", estimate[2]).unwrap();
        pid.do_step(time, H).unwrap();

        let away = (estimate[0] - x).hypot(estimate[1] - y);
        outcome.largest_position_error = outcome.largest_position_error.max(away);
        outcome.within_three +=
            f64::from(u8::from(away < 3.0 * pose.real("position_std").unwrap())) / steps as f64;
        let foot = geometry.project(x, y, at);
        at = foot.foot.distance_m;
        squares += foot.cross_track_error.powi(2);
        outcome.largest_cross_track_error =
            outcome.largest_cross_track_error.max(foot.cross_track_error.abs());
    }
    outcome.rms_cross_track_error = (squares / steps as f64).sqrt();
    println!("{outcome:.3?}");
    outcome
}

#[test]
fn centimetre_fixes_keep_the_car_on_the_road() {
    let receiver = Receiver { std: 0.02, silent: 0.0..0.0, learns: true, seed: 1 };
    let outcome = drive("IdentifiedPlant", 0.0, &receiver);
    assert!(outcome.rms_cross_track_error < 0.1, "{outcome:?}");
    assert!(outcome.largest_position_error < 0.2 && outcome.within_three > 0.97, "{outcome:?}");
    assert!(outcome.steered > 0.01, "{outcome:?}");
}

/// A vehicle whose course is not its yaw.
#[test]
fn sideslip_is_a_parameter_of_estimator_and_path() {
    let bicycle: Bicycle = document(&demo().folder.join("multibody/bicycle.json"));
    let path: PathFile = document(&demo().folder.join("multibody/path.json"));
    let parameters = steerwright_models::files::bicycle_parameters(&bicycle.vehicle);
    let sideslip = parameters.sideslip_per_yaw_rate(path.speed_mps);
    assert!(sideslip.abs() > 0.01, "{sideslip}");
    let receiver = Receiver { std: 0.02, silent: 0.0..0.0, learns: true, seed: 2 };
    let outcome = drive("BicyclePlant", sideslip, &receiver);
    assert!(outcome.rms_cross_track_error < 0.1, "{outcome:?}");
    assert!(outcome.largest_position_error < 0.2 && outcome.within_three > 0.95, "{outcome:?}");
}

#[test]
fn two_seconds_without_fixes_and_metre_noise_are_survived() {
    let receiver = Receiver { std: 0.02, silent: 5.0..7.0, learns: true, seed: 3 };
    let outcome = drive("IdentifiedPlant", 0.0, &receiver);
    assert!(outcome.largest_cross_track_error < 0.5, "{outcome:?}");
    let receiver = Receiver { std: 1.0, silent: 0.0..0.0, learns: true, seed: 4 };
    let outcome = drive("IdentifiedPlant", 0.0, &receiver);
    assert!(outcome.rms_cross_track_error < 0.5, "{outcome:?}");
    assert!(outcome.within_three > 0.95, "{outcome:?}");
}

/// From 10 to 22 m/s in 15 s, then constant, m/s.
fn faster_and_faster(time: f64) -> f64 {
    10.0 + 12.0 * (time / 15.0).min(1.0)
}

/// Bends to both sides of 4 m/s² at [`faster_and_faster`], for 15 m/s, with the guidance of a controller.
fn winding_road(pid: &Pid) -> PathFile {
    let mut road = PathComposer::new().straight(10.0);
    let (mut time, mut before) = (1.0, 0.0);
    for bend in 0..8 {
        let side = if bend % 2 == 0 { 1.0 } else { -1.0 };
        let v = faster_and_faster(time);
        let curvature = side * 4.0 / (v * v);
        road = road.clothoid(before, curvature, 1.4 * v).arc(curvature, 1.0 * v);
        (time, before) = (time + 2.4, curvature);
    }
    let mut path = road.straight(40.0).finish("winding road", 15.0).unwrap();
    path.guidance = steerwright_control::guidance_for(pid, path.speed_mps);
    path.schedule = steerwright_control::guidance_schedule(pid);
    path
}

/// Bicycle, controller and estimator of the shipped drive, packed with that road into a folder.
fn packed_for_the_winding_road(folder: &Path) -> PathFile {
    let multibody = demo().folder.join("multibody");
    let path = winding_road(&document(&multibody.join("pid.json")));
    std::fs::write(folder.join("road.json"), path.to_json()).unwrap();
    let files = ["bicycle.json", "pid.json"].map(|name| multibody.join(name));
    let [bicycle, pid] = files.each_ref().map(|file| file.display());
    let estimator = "{data}/multibody/estimator.json";
    done(folder, &format!("package {bicycle} road.json {pid} {estimator} --ssp loop.ssp"));
    path
}

/// A packed loop on that road while the speed grows.
fn along_the_winding_road(
    archives: &Path,
    plant: &str,
    path: &PathFile,
    sideslip: &[(&str, f64)],
    learns: bool,
) -> Outcome {
    let receiver = Receiver { std: 0.02, silent: 0.0..0.0, learns, seed: 5 };
    let speed = (&faster_and_faster as &dyn Fn(f64) -> f64, 19.0);
    drive_along(archives, plant, path, speed, sideslip, &receiver)
}

/// While the speed grows from 10 to 22 m/s in 15 s:
/// with the distance to the rear axle, which the package takes from bicycle.json, path and estimator use the
/// sideslip of each speed. With the S of the path's speed alone they do not keep the road as well.
#[test]
fn the_sideslip_follows_the_speed_on_the_road() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = packed_for_the_winding_road(folder);
    let along = |sideslip: &[(&str, f64)]| {
        along_the_winding_road(folder, "BicyclePlant", &path, sideslip, false)
    };
    let law = along(&[]).rms_cross_track_error;
    let constant = along(&[("distance_rear", 0.0)]).rms_cross_track_error;
    println!("10 to 22 m/s: {law:.4} m RMS with the law, {constant:.4} m with a constant S");
    assert!(law < constant / 3.0, "{law} {constant}");
}

/// On the same drive, gains, preview and feedforward over speed keep the road better than those of 15 m/s, and
/// the packed path has the table that `path` takes from the controller.
#[test]
fn a_controller_over_speed_keeps_the_road() {
    let multibody = demo().folder.join("multibody");
    let bicycle = multibody.join("bicycle.json");
    let rate = document::<Pid>(&multibody.join("pid.json")).limits.max_rate_radps;
    let rms = |options: &str| {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let bicycle = bicycle.display();
        let design = format!("design {bicycle} {options} --max-rate {rate}rad/s -o pid.json");
        // A requirement that is not met is no fault here.
        run(folder, &design);
        let pid: Pid = document(&folder.join("pid.json"));
        let path = winding_road(&pid);
        std::fs::write(folder.join("road.json"), path.to_json()).unwrap();
        let files = format!("{bicycle} road.json pid.json {{data}}/multibody/estimator.json");
        done(folder, &format!("package {files} --ssp loop.ssp"));
        (
            pid,
            along_the_winding_road(folder, "BicyclePlant", &path, &[], true).rms_cross_track_error,
        )
    };
    let (pid, over_speed) = rms("--speeds 8..24");
    let (fixed, one_speed) = rms("");
    println!(
        "10 to 22 m/s: {over_speed:.4} m RMS over speed, {one_speed:.4} m with one set of gains"
    );
    assert!(fixed.schedule.is_empty() && pid.schedule.len() >= 3);
    assert!(over_speed < one_speed, "{over_speed} {one_speed}");
}

/// A vehicle that is not the model of the design: nonlinear tyres and two tracks, by its data sheet, on a road of two thirds
/// of the friction, at up to 4 m/s². The estimator learns what its sideslip is beyond that of the bicycle, and the path
/// steers for it.
#[test]
fn a_design_on_a_bicycle_keeps_a_nonlinear_vehicle_on_a_wet_road() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = packed_for_the_winding_road(folder);
    let mut vehicle: Vehicle = document(&data().join("multibody/vehicle.json"));
    vehicle.tyres.friction_coefficient = 0.7;
    std::fs::write(folder.join("vehicle.json"), vehicle.to_json()).unwrap();
    done(folder, "package vehicle.json");

    let [learnt, stated] = [true, false]
        .map(|learns| along_the_winding_road(folder, "NonlinearVehicle", &path, &[], learns));
    println!("learnt {learnt:?}, stated {stated:?}");
    assert!(learnt.rms_cross_track_error < 0.05, "{learnt:?}");
    let [with, without] = [&learnt, &stated].map(|outcome| outcome.largest_cross_track_error);
    assert!(with < 0.75 * without, "{with} {without}");
    assert!(learnt.largest_position_error < 0.2 && learnt.within_three > 0.95, "{learnt:?}");
}
