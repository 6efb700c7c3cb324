//! Samples of logs compared bit by bit with those of readers that others wrote.
//!
//! Each script writes files with a peer and lists what the peer reads. Needs the Python environment that
//! `cargo xtask test` creates; STEERWRIGHT_PYTHON is its interpreter.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use steerwright_drivelog::{LogFile, LogOptions, Request, Wanted, open};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drives")
}

/// Runs a script of this folder, and compares each channel that it lists; how many they are.
fn compare(script: &str, arguments: &[&Path]) -> usize {
    let python =
        std::env::var_os("STEERWRIGHT_PYTHON").expect("STEERWRIGHT_PYTHON: cargo xtask test");
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers").join(script);
    let done =
        Command::new(python).arg(script).arg(folder.path()).args(arguments).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let expected = std::fs::read_to_string(folder.path().join("expected.json")).unwrap();
    let expected: Vec<Value> = serde_json::from_str(&expected).unwrap();
    let mut faults = Vec::new();
    for channel in &expected {
        let (file, name) =
            (channel["file"].as_str().unwrap(), channel["channel"].as_str().unwrap());
        let fault = read(folder.path(), channel).and_then(|[time, values]| {
            same("time", &time, channel)?;
            same("values", &values, channel)
        });
        faults.extend(fault.err().map(|fault| format!("{file}: {name}: {fault}")));
    }
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), expected.len(), faults.join("\n"));
    expected.len()
}

/// Times and values of a listed channel.
fn read(folder: &Path, channel: &Value) -> Result<[Vec<f64>; 2], String> {
    let path = folder.join(channel["file"].as_str().unwrap());
    let dbc = channel["dbc"]
        .as_str()
        .map(|name| (name.to_owned(), std::fs::read(folder.join(name)).unwrap()));
    let options = LogOptions { dbc: dbc.into_iter().collect(), ..LogOptions::default() };
    let name = path.display().to_string();
    let file = LogFile::of_file(&name, std::fs::File::open(&path).unwrap());
    let mut recording = open(file, &options).map_err(|e| e.to_string())?;
    let name = channel["channel"].as_str().unwrap();
    let groups = recording.groups().iter().enumerate();
    let found = groups.filter_map(|(g, group)| {
        let label = |c: &str| c == name || format!("{}.{c}", group.name) == name;
        let c = group.channels.iter().position(|c| label(&c.name))?;
        let named = channel["clock"].as_str();
        let clock = named.map_or(group.clock, |n| group.channels.iter().position(|c| c.name == n));
        Some((g, vec![clock?, c]))
    });
    let found: Vec<_> = found.collect();
    let [(group, channels)] = &found[..] else {
        return Err(format!("{} channels have that name", found.len()));
    };
    let wanted = [Wanted { group: *group, channels: channels.clone() }];
    let mut all = [Vec::new(), Vec::new()];
    let request = Request { wanted: &wanted, window_s: None, most: 1000 };
    for rows in recording.rows(request).map_err(|e| e.to_string())? {
        let values = rows.map_err(|e| e.to_string())?.columns.values;
        all.iter_mut().zip(values).for_each(|(all, mut new)| all.append(&mut new));
    }
    Ok(all)
}

fn same(what: &str, got: &[f64], channel: &Value) -> Result<(), String> {
    let expected = &channel[what];
    let expected: Vec<f64> =
        expected.as_array().unwrap().iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect();
    if got.len() != expected.len() {
        return Err(format!("{} {what}, the peer has {}", got.len(), expected.len()));
    }
    // Interpolation in a table is rounded in the order of its operations.
    let tolerance = channel["tolerance"].as_f64().unwrap_or(0.0);
    let differ = |(a, b): (&f64, &f64)| {
        let same = a == b || (a - b).abs() <= tolerance || a.is_nan() && b.is_nan();
        !same
    };
    match got.iter().zip(&expected).position(differ) {
        Some(k) => Err(format!("{what} of row {k}: {:?}, the peer has {:?}", got[k], expected[k])),
        None => Ok(()),
    }
}

#[test]
#[ignore = "needs Python: cargo xtask test"]
fn mdf_as_asammdf_and_cantools_read_it() {
    let dbc = data().join("comma2k19/can/toyota_prius_2010_pt.dbc");
    assert!(compare("mdf_files.py", &[&dbc]) > 150);
}

#[test]
#[ignore = "needs Python: cargo xtask test"]
fn parquet_as_pyarrow_reads_it() {
    assert!(compare("parquet_files.py", &[]) > 200);
}

#[test]
#[ignore = "needs Python: cargo xtask test"]
fn raw_buses_as_python_can_and_cantools_read_them() {
    assert!(compare("raw_can.py", &[]) > 100);
}

#[test]
#[ignore = "needs Python: cargo xtask test"]
fn mcap_as_rosbags_and_mcap_ros2_support_read_it() {
    assert!(compare("mcap_files.py", &[]) > 1000);
}
