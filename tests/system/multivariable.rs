//! `identify` with named inputs and outputs of any system, from the command line.

use crate::support::{read_json, run, text_of};
use std::fmt::Write;
use std::path::Path;
use steerwright_formats::{Document, MultivariablePlant};

/// Knuth's MMIX: uniform numbers, of which twelve make a normal one.
struct Random(u64);

impl Random {
    fn normal(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// Signals of a plant of two inputs and two outputs, sampled every 0.5 s: a heater of one tank and a valve between two, the
/// valve three samples late. Columns: heater in W, valve in V, temperatures in °C.
struct Tanks {
    time_s: Vec<f64>,
    inputs: [Vec<f64>; 2],
    outputs: [Vec<f64>; 2],
}

impl Tanks {
    fn new(count: usize, noise: f64) -> Self {
        let mut random = Random(11);
        let mut tanks = Self {
            time_s: Vec::new(),
            inputs: [Vec::new(), Vec::new()],
            outputs: [Vec::new(), Vec::new()],
        };
        let (mut heat, mut valve, mut a, mut b) = (0.0, 0.0, 0.0, 0.0);
        let mut late = std::collections::VecDeque::from(vec![0.0; 3]);
        for k in 0..count {
            if k % 3 == 0 {
                heat = 0.5 * heat + 100.0 * random.normal();
                valve = 0.4 * valve + 1.5 * random.normal();
            }
            tanks.time_s.push(0.5 * k as f64);
            tanks.inputs[0].push(1500.0 + heat);
            tanks.inputs[1].push(4.0 + valve);
            tanks.outputs[0].push(60.0 + a + noise * random.normal());
            tanks.outputs[1].push(45.0 + b + noise * random.normal());
            late.push_back(valve);
            let valve = late.pop_front().unwrap_or_default();
            (a, b) = (0.9 * a + 0.02 * heat - 0.3 * valve, 0.8 * b + 0.15 * a + 0.6 * valve);
        }
        tanks
    }

    fn write(&self, file: &Path) {
        let mut text = String::from(
            "time_s,heater_power [W],valve_voltage_V,T1 [°C],outlet_temperature_degC\n",
        );
        for k in 0..self.time_s.len() {
            let values = [&self.inputs[0], &self.inputs[1], &self.outputs[0], &self.outputs[1]];
            let cells: Vec<String> = values.iter().map(|v| format!("{:.6}", v[k])).collect();
            let _ = writeln!(text, "{},{}", self.time_s[k], cells.join(","));
        }
        std::fs::write(file, text).unwrap();
    }
}

const CHANNELS: &str = "--input-channel heater_power --input-channel valve_voltage_V --output-channel T1 \
                        --output-channel outlet_temperature_degC";

fn read_plant(file: &Path) -> MultivariablePlant {
    MultivariablePlant::from_json(&std::fs::read_to_string(file).unwrap(), "it").unwrap()
}

/// x of least ‖A x − b‖ by the normal equations and Gauss's elimination.
fn least_squares(rows: &[(Vec<f64>, f64)]) -> Vec<f64> {
    let n = rows[0].0.len();
    let mut m = vec![vec![0.0; n + 1]; n];
    for (row, b) in rows {
        for i in 0..n {
            for j in 0..n {
                m[i][j] += row[i] * row[j];
            }
            m[i][n] += row[i] * b;
        }
    }
    for i in 0..n {
        let pivot = (i..n).max_by(|a, b| m[*a][i].abs().total_cmp(&m[*b][i].abs())).unwrap();
        m.swap(i, pivot);
        let of_pivot = m[i].clone();
        for (_, row) in m.iter_mut().enumerate().filter(|(k, _)| *k != i) {
            let factor = row[i] / of_pivot[i];
            row.iter_mut().zip(&of_pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    (0..n).map(|i| m[i][n] / m[i][i]).collect()
}

fn times(matrix: &steerwright_formats::Matrix, x: &[f64]) -> Vec<f64> {
    matrix.0.iter().map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// Fits of the outputs over samples, by the document alone: its matrices, offsets and delays, and the initial state that
/// fits best.
fn fits(plant: &MultivariablePlant, tanks: &Tanks, from: usize, to: usize) -> Vec<f64> {
    let d = &plant.discrete;
    let late = |j: usize| (plant.inputs[j].delay_s / d.sample_time_s).round() as usize;
    let input = |k: usize| -> Vec<f64> {
        let at = |j: usize| k.saturating_sub(late(j)).max(from);
        (0..2).map(|j| tanks.inputs[j][at(j)] - plant.inputs[j].offset).collect()
    };
    let simulated = |x0: &[f64]| -> Vec<Vec<f64>> {
        let mut x = x0.to_vec();
        let outputs = (from..to).map(|k| {
            let u = input(k);
            let y = sum(&times(&d.c, &x), &times(&d.d, &u));
            x = sum(&times(&d.a, &x), &times(&d.b, &u));
            y
        });
        outputs.collect()
    };
    let n = plant.order();
    let at_rest = simulated(&vec![0.0; n]);
    let of_unit: Vec<Vec<Vec<f64>>> = (0..n)
        .map(|i| simulated(&(0..n).map(|k| f64::from(u8::from(k == i))).collect::<Vec<_>>()))
        .collect();
    let deviation = |k: usize, i: usize| tanks.outputs[i][from + k] - plant.outputs[i].offset;
    let mut rows = Vec::new();
    for k in 0..to - from {
        for i in 0..2 {
            // In units of the output's deviation, as the document's.
            let scale = plant.outputs[i].standard_deviation;
            let row = of_unit.iter().map(|y| (y[k][i] - at_rest[k][i]) / scale).collect();
            rows.push((row, (deviation(k, i) - at_rest[k][i]) / scale));
        }
    }
    let y = simulated(&least_squares(&rows));
    (0..2)
        .map(|i| {
            let count = (to - from) as f64;
            let mean = (0..to - from).map(|k| deviation(k, i)).sum::<f64>() / count;
            let error: f64 = (0..to - from).map(|k| (deviation(k, i) - y[k][i]).powi(2)).sum();
            let spread: f64 = (0..to - from).map(|k| (deviation(k, i) - mean).powi(2)).sum();
            100.0 * (1.0 - (error / spread).sqrt())
        })
        .collect()
}

#[test]
fn named_channels_are_identified_and_the_file_reproduces_the_stated_fits() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tanks = Tanks::new(800, 0.3);
    tanks.write(&folder.join("tanks.csv"));
    let line = format!("identify tanks.csv {CHANNELS} -o plant.json");
    let output =
        run(folder, &format!("{line} --traces traces.csv --report page.html --plots plots"));
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    for part in
        ["output", "degC", "1.5 s of valve_voltage_V", "T1: ", " ± ", "residual", "written to"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let plant = read_plant(&folder.join("plant.json"));
    let channels: Vec<(&str, &str)> = plant
        .inputs
        .iter()
        .map(|c| (c.name.as_str(), c.unit.as_str()))
        .chain(plant.outputs.iter().map(|c| (c.name.as_str(), c.unit.as_str())))
        .collect();
    let expected = [
        ("heater_power", "W"),
        ("valve_voltage_V", "V"),
        ("T1", "degC"),
        ("outlet_temperature_degC", "degC"),
    ];
    assert_eq!(channels, expected);
    assert_eq!([plant.inputs[0].delay_s, plant.inputs[1].delay_s], [0.0, 1.5]);
    assert_eq!(plant.discrete.sample_time_s, 0.5);
    assert!(plant.order() <= 3, "{:?}", plant.evidence.order_table);
    for (evidence, fit) in plant.evidence.outputs.iter().zip(fits(&plant, &tanks, 400, 800)) {
        assert!(evidence.fit.validation > 85.0, "{evidence:?}");
        assert!((evidence.fit.validation - fit).abs() < 1e-5, "{evidence:?} {fit}");
        assert!(evidence.whiteness.pass && evidence.fit_standard_error.is_some(), "{evidence:?}");
        assert!(evidence.coherence.iter().any(|c| c.coherence > 0.9), "{evidence:?}");
    }
    // The gains at rest, by hand, within three standard errors.
    let truth = [0.02 / 0.1, -0.3 / 0.1, 0.15 * 0.2 / 0.2, (0.6 - 0.15 * 3.0) / 0.2];
    for (pair, truth) in plant.evidence.pairs.iter().zip(truth) {
        let gain = pair.steady_state_gain.unwrap();
        assert!((gain.value - truth).abs() < 3.0 * gain.standard_error, "{pair:?} {truth}");
        assert!(pair.independence.pass, "{pair:?}");
        assert!(!pair.measured.is_empty());
    }
    let delays = plant.evidence.pairs.iter().map(|pair| pair.delay.map(|d| d.estimate_s));
    assert_eq!(delays.collect::<Vec<_>>()[..2], [Some(0.0), Some(1.5)]);
    let traces = std::fs::read_to_string(folder.join("traces.csv")).unwrap();
    assert!(traces.starts_with("time_s,heater_power,valve_voltage_V,T1,simulated_T1,"), "{traces}");
    assert_eq!(traces.lines().count(), 801);
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("outlet_temperature_degC over heater_power"));
    for (file, label) in [("outputs.svg", "T1"), ("gains.svg", "T1 over heater_power")] {
        let figure = std::fs::read_to_string(folder.join("plots").join(file)).unwrap();
        assert!(figure.contains(label), "{file}: {figure}");
    }
    assert_eq!(std::fs::read_dir(folder.join("plots")).unwrap().count(), 2);
    let printed = run(folder, &format!("{line} --json --force"));
    let printed: serde_json::Value = serde_json::from_slice(&printed.stdout).unwrap();
    assert_eq!(printed, read_json(&folder.join("plant.json")));
}

#[test]
fn one_channel_of_any_system_is_named_as_one_of_several_is() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    Tanks::new(400, 0.3).write(&folder.join("tanks.csv"));
    let line = "identify tanks.csv --input-channel heater_power --output-channel T1 --order 1";
    let output = run(folder, line);
    assert!(output.status.success(), "{}", text_of(&output));
    let plant = read_plant(&folder.join("plant.json"));
    assert_eq!((plant.inputs.len(), plant.outputs.len(), plant.order()), (1, 1, 1));
}

#[test]
fn what_is_not_of_any_system_rejects_named_channels() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    Tanks::new(400, 0.3).write(&folder.join("tanks.csv"));
    let identify = format!("identify tanks.csv {CHANNELS}");
    assert!(run(folder, &identify).status.success());
    let bicycle = include_str!("../../fmu/bicycle-plant/example.json");
    std::fs::write(folder.join("bicycle.json"), bicycle).unwrap();
    for (line, problem) in [
        (format!("{identify} --structure bicycle"), "the structure bicycle is that of a vehicle"),
        (format!("{identify} --detrend linear"), "detrend: linear"),
        (format!("{identify} --delay 0.3s"), "a whole number of samples of 0.5 s"),
        (format!("{identify} --unit T1=turns"), "turns"),
        (format!("{identify} --structure torque"), "has one --input-channel"),
        (format!("build tanks.csv {CHANNELS} --out built"), "build designs the steering of a vehicle"),
        (
            "identify tanks.csv --input-channel T1 --input-channel heater_power --output-channel T1".into(),
            "named as an input and as an output",
        ),
        (
            "identify tanks.csv --input-channel T1 --input-channel heater_power".into(),
            "2 inputs and 0 outputs are named",
        ),
        (
            "identify tanks.csv --input-channel power --output-channel T1 --output-channel T2".into(),
            "no column `power` (for the input)",
        ),
        ("design plant.json".into(), "a plant of named channels is of any system"),
        ("path --plant plant.json".into(), "follows no path"),
        ("simulate plant.json".into(), "a document, which no FMU is"),
        ("export plant.json --for autoware".into(), "no parameters of a steering"),
        ("compare plant.json".into(), "are compared on a log"),
        ("compare plant.json --log tanks.csv --overshoot 2%".into(), "the specification has no effect"),
        ("compare plant.json --log tanks.csv --sample-time 1s".into(), "sampled at 1 s, the plant at 0.5 s"),
        ("compare plant.json --log tanks.csv --unit T1=K".into(), "has the unit K, that of the plant degC"),
        ("compare plant.json bicycle.json --log tanks.csv".into(), "beside a plant of named channels"),
    ] {
        let output = run(folder, &format!("{line} --force"));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(problem), "{line}: {text}");
        assert!(text.contains("hint:"), "{line}: {text}");
    }
}

/// On another drive, against the document alone; the channels and the sample time are those of the plant.
#[test]
fn plants_of_named_channels_are_compared_on_another_log() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    Tanks::new(800, 0.3).write(&folder.join("tanks.csv"));
    for order in [1, 2] {
        let line = format!("identify tanks.csv {CHANNELS} --order {order} -o order_{order}.json");
        run(folder, &line);
    }
    let other = Tanks::new(500, 0.1);
    other.write(&folder.join("other.csv"));
    let line = "compare order_1.json order_2.json --log other.csv";
    let output = run(folder, &format!("{line} --out compared --json"));
    assert!(output.status.success(), "{}", text_of(&output));
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for (k, name) in ["order_1", "order_2"].into_iter().enumerate() {
        let plant = read_plant(&folder.join(format!("{name}.json")));
        let model = &printed["models"][k];
        assert_eq!(
            (&model["name"], model["outputs"][0]["name"].as_str()),
            (&name.into(), Some("T1"))
        );
        for (i, expected) in fits(&plant, &other, 0, 500).into_iter().enumerate() {
            let fit = model["outputs"][i]["fit_percent"].as_f64().unwrap();
            assert!((fit - expected).abs() < 1e-6, "{name} {i}: {fit} {expected}");
        }
        for figure in ["outputs", "gains"] {
            assert!(folder.join(format!("compared/{name}-{figure}.svg")).exists());
        }
    }
    let text = text_of(&run(folder, line));
    assert!(text.contains("best fit: T1 by order_2"), "{text}");
}

/// Packed, and driven by the log, against the document alone.
#[test]
fn the_packed_plant_has_the_names_of_the_channels_and_the_outputs_of_the_document() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tanks = Tanks::new(800, 0.3);
    tanks.write(&folder.join("tanks.csv"));
    for line in [
        format!("identify tanks.csv {CHANNELS} --validation-fraction 40% -o plant.json"),
        "package plant.json".into(),
        "check MultivariablePlant.fmu --run".into(),
    ] {
        let output = run(folder, &line);
        assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    }
    let mut inputs = String::from("time,valve_voltage_V,heater_power\n");
    for k in 0..800 {
        let _ =
            writeln!(inputs, "{},{},{}", tanks.time_s[k], tanks.inputs[1][k], tanks.inputs[0][k]);
    }
    std::fs::write(folder.join("inputs.csv"), inputs).unwrap();
    let line = "simulate MultivariablePlant.fmu --input inputs.csv --stop 399.5s -o result.csv";
    let output = run(folder, line);
    assert!(output.status.success(), "{}", text_of(&output));

    let plant = read_plant(&folder.join("plant.json"));
    let d = &plant.discrete;
    let late = |j: usize| (plant.inputs[j].delay_s / d.sample_time_s).round() as usize;
    let deviation = |k: usize, j: usize| match k.checked_sub(late(j)) {
        Some(k) => tanks.inputs[j][k] - plant.inputs[j].offset,
        None => 0.0,
    };
    let result = std::fs::read_to_string(folder.join("result.csv")).unwrap();
    let mut rows = result.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|n| n.ends_with(name)).unwrap();
    let places = [place("T1"), place("outlet_temperature_degC")];
    let mut x = vec![0.0; plant.order()];
    let mut compared = 0;
    for (k, row) in rows.enumerate() {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(cells[0], tanks.time_s[k]);
        let v = [deviation(k, 0), deviation(k, 1)];
        let y = sum(&times(&d.c, &x), &times(&d.d, &v));
        for i in 0..2 {
            let expected = y[i] + plant.outputs[i].offset;
            assert!((cells[places[i]] - expected).abs() < 1e-9, "{k}: {row} {expected}");
            compared += 1;
        }
        x = sum(&times(&d.a, &x), &times(&d.b, &v));
    }
    assert_eq!(compared, 1600);
}
