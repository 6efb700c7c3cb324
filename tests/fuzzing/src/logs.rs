//! Drive logs of every format, and the databases of buses.

use steerwright_drivelog::{LogFile, LogOptions, Response, inspect, read_log};

/// A database with the frames of the logs in the corpus.
const DATABASE: &[u8] = b"BO_ 37 A: 8 X\n SG_ B : 3|12@0- (1.5,0) [0|0] \"deg\" X\n SG_ C M : 0|2@1+ (1,0) [0|0] \"\" X\n";
const BUS: &[u8] =
    b"(1.0) a 025#00001000C00000FD\n(1.1) b 025##0FF00AA5512345678\n(1.2) a 00000025#01\n";

/// A log is refused with a reason or read to its end.
pub(crate) fn logs(bytes: &[u8]) {
    // The crates for Parquet and Arrow panic on some damaged bytes, which the reader contains and the fuzzer does not.
    let starts: [&[u8]; 3] = [b"PAR1", b"ARROW1", &[0xFF; 4]];
    if cfg!(fuzzing) && starts.iter().any(|start| bytes.starts_with(start)) {
        return;
    }
    read(bytes, DATABASE);
}

/// A database is read as far as it is one.
pub(crate) fn databases(bytes: &[u8]) {
    read(BUS, bytes);
}

fn read(log: &[u8], database: &[u8]) {
    let dbc = vec![("fuzzed.dbc".to_owned(), database.to_vec())];
    let options = LogOptions { dbc, ..LogOptions::default() };
    if let Err(error) = inspect(LogFile::of_bytes("fuzzed", log), &options) {
        assert!(!error.to_string().is_empty());
        assert!(!error.hint().is_empty());
    }
    for response in Response::ALL {
        let options = LogOptions { response, ..options.clone() };
        let files = [("fuzzed".to_owned(), log.to_vec())];
        if let Err(error) = read_log(&files, &options) {
            assert!(!error.to_string().is_empty());
            assert!(!error.hint().is_empty());
        }
    }
}
