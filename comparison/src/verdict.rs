//! The verdict in sentences: which controllers meet the specification, which leave the path, which one
//! tracks better and by how much, and how good the predictions were.

use crate::drive::ComparedDrive;
use crate::models::{ComparedModel, Controller};
use crate::outcome::Outcome;
use crate::plants::Plant;
use crate::runs::ComparedRun;
use serde::Serialize;
use steerwright_sweep::Class;

/// Smaller differences of the cross-track error do not count, m: the accuracy of a corrected GNSS.
const LEAST_TRACKING_M: f64 = 0.01;
/// Nor do smaller shares of the larger one.
const LEAST_SHARE: f64 = 0.05;
/// Smaller differences of a fit do not count, percent.
const LEAST_FIT: f64 = 0.5;
/// Larger differences of the modulus margins are reported.
const LEAST_MARGIN: f64 = 0.05;

/// The conclusions, for scripts and people.
#[derive(Serialize)]
pub struct Verdict {
    /// Where the controllers are compared.
    pub judged_on: String,
    /// The controller that tracks best; absent where there is no difference, or all are off the path.
    pub tracks_best: Option<String>,
    /// Smaller differences of the RMS cross-track error count as none, m.
    pub least_difference_m: f64,
    /// For each controller the figure that is compared.
    pub cross_track_rms_m: Vec<Figure>,
    /// In words, the most important first.
    pub sentences: Vec<String>,
}

/// A controller's figure.
#[derive(Serialize)]
pub struct Figure {
    /// The controller.
    pub controller: String,
    /// Absent where it is off the path.
    pub value: Option<f64>,
}

/// The evidence of the verdict.
pub(crate) struct Compared<'a> {
    pub(crate) controllers: &'a [Controller],
    pub(crate) plants: &'a [Plant],
    pub(crate) runs: &'a [ComparedRun],
    /// One for each run.
    pub(crate) outcomes: &'a [Outcome],
    pub(crate) drive: Option<&'a ComparedDrive>,
    pub(crate) models: &'a [ComparedModel],
}

impl Compared<'_> {
    /// On the truth, or without one on the worst plant of each controller: which meet the specification,
    /// which leave the path, and which one tracks better.
    pub(crate) fn verdict(&self) -> Verdict {
        let truth = self.plants.iter().position(|p| p.model.is_none());
        // The same plants for all, since some follow a road less easily.
        let counts = |run: &&ComparedRun| truth.is_none_or(|truth| run.plant == truth);
        let figure = |run: &ComparedRun| {
            let rms = run.errors.cross_track_rms_m;
            Some(rms).filter(|rms| run.off_path_at_m.is_none() && rms.is_finite())
        };
        let tracking_errors: Vec<Figure> = (0..self.controllers.len())
            .map(|index| {
                let own = self.runs.iter().filter(|r| r.controller == index).filter(counts);
                // One plant without a figure leaves none.
                let value = own.map(figure).try_fold(0.0_f64, |worst, rms| Some(worst.max(rms?)));
                Figure { controller: self.controllers[index].label.clone(), value }
            })
            .collect();
        let judged_on =
            truth.map_or("the worst of the models' plants", |t| self.plants[t].label.as_str());
        let judged_on = judged_on.to_owned();
        let mut sentences = self.specification(truth);
        sentences.extend(self.astray());
        let (tracks_best, sentence) = tracking(&tracking_errors, &judged_on);
        sentences.extend(sentence);
        if let Some(truth) = truth {
            sentences.extend(predictions(self.controllers, self.runs, truth));
        } else {
            sentences.push(
                "Without a truth this shows how much the controllers depend on their models, not which \
                 model is right."
                    .into(),
            );
        }
        sentences.extend(self.drive.and_then(|drive| fits(drive, self.models)));
        sentences.extend(margins(self.controllers));
        sentences.push(
            "All figures are of one road and one speed, without sensor noise: a sweep varies these, and only a \
             vehicle confirms them."
                .into(),
        );
        Verdict {
            judged_on,
            tracks_best,
            least_difference_m: LEAST_TRACKING_M,
            cross_track_rms_m: tracking_errors,
            sentences,
        }
    }

    /// The controllers that meet the specification, and why the others miss it.
    fn specification(&self, truth: Option<usize>) -> Vec<String> {
        let (mut sentences, mut meet) = (Vec::new(), Vec::new());
        for (index, controller) in self.controllers.iter().enumerate() {
            let counts = |run: &ComparedRun| {
                run.controller == index && truth.is_none_or(|truth| run.plant == truth)
            };
            let missed: Vec<(&ComparedRun, &Outcome)> = self
                .runs
                .iter()
                .zip(self.outcomes)
                .filter(|(run, j)| counts(run) && !j.shortfalls.is_empty())
                .collect();
            if missed.is_empty() {
                meet.push(controller.label.as_str());
            }
            for (run, j) in missed {
                let cause = match j.cause.as_ref() {
                    Some(c) => format!(": {c}"),
                    None => String::new(),
                };
                sentences.push(format!(
                    "The controller of {} misses the specification on {}, by {}{cause}.",
                    controller.label,
                    self.plants[run.plant].label,
                    j.shortfalls.join(" and ")
                ));
            }
        }
        let on = truth.map_or("every model's plant", |truth| self.plants[truth].label.as_str());
        let first = match meet[..] {
            [] => format!("No controller meets the specification on {on}."),
            [one] => format!("The controller of {one} meets the specification on {on}."),
            _ => format!(
                "On {on} the specification is met by the controllers of {}.",
                meet.join(", ")
            ),
        };
        sentences.insert(0, first);
        sentences
    }

    /// The controllers that are unstable or off the path, and where.
    fn astray(&self) -> Vec<String> {
        let one = |(run, result): (&ComparedRun, &Outcome)| {
            let controller = &self.controllers[run.controller].label;
            let plant = &self.plants[run.plant].label;
            let at = match run.off_path_at_m {
                Some(at) => format!(" after {at:.0} m"),
                None => String::new(),
            };
            match result.outcome {
                Class::Unstable => {
                    Some(format!("The controller of {controller} is unstable on {plant}{at}."))
                }
                Class::OffThePath => Some(format!(
                    "The controller of {controller} is off the path on {plant}{at}, by {:.1} m.",
                    run.errors.cross_track_max_m
                )),
                _ => None,
            }
        };
        self.runs.iter().zip(self.outcomes).filter_map(one).collect()
    }
}

