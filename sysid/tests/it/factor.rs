//! The factor of the data: the same by every way to compute it, however the samples come, and a clear
//! word where the data are not good for it.

use crate::known::{Random, markov_distance};
use faer::Mat;
use steerwright_sysid::subspace::{
    Accumulator, Decomposition, Factor, shift_realization, structured_bd, subspace,
};
use steerwright_sysid::{DataSet, Error, Segment, Signals, StateSpace, Weighting, simulate};

/// L by its definition: all windows of all segments written out, and one QR factorisation.
fn written_out(segments: &[Segment], s: usize) -> Mat<f64> {
    let mut columns = Vec::new();
    for segment in segments {
        let (u, y) = (&segment.u, &segment.y);
        for t in 0..(segment.len() + 1).saturating_sub(2 * s) {
            let rows = |m: &Signals, from: usize| -> Vec<f64> {
                (from..from + s)
                    .flat_map(|lag| (0..m.nrows()).map(move |c| (c, t + lag)))
                    .map(|(c, t)| m[(c, t)])
                    .collect()
            };
            columns.push([rows(u, s), rows(u, 0), rows(y, 0), rows(y, s)].concat());
        }
    }
    let scale = 1.0 / (columns.len() as f64).sqrt();
    let h = Mat::from_fn(columns.len(), columns[0].len(), |t, i| columns[t][i] * scale);
    let r = h.qr().thin_R().to_owned();
    Mat::from_fn(
        r.ncols(),
        r.ncols(),
        |i, j| {
            if j > i { 0.0 } else { r[(j, i)] * r[(j, j)].signum() }
        },
    )
}

/// Largest difference of a row over the row's length.
fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    assert_eq!((a.nrows(), a.ncols()), (b.nrows(), b.ncols()));
    let row = |i: usize| (a.row(i) - b.row(i)).norm_l2() / b.row(i).norm_l2();
    (0..a.nrows()).map(row).fold(0.0, f64::max)
}

/// A drive of a random system with noise on its output.
fn drive(random: &mut Random, (m, p): (usize, usize), count: usize, noise: f64) -> Segment {
    let truth = random.system(3, m, p);
    let u = random.matrix(m, count);
    let e = random.matrix(p, count);
    let y = simulate(&truth, u.as_ref(), &[0.5; 3]);
    Segment::new(u, Mat::from_fn(p, count, |i, t| y[(i, t)] + noise * e[(i, t)]))
}

fn moved(m: &Signals, scale: f64, offset: f64) -> Signals {
    Signals::from_fn(m.nrows(), m.ncols(), |i, t| scale * m[(i, t)] + offset)
}

#[test]
fn both_decompositions_lead_to_the_factor_of_the_definition() {
    let mut random = Random(11);
    // More than one block of 1024 windows, so that sums and edges are put together.
    for (channels, s, count) in [((1, 1), 15, 3000), ((2, 3), 4, 1500), ((0, 2), 5, 700)] {
        let segments = vec![drive(&mut random, channels, count, 0.1)];
        let reference = written_out(&segments, s);
        let data = DataSet::new(1.0, segments).unwrap();
        for kind in [Decomposition::Gram, Decomposition::Qr] {
            let factor = by(kind, &data, s);
            let error = distance(&factor.l, &reference);
            assert!(error < 1e-12, "{kind:?} {channels:?}: {error:e}");
            assert_eq!(factor.columns, count + 1 - 2 * s);
        }
        let how = Factor::new(&data, s).unwrap().conditioning;
        assert!(how.method == Decomposition::Gram && how.condition > 1.0);
        assert!((1.0..=how.condition).contains(&how.input_condition));
    }
}

