//! Drives of vehicles that are written apart from the model: steps of a millisecond, an engine with a torque curve and
//! gears or an electric motor with a limited power, a turbocharger, engine drag, brake hydraulics, hills, a driver who
//! follows a reference with a PI controller, and a log of quantised signals with noise.

use std::collections::VecDeque;
use std::fmt::Write;

const STEP: f64 = 0.001;
const GRAVITY: f64 = 9.80665;

pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x51);
        random.uniform();
        random
    }

    /// From 0 to 1.
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// What turns a pedal or a command into an acceleration.
#[derive(Debug, Clone)]
pub(super) enum Drive {
    /// Acceleration per accelerator, m/s², or per command: linear.
    Linear(f64),
    /// Combustion engine: largest torque, Nm; ratios of the gears to the wheel's radius, 1/m.
    Engine { torque_nm: f64, ratios: Vec<f64> },
    /// Electric motor: largest force, N, and power, W.
    Motor { force_n: f64, power_w: f64 },
}

#[derive(Debug, Clone)]
pub(super) struct Car {
    pub(super) drive: Drive,
    /// Whether the input is an acceleration command, without a brake.
    pub(super) is_commanded: bool,
    pub(super) mass_kg: f64,
    pub(super) lag_s: f64,
    pub(super) delay_s: f64,
    pub(super) brake_mps2: f64,
    pub(super) brake_lag_s: f64,
    pub(super) brake_delay_s: f64,
    pub(super) resistance_mps2: f64,
    pub(super) drag_per_m: f64,
    /// Exponent of the pedal: 1 is linear.
    pub(super) pedal: f64,
    /// Standard deviation of the grade.
    pub(super) hills: f64,
    /// Standard deviation of the noise of the speed, and its quantum, m/s.
    pub(super) noise_mps: f64,
    pub(super) quantum_mps: f64,
    pub(super) logs_grade: bool,
    pub(super) logs_gear: bool,
    pub(super) least_reference_mps: f64,
    pub(super) largest_reference_mps: f64,
}

impl Car {
    pub(super) fn linear() -> Self {
        Self {
            drive: Drive::Linear(3.2),
            is_commanded: false,
            mass_kg: 1500.0,
            lag_s: 0.35,
            delay_s: 0.13,
            brake_mps2: 9.0,
            brake_lag_s: 0.12,
            brake_delay_s: 0.06,
            resistance_mps2: 0.2,
            drag_per_m: 4e-4,
            pedal: 1.0,
            hills: 0.01,
            noise_mps: 0.03,
            quantum_mps: 0.01,
            logs_grade: false,
            logs_gear: false,
            least_reference_mps: 8.0,
            largest_reference_mps: 28.0,
        }
    }

    /// A usual vehicle: engine, motor or acceleration command, in turn.
    pub(super) fn usual(seed: u64) -> Self {
        let mut random = Random::new(1000 + seed);
        let mut r = |low, high| random.between(low, high);
        let mass_kg = r(1100.0, 2200.0);
        let drive = match seed % 3 {
            0 => Drive::Engine {
                torque_nm: mass_kg * r(0.1, 0.2),
                ratios: [13.0, 7.6, 4.9, 3.6, 2.9, 2.4].map(|x| x / 0.31).to_vec(),
            },
            1 => Drive::Motor { force_n: mass_kg * r(3.5, 6.0), power_w: mass_kg * r(50.0, 110.0) },
            _ => Drive::Linear(r(0.85, 1.1)),
        };
        Self {
            drive,
            is_commanded: seed % 3 == 2,
            mass_kg,
            lag_s: r(0.15, 0.5),
            delay_s: r(0.05, 0.25),
            brake_mps2: r(7.0, 12.0),
            brake_lag_s: r(0.08, 0.2),
            brake_delay_s: r(0.03, 0.1),
            resistance_mps2: r(0.1, 0.2),
            drag_per_m: r(2.2e-4, 5e-4),
            pedal: r(0.85, 1.15),
            hills: r(0.005, 0.02),
            noise_mps: r(0.01, 0.05),
            quantum_mps: [0.0, 0.01, 1.0 / 36.0][(seed % 7 % 3) as usize],
            logs_grade: seed.is_multiple_of(2),
            logs_gear: seed.is_multiple_of(6),
            least_reference_mps: 4.0,
            largest_reference_mps: r(20.0, 34.0),
        }
    }

