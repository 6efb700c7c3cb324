//! `export`: drives of vehicles with known delay, lag, wheelbase and steering ratio are identified and exported;
//! the file that is written is read back, and the stack's own formula is run on it.

use crate::support::{read_json, run, steerwright, text_of};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const DT: f64 = 0.01;
const DELAY: f64 = 0.12;
const LAG: f64 = 0.2;
const OFFSET: f64 = 0.004;

/// Uniform and normal numbers from a linear congruential generator.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// A command that moves to a new goal every half second.
    fn command(&mut self, k: usize, goal: &mut f64, last: f64, largest: f64) -> f64 {
        if k.is_multiple_of(50) {
            *goal = largest * (2.0 * self.uniform() - 1.0);
        }
        last + 0.1 * (*goal - last)
    }
}

/// A drive of the model that Autoware simulates, at 8 m/s: wheelbase 2.9 m.
fn kinematic(seed: u64) -> String {
    let mut random = Random(seed);
    let (mut goal, mut command, mut wheel) = (0.0, 0.0, 0.0_f64);
    let mut queue = std::collections::VecDeque::from(vec![0.0; (DELAY / DT).round() as usize]);
    let mut log = String::from("time_s,steering_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..24_000 {
        command = random.command(k, &mut goal, command, 0.06);
        queue.push_back(command);
        let delayed = queue.pop_front().unwrap();
        let yaw_rate = 8.0 * wheel.tan() / 2.9 + 0.002 * random.normal();
        writeln!(log, "{:.2},{:.7},{yaw_rate:.7},8.0", k as f64 * DT, command + OFFSET).unwrap();
        wheel += (delayed - wheel) * (1.0 - (-DT / LAG).exp());
    }
    log
}

fn done(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    assert!(output.status.success(), "{line}: {}", text_of(&output));
    text_of(&output)
}

/// Values and standard errors of a file in the form of a stack.
fn parameters(text: &str) -> BTreeMap<String, (f64, Option<f64>)> {
    let error = |comment: &str| {
        let rest = comment.split_once(", standard error ")?.1;
        rest.split(':').next()?.parse().ok()
    };
    let mut found = BTreeMap::new();
    let mut comment = String::new();
    for line in text.lines() {
        let (content, after) = line.split_once('#').unwrap_or((line, ""));
        let mut words = content.split(['=', ':', ',', '\t', ' ']).filter(|w| !w.is_empty());
        let mut words: Vec<&str> = words.by_ref().collect();
        if words.starts_with(&["1", "1"]) {
            words = words[2..4].to_vec();
        }
        if let [key, value] = words[..]
            && let Ok(value) = value.parse()
        {
            let comment = if after.is_empty() { &comment } else { after };
            found.insert(key.to_owned(), (value, error(comment)));
        }
        comment = after.to_owned();
    }
    found
}

/// Runs `export` and reads what it wrote.
fn exported(folder: &Path, line: &str) -> BTreeMap<String, (f64, Option<f64>)> {
    done(folder, &format!("export {line} -o exported.txt"));
    parameters(&std::fs::read_to_string(folder.join("exported.txt")).unwrap())
}

fn assert_within(found: (f64, Option<f64>), truth: f64, errors: f64, most: f64) {
    let (value, error) = found;
    let error = error.expect("a standard error");
    assert!((value - truth).abs() < errors * error, "{value} ± {error}, truth {truth}");
    assert!(error < most, "{error}");
}