#[test]
fn the_gram_matrix_loses_digits_with_the_condition_squared_and_is_left_in_time() {
    let mut random = Random(12);
    for exponent in 1..=10 {
        let segments = vec![drive(&mut random, (1, 1), 2000, 10f64.powi(-exponent))];
        let reference = written_out(&segments, 8);
        let data = DataSet::new(1.0, segments).unwrap();
        let factor = Factor::new(&data, 8).unwrap();
        let error = distance(&factor.l, &reference);
        let how = factor.conditioning;
        assert!(!how.is_reduced());
        let by_gram = how.method == Decomposition::Gram;
        assert!(!by_gram || how.condition < 1e6);
        // The reference itself is no better than the condition allows.
        let most = if by_gram { 1e-14 * how.condition.powi(2) } else { 1e-12 };
        assert!(error < most.max(1e-13), "{exponent}: {error:e} {}", factor.conditioning);
        assert!(if exponent < 5 { by_gram } else { exponent < 8 || !by_gram }, "{exponent}");
    }
}

#[test]
fn a_smaller_horizon_is_cut_from_the_same_windows() {
    let mut random = Random(13);
    let data = DataSet::new(1.0, vec![drive(&mut random, (1, 2), 900, 0.1)]).unwrap();
    let segment = &data.segments()[0];
    for kind in [Decomposition::Gram, Decomposition::Qr] {
        let cut = by(kind, &data, 9).with_horizon(5).unwrap();
        // The windows of 18 samples leave out 4 samples on both sides of those of 10.
        let inner = Segment::new(segment.u.columns(4..896), segment.y.columns(4..896));
        let error = distance(&cut.l, &written_out(&[inner], 5));
        assert!(error < 1e-12, "{kind:?}: {error:e}");
    }
}

fn accumulate(kind: Decomposition, s: usize, segment: &Segment, chunk: usize) -> Accumulator {
    let mut sums = Accumulator::new(kind, s, (segment.u.nrows(), segment.y.nrows()), 1.0).unwrap();
    let mut start = 0;
    while start < segment.len() {
        let end = (start + chunk).min(segment.len());
        sums.push(segment.u.columns(start..end), segment.y.columns(start..end)).unwrap();
        start = end;
    }
    sums
}

fn by(kind: Decomposition, data: &DataSet, s: usize) -> Factor {
    let mut sums = Accumulator::new(kind, s, (data.inputs(), data.outputs()), 1.0).unwrap();
    for segment in data.segments() {
        sums.push(segment.u.as_ref(), segment.y.as_ref()).unwrap();
        sums.end_segment();
    }
    sums.factor().unwrap()
}

#[test]
fn chunks_do_not_matter_to_the_last_bit() {
    let mut random = Random(14);
    let segment = drive(&mut random, (1, 2), 2600, 0.1);
    let data = DataSet::new(1.0, vec![segment.clone()]).unwrap();
    for kind in [Decomposition::Gram, Decomposition::Qr] {
        let whole = by(kind, &data, 7);
        for chunk in [1, 7, 1000, 1024, 1037, 2599, 2600] {
            let parts = accumulate(kind, 7, &segment, chunk).factor().unwrap();
            assert_eq!(parts.l, whole.l, "{kind:?} {chunk}");
        }
    }
}

#[test]
fn merged_states_are_one_pass() {
    let mut random = Random(15);
    // Different offsets, so that different constants were taken off.
    let segments: Vec<Segment> = [900, 13, 1500, 40]
        .into_iter()
        .enumerate()
        .map(|(k, count)| {
            let d = drive(&mut random, (1, 1), count, 0.1);
            Segment::new(moved(&d.u, 1.0, k as f64), moved(&d.y, 1.0, -3.0 * k as f64))
        })
        .collect();
    let s = 7;
    let reference = written_out(&segments, s);
    let data = DataSet::new(1.0, segments.clone()).unwrap();
    for kind in [Decomposition::Gram, Decomposition::Qr] {
        let whole = by(kind, &data, s);
        assert!(distance(&whole.l, &reference) < 1e-12, "{kind:?}");
        // The second is shorter than a window, and first in this order.
        let mut merged = accumulate(kind, s, &segments[1], 5);
        for k in [3, 0, 2] {
            merged.merge(accumulate(kind, s, &segments[k], 100)).unwrap();
        }
        assert_eq!(merged.samples(), 900 + 13 + 1500 + 40);
        let merged = merged.factor().unwrap();
        assert_eq!(merged.columns, whole.columns);
        let error = distance(&merged.l, &whole.l);
        assert!(error < 1e-12, "{kind:?}: {error:e}");
    }
}

