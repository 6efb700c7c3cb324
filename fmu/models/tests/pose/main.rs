//! The pose estimator on drives whose truth is known.
#![allow(clippy::unwrap_used)]

mod drive;
mod fixes;

use drive::{DRIVE, Drive, H, Moment, Truth};
use proptest::prelude::*;
use steerwright_formats::{Gnss, InitialUncertainty, SensorNoise};
use steerwright_models::noise::gaussian;
use steerwright_models::quadrature::Pose;
use steerwright_models::{PoseEstimator, PoseInput, PoseParameters, Sideslip};

fn step(estimator: &mut PoseEstimator, input: PoseInput) {
    estimator.input = input;
    estimator.step(H).unwrap();
}

fn error(estimator: &PoseEstimator, truth: &Truth) -> [f64; 5] {
    let [x, y, yaw, bias, sideslip] = estimator.mean();
    let of_motion = [x - truth.x, y - truth.y, yaw - truth.yaw];
    [of_motion[0], of_motion[1], of_motion[2], bias - truth.bias, sideslip - truth.sideslip]
}

/// eᵀ·P⁻¹·e, by elimination.
fn nees(estimator: &PoseEstimator, truth: &Truth) -> f64 {
    let (e, mut a) = (error(estimator, truth), estimator.covariance());
    let mut b = e;
    for i in 0..5 {
        for j in i + 1..5 {
            let factor = a[j][i] / a[i][i];
            let row = a[i];
            a[j].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
            b[j] -= factor * b[i];
        }
    }
    for i in (0..5).rev() {
        let rest: f64 = (i + 1..5).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - rest) / a[i][i];
    }
    b.iter().zip(e).map(|(x, y)| x * y).sum()
}

fn away(estimator: &PoseEstimator, truth: &Truth) -> f64 {
    (estimator.x() - truth.x).hypot(estimator.y() - truth.y)
}

/// Normalised estimation error squared (Bar-Shalom, section 5.4): χ² with five degrees of freedom
/// at each time, over drives whose noise is what the filter assumes, for centimetre fixes and metre
/// ones.
#[test]
fn errors_are_as_large_as_the_filter_says() {
    const SEEDS: i32 = 150;
    for gnss_std in [0.02, 1.0] {
        let times: Vec<usize> = (1..=8).map(|k| k * 250 - 1).collect();
        let mut sums = vec![0.0; times.len()];
        let mut outliers = 0;
        for seed in 0..SEEDS {
            let drive = Drive { seed, gnss_std, ..DRIVE };
            let mut estimator = drive.estimator();
            for (k, moment) in drive.moments(2000, 10).iter().enumerate() {
                step(&mut estimator, moment.input);
                outliers += u32::from(estimator.is_aligning());
                if let Some(i) = times.iter().position(|t| *t == k) {
                    sums[i] += nees(&estimator, &moment.truth);
                }
            }
        }
        assert_eq!(outliers, 0, "a filter that is right was taken for wrong");
        let n = f64::from(SEEDS);
        let means: Vec<f64> = sums.iter().map(|sum| sum / n).collect();
        println!("NEES at {gnss_std} m: {means:.2?}");
        // Mean 5 and variance 10 a drive; four standard errors.
        let bound = 4.0 * (10.0 / n).sqrt();
        assert!(means.iter().all(|mean| (mean - 5.0).abs() < bound), "{means:?}");
        let overall = means.iter().sum::<f64>() / means.len() as f64;
        assert!((overall - 5.0).abs() < 0.5, "{overall}");
    }
}

