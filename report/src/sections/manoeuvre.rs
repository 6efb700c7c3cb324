//! A manoeuvre: what it determines, and what to drive, for a driver or the operator of a robot.

use super::{length, value};
use crate::figure::{Figure, Mark, MarkPlace, Panel, Series, Style};
use crate::figures::DEG;
use crate::html::report_html;
use crate::palette::{BLUE, VERMILION, nth};
use crate::section::{Block, Section, Tone};
use crate::table::Table;
use steerwright_formats::{Manoeuvre, ManoeuvreGoal, ManoeuvreKind, SteeringSignal};

/// Degrees per acceleration of free fall of an understeer gradient of 1 rad·s²/m.
const DEGREES_PER_G: f64 = DEG * 9.806_65;

/// An error of a goal, in the unit that is usual for it.
fn goal_error(goal: ManoeuvreGoal, error: f64) -> String {
    match goal {
        ManoeuvreGoal::Response | ManoeuvreGoal::TyreLimit => format!("±{:.2} %", 100.0 * error),
        ManoeuvreGoal::Understeer => {
            format!("±{}\u{a0}deg/g", super::significant(DEGREES_PER_G * error))
        }
    }
}

/// What a manoeuvre determines, with the value of the model where it is one number.
fn goal_in_words(manoeuvre: &Manoeuvre) -> String {
    let of = |name: &str| {
        let parameters = &manoeuvre.expected.parameters;
        parameters.iter().find(|p| p.name == name).map_or(f64::NAN, |p| p.value)
    };
    match manoeuvre.purpose.goal {
        ManoeuvreGoal::Response => {
            let [low, high] = manoeuvre.purpose.band_hz;
            format!("response from {low} to {high} Hz")
        }
        ManoeuvreGoal::Understeer => format!(
            "understeer gradient of {:.3}\u{a0}deg/g at the road wheel",
            DEGREES_PER_G * of("understeer_gradient")
        ),
        ManoeuvreGoal::TyreLimit => format!(
            "friction coefficients of {:.2} in front and {:.2} at the rear",
            of("friction_coefficient_front"),
            of("friction_coefficient_rear")
        ),
    }
}

/// The quantities that a manoeuvre determines, with two standard errors.
fn parameters(manoeuvre: &Manoeuvre) -> Table {
    let mut table = Table::new(["quantity", "value", "± two standard errors"]);
    for parameter in &manoeuvre.expected.parameters {
        let unit = if parameter.unit == "1" { "" } else { &parameter.unit };
        table.push([
            parameter.name.replace('_', " "),
            value(parameter.value, 4, unit),
            value(2.0 * parameter.standard_error, 4, unit),
        ]);
    }
    table
}

/// The distance of the cones of a slalom, of which one stands at each change of side; `None` of other signals.
fn cone_distance_m(signal: &SteeringSignal) -> Option<f64> {
    let [from, to] = signal.frequency_hz?;
    if from == to { Some(signal.speed_mps / (2.0 * from)) } else { None }
}

/// The rhythm, the amplitude and the cones of a signal in a sentence.
fn signal_in_words(kind: ManoeuvreKind, signal: &SteeringSignal) -> String {
    let angle = signal.peaks.angle_rad.to_degrees();
    let speed = signal.speed_mps;
    match (kind, signal.frequency_hz, signal.hold_s) {
        (ManoeuvreKind::Slalom, Some([hz, _]), _) => {
            let cones = cone_distance_m(signal).unwrap_or_default();
            format!(
                "slalom of {hz:.2} Hz at {speed:.1} m/s, ±{angle:.1}°: metronome at {:.0} beats a minute, one beat a side, a cone every {cones:.1} m",
                120.0 * hz
            )
        }
        (ManoeuvreKind::Sweep, Some([from, to]), _) => format!(
            "slalom whose rhythm rises from {from:.2} to {to:.2} Hz at {speed:.1} m/s, ±{angle:.1}°: metronome from {:.0} to {:.0} beats a minute, one beat a side",
            120.0 * from,
            120.0 * to
        ),
        (ManoeuvreKind::Steps, _, Some(hold)) => format!(
            "lane changes there and back at {speed:.1} m/s, ±{angle:.1}°: hold {hold:.1} s, {:.1} s to the other side, {hold:.1} s",
            2.0 * hold
        ),
        (ManoeuvreKind::GrowingSlalom, Some([hz, _]), _) => {
            let cones = cone_distance_m(signal).unwrap_or_default();
            format!(
                "slalom of {hz:.2} Hz at {speed:.1} m/s that grows to ±{angle:.1}°: metronome at {:.0} beats a minute, one beat a side, a cone every {cones:.1} m",
                120.0 * hz
            )
        }
        (ManoeuvreKind::RisingAngle, ..) => {
            format!(
                "angle that rises slowly to {angle:.1}° at {speed:.1} m/s, and returns: the vehicle turns"
            )
        }
        (_, Some([from, to]), _) => {
            format!("tones from {from:.2} to {to:.2} Hz at {speed:.1} m/s, up to ±{angle:.1}°")
        }
        (_, None, _) => format!("at {speed:.1} m/s, ±{angle:.1}°"),
    }
}

