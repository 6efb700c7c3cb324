//! `SpeedController` from a drive to the packed FMU, in the loop with `LongitudinalPlant` and with vehicles that are
//! written apart: what is delivered is what was validated.

use crate::car::{Car, Motion, Random};
use crate::longitudinal_plant::record;
use crate::support::{done, run, text_of};
use std::path::Path;
use steerwright_control::{SpeedDesignOptions, design_speed, speed_step};
use steerwright_drivelog::{LogOptions, Response, read_log};
use steerwright_formats::{
    Document, Grade, Longitudinal, ReasonCode, SourceFile, SpeedController, SpeedStep,
};
use steerwright_host::{Archive, Instance};
use steerwright_packaging::Fmu;
use steerwright_sysid::longitudinal::{LongitudinalOptions, identify_longitudinal};

fn controller_in(file: &Path) -> SpeedController {
    SpeedController::from_json(&std::fs::read_to_string(file).unwrap(), "it").unwrap()
}

/// Two FMUs, coupled as Gauss and Seidel do.
struct Loop {
    plant: Instance,
    control: Instance,
    step: f64,
    steps: u32,
}

impl Loop {
    fn new(plant: &Archive, control: &Archive, speed: f64, reference: f64, step: f64) -> Self {
        let mut plant = Instance::new(plant, "plant").unwrap();
        let mut control = Instance::new(control, "control").unwrap();
        for fmu in [&mut plant, &mut control] {
            fmu.setup_experiment(0.0, None, None).unwrap();
            fmu.enter_initialization_mode().unwrap();
        }
        plant.set("initial_speed", speed).unwrap();
        control.set("speed", speed).unwrap();
        control.set("speed_reference", reference).unwrap();
        for fmu in [&mut plant, &mut control] {
            fmu.exit_initialization_mode().unwrap();
        }
        Self { plant, control, step, steps: 0 }
    }

    fn output(&mut self, name: &str) -> f64 {
        self.control.real(name).unwrap()
    }

    /// The speeds at the ticks, from now to the end.
    fn run(&mut self, seconds: f64, reference: f64, grade: f64) -> Vec<f64> {
        let mut speeds = vec![self.plant.real("speed").unwrap()];
        // The output of this tick was computed with the reference before.
        for _ in 0..(seconds / self.step).round() as u32 {
            for name in ["accelerator", "brake", "acceleration_command"] {
                let value = self.output(name);
                self.plant.set(name, value).unwrap();
            }
            self.plant.set("grade", grade).unwrap();
            let time = f64::from(self.steps) * self.step;
            self.plant.do_step(time, self.step).unwrap();
            let speed = self.plant.real("speed").unwrap();
            self.control.set("speed", speed).unwrap();
            self.control.set("speed_reference", reference).unwrap();
            self.control.do_step(time, self.step).unwrap();
            self.steps += 1;
            speeds.push(speed);
        }
        speeds
    }
}

