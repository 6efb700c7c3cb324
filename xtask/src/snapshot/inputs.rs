//! The folder of the commands, with copies of the inputs in the repository and with three simulated drives: a car of
//! varying speed up to the limit of its grip, one that is steered by torque, and one that follows its pedals.
//!
//! They are computed without a mathematical library, so that each machine has the same bytes.

use crate::files::{copy_below, remove, write};
use crate::run::root;
use std::collections::VecDeque;
use std::fmt::Write;
use std::path::Path;

/// A folder of inputs, and the folder of the repository that it is a copy of.
const COPIED: [(&str, &str); 7] = [
    ("data", "examples/drives"),
    ("logs", "tests/fuzzing/corpus/logs"),
    ("archives", "tests/fuzzing/corpus/archives"),
    ("databases", "tests/fuzzing/corpus/databases"),
    ("fixtures", "drivelog/tests/it/fixtures"),
    ("documents", "tests/fuzzing/documents"),
    ("inputs", "tests/snapshot"),
];

/// Makes the folder again; `cases` is a folder of further logs.
pub(super) fn prepare(work: &Path, cases: Option<&Path>) -> Result<(), String> {
    remove(work)?;
    for (name, from) in COPIED {
        copy_below(&root().join(from), &work.join(name))?;
    }
    if let Some(cases) = cases {
        copy_below(cases, &work.join("cases"))?;
    }
    examples(&work.join("documents"))?;
    write(&work.join("inputs/varying.csv"), varying_speed().as_bytes())?;
    write(&work.join("inputs/torque.csv"), torque().as_bytes())?;
    write(&work.join("inputs/pedals.csv"), pedals().as_bytes())
}

/// The example of each FMU, by the name of its format.
fn examples(folder: &Path) -> Result<(), String> {
    let fmus = root().join("fmu");
    let entries = std::fs::read_dir(&fmus).map_err(|e| format!("{}: {e}", fmus.display()))?;
    for entry in entries {
        let path =
            entry.map_err(|e| format!("{}: {e}", fmus.display()))?.path().join("example.json");
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        let format =
            text.split('/').nth(1).ok_or_else(|| format!("{}: no schema", path.display()))?;
        write(&folder.join(format!("{format}.json")), text.as_bytes())?;
    }
    Ok(())
}

/// A linear congruential generator: Knuth's MMIX.
struct Random(u64);

impl Random {
    /// Uniform from −1 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// About normal, of standard deviation 1: the sum of twelve.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() / 2.0
    }
}

/// Close to tanh, without a mathematical library.
fn saturate(x: f64) -> f64 {
    let x = x.clamp(-3.0, 3.0);
    x * (27.0 + x * x) / (27.0 + 9.0 * x * x)
}

/// Two wheels with tyres that saturate, 150 s at 50 Hz: speed 9 to 21 m/s, steering in ramps between random levels.
fn varying_speed() -> String {
    const STEP: f64 = 0.002;
    let (mass, inertia, front, rear) = (1500.0, 2400.0, 1.2, 1.5);
    let force = |slip: f64| 6500.0 * saturate(slip * 80_000.0 / 6500.0);
    let (mut random, mut goal, mut steering) = (Random(1), 0.0, 0.0_f64);
    let (mut lateral, mut rate, mut acceleration) = (0.0, 0.0, 0.0);
    let mut log = String::from(
        "time_s,steering_wheel_angle_deg,yaw_rate_radps,speed_mps,lateral_acceleration_mps2\n",
    );
    for k in 0..75_000_u32 {
        let time = f64::from(k) * STEP;
        let phase = time % 50.0 / 25.0;
        let speed = 9.0 + 12.0 * if phase < 1.0 { phase } else { 2.0 - phase };
        if k % 400 == 0 {
            goal = 12.0 * random.uniform() / (speed * speed);
        }
        if k % 10 == 0 {
            let angle = 15.0 * steering * 57.295_779_513;
            let (yaw, noise) = (rate + 0.002 * random.normal(), 0.05 * random.normal());
            let shown = acceleration + noise;
            let _ = writeln!(log, "{time:.2},{angle:.4},{yaw:.5},{speed:.3},{shown:.4}");
        }
        steering += (goal - steering).clamp(-0.3 * STEP, 0.3 * STEP);
        let of_front = force(steering - (lateral + front * rate) / speed);
        let of_rear = force((rear * rate - lateral) / speed);
        acceleration = (of_front + of_rear) / mass;
        lateral += STEP * (acceleration - speed * rate);
        rate += STEP * (front * of_front - rear * of_rear) / inertia;
    }
    log
}

