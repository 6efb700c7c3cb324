//! The plants of the ensemble of a design, the limits of each requirement, and from where the loop returns to a path.

use super::optional;
use crate::figures::DEG;
use crate::section::Block;
use crate::table::Table;
use steerwright_formats::{
    Breaking, DesignEvidence, Engagement, EngagementRow, Pid, Requirement, Robustness,
};

/// What was varied, and where each requirement breaks.
pub(super) fn robustness(pid: &Pid, r: &Robustness) -> [Block; 2] {
    let is_over_speed = !r.speed.is_empty() || !pid.schedule.is_empty();
    let mut headers = vec!["requirement", "breaks at a loop delay of"];
    if is_over_speed {
        headers.push("at a speed of");
    }
    let mut table = Table::new(headers);
    for b in &r.latency {
        let label =
            Requirement::from_name(&b.requirement).map_or(b.requirement.as_str(), |r| r.label());
        let mut row = vec![label.to_owned(), where_it_breaks(b, &|v| format!("{} ms", ms(v)))];
        if is_over_speed {
            let speed = r.speed.iter().find(|s| s.requirement == b.requirement);
            row.push(match speed {
                Some(b) => where_it_breaks(b, &|v| format!("{v:.1} m/s")),
                None => "see over speed".into(),
            });
        }
        table.push(row);
    }
    [Block::Text(ranges(pid, r)), Block::Table(table)]
}

/// The requirements that plants of the ensemble miss.
pub(super) fn where_missed(r: &Robustness) -> Vec<String> {
    let sentence = |o: &steerwright_formats::OverEnsemble| {
        let label = Requirement::from_name(&o.requirement).map_or(&*o.requirement, |r| r.label());
        format!("{label} is kept by {:.0} % of {}", 100.0 * o.share_kept, r.plants)
    };
    r.requirements.iter().filter(|o| o.share_kept < 1.0).map(sentence).collect()
}

fn ranges(pid: &Pid, r: &Robustness) -> String {
    let mut text = format!("worst of {} plants: ", r.plants);
    if r.members > 0 {
        let of_wanted = match r.members_wanted {
            Some(wanted) => {
                format!(" of {wanted} (the others are unstable or have no continuous form)")
            }
            None => String::new(),
        };
        let members = r.members;
        text += &format!("{members}{of_wanted} drawn from the identified uncertainty, ");
    }
    text += &format!("gain {} to {}", r.gain_range[0], r.gain_range[1]);
    let [low, high] = r.loop_delay_range_s;
    if high > low {
        text += &format!(", delay of the loop {} to {} ms", ms(low.max(0.0)), ms(high));
    }
    if let Some([low, high]) = r.speed_range_mps {
        text += &format!(", {low:.1} to {high:.1} m/s");
    } else if pid.schedule.is_empty() {
        text += &format!(", at {:.1} m/s alone", pid.designed_for.speed_mps);
    }
    text
}

fn where_it_breaks(b: &Breaking, value: &dyn Fn(f64) -> String) -> String {
    match (b.below, b.above) {
        (None, None) => format!("none up to {}", value(b.looked[1])),
        (Some(below), None) => format!("below {}", value(below)),
        (None, Some(above)) => format!("above {}", value(above)),
        (Some(below), Some(above)) => format!("below {}, above {}", value(below), value(above)),
    }
}

fn ms(seconds: f64) -> String {
    format!("{:.0}", 1e3 * seconds)
}

/// Lateral offsets from which the loop returns to a path: a row for each heading error, a column for each speed.
pub(super) fn engagement(engagement: &Engagement) -> Vec<Block> {
    let mut speeds: Vec<f64> = engagement.rows.iter().map(|r| r.speed_mps).collect();
    speeds.dedup();
    let headers = speeds.iter().map(|v| format!("{v:.1} m/s"));
    let mut table = Table::new(std::iter::once("heading error".to_owned()).chain(headers));
    let first = speeds.first().copied();
    for row in engagement.rows.iter().filter(|r| Some(r.speed_mps) == first) {
        let mut cells = vec![format!("{:.0}°", DEG * row.heading_error_rad)];
        cells.extend(speeds.iter().map(|v| {
            let is_same = |r: &&EngagementRow| {
                r.speed_mps == *v && r.heading_error_rad == row.heading_error_rad
            };
            let offset = engagement.rows.iter().find(is_same).and_then(|r| r.largest_offset_m);
            optional(offset, 0, "m", "none")
        }));
        table.push(cells);
    }
    let heading = format!(
        "Largest lateral offset, of up to {:.0} m, from which the loop returns to a straight path ({})",
        engagement.offsets_m.last().copied().unwrap_or_default(),
        engagement.plant
    );
    vec![Block::Heading(heading), Block::Table(table)]
}

/// The shortest settling time that each modulus margin allows.
pub(super) fn trade_off(e: &DesignEvidence) -> Option<String> {
    let settling = |time: Option<f64>, absent: &str| optional(time, 2, "s", absent);
    let rows: Vec<String> = e
        .trade_off
        .iter()
        .map(|t| format!("{} at {}", settling(t.settling_time_s, "none"), t.modulus_margin))
        .collect();
    if rows.is_empty() {
        return None;
    }
    Some(format!(
        "shortest settling on the nominal plant by modulus margin: {} (here {} at {:.2})",
        rows.join(", "),
        settling(e.step.settling_time_s, "never"),
        e.margins.modulus_margin
    ))
}
