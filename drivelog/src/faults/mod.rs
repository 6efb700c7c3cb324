//! Faults of single channels, found on their own clocks before anything is resampled.
//!
//! A *spike* (or dropout) is a run of one to three samples that jumps away and back, by more than the channel
//! usually does from sample to sample (Hampel's identifier, see `docs/methods/logs.md`). A held command that
//! steps does not jump back; where it steps often, the upper percentile is the size of its steps.

mod freezes;
mod repeated;
mod spikes;

pub(crate) use freezes::{Freezes, Moving, Sampled};
pub(crate) use repeated::{Repeated, average};
pub(crate) use spikes::SpikeFilter;

#[cfg(test)]
mod tests {
    use super::spikes::Jumps;
    use super::*;
    use crate::signal::resolution;
    use crate::signal::tests::noise;

    fn spikes(time: &[f64], x: &[f64]) -> Vec<usize> {
        Jumps::from_samples(time, x).unwrap().spikes(time, x).into_iter().flatten().collect()
    }

    fn frozen(
        yaw_rate: Sampled<'_>,
        steering: Sampled<'_>,
        speed: Option<Sampled<'_>>,
    ) -> Vec<[f64; 2]> {
        let mut freezes = Freezes::default();
        freezes.note(yaw_rate.value, steering.value);
        let resolution = resolution(yaw_rate.value);
        freezes.find(Moving { yaw_rate, steering, speed, resolution }, None).1
    }

    fn clock(n: usize, period: f64) -> Vec<f64> {
        (0..n).map(|k| k as f64 * period).collect()
    }

    #[test]
    fn spikes_and_dropouts_are_found_and_nothing_else() {
        let mut seed = 3;
        let time = clock(6000, 0.01);
        let smooth: Vec<f64> =
            time.iter().map(|t| 0.2 * (2.0 * t).sin() + 0.002 * noise(&mut seed)).collect();
        assert!(spikes(&time, &smooth).is_empty());
        let mut spoiled = smooth.clone();
        spoiled[700] += 0.15;
        spoiled[1234] = 0.0;
        spoiled[2500..2502].fill(-1.0);
        assert_eq!(spikes(&time, &spoiled), [700, 1234, 2500, 2501]);
    }

    #[test]
    fn steps_pulses_and_sharp_turns_stay() {
        let mut seed = 5;
        let time = clock(6000, 0.01);
        // A command with a new value every 0.15 s, a binary sequence, and a step every 10 s.
        let mut level = 0.0;
        let held: Vec<f64> = (0..6000)
            .map(|k| {
                if k % 15 == 0 {
                    level = noise(&mut seed);
                }
                level
            })
            .collect();
        let binary: Vec<f64> = held.iter().map(|x| x.signum()).collect();
        let rare: Vec<f64> = (0..6000).map(|k| f64::from(u8::from(k / 1000 % 2 == 1))).collect();
        // Each sample another binary value, and a swerve of a second in a straight minute at 10 Hz.
        let fast: Vec<f64> = (0..6000).map(|_| noise(&mut seed).signum()).collect();
        for x in [&held, &binary, &rare, &fast] {
            assert!(spikes(&time, x).is_empty(), "{:?}", spikes(&time, x));
        }
        let slow = clock(600, 0.1);
        let swerve: Vec<f64> = slow
            .iter()
            .map(|t| {
                let inside = (30.0..31.4).contains(t);
                let turn = 0.2 * (std::f64::consts::TAU * (t - 30.0) / 1.4).sin();
                if inside { turn } else { 0.0 }
            })
            .collect();
        assert!(spikes(&slow, &swerve).is_empty(), "{:?}", spikes(&slow, &swerve));
    }

    /// A random command of that many samples, clipped and with a bounded rate.
    fn limited(seed: &mut u64, count: usize, period: f64) -> Vec<f64> {
        const TAU_S: f64 = 0.5;
        let share = period / TAU_S;
        let (mut low, mut wanted, mut command) = (0.0, 0.0, 0.0_f64);
        (0..count)
            .map(|_| {
                low += share * (noise(seed) / share.sqrt() - low);
                wanted += share * (low - wanted);
                let most = 0.4 * period;
                command += (0.3 * f64::clamp(wanted, -1.0, 1.0) - command).clamp(-most, most);
                command
            })
            .collect()
    }

    #[test]
    fn a_clipped_command_of_bounded_rate_has_no_spikes_but_those_inserted() {
        for period in [0.1, 0.05, 0.01] {
            for seed in 1..=50 {
                let (mut seed, count) = (seed, (60.0 / period) as usize);
                let time = clock(count, period);
                let mut x = limited(&mut seed, count, period);
                assert!(spikes(&time, &x).is_empty(), "{period} {:?}", spikes(&time, &x));
                let at: Vec<usize> = (0..5)
                    .map(|k| count * (2 * k + 1) / 10 + (4.0 * noise(&mut seed)) as usize)
                    .collect();
                at.iter().for_each(|&i| x[i] += 0.8 * noise(&mut seed).signum());
                assert_eq!(spikes(&time, &x), at, "{period}");
            }
        }
    }

    #[test]
    fn a_gyro_that_freezes_while_the_vehicle_is_steered() {
        let mut seed = 11;
        let time = clock(6000, 0.01);
        let of = |value| Sampled { time: &time, value };
        let steered: Vec<f64> = time.iter().map(|t| 0.02 * (2.0 * t).sin()).collect();
        let steering = of(&steered);
        let alive: Vec<f64> =
            time.iter().map(|t| 0.2 * (2.0 * t).sin() + 0.002 * noise(&mut seed)).collect();
        assert!(frozen(of(&alive), steering, None).is_empty());
        let mut stuck = alive.clone();
        stuck[1000..1200].fill(0.0);
        let held = stuck[3000];
        stuck[3000..3200].fill(held);
        let found = frozen(of(&stuck), steering, None);
        assert_eq!(found, [[time[1000], time[1199]], [time[3000], time[3199]]]);
        // At rest nothing is wrong with a yaw rate of zero.
        let at_rest = [0.0; 6000];
        assert!(frozen(of(&stuck), steering, Some(of(&at_rest))).is_empty());
    }
}
