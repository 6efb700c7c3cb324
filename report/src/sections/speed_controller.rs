//! A speed controller: gains, limits, the responses at each speed, and the ensemble.

use super::{optional, quality_note};
use crate::section::{Block, Section};
use crate::table::Table;
use steerwright_formats::{
    SpeedController, SpeedEnsemble, SpeedEvidence, SpeedResponses, SpeedStep,
};

/// The verdict, the gains, and the responses.
pub fn speed_controller_section(controller: &SpeedController) -> Section {
    let e = &controller.evidence;
    let mut blocks = vec![quality_note(&controller.quality)];
    blocks.push(Block::List(e.advice.clone()));
    blocks.push(Block::Facts(facts(controller)));
    blocks.push(Block::Table(responses(controller)));
    blocks.extend(in_the_loop(e).map(Block::Text));
    blocks.extend(e.ensemble.map(|ensemble| Block::Text(over_ensemble(ensemble))));
    Section::new(format!("Speed controller: {}", controller.name), blocks)
}

fn facts(controller: &SpeedController) -> Vec<(String, String)> {
    let (g, l, s) = (&controller.gains, &controller.limits, &controller.specification);
    let [low, high] = s.speeds_mps;
    let model = format!("longitudinal {} from {low:.1} to {high:.1} m/s", controller.model.name);
    let gains = format!(
        "kp {:.4} 1/s, ki {:.4} 1/s², reference rate {:.4} 1/s",
        g.kp_per_s, g.ki_per_s2, g.reference_rate_per_s
    );
    let limits = format!(
        "acceleration {} m/s², deceleration {} m/s², jerk {} m/s³; pedals change at {:.2} m/s²; held below {} m/s",
        l.max_acceleration_mps2,
        l.max_deceleration_mps2,
        l.max_jerk_mps3,
        l.pedal_hysteresis_mps2,
        l.hold_speed_mps
    );
    vec![
        Block::fact("designed on", model),
        Block::fact("gains", gains),
        Block::fact("limits", limits),
    ]
}

fn responses(controller: &SpeedController) -> Table {
    let s = &controller.specification;
    let mut table = Table::new([
        "speed (m/s)".to_owned(),
        format!("overshoot, +{} m/s", s.step_mps),
        "settling".into(),
        format!("overshoot, -{} m/s", s.step_mps),
        "settling".into(),
        format!("error on {} %", s.grade_percent),
        "largest loss".into(),
    ]);
    for row in &controller.evidence.speeds {
        table.push([
            format!("{:.1}", row.speed_mps),
            format!("{:.2} %", row.up.overshoot_percent),
            optional(row.up.settling_time_s, 2, "s", "never"),
            format!("{:.2} %", row.down.overshoot_percent),
            optional(row.down.settling_time_s, 2, "s", "never"),
            format!("{:.2} %", row.error_on_grade_percent),
            format!("{:.2} m/s", row.largest_loss_on_grade_mps),
        ]);
    }
    table
}

fn over_ensemble(e: SpeedEnsemble) -> String {
    format!(
        "{} of {} vehicles drawn from the uncertainty of the model keep every requirement; the worst overshoot is \
         {:.2} %, settling time {}, steady-state error {:.2} %",
        e.keeping,
        e.vehicles,
        e.overshoot_percent,
        optional(e.settling_time_s, 2, "s", "never"),
        e.steady_state_error_percent
    )
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