/// A fix that arrives late gives the estimate of one that was there in time: to the last bit once
/// the readings since have been caught up, here in drop-outs as long as the latency.
#[test]
fn latency_is_made_up_for_exactly() {
    let lag = 13;
    let late = Drive {
        parameters: PoseParameters {
            gnss: Gnss { latency_s: lag as f64 * H, ..DRIVE.parameters.gnss },
            ..DRIVE.parameters
        },
        ..DRIVE
    };
    let prompt = Drive {
        parameters: PoseParameters {
            gnss: Gnss { latency_s: 0.0, ..DRIVE.parameters.gnss },
            ..DRIVE.parameters
        },
        ..DRIVE
    };
    let mut moments = late.moments(600, lag);
    // Fixes come in the first half of each second alone.
    for k in 0..moments.len() {
        if (k + 1) % 100 > 50 {
            moments[k].input.gnss_fix_count = moments[k - 1].input.gnss_fix_count;
        }
    }
    let (mut one, mut other) = (late.estimator(), prompt.estimator());
    let mut compared = 0;
    for k in 0..moments.len() - lag {
        step(&mut one, moments[k].input);
        // The other has the fixes when they are valid.
        let fix = moments[k + lag].input;
        let Moment { input: PoseInput { yaw_rate, speed, .. }, .. } = moments[k];
        step(&mut other, PoseInput { yaw_rate, speed, ..fix });
        if moments[k].input.gnss_fix_count == fix.gnss_fix_count {
            assert_eq!(one.mean(), other.mean(), "step {k}");
            assert_eq!(one.covariance(), other.covariance(), "step {k}");
            compared += 1;
        } else if k > lag {
            assert_ne!(one.mean(), other.mean(), "step {k}");
        }
    }
    assert!(compared > 200, "{compared}");
}

/// The estimate is of the centre of gravity; an antenna taken for it would be off by its arm.
#[test]
fn the_antenna_is_not_the_centre_of_gravity() {
    let arm = PoseParameters {
        gnss: Gnss { antenna_x_m: -1.5, antenna_y_m: 0.8, ..DRIVE.parameters.gnss },
        ..DRIVE.parameters
    };
    let drive = Drive { parameters: arm, noise: false, ..DRIVE };
    let moments = drive.moments(1500, 10);
    let mut estimator = drive.estimator();
    let ignorant = Drive {
        parameters: PoseParameters {
            gnss: Gnss { antenna_x_m: 0.0, antenna_y_m: 0.0, ..arm.gnss },
            ..arm
        },
        ..drive
    };
    let mut other = ignorant.estimator();
    for moment in &moments {
        step(&mut estimator, moment.input);
        step(&mut other, moment.input);
    }
    let truth = moments[moments.len() - 1].truth;
    assert!(away(&estimator, &truth) < 1e-3, "{}", away(&estimator, &truth));
    assert!(away(&other, &truth) > 1.0, "{}", away(&other, &truth));
}

/// A vehicle that stands does not turn: its yaw stays, however long, and its gyro reads the bias, as exactly as its noise
/// allows. One that turns without turning its wheels is followed.
#[test]
fn the_gyro_of_a_vehicle_that_stands_reads_its_bias() {
    const SEEDS: i32 = 200;
    let (bias, seconds) = (0.01, 20.0_f64);
    let p = PoseParameters {
        noise: SensorNoise { yaw_rate_bias_density: 0.0, ..DRIVE.parameters.noise },
        ..DRIVE.parameters
    };
    let drive = Drive { parameters: p, ..DRIVE };
    let deviation = p.noise.yaw_rate_density / H.sqrt();
    let mut squares = 0.0;
    for seed in 0..SEEDS {
        let mut estimator = drive.estimator();
        let yaw = estimator.yaw();
        for k in 0..(seconds / H) as u64 {
            let yaw_rate = bias + deviation * gaussian(seed, k);
            step(&mut estimator, PoseInput { yaw_rate, ..PoseInput::default() });
            assert_eq!(estimator.yaw(), yaw, "seed {seed}, step {k}");
        }
        let (variance, [.., found, _]) = (estimator.covariance()[3][3], estimator.mean());
        // That of the mean of all readings, and of what was known before.
        let known = p.initial.yaw_rate_bias_std_radps.powi(-2);
        let expected = 1.0 / (known + seconds / p.noise.yaw_rate_density.powi(2));
        assert!((variance / expected - 1.0).abs() < 1e-9, "{variance} {expected}");
        squares += (found - bias).powi(2) / variance;
        assert!((estimator.covariance()[2][2] - p.initial.yaw_std_rad.powi(2)).abs() < 1e-12);

        let before = estimator.yaw();
        for _ in 0..100 {
            step(&mut estimator, PoseInput { yaw_rate: 0.3 + bias, ..PoseInput::default() });
        }
        assert!((estimator.yaw() - before - 0.3).abs() < 0.01, "{}", estimator.yaw());
    }
    // Four standard errors, and the mean of two successive readings, of which each counts in both.
    let mean = squares / f64::from(SEEDS);
    assert!((mean - 1.0).abs() < 4.0 * (2.0 / f64::from(SEEDS)).sqrt(), "{mean}");
}

