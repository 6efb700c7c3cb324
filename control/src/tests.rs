//! The sampled loop against theory and against the models that run in the FMUs.

use crate::closed_loop::feedforward::{Advice, ramp_lag};
use crate::closed_loop::margins::{controller, margins};
use crate::closed_loop::metrics::metrics;
use crate::closed_loop::simulate::{Excitation, Simulator};
use crate::design;
use crate::design::options::DesignOptions;
use crate::plants::design_plant::DesignPlant;
use crate::plants::dynamics::Dynamics;
use crate::plants::sampled::Sampled;
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;
use steerwright_formats::{InputKind, PidGains, SourceFile};
use steerwright_models::{
    Continuous, IdentifiedData, IdentifiedModel, IdentifiedPlant, Pid, PidInput, PidParameters,
};

/// Yaw rate = gain · steering: yaw is a pure integrator.
fn integrator(gain: f64, delay: f64) -> DesignPlant {
    DesignPlant::from_matrices(&[-1.0], &[0.0], &[0.0], gain, delay).unwrap()
}

/// Yaw rate = gain/(τs + 1) · steering.
fn lag(gain: f64, tau: f64, delay: f64) -> DesignPlant {
    DesignPlant::from_matrices(&[-1.0 / tau], &[gain / tau], &[1.0], 0.0, delay).unwrap()
}

/// A two-mode plant with feedthrough.
const F: [f64; 4] = [-6.0, 11.0, -9.0, -5.0];
const G: [f64; 2] = [3.0, 8.0];
const H: [f64; 2] = [0.2, 1.4];
const D: f64 = 0.15;

fn pid() -> PidParameters {
    PidParameters {
        gains: PidGains {
            kp: 1.2,
            ki: 0.6,
            kd: 0.05,
            derivative_filter_time_s: 0.02,
            setpoint_weight_proportional: 0.8,
            setpoint_weight_derivative: 0.0,
            anti_windup_time_s: 0.5,
        },
        max_angle: 1e3,
        max_increment: 1e3,
        max_rate: 1e6,
        sample_time: 0.01,
        ..PidParameters::default()
    }
}

const STEP: Excitation =
    Excitation { step: 0.1, ramp: 0.0, feedforward: 0.0, offset: 0.0, until: 5.0, quiet: 0.0 };

fn proportional(kp: f64, sample_time: f64) -> PidParameters {
    PidParameters {
        gains: PidGains { kp, ki: 0.0, kd: 0.0, setpoint_weight_proportional: 1.0, ..pid().gains },
        sample_time,
        ..pid()
    }
}

/// A held unit of steering from tick 0 turns a lag by g·(s − τ·(1 − e^{−s/τ})), s the time since
/// the delay ended.
#[test]
fn sampling_splits_a_delay_exactly() {
    let (gain, tau, ts) = (4.0, 0.3, 0.02);
    for delay in [0.0, 0.02, 0.013, 0.0537, 0.1] {
        let plant = Sampled::new(&lag(gain, tau, delay), ts, 0.0).unwrap();
        let mut z = [0.0; 2];
        for k in 0..200_usize {
            let since = (k as f64 * ts - delay).max(0.0);
            let expected = gain * (since - tau * (1.0 - (-since / tau).exp()));
            assert!(
                (z[1] - expected).abs() < 1e-12,
                "delay {delay}, tick {k}: {} {expected}",
                z[1]
            );
            let old = f64::from(u8::from(k > plant.delay));
            let new = f64::from(u8::from(k >= plant.delay));
            let next = |i: usize| {
                plant.phi[2 * i] * z[0]
                    + plant.phi[2 * i + 1] * z[1]
                    + plant.gamma_old[i] * old
                    + plant.gamma_new[i] * new
            };
            z = [next(0), next(1)];
        }
    }
}

