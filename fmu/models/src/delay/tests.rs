use super::*;
use proptest::prelude::*;

fn walk_ramp(line: &mut DelayLine, step: f64, value: f64, slope: f64) -> Vec<Segment> {
    line.push(step, value, slope).unwrap();
    let (mut left, mut pieces) = (step, Vec::new());
    while left > 0.0 {
        let piece = line.next(left);
        pieces.push(piece);
        left -= piece.duration;
    }
    pieces
}

/// Lengths and values of the delayed input over a step, by walking.
fn walk(line: &mut DelayLine, step: f64, value: f64) -> Vec<(f64, f64)> {
    walk_ramp(line, step, value, 0.0).iter().map(|s| (s.duration, s.value)).collect()
}

proptest! {
    /// Against the definition: the value that was set `delay` ago.
    #[test]
    fn is_the_input_of_a_while_ago(
        delay in 0.001..0.5_f64,
        steps in prop::collection::vec((0.001..0.1_f64, -3..3_i32), 1..200),
    ) {
        let mut line = DelayLine::new(delay, 9.0);
        let mut history = vec![(-delay, 9.0)];
        let mut time = 0.0;
        for (step, value) in steps {
            let value = f64::from(value);
            history.push((time, value));
            for (piece, u) in walk(&mut line, step, value) {
                let middle = time + piece / 2.0 - delay;
                let expected = history.iter().rev().find(|(t, _)| *t <= middle).unwrap().1;
                if piece > 1e-9 {
                    prop_assert_eq!(u, expected);
                }
                time += piece;
            }
        }
    }
}

proptest! {
    /// Ramps come out as they went in, later, however they are cut.
    #[test]
    fn ramps_are_delayed(
        delay in 0.001..0.5_f64,
        steps in prop::collection::vec((0.001..0.1_f64, -3.0..3.0_f64, -9.0..9.0_f64), 1..200),
    ) {
        let mut line = DelayLine::new(delay, 9.0);
        let mut history = vec![(-delay, 9.0, 0.0)];
        let mut time = 0.0;
        for (step, value, slope) in steps {
            history.push((time, value, slope));
            let mut restored = DelayLine::new(delay, 0.0);
            restored.restore(line.save()).unwrap();
            prop_assert_eq!(restored.save(), line.save());
            let pieces = walk_ramp(&mut line, step, value, slope);
            prop_assert_eq!(&walk_ramp(&mut restored, step, value, slope), &pieces);
            for piece in pieces {
                if piece.duration > 1e-9 {
                    let at = time + piece.duration / 2.0 - delay;
                    let (t, v, s) = *history.iter().rev().find(|(t, ..)| *t <= at).unwrap();
                    prop_assert_eq!(piece.slope, s);
                    prop_assert!((piece.value - (v + s * (time - delay - t).max(0.0))).abs() < 1e-9);
                }
                time += piece.duration;
            }
        }
    }
}

/// A ramp in steps too short to be remembered one by one is still the ramp.
#[test]
fn merged_ramps_stay_ramps() {
    let mut line = DelayLine::new(1.0, 0.0);
    let h = 1e-5;
    for k in 0..300_000 {
        for piece in walk_ramp(&mut line, h, 2.0 * f64::from(k) * h, 2.0) {
            let expected = (2.0 * (f64::from(k) * h - 1.0)).max(0.0);
            assert!((piece.value - expected).abs() < 3e-5, "{k}: {piece:?} {expected}");
        }
    }
    assert!(line.len() <= 2 * RESOLUTION as usize + 2);
}

#[test]
fn histories_that_cannot_be_are_refused() {
    let mut line = DelayLine::new(0.1, 0.0);
    for k in 0..10 {
        walk(&mut line, 0.03, f64::from(k));
    }
    let good = line.save();
    let refused = |change: &dyn Fn(&mut History)| {
        let (mut history, mut line) = (good.clone(), line.clone());
        change(&mut history);
        assert!(line.restore(history).is_err());
    };
    assert!(line.clone().restore(good.clone()).is_ok());
    refused(&|h| h.segments.clear());
    refused(&|h| h.segments[1].value = f64::NAN);
    refused(&|h| h.segments[0].slope = f64::INFINITY);
    refused(&|h| h.segments[1].duration += 0.001);
    refused(&|h| h.segments[1].duration = -0.01);
    refused(&|h| h.segments.extend(vec![Segment::default(); 9000]));
    refused(&|h| h.latest.value = f64::INFINITY);
    assert!(DelayLine::new(0.0, 0.0).restore(good).is_err());
}

#[test]
fn steps_on_the_grid_leave_no_slivers() {
    let mut line = DelayLine::new(0.05, 0.0);
    for k in 0..100_000 {
        let value = f64::from(k % 97);
        let pieces = walk(&mut line, 0.01, value);
        assert_eq!(pieces.len(), 1);
        assert_eq!(pieces[0].0, 0.01);
        if k >= 5 {
            assert_eq!(pieces[0].1, f64::from((k - 5) % 97));
        }
    }
}

#[test]
fn bounded_and_keeps_the_integral() {
    let mut line = DelayLine::new(1.0, 0.0);
    let (mut into, mut out) = (0.0, 0.0);
    for k in 0..300_000 {
        let value = f64::from(k % 7);
        into += value * 1e-5;
        out += walk(&mut line, 1e-5, value).iter().map(|(t, u)| t * u).sum::<f64>();
        assert!(line.len() <= 2 * RESOLUTION as usize + 2);
    }
    out += walk(&mut line, 1.0, 0.0).iter().map(|(t, u)| t * u).sum::<f64>();
    assert!((into - out).abs() < 1e-9, "{into} {out}");
}

/// One segment, shortened and lengthened by steps that are no binary fractions.
#[test]
fn a_held_input_is_saved_alike_before_and_after_it_is_restored() {
    let mut line = DelayLine::new(0.025, 1.0);
    for _ in 0..1000 {
        walk(&mut line, 0.001, 1.0);
        let mut restored = DelayLine::new(0.025, 0.0);
        restored.restore(line.save()).unwrap();
        assert_eq!(restored.save(), line.save());
    }
}

#[test]
fn an_input_beyond_all_numbers_is_refused() {
    let mut line = DelayLine::new(0.1, 1.0);
    let before = line.clone();
    for (value, slope) in
        [(f64::INFINITY, 0.0), (f64::NAN, 0.0), (1e308, 1e308), (0.0, f64::NEG_INFINITY)]
    {
        assert!(line.push(10.0, value, slope).is_err(), "{value} {slope}");
        assert_eq!(line, before);
    }
}

#[test]
fn without_delay_the_input_passes() {
    let mut line = DelayLine::new(0.0, 0.0);
    assert_eq!(walk(&mut line, 0.01, 3.0), [(0.01, 3.0)]);
    assert_eq!(line.output(4.0, 0.5), (4.0, 0.5));
}