#[test]
fn one_log_on_two_machines_is_one_pass_where_the_parts_overlap() {
    let mut random = Random(16);
    let segment = drive(&mut random, (1, 1), 3000, 0.1);
    let s = 10;
    let part = |from: usize, to: usize| {
        Segment::new(segment.u.columns(from..to), segment.y.columns(from..to))
    };
    for kind in [Decomposition::Gram, Decomposition::Qr] {
        let mut merged = accumulate(kind, s, &part(0, 1700), 512);
        merged.merge(accumulate(kind, s, &part(1700 - (2 * s - 1), 3000), 512)).unwrap();
        let whole = accumulate(kind, s, &segment, 3000).factor().unwrap();
        let merged = merged.factor().unwrap();
        assert_eq!(merged.columns, whole.columns);
        assert!(distance(&merged.l, &whole.l) < 1e-12, "{kind:?}");
    }
}

#[test]
fn a_state_goes_through_bytes_to_the_last_bit() {
    let mut random = Random(22);
    let (first, second) =
        (drive(&mut random, (1, 2), 1300, 0.1), drive(&mut random, (1, 2), 200, 0.1));
    for kind in [Decomposition::Gram, Decomposition::Qr] {
        let mut sums = accumulate(kind, 6, &first, 300);
        let bytes = sums.to_bytes();
        let mut back = Accumulator::from_bytes(&bytes).unwrap();
        assert_eq!(back.to_bytes(), bytes);
        for sums in [&mut sums, &mut back] {
            sums.merge(accumulate(kind, 6, &second, 300)).unwrap();
        }
        assert_eq!(back.factor().unwrap().l, sums.factor().unwrap().l);
        for cut in [0, 7, 8, 60, 64, bytes.len() - 8, bytes.len() - 1] {
            assert!(Accumulator::from_bytes(&bytes[..cut]).is_err(), "{cut}");
        }
        assert!(Accumulator::from_bytes(&[bytes.clone(), vec![0; 8]].concat()).is_err());
        let empty = Accumulator::new(kind, 6, (1, 2), 1.0).unwrap().to_bytes();
        assert_eq!(Accumulator::from_bytes(&empty).unwrap().to_bytes(), empty);
        for place in 0..7 {
            for value in [f64::NAN, -1.0, 0.5, 1e15] {
                let mut broken = bytes.clone();
                broken[8 + 8 * place..16 + 8 * place].copy_from_slice(&value.to_le_bytes());
                // A sample time and counts of samples may be anything; nothing may crash.
                let _ = Accumulator::from_bytes(&broken);
            }
        }
    }
}

#[test]
fn states_that_do_not_belong_together_are_not_merged() {
    let new = |kind, s, channels, ts| Accumulator::new(kind, s, channels, ts).unwrap();
    let a = new(Decomposition::Gram, 5, (1, 1), 0.01);
    for other in [
        new(Decomposition::Gram, 6, (1, 1), 0.01),
        new(Decomposition::Gram, 5, (2, 1), 0.01),
        new(Decomposition::Gram, 5, (1, 1), 0.02),
    ] {
        assert!(matches!(a.clone().merge(other), Err(Error::Data { .. })));
    }
    let mut random = Random(17);
    let segment = drive(&mut random, (1, 1), 100, 0.1);
    let mut sums = accumulate(Decomposition::Gram, 5, &segment, 100);
    let triangle = accumulate(Decomposition::Qr, 5, &segment, 100);
    assert!(matches!(sums.merge(triangle), Err(Error::Data { .. })));
}