#[test]
fn a_plant_returns_the_delay_lag_and_wheelbase_of_the_simulated_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("drive.csv"), kinematic(1)).unwrap();
    done(folder, "identify drive.csv --steering-ratio 1 --intersample zoh -o plant.json");

    let found = exported(folder, "plant.json --for autoware --max-angle 0.5rad --wheelbase 2.9");
    let delay = found["steer_time_delay"];
    assert_within(delay, DELAY, 3.0, 0.02);
    let lag = found["steer_time_constant"];
    assert_within(lag, LAG, 3.0, 0.02);
    assert_eq!((delay, lag), (found["input_delay"], found["vehicle_model_steer_tau"]));
    assert!((found["steer_bias"].0 - OFFSET).abs() < 2e-4, "{found:?}");
    assert_eq!((found["steer_lim"].0, found["wheel_base"].0), (0.5, 2.9));
    // Autoware's simulator with the file's numbers, after a step: as the vehicle within 1 % of the steady state.
    let simulated = |delay: f64, lag: f64, at: f64| 1.0 - (-(at - delay).max(0.0) / lag).exp();
    for at in [0.2, 0.4, 0.8, 1.6] {
        let (got, truth) = (simulated(delay.0, lag.0, at), simulated(DELAY, LAG, at));
        assert!((got - truth).abs() < 0.01, "{at}: {got} {truth}");
    }

    // openpilot: its lateral delay is steerActuatorDelay + 0.2 s.
    let found = exported(folder, "plant.json --for openpilot --force");
    let total = found["steerActuatorDelay"];
    assert_within((total.0 + 0.2, total.1), DELAY + LAG, 3.0, 0.02);
    assert!(!found.contains_key("steerRatio"));

    // ArduPilot: output = FF · yaw rate · base / v, which moves the road wheel to the angle of that yaw rate.
    let found = exported(folder, "plant.json --for ardupilot --max-angle 30deg --force");
    let (yaw_rate, speed) = (0.1, 8.0);
    let scale = yaw_rate * found["MOT_SPD_SCA_BASE"].0 / speed * 30_f64.to_radians();
    let (gain, error) = found["ATC_STR_RAT_FF"];
    // tan δ is 0.02 % more than δ on average over the drive.
    assert_within((gain * scale, error.map(|e| e * scale + 1e-6)), 0.1 * 2.9 / 8.0, 3.0, 1e-3);

    // PX4: angle = atan(correction · yaw rate · wheelbase / v), with a wheelbase stated too short.
    let found = exported(
        folder,
        "plant.json --for px4 --wheelbase 2.5 --max-angle 0.5rad --max-rate 30deg/s --force",
    );
    let (correction, error) = found["RO_YAW_RATE_CORR"];
    assert_within((correction, error.map(|e| e + 1e-4)), 2.9 / 2.5, 3.0, 0.01);
    assert_eq!(found["RA_WHEEL_BASE"].0, 2.5);
    assert!((found["RA_STR_RATE_LIM"].0 - 30.0).abs() < 1e-3, "{found:?}");
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn bands_of_forty_drives_contain_the_delay_and_the_lag() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut inside = [0; 2];
    for seed in 100..140 {
        std::fs::write(folder.join("drive.csv"), kinematic(seed)).unwrap();
        let identify = "identify drive.csv --structure state-space --steering-ratio 1 --intersample zoh --force";
        done(folder, identify);
        let found = exported(folder, "plant.json --for autoware --force");
        let keys = [("steer_time_delay", DELAY), ("steer_time_constant", LAG)];
        for (inside, (key, truth)) in inside.iter_mut().zip(keys) {
            let (value, error) = found[key];
            *inside += u32::from((value - truth).abs() < 1.96 * error.unwrap());
        }
    }
    assert!(inside.iter().all(|n| *n >= 34), "of 40: {inside:?}");
}

/// Mass, inertia, distances, stiffnesses and steering ratio of the dynamic car.
const CAR: [f64; 7] = [1500.0, 2600.0, 1.2, 1.5, 80e3, 95e3, 16.0];

