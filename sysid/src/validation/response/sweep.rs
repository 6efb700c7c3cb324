//! What to drive next: with the noise as it was, the standard error of a band's gain falls as one
//! over the steering's amplitude in that band and the square root of the time driven. A sweep of
//! amplitude A with equal time for each octave puts `A²/2 · ln(f₂/f₁)/ln(F₂/F₁)` of steering power
//! into the band from f₁ to f₂.

use crate::validation::response::uncertain_response::ResponseError;
use steerwright_formats::{Evidence, ExcitationBand, FrequencyResponse, Reason, ResponsePoint};

/// The properties of the drive that the quality needs in addition to the evidence.
pub(crate) struct Drive<'a> {
    pub(crate) has_continuous: bool,
    pub(crate) speed_mps: f64,
    pub(crate) speed_spread: f64,
    pub(crate) steering_ratio: f64,
    pub(crate) to_road_wheel: f64,
    pub(crate) steering: &'a [f64],
    /// Length without what was left out, s.
    pub(crate) seconds: f64,
    pub(crate) order: usize,
    pub(crate) slow_log: Option<(Reason, String)>,
    pub(crate) noise_radps: f64,
    /// Road-wheel angle that driving straight would need, rad.
    pub(crate) road_wheel_offset_rad: f64,
    /// The yaw rate that driving straight would read, rad/s.
    pub(crate) yaw_rate_offset_radps: f64,
    pub(crate) implausible: Vec<(Reason, String)>,
    /// What is known of the response at the frequencies that count.
    pub(crate) response_errors: Vec<ResponseError>,
    /// Period of a steering, s, where a pass depends on whether it is held between its samples.
    pub(crate) open_hold_s: Option<f64>,
}

/// The rhythm to drive, Hz: what a driver can steer, and a controller needs.
pub(crate) const SWEEP: (f64, f64) = (0.2, 2.0);
const SWEEP_S: f64 = 60.0;
const LONGEST_S: f64 = 1200.0;
/// The relative error of each band's gain to aim at.
pub(crate) const WANTED: f64 = 0.05;
/// A drive stays linear up to about that lateral acceleration, m/s².
pub(crate) const LINEAR: f64 = 3.0;
/// A slalom that is felt: 20° at the steering wheel of a car, at the road wheel, rad.
const USUAL: f64 = 0.0233;

/// The sweep that would determine the gain of each band to [`WANTED`].
pub(crate) fn what_to_drive(evidence: &Evidence, drive: &Drive<'_>) -> String {
    let duration = drive.seconds;
    let octaves = |b: &ExcitationBand| (b.to_hz / b.from_hz).ln() / (SWEEP.1 / SWEEP.0).ln();
    let bands = || evidence.excitation.bands.iter().filter(|b| swept(b.from_hz, b.to_hz));
    // Relative error of a band's gain at amplitude 1 rad (road wheel) for a second.
    let at_unit = |b: &ExcitationBand| {
        b.relative_error * b.road_wheel_std_rad * (2.0 * duration / octaves(b)).sqrt()
    };
    let worst = bands().map(at_unit).fold(0.0, f64::max);
    let gain = evidence.frequency_response.as_ref().map_or(0.0, largest_gain);
    let most = largest_amplitude(gain, drive).unwrap_or(f64::INFINITY);
    let needed = worst / (WANTED * SWEEP_S.sqrt());
    let amplitude = needed.clamp(USUAL, 2.0 * USUAL).min(most);
    let time = (worst / (WANTED * amplitude)).powi(2).clamp(SWEEP_S, LONGEST_S);
    let time = (time / 30.0).ceil() * 30.0;
    let for_long = if time <= 120.0 {
        format!("{time:.0} s")
    } else {
        format!("{:.0} min", (time / 60.0).ceil())
    };
    let reached = worst / (amplitude * time.sqrt());
    let angle = amplitude.to_degrees() * drive.steering_ratio;
    let angle = if drive.steering_ratio > 2.0 {
        format!("about ±{:.0}° at the steering wheel", nice(angle))
    } else {
        format!("about ±{:.1}° at the road wheel", angle)
    };
    let speed = if drive.speed_mps > 0.5 {
        format!("a steady {:.0} m/s", drive.speed_mps)
    } else {
        "steady speed".to_owned()
    };
    let mut text = format!(
        "drive a slalom whose rhythm sweeps from {} to {} Hz, {angle}, for {for_long} at {speed}",
        SWEEP.0, SWEEP.1
    );
    let now = bands().map(|b| b.relative_error).fold(0.0, f64::max);
    // A log that already determines the gain at least as well is recorded again for another reason.
    if reached > 0.0 && reached < 1.0 && reached < now {
        let now = if now < 1.0 {
            format!("±{:.0} %", (200.0 * now).ceil())
        } else {
            "not at all".to_owned()
        };
        text += &format!(
            ": with the noise of this log, the gain at each of these frequencies would be known to ±{:.0} % (from this log: {now})",
            (200.0 * reached).ceil()
        );
    }
    text
}

