//! Drive logs of every format, and the databases of buses.

use std::sync::Once;
use steerwright_drivelog::{LogFile, LogOptions, Response, inspect, read_log};

/// A database with the frames of the logs in the corpus.
const DATABASE: &[u8] = b"BO_ 37 A: 8 X\n SG_ B : 3|12@0- (1.5,0) [0|0] \"deg\" X\n SG_ C M : 0|2@1+ (1,0) [0|0] \"\" X\n";
const BUS: &[u8] =
    b"(1.0) a 025#00001000C00000FD\n(1.1) b 025##0FF00AA5512345678\n(1.2) a 00000025#01\n";

/// A log is refused with a reason or read to its end.
pub(crate) fn logs(bytes: &[u8]) {
    // The crates for Parquet and Arrow panic on some damaged bytes, which the reader contains: see `tables`.
    if cfg!(fuzzing) && is_of_crates(bytes) {
        return;
    }
    read(bytes, DATABASE);
}

/// The same of Parquet and Arrow, whose crates may panic within the reader, but not beyond it.
pub(crate) fn tables(bytes: &[u8]) {
    if !is_of_crates(bytes) {
        return;
    }
    static QUIET: Once = Once::new();
    // The fuzzer's own hook ends the process before a panic is contained.
    QUIET.call_once(|| {
        if cfg!(fuzzing) {
            std::panic::set_hook(Box::new(|_| ()));
        }
    });
    if std::panic::catch_unwind(|| read(bytes, DATABASE)).is_err() {
        std::process::abort();
    }
}

fn is_of_crates(bytes: &[u8]) -> bool {
    let starts: [&[u8]; 3] = [b"PAR1", b"ARROW1", &[0xFF; 4]];
    starts.iter().any(|start| bytes.starts_with(start))
}

/// A definition of a message of ROS is read as far as it is one, and its messages by it.
pub(crate) fn definitions(bytes: &[u8]) {
    let (text, message) = bytes.split_at(bytes.len() - bytes.len() / 4);
    let text = String::from_utf8_lossy(text).into_owned();
    let ros_definitions = [("own_msgs/Own".to_owned(), text)].into();
    let options = LogOptions { ros_definitions, ..LogOptions::default() };
    check(&bag(message), &options);
}

/// An MCAP file with messages of a type without a definition.
fn bag(message: &[u8]) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let record = |code: u8, content: Vec<u8>| {
        [&[code], &(content.len() as u64).to_le_bytes()[..], &content].concat()
    };
    let schema = [vec![1, 0], text("own_msgs/msg/Own"), text("ros2msg"), text("")].concat();
    let channel = [vec![1, 0, 1, 0], text("/own"), text("cdr"), text("")].concat();
    let mut file = [MAGIC.to_vec(), record(1, [text("ros2"), text("")].concat())].concat();
    file.extend(record(3, schema));
    file.extend(record(4, channel));
    for k in 0..3_u64 {
        let times = [k * 10_000_000; 2].map(u64::to_le_bytes).concat();
        file.extend(record(5, [vec![1, 0], vec![0; 4], times, message.to_vec()].concat()));
    }
    [file, record(15, vec![0; 4]), record(2, vec![0; 20]), MAGIC.to_vec()].concat()
}

/// A database is read as far as it is one.
pub(crate) fn databases(bytes: &[u8]) {
    read(BUS, bytes);
}

fn read(log: &[u8], database: &[u8]) {
    let dbc = vec![("fuzzed.dbc".to_owned(), database.to_vec())];
    check(log, &LogOptions { dbc, ..LogOptions::default() });
}

fn check(log: &[u8], options: &LogOptions) {
    if let Err(error) = inspect(LogFile::of_bytes("fuzzed", log), options) {
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
