//! Tables in Arrow IPC; `fixtures/make.py` makes the files.

use steerwright_drivelog::{Inspection, LogFile, LogOptions, inspect, read_drives};

const DRIVE: &[u8] = include_bytes!("fixtures/drive.feather");
const POLARS: &[u8] = include_bytes!("fixtures/polars.arrows");
/// Bytes of metadata from one that is changed to the next.
const STEP: usize = 1;
const KINDS: &[u8] = include_bytes!("fixtures/kinds.arrows");

fn read(name: &str, bytes: &[u8]) -> Inspection {
    inspect(LogFile::of_bytes(name, bytes), &LogOptions::default()).unwrap()
}

#[test]
fn a_drive_in_feather_is_that_in_csv() {
    let file = LogFile::of_bytes("drive.feather", DRIVE);
    let log = read_drives(vec![file], Vec::new(), &LogOptions::default()).unwrap();
    let plain = super::read_one(super::good(), &LogOptions::default()).unwrap();
    let is_close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-7);
    assert_eq!(log.len(), plain.len());
    assert!(is_close(&log.input, &plain.input) && is_close(&log.output, &plain.output));
    assert!(is_close(&log.speed.unwrap(), &plain.speed.unwrap()));
}

#[test]
fn all_kinds_of_columns_in_a_stream_and_in_a_compressed_file() {
    let compressed: &[u8] = include_bytes!("fixtures/kinds_zstd.arrow");
    for (name, bytes) in [("kinds.arrows", KINDS), ("kinds.arrow", compressed)] {
        let found = read(name, bytes);
        let group = &found.groups[0];
        assert_eq!((group.rows, group.clock.as_deref()), (20, Some("stamp")), "{name}");
        assert_eq!(group.rate_hz, Some(100.0));
        let channel = |name: &str| {
            let channel = group.channels.iter().find(|c| c.name == name).unwrap();
            (channel.values, channel.min.unwrap(), channel.max.unwrap())
        };
        // `date -u -d '2024-03-01T10:00:00Z' +%s`
        let ten = 1_709_287_200.0;
        let u64_max = 9_223_372_036_854_795_264.0;
        for (name, expected) in [
            ("stamp", (20, ten, ten + 0.19)),
            ("i8", (20, -19.0, 0.0)),
            ("u8", (20, 236.0, 255.0)),
            ("u64", (20, 2_f64.powi(63), u64_max)),
            ("half", (20, 0.0, 9.5)),
            // Every third is null.
            ("f32", (14, 0.0, 4.75)),
            ("flag", (14, 0.0, 1.0)),
            ("money", (20, -0.19, 0.0)),
            ("lap", (20, 0.0, 0.095)),
            ("clock", (20, 0.0, 19.0)),
            ("iso", (14, ten, ten + 19.0)),
            // The structure is null once.
            ("pose.x", (19, 0.0, 9.5)),
            ("pose.deep.z", (13, 0.0, 19.0)),
            ("day", (20, 0.0, 19.0)),
            ("last", (20, 0.0, 19.0)),
        ] {
            assert_eq!(channel(name), expected, "{name}");
        }
        for name in ["text", "view", "mode"] {
            let text = group.channels.iter().find(|c| c.name == name).unwrap();
            assert_eq!(text.unit.as_deref(), Some("text"));
        }
        let losses = found.losses.join("\n");
        for part in [
            "`list` is not read: lists",
            "`fixed` is not read: lists",
            "`none` is not read: no values",
            "`blob` is not read: bytes",
        ] {
            assert!(losses.contains(part), "{losses}");
        }
        assert_eq!(found.losses.len(), 4, "{losses}");
    }
}

#[test]
fn files_and_streams_of_polars() {
    let file: &[u8] = include_bytes!("fixtures/polars.arrow");
    for (name, bytes) in [("polars.arrow", file), ("polars.arrows", POLARS)] {
        let found = read(name, bytes);
        let group = &found.groups[0];
        assert_eq!((group.rows, found.losses.len()), (200, 0), "{name}: {:?}", found.losses);
        let yaw = group.channels.iter().find(|c| c.name == "yaw_rate_radps").unwrap();
        // 0.2·sin(π·t − 0.3), whose extremes at t = 0.6 and 1.6 s are sampled within 1 %.
        assert!((yaw.max.unwrap() - 0.2).abs() < 2e-3 && (yaw.min.unwrap() + 0.2).abs() < 2e-3);
        let speed = group.channels.iter().find(|c| c.name == "speed_mps").unwrap();
        assert_eq!((speed.values, speed.min, speed.max), (200, Some(15.0), Some(15.0)));
        let gear = group.channels.iter().find(|c| c.name == "gear").unwrap();
        assert_eq!(gear.unit.as_deref(), Some("text"));
    }
}

