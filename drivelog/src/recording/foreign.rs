//! Formats that are not read here, by their first bytes or lines, and what reads them.

use super::Recording;
use super::bytes::{Head, LogFile};
use crate::Error;
use crate::options::LogOptions;

/// First bytes, name, what to do.
type Known = (&'static [u8], &'static str, &'static str);

const PYTHON: &str = "read it in Python: pip install './python[logs]', then steerwright.read(FILE); or convert it to CSV, MCAP or Parquet";
const BUS: &str = "read it in Python: pip install './python[logs]', then steerwright.read(FILE, dbc=DBC); or convert it, as with: python -m can.logconvert IN.blf OUT.asc";
const PACKETS: &str =
    "export the frames with Wireshark as text, or record the bus with candump -L, which is read";
const SHEET: &str = "export the sheet as CSV";
const COLUMNS: &str =
    "convert it to Parquet or CSV, as with pandas.read_feather(FILE).to_parquet(OUT)";
const UNPACK: &str =
    "decompress it first; one log in gzip, Zstandard, bzip2 or ZIP is read as it is";

const AUTOPILOT: &str = "read it in Python: pip install ./python, then steerwright.read(FILE); or convert it to CSV, as with ulog2csv of pyulog";
const ARDUPILOT: &str = "read the binary log in Python: pip install ./python, then steerwright.read(FILE); or convert a message to CSV with pymavlink, as in: mavlogdump.py --format csv --types STER FILE > OUT.csv";
const UTF_32: &str = "save it as UTF-8, as with: iconv -f UTF-32 -t UTF-8 LOG > UTF8.csv";

/// First letters of a text that marks up another one, name, what to do.
const MARKED_UP: &[(&str, &str, &str)] = &[
    ("<!doctype html", "a web page (HTML)", "download the log itself"),
    ("<html", "a web page (HTML)", "download the log itself"),
    ("<gpx", "a track (GPX)", TRACK),
    ("<kml", "a track (KML)", TRACK),
    ("<?xml", "an XML document", "export the numbers as CSV"),
];
const TRACK: &str = "convert it to CSV, as with: gpsbabel -i gpx -f IN -o unicsv -F OUT.csv";

const FORMATS: &[Known] = &[
    (b"\x89HDF\r\n\x1a\n", "HDF5", "convert it to Parquet or CSV, as with h5py and pandas"),
    (b"MATLAB 7.3 MAT", "a MAT file (MATLAB 7.3)", PYTHON),
    (b"MATLAB 5.0 MAT", "a MAT file (MATLAB)", PYTHON),
    (b"\xd0\xcf\x11\xe0", "an Excel workbook (.xls)", SHEET),
    (b"\xd4\xc3\xb2\xa1", "a packet capture (pcap)", PACKETS),
    (b"\xa1\xb2\xc3\xd4", "a packet capture (pcap)", PACKETS),
    (b"\x4d\x3c\xb2\xa1", "a packet capture (pcap)", PACKETS),
    (b"\xa1\xb2\x3c\x4d", "a packet capture (pcap)", PACKETS),
    (b"\x0a\x0d\x0d\x0a", "a packet capture (pcapng)", PACKETS),
    (b"LOGG", "a bus log of Vector (BLF)", BUS),
    (b"SQLite format 3\0", "an SQLite database, such as a ROS 2 bag (.db3)", PYTHON),
    (b"#ROSBAG V", "a ROS 1 bag", PYTHON),
    (b"TDSm", "a TDMS file", PYTHON),
    (b"FEA1", "Feather of the first version", COLUMNS),
    (b"ULog\x01\x12\x35", "a log of PX4 (ULog)", AUTOPILOT),
    (b"\xa3\x95\x80\x80", "a log of ArduPilot (.bin)", ARDUPILOT),
    (b"FMT, 128, 89, FMT,", "a log of ArduPilot in text", ARDUPILOT),
    (b"\xff\xfe\0\0", "text in UTF-32", UTF_32),
    (b"\0\0\xfe\xff", "text in UTF-32", UTF_32),
    (b"\x28\xb5\x2f\xfd", "compressed as a whole (Zstandard)", UNPACK),
    (b"\xfd7zXZ\0", "compressed as a whole (xz)", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"BZh", "compressed as a whole (bzip2)", UNPACK),
    (b"PK\x03\x04", "a ZIP archive", UNPACK),
];

fn known(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let (magic, name, help) = FORMATS.iter().find(|(magic, ..)| start.starts_with(magic))?;
    let has = |part: &[u8]| start.windows(part.len()).any(|bytes| bytes == part);
    // Text may begin like the letters of a name: in the format, a number or padding follows.
    let is_text =
        |bytes: &[u8]| bytes.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
    if magic.iter().all(u8::is_ascii_alphanumeric) && is_text(start.get(..64).unwrap_or(start)) {
        return None;
    }
    if *magic == b"BZh" && start.get(4..10).is_none_or(|block| block != b"1AY&SY") {
        return None;
    }
    if *magic == b"PK\x03\x04"
        && [&b"xl/"[..], b"[Content_Types].xml", b"docProps/"].into_iter().any(has)
    {
        return Some(("an Excel workbook (.xlsx)", SHEET));
    }
    Some((name, help))
}

/// A text that is no table, by its first lines.
fn known_text(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let begins = |text: &str, with: &str| {
        text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with))
    };
    if text.starts_with('<') {
        let of_root = |root: &str| MARKED_UP.iter().find(|(with, ..)| begins(root, with)).copied();
        // What a document of XML is stands in its first elements.
        let inner =
            text.match_indices('<').skip(1).take(8).find_map(|(at, _)| of_root(&text[at..]));
        let (_, name, help) = inner.or_else(|| of_root(text))?;
        return Some((name, help));
    }
    let mut lines = text.lines().map(str::trim_end).filter(|line| *line != "---");
    let first = lines.next()?;
    let is_key = first.ends_with(':') || first.contains(": ");
    let is_yaml = is_key && !first.contains([',', ';', '\t']) && text.lines().any(|l| l == "---");
    if !is_yaml {
        return None;
    }
    Some((
        "YAML, as ros2 topic echo prints messages",
        "record them with ros2 bag record, or print a table with ros2 topic echo --csv, in ROS 1 with rostopic echo -p",
    ))
}

fn recognised(start: &[u8]) -> Option<(&'static str, &'static str)> {
    known(start).or_else(|| known_text(start))
}

pub(super) fn recognises(head: &Head<'_>) -> bool {
    recognised(head.start).is_some()
}

/// Refuses the file by the name of its format.
pub(super) fn open<'a>(
    file: LogFile<'a>,
    _: &LogOptions,
) -> Result<Box<dyn Recording + 'a>, Error> {
    let start = file.head()?;
    let (format, help) = recognised(&start).unwrap_or(("another format", SHEET));
    Err(Error::OtherFormat { file: file.name, format, help })
}