    /// Traction, m/s², and the gear.
    fn traction(&self, pedal: f64, speed: f64, gear: &mut usize) -> f64 {
        let v = speed.max(1.0);
        match &self.drive {
            Drive::Linear(gain) => gain * pedal,
            Drive::Motor { force_n, power_w } => {
                let force = force_n.min(power_w / v);
                // Some recuperation where the pedal is released.
                (force * pedal.powf(self.pedal) - 0.02 * force_n * (1.0 - pedal)) / self.mass_kg
            }
            Drive::Engine { torque_nm, ratios } => {
                // rad/s of the engine at which gears change.
                let (up, down) = (330.0, 150.0);
                while *gear + 1 < ratios.len() && v * ratios[*gear] > up {
                    *gear += 1;
                }
                while *gear > 0 && v * ratios[*gear] < down {
                    *gear -= 1;
                }
                let turning = v * ratios[*gear];
                let curve = 1.0 - ((turning - 300.0) / 450.0).powi(2);
                let torque =
                    torque_nm * curve * pedal.powf(self.pedal) - 0.06 * torque_nm * (1.0 - pedal);
                torque * ratios[*gear] / self.mass_kg
            }
        }
    }

    /// A drive at 50 Hz, as CSV.
    pub(super) fn drive(&self, seed: u64, seconds: f64) -> String {
        let mut random = Random::new(seed);
        let pedal_name = if self.is_commanded {
            "acceleration_command_mps2"
        } else {
            "accelerator [1],brake [1]"
        };
        let mut log = format!("time_s,{pedal_name},speed_mps");
        for (is_logged, name) in [(self.logs_grade, ",grade [%]"), (self.logs_gear, ",gear")] {
            log += if is_logged { name } else { "" };
        }
        log.push('\n');
        let mut motion = Motion::new(self, 12.0);
        let mut integral = 0.0_f64;
        let (mut hill, mut wind) = (self.hills * random.normal(), 0.0_f64);
        let (mut reference, mut wanted, mut until) = (12.0, 12.0, 0.0);
        let (mut pedal, mut braking) = (0.0_f64, 0.0_f64);
        // The foot follows in a tenth of a second.
        let (mut pedal_wanted, mut braking_wanted) = (0.0_f64, 0.0_f64);
        for k in 0..(seconds / STEP) as usize {
            let t = k as f64 * STEP;
            if t >= until {
                until = t + random.between(3.0, 14.0);
                wanted = random.between(self.least_reference_mps, self.largest_reference_mps);
            }
            // The driver acts every 20 ms.
            if k.is_multiple_of(20) {
                reference += (wanted - reference).clamp(-0.05, 0.03);
                let speed = motion.speed;
                let error = reference - speed;
                integral = (integral + 0.02 * 0.15 * error).clamp(-1.0, 2.0);
                let acceleration =
                    (0.9 * error + integral + 0.08 * random.normal()).clamp(-4.0, 3.0);
                if self.is_commanded {
                    pedal = acceleration;
                } else if acceleration > 0.0 {
                    pedal_wanted = (acceleration / 3.0 + 0.002 * speed).clamp(0.0, 1.0);
                    braking_wanted = 0.0;
                } else {
                    pedal_wanted = 0.0;
                    braking_wanted = (-acceleration / self.brake_mps2).clamp(0.0, 1.0);
                }
            }
            if !self.is_commanded {
                pedal += STEP * (pedal_wanted - pedal) / 0.1;
                braking += STEP * (braking_wanted - braking) / 0.1;
            }
            if k.is_multiple_of(20) {
                let measured = motion.speed + self.noise_mps * random.normal();
                let measured = match self.quantum_mps > 0.0 {
                    true => (measured / self.quantum_mps).round() * self.quantum_mps,
                    false => measured,
                };
                write!(log, "{t:.2},{pedal:.5}").unwrap();
                if !self.is_commanded {
                    write!(log, ",{braking:.5}").unwrap();
                }
                write!(log, ",{:.5}", measured.max(0.0)).unwrap();
                if self.logs_grade {
                    write!(log, ",{:.4}", 100.0 * hill).unwrap();
                }
                if self.logs_gear {
                    write!(log, ",{}", motion.gear + 1).unwrap();
                }
                log.push('\n');
            }
            // A hill lasts some 150 m, a gust 4 s.
            let share = STEP * motion.speed / 150.0;
            hill += -share * hill + self.hills * (2.0 * share).sqrt() * random.normal();
            wind += -STEP * wind / 4.0 + 0.05 * (2.0 * STEP / 4.0).sqrt() * random.normal();
            motion.advance(self, pedal, braking, hill, wind);
        }
        log
    }