/// The controller that tracks best, and the sentence about it.
fn tracking(figures: &[Figure], on: &str) -> (Option<String>, Option<String>) {
    let mut kept: Vec<(&str, f64)> =
        figures.iter().filter_map(|j| Some((j.controller.as_str(), j.value?))).collect();
    kept.sort_by(|a, b| a.1.total_cmp(&b.1));
    let [(name, best), others @ ..] = &kept[..] else { return (None, None) };
    let figure = |m: f64| format!("{m:.3} m");
    let differs = |other: f64| other - best >= LEAST_TRACKING_M.max(LEAST_SHARE * other);
    let some_left = figures.len() > kept.len();
    let Some((_, next)) = others.first() else {
        let sentence = if some_left {
            Some(format!(
                "On {on} only the controller of {name} stays on the path, to {} RMS.",
                figure(*best)
            ))
        } else {
            None
        };
        return (some_left.then(|| (*name).to_owned()), sentence);
    };
    let list = |all: &[(&str, f64)]| {
        let each: Vec<String> = all.iter().map(|(n, m)| format!("{n} {}", figure(*m))).collect();
        each.join(", ")
    };
    if !differs(*next) {
        let (mut same, apart): (Vec<_>, Vec<_>) = kept.iter().partition(|(_, m)| !differs(*m));
        // Controllers without a difference keep the order of the table.
        let place = |n: &str| figures.iter().position(|j| j.controller == n);
        same.sort_by_key(|(n, _)| place(n));
        let behind = if apart.is_empty() {
            String::new()
        } else {
            format!("; behind them: {}", list(&apart))
        };
        let sentence = format!(
            "On {on} there is no difference beyond {LEAST_TRACKING_M} m and {:.0} % in RMS \
             cross-track error: {}{behind}.",
            100.0 * LEAST_SHARE,
            list(&same)
        );
        return (None, Some(sentence));
    }
    let less = 100.0 * (1.0 - best / next);
    let sentence = format!(
        "On {on} the controller of {name} tracks best: {} RMS cross-track error against {}, {less:.0} % \
         less than the next.",
        figure(*best),
        list(others)
    );
    (Some((*name).to_owned()), Some(sentence))
}

