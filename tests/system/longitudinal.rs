//! `identify --structure longitudinal`: the response of the speed, from the command line.

use crate::support::{read_json, run, text_of};
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Document, Longitudinal};

const PEDALS: &str = "time_s,accelerator [1],brake [1],speed_mps";
const COMMAND: &str = "time_s,acceleration_command_mps2,speed_mps";

/// What a driver does and what the car does, at 50 Hz.
struct Sample {
    time_s: f64,
    accelerator: f64,
    brake: f64,
    acceleration_mps2: f64,
    speed_mps: f64,
}

/// 243 s, four pairs of half minutes, of a car of 3.2 m/s² at the full accelerator or 1 m/s² per commanded m/s², a lag of 0.35 s, a delay of
/// 0.15 s and a resistance of 0.15 m/s² + 4e-4·v². The driver follows speeds between 8 and 26 m/s. A motor of limited
/// power accelerates less above 14 m/s.
fn drive(is_limited: bool) -> Vec<Sample> {
    const STEP: f64 = 0.002;
    let mut state = 7_u64;
    // Uniform from 0 to 1: Knuth's MMIX.
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut speed, mut drive, mut brake) = (12.0_f64, 0.0, 0.0);
    let (mut reference, mut wanted, mut until) = (12.0_f64, 12.0, 0.0);
    let mut delayed = std::collections::VecDeque::from(vec![0.0_f64; 75]);
    let (mut command, mut samples) = (0.0_f64, Vec::new());
    for k in 0..121_500_u32 {
        let time_s = f64::from(k) * STEP;
        if time_s >= until {
            until = time_s + 4.0 + 6.0 * random();
            wanted = 8.0 + 18.0 * random();
        }
        if k % 10 == 0 {
            reference += (wanted - reference).clamp(-0.05, 0.03);
            let unrest = 0.3 * (random() - 0.5);
            command = (0.9 * (reference - speed) + 0.2 + unrest).clamp(-4.0, 3.0);
            samples.push(Sample {
                time_s,
                accelerator: command.max(0.0) / 3.2,
                brake: (-command).max(0.0) / 9.0,
                acceleration_mps2: command,
                speed_mps: speed + 0.1 * (random() - 0.5),
            });
        }
        delayed.push_back(command);
        let late = delayed.pop_front().unwrap_or_default();
        let share = if is_limited { (14.0 / speed).min(1.0) } else { 1.0 };
        drive += STEP * (share * late.max(0.0) - drive) / 0.35;
        brake += STEP * (late.min(0.0) - brake) / 0.35;
        speed += STEP * (drive + brake - 0.15 - 4e-4 * speed * speed);
    }
    samples
}

/// Writes a log of the cells of each sample.
fn write_log(file: &Path, header: &str, cells: impl Fn(&Sample) -> Vec<f64>) {
    let mut text = format!("{header}\n");
    for sample in drive(false) {
        let cells: Vec<String> = cells(&sample).iter().map(|cell| format!("{cell:.4}")).collect();
        let _ = writeln!(text, "{:.2},{}", sample.time_s, cells.join(","));
    }
    std::fs::write(file, text).unwrap();
}

fn write_pedals(file: &Path) {
    write_log(file, PEDALS, |sample| vec![sample.accelerator, sample.brake, sample.speed_mps]);
}

fn read_model(file: &Path) -> Longitudinal {
    Longitudinal::from_json(&std::fs::read_to_string(file).unwrap(), "it").unwrap()
}

