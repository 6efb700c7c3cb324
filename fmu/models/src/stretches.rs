//! Where among sorted distances one lies, without a search.
//!
//! The way is cut into as many equal stretches as there are intervals, and a table says how many
//! distances lie before each. Where these are about evenly spaced, a stretch holds one or two of them and
//! the answer costs the same however many there are; where they are not, it is a binary search within
//! one stretch. Nothing is remembered from one question to the next, so the answer depends on the
//! distance alone and is that of a search of all.

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretches {
    start: f64,
    /// Stretches a metre.
    density: f64,
    /// How many distances lie before each stretch, and at last how many there are.
    before: Vec<usize>,
}

impl Stretches {
    /// Of distances that do not fall.
    pub(crate) fn of(distances: &[f64]) -> Self {
        let count = distances.len().saturating_sub(1).max(1);
        let (start, end) = match distances {
            [first, .., last] => (*first, *last),
            _ => (0.0, 1.0),
        };
        let density = count as f64 / (end - start);
        let mut table = Self { start, density, before: vec![0; count + 1] };
        for distance in distances {
            let stretch = table.stretch(*distance);
            table.before[stretch + 1] += 1;
        }
        for stretch in 0..count {
            table.before[stretch + 1] += table.before[stretch];
        }
        table
    }

    /// Between which of the distances those lie that one may be next to: all before are not above it,
    /// all from the end on are above it.
    pub(crate) fn around(&self, distance: f64) -> std::ops::Range<usize> {
        let stretch = self.stretch(distance);
        self.before[stretch]..self.before[stretch + 1]
    }

    /// The same rounding for distances of the table and for those looked up: of two distances the larger
    /// is never in an earlier stretch.
    fn stretch(&self, distance: f64) -> usize {
        // What is before the start, or no number, is in the first.
        (((distance - self.start) * self.density) as usize).min(self.before.len() - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(table: &Stretches, all: &[f64], distance: f64) -> usize {
        let near = table.around(distance);
        near.start + all[near].partition_point(|d| *d <= distance)
    }

    proptest! {
        /// Evenly spaced or bunched, of any size: what a binary search of all finds.
        #[test]
        fn finds_what_a_search_of_all_finds(
            start in -1e6..1e6_f64,
            steps in prop::collection::vec((0.0..1.0_f64, -9..5_i32), 1..60),
            at in -0.2..1.2_f64,
        ) {
            let mut all = vec![start];
            for (step, exponent) in steps {
                all.push(all[all.len() - 1] + step * 10.0_f64.powi(exponent));
            }
            let table = Stretches::of(&all);
            let end = all[all.len() - 1];
            let between = start + at * (end - start);
            let odd = [between, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX];
            let near = all.iter().flat_map(|d| [*d, d.next_up(), d.next_down()]);
            for distance in odd.into_iter().chain(near) {
                prop_assert_eq!(
                    found(&table, &all, distance),
                    all.partition_point(|d| *d <= distance)
                );
            }
        }
    }

    /// However many there are, one or two are left to look at.
    #[test]
    fn evenly_spaced_distances_are_found_at_once() {
        for count in [2, 100, 100_000] {
            let all: Vec<f64> = (0..count).map(|i| 7.3 + 0.1 * f64::from(i)).collect();
            let table = Stretches::of(&all);
            let most = all.iter().map(|d| table.around(d + 0.05).len()).max();
            assert!(most <= Some(3), "{count}: {most:?}");
        }
    }

    #[test]
    fn no_distance_is_too_large() {
        for all in [vec![-f64::MAX, 0.0, f64::MAX], vec![0.0, 1e-310, 2e-310], vec![]] {
            let table = Stretches::of(&all);
            for d in all.iter().copied().chain([0.0, 5e-311, 1e300, -1e300]) {
                assert_eq!(found(&table, &all, d), all.partition_point(|x| *x <= d));
            }
        }
    }
}