#[test]
fn the_bias_is_found() {
    let drive = Drive { noise: false, ..DRIVE };
    let mut estimator = drive.estimator();
    let bias = 0.02;
    for moment in drive.moments(3000, 10) {
        let yaw_rate = moment.input.yaw_rate + bias;
        step(&mut estimator, PoseInput { yaw_rate, ..moment.input });
    }
    let [.., found, _] = estimator.mean();
    assert!((found - bias).abs() < 5e-4, "{found}");
    assert!(estimator.covariance()[3][3].sqrt() < 2e-3);
}

/// A vehicle that slides more than stated, and fixes that are older than stated: both turn the course away from the yaw
/// by a share of the yaw rate, and an estimator that does not learn it is off to the side.
#[test]
fn the_sideslip_is_found() {
    let wrong_by = |sideslip: f64, older: f64| {
        let of_vehicle = Sideslip {
            per_yaw_rate: DRIVE.parameters.sideslip.per_yaw_rate + sideslip,
            ..DRIVE.parameters.sideslip
        };
        let vehicle = PoseParameters { sideslip: of_vehicle, ..DRIVE.parameters };
        let truth = Drive { noise: false, parameters: vehicle, ..DRIVE };
        let lag = ((DRIVE.parameters.gnss.latency_s + older) / H).round() as usize;
        let certain = PoseParameters {
            noise: SensorNoise { sideslip_per_yaw_rate_density: 0.0, ..DRIVE.parameters.noise },
            initial: InitialUncertainty {
                sideslip_per_yaw_rate_std_s: 0.0,
                ..DRIVE.parameters.initial
            },
            ..DRIVE.parameters
        };
        let [mut learns, mut does_not] =
            [DRIVE.parameters, certain].map(|parameters| Drive { parameters, ..DRIVE }.estimator());
        let (mut yaw_errors, mut found) = ([0.0_f64; 2], 0.0);
        for (k, moment) in truth.moments(4000, lag).iter().enumerate() {
            for (estimator, largest) in
                [&mut learns, &mut does_not].into_iter().zip(&mut yaw_errors)
            {
                step(estimator, moment.input);
                if k > 2000 {
                    *largest = largest.max((estimator.yaw() - moment.truth.yaw).abs());
                }
            }
            [.., found] = learns.mean();
        }
        (found, yaw_errors)
    };
    let (found, [learnt, stated]) = wrong_by(0.03, 0.0);
    assert!((found - 0.03).abs() < 3e-3, "{found}");
    assert!(learnt < 0.3 * stated, "{learnt} {stated}");
    let (found, [learnt, stated]) = wrong_by(0.0, 0.1);
    assert!((found + 0.1).abs() < 0.02, "{found}");
    assert!(learnt < 0.3 * stated, "{learnt} {stated}");
}

/// In a steady turn the course, not the yaw, is where the vehicle goes; neither is wrapped.
#[test]
fn course_is_yaw_and_sideslip() {
    let p = PoseParameters {
        sideslip: Sideslip { per_yaw_rate: -0.06, growth: -0.001, ..Sideslip::default() },
        ..PoseParameters::default()
    };
    let mut estimator = PoseEstimator::new(p).unwrap();
    estimator.start().unwrap();
    for _ in 0..2000 {
        let before = [estimator.x(), estimator.y()];
        step(&mut estimator, PoseInput { yaw_rate: 0.5, speed: 15.0, ..PoseInput::default() });
        let (dx, dy) = (estimator.x() - before[0], estimator.y() - before[1]);
        let middle = estimator.course() - 0.5 * 0.5 * H;
        assert!(steerwright_models::wrap_angle(dy.atan2(dx) - middle).abs() < 1e-9);
    }
    assert!((estimator.yaw() - 10.0).abs() < 1e-9);
    let sideslip = (0.06 + 0.001 * 7.5_f64.powi(2)) * 0.5;
    assert!((estimator.course() - estimator.yaw() + sideslip.atan()).abs() < 1e-12);
}