#[test]
fn pedals_and_acceleration_commands_are_identified() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_pedals(&folder.join("pedals.csv"));
    write_log(&folder.join("command.csv"), COMMAND, |sample| {
        vec![sample.acceleration_mps2, sample.speed_mps]
    });
    // No log has a gear: that of the pedals' vehicle shows that it has one.
    for (log, gain, quality) in
        [("pedals", 3.2, "quality pass: "), ("command", 1.0, "quality pass: ")]
    {
        let line = format!("identify {log}.csv --structure longitudinal -o {log}.json");
        let output = run(folder, &line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        for part in ["lag", "delay", "resistance", "fit ", quality, "written to"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        let model = read_model(&folder.join(format!("{log}.json")));
        assert!((model.gain_at(15.0) / gain - 1.0).abs() < 0.02, "{:?}", model.gains);
        assert!((model.time_constant_s.value - 0.35).abs() < 0.03, "{:?}", model.time_constant_s);
        assert_eq!(model.brake.is_some(), log == "pedals");
        let printed = run(folder, &format!("{line} --json --force"));
        let printed: serde_json::Value = serde_json::from_slice(&printed.stdout).unwrap();
        assert_eq!(printed, read_json(&folder.join(format!("{log}.json"))));
    }
}

/// Signals, figure and page have the speed as it is simulated in the windows of the fit.
#[test]
fn signals_figures_and_a_page_show_the_simulated_speed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_pedals(&folder.join("drive.csv"));
    let line =
        "identify drive.csv --structure longitudinal --traces t.csv --plots plots --report r.html";
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    let model = read_model(&folder.join("longitudinal.json"));
    let text = std::fs::read_to_string(folder.join("t.csv")).unwrap();
    let mut rows = text.lines();
    assert_eq!(
        rows.next(),
        Some("time_s,accelerator,brake,speed_mps,simulated_speed_mps,held_out")
    );
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let validated = rows.iter().filter(|row| row[5] == 1.0 && row[4].is_finite());
    let errors: Vec<f64> = validated.map(|row| row[4] - row[3]).collect();
    assert!(errors.len() > 9 * model.evidence.validation_samples / 10, "{}", errors.len());
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    // Of changes of some metres per second, with a fit of 97 % and more.
    assert!(rms > 0.0 && rms < 0.15, "{rms}");
    let names: Vec<_> = std::fs::read_dir(folder.join("plots")).unwrap().collect();
    assert_eq!(names.len(), 1, "{names:?}");
    let page = std::fs::read_to_string(folder.join("r.html")).unwrap();
    for part in ["change of the speed", "speed_mps", "validation data"] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn commands_for_the_steering_reject_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_pedals(&folder.join("drive.csv"));
    let identify = "identify drive.csv --structure longitudinal";
    assert_eq!(run(folder, identify).status.code(), Some(0));
    let before = std::fs::read_dir(folder).unwrap().count();
    for (line, problem) in [
        ("identify drive.csv --structure longitudinal --order 2", "the structure state-space"),
        ("compare longitudinal.json --log drive.csv", "the structure longitudinal"),
        ("export longitudinal.json --for openpilot", "the structure longitudinal"),
        ("build drive.csv --structure longitudinal", "the structure longitudinal"),
        ("accumulate drive.csv", "no steering"),
        ("accumulate longitudinal.json", "not a log"),
    ] {
        let output = run(folder, line);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{line}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), before, "nothing is written");
}

#[test]
fn logs_without_information_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: usize, pedal: f64, speed: f64| {
        format!("{:.2},{pedal:.3},0,{speed:.3}\n", 0.02 * k as f64)
    };
    let pedal = |k: usize| if k % 100 < 40 { 0.2 } else { 0.0 };
    let all = |cells: &dyn Fn(usize) -> String| (0..6000).map(cells).collect::<String>();
    for (rows, problem) in [
        (String::new(), "a log needs 100 or more"),
        (row(0, 0.1, 12.0), "a log needs 100 or more"),
        (all(&|k| row(k, pedal(k), 0.0)), "the speed is 0 m/s throughout"),
        (all(&|k| row(k, pedal(k), -4.0 - pedal(k))), "reverses"),
        (
            all(&|k| row(k, 0.2, 20.0 + 0.01 * (k % 3) as f64)),
            "the accelerator or acceleration command is 0.2 throughout",
        ),
    ] {
        std::fs::write(folder.path().join("drive.csv"), format!("{PEDALS}\n{rows}")).unwrap();
        let output = run(folder.path(), "identify drive.csv --structure longitudinal");
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{problem}: {text}");
        assert!(text.contains(problem) && text.contains("hint:"), "{problem}: {text}");
    }
}

