//! What is no factor, and what cannot be made one, is refused with its reason.

use super::*;

#[test]
fn states_that_differ_are_refused_with_what_differs() {
    let text = csv(1, 6_000);
    let one = accumulated(&text);
    let other = csv(2, 6_000);
    let with = |change: &dyn Fn(&mut AccumulateOptions)| {
        let mut options = AccumulateOptions::default();
        change(&mut options);
        accumulated_with(&other, &options).unwrap()
    };
    let refused = |other: Accumulated, word: &str| {
        let error = one.clone().merge(other).unwrap_err();
        let message = format!("{error} | {}", error.hint());
        assert!(matches!(error, Error::Differ { .. }) && message.contains(word), "{message}");
    };
    refused(with(&|o| o.horizon = 20), "horizons of 30 and 20");
    refused(with(&|o| o.log.sample_time_s = Some(0.05)), "sample times of 0.02 s and 0.05 s");
    refused(with(&|o| o.log.steering_ratio = Some(15.0)), "steering ratios of 1 and 15");
    refused(with(&|o| o.input_kind = InputKind::SteeringTimesSpeed), "steering*speed");
    refused(with(&|o| o.log.max_gap_s = 0.2), "max_gap_s is 0.5 and 0.2");
    refused(with(&|o| o.log.speed_window = Some((10.0, 20.0))), "speed_window_mps");
    let mut file = with(&|_| ()).to_file();
    file.provenance.version = "0.0.7".into();
    refused(Accumulated::from_file(&file.sealed(), "b.rfactor").unwrap(), "0.0.7");
}

#[test]
fn a_log_that_is_in_both_counts_once() {
    let [one, two, three] = [1, 2, 3].map(|seed| accumulated(&csv(seed, 6_000)));
    let merged = |parts: [&Accumulated; 2]| {
        let mut all = parts[0].clone();
        let added = all.merge(parts[1].clone()).unwrap();
        (all, added)
    };
    let (both, added) = merged([&one, &two]);
    assert!(added);
    for parts in [[&both, &one], [&one, &both], [&both, &both], [&two, &both]] {
        let (all, added) = merged(parts);
        assert!(!added);
        assert_eq!(all.to_file(), both.to_file());
    }
    // What they share cannot be removed from either.
    let (others, _) = merged([&two, &three]);
    let repeated = both.clone().merge(others).unwrap_err();
    assert!(
        matches!(repeated, Error::Log(steerwright_drivelog::Error::RepeatedDrive { .. })),
        "{repeated}"
    );
}

#[test]
fn a_file_that_was_cut_or_changed_is_refused() {
    let file = accumulated(&csv(1, 6_000)).to_file();
    let text = file.to_json();
    assert!(AccumulatedDrives::from_json(&text[..text.len() / 2], "a.rfactor").is_err());
    let state = text.find("\"estimation\": \"").unwrap() + 1000;
    for at in [text.find("\"horizon\"").unwrap() + 11, state] {
        let mut bytes = text.clone().into_bytes();
        bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
        let error = AccumulatedDrives::from_json(std::str::from_utf8(&bytes).unwrap(), "a.rfactor");
        assert!(error.is_err(), "{at}");
    }
    // A checksum is no proof: what passes it is checked too.
    let sealed = |change: &dyn Fn(&mut AccumulatedDrives)| {
        let mut file = file.clone();
        change(&mut file);
        Accumulated::from_file(&file.sealed(), "a.rfactor")
    };
    assert!(sealed(&|_| ()).is_ok());
    for change in [
        &(|f: &mut AccumulatedDrives| f.horizon = 29) as &dyn Fn(&mut AccumulatedDrives),
        &|f| f.sample_time_s = 0.05,
        &|f| f.estimation_samples += 1,
        &|f| f.estimation.truncate(200),
        &|f| f.estimation.push('0'),
        &|f| f.validation = "xyzé".into(),
        &|f| f.estimation = f.validation.clone(),
        &|f| f.estimation_samples = 1_000_000_000_000_000_000,
        &|f| f.sample_time_s = 1e18,
        &|f| f.sample_time_s = f64::NAN,
        &|f| f.steering_ratio = -1.0,
        &|f| f.horizon = 1_000_000_000_000_000_000,
    ] {
        let error = sealed(change).unwrap_err();
        assert!(matches!(error, Error::NoFactor { .. }), "{error}");
    }
}

