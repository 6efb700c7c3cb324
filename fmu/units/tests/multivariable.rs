//! `MultivariablePlant` against the equations of its document, computed here.
#![allow(clippy::unwrap_used, clippy::panic)]

use fmi2_export::model_description::Value;
use fmi2_export::{CoSimulationUnit, Log, Resources, VariableId};
use steerwright_formats::{Document, MultivariablePlant as PlantFile};
use steerwright_units::MultivariablePlant;

const EXAMPLE: &str = include_str!("../../multivariable-plant/example.json");

fn opened(start: Option<&str>) -> Result<MultivariablePlant, String> {
    let mut files = vec![("plant.json".to_owned(), EXAMPLE.as_bytes().to_vec())];
    files.extend(start.map(|start| ("start.json".to_owned(), start.as_bytes().to_vec())));
    MultivariablePlant::open(&Resources::from(files))
}

fn set(unit: &mut MultivariablePlant, reference: u32, value: f64) {
    let variable = VariableId::from_reference(reference).unwrap();
    unit.set(variable, &Value::Real(value));
}

fn outputs(unit: &mut MultivariablePlant) -> [f64; 2] {
    [100, 101].map(|reference| {
        let variable = VariableId::from_reference(reference).unwrap();
        unit.get(variable).as_number().unwrap()
    })
}

/// Inputs at a grid point, about which nothing is special.
fn inputs(k: i32) -> [f64; 2] {
    let k = f64::from(k);
    [1500.0 + 80.0 * (0.7 * k).sin(), 4.0 + 1.5 * (0.3 * k + 1.0).cos()]
}

/// The outputs at the grid points by the document: x from zero, both inputs at their offsets before the start.
fn expected(points: i32) -> Vec<[f64; 2]> {
    let file = PlantFile::from_json(EXAMPLE, "it").unwrap();
    let d = &file.discrete;
    let late = [0, 3];
    let v = |k: i32, j: usize| match k - late[j] {
        before if before < 0 => 0.0,
        k => inputs(k)[j] - file.inputs[j].offset,
    };
    let mut x = [0.0; 2];
    let mut found = Vec::new();
    for k in 0..points {
        let v = [v(k, 0), v(k, 1)];
        let sum = |m: &steerwright_formats::Matrix, row: usize, z: &[f64; 2]| {
            m.entry(row, 0) * z[0] + m.entry(row, 1) * z[1]
        };
        found.push([0, 1].map(|i| file.outputs[i].offset + sum(&d.c, i, &x) + sum(&d.d, i, &v)));
        x = [0, 1].map(|i| sum(&d.a, i, &x) + sum(&d.b, i, &v));
    }
    found
}

#[test]
fn outputs_at_the_grid_points_are_those_of_the_document_whatever_the_step() {
    let expected = expected(60);
    // Whole samples, parts of one, and several at once.
    for (parts, samples) in [(1, 1), (5, 1), (1, 3)] {
        let mut unit = opened(None).unwrap();
        let step = 0.5 * f64::from(samples) / f64::from(parts);
        unit.exit_initialization(0.0, &mut Log::default()).unwrap();
        for k in (0..60).step_by(samples as usize) {
            for (reference, value) in (0..).zip(inputs(k)) {
                set(&mut unit, reference, value);
            }
            // An input of several samples holds.
            if samples == 1 {
                let now = outputs(&mut unit);
                for i in 0..2 {
                    let error = (now[i] - expected[k as usize][i]).abs();
                    assert!(error < 1e-11, "{parts} parts, point {k}: {now:?} {expected:?}");
                }
            }
            for part in 0..parts {
                unit.step(0.0, step, &mut Log::default()).unwrap();
                if part + 1 < parts {
                    let held = outputs(&mut unit);
                    // Between grid points neither time nor an input moves an output.
                    set(&mut unit, 0, 0.0);
                    assert_eq!(outputs(&mut unit), held);
                    assert!((held[0] - expected[k as usize][0]).abs() < 1e-11, "{held:?}");
                }
            }
        }
        if samples > 1 {
            let mut by_ones = opened(None).unwrap();
            by_ones.exit_initialization(0.0, &mut Log::default()).unwrap();
            for k in 0..60 {
                for (reference, value) in (0..).zip(inputs(k - k % samples)) {
                    set(&mut by_ones, reference, value);
                }
                by_ones.step(0.0, 0.5, &mut Log::default()).unwrap();
            }
            assert_eq!(outputs(&mut by_ones), outputs(&mut unit));
        }
    }
}