/// A drive of eq 13 with varying speed, and a steering lag of 0.1 s.
fn dynamic(seed: u64) -> String {
    let [m, j, a, b, cf, cr, ratio] = CAR;
    let mut random = Random(seed);
    let (mut goal, mut command, mut wheel, mut y, mut r) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut log = String::from("time_s,steering_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..30_000 {
        let time = k as f64 * DT;
        let v = 14.0 + 9.0 * (time / 17.0).sin();
        command = random.command(k, &mut goal, command, 0.35 / (1.0 + (v / 12.0).powi(2)));
        let yaw_rate = r + 0.001 * random.normal();
        writeln!(log, "{time:.2},{command:.7},{yaw_rate:.7},{v:.4}").unwrap();
        let steps = 20;
        for _ in 0..steps {
            let h = DT / f64::from(steps);
            wheel += h * (command / ratio - wheel) / 0.1;
            let (front, rear) = (cf * (wheel - (y + a * r) / v), -cr * (y - b * r) / v);
            y += h * ((front + rear) / m - v * r);
            r += h * (a * front - b * rear) / j;
        }
    }
    log
}

#[test]
fn a_bicycle_returns_the_steady_turns_of_the_simulated_car_in_openpilots_formula() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("drive.csv"), dynamic(3)).unwrap();
    done(
        folder,
        "identify drive.csv --structure bicycle --steering-ratio 16 --mass 1500 --wheelbase 2.7 --front-share 55.556% --intersample zoh -o bicycle.json",
    );
    let found = exported(folder, "bicycle.json --for openpilot");
    assert_within(found["steerRatio"], 16.0, 3.0, 0.3);
    let at = |key: &str| found[key].0;
    assert!((at("wheelbase") - 2.7).abs() < 1e-9 && at("mass") == 1500.0, "{found:?}");
    let [m, _, a, b, cf, cr, ratio] = CAR;
    for v in [6.0_f64, 14.0, 22.0] {
        let gain = |m: f64, a: f64, b: f64, cf: f64, cr: f64, ratio: f64| {
            let l = a + b;
            let slip = m * (cf * a - cr * b) / (l * l * cf * cr);
            v / (ratio * l * (1.0 - slip * v * v))
        };
        let truth = gain(m, a, b, cf, cr, ratio);
        let [front, length] = [at("centerToFront"), at("wheelbase")];
        let [cf, cr] = [at("tireStiffnessFront"), at("tireStiffnessRear")];
        let got = gain(at("mass"), front, length - front, cf, cr, at("steerRatio"));
        assert!((got / truth - 1.0).abs() < 0.01, "{v}: {got} {truth}");
    }
    // The effective wheelbase of PX4 contains the understeer at the speed of the file.
    let found = exported(folder, "bicycle.json --for px4 --force");
    let v = read_json(&folder.join("bicycle.json"))["vehicle"]["speed_mps"].as_f64().unwrap();
    let gradient = m / 2.7 * (b / cf - a / cr);
    assert_within(found["RO_YAW_RATE_CORR"], 1.0 + gradient * v * v / 2.7, 3.0, 0.02);
}

#[test]
fn what_one_speed_does_not_determine_is_left_out_and_failed_models_are_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("drive.csv"), kinematic(2)).unwrap();
    done(folder, "identify drive.csv --steering-ratio 1 --structure bicycle -o bicycle.json");
    let text = done(folder, "export bicycle.json --for px4");
    assert!(text.contains("RA_WHEEL_BASE is left out: one speed does not determine it"), "{text}");
    for (line, problem) in [
        ("export bicycle.json --for ros", "expected autoware, openpilot"),
        ("export bicycle.json --for px4 --max-angle 100deg", "less than π/2"),
        ("export bicycle.json --for px4 --wheelbase -1", "wheelbase is -1"),
        ("export bicycle.json --for px4 -o bicycle.json --force", "input"),
    ] {
        let output = run(folder, line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{line}: {text}");
    }
    let mut failed = read_json(&folder.join("bicycle.json"));
    failed["quality"]["grade"] = "fail".into();
    failed["quality"]["reasons"][0]["grade"] = "fail".into();
    std::fs::write(folder.join("failed.json"), failed.to_string()).unwrap();
    let output = run(folder, "export failed.json --for px4");
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let text = done(folder, "export failed.json --for px4 --accept-untrusted");
    assert!(text.contains("# quality of the model: fail"), "{text}");
}

