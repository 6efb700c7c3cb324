//! Drives accumulated into states, merged and identified from: the same model however they came
//! together, the model of the log itself, and a clear error for what does not belong together.

mod refused;

use crate::known::bias::Errors;
use crate::known::{
    AccumulatedSignals, Drive, Experiment, Random, driver, halves, response_distance,
};
use std::f64::consts::TAU;
use std::io::{Cursor, Read};
use steerwright_drivelog::{LogFile, LogOptions, read_log};
use steerwright_formats::{AccumulatedDrives, Document, InputKind, Plant};
use steerwright_sysid::model::initial_state;
use steerwright_sysid::{
    AccumulateOptions, Accumulated, DataSet, Error, IdentifyOptions, Method, StateSpace,
    ValidationData, Weighting, automatic, fit_percent, identify, simulate,
};

fn csv(seed: u64, rows: usize) -> String {
    Drive { sample_time: 0.01, delay: 0.0, servo: 0.0, noise: 0.002, seed }.record(rows).csv()
}

fn accumulated_with(text: &str, options: &AccumulateOptions) -> Result<Accumulated, Error> {
    Accumulated::of_log(LogFile::of_bytes("drive.csv", text.as_bytes()), options)
}

fn accumulated(text: &str) -> Accumulated {
    accumulated_with(text, &AccumulateOptions::default()).unwrap()
}

/// As another machine reads it.
fn sent(state: &Accumulated) -> Accumulated {
    let file = AccumulatedDrives::from_json(&state.to_file().to_json(), "a.rfactor").unwrap();
    Accumulated::from_file(&file, "a.rfactor").unwrap()
}

fn model(plant: &Plant) -> StateSpace {
    let d = &plant.discrete;
    let dense = |m: &steerwright_formats::Matrix| {
        faer::Mat::from_fn(m.rows(), m.columns().unwrap(), |i, j| m.entry(i, j))
    };
    StateSpace { a: dense(&d.a), b: dense(&d.b), c: dense(&d.c), d: dense(&d.d) }
}

fn merged(states: &[&Accumulated]) -> Accumulated {
    let mut all = states[0].clone();
    for state in &states[1..] {
        all.merge((*state).clone()).unwrap();
    }
    all
}

#[test]
fn merging_is_one_pass_in_any_order_and_through_files() {
    let [a, b, c] = [1, 2, 3].map(|seed| accumulated(&csv(seed, 24_000)));
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

/// Bytes that come a few at a time, as from a pipe.
struct Trickle(Cursor<Vec<u8>>, usize);

impl Read for Trickle {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let most = to.len().min(self.1);
        self.0.read(&mut to[..most])
    }
}

#[test]
fn a_log_is_the_same_however_its_bytes_come() {
    let text = csv(4, 9_000);
    let whole = accumulated(&text).to_file();
    for bytes in [1, 7, 1000] {
        let reader = Trickle(Cursor::new(text.clone().into_bytes()), bytes);
        let file = LogFile::of_stream("drive.csv", reader);
        let state = Accumulated::of_log(file, &AccumulateOptions::default()).unwrap();
        assert_eq!(state.to_file(), whole, "{bytes}");
    }
}

/// Whatever is merged with what first.
#[test]
fn merging_is_the_same_in_every_order_and_grouping() {
    let mut random = Random(31);
    let options = AccumulateOptions { horizon: 10, ..AccumulateOptions::default() };
    let parts: Vec<Accumulated> =
        (1..=6).map(|seed| accumulated_with(&csv(seed, 3_000), &options).unwrap()).collect();
    let order = IdentifyOptions { order: Some(2), ..IdentifyOptions::default() };
    let one = merged(&parts.iter().collect::<Vec<_>>()).identify(&order).unwrap();
    for _ in 0..8 {
        let mut groups = parts.clone();
        while groups.len() > 1 {
            let mut draw = || (random.uniform() * groups.len() as f64) as usize % groups.len();
            let (a, b) = (draw(), draw());
            if a != b {
                let (mut first, second) = (groups[a].clone(), groups[b].clone());
                first.merge(second).unwrap();
                groups[a] = first;
                groups.swap_remove(b);
            }
        }
        let other = groups[0].identify(&order).unwrap();
        let distance = response_distance(&model(&one), &model(&other));
        assert!(distance < 1e-9, "{distance:e}");
    }
}