#[test]
fn a_saved_state_goes_on_between_grid_points_and_in_the_delay() {
    let mut unit = opened(None).unwrap();
    let variable = VariableId::from_reference(200).unwrap();
    unit.set(variable, &Value::Real(1.0));
    unit.exit_initialization(0.0, &mut Log::default()).unwrap();
    for k in 0..7 {
        for (reference, value) in (0..).zip(inputs(k)) {
            set(&mut unit, reference, value);
        }
        unit.step(0.0, 0.3, &mut Log::default()).unwrap();
    }
    let mut loaded = opened(None).unwrap();
    loaded.load(&unit.save()).unwrap();
    assert_eq!(loaded.save(), unit.save());
    for _ in 0..20 {
        assert_eq!(outputs(&mut loaded), outputs(&mut unit));
        for unit in [&mut loaded, &mut unit] {
            unit.step(0.0, 0.3, &mut Log::default()).unwrap();
        }
    }
    // Of another document the lengths differ.
    let mut bytes = unit.save();
    bytes.truncate(bytes.len() / 2);
    assert!(loaded.load(&bytes).is_err());
}

#[test]
fn noise_has_the_covariance_of_the_innovations() {
    let mut unit =
        opened(Some("{\"schema\": \"steerwright/start/1\", \"values\": {\"noise_scale\": 2.0}}"))
            .unwrap();
    unit.exit_initialization(0.0, &mut Log::default()).unwrap();
    // The innovation is what the model without noise does not predict: K takes it into the states.
    let file = PlantFile::from_json(EXAMPLE, "it").unwrap();
    let d = &file.discrete;
    let (mut x, count) = ([0.0; 2], 20_000);
    let mut sums = [[0.0; 2]; 2];
    for _ in 0..count {
        let y = outputs(&mut unit);
        let times = |m: &steerwright_formats::Matrix, i: usize, z: [f64; 2]| {
            m.entry(i, 0) * z[0] + m.entry(i, 1) * z[1]
        };
        let e = [0, 1].map(|i| y[i] - file.outputs[i].offset - times(&d.c, i, x));
        x = [0, 1].map(|i| times(&d.a, i, x) + times(&d.k, i, e));
        for i in 0..2 {
            for j in 0..2 {
                sums[i][j] += e[i] * e[j] / f64::from(count);
            }
        }
        unit.step(0.0, 0.5, &mut Log::default()).unwrap();
    }
    for (i, row) in sums.iter().enumerate() {
        for (j, found) in row.iter().enumerate() {
            let truth = 4.0 * file.innovation_covariance.entry(i, j);
            let spread = |k: usize| 4.0 * file.innovation_covariance.entry(k, k);
            // Five standard errors of a product of normal numbers.
            let tolerance = 5.0 * (2.0 * spread(i) * spread(j) / f64::from(count)).sqrt();
            assert!((found - truth).abs() < tolerance, "{i} {j}: {found} {truth}");
        }
    }
}

#[test]
fn variables_have_the_names_of_the_channels_in_start_values_and_errors() {
    let start = |values: &str| {
        opened(Some(&format!("{{\"schema\": \"steerwright/start/1\", \"values\": {{{values}}}}}")))
    };
    let mut unit = start("\"heater_power\": 1600").unwrap();
    let first = VariableId::from_reference(0).unwrap();
    assert_eq!(unit.get(first), Value::Real(1600.0));
    let error = start("\"input_1\": 1600").unwrap_err();
    assert!(error.contains("no variable input_1"), "{error}");
    // The document has two inputs and two outputs.
    for (reference, has) in [(0, true), (1, true), (2, false), (101, true), (102, false)] {
        assert_eq!(unit.has(VariableId::from_reference(reference).unwrap()), has, "{reference}");
    }
}
