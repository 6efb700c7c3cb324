//! Logs that are compressed as a whole.

use super::good;
use std::io::{Cursor, Write};
use steerwright_drivelog::{Error, Inspection, LogFile, LogOptions, inspect};

fn zstandard(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}

fn zip(names: &[&str], bytes: &[u8]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for name in names {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn read(name: &str, bytes: &[u8]) -> Result<Inspection, Error> {
    inspect(LogFile::of_bytes(name, bytes), &LogOptions::default())
}

#[test]
fn members_of_gzip_follow_each_other_and_zeros_end_them() {
    let gzip = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let text = good();
    let (start, end) = text.split_at(text.len() / 2);
    let members = [gzip(start), gzip(end)].concat();
    for zeros in [0, 512, 100_000] {
        let padded = [members.clone(), vec![0; zeros]].concat();
        let found = read("a.csv.gz", &padded).unwrap();
        assert_eq!((found.groups[0].rows, found.losses.len()), (1000, 0), "{zeros}");
    }
    let apart = [gzip(start), vec![0; 512], gzip(end)].concat();
    assert_eq!(read("a.csv.gz", &apart).unwrap().groups[0].rows, 1000);
    let error = read("a.csv.gz", &[members, b"\0\0more".to_vec()].concat()).unwrap_err();
    assert!(error.to_string().contains("no gzip follow"), "{error}");
}

#[test]
fn a_text_is_read_through_its_compression() {
    let text = good();
    let (start, end) = text.split_at(text.len() / 2);
    // A frame that is to be passed over stands between two frames.
    let passed_over = [0x50, 0x2A, 0x4D, 0x18, 3, 0, 0, 0, 1, 2, 3].to_vec();
    let frames = [zstandard(start), passed_over, zstandard(end)].concat();
    for (name, bytes) in [
        ("a.csv.zst", frames.as_slice()),
        ("a.csv.bz2", &bzip2(&text)),
        ("a.zip", &zip(&["folder/a.csv"], &text)),
    ] {
        let found = read(name, bytes).unwrap();
        assert_eq!((found.groups[0].rows, found.losses.len()), (1000, 0), "{name}");
        if name != "a.zip" {
            let stream = LogFile::of_stream(name, bytes);
            let found = inspect(stream, &LogOptions::default()).unwrap();
            assert_eq!(found.groups[0].rows, 1000, "{name}");
        }
        let _ = read(name, &bytes[..bytes.len() / 2]);
    }
    for names in [&["a.csv", "b.csv"][..], &["xl/workbook.xml", "docProps/app.xml"]] {
        let refused = read("a.zip", &zip(names, &text));
        assert!(matches!(refused, Err(Error::OtherFormat { .. })), "{refused:?}");
    }
}

#[test]
fn formats_that_are_read_at_several_places_are_unpacked() {
    let whole = include_bytes!("fixtures/drive.parquet");
    for bytes in [zstandard(whole), bzip2(whole), zip(&["drive.parquet"], whole)] {
        assert_eq!(read("drive.parquet.x", &bytes).unwrap().groups[0].rows, 1000);
        assert!(read("drive.parquet.x", &bytes[..bytes.len() / 2]).is_err());
    }
}

#[test]
fn damage_within_a_compressed_file_is_reported() {
    let recorded = include_bytes!("../../../tests/fuzzing/corpus/logs/none.mcap");
    let gzip = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let bytes = gzip(recorded);
    assert_eq!(read("a.mcap.gz", &bytes).unwrap().losses.len(), 0);
    let found = read("a.mcap.gz", &bytes[..bytes.len() - 1000]).unwrap();
    let last = found.losses.last().unwrap();
    assert!(last.contains("decompressed") && last.contains("is not read"), "{last}");
    let parquet = gzip(include_bytes!("fixtures/drive.parquet"));
    let error = read("a.parquet.gz", &parquet[..parquet.len() / 2]).unwrap_err();
    assert!(error.to_string().contains("decompressed"), "{error}");
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        changes in proptest::collection::vec((0_usize..100_000, 0_u8..=255), 1..12),
        form in 0..3,
    ) {
        let text = b"t,x\n0,1\n1,2\n".repeat(20);
        let mut bytes = match form {
            0 => zstandard(&text),
            1 => bzip2(&text),
            _ => zip(&["a.csv"], &text),
        };
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        let _ = read("a.csv.x", &bytes);
    }
}