/// 2.5 m/s² per command, friction 0.12, offset 0.05 m/s², delay 0.26 s; 600 s at 50 Hz and 20 m/s.
fn torque() -> String {
    let (mut random, mut goal, mut command, mut angle) = (Random(2), 0.0, 0.0_f64, 0.0);
    let mut delayed = VecDeque::from(vec![0.0; 13]);
    let mut log = String::from(
        "time_s,steering_torque [1],lateral_acceleration_mps2,speed_mps,steering_angle_deg\n",
    );
    for k in 0..30_000_u32 {
        if k % 40 == 0 {
            goal = 0.8 * random.uniform();
        }
        command += (goal - command).clamp(-0.04, 0.04);
        delayed.push_back(command);
        let late = delayed.pop_front().unwrap_or_default();
        let rate = (0.3 * late - angle) / 0.15;
        let friction = 0.12 * saturate(rate / 0.05);
        let acceleration = 2.5 * (late - friction) + 0.05 + 0.05 * random.normal();
        let (time, degrees) = (f64::from(k) * 0.02, angle * 57.295_779_513);
        let _ = writeln!(log, "{time:.2},{command:.6},{acceleration:.5},20,{degrees:.5}");
        angle += 0.02 * rate;
    }
    log
}

/// 3 m/s² at the full accelerator and 9 m/s² at the full brake, a lag of 0.3 s, a delay of 0.12 s; 200 s at 25 Hz, 8 to
/// 24 m/s.
fn pedals() -> String {
    const STEP: f64 = 0.02;
    let (mut random, mut goal, mut reference) = (Random(3), 15.0, 12.0_f64);
    let (mut speed, mut drive, mut command) = (12.0_f64, 0.0, 0.0_f64);
    let mut delayed = VecDeque::from(vec![0.0_f64; 6]);
    let mut log = String::from("time_s,accelerator [1],brake [1],speed_mps\n");
    for k in 0..10_000_u32 {
        if k % 300 == 0 {
            goal = 16.0 + 8.0 * random.uniform();
        }
        reference += (goal - reference).clamp(-0.05, 0.03);
        if k % 2 == 0 {
            command = (reference - speed + 0.2 + 0.1 * random.normal()).clamp(-4.0, 3.0);
            let (accelerator, brake) = (command.max(0.0) / 3.0, (-command).max(0.0) / 9.0);
            let (time, shown) = (f64::from(k) * STEP, speed + 0.03 * random.normal());
            let _ = writeln!(log, "{time:.2},{accelerator:.4},{brake:.4},{shown:.3}");
        }
        delayed.push_back(command);
        let late = delayed.pop_front().unwrap_or_default();
        drive += STEP * (late - drive) / 0.3;
        speed += STEP * (drive - 0.15 - 0.0004 * speed * speed);
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drives_are_the_same_on_each_machine() {
        let (varying, torque, pedals) = (varying_speed(), torque(), pedals());
        assert_eq!(pedals.lines().count(), 5001);
        assert_eq!(pedals.lines().nth(2500), Some("99.96,0.0000,0.2446,14.122"));
        assert_eq!(varying.lines().count(), 7501);
        assert_eq!(varying.lines().nth(5000), Some("99.98,-78.0686,-0.28338,9.010,-2.5193"));
        assert_eq!(torque.lines().count(), 30_001);
        assert_eq!(torque.lines().nth(15_000), Some("299.98,0.478079,1.24900,20,8.15277"));
    }
}
