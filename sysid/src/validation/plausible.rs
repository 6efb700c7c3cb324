//! Whether sign, gain and zeros of a model can be those of a road vehicle. At low frequency,
//! [`LOW_HZ`], `l_e = v δ/r = l (1 + (v/v_ch)²)` is a length: the wheelbase, lengthened by
//! understeer (Gillespie, *Fundamentals of Vehicle Dynamics*, 1992, chapter 6).

use crate::validation::residuals::pairs::Pair;
use crate::validation::response::modelled::{LOW_HZ, bandwidth_hz};
use std::f64::consts::TAU;
use steerwright_formats::{Excitation, Grade, Information, Reason, ReasonCode, Spread};

/// The shortest effective wheelbase, m: 1:28 scale cars have 0.09 m.
const SHORTEST_M: f64 = 0.08;
/// … of a steering wheel or a fast vehicle: karts have 1.0 m, oversteering cars less.
const SHORTEST_FULL_SIZE_M: f64 = 0.7;
/// Faster than scale cars are driven on a recording, m/s.
const FAST_MPS: f64 = 10.0;
/// The longest wheelbase, m: long trucks.
const LONGEST_M: f64 = 8.0;
/// The least characteristic speed, m/s: heavily understeering cars have 15 to 18.
const LEAST_CHARACTERISTIC_MPS: f64 = 14.0;
/// A steering angle with that ratio to the road wheel is a steering wheel's.
const STEERING_WHEEL_RATIO: f64 = 3.0;
/// Slower zeros are those of drift, rad/s.
const SLOWEST_ZERO_RADPS: f64 = 0.5;
/// Bandwidths are looked for up to here, Hz.
const HIGHEST_HZ: f64 = 5.0;

/// Within that, the yaw rate of every vehicle follows the steering, s.
const SMOOTH_S: f64 = 1.0;
/// Correlation of yaw rate and steering below minus which their signs are opposite.
const OPPOSITE: f64 = 0.5;

/// What to do about a sign.
const AXES: &str = "check the axes: steering and yaw rate are positive to the left (ISO 8855, z up); a gyro with its axis down or a steering angle positive to the right needs a leading - before its column";

/// Bands up to here are low frequencies, Hz.
const LOW_BANDS_HZ: f64 = 0.5;

pub(crate) struct Response<'a> {
    /// Yaw rate over road-wheel angle, (real, imaginary) in 1/s, at a frequency in Hz.
    pub(crate) at: &'a dyn Fn(f64) -> (f64, f64),
    /// Where nothing is known of low frequencies, neither is sign or gain; `None` where both are known.
    pub(crate) excitation: Option<&'a Excitation>,
    pub(crate) speed_mps: f64,
    pub(crate) steering_ratio: f64,
    /// Zeros of the continuous model, rad/s, with their spreads where they are known.
    pub(crate) zeros: &'a [[f64; 2]],
    pub(crate) spreads: &'a [Spread],
}

pub(crate) fn implausible(of: &Response<'_>) -> Vec<(Reason, String)> {
    let mut out = Vec::new();
    let low = of.excitation.iter().flat_map(|e| &e.bands).filter(|b| b.to_hz <= LOW_BANDS_HZ);
    let mut low = low.map(|b| b.information).peekable();
    if low.peek().is_some() && low.all(|i| i == Information::None) {
        return out;
    }
    let (re, im) = (of.at)(LOW_HZ);
    if re < 0.0 {
        let message = format!(
            "the yaw rate has the opposite sign to the steering: {re:.2} (rad/s)/rad at {LOW_HZ} Hz"
        );
        let reason = Reason::new(ReasonCode::WrongSign, Grade::Fail, message);
        out.push((reason.compared(re, 0.0, "1/s"), AXES.to_owned()));
    } else if let Some(found) = wrong_gain(of, re.hypot(im)) {
        out.push(found);
    }
    out.extend(slow_zero(of));
    out
}

fn wrong_gain(of: &Response<'_>, gain: f64) -> Option<(Reason, String)> {
    let v = of.speed_mps;
    if !(v > 0.1 && gain > 0.0) {
        return None;
    }
    let wheelbase = v / gain;
    let full_size = of.steering_ratio >= STEERING_WHEEL_RATIO || v > FAST_MPS;
    let shortest = if full_size { SHORTEST_FULL_SIZE_M } else { SHORTEST_M };
    let longest = LONGEST_M * (1.0 + (v / LEAST_CHARACTERISTIC_MPS).powi(2));
    let limit = if wheelbase < shortest {
        shortest
    } else if wheelbase > longest {
        longest
    } else {
        return None;
    };
    let range = if wheelbase < shortest { "shorter" } else { "longer" };
    let message = format!(
        "the gain from steering to yaw rate at {LOW_HZ} Hz is that of a wheelbase (with understeer) of {wheelbase:.3} m at {v:.1} m/s, {range} than any road vehicle's ({limit:.2} m)"
    );
    let cause = if wheelbase < shortest {
        "check the units and the steering ratio: a steering angle in rad read as deg, a yaw rate in deg/s read as rad/s, or a steering ratio stated for an angle that is at the road wheel already"
    } else {
        "check the units and the steering ratio: a steering angle in deg read as rad, a yaw rate in rad/s read as deg/s, or the angle of a steering wheel taken for the road wheel's"
    };
    let reason = Reason::new(ReasonCode::ImplausibleGain, Grade::Fail, message);
    let cause = format!("{cause}; the unit of the speed matters too");
    Some((reason.compared(wheelbase, limit, "m"), cause))
}

