//! A description written and read again is the same, and as the standard wants it.

use crate::common;

use common::{TABLE, description, starts};
use model_description::{Error, ModelDescription, Value, guid};

#[test]
fn written_and_read_it_is_the_same() {
    let written = description();
    let xml = written.to_xml();
    assert_eq!(ModelDescription::from_xml(&xml).unwrap(), written);
    assert_eq!(xml, description().to_xml());
    assert!(!xml.contains("generationDateAndTime"));
    assert_eq!(written.findings(), []);
}

#[test]
fn every_double_survives() {
    let mut description = description();
    for value in [f64::MIN_POSITIVE, 5e-324, f64::MAX, -0.0, 0.1 + 0.2, 1e22, 1.0 / 3.0, -1e-7] {
        description.variables[1].start = Some(Value::Real(value));
        let read = ModelDescription::from_xml(&description.to_xml()).unwrap();
        let Some(Value::Real(back)) = read.variables[1].start else { panic!("{value}") };
        assert_eq!(back.to_bits(), value.to_bits(), "{value}");
    }
}

#[test]
fn the_model_structure_follows_the_standard() {
    let description = description();
    let indices = |list: &[model_description::Unknown]| -> Vec<u32> {
        list.iter().map(|unknown| unknown.index).collect()
    };
    // `count` is exact: an output, but no initial unknown; `scale` is a calculated parameter.
    assert_eq!(indices(&description.outputs), [1, 8, 9]);
    assert_eq!(indices(&description.initial_unknowns), [1, 7, 9]);
    assert_eq!(description.outputs[0].dependencies, Some(vec![6]));
    // Ascending and without twins whatever the order of the names; parameters are listed.
    assert_eq!(description.initial_unknowns[0].dependencies, Some(vec![2, 6]));
    // None: an empty list. All: no list.
    assert_eq!(description.outputs[1].dependencies, Some(vec![]));
    assert_eq!(description.outputs[2].dependencies, None);
    let xml = description.to_xml();
    assert!(xml.contains(r#"<Unknown index="7" dependencies=""/>"#), "{xml}");
    assert!(xml.contains(r#"<Unknown index="9"/>"#), "{xml}");
}

#[test]
fn start_values_stand_where_they_must_and_nowhere_else() {
    for variable in description().variables {
        let needs = matches!(
            variable.name.as_str(),
            "gain" | "seed" | "enabled" | "label" | "speed" | "count"
        );
        assert_eq!(variable.start.is_some(), needs, "{}", variable.name);
    }
}

#[test]
fn wrong_start_values_are_refused() {
    let with = |index: usize, value: Value| {
        let mut starts = starts();
        starts[index] = value;
        ModelDescription::from_table(&TABLE, &starts, "id", None).unwrap_err()
    };
    assert!(matches!(with(2, Value::Integer(8)), Error::StartRange { variable: "seed", .. }));
    assert!(matches!(with(5, Value::Real(f64::NAN)), Error::StartRange { variable: "speed", .. }));
    assert!(matches!(with(3, Value::Real(1.0)), Error::StartKind { variable: "enabled", .. }));
    let short = ModelDescription::from_table(&TABLE, &starts()[1..], "id", None).unwrap_err();
    assert_eq!(short, Error::StartCount { model: "Everything", got: 8, need: 9 });
}

#[test]
fn the_guid_depends_on_table_and_resources_alone() {
    let file = |name: &str, bytes: &[u8]| (name.to_owned(), bytes.to_vec());
    let (a, b) = (file("a", b"1"), file("b", b"2"));
    let id = guid(&TABLE, &[a.clone(), b.clone()]);
    assert_eq!(id, guid(&TABLE, &[b.clone(), a.clone()]));
    let others = [
        guid(&TABLE, &[]),
        guid(&TABLE, std::slice::from_ref(&a)),
        guid(&TABLE, &[file("a", b"2"), file("b", b"1")]),
        guid(&TABLE, &[file("a", b"1b2")]),
        guid(&model_description::Table { version: "1.2.4", ..TABLE }, &[a, b]),
    ];
    assert!(!others.contains(&id));
    assert_eq!(id.len(), 36);
    let shape: Vec<usize> = id.split('-').map(str::len).collect();
    assert_eq!(shape, [8, 4, 4, 4, 12]);
    assert!(id.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f' | b'-')));
}