#[test]
fn offsets_and_units_cost_no_digits() {
    let mut random = Random(18);
    let plain = drive(&mut random, (1, 1), 4000, 0.1);
    let expected = Factor::new(&DataSet::new(1.0, vec![plain.clone()]).unwrap(), 12)
        .unwrap()
        .about_mean()
        .unwrap();
    for (scale, offset) in [(1.0, 1e6), (1e-9, 0.0), (1e9, 0.0), (1e-9, 1e-3), (1e9, -1e15)] {
        let other = Segment::new(moved(&plain.u, scale, offset), moved(&plain.y, scale, offset));
        // What adding the offset has rounded away is gone from the data.
        let lost = 1e-15 * offset.abs() / scale;
        let data = DataSet::new(1.0, vec![other.clone()]).unwrap();
        for kind in [Decomposition::Gram, Decomposition::Qr] {
            let factor = by(kind, &data, 12);
            let l = factor.about_mean().unwrap().l;
            let error = distance(
                &Mat::from_fn(l.nrows(), l.ncols(), |i, j| l[(i, j)] / scale),
                &expected.l,
            );
            assert!(error < 1e-12 + 10.0 * lost, "{kind:?} {scale:e} {offset:e}: {error:e}");
            // With the offset, the factor is still that of the data as they are.
            let squares = |m: &Mat<f64>| (m * m.transpose())[(0, 0)];
            let u = other.u.columns(12..4000 - 11);
            let mean_square = u.squared_norm_l2() / u.ncols() as f64;
            assert!((squares(&factor.l) / mean_square - 1.0).abs() < 1e-12, "{kind:?}");
        }
    }
}

#[test]
fn constants_on_noise_free_signals_leave_the_model_exact() {
    let mut random = Random(19);
    let truth = StateSpace { d: Mat::zeros(1, 1), ..random.system(3, 1, 1) };
    let u = random.matrix(1, 500);
    let y = simulate(&truth, u.as_ref(), &[1.0; 3]);
    let data = DataSet::single(1.0, moved(&u.into(), 1.0, 20.0), moved(&y, 1.0, -7.0)).unwrap();
    let factor = Factor::new(&data, 8).unwrap().about_mean().unwrap();
    assert_eq!(factor.conditioning.method, Decomposition::Qr);
    let sub = subspace(&factor, Weighting::Moesp).unwrap();
    let (a, c) = shift_realization(&sub, 3, 1).unwrap();
    let model = structured_bd(&factor, &sub, a.as_ref(), c.as_ref(), false).unwrap();
    let error = markov_distance(&truth, &model, 30);
    assert!(error < 1e-8, "{error:e}");
}

/// Five sines excite ten samples in a row, whatever horizon is requested.
#[test]
fn an_input_of_few_frequencies_gets_the_horizon_it_excites() {
    let mut random = Random(20);
    let truth = StateSpace { d: Mat::zeros(1, 1), ..random.system(2, 1, 1) };
    let sines =
        |t: usize| (1..=5).map(|k| (0.5 * k as f64 * t as f64 + k as f64).sin()).sum::<f64>();
    let u = Mat::from_fn(1, 2000, |_, t| sines(t));
    let y = simulate(&truth, u.as_ref(), &[0.3, 0.3]);
    let data = DataSet::single(1.0, u, y).unwrap();
    let factor = Factor::new(&data, 15).unwrap();
    let how = factor.conditioning;
    assert!(how.is_reduced() && how.method == Decomposition::Qr, "{how}");
    assert_eq!((how.requested_horizon, how.horizon, factor.horizon), (15, 5, 5));
    assert!(how.input_condition > 1e12);
    assert!(factor.conditioning.to_string().contains("does not excite"));
    let sub = subspace(&factor, Weighting::Moesp).unwrap();
    let (a, c) = shift_realization(&sub, 2, 1).unwrap();
    let model = structured_bd(&factor, &sub, a.as_ref(), c.as_ref(), false).unwrap();
    assert!(markov_distance(&truth, &model, 30) < 1e-8);
    // Other horizons of the same pass: no longer than that, and shorter ones as they are.
    assert_eq!(factor.with_horizon(12).unwrap().horizon, 5);
    let short = factor.with_horizon(4).unwrap();
    assert!(short.horizon == 4 && !short.conditioning.is_reduced());
    assert!(factor.with_horizon(16).is_err());
}