#[test]
fn other_units_and_signs_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let identify = "identify drive.csv --structure longitudinal --force";
    let drive = folder.join("drive.csv");
    // A speed in km/h as m/s.
    write_log(&drive, PEDALS, |s| vec![s.accelerator, s.brake, 3.6 * s.speed_mps]);
    let text = text_of(&run(folder, identify));
    assert!(text.contains("warn (implausible-gain)") && text.contains("km/h"), "{text}");
    write_log(&drive, COMMAND, |s| vec![s.acceleration_mps2, 3.6 * s.speed_mps]);
    let text = text_of(&run(folder, identify));
    assert!(text.contains("warn (implausible-gain)") && text.contains("km/h"), "{text}");
    write_log(&drive, COMMAND, |s| vec![-s.acceleration_mps2, s.speed_mps]);
    let text = text_of(&run(folder, identify));
    assert!(text.contains("--input-channel=\"-acceleration_command_mps2\""), "{text}");

    // A pedal that is 1 where it is released.
    write_log(&drive, PEDALS, |s| vec![1.0 - s.accelerator, s.brake, s.speed_mps]);
    let output = run(folder, identify);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("fail (wrong-sign)"), "{text}");
    assert!(text.contains("--input-channel \"1 - accelerator [1]\""), "{text}");
    let mut words: Vec<String> = crate::support::words(identify, Path::new(""));
    words.extend(["--input-channel".into(), "1 - accelerator [1]".into()]);
    let output = crate::support::steerwright(folder, &words);
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    let model = read_model(&folder.join("longitudinal.json"));
    assert!((model.resistance_mps2.value - 0.15).abs() < 0.02, "{:?}", model.resistance_mps2);
    // Only its sign is reversed: the vehicle seems to accelerate alone.
    let reversed =
        run(folder, &identify.replace(" --force", " --force --input-channel=-accelerator"));
    let text = text_of(&reversed);
    assert!(text.contains("unusual-parameter") && text.contains("command of 0"), "{text}");

    // A pedal without a unit.
    let names = "time_s,throttle,brake,speed_mps";
    write_log(&drive, names, |s| vec![s.accelerator, s.brake, s.speed_mps]);
    let output = run(folder, identify);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("`throttle [%]`") && !text.contains("deg"), "{text}");
}

/// A log as it is between its samples.
struct Log {
    signals: [Vec<f64>; 3],
    /// Whether pedals are held over a sample, otherwise they move on straight lines.
    is_held: bool,
    sample_time_s: f64,
}

impl Log {
    fn signal(&self, index: usize, time_s: f64, is_held: bool) -> f64 {
        let samples = &self.signals[index];
        let last = samples.len() - 1;
        let place = (time_s / self.sample_time_s + 1e-9).clamp(0.0, last as f64);
        let below = place.floor() as usize;
        let share = if is_held { 0.0 } else { place - below as f64 };
        samples[below] + share * (samples[(below + 1).min(last)] - samples[below])
    }

    fn pedal(&self, index: usize, time_s: f64) -> f64 {
        self.signal(index, time_s, self.is_held)
    }

    fn speed(&self, time_s: f64) -> f64 {
        self.signal(2, time_s, false)
    }
}

/// Rates of drive and brake, and of the speed, at a time.
fn rates(model: &Longitudinal, state: [f64; 3], time_s: f64, log: &Log) -> [f64; 3] {
    let [drive, brake, speed] = state;
    let accelerator = log.pedal(0, time_s - model.delay_s.value);
    let curvature = model.pedal_curvature.map_or(0.0, |own| own.value);
    let accelerator = accelerator + curvature * accelerator * (1.0 - accelerator);
    let of_brake = model.brake.as_ref().unwrap();
    let pedal = log.pedal(1, time_s - of_brake.delay_s.value);
    let resistance = model.resistance_mps2.value
        + model.resistance_per_speed.map_or(0.0, |own| own.value) * speed
        + model.drag_per_m.value * speed * speed;
    [
        (model.gain_at(speed) * accelerator - drive) / model.time_constant_s.value,
        (-of_brake.gain_mps2.value * pedal - brake) / of_brake.time_constant_s.value,
        drive + brake - resistance,
    ]
}

