//! A speed controller for people: gains, limits, the responses at each speed, the ensemble and the quality.

use crate::terminal::console;
use std::fmt::Write;
use steerwright_formats::{Grade, SpeedController, SpeedEvidence, SpeedResponses, SpeedStep};
use steerwright_report::Table;

pub(crate) fn summary(controller: &SpeedController) -> String {
    let (g, l, s) = (&controller.gains, &controller.limits, &controller.specification);
    let e = &controller.evidence;
    let [low, high] = s.speeds_mps;
    let mut text = format!(
        "designed on longitudinal {} from {low:.1} to {high:.1} m/s\n\
         gains    kp {:.4} 1/s, ki {:.4} 1/s², reference rate {:.4} 1/s\n\
         limits   acceleration {} m/s², deceleration {} m/s², jerk {} m/s³; pedals change at {:.2} m/s²; held below {} m/s\n\n",
        controller.model.name,
        g.kp_per_s,
        g.ki_per_s2,
        g.reference_rate_per_s,
        l.max_acceleration_mps2,
        l.max_deceleration_mps2,
        l.max_jerk_mps3,
        l.pedal_hysteresis_mps2,
        l.hold_speed_mps,
    );
    let on_grade = format!("error on {} %", s.grade_percent);
    let mut table = Table::new([
        "speed (m/s)".to_owned(),
        format!("overshoot, +{} m/s", s.step_mps),
        "settling".into(),
        format!("overshoot, -{} m/s", s.step_mps),
        "settling".into(),
        on_grade,
        "largest loss".into(),
    ]);
    for row in &e.speeds {
        table = table.row([
            format!("{:.1}", row.speed_mps),
            format!("{:.2} %", row.up.overshoot_percent),
            settling(&row.up),
            format!("{:.2} %", row.down.overshoot_percent),
            settling(&row.down),
            format!("{:.2} %", row.error_on_grade_percent),
            format!("{:.2} m/s", row.largest_loss_on_grade_mps),
        ]);
    }
    let _ = writeln!(text, "{}", console::table(&table));
    if let Some(in_loop) = in_the_loop(e) {
        let _ = writeln!(text, "{in_loop}");
    }
    if let Some(ensemble) = e.ensemble {
        let longest = ensemble.settling_time_s.map_or("never".into(), |t| format!("{t:.2} s"));
        let _ = writeln!(
            text,
            "{} of {} vehicles drawn from the uncertainty of the model keep every requirement; the worst overshoot is \
             {:.2} %, settling time {longest}, steady-state error {:.2} %\n",
            ensemble.keeping,
            ensemble.vehicles,
            ensemble.overshoot_percent,
            ensemble.steady_state_error_percent
        );
    }
    for advice in &e.advice {
        let _ = writeln!(text, "{advice}");
    }
    let quality = &controller.quality;
    let _ = write!(text, "quality: {}", quality.grade);
    if quality.grade > Grade::Pass {
        let _ = write!(text, " ({})", quality.codes());
    }
    let _ = write!(text, ": {}", quality.summary);
    for reason in quality.unstated_reasons() {
        let _ = write!(text, "\n  {}: {}", reason.grade, reason.message);
    }
    text
}

/// How far the loop of the packed FMUs is from the responses above.
fn in_the_loop(e: &SpeedEvidence) -> Option<String> {
    let steps = |all: &[SpeedResponses]| -> Vec<SpeedStep> {
        all.iter().flat_map(|row| [row.up, row.down]).collect()
    };
    let (stated, found) = (steps(&e.speeds), steps(&e.fmu_loop));
    if found.is_empty() || found.len() != stated.len() {
        return None;
    }
    let mut largest = [0.0_f64; 2];
    for (a, b) in stated.iter().zip(&found) {
        largest[0] = largest[0].max((a.overshoot_percent - b.overshoot_percent).abs());
        let apart = match (a.settling_time_s, b.settling_time_s) {
            (Some(a), Some(b)) => (a - b).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        largest[1] = largest[1].max(apart);
    }
    let [overshoot, settling] = largest;
    let settling = if settling.is_finite() {
        format!("settling times by at most {settling:.3} s")
    } else {
        "settling times in that one of both never settles".into()
    };
    Some(format!(
        "in a loop of the packed FMUs the overshoots differ from these by at most {overshoot:.3} %, the {settling}"
    ))
}

fn settling(step: &SpeedStep) -> String {
    step.settling_time_s.map_or("never".into(), |time| format!("{time:.2} s"))
}