/// Whole degrees, multiples of five from ten on.
fn nice(degrees: f64) -> f64 {
    if degrees < 10.0 { degrees.round().max(1.0) } else { 5.0 * (degrees / 5.0).round() }
}

fn largest_gain(response: &FrequencyResponse) -> f64 {
    let known = |p: &&ResponsePoint| {
        p.frequency_hz <= SWEEP.1 && p.coherence > response.significant_coherence.max(0.3)
    };
    response.points.iter().filter(known).map(|p| p.gain).fold(0.0, f64::max)
}

/// Amplitude at the road wheel that keeps the lateral acceleration v·r linear.
fn largest_amplitude(gain: f64, drive: &Drive<'_>) -> Option<f64> {
    let of_road_wheel = gain / drive.to_road_wheel;
    if gain > 0.0 && drive.speed_mps > 0.5 {
        Some(LINEAR / (of_road_wheel * drive.speed_mps))
    } else {
        None
    }
}

/// Whether a band is within what is to be swept, where a yaw controller works.
pub(crate) fn swept(from_hz: f64, to_hz: f64) -> bool {
    from_hz >= SWEEP.0 && to_hz <= SWEEP.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use steerwright_formats::Information;

    fn drive(to_road_wheel: f64) -> Drive<'static> {
        Drive {
            has_continuous: true,
            speed_mps: 20.0,
            speed_spread: 0.0,
            steering_ratio: 15.0,
            to_road_wheel,
            steering: &[0.0; 1500],
            seconds: 60.0,
            order: 2,
            slow_log: None,
            noise_radps: 0.0,
            road_wheel_offset_rad: 0.0,
            yaw_rate_offset_radps: 0.0,
            implausible: Vec::new(),
            open_hold_s: None,
            response_errors: Vec::new(),
        }
    }

    /// 6 (rad/s)/rad at the road wheel at 20 m/s are linear up to 3/(6·20) rad, whether the gain is that
    /// of the steering wheel's angle or of that times speed.
    #[test]
    fn the_largest_amplitude_does_not_depend_on_what_drives_the_model() {
        for to_road_wheel in [1.0 / 15.0, 1.0 / (15.0 * 20.0)] {
            let most = largest_amplitude(6.0 * to_road_wheel, &drive(to_road_wheel)).unwrap();
            assert!((most - 0.025).abs() < 1e-12, "{most}");
        }
    }

    /// The recommended sweep, computed by hand: in the octave from 1 to 2 Hz (0.301 of the sweep) a log
    /// of 60 s with 2 mrad determined the gain to 90 %. A sweep of ±46.6 mrad needs
    /// (0.9·0.002·√(2·60/0.301)/(0.05·0.0466))² = 238 s for 5 %.
    #[test]
    fn the_sweep_that_is_recommended() {
        let band = ExcitationBand {
            from_hz: 1.0,
            to_hz: 2.0,
            road_wheel_std_rad: 2e-3,
            yaw_rate_std_radps: 1e-2,
            coherence: 0.3,
            relative_error: 0.9,
            information: Information::Weak,
        };
        let mut evidence = Evidence::default();
        evidence.excitation.bands = vec![band];
        let text = what_to_drive(&evidence, &drive(1.0 / 15.0));
        assert!(
            text.contains("±40° at the steering wheel, for 4 min at a steady 20 m/s"),
            "{text}"
        );
        assert!(text.contains("known to ±10 % (from this log: ±180 %)"), "{text}");
    }
}