#[test]
fn the_packed_loop_has_the_stated_responses() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    record(&at("drive.csv"));
    done(folder.path(), "identify drive.csv --structure longitudinal");
    let designed = run(folder.path(), "design longitudinal.json --plots plots");
    println!("{}", text_of(&designed));
    let plot = std::fs::read_to_string(at("plots/speed-steps.svg")).unwrap();
    for part in ["Step up (m/s)", "On the grade (m/s)", "to settle by"] {
        assert!(plot.contains(part), "{part}");
    }
    done(folder.path(), "package longitudinal.json speed_controller.json --out fmu");
    for fmu in ["LongitudinalPlant", "SpeedController"] {
        let checked = done(folder.path(), &format!("check fmu/{fmu}.fmu --run --strict"));
        println!("{}", text_of(&checked));
    }
    let file = controller_in(&at("speed_controller.json"));
    assert!(file.evidence.met && file.quality.grade < Grade::Fail, "{:?}", file.quality);
    let ensemble = file.evidence.ensemble.unwrap();
    assert!(ensemble.keeping * 20 >= ensemble.vehicles * 19, "{ensemble:?}");

    let [plant, control] = ["LongitudinalPlant", "SpeedController"]
        .map(|fmu| Archive::open(at(&format!("fmu/{fmu}.fmu"))).unwrap());
    let s = &file.specification;
    let rows = &file.evidence.speeds;
    assert_eq!(file.evidence.fmu_loop.len(), rows.len());
    for (of_model, of_fmus) in rows.iter().zip(&file.evidence.fmu_loop) {
        for (stated, found) in [(of_model.up, of_fmus.up), (of_model.down, of_fmus.down)] {
            let later = found.settling_time_s.unwrap() - stated.settling_time_s.unwrap();
            let overshoot = found.overshoot_percent - stated.overshoot_percent;
            assert!(later.abs() < 1e-3 && overshoot.abs() < 0.01, "{stated:?} {found:?}");
        }
        let on_grade = of_fmus.largest_loss_on_grade_mps - of_model.largest_loss_on_grade_mps;
        assert!(on_grade.abs() < 1e-3, "{of_model:?} {of_fmus:?}");
    }
    // At the speeds of the design, and between them.
    let mut speeds: Vec<(f64, bool)> = rows.iter().map(|row| (row.speed_mps, true)).collect();
    speeds.extend(rows.windows(2).map(|w| (0.5 * (w[0].speed_mps + w[1].speed_mps), false)));
    for (speed, is_designed) in speeds {
        let mut fmus = Loop::new(&plant, &control, speed, speed, file.sample_time_s);
        let seconds = s.steady_state_time_s;
        fmus.run(seconds, speed, 0.0);
        let up = fmus.run(seconds, speed + s.step_mps, 0.0);
        let down = fmus.run(seconds, speed, 0.0);
        let on_grade = fmus.run(seconds, speed, (0.01 * s.grade_percent).atan());
        let metrics = |speeds: &[f64], before: f64, height: f64| {
            speed_step(speeds, before, height, file.sample_time_s, s)
        };
        let up = metrics(&up, speed, s.step_mps);
        let down = metrics(&down, speed + s.step_mps, -s.step_mps);
        let error = 100.0 * (on_grade.last().unwrap() - speed).abs() / s.step_mps;
        println!("{speed:5.2} m/s: {up:?} {down:?} {error:.3} % on the grade");
        for step in [up, down] {
            assert!(step.overshoot_percent <= s.overshoot_percent.unwrap() + 0.2, "{step:?}");
            assert!(step.settling_time_s.unwrap() <= s.settling_time_s.unwrap() + 0.1, "{step:?}");
        }
        assert!(error <= s.steady_state_error_percent.unwrap() + 0.1, "{error}");
        if is_designed {
            let row = rows.iter().find(|row| row.speed_mps == speed).unwrap();
            // The reference of the loop is later by a tick.
            let late = file.sample_time_s;
            for (step, stated) in [(up, row.up), (down, row.down)] {
                let is_as_stated = |step: &SpeedStep, stated: &SpeedStep| {
                    let off = step.overshoot_percent - stated.overshoot_percent;
                    let later =
                        step.settling_time_s.unwrap() - stated.settling_time_s.unwrap() - late;
                    off.abs() < 0.01 && later.abs() < 1e-3
                };
                assert!(is_as_stated(&step, &stated), "{step:?} {stated:?}");
            }
            assert!((error - row.error_on_grade_percent).abs() < 0.01, "{error} {row:?}");
        }
    }

    // From standstill to standstill.
    let mut fmus = Loop::new(&plant, &control, 0.0, 0.0, file.sample_time_s);
    let held = fmus.run(2.0, 0.0, 0.05);
    assert!(held.iter().all(|speed| *speed == 0.0) && fmus.output("brake") > 0.1);
    fmus.run(20.0, 8.0, 0.0);
    assert!((fmus.plant.real("speed").unwrap() - 8.0).abs() < 0.05);
    let stops = fmus.run(20.0, 0.0, 0.0);
    assert_eq!(*stops.last().unwrap(), 0.0);
    assert!(fmus.output("brake") > 0.1 && fmus.output("accelerator") == 0.0);
    // Neither limit is exceeded by more than what the lag of the brake makes of a jerk.
    let fastest = stops.windows(2).map(|w| (w[0] - w[1]) / file.sample_time_s).fold(0.0, f64::max);
    println!("stops with up to {fastest:.2} m/s²");
    assert!(fastest < file.limits.max_deceleration_mps2 + 0.3, "{fastest}");
}

