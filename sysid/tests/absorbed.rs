//! Drives absorbed into states, merged and identified from: the same model however they came together,
//! the model that the log itself gives, and a clear word about what does not belong together.
#![allow(clippy::unwrap_used, clippy::panic)]

use formats::{AbsorbedDrives, Document, InputKind, Plant};
use std::f64::consts::TAU;
use sysid::{
    AbsorbOptions, Absorbed, Error, IdentifyOptions, LogFile, LogOptions, StateSpace, identify,
    read_log,
};
use sysid_evaluation::{Drive, response_distance};

fn csv(seed: u64, rows: usize) -> String {
    Drive { sample_time: 0.01, delay: 0.0, servo: 0.0, noise: 0.002, seed }.record(rows).csv()
}

fn absorbed_with(text: &str, options: &AbsorbOptions) -> Result<Absorbed, Error> {
    Absorbed::of_log(LogFile::of_bytes("drive.csv", text.as_bytes()), options)
}

fn absorbed(text: &str) -> Absorbed {
    absorbed_with(text, &AbsorbOptions::default()).unwrap()
}

/// As another machine reads it.
fn sent(state: &Absorbed) -> Absorbed {
    let file = AbsorbedDrives::from_json(&state.to_file().to_json(), "a.factor").unwrap();
    Absorbed::from_file(&file, "a.factor").unwrap()
}

fn model(plant: &Plant) -> StateSpace {
    let d = &plant.discrete;
    let dense =
        |m: &formats::Matrix| faer::Mat::from_fn(m.rows(), m.columns().unwrap(), |i, j| m.at(i, j));
    StateSpace { a: dense(&d.a), b: dense(&d.b), c: dense(&d.c), d: dense(&d.d) }
}

fn merged(states: &[&Absorbed]) -> Absorbed {
    let mut all = states[0].clone();
    for state in &states[1..] {
        all.merge((*state).clone()).unwrap();
    }
    all
}

#[test]
fn merging_is_one_pass_in_any_order_and_through_files() {
    let [a, b, c] = [1, 2, 3].map(|seed| absorbed(&csv(seed, 24_000)));
    let order = IdentifyOptions { order: Some(2), ..IdentifyOptions::default() };
    let one = merged(&[&a, &b, &c]).identify(&order).unwrap();
    let samples = one.evidence.estimation_samples + one.evidence.validation_samples;
    assert_eq!(samples, 3 * (a.samples().0 + a.samples().1));
    let bc = merged(&[&sent(&b), &sent(&c)]);
    for other in [merged(&[&sent(&c), &sent(&b), &a]), merged(&[&sent(&a), &sent(&bc)])] {
        let other = other.identify(&order).unwrap();
        let distance = response_distance(&model(&one), &model(&other));
        assert!(distance < 1e-10, "{distance:e}");
        let (one, other) = (&one, &other);
        let of = |p: &Plant| {
            [
                p.operating_point.steering_offset_rad,
                p.operating_point.speed_mps,
                p.noise.innovation_variance,
                p.evidence.fit.validation,
                p.evidence.fit.validation_one_step,
            ]
        };
        for (a, b) in of(one).iter().zip(of(other)) {
            assert!((a - b).abs() < 1e-9 * (1e-3 + a.abs()), "{a} {b}");
        }
    }
}

#[test]
fn the_model_is_that_of_the_log_and_offsets_cost_nothing() {
    let text = csv(7, 60_000);
    let options = IdentifyOptions { delay_s: Some(0.0), ..IdentifyOptions::default() };
    let log = read_log(&[("a.csv".into(), text.clone().into())], &LogOptions::default()).unwrap();
    let whole = identify(&log, &options).unwrap().plant;
    let plant = absorbed(&text).identify(&IdentifyOptions::default()).unwrap();
    // Where the drive excites.
    for hz in [0.1, 0.3, 0.6, 1.0, 1.5, 2.0] {
        let at = |p: &Plant| model(p).frequency_response(0, 0, TAU * hz * p.discrete.sample_time_s);
        let (a, b) = (at(&plant), at(&whole));
        let apart = (a.0 - b.0).hypot(a.1 - b.1) / b.0.hypot(b.1);
        assert!(apart < 0.02, "{hz} Hz: {apart}");
    }
    assert_eq!(plant.order(), whole.order());
    assert!(model(&plant).spectral_radius() < 1.0);
    assert!(plant.evidence.fit.validation > 95.0, "{:?}", plant.evidence.fit);
    // The third pole, which hardly shows, may come out on the negative axis: then that is said.
    let warnings = plant.evidence.warnings.join("\n");
    assert!(plant.continuous.is_some() || warnings.contains("stays discrete"), "{warnings}");
    assert!((plant.operating_point.speed_mps - whole.operating_point.speed_mps).abs() < 0.01);
    assert!(plant.evidence.excitation.informative_up_to_hz > 0.8);
    // Not tested is not passed.
    assert!(plant.evidence.independence.lags == 0 && !plant.evidence.independence.pass);
    assert!(plant.evidence.warnings.iter().any(|w| w.contains("no estimate of the delay")));
    // A crooked wheel and a gyro's bias, far beyond what any has: the model stays.
    let mut lines = text.lines();
    let mut moved = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        for (cell, offset) in [(1, 0.3), (2, -2.0)] {
            cells[cell] = format!("{:.7}", cells[cell].parse::<f64>().unwrap() + offset);
        }
        moved += &(cells.join(",") + "\n");
    }
    let other = absorbed(&moved).identify(&IdentifyOptions::default()).unwrap();
    let distance = response_distance(&model(&plant), &model(&other));
    assert!(distance < 1e-6, "{distance:e}");
}