#[test]
fn dictionaries_of_numbers_and_times_in_a_stream_of_an_older_writer() {
    let found = read("legacy.arrows", include_bytes!("fixtures/legacy.arrows"));
    let group = &found.groups[0];
    assert_eq!((group.rows, group.clock.as_deref()), (30, Some("stamp")), "{:?}", found.losses);
    let x = group.channels.iter().find(|c| c.name == "x").unwrap();
    // Every third is null.
    assert_eq!((x.values, x.min, x.max), (20, Some(0.25), Some(0.5)));
}

#[test]
fn a_blank_in_a_column_of_times_is_a_missing_value() {
    let arrow: &[u8] = include_bytes!("fixtures/blanks.arrow");
    let parquet: &[u8] = include_bytes!("fixtures/blanks.parquet");
    for (name, bytes) in [("a.arrow", arrow), ("a.parquet", parquet)] {
        let found = read(name, bytes);
        let group = &found.groups[0];
        assert_eq!((group.rows, group.clock.as_deref()), (30, Some("stamp")), "{name}");
        assert!(found.losses.is_empty(), "{:?}", found.losses);
        let values: Vec<usize> = group.channels.iter().map(|channel| channel.values).collect();
        assert_eq!(values, [27, 30], "{name}");
    }
}

#[test]
fn a_file_of_texts_is_not_damaged() {
    let texts = include_bytes!("fixtures/texts.arrow");
    let error = inspect(LogFile::of_bytes("a.arrow", texts), &LogOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "a.arrow: no column has numbers");
}

/// Places of the metadata of the batches: behind a mark, so many bytes.
fn metadata(bytes: &[u8]) -> Vec<std::ops::Range<usize>> {
    let marks = (0..bytes.len() - 8).filter(|at| bytes[*at..].starts_with(&[0xFF; 4]));
    let all = marks.map(|at| {
        let length = u32::from_le_bytes(bytes[at + 4..at + 8].try_into().unwrap());
        at + 8..at + 8 + length as usize
    });
    all.filter(|range| !range.is_empty() && range.end < bytes.len()).skip(1).collect()
}

#[test]
fn damaged_metadata_change_nothing_in_silence() {
    let numbers = |found: &Inspection| {
        let group = &found.groups[0];
        let channels = group.channels.iter().map(|c| (c.name.clone(), c.values, c.min, c.max));
        (group.rows, channels.collect::<Vec<_>>())
    };
    let compressed: &[u8] = include_bytes!("fixtures/polars.arrow");
    let mut changed = Vec::new();
    for (name, bytes) in [("drive", DRIVE), ("stream", POLARS), ("file", compressed)] {
        let whole = numbers(&read(name, bytes));
        for range in metadata(bytes) {
            for (at, bit) in range.step_by(STEP).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
                let mut damaged = bytes.to_vec();
                damaged[at] ^= 1 << bit;
                let file = LogFile::of_bytes(name, &damaged);
                let Ok(found) = inspect(file, &LogOptions::default()) else { continue };
                if found.losses.is_empty() && numbers(&found) != whole {
                    changed.push((name, at, bit));
                }
            }
        }
    }
    assert_eq!(changed, []);
}

#[test]
fn what_is_cut_or_damaged_is_reported() {
    let found = read("drive.feather", &DRIVE[..DRIVE.len() / 2]);
    assert_eq!(found.groups[0].rows, 300, "{:?}", found.losses);
    assert!(found.losses[0].contains("ends within a message"), "{:?}", found.losses);
    let mut bytes = DRIVE.to_vec();
    let middle = bytes.len() / 3;
    bytes[middle..middle + 400].fill(0xFF);
    let found = read("drive.feather", &bytes);
    assert!(found.groups[0].rows < 1000, "{:?}", found.losses);
    assert!(found.losses.iter().any(|loss| loss.contains("not read")), "{:?}", found.losses);
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        changes in proptest::collection::vec((0_usize..100_000, 0_u8..=255), 1..12),
        form in 0..3_u8,
    ) {
        let compressed: &[u8] = include_bytes!("fixtures/kinds_zstd.arrow");
        let files: [&[u8]; 3] = [DRIVE, KINDS, compressed];
        let mut bytes = files[usize::from(form)].to_vec();
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        let _ = inspect(LogFile::of_bytes("a.arrow", &bytes), &LogOptions::default());
    }
}
