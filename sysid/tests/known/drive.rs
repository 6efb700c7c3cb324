//! A simulated drive, whose delay and lag are known.

use super::Random;
use std::collections::VecDeque;
use std::fmt::Write;

/// A second-order yaw response with a zero (6 rad/s, damping 0.8) behind a servo's lag and a pure
/// delay, in steps of half a millisecond. The command goes smoothly to random values and is held over
/// each sample; the gyro's noise is white.
#[derive(Debug, Clone, Copy)]
pub struct Drive {
    /// Sample time, s.
    pub sample_time: f64,
    /// Pure delay, s.
    pub delay: f64,
    /// Time constant of the servo, s.
    pub servo: f64,
    /// Standard deviation of the gyro's noise, rad/s.
    pub noise: f64,
    /// Of the random values and the noise.
    pub seed: u64,
}

/// What was recorded: road-wheel angle, rad, and yaw rate, rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Sample time, s.
    pub sample_time: f64,
    /// Commanded road-wheel angle, rad.
    pub steering: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate: Vec<f64>,
}

impl Drive {
    /// Drives for so many samples.
    #[must_use]
    pub fn record(&self, samples: usize) -> Recording {
        const FINE: f64 = 5e-4;
        let ts = self.sample_time;
        let per_sample = (ts / FINE).round() as usize;
        let mut random = Random(self.seed);
        let mut line = VecDeque::from(vec![0.0; (self.delay / FINE).round() as usize]);
        let (mut level, mut command, mut wheel, mut x) = (0.0, 0.0, 0.0, [0.0, 0.0]);
        let (mut steering, mut yaw_rate) = (Vec::new(), Vec::new());
        for k in 0..samples {
            if k % (0.6 / ts) as usize == 0 {
                level = 0.03 * random.normal();
            }
            command += (1.0 - (-ts / 0.15).exp()) * (level - command);
            steering.push(command);
            yaw_rate.push(x[0] + self.noise * random.normal());
            for _ in 0..per_sample {
                line.push_back(command);
                let late = line.pop_front().unwrap_or_default();
                wheel += if self.servo > 0.0 { FINE / self.servo } else { 1.0 } * (late - wheel);
                let slope = [x[1] + 25.0 * wheel - 9.6 * x[0], 180.0 * wheel - 36.0 * x[0]];
                x = [x[0] + FINE * slope[0], x[1] + FINE * slope[1]];
            }
        }
        Recording { sample_time: ts, steering, yaw_rate }
    }
}

impl Recording {
    /// As a logger writes it, with channels that are not needed.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "time_s,roadwheel_command_rad,yaw_rate_radps,speed_mps,throttle_1,lateral_acceleration_mps2\n",
        );
        for (k, (u, y)) in self.steering.iter().zip(&self.yaw_rate).enumerate() {
            let t = k as f64 * self.sample_time;
            let speed = 15.0 + 0.1 * (0.05 * t).sin();
            let _ = writeln!(text, "{t:.3},{u:.7},{y:.7},{speed:.4},0.31,{:.5}", speed * y);
        }
        text
    }
}