#[test]
fn hostile_data_are_refused_with_what_to_do() {
    let mut random = Random(21);
    let good = drive(&mut random, (2, 1), 400, 0.1);
    let with = |change: &dyn Fn(usize, usize, f64) -> f64| {
        let u = Mat::from_fn(2, 400, |i, t| change(i, t, good.u[(i, t)]));
        let y = Mat::from_fn(1, 400, |i, t| change(2 + i, t, good.y[(i, t)]));
        DataSet::single(1.0, u, y).unwrap()
    };
    let message = |data: &DataSet, s: usize| {
        let error = Factor::new(data, s).unwrap_err();
        format!("{error} | {}", error.hint())
    };
    let constant =
        |channel: usize| move |c: usize, _: usize, x: f64| if c == channel { 3.7 } else { x };
    assert!(message(&with(&constant(1)), 5).contains("input 1 (counted from 0) is 3.7 throughout"));
    assert!(
        message(&with(&constant(2)), 5).contains("output 0 (counted from 0) is 3.7 throughout")
    );
    assert!(message(&with(&|_, _, _| 0.0), 5).contains("input 0 (counted from 0) is 0 throughout"));
    // Two inputs that are the same.
    let same = with(&|c, t, x| if c == 1 { 2.0 * good.u[(0, t)] } else { x });
    assert!(message(&same, 5).contains("excite"));
    // A single step.
    let step = with(&|c, t, x| if c < 2 { f64::from(t > 399 - c) } else { x });
    assert!(message(&step, 5).contains("excite"));
    let huge = message(&with(&|c, t, x| if c == 0 && t == 77 { 1e300 } else { x }), 5);
    assert!(huge.contains("input 0") && huge.contains("1e300") && huge.contains("sample 77"));
    assert!(message(&with(&|_, _, x| 1e-200 * x), 5).contains("throughout"));
    // 2·s·3 rows and 2·s more samples for the windows.
    for s in [51, 400, 1_000_000, usize::MAX / 8] {
        assert!(matches!(
            Factor::new(&with(&|_, _, x| x), s),
            Err(Error::TooFewSamples { got: 400, .. })
        ));
    }
    assert!(matches!(Factor::new(&with(&|_, _, x| x), 0), Err(Error::Data { .. })));
    let one = DataSet::single(1.0, random.matrix(1, 1), random.matrix(1, 1)).unwrap();
    assert!(matches!(Factor::new(&one, 2), Err(Error::TooFewSamples { got: 1, .. })));
    assert!(matches!(
        Accumulator::new(Decomposition::Gram, 1_000_000, (1, 1), 1.0),
        Err(Error::Data { .. })
    ));

    let mut sums = Accumulator::new(Decomposition::Gram, 3, (1, 1), 1.0).unwrap();
    let (row, nan) = (random.matrix(1, 9), Mat::from_fn(1, 9, |_, _| f64::NAN));
    assert!(matches!(sums.push(row.as_ref(), nan.as_ref()), Err(Error::Data { .. })));
    assert!(matches!(
        sums.push(row.as_ref(), random.matrix(2, 9).as_ref()),
        Err(Error::Data { .. })
    ));
    assert!(matches!(
        sums.push(row.as_ref(), random.matrix(1, 8).as_ref()),
        Err(Error::Data { .. })
    ));
}
