//! Where among sorted distances one lies, without a search.
//!
//! A table holds how many distances lie before each of equal intervals, twice as many as there are gaps.
//! Where the distances are about evenly spaced, an interval holds at most one of them; where they are not,
//! it is a binary search within one interval. The result depends on the distance alone.

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Intervals {
    start: f64,
    /// Intervals a metre.
    density: f64,
    /// How many distances lie before each interval, and at last how many there are.
    before: Vec<usize>,
    /// And one more, beyond all.
    distances: Vec<f64>,
}

impl Intervals {
    /// Of distances that do not fall.
    pub(crate) fn from_distances(distances: &[f64]) -> Self {
        let count = 2 * distances.len().saturating_sub(1).max(1);
        let (start, end) = match distances {
            [first, .., last] => (*first, *last),
            _ => (0.0, 1.0),
        };
        let density = count as f64 / (end - start);
        let padded = distances.iter().copied().chain([f64::INFINITY]).collect();
        let mut table = Self { start, density, before: vec![0; count + 1], distances: padded };
        for distance in distances {
            let interval = table.interval(*distance);
            table.before[interval + 1] += 1;
        }
        for interval in 0..count {
            table.before[interval + 1] += table.before[interval];
        }
        table
    }

    /// How many of the distances are not above one.
    #[inline]
    pub(crate) fn count(&self, distance: f64) -> usize {
        let interval = self.interval(distance);
        let (first, end) = (self.before[interval], self.before[interval + 1]);
        if end - first > 1 {
            return first + self.distances[first..end].partition_point(|d| *d <= distance);
        }
        // Without a branch that nothing predicts: of an empty interval it is the first of a later one,
        // which is above.
        let found = first + usize::from(self.distances[first] <= distance);
        // An infinite distance is not below the one beyond all.
        found.min(self.distances.len() - 1)
    }

    /// The same rounding for distances of the table and for those looked up: of two distances the larger
    /// is never in an earlier interval.
    fn interval(&self, distance: f64) -> usize {
        // A distance before the start, or NaN, is in the first.
        (((distance - self.start) * self.density) as usize).min(self.before.len() - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            let table = Intervals::from_distances(&all);
            let end = all[all.len() - 1];
            let between = start + at * (end - start);
            let odd = [between, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX];
            let near = all.iter().flat_map(|d| [*d, d.next_up(), d.next_down()]);
            for distance in odd.into_iter().chain(near) {
                prop_assert_eq!(
                    table.count(distance),
                    all.partition_point(|d| *d <= distance)
                );
            }
        }
    }

    /// However many there are, at most one is left to look at.
    #[test]
    fn evenly_spaced_distances_are_found_at_once() {
        for count in [2, 100, 100_000] {
            let all: Vec<f64> = (0..count).map(|i| 7.3 + 0.1 * f64::from(i)).collect();
            let table = Intervals::from_distances(&all);
            let near = |d: &f64| {
                let interval = table.interval(d + 0.05);
                table.before[interval + 1] - table.before[interval]
            };
            let most = all.iter().map(near).max();
            assert!(most <= Some(1), "{count}: {most:?}");
        }
    }

    #[test]
    fn no_distance_is_too_large() {
        let equal = vec![186_020.5; 2];
        for all in [vec![-f64::MAX, 0.0, f64::MAX], vec![0.0, 1e-310, 2e-310], equal, vec![]] {
            let table = Intervals::from_distances(&all);
            for d in all.iter().copied().chain([0.0, 5e-311, 1e300, -1e300, f64::INFINITY]) {
                assert_eq!(table.count(d), all.partition_point(|x| *x <= d));
            }
        }
    }
}