    /// From the pedal or command to the acceleration at a constant speed, as real and imaginary part, by a small sine; with
    /// the number of the gear after accelerating to that speed, and the steady pedal.
    pub(super) fn response(&self, speed: f64, frequency_hz: f64) -> ([f64; 2], i64, f64) {
        let mut gear = 0;
        let resistance = |speed: f64| self.resistance_mps2 + self.drag_per_m * speed * speed;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let is_below = self.traction(middle, speed, &mut gear) < resistance(speed);
            if is_below { low = middle } else { high = middle }
        }
        let steady = 0.5 * (low + high);
        let traction = self.traction(steady, speed, &mut gear);
        let (mut drive, mut boost, mut now) = (traction, traction, speed);
        let delay_s = (self.delay_s / STEP).round() * STEP;
        let period = (1.0 / frequency_hz / STEP).round() as usize;
        let omega = std::f64::consts::TAU / (period as f64 * STEP);
        let (settled, cycles) = (10_000_usize.div_ceil(period) * period, 4);
        let size = 0.02 * steady;
        let mut sums = [0.0; 2];
        for k in 0..settled + cycles * period {
            let t = k as f64 * STEP;
            let pedal = steady + size * (omega * (t - delay_s)).sin();
            let traction = self.traction(pedal, now, &mut gear);
            boost += STEP * (traction - boost) / 0.8;
            let has_turbo = matches!(self.drive, Drive::Engine { .. });
            let traction = if has_turbo { 0.9 * traction + 0.1 * boost } else { traction };
            drive += STEP * (traction - drive) / self.lag_s;
            let acceleration = drive - resistance(now);
            now += STEP * acceleration;
            if k >= settled {
                sums[0] += acceleration * (omega * t).cos();
                sums[1] -= acceleration * (omega * t).sin();
            }
        }
        // The pedal is the imaginary part of size·e^{jωt}: the response is j times the sum.
        let scale = 2.0 / (size * (cycles * period) as f64);
        ([-scale * sums[1], scale * sums[0]], gear as i64 + 1, steady)
    }
}

/// A car as it moves.
pub(super) struct Motion {
    /// m/s.
    pub(super) speed: f64,
    /// Place of the gear in the list of ratios.
    pub(super) gear: usize,
    drive: f64,
    brake: f64,
    boost: f64,
    drive_delay: VecDeque<f64>,
    brake_delay: VecDeque<f64>,
}

impl Motion {
    pub(super) fn new(car: &Car, speed: f64) -> Self {
        let late = |delay: f64| VecDeque::from(vec![0.0; (delay / STEP).round().max(1.0) as usize]);
        Self {
            speed,
            gear: 2,
            drive: 0.0,
            brake: 0.0,
            boost: 0.0,
            drive_delay: late(car.delay_s),
            brake_delay: late(car.brake_delay_s),
        }
    }

    /// A millisecond; `grade` is the tangent of the angle of the road, `push` an acceleration by the wind, m/s².
    pub(super) fn advance(&mut self, car: &Car, pedal: f64, braking: f64, grade: f64, push: f64) {
        self.drive_delay.push_back(pedal);
        self.brake_delay.push_back(braking);
        let pedal = self.drive_delay.pop_front().unwrap_or_default();
        let braking = self.brake_delay.pop_front().unwrap_or_default();
        let traction = car.traction(pedal, self.speed, &mut self.gear);
        // A turbocharger builds up a tenth of the torque later.
        let has_turbo = matches!(car.drive, Drive::Engine { .. });
        self.boost += STEP * (traction - self.boost) / 0.8;
        let traction = if has_turbo { 0.9 * traction + 0.1 * self.boost } else { traction };
        self.drive += STEP * (traction - self.drive) / car.lag_s;
        self.brake += STEP * (car.brake_mps2 * braking - self.brake) / car.brake_lag_s;
        let resistance = car.resistance_mps2 + car.drag_per_m * self.speed * self.speed;
        let gravity = GRAVITY * grade.atan().sin();
        let slowing = if self.speed > 0.05 { resistance + self.brake } else { 0.0 };
        self.speed = (self.speed + STEP * (self.drive - slowing - gravity + push)).max(0.0);
    }
}