/// What the signals use of the limits.
fn limits(manoeuvre: &Manoeuvre) -> Table {
    let mut table =
        Table::new(["speed", "quantity", "of the model", "bound by its uncertainty", "limit"]);
    let l = &manoeuvre.limits;
    let degrees = |limit: Option<f64>| limit.map(f64::to_degrees);
    for signal in &manoeuvre.signals {
        let p = &signal.peaks;
        let [angle, rate] = [p.angle_rad, p.rate_radps].map(f64::to_degrees);
        let rows = [
            (
                "lateral acceleration",
                p.lateral_acceleration_mps2,
                Some(l.max_lateral_acceleration_mps2),
                "m/s²",
            ),
            ("lateral offset", p.offset_m, l.max_offset_m, "m"),
            ("steering angle", [angle; 2], degrees(l.max_angle_rad), "°"),
            ("steering rate", [rate; 2], degrees(l.max_rate_radps), "°/s"),
        ];
        for (name, [nominal, upper], limit, unit) in rows {
            table.push([
                format!("{:.1} m/s", signal.speed_mps),
                name.to_owned(),
                value(nominal, 2, unit),
                value(upper, 2, unit),
                match limit {
                    Some(limit) => value(limit, 2, unit),
                    None => "none".into(),
                },
            ]);
        }
    }
    table
}

/// The page of a manoeuvre, self-contained.
#[must_use]
pub fn manoeuvre_page(manoeuvre: &Manoeuvre) -> String {
    let lead = "Angles are those of the log that the model is from, in degrees, positive to the left (ISO 8855); \
                errors are two standard errors.";
    let title = format!("{}: the drive to record", manoeuvre.name);
    report_html(&title, lead, &manoeuvre_sections(manoeuvre))
}

/// What a manoeuvre determines, what to drive, and what it uses of the limits.
#[must_use]
pub fn manoeuvre_sections(manoeuvre: &Manoeuvre) -> Vec<Section> {
    vec![errors(manoeuvre), drive(manoeuvre), signals(manoeuvre)]
}

