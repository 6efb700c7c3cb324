//! Every structure from one log to every command: a document of its name, and a result or a reason.

use crate::support::{run, text_of};
use std::collections::VecDeque;
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Model, Structure};

/// A car with the channels of every structure, 400 s at 10 Hz between 15 and 25 m/s: a steering command leads the lateral
/// acceleration by 0.2 s, an acceleration command that of the speed by a lag of 0.3 s.
fn write_drive(file: &Path) {
    const STEP: f64 = 0.02;
    let mut state = 5_u64;
    // Uniform from -1 to 1: Knuth's MMIX.
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (mut goal, mut turn, mut command, mut reference) = (20.0, 0.0, 0.0_f64, 20.0_f64);
    let (mut speed, mut drive, mut pedal, mut rate) = (20.0_f64, 0.0, 0.0_f64, 0.0);
    let mut delayed = VecDeque::from(vec![0.0; 10]);
    let mut log = String::from(
        "time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps,lateral_acceleration_mps2,steering_torque [1],acceleration_command_mps2\n",
    );
    for k in 0..20_000_u32 {
        if k % 200 == 0 {
            goal = 20.0 + 5.0 * random();
        }
        if k % 50 == 0 {
            turn = 0.8 * random();
        }
        command += (turn - command).clamp(-0.04, 0.04);
        delayed.push_back(command);
        let late: f64 = delayed.pop_front().unwrap();
        let angle = 2.5 * late * 2.7 * (1.0 / (speed * speed) + 0.002);
        if k % 5 == 0 {
            reference += (goal - reference).clamp(-0.3, 0.2);
            pedal = (reference - speed + 0.2 * random()).clamp(-3.0, 2.0);
            let (yaw, lateral) = (rate + 0.002 * random(), speed * rate + 0.05 * random());
            let (time, shown) = (f64::from(k) * STEP, speed + 0.02 * random());
            let _ = writeln!(
                log,
                "{time:.2},{angle:.6},{yaw:.5},{shown:.3},{lateral:.4},{command:.5},{pedal:.4}"
            );
        }
        let settled = speed * angle / (2.7 * (1.0 + 0.002 * speed * speed));
        rate += STEP * (settled - rate) / 0.12;
        drive += STEP * (pedal - drive) / 0.3;
        speed += STEP * (drive - 0.1);
    }
    std::fs::write(file, log).unwrap();
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn every_structure_is_identified_and_other_commands_take_it_or_report_why_not() {
    let folder = tempfile::tempdir().unwrap();
    write_drive(&folder.path().join("drive.csv"));
    // Its end, and what it printed; never a crash, and never an error without a hint.
    let ends = |line: &str| {
        let output = run(folder.path(), line);
        let (code, text) = (output.status.code(), text_of(&output));
        assert!(matches!(code, Some(0..=2)), "{line}: {text}");
        assert!(!text.contains("internal fault"), "{line}: {text}");
        assert!(code != Some(2) || text.contains("hint: "), "{line}: {text}");
        (code == Some(2), text)
    };
    for structure in Structure::ALL {
        let identify = format!("identify drive.csv --structure {structure}");
        let drawn = "--traces t.csv --plots plots --report r.html";
        let (is_refused, text) = ends(&format!("{identify} {drawn} --force"));
        assert!(!is_refused, "{text}");
        for written in ["t.csv", "plots", "r.html"] {
            assert!(folder.path().join(written).exists(), "{written}: {text}");
        }
        std::fs::remove_file(folder.path().join("t.csv")).unwrap();
        std::fs::remove_file(folder.path().join("r.html")).unwrap();
        std::fs::remove_dir_all(folder.path().join("plots")).unwrap();
        let name = structure.file_name();
        let json = std::fs::read_to_string(folder.path().join(&name)).unwrap();
        let model = Model::from_json(&json, &name).unwrap();
        assert_eq!(model.structure(), structure);
        assert_eq!(model.to_json(), json);
        assert!(!model.channels().is_empty() && model.provenance().is_some(), "{structure}");
        // The sentence goes on with the next command.
        let summary = model.quality().summary.trim_end_matches('.');
        assert!(text.contains(summary), "{structure}: {text}");
        // Those of the lateral dynamics have tests of their own with each command.
        if structure.is_lateral() {
            continue;
        }
        for command in [
            format!("design {name} --force"),
            format!("package {name} --out fmu --force"),
            format!("export {name} --for openpilot"),
            format!("export {name} --for px4"),
            format!("path --plant {name} --force"),
            format!("compare {name} {name} --log drive.csv --out c --force"),
            format!("excite {name} --force"),
        ] {
            ends(&command);
        }
        // Without steering there is no sideslip on a path, which is not the same as none.
        let refused = run(folder.path(), &format!("path --plant {name} --force"));
        assert_eq!(refused.status.code(), Some(2), "{structure}: {}", text_of(&refused));
    }
}