/// A vehicle of S(v) = b/v − κ·v goes from 5 to 25 m/s in a bend: dead reckoning with the law finds where it
/// is, with the S of one speed it does not.
#[test]
fn the_sideslip_follows_the_speed() {
    let (distance_rear, kappa, rate) = (1.5, 0.004, 0.15);
    let s = |v: f64| distance_rear / v - kappa * v;
    let law = Sideslip {
        per_yaw_rate: s(12.0),
        reference_speed: 12.0,
        distance_rear,
        ..Sideslip::default()
    };
    let off = |sideslip: Sideslip| {
        let mut estimator =
            PoseEstimator::new(PoseParameters { sideslip, ..PoseParameters::default() }).unwrap();
        estimator.input = PoseInput { yaw_rate: rate, speed: 5.0, ..PoseInput::default() };
        estimator.start().unwrap();
        let (mut x, mut y) = (0.0, 0.0);
        for k in 0..2000 {
            let t = f64::from(k) * H;
            // The same means of speed as the filter's.
            let v = 5.0 + t + 0.5 * H;
            let (course, half) = (rate * (t + 0.5 * H), 0.5 * rate * H);
            let chord = H * half.sin() / half;
            x += chord * (v * course.cos() - v * s(v) * rate * course.sin());
            y += chord * (v * course.sin() + v * s(v) * rate * course.cos());
            let input = PoseInput { yaw_rate: rate, speed: 5.0 + t + H, ..PoseInput::default() };
            step(&mut estimator, input);
        }
        assert!((estimator.yaw() - 3.0).abs() < 1e-9);
        let course = estimator.yaw() + (sideslip.at_speed(25.0).per_yaw_rate * rate).atan();
        assert!((estimator.course() - course).abs() < 1e-12);
        (estimator.x() - x).hypot(estimator.y() - y)
    };
    // The first step has no reading before it.
    assert!(off(law) < 1e-4, "{}", off(law));
    assert!(off(Sideslip { distance_rear: 0.0, ..law }) > 1.0);
}

/// The frame in which fixes are given does not matter.
fn in_another_frame(turn: f64, dx: f64, dy: f64) -> f64 {
    let drive = DRIVE;
    let (sin, cos) = turn.sin_cos();
    let there = |x: f64, y: f64| (dx + x * cos - y * sin, dy + x * sin + y * cos);
    let (initial_x, initial_y) = there(0.0, 0.0);
    let moved = PoseParameters {
        initial_pose: Pose { x: initial_x, y: initial_y, yaw: turn },
        ..DRIVE.parameters
    };
    let mut estimator = drive.estimator();
    let mut other = PoseEstimator::new(moved).unwrap();
    other.start().unwrap();
    let mut largest = 0.0_f64;
    for moment in drive.moments(300, 10) {
        step(&mut estimator, moment.input);
        let mut input = moment.input;
        (input.gnss_x, input.gnss_y) = there(input.gnss_x, input.gnss_y);
        step(&mut other, input);
        let (x, y) = there(estimator.x(), estimator.y());
        largest = largest
            .max((other.x() - x).hypot(other.y() - y))
            .max((other.yaw() - estimator.yaw() - turn).abs())
            .max((other.position_std() - estimator.position_std()).abs());
    }
    largest
}