/// A driver who steers by what the car did: the open-loop methods are biased, the default is not.
#[test]
#[ignore = "slow: cargo xtask test"]
fn feedback_is_found_and_does_not_bias_the_model() {
    let truth = driver::Drive::vehicle();
    let drive = driver::Drive::controlled();
    let size = |model: &StateSpace| {
        let errors = Errors::new(model, &truth).unwrap().response;
        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let data = drive.record(40_000, 3).unwrap();
    let accumulated = AccumulatedSignals::new(&data, 30).unwrap();
    let found = accumulated.identify(&IdentifyOptions::default()).unwrap();
    assert!(found.feedback);
    assert!(matches!(found.method.as_str(), "ssarx" | "pbsid"), "{}", found.method);
    let open = Method::OpenLoop(Weighting::N4sid);
    let forced = IdentifyOptions {
        method: Some(open),
        order: Some(truth.order()),
        ..IdentifyOptions::default()
    };
    let forced = accumulated.identify(&forced).unwrap();
    let first = &data.segments()[0];
    let part = |range: std::ops::Range<usize>| {
        let (u, y) = (first.u.columns(range.clone()), first.y.columns(range));
        DataSet::single(driver::SAMPLE_TIME_S, u, y).unwrap()
    };
    let memory =
        automatic(&part(0..30_000), &part(30_000..40_000), &IdentifyOptions::default()).unwrap();
    assert_eq!(found.model.order(), memory.model.order());
    let [of_factor, in_memory, biased] = [&found.model, &memory.model, &forced.model].map(size);
    assert!(of_factor < 0.015 && of_factor < in_memory + 0.005, "{of_factor} {in_memory}");
    assert!(biased > 3.0 * of_factor, "{biased} {of_factor}");
    // No feedback where there is none.
    let open = driver::Drive { gain: 0.0, ..drive }.record(20_000, 3).unwrap();
    let open = AccumulatedSignals::new(&open, 30).unwrap();
    assert!(!open.identify(&IdentifyOptions::default()).unwrap().feedback);
}

/// The fit on the validation windows is that of simulating the validation blocks themselves.
#[test]
#[ignore = "slow: cargo xtask test"]
fn the_fit_on_validation_windows_is_that_of_the_validation_samples() {
    const BLOCK: usize = 500;
    let drive = Drive { sample_time: 0.01, delay: 0.0, servo: 0.0, noise: 0.05, seed: 6 };
    let text = drive.record(100_000).csv();
    let plant = accumulated(&text).identify(&IdentifyOptions::default()).unwrap();
    let log = read_log(&[("a.csv".into(), text.into())], &LogOptions::default()).unwrap();
    let model = model(&plant);
    let point = &plant.operating_point;
    let (mut measured, mut simulated) = (Vec::new(), Vec::new());
    let (mut samples, mut from) = (0, 3 * BLOCK);
    while from < log.len() {
        let range = from..(from + BLOCK).min(log.len());
        let of = |x: &[f64], offset: f64| {
            steerwright_sysid::Signals::from(x.iter().map(|x| x - offset).collect::<Vec<f64>>())
        };
        let u = of(&log.input[range.clone()], point.steering_offset_rad);
        let y = of(&log.output[range.clone()], point.yaw_rate_offset_radps);
        let x0 = initial_state(&model, u.as_ref(), y.as_ref()).unwrap();
        simulated.extend_from_slice(simulate(&model, u.as_ref(), &x0).row(0));
        measured.extend_from_slice(y.row(0));
        samples += range.len();
        from += 4 * BLOCK;
    }
    assert_eq!(samples, plant.evidence.validation_samples);
    let fit = fit_percent(&measured, &simulated);
    let stated = plant.evidence.fit.validation;
    // The windows' states follow from half a window, those of the blocks from all of them.
    assert!((-1.0..0.3).contains(&(stated - fit)), "{stated} {fit}");
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_order_is_that_of_the_samples_in_memory() {
    let mut random = Random(190);
    // A vehicle's order is 2 at least, as long as the data show any of it.
    for order in [2, 3] {
        let e = Experiment::random(&mut random, order, false, 5000, 20.0);
        let data = DataSet::single(0.05, e.u.clone(), e.noisy.clone()).unwrap();
        let [estimation, validation] = halves(&data).unwrap();
        let options = IdentifyOptions::default();
        let memory = automatic(&estimation, &validation, &options).unwrap().model;
        let accumulated = AccumulatedSignals::new(&estimation, 30).unwrap();
        let found = accumulated.identify(&options).unwrap().model;
        assert_eq!(found.order(), memory.order(), "{order}");
        let loss = e.clean_fit(&memory) - e.clean_fit(&found);
        assert!(loss < 0.5, "{order}: {loss}");
    }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_model_is_that_of_the_log_and_offsets_cost_nothing() {
    let text = csv(7, 60_000);
    // As much to estimate from as the factor has.
    let options = IdentifyOptions {
        delay_s: Some(0.0),
        validation: ValidationData { fraction: 0.25, ..ValidationData::default() },
        ..IdentifyOptions::default()
    };
    let log = read_log(&[("a.csv".into(), text.clone().into())], &LogOptions::default()).unwrap();
    let whole = identify(&log, &options).unwrap().plant;
    let plant = accumulated(&text).identify(&IdentifyOptions::default()).unwrap();
    // Where the drive excites.
    for hz in [0.1, 0.3, 0.6, 1.0, 1.5, 2.0] {
        let at = |p: &Plant| model(p).frequency_response(0, 0, TAU * hz * p.discrete.sample_time_s);
        let (a, b) = (at(&plant), at(&whole));
        let apart = (a.0 - b.0).hypot(a.1 - b.1) / b.0.hypot(b.1);
        assert!(apart < 0.02, "{hz} Hz: {apart}");
    }
    // A second-order yaw response seen through a filter has no order of its own: which one the data
    // require depends on the samples. Neither order may be one of fit.
    let apart = plant.evidence.fit.validation - whole.evidence.fit.validation;
    assert!(plant.order().abs_diff(whole.order()) <= 1 && apart.abs() < 0.2, "{apart}");
    assert!(model(&plant).spectral_radius() < 1.0);
    assert!(plant.evidence.fit.validation > 95.0, "{:?}", plant.evidence.fit);
    assert_eq!(plant.continuous.is_some(), whole.continuous.is_some());
    assert!((plant.operating_point.speed_mps - whole.operating_point.speed_mps).abs() < 0.01);
    assert!(plant.evidence.excitation.informative_up_to_hz > 0.8);
    // Not tested is not passed.
    assert!(plant.evidence.independence.lags == 0 && !plant.evidence.independence.pass);
    assert!(plant.evidence.warnings.iter().any(|w| w.contains("no estimate of the delay")));
    // A steering offset and a gyro's bias, far beyond what any has: the model stays.
    let mut lines = text.lines();
    let mut moved = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        for (cell, offset) in [(1, 0.3), (2, -2.0)] {
            cells[cell] = format!("{:.7}", cells[cell].parse::<f64>().unwrap() + offset);
        }
        moved += &(cells.join(",") + "\n");
    }
    let other = accumulated(&moved).identify(&IdentifyOptions::default()).unwrap();
    let distance = response_distance(&model(&plant), &model(&other));
    assert!(distance < 1e-6, "{distance:e}");
}

/// A drive with stretches at walking pace between gaps, the first at its start; the yaw rate obeys another law there.
fn with_crawling(fast: &str, every: usize, crawling: usize) -> String {
    const GAP: usize = 300;
    let mut lines = fast.lines();
    let mut text = format!("{}\n", lines.next().unwrap());
    let mut row = 0;
    for (k, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if k % every == 0 {
            row += GAP;
            for slow in 0..crawling {
                let angle = 0.3 * (0.02 * slow as f64).sin();
                let t = 0.01 * row as f64;
                text += &format!("{t:.3},{angle:.7},{:.7},1.0,0.1,0.0\n", 0.35 * angle);
                row += 1;
            }
            row += GAP;
        }
        cells[0] = format!("{:.3}", 0.01 * row as f64);
        text += &(cells.join(",") + "\n");
        row += 1;
    }
    text
}

/// What crawls is left out, wherever it is, and reported; a vehicle that is nowhere faster is used as it is.
#[test]
fn what_crawls_is_left_out() {
    let text = csv(11, 24_000);
    let plain = accumulated(&text);
    assert!(plain.warnings().is_empty(), "{:?}", plain.warnings());
    let slow = accumulated(&with_crawling(&text, 3_000, 1_500));
    let warned = slow.warnings().iter().find(|w| w.contains("the speed is below"));
    println!("{warned:?}");
    assert!(warned.is_some_and(|w| w.contains("left out")), "{:?}", slow.warnings());
    let order = IdentifyOptions { order: Some(2), ..IdentifyOptions::default() };
    let [plain_fit, slow_fit] = [&plain, &slow].map(|state| {
        let plant = sent(state).identify(&order).unwrap();
        assert!(plant.provenance.options.contains_key("least_speed_mps"));
        plant.evidence.fit.validation
    });
    println!("{plain_fit} {slow_fit}");
    assert!((plain_fit - slow_fit).abs() < 1.0, "{plain_fit} {slow_fit}");
    assert!(slow.samples().0 + slow.samples().1 <= plain.samples().0 + plain.samples().1);

    let crawling = accumulated(&text.replace(",15.", ",1.").replace(",14.", ",1."));
    assert_eq!(crawling.samples(), plain.samples());
    assert!(crawling.warnings().iter().all(|w| !w.contains("the speed is below")));
}

/// Minutes at walking pace before anything else do not make them part of the model.
#[test]
fn what_crawls_for_minutes_at_the_start_is_left_out() {
    let text = csv(12, 24_000);
    let plain = accumulated(&text);
    let slow = accumulated(&with_crawling(&text, 24_000, 18_000));
    let warnings = slow.warnings();
    assert!(warnings.iter().any(|w| w.contains("the speed is below")), "{warnings:?}");
    let [plain_s, slow_s] = [&plain, &slow].map(|state| {
        let (estimation, validation) = state.samples();
        (estimation + validation) as f64 * state.to_file().sample_time_s
    });
    println!("{plain_s} s, {slow_s} s");
    assert!((plain_s - slow_s).abs() < 1.0, "{plain_s} s, {slow_s} s");
}