/// The step response of the design is that of the plant and the controller of the FMUs.
#[test]
fn the_simulation_is_the_loop_of_the_fmus() {
    let ts = 0.01;
    for (continuous, grid, delay, offset) in [
        (true, 0.01, 0.0, 0.0),
        (true, 0.01, 0.0137, 0.02),
        (true, 0.02, 0.05, 0.0),
        (false, 0.01, 0.0, 0.0),
        (false, 0.01, 0.0137, 0.02),
        (false, 0.005, 0.012, 0.0),
        (false, 0.005, 0.013, 0.02),
    ] {
        let (a, b) = steerwright_models::linear::discretize(
            &DMatrix::from_row_slice(2, 2, &F),
            &DMatrix::from_row_slice(2, 1, &G),
            grid,
        )
        .unwrap();
        let model = IdentifiedModel::new(IdentifiedData {
            sample_time: grid,
            a: a.transpose().as_slice().to_vec(),
            b: b.as_slice().to_vec(),
            c: H.to_vec(),
            d: D,
            k: vec![0.0; 2],
            continuous: continuous.then(|| Continuous {
                f: F.to_vec(),
                g: G.to_vec(),
                h: H.to_vec(),
            }),
            input: InputKind::Steering,
            delay,
            // A steering offset of the plant is an undelayed disturbance of the other sign.
            steering_offset: 0.0,
            yaw_rate_offset: 0.0,
            speed: 15.0,
            innovation_std: 0.0,
            sideslip: steerwright_models::Sideslip::default(),
        })
        .unwrap();
        let mut design = DesignPlant::from_matrices(&F, &G, &H, D, delay).unwrap();
        if !continuous {
            let Dynamics::Continuous(mut m) = design.dynamics else { unreachable!() };
            (m.state, m.input) = (a, DVector::from_column_slice(b.as_slice()));
            design.dynamics = Dynamics::Discrete { sample_time: grid, matrices: m };
        }
        let sampled = Sampled::new(&design, ts, 0.0).unwrap();
        let mut simulator = Simulator::default();
        let trace = simulator.run(&sampled, &pid(), &STEP);

        let mut plant = IdentifiedPlant::new(Arc::new(model));
        let mut controller = Pid::default();
        let input = |yaw_reference, yaw| PidInput {
            yaw_reference,
            yaw,
            steering_feedforward: 0.0,
            enabled: true,
            speed: 0.0,
        };
        controller.tick(&pid(), &input(0.0, 0.0));
        for k in 0..trace.time.len() {
            assert!(
                (plant.yaw() - trace.yaw[k]).abs() < 1e-9,
                "continuous {continuous}, grid {grid}, delay {delay}, tick {k}: {} {}",
                plant.yaw(),
                trace.yaw[k]
            );
            plant.steering_angle = controller.tick(&pid(), &input(0.1, plant.yaw())).steering_angle;
            plant.step(ts).unwrap();
        }
        // The offset at the plant's input ends in the integral action: −offset on the steering.
        if offset != 0.0 {
            let with_offset = Excitation { offset, until: 30.0, ..STEP };
            let trace = simulator.run(&sampled, &pid(), &with_offset);
            let last = trace.time.len() - 1;
            assert!((trace.steering[last] + offset).abs() < 1e-5);
            assert!((trace.yaw[last] - 0.1).abs() < 1e-5);
        }
    }
}

/// C(z) from the tick function itself: Σ u(k)·z⁻ᵏ after an impulse of yaw, |z| > 1.
#[test]
fn the_controller_response_is_that_of_the_tick_function() {
    let p = pid();
    for angle in [0.01, 0.1, 0.7, 2.0, 3.1] {
        let z = Complex::from_polar(1.05, angle);
        let mut controller_state = Pid::default();
        let input = |yaw| PidInput { yaw, enabled: true, ..PidInput::default() };
        controller_state.tick(&p, &input(0.0));
        let mut sum = Complex::new(0.0, 0.0);
        for k in 0..2000 {
            let yaw = if k == 0 { 1e-3 } else { 0.0 };
            let u = controller_state.tick(&p, &input(yaw)).steering_angle;
            sum += z.powi(-k) * u;
        }
        let expected = -controller(&p, z) * 1e-3;
        assert!((sum - expected).norm() < 1e-9 * expected.norm(), "{sum} {expected}");
    }
}

/// K/s with delay d·T, sampled: |L| = KT/(2·sin(ωT/2)), arg L = −π/2 − ωT·(d + ½).
#[test]
fn margins_of_a_sampled_integrator_with_delay() {
    let pi = std::f64::consts::PI;
    for (k, d, ts) in [(2.0, 10, 0.01), (0.5, 3, 0.05), (8.0, 0, 0.01)] {
        let plant = Sampled::new(&integrator(k, f64::from(d) * ts), ts, 0.0).unwrap();
        let m = margins(&plant, &proportional(1.0, ts));
        let late = f64::from(d) + 0.5;
        let crossover = 2.0 * (k * ts / 2.0).asin() / ts;
        let phase = pi / 2.0 - crossover * ts * late;
        let gain = 2.0 * (pi / (4.0 * late)).sin() / (k * ts);
        let close = |a: Option<f64>, b: f64| assert!((a.unwrap() / b - 1.0).abs() < 1e-6);
        close(m.crossover_radps, crossover);
        close(m.phase_margin_deg, phase.to_degrees());
        close(m.delay_margin_s, phase / crossover);
        close(m.gain_margin_db, 20.0 * gain.log10());
        let response = |w: f64| {
            Complex::from_polar(k * ts / (2.0 * (w / 2.0).sin()), -pi / 2.0 - w * late) + 1.0
        };
        let modulus =
            (1..=400_000).map(|i| response(pi * f64::from(i) / 4e5).norm()).fold(9.0, f64::min);
        assert!((m.modulus_margin / modulus - 1.0).abs() < 1e-6, "{} {modulus}", m.modulus_margin);
    }
}

