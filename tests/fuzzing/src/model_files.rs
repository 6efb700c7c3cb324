//! The stages' files, as an FMU's `resources/` may hold them.

use crate::cursor::Cursor;
use crate::documents::chosen;
use fmi2_export::{CoSimulationUnit, Log, Resources};
use serde_json::Value;
use steerwright_units::{Definition, Fmu, Visitor};

/// Numbers changed in one document, at most.
const MOST_CHANGES: usize = 8;

/// Reads the bytes as each of the files; whatever is accepted must run.
///
/// Bytes that begin with `#` are no file but changes: which document, and which of its numbers
/// become what. Random text is hardly ever JSON of the right shape.
pub(crate) fn model_files(bytes: &[u8]) {
    if let Some(changes) = bytes.strip_prefix(b"#") {
        let mut cursor = Cursor::new(changes);
        let (fmu, document) = chosen(cursor.byte());
        return fmu.visit(Run { document: &changed(document, &mut cursor) });
    }
    for fmu in Fmu::ALL {
        fmu.visit(Run { document: bytes });
    }
}

/// The document with some of its numbers changed.
fn changed(document: &str, cursor: &mut Cursor<'_>) -> Vec<u8> {
    let mut json: Value = serde_json::from_str(document).expect("our own document");
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

/// One FMU with a document. A refusal must say why; an accepted file must give finite values at the start, and
/// then run on or say why not. (Later the C layer is the one that passes no other value on: see `calls`.)
struct Run<'a> {
    document: &'a [u8],
}

impl Visitor for Run<'_> {
    type Output = ();

    fn visit<S: Definition>(self) {
        let resources = Resources::from(vec![(S::RESOURCE.to_owned(), self.document.to_vec())]);
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
