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

#[test]
fn a_later_version_of_mdf_4_is_read_as_far_as_its_blocks_are_known() {
    let mut later = DRIVE.to_vec();
    later[8..12].copy_from_slice(b"4.30");
    later[28..30].copy_from_slice(&430_u16.to_le_bytes());
    let read = |bytes: &[u8]| {
        inspect(LogFile::of_bytes("drive.mf4", bytes), &LogOptions::default()).unwrap()
    };
    assert_eq!(read(&later), read(DRIVE));
}

#[test]
fn halves_are_read_arrays_are_reported_and_a_cut_block_is_read_to_its_end() {
    let bytes = include_bytes!("fixtures/kinds.mf4");
    let read = |bytes: &[u8]| {
        inspect(LogFile::of_bytes("kinds.mf4", bytes), &LogOptions::default()).unwrap()
    };
    let found = read(bytes);
    let half = found.groups[0].channels.iter().find(|c| c.name == "half").unwrap();
    assert_eq!((half.min, half.max), (Some(-3.0), Some(9.25)));
    assert!(found.losses.iter().any(|loss| loss.contains("wheels")), "{:?}", found.losses);
    // Cut within the samples, which are moved to the end of the file.
    let samples = bytes.windows(4).rposition(|w| w == b"##DT").unwrap();
    let link = (samples as u64).to_le_bytes();
    let link = bytes.windows(8).position(|w| w == link).unwrap();
    let record = 8 + 2 + 4 * 8;
    let mut moved = bytes.to_vec();
    moved.resize(bytes.len().next_multiple_of(8), 0);
    let end = (moved.len() as u64).to_le_bytes();
    moved[link..link + 8].copy_from_slice(&end);
    moved.extend_from_slice(&bytes[samples..samples + 24 + 20 * record + 5]);
    let cut = read(&moved);
    assert_eq!(cut.groups[0].rows, 20);
    assert!(cut.losses.iter().any(|loss| loss.contains("ends within")), "{:?}", cut.losses);
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