/// (kp + ki/s)·g/s in the limit of short samples: |L| = 1 and arg L = −π + atan(kp·ω/ki).
#[test]
fn margins_of_pi_on_an_integrator_approach_the_continuous_ones() {
    let (g, kp, ki) = (5.0, 1.0, 8.0);
    let ts = 1e-4;
    let plant = Sampled::new(&integrator(g, 0.0), ts, 0.0).unwrap();
    let p = PidParameters {
        gains: PidGains { ki, ..proportional(kp, ts).gains },
        ..proportional(kp, ts)
    };
    let m = margins(&plant, &p);
    // |L|² = g²(kp²ω² + ki²)/ω⁴ = 1.
    let square = 0.5 * ((g * kp).powi(2) + ((g * kp).powi(4) + 4.0 * (g * ki).powi(2)).sqrt());
    let phase = (kp * square.sqrt() / ki).atan();
    assert!((m.crossover_radps.unwrap() / square.sqrt() - 1.0).abs() < 1e-3);
    assert!((m.phase_margin_deg.unwrap() / phase.to_degrees() - 1.0).abs() < 1e-3);
    // S = 1/(1 + L) = s²/(s² + g·kp·s + g·ki): |S|² = x²/((1−x)² + 4ζ²x) with x = (ω/ωn)² and
    // ζ = ½·√(g·kp²/ki) = 0.40.
    let zeta2 = 0.25 * g * kp * kp / ki;
    let s2 = (1..200_000)
        .map(|i| f64::from(i) * 1e-3)
        .map(|x| x * x / ((1.0 - x).powi(2) + 4.0 * zeta2 * x))
        .fold(0.0, f64::max);
    assert!((m.modulus_margin * s2.sqrt() - 1.0).abs() < 1e-3, "{}", m.modulus_margin);
}

/// Gain and delay margins are where the simulated loop begins to grow, and beyond them there are
/// none.
#[test]
fn margins_end_where_the_simulated_loop_grows() {
    let ts = 0.01;
    let design = DesignPlant::from_matrices(&F, &G, &H, D, 0.03).unwrap();
    let plant = Sampled::new(&design, ts, 0.0).unwrap();
    let m = margins(&plant, &pid());
    let factor = 10.0_f64.powf(m.gain_margin_db.unwrap() / 20.0);
    let grows = |plant: &Sampled, p: &PidParameters| {
        let e = Excitation { step: 1e-6, until: 60.0, ..STEP };
        let mut simulator = Simulator::default();
        let trace = simulator.run(plant, p, &e);
        let n = trace.yaw.len();
        let swing = |part: &[f64]| part.iter().map(|y| (y / 1e-6 - 1.0).abs()).fold(0.0, f64::max);
        n < 6001 || swing(&trace.yaw[n - 500..]) > swing(&trace.yaw[n / 2..n / 2 + 500])
    };
    for (share, unstable) in [(0.97, false), (1.03, true)] {
        let k = share * factor;
        let p = PidParameters {
            gains: PidGains { kp: k * 1.2, ki: k * 0.6, kd: k * 0.05, ..pid().gains },
            ..pid()
        };
        assert_eq!(grows(&plant, &p), unstable, "gain times {k}");
        assert_eq!(margins(&plant, &p).modulus_margin == 0.0, unstable);
        let delay = share * m.delay_margin_s.unwrap();
        let delayed = Sampled::new(&design, ts, delay).unwrap();
        assert_eq!(grows(&delayed, &pid()), unstable, "delay {delay}");
        assert_eq!(margins(&delayed, &pid()).modulus_margin == 0.0, unstable);
    }
}

/// kp on g/(τs + 1)/s: ωn² = g·kp/τ, ζ = ½/√(g·kp·τ), overshoot e^{−πζ/√(1−ζ²)}.
#[test]
fn a_second_order_loop_overshoots_as_the_textbook_says() {
    for (g, tau, kp) in [(4.0, 0.2, 1.0), (2.0, 0.5, 0.8)] {
        let ts = 2e-4;
        let plant = Sampled::new(&lag(g, tau, 0.0), ts, 0.0).unwrap();
        let mut simulator = Simulator::default();
        let m = metrics(simulator.run(&plant, &proportional(kp, ts), &STEP), 0.1, 2.0);
        let zeta = 0.5 / f64::sqrt(g * kp * tau);
        let expected = 100.0 * (-std::f64::consts::PI * zeta / f64::sqrt(1.0 - zeta * zeta)).exp();
        assert!((m.step.overshoot_percent / expected - 1.0).abs() < 0.005, "{zeta}");
    }
}