fn drive(manoeuvre: &Manoeuvre) -> Section {
    let who = if manoeuvre.kind == ManoeuvreKind::Multisine {
        "A steering robot or drive-by-wire steers excitation.csv; a person holds the speed and takes over to centre the vehicle."
    } else if manoeuvre.kind == ManoeuvreKind::RisingAngle {
        "The driver or a robot holds the speed and turns the wheel slowly and steadily, on a free area."
    } else {
        "The driver holds the speed and steers to the beat of a metronome: the hands are at one side at each beat."
    };
    let mut list = vec![
        format!(
            "Record steering angle, yaw rate and speed, for {:.0} s in {} blocks of {:.0} s.",
            manoeuvre.time_s(),
            manoeuvre.schedule.len(),
            manoeuvre.block_s
        ),
        "Begin each block straight, in the middle of the lane, at the stated speed; drive straight for the last 2 s.".into(),
        "Between blocks the vehicle may be centred and the recording may go on: steering that is recorded is used.".into(),
        who.into(),
    ];
    let offsets: Vec<String> = manoeuvre
        .signals
        .iter()
        .map(|s| format!("{} at {:.1} m/s", length(s.peaks.offset_m[1]), s.speed_mps))
        .collect();
    if manoeuvre.purpose.goal == ManoeuvreGoal::TyreLimit {
        list.push("The tyres come near their grip: on a free, level and dry area, with the stated limits checked with a smaller amplitude first, and with the stability control as it is to be known.".into());
    }
    if manoeuvre.kind != ManoeuvreKind::RisingAngle {
        list.push(format!(
        "The vehicle stays within {} to either side of its line, and returns to it, if the wheel that drives straight is at 0°; a steering offset, a crowned road or wind make it drift, which the driver or a slow correction of the robot takes out.",
        offsets.join(", ")
    ));
    }
    let mut table = Table::new(["block", "from (s)", "speed (m/s)", "first to", "what"]);
    for (k, block) in manoeuvre.schedule.iter().enumerate() {
        let Some(signal) = manoeuvre.signals.get(block.signal) else { continue };
        let first = signal.steering_rad.iter().find(|u| u.abs() > 0.1 * signal.peaks.angle_rad);
        let left = first.is_some_and(|u| *u > 0.0) != block.mirrored;
        table.push([
            format!("{}", k + 1),
            format!("{:.0}", block.start_s),
            format!("{:.1}", signal.speed_mps),
            if left { "left".into() } else { "right".into() },
            signal_in_words(manoeuvre.kind, signal),
        ]);
    }
    let kind = format!(
        "{} of {:.0} s, {} blocks of {:.0} s, for {}",
        manoeuvre.kind,
        manoeuvre.time_s(),
        manoeuvre.schedule.len(),
        manoeuvre.block_s,
        manoeuvre.name
    );
    let mut facts = vec![Block::fact("manoeuvre", kind)];
    let signals = manoeuvre.signals.iter();
    facts.extend(
        signals.map(|signal| Block::fact("signal", signal_in_words(manoeuvre.kind, signal))),
    );
    let blocks =
        vec![Block::Facts(facts), Block::List(list), Block::Details(vec![Block::Table(table)])];
    Section::new("What to drive", blocks)
}

fn signals(manoeuvre: &Manoeuvre) -> Section {
    let mut steering = Panel::new("Time in the block (s)", "Steering angle (deg)");
    for (k, signal) in manoeuvre.signals.iter().enumerate() {
        let points = signal.steering_rad.iter().enumerate();
        let points = points.map(|(i, u)| (manoeuvre.sample_time_s * i as f64, DEG * u)).collect();
        let name = format!("signal {} at {:.1} m/s", k + 1, signal.speed_mps);
        steering = steering.with(Series::new(name, points, Style::line(nth(k))));
    }
    if let Some(limit) = manoeuvre.limits.max_angle_rad {
        for (name, at) in [("limit", limit), ("", -limit)] {
            steering = steering.mark(Mark::new(name, MarkPlace::YLine(DEG * at), VERMILION));
        }
    }
    let figure = Figure::new("Steering of the blocks", vec![steering]);
    let caption = "A mirrored block begins to the other side.";
    Section::new(
        "Signals and limits",
        vec![
            Block::figure(figure, 320, caption),
            Block::Table(limits(manoeuvre)),
            Block::Text(
                "The bound is kept with a probability of 97.5 % by the stated uncertainty of the model.".into(),
            ),
        ],
    )
}

fn errors(manoeuvre: &Manoeuvre) -> Section {
    let e = &manoeuvre.expected;
    let mut blocks = vec![verdict(manoeuvre)];
    if !e.response.is_empty() {
        blocks.push(response_figure(manoeuvre));
        blocks.push(Block::Details(vec![Block::Table(response(manoeuvre))]));
    }
    let parameters = Block::Table(parameters(manoeuvre));
    blocks.push(match manoeuvre.purpose.goal {
        ManoeuvreGoal::Response => Block::Details(vec![parameters]),
        ManoeuvreGoal::Understeer | ManoeuvreGoal::TyreLimit => parameters,
    });
    blocks.push(Block::Table(alternatives(manoeuvre)));
    Section::new("Errors to expect", blocks)
}

