//! Where each requirement is no longer kept, going away from what was designed for.

use crate::requirement::{Reached, Requirement};
use formats::{Breaking, Specification};

/// Steps to either side, and halvings of the one in which a requirement breaks.
const STEPS: u32 = 40;
const HALVINGS: u32 = 8;

/// For each requirement kept at `nominal`, the values to either side within `looked` from which on it
/// is not; `reached` is `None` where there is no plant to control.
pub(crate) fn breaking(
    spec: &Specification,
    nominal: f64,
    looked: [f64; 2],
    reached: impl Fn(f64) -> Option<Reached>,
) -> Vec<Breaking> {
    let asked: Vec<(Requirement, f64)> = Requirement::ALL
        .into_iter()
        .filter_map(|r| Some((r, r.required(spec)?)))
        .filter(|(r, required)| reached(nominal).is_some_and(|x| r.is_met(*required, x.value(*r))))
        .collect();
    let mut all: Vec<Breaking> = asked
        .iter()
        .map(|(r, _)| Breaking { requirement: r.name().into(), below: None, above: None, looked })
        .collect();
    for (side, end) in looked.into_iter().enumerate() {
        if (end - nominal).abs() < 1e-9 {
            continue;
        }
        let mut before = nominal;
        for step in 1..=STEPS {
            // Near the nominal value in small steps, for that is where it matters.
            let share = f64::from(step) / f64::from(STEPS);
            let value = nominal + (end - nominal) * share * (0.4 + 0.6 * share);
            let now = reached(value);
            for ((r, required), breaking) in asked.iter().zip(&mut all) {
                let found = if side == 0 { &mut breaking.below } else { &mut breaking.above };
                let kept =
                    |x: &Option<Reached>| x.is_some_and(|x| r.is_met(*required, x.value(*r)));
                if found.is_none() && !kept(&now) {
                    let (mut inside, mut outside) = (before, value);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (inside + outside);
                        if kept(&reached(middle)) { inside = middle } else { outside = middle }
                    }
                    *found = Some(inside);
                }
            }
            before = value;
            let broken = |b: &Breaking| if side == 0 { b.below } else { b.above };
            if all.iter().all(|b| broken(b).is_some()) {
                break;
            }
        }
    }
    all
}
