//! The input delay: found where there is one, left out where a lag explains the same.

use crate::common::recording;
use crate::known::{Drive, Random};
use faer::Mat;
use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_sysid::delay::{Delay, estimate_delay};
use steerwright_sysid::{DataSet, Error, IdentifyOptions, Segment, identify};

fn row(x: &[f64]) -> Mat<f64> {
    Mat::from_fn(1, x.len(), |_, k| x[k])
}

fn data((ts, u, y): &(f64, Vec<f64>, Vec<f64>)) -> DataSet {
    DataSet::single(*ts, row(u), row(y)).unwrap()
}

/// Sample time, steering and yaw rate of so many seconds.
fn record(drive: Drive, seconds: f64) -> (f64, Vec<f64>, Vec<f64>) {
    let recording = drive.record((seconds / drive.sample_time) as usize);
    (recording.sample_time, recording.steering, recording.yaw_rate)
}

const DRIVE: Drive = Drive { sample_time: 0.04, delay: 0.0, servo: 0.0, noise: 0.002, seed: 1 };

fn estimate(drive: &Drive) -> Delay {
    estimate_delay(&data(&record(*drive, 60.0))).unwrap()
}

#[test]
fn a_delay_is_found_to_a_hundredth_of_a_second() {
    for (sample_time, delay, servo, noise) in [
        (0.04, 0.12, 0.0, 0.002),
        (0.01, 0.12, 0.0, 0.01),
        (0.04, 0.12, 0.05, 0.002),
        (0.04, 0.2, 0.05, 0.002),
        // Less than a sample.
        (0.04, 0.03, 0.0, 0.002),
        (0.04, 0.135, 0.0, 0.002),
    ] {
        for seed in [1, 2] {
            let found = estimate(&Drive { sample_time, delay, servo, noise, seed });
            let error = (found.seconds - delay).abs();
            assert!(error < 0.01, "{delay} {servo} {seed}: {found:?}");
            assert!(error < 4.0 * found.standard_error_s + 0.001, "{delay} {seed}: {found:?}");
            // The noisier records do not separate all of it from an actuator's lag, and report so.
            assert!(found.standard_error_s < 0.02 && found.evidence > 6.0, "{found:?}");
        }
    }
}

#[test]
fn a_lag_is_no_delay() {
    for servo in [0.0, 0.05, 0.1] {
        for (noise, sample_time) in [(0.002, 0.04), (0.002, 0.01), (0.01, 0.04), (0.01, 0.01)] {
            let found = estimate(&Drive { servo, noise, sample_time, ..DRIVE });
            assert_eq!(found.seconds, 0.0, "{servo} {noise} {sample_time}: {found:?}");
        }
    }
    // The lag that replaces a delay is the servo's, where the noise lets it be seen.
    let found = estimate(&Drive { servo: 0.05, sample_time: 0.01, ..DRIVE });
    assert!((found.lag_without_s - 0.05).abs() < 0.005, "{found:?}");
}

#[test]
fn where_noise_hides_which_is_which_delay_and_lag_are_one() {
    for seed in 1..5 {
        let found =
            estimate(&Drive { delay: 0.12, servo: 0.05, noise: 0.01, sample_time: 0.01, seed });
        // Left out, or between the delay and the delay with the whole lag.
        let between = (0.11..=0.18).contains(&found.seconds);
        assert!(found.seconds == 0.0 || between, "{found:?}");
    }
}

/// A servo's lag that the noise hides is taken into the delay. The stated error covers that: over
/// seeds, sample times and amounts of noise, the truth lies within two standard errors as often as it
/// should.
#[test]
fn the_stated_error_holds_what_a_lag_can_replace() {
    let (mut inside, mut all, mut widest) = (0, 0, 0.0_f64);
    for seed in 1..=6 {
        for (noise, sample_time) in [(0.002, 0.04), (0.01, 0.01), (0.02, 0.02)] {
            let drive = Drive { delay: 0.12, servo: 0.05, noise, sample_time, seed };
            let found = estimate(&drive);
            let error = (found.estimate_s - 0.12).abs();
            all += 1;
            inside += usize::from(error <= 2.0 * found.standard_error_s + 1e-3);
            if found.seconds > 0.0 {
                widest = widest.max(found.standard_error_s);
            }
            if error > 2.0 * found.standard_error_s + 1e-3 {
                println!("{noise} {sample_time} {seed}: {found:?}");
            }
        }
    }
    println!("{inside} of {all} within two standard errors, the widest {widest:.3} s");
    assert!(inside as f64 >= 0.9 * f64::from(all as u32), "{inside} of {all}");
    assert!(widest < 0.06, "{widest}");
}

/// The drives in the repository; none of them has a delay in addition to the servo's lag.
fn recorded(sample_time_s: f64) -> DriveLog {
    let text = std::fs::read("../examples/drives/multibody/drive.csv").unwrap();
    let options = LogOptions {
        input: Some("steering_command_rad".into()),
        steering_ratio: Some(1.0),
        sample_time_s: Some(sample_time_s),
        ..LogOptions::default()
    };
    read_log(&[("drive.csv".to_owned(), text)], &options).unwrap()
}

#[test]
fn a_multi_body_vehicle_with_a_servo_has_none() {
    for ts in [0.02, 0.04] {
        let log = recorded(ts);
        let found = estimate_delay(&data(&(ts, log.input.clone(), log.output.clone()))).unwrap();
        assert_eq!(found.seconds, 0.0, "{found:?}");
        // Its servo follows with 0.05 s.
        assert!((0.035..0.075).contains(&found.lag_without_s), "{found:?}");
        // The same drive, the gyro three samples late.
        let n = log.len();
        let late = (ts, log.input[3..].to_vec(), log.output[..n - 3].to_vec());
        let found = estimate_delay(&data(&late)).unwrap();
        assert!((found.seconds - 3.0 * ts).abs() < 0.005, "{found:?}");
    }
}