/// What will be known, and whether that is what is required.
fn verdict(manoeuvre: &Manoeuvre) -> Block {
    let (e, goal) = (&manoeuvre.expected, manoeuvre.purpose.goal);
    let detail = match goal {
        ManoeuvreGoal::Response => "two standard errors of gain and phase, the largest in the band",
        ManoeuvreGoal::Understeer => "two standard errors",
        ManoeuvreGoal::TyreLimit => "two standard errors, the larger of both",
    };
    let error = goal_error(goal, 2.0 * e.largest_error);
    let known = format!("{} known to {error}", goal_in_words(manoeuvre));
    let mut text = detail.to_owned();
    if let Some(bound) = e.bound {
        let bound = goal_error(goal, 2.0 * bound);
        text += &format!("; no tones within the limits know it better than to {bound}");
    }
    let Some(wanted) = manoeuvre.purpose.max_error else {
        return Block::Note { tone: Tone::Good, title: known, text };
    };
    let needed = match e.needed_time_s {
        Some(time) => format!("{time:.0} s would do"),
        None => "no time would do".into(),
    };
    let (tone, met) = if e.met { (Tone::Good, "met") } else { (Tone::Bad, "not met") };
    let title = format!("required {}: {met}; {needed}", goal_error(goal, wanted));
    Block::Note { tone, title, text: format!("{known} ({text})") }
}

/// The response and its errors at each speed and frequency.
fn response(manoeuvre: &Manoeuvre) -> Table {
    let mut table =
        Table::new(["speed (m/s)", "frequency (Hz)", "gain (1/s)", "± gain", "± phase"]);
    for row in &manoeuvre.expected.response {
        table.push([
            format!("{:.1}", row.speed_mps),
            format!("{:.2}", row.frequency_hz),
            format!("{:.3}", row.gain),
            format!("{:.2} %", 200.0 * row.gain_error),
            format!("{:.2}°", 2.0 * DEG * row.phase_error_rad),
        ]);
    }
    table
}

/// The best manoeuvre of each kind, and who steers it.
fn alternatives(manoeuvre: &Manoeuvre) -> Table {
    let goal = manoeuvre.purpose.goal;
    let heading = match goal {
        ManoeuvreGoal::Response => "largest error in the band",
        ManoeuvreGoal::Understeer => "error of the understeer gradient",
        ManoeuvreGoal::TyreLimit => "larger error of the friction",
    };
    let mut table = Table::new(["manoeuvre", heading]);
    for other in &manoeuvre.alternatives {
        let who = match other.kind {
            _ if goal == ManoeuvreGoal::TyreLimit => "robot or driver",
            ManoeuvreKind::Multisine => "robot",
            _ => "driver",
        };
        table
            .push([format!("{} ({who})", other.kind), goal_error(goal, 2.0 * other.largest_error)]);
    }
    table
}

fn response_figure(manoeuvre: &Manoeuvre) -> Block {
    let e = &manoeuvre.expected;
    let mut gain = Panel::new("Frequency (Hz)", "± gain (%)");
    let mut phase = Panel::new("Frequency (Hz)", "± phase (deg)");
    let mut speeds: Vec<f64> = e.response.iter().map(|row| row.speed_mps).collect();
    speeds.dedup();
    for (k, speed) in speeds.iter().enumerate() {
        let own: Vec<_> = e.response.iter().filter(|row| row.speed_mps == *speed).collect();
        let name = format!("{speed:.1} m/s");
        let color = if speeds.len() == 1 { BLUE } else { nth(k) };
        let style = Style::dots(color);
        let points = |of: fn(&steerwright_formats::ExpectedResponse) -> f64| {
            own.iter().map(|row| (row.frequency_hz, of(row))).collect()
        };
        gain = gain.with(Series::new(name.clone(), points(|row| 200.0 * row.gain_error), style));
        let degrees = points(|row| 2.0 * DEG * row.phase_error_rad);
        phase = phase.with(Series::new(name, degrees, style));
    }
    for panel in [&mut gain, &mut phase] {
        panel.x_log = true;
        panel.link = "frequency";
    }
    let largest = e.response.iter().map(|row| row.gain_error.max(row.phase_error_rad));
    let largest = largest.fold(0.0, f64::max);
    let result = format!("At most ±{} %.", super::significant(200.0 * largest));
    let figure = Figure::new("Errors of the response to expect", vec![gain, phase]).stating(result);
    Block::figure(figure, 420, "Two standard errors, with the stated noise.")
}
