//! Long series made short without a visible change.
//!
//! Along a time axis, each column of pixels keeps its first, least, largest and last point, so that
//! no peak is lost. A curve in the plane, and the rest of either, loses the points that lie within a
//! tenth of a pixel of the line that stays (Ramer 1972; Douglas and Peucker 1973).

/// A point in pixels.
pub(crate) type Pixel = (f64, f64);

/// Cuts a series where a value cannot be drawn: a gap, not a bridge.
pub(crate) fn segments(points: impl Iterator<Item = Option<Pixel>>) -> Vec<Vec<Pixel>> {
    let mut out = vec![Vec::new()];
    for point in points {
        match (point, out.last_mut()) {
            (Some(p), Some(segment)) => segment.push(p),
            _ => out.push(Vec::new()),
        }
    }
    out.retain(|segment| !segment.is_empty());
    out
}

/// At most about `budget` points that look the same.
pub(crate) fn decimate(segment: &[Pixel], budget: usize) -> Vec<Pixel> {
    let forward = segment.windows(2).all(|w| w[1].0 >= w[0].0);
    let reduced = if forward { extremes(segment, budget) } else { thinned(segment, budget) };
    simplified(&reduced, 0.1)
}

/// First, least, largest and last point of each column of pixels, in their order.
fn extremes(segment: &[Pixel], budget: usize) -> Vec<Pixel> {
    let (Some(first), Some(last)) = (segment.first(), segment.last()) else { return Vec::new() };
    let columns = ((last.0 - first.0).ceil()).clamp(1.0, (budget as f64 / 4.0).max(1.0));
    let column = |p: &Pixel| {
        let length = (last.0 - first.0).max(f64::MIN_POSITIVE);
        ((p.0 - first.0) / length * columns).floor().min(columns - 1.0)
    };
    let mut out = Vec::new();
    let mut start = 0;
    while start < segment.len() {
        let here = column(&segment[start]);
        let length = segment[start..].iter().take_while(|p| column(p) == here).count().max(1);
        let part = &segment[start..start + length];
        let by = |a: &(usize, &Pixel), b: &(usize, &Pixel)| a.1.1.total_cmp(&b.1.1);
        let least = part.iter().enumerate().min_by(by).map_or(0, |(i, _)| i);
        let largest = part.iter().enumerate().max_by(by).map_or(0, |(i, _)| i);
        let mut keep = vec![0, least, largest, length - 1];
        keep.sort_unstable();
        keep.dedup();
        out.extend(keep.into_iter().map(|i| part[i]));
        start += length;
    }
    out
}

/// Points at least a distance apart that grows until they are few enough.
fn thinned(segment: &[Pixel], budget: usize) -> Vec<Pixel> {
    let mut apart = 0.25;
    loop {
        let mut out: Vec<Pixel> = Vec::new();
        for (i, p) in segment.iter().enumerate() {
            let far = out.last().is_none_or(|q| (p.0 - q.0).hypot(p.1 - q.1) >= apart);
            if far || i + 1 == segment.len() {
                out.push(*p);
            }
        }
        if out.len() <= budget.max(2) || apart > 1e6 {
            return out;
        }
        apart *= 1.5;
    }
}

/// Ramer–Douglas–Peucker with a list of intervals in place of recursion.
fn simplified(points: &[Pixel], tolerance: f64) -> Vec<Pixel> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((a, b)) = open.pop() {
        let farthest = (a + 1..b)
            .map(|i| (i, distance_to_chord(points[i], points[a], points[b])))
            .max_by(|p, q| p.1.total_cmp(&q.1));
        if let Some((i, distance)) = farthest
            && distance > tolerance
        {
            keep[i] = true;
            open.push((a, i));
            open.push((i, b));
        }
    }
    points.iter().zip(keep).filter_map(|(p, k)| if k { Some(*p) } else { None }).collect()
}

fn distance_to_chord(p: Pixel, a: Pixel, b: Pixel) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p.0 - a.0 - along * dx).hypot(p.1 - a.1 - along * dy)
}

/// The parts of a polyline inside the rectangle (Liang and Barsky 1984), as polylines.
pub(crate) fn clipped(
    line: &[Pixel],
    (left, top, right, bottom): (f64, f64, f64, f64),
) -> Vec<Vec<Pixel>> {
    let mut out: Vec<Vec<Pixel>> = Vec::new();
    let mut joined = false;
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (step, room) in
            [(-dx, a.0 - left), (dx, right - a.0), (-dy, a.1 - top), (dy, bottom - a.1)]
        {
            if step == 0.0 {
                if room < 0.0 {
                    leave = -1.0;
                }
            } else if step < 0.0 {
                enter = enter.max(room / step);
            } else {
                leave = leave.min(room / step);
            }
        }
        if enter > leave {
            joined = false;
            continue;
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        match out.last_mut() {
            Some(last) if joined && enter == 0.0 => last.push(at(leave)),
            _ => out.push(vec![at(enter), at(leave)]),
        }
        joined = leave == 1.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_gap_is_not_bridged() {
        let points = [Some((0.0, 1.0)), Some((1.0, 2.0)), None, None, Some((4.0, 3.0))];
        assert_eq!(
            segments(points.into_iter()),
            vec![vec![(0.0, 1.0), (1.0, 2.0)], vec![(4.0, 3.0)]]
        );
    }

    #[test]
    fn a_spike_of_one_sample_survives() {
        let mut points: Vec<Pixel> = (0..100_000).map(|k| (f64::from(k) * 0.007, 50.0)).collect();
        points[43_210].1 = 3.0;
        let short = decimate(&points, 2000);
        assert!(short.len() < 20, "{}", short.len());
        assert!(short.contains(&points[43_210]));
        assert_eq!(short.last(), points.last());
    }

    #[test]
    fn a_circle_stays_a_circle() {
        let circle: Vec<Pixel> = (0..20_000)
            .map(|k| (f64::from(k) * 1e-3).sin_cos())
            .map(|(s, c)| (200.0 * c, 200.0 * s))
            .collect();
        let short = decimate(&circle, 1000);
        assert!(short.len() < 1000);
        for pair in short.windows(2) {
            let middle = (0.5 * (pair[0].0 + pair[1].0), 0.5 * (pair[0].1 + pair[1].1));
            assert!((middle.0.hypot(middle.1) - 200.0).abs() < 0.5);
        }
    }

    #[test]
    fn clipping_cuts_at_the_edge_and_keeps_pieces_apart() {
        let line = [(-10.0, 5.0), (5.0, 5.0), (5.0, 30.0), (8.0, 30.0), (8.0, 5.0)];
        assert_eq!(
            clipped(&line, (0.0, 0.0, 10.0, 10.0)),
            vec![vec![(0.0, 5.0), (5.0, 5.0), (5.0, 10.0)], vec![(8.0, 10.0), (8.0, 5.0)]]
        );
    }

    proptest! {
        #[test]
        fn the_result_is_short_and_keeps_the_extremes(
            values in prop::collection::vec(-1e3..1e3f64, 1..3000)
        ) {
            let points: Vec<Pixel> =
                values.iter().enumerate().map(|(i, v)| (i as f64 * 0.2, *v)).collect();
            let short = decimate(&points, 400);
            prop_assert!(short.len() <= 400 + 4);
            let top = |p: &[Pixel]| p.iter().fold(f64::MIN, |m, q| m.max(q.1));
            // The last pass may cut a peak by its tolerance.
            prop_assert!((top(&short) - top(&points)).abs() <= 0.1);
        }
    }
}