/// What an estimator holds after a step that it took can be loaded again, whatever the readings.
#[test]
fn readings_near_the_largest_numbers_can_be_saved() {
    for (first, second, step) in [(-1e308, 1e308, 1e-3), (0.0, 1.0, 1e-309), (0.0, 0.0, 0.01)] {
        let mut estimator = PoseEstimator::new(PoseParameters {
            gnss: Gnss { latency_s: 0.1, ..PoseParameters::default().gnss },
            ..PoseParameters::default()
        })
        .unwrap();
        for reading in [first, second] {
            estimator.input.yaw_rate = reading;
            if estimator.step(step).is_err() {
                break;
            }
            PoseEstimator::restore(estimator.save()).unwrap();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn rotation_and_shift_change_nothing(turn in -9.0..9.0_f64, dx in -1e4..1e4_f64, dy in -1e4..1e4_f64) {
        prop_assert!(in_another_frame(turn, dx, dy) < 1e-7);
    }

    /// What was saved goes on to the last bit, wherever it was saved.
    #[test]
    fn saved_estimators_go_on(at in 0_usize..250, cold in any::<bool>()) {
        let mut p = DRIVE.parameters;
        if cold { p.initial.yaw_std_rad = 2.0 }
        let drive = Drive { parameters: p, ..DRIVE };
        let moments = drive.moments(300, 10);
        let mut one = drive.estimator();
        moments[..at].iter().for_each(|moment| step(&mut one, moment.input));
        let text = serde_json::to_string(&one.save()).unwrap();
        let mut other = PoseEstimator::restore(serde_json::from_str(&text).unwrap()).unwrap();
        for moment in &moments[at..] {
            step(&mut one, moment.input);
            step(&mut other, moment.input);
            prop_assert_eq!(one.mean(), other.mean());
        }
        prop_assert_eq!(one.covariance(), other.covariance());
    }

    /// Whatever comes: a finite estimate with a covariance that can be one, or an error.
    #[test]
    fn nothing_harms_it(
        inputs in prop::collection::vec(
            (prop::array::uniform5(any::<f64>()), any::<i32>(), 1e-9..20.0_f64), 1..60),
        latency in 0.0..10.0_f64,
    ) {
        let gnss = Gnss { latency_s: latency, ..DRIVE.parameters.gnss };
        let p = PoseParameters { gnss, ..DRIVE.parameters };
        let mut estimator = PoseEstimator::new(p).unwrap();
        estimator.start().unwrap();
        for ([gnss_x, gnss_y, gnss_std, yaw_rate, speed], gnss_fix_count, h) in inputs {
            estimator.input =
                PoseInput { gnss_x, gnss_y, gnss_std, gnss_fix_count, yaw_rate, speed };
            match estimator.step(h) {
                Err(error) => {
                    prop_assert!(!error.hint().is_empty());
                    return Ok(());
                }
                Ok(()) => {
                    prop_assert!(estimator.mean().iter().all(|x| x.is_finite()));
                    prop_assert!(estimator.course().is_finite());
                    prop_assert!(estimator.position_std() >= 0.0);
                }
            }
        }
    }
}

/// However small the steps, the past that is kept is bounded; long steps are taken whole.
#[test]
fn any_step_size() {
    let p = PoseParameters {
        gnss: Gnss { latency_s: 1.0, ..DRIVE.parameters.gnss },
        ..DRIVE.parameters
    };
    let mut estimator = PoseEstimator::new(p).unwrap();
    estimator.start().unwrap();
    for k in 0..30_000 {
        estimator.input = PoseInput {
            speed: 15.0,
            yaw_rate: 0.2,
            gnss_std: 1.0,
            gnss_fix_count: k / 10_000,
            ..PoseInput::default()
        };
        estimator.step(1e-4).unwrap();
    }
    let length = serde_json::to_string(&estimator.save()).unwrap().len();
    assert!(length < 300_000, "{length} characters");
    assert!(estimator.step(0.0).is_err() && estimator.step(f64::NAN).is_err());
    assert!(estimator.step(1e12).unwrap_err().to_string().contains("1000000000000 s"));
    estimator.step(30.0).unwrap();
}

#[test]
fn parameters_that_cannot_be_are_refused() {
    let refused = |p: PoseParameters| PoseEstimator::new(p).unwrap_err().to_string();
    let p = DRIVE.parameters;
    assert!(
        refused(PoseParameters { gnss: Gnss { latency_s: -0.1, ..p.gnss }, ..p })
            .contains("latency is -0.1")
    );
    assert!(
        refused(PoseParameters { gnss: Gnss { latency_s: 11.0, ..p.gnss }, ..p })
            .contains("0 to 10")
    );
    assert!(
        refused(PoseParameters { noise: SensorNoise { speed_density: f64::NAN, ..p.noise }, ..p })
            .contains("NaN")
    );
    assert!(
        refused(PoseParameters {
            initial: InitialUncertainty { yaw_std_rad: 4.0, ..p.initial },
            ..p
        })
        .contains("yaw")
    );
    assert!(
        refused(PoseParameters { initial_pose: Pose { x: f64::INFINITY, ..p.initial_pose }, ..p })
            .contains("initial x")
    );
    let sideslip = Sideslip { distance_rear: -1.0, ..p.sideslip };
    assert!(refused(PoseParameters { sideslip, ..p }).contains("rear axle is -1"));
}