/// A controller of the example's model, with other numbers.
fn example(change: impl FnOnce(&mut Longitudinal)) -> Longitudinal {
    let mut model = Longitudinal::from_json(Fmu::LongitudinalPlant.example(), "it").unwrap();
    change(&mut model);
    model
}

#[test]
fn a_weak_drive_is_reported_with_what_limits_and_what_would_do() {
    let folder = tempfile::tempdir().unwrap();
    let weak = example(|model| {
        for row in &mut model.gains {
            row.gain.value *= 0.5;
        }
    });
    std::fs::write(folder.path().join("longitudinal.json"), weak.to_json()).unwrap();
    let designed = run(folder.path(), "design longitudinal.json");
    let text = text_of(&designed);
    println!("{text}");
    assert_eq!(designed.status.code(), Some(1), "{text}");
    assert!(text.contains("the drive limits the grade"), "{text}");
    assert!(text.contains("missed-requirement"), "{text}");
    let file = controller_in(&folder.path().join("speed_controller.json"));
    assert!(!file.evidence.met && file.quality.has(ReasonCode::MissedRequirement));
    let refused = run(folder.path(), "package speed_controller.json");
    assert_eq!(refused.status.code(), Some(1), "{}", text_of(&refused));
    done(folder.path(), "package speed_controller.json --accept-untrusted");
    // What would do: the grade that it states.
    let possible = text.split("up to a grade of ").nth(1).unwrap().split(" %").next().unwrap();
    let line = format!(
        "design longitudinal.json --grade {possible}% --settling none --overshoot none -o flat.json"
    );
    println!("{}", text_of(&run(folder.path(), &line)));
    let flat = controller_in(&folder.path().join("flat.json"));
    let on_grade = flat.evidence.speeds.iter().map(|row| row.error_on_grade_percent);
    assert!(on_grade.fold(0.0, f64::max) < 4.0, "{:?}", flat.evidence);
}

#[test]
fn options_of_the_other_controller_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let model = example(|_| {});
    std::fs::write(folder.path().join("longitudinal.json"), model.to_json()).unwrap();
    std::fs::write(folder.path().join("bicycle.json"), Fmu::BicyclePlant.example()).unwrap();
    for (line, what) in [
        ("design longitudinal.json --max-angle 20deg", "--max-angle is an option of a steering"),
        ("design longitudinal.json --latency 20ms", "--latency is an option of a steering"),
        ("design longitudinal.json --speeds 5..6", "lowest speed is 5 m/s"),
        ("design bicycle.json --grade 4%", "--grade is an option of a speed controller"),
        ("design longitudinal.json --steady-state-error 500%", "below 100 %"),
        ("design longitudinal.json --overshoot 101%", "at most 100 %"),
    ] {
        let refused = run(folder.path(), line);
        let text = text_of(&refused);
        assert!(!refused.status.success() && text.contains(what), "{line}: {text}");
    }
}

#[test]
fn a_design_beyond_the_speeds_of_the_drive_is_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let model = example(|_| {});
    let [low, _, high] = model.evidence.speed_mps;
    std::fs::write(folder.path().join("longitudinal.json"), model.to_json()).unwrap();
    for (range, is_doubted) in
        [(format!("{low}..{high}"), false), (format!("{low}..{}", 1.3 * high), true)]
    {
        let line = format!("design longitudinal.json --speeds {range} --settling none --force");
        let text = text_of(&run(folder.path(), &line));
        let file = controller_in(&folder.path().join("speed_controller.json"));
        let is_named = file
            .quality
            .reasons
            .iter()
            .any(|reason| reason.message.contains("gain is held constant"));
        assert_eq!(is_named, is_doubted, "{text}");
    }
}

/// A vehicle on a hill that rolls back, with a brake that only resists.
struct OnAHill {
    speed: f64,
    drive: f64,
    brake: f64,
}

