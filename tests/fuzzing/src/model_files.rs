//! The stages' files, as an FMU's `resources/` may hold them.

use crate::calls::chosen;
use crate::cursor::Cursor;
use crate::documents::{BICYCLE, DELAYED, ESTIMATOR, LONGITUDINAL, PATH, PID, PLANT, VEHICLE};
use fmi2_export::{CoSimulationUnit, Log, Resources};
use serde_json::Value;
use steerwright_units::{
    BicyclePlant, IdentifiedPlant, LateralPid, LongitudinalPlant, NonlinearVehicle, PoseEstimator,
    ReferencePath,
};

/// Numbers changed in one document, at most.
const MOST_CHANGES: usize = 8;

/// Reads the bytes as each of the files; whatever is accepted must run.
///
/// Bytes that begin with `#` are no file but changes: which document, and which of its numbers
/// become what. Random text is hardly ever JSON of the right shape.
pub(crate) fn model_files(bytes: &[u8]) {
    if let Some(changes) = bytes.strip_prefix(b"#") {
        let mut cursor = Cursor::new(changes);
        match chosen(cursor.byte()) {
            0 => run::<IdentifiedPlant>("plant.json", &changed(PLANT, &mut cursor)),
            1 => run::<IdentifiedPlant>("plant.json", &changed(DELAYED, &mut cursor)),
            2 => run::<BicyclePlant>("bicycle.json", &changed(BICYCLE, &mut cursor)),
            3 => run::<LateralPid>("pid.json", &changed(PID, &mut cursor)),
            4 => run::<ReferencePath>("path.json", &changed(PATH, &mut cursor)),
            5 => run::<NonlinearVehicle>("vehicle.json", &changed(VEHICLE, &mut cursor)),
            7 => run::<LongitudinalPlant>("longitudinal.json", &changed(LONGITUDINAL, &mut cursor)),
            _ => run::<PoseEstimator>("estimator.json", &changed(ESTIMATOR, &mut cursor)),
        }
        return;
    }
    run::<IdentifiedPlant>("plant.json", bytes);
    run::<BicyclePlant>("bicycle.json", bytes);
    run::<LateralPid>("pid.json", bytes);
    run::<ReferencePath>("path.json", bytes);
    run::<NonlinearVehicle>("vehicle.json", bytes);
    run::<LongitudinalPlant>("longitudinal.json", bytes);
    run::<PoseEstimator>("estimator.json", bytes);
}

/// The document with some of its numbers changed.
fn changed(document: &[u8], cursor: &mut Cursor<'_>) -> Vec<u8> {
    let mut json: Value = serde_json::from_slice(document).expect("our own document");
    for _ in 0..MOST_CHANGES {
        if cursor.is_empty() {
            break;
        }
        let mut numbers = Vec::new();
        collect(&mut json, &mut numbers);
        let at = cursor.below(256) * 256 + cursor.below(256);
        let value = Value::from(cursor.real());
        let count = numbers.len();
        if let Some(number) = numbers.into_iter().nth(at % count.max(1)) {
            *number = value;
        }
    }
    json.to_string().into_bytes()
}

fn collect<'a>(json: &'a mut Value, numbers: &mut Vec<&'a mut Value>) {
    match json {
        Value::Number(_) => numbers.push(json),
        Value::Array(items) => items.iter_mut().for_each(|item| collect(item, numbers)),
        Value::Object(members) => members.values_mut().for_each(|item| collect(item, numbers)),
        _ => {}
    }
}

/// A refusal must say why; an accepted file must give finite values at the start, and then run on or
/// say why not. (Later the C layer is the one that passes no other value on: see `calls`.)
fn run<S: CoSimulationUnit>(name: &str, bytes: &[u8]) {
    let resources = Resources::from(vec![(name.to_owned(), bytes.to_vec())]);
    let mut unit = match S::open(&resources) {
        Ok(unit) => unit,
        Err(problem) => return assert!(problem.len() > 10, "{problem:?}"),
    };
    let mut log = Log::default();
    let mut outcome = unit.exit_initialization(0.0, &mut log);
    let mut time = 0.0;
    for step in [0.01, 1e-6, 0.25] {
        if let Err(problem) = outcome {
            return assert!(problem.len() > 10, "{problem:?}");
        }
        if time == 0.0 {
            all_finite(&mut unit);
        }
        outcome = unit.step(time, step, &mut log);
        time += step;
    }
}

fn all_finite<S: CoSimulationUnit>(unit: &mut S) {
    use fmi2_export::VariableId;
    for row in S::TABLE.variables {
        let variable = S::Variable::from_reference(row.reference).expect("a row has its variable");
        if let model_description::Value::Real(value) = unit.get(variable) {
            assert!(value.is_finite(), "{} is {value}", row.name);
        }
    }
}
