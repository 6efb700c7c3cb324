//! Tables in Parquet; `fixtures/make.py` makes the file. The peers compare all kinds of columns and codecs.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use steerwright_drivelog::{
    LogFile, LogOptions, ReadAt, Request, Wanted, inspect, open, read_drives,
};

const DRIVE: &[u8] = include_bytes!("fixtures/drive.parquet");

#[test]
fn a_drive_is_read_by_names_and_units() {
    let file = LogFile::of_bytes("drive.parquet", DRIVE);
    let log = read_drives(vec![file], Vec::new(), &LogOptions::default()).unwrap();
    assert!((log.speed.unwrap()[0] - 15.0).abs() < 1e-9);
    let largest = log.output.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!((largest - 0.2).abs() < 1e-3, "{largest}");
}

#[test]
fn durations_stamps_halves_decimals_and_what_is_not_read() {
    let bytes = include_bytes!("fixtures/kinds.parquet");
    let found = inspect(LogFile::of_bytes("a.parquet", bytes), &LogOptions::default()).unwrap();
    let group = &found.groups[0];
    assert_eq!((group.rows, group.clock.as_deref()), (50, Some("time")));
    let channel = |name: &str| {
        let channel = group.channels.iter().find(|c| c.name == name).unwrap();
        (channel.min, channel.max)
    };
    assert_eq!(channel("time"), (Some(0.0), Some(0.49)));
    assert_eq!(channel("half"), (Some(-3.0), Some(9.25)));
    assert_eq!(channel("price"), (Some(-0.2), Some(0.29)));
    // `date -u -d '2024-03-01T10:00:00Z' +%s`
    assert_eq!(channel("stamp"), (Some(1_709_287_200.0), Some(1_709_287_200.49)));
    assert_eq!(channel("note"), (None, None));
    assert_eq!(found.losses.len(), 1, "{:?}", found.losses);
    assert!(found.losses[0].contains("list"), "{:?}", found.losses);
}

#[test]
fn texts_that_take_much_more_memory_than_the_file_are_not_read() {
    let bytes = include_bytes!("fixtures/expanding.parquet");
    let found = inspect(LogFile::of_bytes("a.parquet", bytes), &LogOptions::default()).unwrap();
    assert_eq!((found.groups[0].rows, found.losses.len()), (80, 1), "{:?}", found.losses);
    let is_named = found.losses[0].starts_with("a.parquet: column `note` is not read: 80");
    assert!(is_named && found.losses[0].contains("that are compressed"), "{:?}", found.losses);
}

/// Bytes that count how many are read.
struct Counted(Vec<u8>, Arc<AtomicU64>);

impl ReadAt for Counted {
    fn size(&self) -> std::io::Result<u64> {
        self.0.size()
    }

    fn read_at(&self, buffer: &mut [u8], offset: u64) -> std::io::Result<usize> {
        let count = self.0.read_at(buffer, offset)?;
        self.1.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

#[test]
fn a_window_reads_the_row_groups_that_it_is_in() {
    let read = Arc::new(AtomicU64::new(0));
    let file = LogFile::of_file("drive.parquet", Counted(DRIVE.to_vec(), Arc::clone(&read)));
    let mut log = open(file, &LogOptions::default()).unwrap();
    let wanted = [Wanted { group: 0, channels: vec![0, 2] }];
    let mut bytes = |window_s| {
        let before = read.load(Ordering::Relaxed);
        let request = Request { wanted: &wanted, window_s, most: 100 };
        let pieces: Vec<_> = log.rows(request).unwrap().map(Result::unwrap).collect();
        assert!(pieces.iter().all(|p| p.columns.lines.len() <= 100));
        let lines: Vec<u64> = pieces.iter().flat_map(|p| p.columns.lines.to_vec()).collect();
        (lines, read.load(Ordering::Relaxed) - before)
    };
    let (lines, all) = bytes(None);
    assert_eq!(lines, (1..=1000).collect::<Vec<u64>>());
    // Row groups of 250 rows of 10 ms.
    let (lines, part) = bytes(Some((3.0, 4.0)));
    assert_eq!(lines, (251..=500).collect::<Vec<u64>>());
    assert!(part < all / 3, "{part} of {all} bytes");
}

/// Where only the row groups of a window are read, time still counts from the first sample of the file.
#[test]
fn a_window_counts_from_the_first_row_group() {
    let read = |windows: Vec<(f64, f64)>| {
        let file = LogFile::of_bytes("drive.parquet", DRIVE);
        let options = LogOptions { windows, ..LogOptions::default() };
        read_drives(vec![file], Vec::new(), &options).unwrap()
    };
    let (whole, part) = (read(Vec::new()), read(vec![(5.5, 7.0)]));
    assert_eq!(whole.options.get("log_start_s"), part.options.get("log_start_s"));
    assert!(part.time_s().iter().all(|t| (5.5..=7.0).contains(t)));
    let place = whole.time_s().iter().position(|t| (t - part.time_s()[0]).abs() < 1e-6).unwrap();
    assert!((whole.output[place] - part.output[0]).abs() < 1e-9);
}

#[test]
fn a_damaged_row_group_is_reported_and_the_others_are_read() {
    let mut bytes = DRIVE.to_vec();
    // In the first pages.
    bytes[60..90].fill(0xFF);
    let found =
        inspect(LogFile::of_bytes("drive.parquet", &bytes), &LogOptions::default()).unwrap();
    assert_eq!(found.groups[0].rows, 750, "{:?}", found.losses);
    assert!(found.losses[0].contains("at byte"), "{:?}", found.losses);
    // The footer is at the end.
    let cut = LogFile::of_bytes("drive.parquet", &DRIVE[..DRIVE.len() - 1]);
    let error = inspect(cut, &LogOptions::default()).unwrap_err();
    assert!(error.to_string().contains("byte"), "{error}");
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
        let _ = inspect(LogFile::of_bytes("drive.parquet", &bytes), &LogOptions::default());
    }
}