/// What has a right checksum need not have come from any drive.
#[test]
fn numbers_that_no_drive_has_are_no_crash() {
    let file = accumulated(&csv(1, 24_000)).to_file();
    // The number at a place of the state, in hexadecimal; seven of them come before the constants.
    let with = |place: usize, count: usize, value: f64| {
        let mut file = file.clone();
        let digits: String = value.to_le_bytes().iter().map(|b| format!("{b:02x}")).collect();
        let at = 16 + 16 * place;
        file.estimation.replace_range(at..at + 16 * count, &digits.repeat(count));
        Accumulated::from_file(&file.sealed(), "a.rfactor")
    };
    assert!(with(9, 0, 0.0).is_ok());
    for value in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(matches!(with(9, 1, value), Err(Error::NoFactor { .. })), "{value}");
    }
    // Counts: more windows than samples, and absurdly many of both.
    assert!(matches!(with(6, 1, 1e15), Err(Error::NoFactor { .. })));
    assert!(matches!(with(5, 2, 1e18), Err(Error::NoFactor { .. })));
    // The rest are numbers like any other: an error or a model, no more.
    let whole = file.estimation.len() / 16 - 10;
    for (place, count, value) in [(9, whole, 0.0), (9, whole, 1.0), (9, 1, 0.0), (9, whole, 1e149)]
    {
        if let Ok(state) = with(place, count, value) {
            match state.identify(&IdentifyOptions::default()) {
                Ok(plant) => assert!(model(&plant).spectral_radius() < 1.0),
                Err(error) => assert!(!error.hint().is_empty(), "{error}"),
            }
        }
    }
    // A drive without a sample, and one that never moves.
    let error = accumulated_with(
        "time_s,roadwheel_angle_rad,yaw_rate_radps\n",
        &AccumulateOptions::default(),
    );
    assert!(
        matches!(error, Err(Error::Log(steerwright_drivelog::Error::TooFewRows { .. }))),
        "{error:?}"
    );
    let still: String = (0..3000).map(|k| format!("{:.2},0,0\n", 0.01 * f64::from(k))).collect();
    let still = format!("time_s,roadwheel_angle_rad,yaw_rate_radps\n{still}");
    let error = accumulated_with(&still, &AccumulateOptions::default());
    assert!(
        matches!(error, Err(Error::Log(steerwright_drivelog::Error::Constant { .. }))),
        "{error:?}"
    );
}

#[test]
fn a_fault_is_reported_with_its_place() {
    let text = accumulated(&csv(1, 6_000)).to_file().to_json();
    let message = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        let changed = text.replacen(from, to, 1);
        AccumulatedDrives::from_json(&changed, "a.rfactor").unwrap_err().to_string()
    };
    for (from, to, place) in [
        ("\"horizon\": 30", "\"horizon\": 1e18", "horizon"),
        ("\"horizon\": 30", "\"horizon\": 1000000000000000000", "horizon"),
        ("\"horizon\": 30", "\"horizon\": -3", "horizon"),
        ("\"steering_ratio\": 1.0", "\"steering_ratio\": \"one\"", "steering_ratio"),
        ("\"sample_time_s\": 0.02", "\"sample_time_s\": NaN", "sample_time_s"),
        ("\"sample_time_s\": 0.02", "\"sample_time_s\": 0", "sample_time_s"),
        ("\"mean_mps\"", "\"mean\"", "speed"),
        ("\"rate_hz\": 100.0", "\"rate_hz\": null", "channels[0].rate_hz"),
    ] {
        let problem = message(from, to);
        assert!(problem.contains("a.rfactor") && problem.contains(place), "{problem}");
    }
}

#[test]
fn logs_that_cannot_be_accumulated_are_errors_with_the_reason() {
    let message = |text: &str, options: &AccumulateOptions| {
        let error = accumulated_with(text, options).unwrap_err();
        format!("{error} | {}", error.hint())
    };
    let default = AccumulateOptions::default();
    let good = csv(1, 3_000);
    let half = good.replace("yaw_rate_radps", "something_radps");
    assert!(message(&half, &default).contains("no yaw rate, and each file is read as a drive"));
    let window = LogOptions { windows: vec![(1.0, 2.0)], ..LogOptions::default() };
    let window = AccumulateOptions { log: window, ..AccumulateOptions::default() };
    assert!(message(&good, &window).contains("window: "));
    let long = AccumulateOptions { horizon: 500, ..AccumulateOptions::default() };
    assert!(message(&good, &long).contains("2 to 200"));
    // A clock that changes its rate.
    let mut rows = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps\n");
    let mut t = 0.0;
    for k in 0..40_000 {
        t += if k < 20_000 { 0.01 } else { 0.02 };
        let x = (0.001 * f64::from(k)).sin();
        rows += &format!("{t:.3},{:.6},{:.6}\n", 0.01 * x, 0.1 * x);
    }
    assert!(message(&rows, &default).contains("period changes from 0.01 s to 0.02 s"));
    assert!(
        message(&good.lines().take(2).collect::<Vec<_>>().join("\n"), &default).contains("1 value")
    );
    // Long enough to read, too short to identify from.
    let short = accumulated(&csv(1, 350));
    let error = short.identify(&IdentifyOptions::default()).unwrap_err();
    assert!(matches!(error, Error::TooFewSamples { .. }), "{error}");
    // Options that windows cannot serve.
    let state = accumulated(&good);
    let with = |change: &dyn Fn(&mut IdentifyOptions)| {
        let mut options = IdentifyOptions::default();
        change(&mut options);
        state.identify(&options).unwrap_err().to_string()
    };
    assert!(with(&|o| o.delay_s = Some(0.1)).contains("delay: 0.1 s"));
    assert!(with(&|o| o.horizon = Some(40)).contains("30 at most"));
    assert!(with(&|o| o.detrend = steerwright_sysid::Detrend::Linear).contains("detrend: linear"));
}