/// A drive steered by torque, with yaw rate and speed in place of the lateral acceleration: 2.5 m/s² per command,
/// friction 0.12, offset 0.05 m/s², delay 0.27 s.
fn torque_drive(unit: &str) -> String {
    let mut random = Random(5);
    let (mut goal, mut command, mut angle, mut last_rate) = (0.0, 0.0, 0.0, 0.0);
    let mut queue = std::collections::VecDeque::from(vec![0.0; 27]);
    let mut log =
        format!("time_s,steering_torque [{unit}],yaw_rate_degps,speed_kmh,steering_angle_deg\n");
    for k in 0..60_000 {
        command = random.command(k, &mut goal, command, 0.4);
        queue.push_back(command);
        let delayed = queue.pop_front().unwrap();
        let rate: f64 = (0.3 * delayed - angle) / 0.15;
        let friction = 0.12 * (f64::midpoint(rate, last_rate) / 0.05).tanh();
        let acceleration = 2.5 * (delayed - friction) + 0.05 + 0.05 * random.normal();
        let (yaw_rate, degrees) = ((acceleration / 20.0).to_degrees(), angle.to_degrees());
        let time = k as f64 * DT;
        writeln!(log, "{time:.2},{command:.6},{yaw_rate:.6},72,{degrees:.6}").unwrap();
        angle += DT * rate;
        last_rate = rate;
    }
    log
}

#[test]
fn a_torque_returns_the_steady_turns_of_the_simulated_car_in_openpilots_formula() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("drive.csv"), torque_drive("1")).unwrap();
    let identify = |log: &str, out: &str| {
        let acceleration = ["--output-channel", "yaw_rate_degps * speed_kmh"];
        let output = steerwright(
            folder,
            &[&["identify", log, "--structure", "torque", "-o", out][..], &acceleration].concat(),
        );
        assert!(output.status.success(), "{}", text_of(&output));
    };
    identify("drive.csv", "torque.json");
    let found = exported(folder, "torque.json --for openpilot");
    for (key, truth) in [("latAccelFactor", 2.5), ("friction", 0.12), ("latAccelOffset", 0.05)] {
        assert_within(found[key], truth, 3.0, 0.02 * truth.max(0.2));
    }
    let delay = found["steerActuatorDelay"];
    // Friction and filter do not commute: 0.6 ms.
    assert!((delay.0 + 0.2 - 0.27).abs() < 1e-3 && delay.1.unwrap() < 1e-3, "{delay:?}");
    // The command of openpilot's controller for a steady turn turns the simulated car as desired.
    for desired in [-1.0, 0.5, 1.5] {
        let command = (desired - found["latAccelOffset"].0) / found["latAccelFactor"].0;
        assert!((2.5 * command + 0.05 - desired).abs() < 0.01, "{desired} {command}");
    }

    std::fs::write(folder.join("newton.csv"), torque_drive("Nm")).unwrap();
    identify("newton.csv", "newton.json");
    for (line, problem) in [
        ("export torque.json --for px4", "px4 does not steer by torque"),
        ("export torque.json --for openpilot --wheelbase 2.7", "no parameter of a car"),
        ("export newton.json --for openpilot", "is in Nm"),
        ("design torque.json", "a model of the steering torque has no steering angle"),
        ("identify drive.csv --structure torque --order 2", "of the structure state-space"),
        (
            "identify drive.csv --structure state-space --min-speed 5m/s",
            "bicycle or single-track or torque",
        ),
        ("identify drive.csv --structure torque --channel bank=roll", "engaged, override"),
    ] {
        let output = run(folder, line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{line}: {text}");
    }
}
