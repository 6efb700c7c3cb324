//! Tables in Arrow IPC; `fixtures/make.py` makes the files.

use steerwright_drivelog::{Inspection, LogFile, LogOptions, inspect, read_drives};

const DRIVE: &[u8] = include_bytes!("fixtures/drive.feather");
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
        let text = group.channels.iter().find(|c| c.name == "text").unwrap();
        assert_eq!(text.unit.as_deref(), Some("text"));
        let losses = found.losses.join("\n");
        for part in [
            "`mode` is not read: texts of a dictionary",
            "`list` is not read: lists",
            "`fixed` is not read: lists",
            "`view` is not read: texts",
            "`none` is not read: no values",
            "`blob` is not read: bytes",
        ] {
            assert!(losses.contains(part), "{losses}");
        }
        assert_eq!(found.losses.len(), 6, "{losses}");
    }
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