impl OnAHill {
    fn advance(&mut self, h: f64, accelerator: f64, brake: f64, grade: f64) {
        self.drive += h * (4.6 * accelerator - self.drive) / 0.35;
        self.brake += h * (9.0 * brake - self.brake) / 0.12;
        let resisting = 0.18 + self.brake;
        let pushing = self.drive - 9.80665 * grade.sin();
        let next = self.speed + h * (pushing - resisting * self.speed.signum());
        let stands = self.speed.abs() < 1e-9 || next * self.speed < 0.0;
        self.speed = if !stands {
            next
        } else if pushing.abs() <= resisting {
            0.0
        } else {
            h * (pushing - resisting * pushing.signum())
        };
    }
}

#[test]
fn a_start_on_a_hill_does_not_roll_back() {
    let text = Fmu::SpeedController.example();
    let packed = steerwright_comparison::pack(text, "it", None).unwrap();
    let archive = Archive::from_bytes(&packed.bytes, "it").unwrap();
    for percent in [0.0, 6.0, 12.0, 20.0] {
        let grade = (0.01_f64 * percent).atan();
        let mut fmu = Instance::new(&archive, "one").unwrap();
        fmu.setup_experiment(0.0, None, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        fmu.set("grade", grade).unwrap();
        fmu.exit_initialization_mode().unwrap();
        let mut car = OnAHill { speed: 0.0, drive: 0.0, brake: 0.0 };
        let (mut lowest, mut furthest_back, mut distance) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 0..2000_u32 {
            let t = 0.01 * f64::from(k);
            // The brake holds from its first second on.
            let reference = if t < 3.0 { 0.0 } else { 6.0 };
            let (accelerator, brake) =
                (fmu.real("accelerator").unwrap(), fmu.real("brake").unwrap());
            for _ in 0..10 {
                car.advance(1e-3, accelerator, brake, grade);
                if t > 1.0 {
                    lowest = lowest.min(car.speed);
                    distance += 1e-3 * car.speed;
                    furthest_back = furthest_back.min(distance);
                }
            }
            fmu.set("speed", car.speed.max(0.0)).unwrap();
            fmu.set("speed_reference", reference).unwrap();
            fmu.do_step(t, 0.01).unwrap();
        }
        println!(
            "{percent} %: {:.3} m/s at the end, back by {furthest_back:.1e} m, at {lowest:.1e} m/s",
            car.speed
        );
        assert!((car.speed - 6.0).abs() < 0.1, "{}", car.speed);
        assert!(furthest_back > -0.01, "{furthest_back}");
    }
}

#[test]
fn noise_does_not_alternate_the_pedals() {
    let model = example(|_| {});
    let source = SourceFile::named("it", b"it");
    let options = SpeedDesignOptions { members: 0, ..SpeedDesignOptions::default() };
    let file = design_speed(&model, &source, &options).unwrap();
    let packed = steerwright_comparison::pack(&file.to_json(), "it", None).unwrap();
    let plant = steerwright_comparison::pack(&model.to_json(), "it", None).unwrap();
    let [plant, control] =
        [plant, packed].map(|packed| Archive::from_bytes(&packed.bytes, "it").unwrap());
    let mut random = Random::new(1);
    let mut fmus = Loop::new(&plant, &control, 15.0, 15.0, file.sample_time_s);
    // Down a hill on which the vehicle nearly keeps its speed without a pedal.
    let grade = -(0.2_f64 / 9.8).asin();
    let (mut changes, mut before) = (0, 0.0);
    for k in 0..6000 {
        fmus.run(file.sample_time_s, 15.0, grade);
        let noisy = fmus.plant.real("speed").unwrap() + model.noise.speed_mps * random.normal();
        fmus.control.set("speed", noisy.max(0.0)).unwrap();
        let pedal = fmus.output("accelerator") - fmus.output("brake");
        if pedal != 0.0 && before != 0.0 && (pedal > 0.0) != (before > 0.0) && k > 500 {
            changes += 1;
        }
        if pedal != 0.0 {
            before = pedal;
        }
    }
    println!("{changes} changes of the pedal in 55 s");
    assert!(changes <= 6, "{changes}");
}

/// The step responses of a controller on a car that is written apart, at speeds of the range of its design.
fn on_the_car(car: &Car, file: &SpeedController, archive: &Archive) -> Vec<SpeedStep> {
    let s = &file.specification;
    let [low, high] = s.speeds_mps;
    let has_gears = !file.model.gear_gains.is_empty();
    let mut steps = Vec::new();
    for share in [0.2, 0.5, 0.8] {
        let speed = low + share * (high - s.step_mps - low);
        let mut fmu = Instance::new(archive, "one").unwrap();
        fmu.setup_experiment(0.0, None, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        fmu.set("speed", speed).unwrap();
        fmu.set("speed_reference", speed).unwrap();
        fmu.exit_initialization_mode().unwrap();
        let mut motion = Motion::new(car, speed);
        let mut tick = 0_u32;
        let mut drive = |seconds: f64, reference: f64| {
            let mut speeds = vec![motion.speed];
            for _ in 0..(seconds / file.sample_time_s).round() as u32 {
                let accelerator = match car.is_commanded {
                    true => fmu.real("acceleration_command").unwrap(),
                    false => fmu.real("accelerator").unwrap(),
                };
                let brake = fmu.real("brake").unwrap();
                for _ in 0..(file.sample_time_s / 0.001).round() as u32 {
                    motion.advance(car, accelerator, brake, 0.0, 0.0);
                }
                fmu.set("speed", motion.speed).unwrap();
                fmu.set("speed_reference", reference).unwrap();
                if has_gears {
                    fmu.set("gear", motion.gear as i32 + 1).unwrap();
                }
                fmu.do_step(f64::from(tick) * file.sample_time_s, file.sample_time_s).unwrap();
                tick += 1;
                speeds.push(motion.speed);
            }
            speeds
        };
        drive(30.0, speed);
        let up = drive(s.steady_state_time_s, speed + s.step_mps);
        steps.push(speed_step(&up, speed, s.step_mps, file.sample_time_s, s));
    }
    steps
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn designs_that_pass_keep_their_figures_on_vehicles_written_apart() {
    let (mut passed, mut kept, mut robust, mut robust_kept) = (0, 0, 0, 0);
    for seed in 0..24 {
        let car = Car::usual(seed);
        let options = LogOptions { response: Response::Speed, ..LogOptions::default() };
        let files = [("drive.csv".into(), car.drive(seed, 400.0).into_bytes())];
        let log = read_log(&files, &options).unwrap();
        let model = identify_longitudinal(&log, &LongitudinalOptions::default()).unwrap();
        let source = SourceFile::named("it", b"it");
        let file = design_speed(&model, &source, &SpeedDesignOptions::default()).unwrap();
        let packed = steerwright_comparison::pack(&file.to_json(), "it", None).unwrap();
        let archive = Archive::from_bytes(&packed.bytes, "it").unwrap();
        let steps = on_the_car(&car, &file, &archive);
        let overshoot = steps.iter().map(|step| step.overshoot_percent).fold(0.0, f64::max);
        let settling =
            steps.iter().map(|step| step.settling_time_s.unwrap_or(99.0)).fold(0.0, f64::max);
        let is_kept = overshoot <= 6.0 && settling <= 4.2;
        println!(
            "{seed:2} {} {:28} met {:5} keeping {:3} kp {:.3}: overshoot {overshoot:5.2} %, settling {settling:5.2} s {}",
            file.quality.grade,
            file.quality.codes(),
            file.evidence.met,
            file.evidence.ensemble.map_or(0, |e| e.keeping),
            file.gains.kp_per_s,
            if is_kept { "kept" } else { "missed" }
        );
        if !file.quality.has(ReasonCode::NotRobust) {
            robust += 1;
            robust_kept += usize::from(is_kept);
        }
        if file.quality.grade == Grade::Pass {
            passed += 1;
            kept += usize::from(is_kept);
        }
    }
    println!(
        "{kept} of {passed} designs with `pass` keep overshoot and settling time on the vehicle"
    );
    println!("{robust_kept} of {robust} without `not-robust` do");
    assert!(robust >= 12 && robust_kept * 10 >= robust * 9, "{robust_kept} of {robust}");
    assert!(passed >= 8 && kept * 10 >= passed * 9, "{kept} of {passed}");
}