/// A yaw rate opposite to steering times speed, by the correlation of means over [`SMOOTH_S`].
pub(crate) fn opposite(segments: &[Pair<'_>], sample_time_s: f64) -> Option<(Reason, String)> {
    let width = ((SMOOTH_S / sample_time_s).round() as usize).max(1);
    let smooth = |x: Vec<f64>| -> Vec<f64> {
        x.chunks_exact(width).map(steerwright_drivelog::signal::mean).collect()
    };
    let turned = |s: &Pair<'_>| match s.speed {
        Some(speed) => s.steering.iter().zip(speed).map(|(u, v)| u * v).collect(),
        None => s.steering.to_vec(),
    };
    let input: Vec<f64> = segments.iter().flat_map(|s| smooth(turned(s))).collect();
    let output: Vec<f64> = segments.iter().flat_map(|s| smooth(s.yaw_rate.to_vec())).collect();
    let (u0, y0) =
        (steerwright_drivelog::signal::mean(&input), steerwright_drivelog::signal::mean(&output));
    let sums = input.iter().zip(&output).fold([0.0; 3], |[uu, yy, uy], (u, y)| {
        let (u, y) = (u - u0, y - y0);
        [uu + u * u, yy + y * y, uy + u * y]
    });
    let correlation = sums[2] / (sums[0] * sums[1]).sqrt();
    if correlation < -OPPOSITE {
        let message = format!(
            "the yaw rate has the opposite sign to the steering: their correlation over means of {SMOOTH_S} s is {correlation:.2}"
        );
        let reason = Reason::new(ReasonCode::WrongSign, Grade::Fail, message);
        Some((reason.compared(correlation, -OPPOSITE, ""), AXES.to_owned()))
    } else {
        None
    }
}

fn slow_zero(of: &Response<'_>) -> Option<(Reason, String)> {
    let bandwidth = TAU * bandwidth_hz(of.at, HIGHEST_HZ);
    let sure = |(i, zero): &(usize, &[f64; 2])| {
        let size = zero[0].hypot(zero[1]);
        // A zero of unknown spread may lie anywhere about where it was found.
        let (error, slower) = match of.spreads.get(*i) {
            Some(spread) => (spread.variance_re.sqrt(), bandwidth),
            None => (0.0, 0.5 * bandwidth),
        };
        zero[0] - 2.0 * error > 0.0 && (SLOWEST_ZERO_RADPS..slower).contains(&size)
    };
    let (_, zero) = of.zeros.iter().enumerate().find(sure)?;
    let message = format!(
        "a zero in the right half plane at {:.2} rad/s is slower than the bandwidth of {bandwidth:.1} rad/s: the yaw rate first answers in the wrong direction",
        zero[0].hypot(zero[1])
    );
    let reason = Reason::new(ReasonCode::NonMinimumPhase, Grade::Fail, message);
    let hint = "check that the channel is the yaw rate about the vertical axis (lateral acceleration, roll rate or sideslip answer that way), the clocks of the channels, and that the vehicle does not drive backwards";
    Some((reason.compared(zero[0].hypot(zero[1]), bandwidth, "rad/s"), hint.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(
        gain: f64,
        speed_mps: f64,
        steering_ratio: f64,
        zeros: &[[f64; 2]],
    ) -> Vec<ReasonCode> {
        // A lag of 0.15 s.
        let at = |hz: f64| {
            let x = 0.15 * TAU * hz;
            (gain / (1.0 + x * x), -gain * x / (1.0 + x * x))
        };
        let of =
            Response { at: &at, excitation: None, speed_mps, steering_ratio, zeros, spreads: &[] };
        implausible(&of).into_iter().map(|(reason, _)| reason.code).collect()
    }

    /// v/(l + K v²) of vehicles that exist, at the speeds that they are driven at.
    #[test]
    fn vehicles_are_plausible_and_mistakes_are_not() {
        let gain = |l: f64, k: f64, v: f64| v / (l + k * v * v);
        let vehicles = [
            (2.7, 0.0026, 20.0, 15.0),
            (2.7, 0.0026, 40.0, 15.0),
            (2.4, -0.0004, 40.0, 15.0), // oversteering sports car
            (6.5, 0.004, 24.0, 20.0),   // truck
            (1.05, 0.0, 20.0, 1.0),     // kart
            (0.26, 0.003, 2.0, 1.0),    // 1:10 scale car
            (2.4, 0.001, 60.0, 1.0),    // race car, road-wheel angle
        ];
        for (l, k, v, ratio) in vehicles {
            let right = gain(l, k, v);
            assert_eq!(codes(right, v, ratio, &[]), [], "{l} m at {v} m/s");
            assert_eq!(codes(-right, v, ratio, &[]), [ReasonCode::WrongSign], "{l} m at {v} m/s");
            for wrong in [57.3, 1.0 / 57.3] {
                let found = codes(wrong * right, v, ratio, &[]);
                assert_eq!(found, [ReasonCode::ImplausibleGain], "{l} m at {v} m/s, ×{wrong}");
            }
        }
        // A steering wheel taken for a road wheel, and a road wheel read with a ratio of 15.
        let car = gain(2.7, 0.0026, 15.0);
        assert_eq!(codes(car / 15.0, 15.0, 1.0, &[]), [ReasonCode::ImplausibleGain]);
        assert_eq!(codes(car * 15.0, 15.0, 15.0, &[]), [ReasonCode::ImplausibleGain]);
        // A slow zero on the right; one beyond the bandwidth, one on the left and one of drift are none.
        assert_eq!(codes(car, 15.0, 1.0, &[[3.0, 0.0]]), [ReasonCode::NonMinimumPhase]);
        assert_eq!(codes(car, 15.0, 1.0, &[[40.0, 0.0], [-3.0, 0.0], [0.02, 0.0]]), []);
    }
}