#[test]
fn limits_hold_at_every_tick() {
    let plant = Sampled::new(&lag(4.0, 0.1, 0.0), 0.01, 0.0).unwrap();
    let p = PidParameters { max_angle: 0.03, max_increment: 0.004, ..pid() };
    let mut simulator = Simulator::default();
    let m = metrics(simulator.run(&plant, &p, &STEP), 0.1, 2.0);
    assert!((m.step.largest_angle_rad - 0.03).abs() < 1e-12);
    assert!((m.step.largest_increment_rad - 0.004).abs() < 1e-12);
}

/// kp·(1 − b)/ki, with or without feedforward; what is advised leaves no error behind a reference whose
/// rate grows, as the heading of a clothoid does, and little behind one whose growth changes.
#[test]
fn preview_and_feedforward_leave_no_error_on_circle_and_clothoid() {
    let plant = DesignPlant::from_matrices(&F, &G, &H, D, 0.02).unwrap();
    let source = SourceFile::from_bytes("plant.json".as_ref(), b"");
    let options = DesignOptions { max_rate_radps: Some(1e3), ..DesignOptions::default() };
    let document = design(&plant, &source, &options).unwrap();
    let p = steerwright_models::files::pid_parameters(&document);
    let sampled = Sampled::new(&plant, p.sample_time, 0.0).unwrap();
    let theory = p.gains.kp * (1.0 - p.gains.setpoint_weight_proportional) / p.gains.ki;
    let measured = ramp_lag(plant.gain(), &sampled, &p);
    assert!((measured - theory).abs() < 1e-3 * theory, "{measured} {theory}");

    let advice = document.guidance;
    // Errors of yaw on a heading whose derivatives are known.
    type Heading<'a> = &'a dyn Fn(f64) -> [f64; 4];
    let errors = |heading: Heading<'_>, until: f64, feedforward_gain: f64, [g, j]: [f64; 2]| {
        let mut errors = Vec::new();
        let mut controller = Pid::default();
        let mut z = [0.0; 3];
        let mut u = vec![0.0; 8];
        let ticks = (until / p.sample_time) as usize;
        for k in 0..ticks {
            let t = k as f64 * p.sample_time;
            errors.push(heading(t)[0] - z[2]);
            let [yaw, rate, growth, jerk] = heading(t + advice.preview_time_s);
            let input = PidInput {
                yaw_reference: yaw + g * growth + j * jerk,
                yaw: z[2],
                // Curvature is the heading's rate over the speed.
                steering_feedforward: feedforward_gain * rate / plant.speed,
                enabled: true,
                speed: plant.speed,
            };
            u.insert(0, controller.tick(&p, &input).steering_angle);
            let (new, old) = (u[sampled.delay], u[sampled.delay + 1]);
            z = [0, 1, 2].map(|i| {
                let row = &sampled.phi[3 * i..3 * i + 3];
                row.iter().zip(&z).map(|(a, b)| a * b).sum::<f64>()
                    + sampled.gamma_old[i] * old
                    + sampled.gamma_new[i] * new
            });
            u.truncate(8);
        }
        errors
    };
    // In s²: 1e-3 s² on a road of 4 m/s² at 6 m/s³ (0.4 rad/s² of yaw) is 4e-4 rad.
    let clothoid = |t: f64| [0.5e-4 * t * t, 1e-4 * t, 1e-4, 0.0];
    let last = |f, gains| errors(&clothoid, 40.0, f, gains).pop().unwrap() / 1e-4;
    let f = advice.feedforward_gain_radm;
    let gains = [advice.yaw_acceleration_gain_s2, advice.yaw_jerk_gain_s3];
    let advised = last(f, gains);
    assert!(advised.abs() < 2e-3, "{advised}");
    assert!(last(plant.speed / plant.gain(), [0.0; 2]).abs() > 2e-2);

    // Bends of 4 s, one after the other.
    let bend = |t: f64| {
        let (sin, cos) = (0.5 * std::f64::consts::PI * t.max(0.0)).sin_cos();
        let w = 0.5 * std::f64::consts::PI;
        [1e-2 * (1.0 - cos) / w, 1e-2 * sin, 1e-2 * w * cos, -1e-2 * w * w * sin]
    };
    let rms = |f, gains| {
        let errors = errors(&bend, 20.0, f, gains);
        let late = &errors[errors.len() / 2..];
        (late.iter().map(|e| e * e).sum::<f64>() / late.len() as f64).sqrt()
    };
    let without = Advice::with_preview(&p, plant.gain(), plant.speed, advice.preview_time_s);
    let (with, without) = (rms(f, gains), rms(without.feedforward_gain, [0.0; 2]));
    let without_jerk = rms(f, [gains[0], 0.0]);
    assert!(with < 0.2 * without && with < 0.5 * without_jerk, "{with:e} {without:e}");
}