#[test]
fn states_that_differ_are_refused_with_what_differs() {
    let text = csv(1, 6_000);
    let one = absorbed(&text);
    let other = csv(2, 6_000);
    let with = |change: &dyn Fn(&mut AbsorbOptions)| {
        let mut options = AbsorbOptions::default();
        change(&mut options);
        absorbed_with(&other, &options).unwrap()
    };
    let refused = |other: Absorbed, word: &str| {
        let error = one.clone().merge(other).unwrap_err();
        let said = format!("{error} | {}", error.hint());
        assert!(matches!(error, Error::Differ { .. }) && said.contains(word), "{said}");
    };
    refused(with(&|o| o.horizon = 20), "horizons of 30 and 20");
    refused(with(&|o| o.log.sample_time_s = Some(0.05)), "sample times of 0.04 s and 0.05 s");
    refused(with(&|o| o.log.steering_ratio = Some(15.0)), "steering ratios of 1 and 15");
    refused(with(&|o| o.input_kind = InputKind::SteeringTimesSpeed), "steering*speed");
    refused(with(&|o| o.log.max_gap_s = 0.2), "max_gap_s is 0.5 and 0.2");
    refused(with(&|o| o.log.speed_window = Some((10.0, 20.0))), "speed_window_mps");
    let mut file = with(&|_| ()).to_file();
    file.provenance.version = "0.0.7".into();
    refused(Absorbed::from_file(&file.sealed(), "b.factor").unwrap(), "0.0.7");
    let repeated = one.clone().merge(absorbed(&text)).unwrap_err();
    assert!(matches!(repeated, Error::RepeatedDrive { .. }), "{repeated}");
}

#[test]
fn a_file_that_was_cut_or_changed_is_refused() {
    let file = absorbed(&csv(1, 6_000)).to_file();
    let text = file.to_json();
    assert!(AbsorbedDrives::from_json(&text[..text.len() / 2], "a.factor").is_err());
    let state = text.find("\"estimation\": \"").unwrap() + 1000;
    for at in [text.find("\"horizon\"").unwrap() + 11, state] {
        let mut bytes = text.clone().into_bytes();
        bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
        let error = AbsorbedDrives::from_json(std::str::from_utf8(&bytes).unwrap(), "a.factor");
        assert!(error.is_err(), "{at}");
    }
    // A checksum is no proof: what passes it is checked too.
    let sealed = |change: &dyn Fn(&mut AbsorbedDrives)| {
        let mut file = file.clone();
        change(&mut file);
        Absorbed::from_file(&file.sealed(), "a.factor")
    };
    assert!(sealed(&|_| ()).is_ok());
    for change in [
        &(|f: &mut AbsorbedDrives| f.horizon = 29) as &dyn Fn(&mut AbsorbedDrives),
        &|f| f.sample_time_s = 0.05,
        &|f| f.estimation_samples += 1,
        &|f| f.estimation.truncate(200),
        &|f| f.estimation.push('0'),
        &|f| f.validation = "xyzé".into(),
        &|f| f.estimation = f.validation.clone(),
    ] {
        let error = sealed(change).unwrap_err();
        assert!(matches!(error, Error::NoFactor { .. }), "{error}");
    }
}

#[test]
fn logs_that_cannot_be_absorbed_say_why() {
    let said = |text: &str, options: &AbsorbOptions| {
        let error = absorbed_with(text, options).unwrap_err();
        format!("{error} | {}", error.hint())
    };
    let default = AbsorbOptions::default();
    let good = csv(1, 3_000);
    let half = good.replace("yaw_rate_radps", "something_radps");
    assert!(said(&half, &default).contains("no yaw rate, and each file is read as a drive"));
    let window = LogOptions { windows: vec![(1.0, 2.0)], ..LogOptions::default() };
    let window = AbsorbOptions { log: window, ..AbsorbOptions::default() };
    assert!(said(&good, &window).contains("--window"));
    let long = AbsorbOptions { horizon: 500, ..AbsorbOptions::default() };
    assert!(said(&good, &long).contains("2 to 200"));
    // A clock that changes its rate.
    let mut rows = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps\n");
    let mut t = 0.0;
    for k in 0..40_000 {
        t += if k < 20_000 { 0.01 } else { 0.02 };
        let x = (0.001 * f64::from(k)).sin();
        rows += &format!("{t:.3},{:.6},{:.6}\n", 0.01 * x, 0.1 * x);
    }
    assert!(said(&rows, &default).contains("period changes from 0.01 s to 0.02 s"));
    assert!(
        said(&good.lines().take(2).collect::<Vec<_>>().join("\n"), &default).contains("1 value")
    );
    // Long enough to read, too short to identify from.
    let short = absorbed(&csv(1, 700));
    let error = short.identify(&IdentifyOptions::default()).unwrap_err();
    assert!(matches!(error, Error::TooFewSamples { .. }), "{error}");
    // Options that windows cannot serve.
    let state = absorbed(&good);
    let with = |change: &dyn Fn(&mut IdentifyOptions)| {
        let mut options = IdentifyOptions::default();
        change(&mut options);
        state.identify(&options).unwrap_err().to_string()
    };
    assert!(with(&|o| o.delay_s = Some(0.1)).contains("--delay"));
    assert!(with(&|o| o.horizon = Some(40)).contains("30 at most"));
    assert!(with(&|o| o.detrend = sysid::Detrend::Linear).contains("--detrend"));
}
