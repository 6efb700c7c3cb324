//! Measurements in MDF; `fixtures/make.py` makes the file. The peers compare all kinds of values.

use steerwright_drivelog::{LogFile, LogOptions, inspect, read_drives};

const DRIVE: &[u8] = include_bytes!("fixtures/drive.mf4");

#[test]
fn a_drive_of_two_channel_groups_is_read_by_names_and_units() {
    let file = LogFile::of_bytes("drive.mf4", DRIVE);
    let log = read_drives(vec![file], Vec::new(), &LogOptions::default()).unwrap();
    assert!((log.speed.unwrap()[0] - 15.0).abs() < 1e-9);
    let largest = log.output.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!((largest - 0.2).abs() < 1e-3, "{largest}");
    assert!(log.output.len() > 450, "{}", log.output.len());
}

#[test]
fn a_truncated_file_keeps_what_is_left_or_names_the_byte() {
    let whole = inspect(LogFile::of_bytes("drive.mf4", DRIVE), &LogOptions::default()).unwrap();
    assert_eq!(whole.losses, Vec::<String>::new());
    assert_eq!(whole.groups.iter().map(|g| g.rows).collect::<Vec<_>>(), [1000, 100]);
    for length in (0..DRIVE.len()).step_by(97) {
        let file = LogFile::of_bytes("drive.mf4", &DRIVE[..length]);
        match inspect(file, &LogOptions::default()) {
            Ok(found) => {
                let rows: usize = found.groups.iter().map(|g| g.rows).sum();
                assert!(rows == 1100 || !found.losses.is_empty(), "{length}: {rows} rows, no loss");
            }
            Err(error) => assert!(error.to_string().contains("byte") || length < 8, "{error}"),
        }
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        changes in proptest::collection::vec((0_usize..100_000, 0_u8..=255), 1..12),
    ) {
        let mut bytes = DRIVE.to_vec();
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        let _ = inspect(LogFile::of_bytes("drive.mf4", &bytes), &LogOptions::default());
    }
}