/// The step that each model predicts, and the step on the truth.
fn predictions(controllers: &[Controller], runs: &[ComparedRun], truth: usize) -> Vec<String> {
    let settled =
        |s: Option<f64>| s.map_or("never settled".into(), |s| format!("settled in {s:.2} s"));
    let one = |(index, controller): (usize, &Controller)| {
        let run = runs.iter().find(|r| r.controller == index && r.plant == truth)?;
        let (predicted, reached) = (&controller.predicted, &run.step);
        Some(format!(
            "{}: predicted overshoot {:.1} %, {}; on the truth {:.1} %, {}.",
            controller.label,
            predicted.overshoot_percent,
            settled(predicted.settling_time_s),
            reached.overshoot_percent,
            settled(reached.settling_time_s)
        ))
    };
    controllers.iter().enumerate().filter_map(one).collect()
}

/// The model whose simulation is closest to the drive.
fn fits(drive: &ComparedDrive, models: &[ComparedModel]) -> Option<String> {
    let mut all: Vec<(&str, f64)> =
        models.iter().zip(&drive.models).map(|(m, d)| (m.label.as_str(), d.fit_percent)).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let [(name, best), (next, other), ..] = all[..] else { return None };
    Some(if best - other < LEAST_FIT {
        format!("On the drive the fits of {name} and {next} differ by less than {LEAST_FIT} %.")
    } else {
        format!(
            "On the drive {name} has the largest fit, {best:.1} %; that of {next} is {other:.1} %."
        )
    })
}

/// Different margins of the controllers.
fn margins(controllers: &[Controller]) -> Option<String> {
    let margin = |c: &Controller| c.pid.evidence.margins.modulus_margin;
    let least = controllers.iter().min_by(|a, b| margin(a).total_cmp(&margin(b)))?;
    let most = controllers.iter().max_by(|a, b| margin(a).total_cmp(&margin(b)))?;
    if margin(most) - margin(least) >= LEAST_MARGIN {
        Some(format!(
            "The margins are not equal: on their own models the modulus margin of {} is {:.2}, that \
             of {} {:.2}.",
            least.label,
            margin(least),
            most.label,
            margin(most)
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conclusion(all: &[(&str, Option<f64>)]) -> (Option<String>, String) {
        let figures: Vec<Figure> = all
            .iter()
            .map(|(name, value)| Figure { controller: (*name).into(), value: *value })
            .collect();
        let (best, sentence) = tracking(&figures, "the car");
        (best, sentence.unwrap_or_default())
    }

    #[test]
    fn small_differences_are_not_reported() {
        for all in [
            // Below the accuracy of a receiver, though a third of the larger one.
            [("a", Some(0.016)), ("b", Some(0.011))],
            // Above it, though 3 %.
            [("a", Some(1.00)), ("b", Some(1.03))],
        ] {
            let (best, sentence) = conclusion(&all);
            assert!(best.is_none() && sentence.contains("no difference beyond"), "{sentence}");
        }
        let all = [("a", Some(0.10)), ("b", Some(0.05))];
        let (best, sentence) = conclusion(&all);
        assert_eq!(best.as_deref(), Some("b"));
        assert!(
            sentence.contains("0.050 m RMS cross-track error against a 0.100 m, 50 %"),
            "{sentence}"
        );
        // Whatever the order.
        assert_eq!(conclusion(&[all[1], all[0]]), (best, sentence));
    }

    #[test]
    fn controllers_without_a_difference_are_listed_together() {
        let (best, sentence) =
            conclusion(&[("c", Some(0.2)), ("b", Some(0.052)), ("a", Some(0.05))]);
        assert!(best.is_none());
        assert!(sentence.ends_with("b 0.052 m, a 0.050 m; behind them: c 0.200 m."), "{sentence}");
    }

    #[test]
    fn controllers_off_the_path_are_not_compared() {
        let (best, sentence) = conclusion(&[("a", None), ("b", Some(0.5))]);
        assert_eq!(best.as_deref(), Some("b"));
        assert!(sentence.contains("only the controller of b stays on the path"), "{sentence}");
        assert_eq!(conclusion(&[("a", None), ("b", None)]), (None, String::new()));
    }
}