#[test]
fn scale_offset_and_segments_do_not_matter() {
    let (ts, u, y) = record(Drive { delay: 0.12, servo: 0.05, ..DRIVE }, 90.0);
    let whole = estimate_delay(&data(&(ts, u.clone(), y.clone()))).unwrap();
    let moved = |x: &[f64], k: f64, c: f64| x.iter().map(|x| k * x + c).collect::<Vec<_>>();
    let other = estimate_delay(&data(&(ts, moved(&u, -57.0, 3.0), moved(&y, 1e-3, 0.2)))).unwrap();
    assert!((whole.seconds - other.seconds).abs() < 1e-4, "{whole:?} {other:?}");
    let cuts = [0, 300, 420, 900, 1600, u.len()];
    let segments = cuts.windows(2).map(|w| {
        // The offsets of the segments differ, as after a change of the sensor's zero.
        let y = moved(&y[w[0]..w[1]], 1.0, 0.01 * w[0] as f64);
        Segment::new(row(&u[w[0]..w[1]]), row(&y))
    });
    let cut = estimate_delay(&DataSet::new(ts, segments.collect()).unwrap()).unwrap();
    assert!((whole.seconds - cut.seconds).abs() < 0.004, "{whole:?} {cut:?}");
}

#[test]
fn what_cannot_be_estimated_is_refused() {
    let (ts, u, y) = record(DRIVE, 5.0);
    let short = data(&(ts, u[..100].to_vec(), y[..100].to_vec()));
    assert!(matches!(estimate_delay(&short), Err(Error::TooFewSamples { got: 100, .. })));
    let both = Mat::from_fn(2, u.len(), |i, k| if i == 0 { u[k] } else { y[k] });
    let two = DataSet::single(ts, both, row(&y)).unwrap();
    assert!(matches!(estimate_delay(&two), Err(Error::Data { .. })));
    // Neither a dead input nor one without information leads to a delay, a panic or a number that is
    // none.
    let mut random = Random(5);
    let noise: Vec<f64> = (0..2000).map(|_| random.normal()).collect();
    for input in [vec![0.0; 2000], vec![1e300; 2000], noise.iter().map(|x| x * 1e-300).collect()] {
        if let Ok(found) = estimate_delay(&data(&(ts, input, noise.clone()))) {
            assert!(found.seconds == 0.0 && !found.estimate_s.is_nan(), "{found:?}");
        }
    }
    let unrelated: Vec<f64> = (0..2000).map(|_| random.normal()).collect();
    let found = estimate_delay(&data(&(ts, unrelated, noise))).unwrap();
    assert_eq!(found.seconds, 0.0, "{found:?}");
}

#[test]
fn identification_takes_the_delay_and_reports_it() {
    let (ts, u, y) = record(Drive { delay: 0.12, ..DRIVE }, 120.0);
    let drive = recording(ts, u, y);
    let options = |delay_s| IdentifyOptions { order: Some(2), delay_s, ..Default::default() };
    let without = identify(&drive, &options(Some(0.0))).unwrap().plant;
    let found = identify(&drive, &options(None)).unwrap();
    let plant = found.plant;
    assert!((plant.input_delay_s - 0.12).abs() < 0.01, "{}", plant.input_delay_s);
    assert!(plant.evidence.warnings.iter().any(|w| w.contains("pure delay")));
    let fit = plant.evidence.fit.validation;
    let plain = without.evidence.fit.validation;
    assert!(fit > plain + 0.3 && fit > 98.0, "{plain} {fit}");
    // The traces show what was steered when it was steered.
    assert_eq!(found.traces.steering_rad, drive.input);
    let given = identify(&drive, &options(Some(0.12))).unwrap().plant;
    assert_eq!(given.input_delay_s, 0.12);
    assert!((given.evidence.fit.validation - fit).abs() < 0.3);
    for wrong in [-0.1, f64::NAN, 5.0] {
        assert!(matches!(identify(&drive, &options(Some(wrong))), Err(Error::Option { .. })));
    }
}

/// At high frequencies; at low ones the model takes over what a longer delay would change.
#[test]
fn an_estimated_delay_widens_the_phase_and_a_stated_one_does_not() {
    let (ts, u, y) = record(Drive { delay: 0.12, servo: 0.05, ..DRIVE }, 120.0);
    let drive = recording(ts, u, y);
    let options = |delay_s| IdentifyOptions { order: Some(2), delay_s, ..Default::default() };
    let found = identify(&drive, &options(None)).unwrap().plant;
    let stated = identify(&drive, &options(Some(found.input_delay_s))).unwrap().plant;
    let error_s = found.evidence.delay.as_ref().unwrap().standard_error_s.unwrap();
    let added = |hz: f64| {
        let [with, without] = [&found, &stated]
            .map(|plant| plant.uncertainty.as_ref().unwrap().errors_at(hz).unwrap()[1]);
        (with * with - without * without).max(0.0).sqrt() / (std::f64::consts::TAU * hz * error_s)
    };
    let (low, high) = (added(0.1), added(10.0));
    assert!(high > 0.1 && high <= 1.0, "{high} of the delay's standard error at 10 Hz");
    assert!(low < 0.5 * high, "{low} at 0.1 Hz, {high} at 10 Hz");
}
