//! `LongitudinalPlant` from a drive to the packed FMU: what is delivered is what was validated.

use crate::support::{column, done, run, text_of};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use steerwright_drivelog::{DriveLog, LogOptions, Response, Role, read_log};
use steerwright_formats::{Document, Grade, Longitudinal, Reason, ReasonCode};
use steerwright_host::{Archive, Instance};
use steerwright_sysid::longitudinal::simulate_longitudinal;

const SECONDS: f64 = 150.0;

/// A car that is driven with both pedals over hills, as a CSV file.
pub(crate) fn record(file: &Path) {
    let fine = 0.001;
    let late = |delay: f64| VecDeque::from(vec![0.0; (delay / fine) as usize]);
    let (mut drive_delay, mut brake_delay) = (late(0.14), late(0.06));
    let (mut speed, mut drive, mut brake, mut random) = (14.0_f64, 0.0, 0.0, 1_u64);
    let (mut pedals, mut wanted_pedals) = ([0.0_f64; 2], [0.0; 2]);
    let mut text = String::from("time_s,accelerator [1],brake [1],speed_mps,grade [rad]\n");
    for k in 0..(SECONDS / fine) as u32 {
        let t = fine * f64::from(k);
        let grade = 0.02 * (TAU * t / 40.0).sin();
        // A foot takes its time; a pedal that is the same for a second is read as a slow channel.
        for (pedal, wanted) in pedals.iter_mut().zip(wanted_pedals) {
            *pedal += fine * (wanted - *pedal) / 0.15;
        }
        if k.is_multiple_of(20) {
            if k.is_multiple_of(1000) {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let choice = (random >> 40) as f64 / f64::from(1 << 24);
                // Around the speed that it began with.
                let wanted = 1.6 * (choice - 0.5) + 0.12 * (14.0 - speed) + 0.13;
                wanted_pedals = [wanted.clamp(0.0, 1.0), (-0.5 * wanted).clamp(0.0, 1.0)];
            }
            let [accelerator, braking] = pedals;
            writeln!(text, "{t:.2},{accelerator:.5},{braking:.5},{speed:.5},{grade:.6}").unwrap();
        }
        drive_delay.push_back(pedals[0]);
        brake_delay.push_back(pedals[1]);
        let [accelerator, braking] =
            [&mut drive_delay, &mut brake_delay].map(|d| d.pop_front().unwrap());
        drive += fine * ((4.2 - 0.08 * speed) * accelerator - drive) / 0.3;
        brake += fine * (9.0 * braking - brake) / 0.12;
        let slowing = 0.2 + 4e-4 * speed * speed + 9.80665 * grade.sin();
        speed = (speed + fine * (drive - brake - slowing)).max(0.0);
    }
    std::fs::write(file, text).unwrap();
}

fn read(file: &Path) -> DriveLog {
    let options = LogOptions { response: Response::Speed, ..LogOptions::default() };
    read_log(&[("drive.csv".into(), std::fs::read(file).unwrap())], &options).unwrap()
}

#[test]
fn the_packed_model_has_the_speeds_of_the_validation() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    record(&at("drive.csv"));
    done(folder.path(), "identify drive.csv --structure longitudinal");
    done(folder.path(), "package longitudinal.json --out fmu");
    let checked = done(folder.path(), "check fmu/LongitudinalPlant.fmu --run --strict");
    println!("{}", text_of(&checked));

    let text = std::fs::read_to_string(at("longitudinal.json")).unwrap();
    let model = Longitudinal::from_json(&text, "longitudinal.json").unwrap();
    assert!(model.evidence.validation_fit > 90.0, "{:?}", model.evidence);
    assert!(model.gains.len() > 1 && model.grade_coefficient.is_some(), "{model:?}");
    let log = read(&at("drive.csv"));
    let expected = simulate_longitudinal(&log, &model).unwrap();
    assert_eq!(log.segments.len(), 1);
    let (brake, grade) = (&log.others[&Role::Brake], &log.others[&Role::Grade]);

    // The inputs of the log, held over a sample; the grade is that of its middle, as in the identification.
    let inputs = |k: usize| {
        let next = (k + 1).min(grade.len() - 1);
        [
            ("accelerator", log.input[k]),
            ("brake", brake[k]),
            ("grade", 0.5 * (grade[k] + grade[next])),
        ]
    };
    let archive = Archive::open(at("fmu/LongitudinalPlant.fmu")).unwrap();
    for parts in [1_u32, 4] {
        let mut fmu = Instance::new(&archive, "one").unwrap();
        fmu.setup_experiment(0.0, None, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        fmu.set("initial_speed", expected[0]).unwrap();
        inputs(0).into_iter().for_each(|(name, value)| fmu.set(name, value).unwrap());
        fmu.exit_initialization_mode().unwrap();
        let h = log.sample_time_s / f64::from(parts);
        let (mut largest, mut steps) = (0.0_f64, 0_u32);
        for (k, speed) in expected.iter().enumerate() {
            largest = largest.max((fmu.real("speed").unwrap() - speed).abs());
            inputs(k).into_iter().for_each(|(name, value)| fmu.set(name, value).unwrap());
            for _ in 0..parts {
                fmu.do_step(f64::from(steps) * h, h).unwrap();
                steps += 1;
            }
        }
        println!("{} samples in {parts} steps each: {largest:.1e} m/s", expected.len());
        assert!(largest < 1e-9, "{parts}: {largest}");
    }
    // From the program, with the inputs in a file.
    let mut drive = String::from("time,accelerator,brake,grade\n");
    for k in 0..expected.len() {
        let [accelerator, braking, grade] = inputs(k).map(|(_, value)| value);
        let time = log.sample_time_s * k as f64;
        writeln!(drive, "{time:.2},{accelerator:?},{braking:?},{grade:?}").unwrap();
    }
    std::fs::write(at("pedals.csv"), drive).unwrap();
    let step = log.sample_time_s;
    let stop = step * (expected.len() - 1) as f64;
    let line = format!(
        "simulate fmu/LongitudinalPlant.fmu --input pedals.csv --step {step}s --stop {stop:.2}s \
         --set LongitudinalPlant.initial_speed={:?} -o simulated.csv",
        expected[0]
    );
    done(folder.path(), &line);
    let simulated = column(&at("simulated.csv"), "LongitudinalPlant.speed");
    assert_eq!(simulated.len(), expected.len());
    for (k, (speed, other)) in expected.iter().zip(&simulated).enumerate() {
        assert!((speed - other).abs() < 1e-6, "{k}: {speed} {other}");
    }
}

#[test]
fn a_model_that_failed_validation_needs_consent() {
    let folder = tempfile::tempdir().unwrap();
    let example = steerwright_packaging::Fmu::LongitudinalPlant.example();
    let mut model = Longitudinal::from_json(example, "it").unwrap();
    model.quality.grade = Grade::Fail;
    model.quality.reasons.push(Reason::new(
        ReasonCode::LowValidationFit,
        Grade::Fail,
        "it does not fit",
    ));
    std::fs::write(folder.path().join("longitudinal.json"), model.to_json()).unwrap();
    let refused = run(folder.path(), "package longitudinal.json");
    assert_eq!(refused.status.code(), Some(1), "{}", text_of(&refused));
    done(folder.path(), "package longitudinal.json --accept-untrusted");
}