/// Integrates in steps of 0.2 ms by the classical Runge–Kutta method, with the measured speed or a simulated one;
/// returns the last state, and the speed at each sample.
fn integrate(
    model: &Longitudinal,
    log: &Log,
    mut state: [f64; 3],
    (from_s, to_s): (f64, f64),
    is_measured: bool,
) -> ([f64; 3], Vec<f64>) {
    const STEP: f64 = 2e-4;
    let per_sample = (log.sample_time_s / STEP).round() as usize;
    let mut speeds = Vec::new();
    for k in 0..((to_s - from_s) / STEP).round() as usize {
        let time_s = from_s + k as f64 * STEP;
        if is_measured {
            state[2] = log.speed(time_s);
        }
        if k % per_sample == 0 {
            speeds.push(state[2]);
        }
        let moved = |by: [f64; 3], share: f64| -> [f64; 3] {
            std::array::from_fn(|i| state[i] + share * STEP * by[i])
        };
        let first = rates(model, state, time_s, log);
        let second = rates(model, moved(first, 0.5), time_s + 0.5 * STEP, log);
        let third = rates(model, moved(second, 0.5), time_s + 0.5 * STEP, log);
        let fourth = rates(model, moved(third, 1.0), time_s + STEP, log);
        state = std::array::from_fn(|i| {
            state[i] + STEP / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i])
        });
    }
    (state, speeds)
}

/// Fit of a file by integration: of the windows of 10 s in the second half of each minute, which begins at `start_s`.
fn integrated_fit(model: &Longitudinal, log: &Log, start_s: f64) -> f64 {
    let measured_speeds = &log.signals[2];
    let end_s = measured_speeds.len() as f64 * log.sample_time_s;
    let (mut error, mut change) = (0.0, 0.0);
    let (mut lags, mut time_s) = ([0.0, 0.0, measured_speeds[0]], 0.0);
    for minute in 0..4 {
        for window in 0..3 {
            let start_s = start_s + 60.0 * f64::from(minute) + 30.0 + 10.0 * f64::from(window);
            assert!(start_s + 10.0 <= end_s);
            (lags, _) = integrate(model, log, lags, (time_s, start_s), true);
            time_s = start_s;
            let first = (start_s / log.sample_time_s).round() as usize;
            let measured =
                &measured_speeds[first..first + (10.0 / log.sample_time_s).round() as usize];
            let mean = measured.iter().sum::<f64>() / measured.len() as f64;
            let (mut initial, mut squares) = (measured[0], 0.0);
            // The best initial speed.
            for _ in 0..4 {
                let state = [lags[0], lags[1], initial];
                let (_, speeds) = integrate(model, log, state, (start_s, start_s + 10.0), false);
                let errors: Vec<f64> =
                    measured.iter().zip(&speeds).map(|(y, own)| y - own).collect();
                squares = errors.iter().map(|e| e * e).sum();
                initial += errors.iter().sum::<f64>() / errors.len() as f64;
            }
            error += squares;
            change += measured.iter().map(|y| (y - mean).powi(2)).sum::<f64>();
        }
    }
    100.0 * (1.0 - f64::sqrt(error / change))
}

/// The file alone, integrated by other means than those of the identification, has the fit that it states.
#[test]
fn an_integration_in_fine_steps_reproduces_the_stated_fit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut text = format!("{PEDALS}\n");
    let mut log = Log { signals: [const { Vec::new() }; 3], is_held: true, sample_time_s: 0.02 };
    for s in drive(true) {
        let _ = writeln!(text, "{:.2},{},{},{}", s.time_s, s.accelerator, s.brake, s.speed_mps);
        for (signal, value) in log.signals.iter_mut().zip([s.accelerator, s.brake, s.speed_mps]) {
            signal.push(value);
        }
    }
    std::fs::write(folder.join("drive.csv"), text).unwrap();
    // The first 2 s fill the lags; a log of measured pedals begins where their filter does.
    for (intersample, start_s) in [("zoh", 2.0), ("bl", 2.18)] {
        // At the samples of the log, since longer ones have other signals, filtered.
        let line =
            "identify drive.csv --structure longitudinal --sample-time 20ms --force --intersample";
        let output = run(folder, &format!("{line} {intersample}"));
        assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
        let model = read_model(&folder.join("longitudinal.json"));
        assert!(model.gains.len() > 1, "{:?}", model.gains);
        assert_eq!(model.evidence.validation_windows, 12);
        log.is_held = intersample == "zoh";
        let fit = integrated_fit(&model, &log, start_s);
        let stated = model.evidence.validation_fit;
        println!("{intersample}: {fit:.3} % integrated, {stated:.3} % stated");
        assert!((fit - stated).abs() < 0.1, "{intersample}: {fit} {stated}");
    }
}
