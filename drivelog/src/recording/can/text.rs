//! Frames of a bus in text: candump of SocketCAN, Vector's ASC, PEAK's traces, logs of BUSMASTER and tables.

use super::asc::Asc;
use super::busmaster::{self, Busmaster};
use super::candump::{candump, has_no_time};
use super::frame::{Frame, Line};
use super::kvaser::{self, Kvaser};
use super::table::{self, Table};
use super::trc::{self, Trc};
use std::io::{BufRead, BufReader, Read};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CanTextForm {
    Candump,
    /// candump whose times count from the frame before (`-t d`).
    Steps,
    /// candump without times.
    NoTime,
    Asc,
    Trc,
    Busmaster,
    Kvaser,
    Table,
}

impl CanTextForm {
    /// The form of a text that starts like this.
    pub(super) fn recognise(start: &[u8]) -> Option<Self> {
        let start = String::from_utf8_lossy(start);
        let start = start.trim_start_matches(BYTE_ORDER_MARK);
        if start.lines().take(30).any(|l| l.starts_with(trc::VERSION)) {
            return Some(Self::Trc);
        }
        // The last line may be cut.
        let is_comment = |l: &&str| l.starts_with(';') || l.starts_with("//");
        let lines = start.lines().map(str::trim).filter(|l| !l.is_empty() && !is_comment(l));
        let mut lines = lines.take(30);
        let first = lines.next()?;
        if first.starts_with("date ")
            || first.starts_with("base hex")
            || first.starts_with("base dec")
        {
            return Some(Self::Asc);
        }
        if first.starts_with(busmaster::MARK) {
            return Some(Self::Busmaster);
        }
        // Text about the logger and the networks may stand above both.
        let top = || start.lines().map(str::trim);
        if top().any(kvaser::is_header) {
            return Some(Self::Kvaser);
        }
        if top().any(|line| Table::from_header(line).is_some() || table::is_above(line)) {
            return Some(Self::Table);
        }
        // The first line may be cut, too.
        let second = lines.next();
        let is = |is_frame: fn(&str) -> bool| is_frame(first) || second.is_some_and(is_frame);
        // Remote frames and errors of the bus may come first.
        let is_other = |line: &str| line.starts_with('(') && matches!(candump(line), Line::Other);
        let mut rest = second.into_iter().chain(lines);
        if is(|line| matches!(candump(line), Line::Frame(_)))
            || is_other(first) && rest.any(|line| matches!(candump(line), Line::Frame(_)))
        {
            Some(Self::Candump)
        } else if is(|line| matches!(Asc::default().line(line), Line::Frame(_))) {
            Some(Self::Asc)
        } else if is(|line| matches!(Trc::default().line(line), Line::Frame(_))) {
            Some(Self::Trc)
        } else if is(has_no_time) {
            Some(Self::NoTime)
        } else {
            None
        }
    }
}

/// The frames of a text, line by line.
pub(super) struct Frames<R> {
    reader: BufReader<R>,
    form: CanTextForm,
    /// Number of lines read.
    pub(super) line: u64,
    /// Number of bytes read.
    pub(super) byte: u64,
    /// Lines that are no frame and nothing else known, and the first of them.
    pub(super) faults: u64,
    pub(super) first_fault: Option<(u64, u64)>,
    text: Vec<u8>,
    pub(super) asc: Asc,
    trc: Trc,
    busmaster: Busmaster,
    kvaser: Kvaser,
    table: Option<Table>,
    /// The instant of the last frame of [`CanTextForm::Steps`], s.
    time: f64,
}

const BYTE_ORDER_MARK: char = '\u{feff}';
/// No line of a bus log is longer.
const LONGEST: u64 = 4096;

impl<R: Read> Frames<R> {
    pub(super) fn new(reader: R, form: CanTextForm) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, reader),
            form,
            line: 0,
            byte: 0,
            faults: 0,
            first_fault: None,
            text: Vec::new(),
            asc: Asc::default(),
            trc: Trc::default(),
            busmaster: Busmaster::default(),
            kvaser: Kvaser::default(),
            table: None,
            time: 0.0,
        }
    }

    /// The next frame, or `None` at the end.
    pub(super) fn next(&mut self) -> std::io::Result<Option<Frame>> {
        loop {
            self.text.clear();
            let count = self.reader.by_ref().take(LONGEST).read_until(b'\n', &mut self.text)?;
            if count == 0 {
                return Ok(None);
            }
            let at = self.byte;
            self.line += 1;
            self.byte += count as u64;
            // Comments may be in another encoding.
            let text = String::from_utf8_lossy(&self.text);
            let text = text.trim_start_matches(BYTE_ORDER_MARK);
            let read = match self.form {
                CanTextForm::Candump | CanTextForm::Steps => candump(text.trim()),
                CanTextForm::Asc => self.asc.line(text.trim()),
                CanTextForm::Trc => self.trc.line(text.trim()),
                CanTextForm::Busmaster => self.busmaster.line(text.trim()),
                CanTextForm::Kvaser => self.kvaser.line(text.trim()),
                CanTextForm::Table => match &mut self.table {
                    Some(table) => table.line(text.trim(), !text.ends_with('\n')),
                    None => {
                        let rows = String::from_utf8_lossy(self.reader.fill_buf()?);
                        self.table = Table::from_header(text.trim()).map(|own| own.based_on(&rows));
                        Line::Other
                    }
                },
                CanTextForm::NoTime => Line::Fault,
            };
            match read {
                Line::Frame(mut frame) => {
                    if self.form == CanTextForm::Steps {
                        self.time += frame.time;
                        frame.time = self.time;
                    }
                    return Ok(Some(frame));
                }
                Line::Other => {}
                Line::Fault => {
                    self.faults += 1;
                    self.first_fault.get_or_insert((self.line, at));
                }
            }
        }
    }

    /// What could not be read, for people.
    pub(super) fn loss(&self, file: &str) -> Option<String> {
        let (line, byte) = self.first_fault?;
        if let Some(problem) = self.table.as_ref().and_then(Table::problem) {
            return Some(format!("{file}:{line}: {problem}"));
        }
        let count = self.faults;
        let lines = if count == 1 { "1 line is" } else { &format!("{count} lines are") };
        Some(format!(
            "{file}: {lines} no frame and not read, the first at line {line}, byte {byte}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> (Vec<Frame>, u64) {
        let form = CanTextForm::recognise(text.as_bytes()).unwrap();
        let mut frames = Frames::new(text.as_bytes(), form);
        let mut read = Vec::new();
        while let Some(frame) = frames.next().unwrap() {
            read.push(frame);
        }
        (read, frames.faults)
    }

    fn frame(time: f64, bus: &str, id: u32, is_extended: bool, data: &[u8]) -> Frame {
        Frame { time, bus: bus.into(), id, is_extended, data: data.into(), is_request: false }
    }

    #[test]
    fn candump_of_both_forms() {
        let text = "(1436509052.249713) vcan0 044#2A366C\n\
             (1436509052.3) vcan0 00000044#\n\
             (1436509052.4) vcan0 123##1AABB\n\
             (1436509052.4) vcan0 123#R\n\
             (1436509052.4) vcan0 20000080#0000000000000000\n\
             (1436509052.5)  can1  1F334455   [2]  11 22\n\
             (1436509052.5)  can1  123   [8]  remote request\n\
             (1436509052.5) vcan0 044#2A3\n";
        let expected = [
            frame(1_436_509_052.249_713, "vcan0", 0x44, false, &[0x2A, 0x36, 0x6C]),
            frame(1_436_509_052.3, "vcan0", 0x44, true, &[]),
            frame(1_436_509_052.4, "vcan0", 0x123, false, &[0xAA, 0xBB]),
            frame(1_436_509_052.5, "can1", 0x1F33_4455, true, &[0x11, 0x22]),
        ];
        assert_eq!(all(text), (expected.to_vec(), 1));
    }

    #[test]
    fn dialects_of_both() {
        let first = |text: &str| all(text).0.swap_remove(0);
        // The column of text, the flags of the direction, a date.
        let plain = frame(1.5, "can0", 0x25, false, &[0x41, 0x20]);
        for text in
            ["(1.5)  can0  025   [2]  41 20   'A '", "(1.5)  can0  RX - -  025   [2]  41 20"]
        {
            assert_eq!(first(text), plain, "{text}");
        }
        // `date -u -d '2024-02-01T10:00:00Z' +%s`
        let dated = frame(1_706_781_600.25, "can0", 0x25, false, &[1]);
        assert_eq!(first("(2024-02-01 10:00:00.250000)  can0  025   [1]  01"), dated);
        let form = |text: &str| CanTextForm::recognise(text.as_bytes());
        assert_eq!(form("  can0  025   [2]  41 20\n"), Some(CanTextForm::NoTime));
        let comment = "; written by a tool\ndate Thu Feb 1\nbase hex\n0.5 1 25 Rx d 1 49\n";
        for text in [comment, "0.5 1 25 Rx d 1 49 Length = 1\n", "0,5 1 25 Rx d 1 49\r\n"] {
            assert_eq!(form(text), Some(CanTextForm::Asc), "{text}");
            assert_eq!(first(text), frame(0.5, "1", 0x25, false, &[0x49]), "{text}");
        }
        assert!(first("0.5 1 25 TxRq d 1 49\n").is_request);
        for data in ["01000001 00100000", "20`41"] {
            assert_eq!(first(&format!("(1.5)  can0  025   [2]  {data}\n")), plain, "{data}");
        }
        // Colours of a terminal.
        let coloured = "\x1b[31m(1.5)  can0  025   [2]  41 20\x1b[0m\n";
        assert_eq!(first(coloured), plain);
        // By name, some of which are numbers, and after a byte-order mark.
        for name in ["STEER", "FACE", "25"] {
            let text = format!("\u{feff}0.5 1 {name} Rx d 1 49 Length = 1 ID = 37\n");
            assert_eq!(first(&text), frame(0.5, "1", 0x25, false, &[0x49]), "{name}");
        }
        let extended = frame(0.5, "1", 0x18FE_CA34, true, &[0x49]);
        assert_eq!(first("0.5 1 Motion Rx d 1 49 Length = 1 ID = 419351092x\n"), extended);
        let mut frames =
            Frames::new(&b"date Do\n// Pr\xfcfstand\n0.5 1 25 Rx d 1 49\n"[..], CanTextForm::Asc);
        assert!(frames.next().unwrap().is_some());
        assert_eq!(frames.faults, 0);
        for text in ["t,x\n1,2\n", "1 2 3\n", "time [s] speed [2]\n", "a b [2] c d\n"] {
            assert_eq!(form(text), None, "{text}");
        }
    }

    #[test]
    fn asc_of_both_bases_and_clocks() {
        let text = "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n\
             internal events logged\nBegin Triggerblock\n 0.000000 Start of measurement\n\
             2.501 1  C8              Rx   d 8 09 08 07 06 05 04 03 02\n\
             3.2 2 18EBFF00x  Tx   d 2 01 A0  Length = 0\n\
             3.3 1 ErrorFrame\n\
             3.4 1  123 Rx r 8\n\
             30.0 CANFD   1 Rx  300   1 0 8 8 01 02 03 04 05 06 07 08 102203 133 303000\n\
             30.1 CANFD   1 Rx  300 Name  1 0 2 2 01 02 1 1\n\
             3.5 1  zz Rx d 1 00\n";
        let expected = [
            frame(2.501, "1", 0xC8, false, &[9, 8, 7, 6, 5, 4, 3, 2]),
            frame(3.2, "2", 0x18EB_FF00, true, &[1, 0xA0]),
            frame(30.0, "1", 0x300, false, &[1, 2, 3, 4, 5, 6, 7, 8]),
            frame(30.1, "1", 0x300, false, &[1, 2]),
        ];
        assert_eq!(all(text), (expected.to_vec(), 1));
        let relative = "base dec  timestamps relative\n0.5 1 200 Rx d 1 10\n0.25 1 200 Rx d 1 11\n";
        let (frames, _) = all(relative);
        assert_eq!(frames[1], frame(0.75, "1", 200, false, &[11]));
    }

    #[test]
    fn peak_traces_of_all_versions() {
        let plain = frame(1.059_9, "1", 0x300, false, &[0xAB, 0x01]);
        let extended = frame(1.059_9, "2", 0x18EF_C034, true, &[0xAB, 0x01]);
        let first = |text: &str| {
            let (frames, faults) = all(text);
            assert_eq!((frames.len(), faults), (1, 0), "{text}");
            frames[0].clone()
        };
        for text in [
            "; PCAN Explorer\n 1)  1059.900  0300  2  AB 01\n",
            ";$FILEVERSION=1.1\n;---\n 1) 1059.9  Rx  0300  2  AB 01\n 2) 1 Warng FFFFFFFF 4 0 0 0 8 BUSHEAVY\n",
            ";$FILEVERSION=1.3\n 1) 1059.9 1 Rx 0300 - 2 AB 01\n 2) 1060.1 1 Rx 0300 - 2 RTR\n",
            ";$FILEVERSION=2.0\n 1 1059.900 DT 0300 Rx 2  AB 01\n 2 1060.000 ST Rx 00 00 00 08\n",
        ] {
            assert_eq!(first(text), plain);
        }
        for text in [
            ";$FILEVERSION=1.2\n 1) 1059.9 2 Tx 18EFC034 2 AB 01\n",
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n 1 1059.900 DT 2 18EFC034 Tx - 2  AB 01\n",
        ] {
            assert_eq!(first(text), extended);
        }
        let long = format!(";$FILEVERSION=2.1\n 1 0 FB 1 0300 Rx - 9 {}\n", "07 ".repeat(12));
        assert_eq!(first(&long).data, [7; 12]);
        assert_eq!(all(";$FILEVERSION=1.1\n 1) 1.0 Rx 25 8 49 03\n").1, 1);
    }

    #[test]
    fn tables_of_other_tools() {
        let plain = frame(1.5, "0", 0x25, false, &[0x49, 3]);
        let long = frame(2.5, "0", 0x18FE_CA34, true, &[]);
        for (text, bus) in [
            ("time,addr,bus,data\n1.5,0x25,0,0x4903\n2.5,419351092,0,\n3,0x25,0,0x490\n", "0"),
            // SavvyCAN and GVRET, in microseconds.
            (
                "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n\
                 1500000,00000025,false,Rx,0,2,49,03,\n2500000,18FECA34,true,Rx,0,0,\n3,25,false,Rx,0,2,49\n",
                "0",
            ),
            (
                "timestamp,arbitration_id,extended,remote,error,dlc,data\n\
                 1.5,0x25,0,0,0,2,SQM=\n1.6,0x25,0,1,0,2,\n2.5,0x18feca34,1,0,0,0,\n3,x,0,0,0,2,SQM=\n",
                "1",
            ),
            (
                "TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;ESI;RTR;DataBytes\n\
                 1.5;2;025;0;2;2;0;0;0;0;0;4903\n2.5;2;18FECA34;1;0;0;0;0;0;0;0;\n3;2;025;0;2;2;0;0;0;0;0;490\n",
                "2",
            ),
        ] {
            let expected = [&plain, &long].map(|f| Frame { bus: bus.into(), ..f.clone() });
            assert_eq!(all(text), (expected.to_vec(), 1), "{text}");
        }
        for text in ["time,addr,speed\n1,2,3\n", "timestamp,id,speed\n", "Time Stamp,ID,D1\n"] {
            assert_eq!(CanTextForm::recognise(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn tables_of_other_tools_that_are_damaged_or_written_otherwise() {
        let python = "timestamp,arbitration_id,extended,remote,error,dlc,data\n";
        let edge =
            "TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;ESI;RTR;DataBytes\n";
        let savvy = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n";
        for (head, row) in [
            // Fewer bytes than stated.
            (python, "1.5,0x25,0,0,0,3,AA\n"),
            (python, "1.5,0x25,0,0,0,3,A*AA\n"),
            (edge, "1.5;1;25;0;3;3;0;0;0;0;0;012C"),
            // A byte of which a digit is missing.
            (savvy, "300000,00000025,false,Rx,0,3,00,10,1"),
        ] {
            assert_eq!(all(&format!("{head}{row}")), (Vec::new(), 1), "{row}");
        }
        let extended = frame(1.5, "0", 0x25, true, &[0x49]);
        for row in ["1500000,00000025,TRUE,Rx,0,1,49,", "1.500000,00000025,true,Rx,0,1,49"] {
            assert_eq!(all(&format!("{savvy}{row}")), (vec![extended.clone()], 0), "{row}");
        }
    }

    #[test]
    fn tables_of_kvaser_in_both_bases() {
        let head = "Time,Channel,ID,Flags,DLC,Data0,Data1,Data2,Counter,AbsTime\n";
        let expected =
            [frame(1.5, "1", 0x25, false, &[0x49, 3]), frame(2.5, "1", 0x18FE_CA34, true, &[])];
        for rows in [
            "1.5,1,37,0,2,73,3,,0,\n1.6,1,37,1,2,,,,1,\n2.5,1,419351092,4,0,,,,2,\n3,1,37,0,2,x,3,,3,\n",
            "1.5,1,25,0,2,49,03,,0,\n1.6,1,25,1,2,,,,1,\n2.5,1,18FECA34,4,0,,,,2,\n3,1,25,0,2,x,3,,3,\n",
        ] {
            assert_eq!(all(&format!("{head}{rows}")), (expected.to_vec(), 1), "{rows}");
        }
    }

    #[test]
    fn logs_of_kvaser_in_both_bases() {
        let expected =
            [frame(100.5, "0", 0x25, false, &[0x49, 3]), frame(101.5, "0", 0x18FE_CA34, true, &[])];
        let king = "Chn Identifier Flg   DLC  D0...1...2...3...4...5...6..D7       Time     Dir\n";
        let hex = " 0    00000025         2  49  03            100.500000 R\n\
                    0    18FECA34 X       0                    101.500000 T\n";
        let decimal = " 0          37         2  73   3            100.500000 R\n\
                        0   419351092 X       0                    101.500000 T\n";
        let others = " 0    00000025 R       0                    101.600000 R\n\
                       0    ErrorFrame                            101.700000 R\n\
                      Logging stopped.\n 0    00000025         2  49      102.500000 R\n";
        for rows in [hex, decimal] {
            assert_eq!(all(&format!("{king}{rows}{others}")), (expected.to_vec(), 1), "{rows}");
        }
        let settings = |base: &str| {
            format!(
                "                  Kvaser Memorator Log\n                  ====================\n\n\
                 Settings:\n   Format of data field: {base}\n   Format of id field:   {base}\n\n\
                 \x20       Time Chan   Identifier Flags        DLC Data          Counter\n=====\n\
                 \x20   0.000  Trigger (type=0x1, active=0x00, pre-trigger=0, post-trigger=-1)\n"
            )
        };
        let hex =
            " 100.500000  0   25 Rx    2 49 03    1\n 101.500000  0  18FECA34 Rx X  0     2\n";
        let decimal = " 100.500000  0   37 Rx    2 73 3    1\n 101.500000  0  419351092  0     2\n";
        for (base, rows) in [("HEX", hex), ("DEC", decimal)] {
            assert_eq!(all(&(settings(base) + rows)), (expected.to_vec(), 0), "{base}");
        }
    }

    #[test]
    fn tables_below_a_text_and_of_unknown_programs() {
        let expected =
            [frame(1.5, "1", 0x25, false, &[0x49, 3]), frame(2.5, "1", 0x18FE_CA34, true, &[])];
        let spy = "Measurement Started,3/1/2024 10:00:00 AM\nNetwork Description,Hardware,Network,Protocol,Baud Rate\n\n\
            Line,Abs Time(Sec),Rel Time (Sec),Status,Er,Tx,Description,Network,Node,Arb ID,Remote,Xtd,B1,B2,B3,Value,Trigger,Signals\n\
            1,1.5,0,67371008,F,F,\"Steer, raw\",1,,25,F,F,49,3,,,,\n2,1.6,.1,8,F,F,x,1,,25,T,F,,,,,,\n2,1.7,.1,8,T,F,x,1,,25,F,F,,,,,,\n\
            3,2.5,1,8,F,T,x,1,,18FECA34,F,T,,,,,,\n4,3,1,8,F,F,x,1,,25,F,F,49";
        assert_eq!(all(spy), (expected.to_vec(), 1));
        let ms = "Message,Time Offset (ms),Type,ID,Length,Data\n1,1500,Rx,025h,2,49 03\n2,2500,Rx,18FECA34h,0,\n";
        let hex = "Trace,V1.3\n\"Time\",\"Identifier (hex)\",\"Format\",\"Data (hex)\"\n\
                   \"00:00:01.500\",\"25\",\"Std\",\"49 03\"\n\"00:00:02.500\",\"18FECA34\",\"Ext\",\"\"\n";
        let rows = "Time;Chn;ID;DLC;Data\n1.5;1;25;2;4903\n2.5;1;18FECA34;0;\n";
        for text in [ms, hex, rows] {
            assert_eq!(all(text), (expected.to_vec(), 0), "{text}");
        }
        // Without a letter in any identifier its base is open, and without a point the unit of the times.
        for (text, part) in [
            ("Time;Chn;ID;DLC;Data\n1.5;1;25;2;4903\n", "base of the identifiers"),
            ("Time;Chn;ID;DLC;Data\n1500;1;0x25;2;4903\n", "unit of the times"),
        ] {
            let form = CanTextForm::recognise(text.as_bytes()).unwrap();
            let mut frames = Frames::new(text.as_bytes(), form);
            assert_eq!(frames.next().unwrap(), None);
            assert!(frames.loss("a.csv").unwrap().contains(part), "{text}");
        }
    }

    #[test]
    fn tables_of_the_cl2000_with_all_its_clocks() {
        let head = "# Logger type: CL2000\n# Time format: 4\nTimestamp;Type;ID;Data\n";
        let rows = |first: &str, second: &str| {
            let text = format!("{head}{first};0;25;4903\n{second};9;18feca34;\n");
            let (read, faults) = all(&text);
            assert_eq!((read.len(), faults), (2, 0), "{text}");
            assert_eq!((read[0].id, read[0].is_extended, read[1].is_extended), (0x25, false, true));
            [read[0].time, read[1].time]
        };
        // `date -u -d '2024-03-01T10:00:00Z' +%s`
        let ten = 1_709_287_200.0;
        assert_eq!(rows("20240301T100000250", "20240302T100000250"), [ten + 0.25, ten + 86_400.25]);
        assert_eq!(rows("01T235959500", "02T000000500"), [86_399.5, 86_400.5]);
        assert_eq!(rows("0301T10:00:00.250", "0301T10:00:01.250").map(|t| t % 60.0), [0.25, 1.25]);
    }

    #[test]
    fn sessions_of_busmaster_follow_each_other() {
        let session = |date: &str, mode: &str, clock: &str| {
            format!(
                "***BUSMASTER Ver 3.2.2***\n***START DATE AND TIME {date}***\n***HEX***\n***{mode} MODE***\n\
                 {clock} Rx 1 0x025 s 1 49\n***[STOP LOGGING SESSION]***\n"
            )
        };
        let times = |mode: &str, clocks: [&str; 2]| {
            let first = session("30:9:2013 14:00:0:0", mode, clocks[0]);
            let second = session("1:10:2013 8:00:0:500", mode, clocks[1]);
            let (read, faults) = all(&(first + &second));
            assert_eq!(faults, 0);
            read.into_iter().map(|frame| frame.time).collect::<Vec<f64>>()
        };
        let day = 86_400.0;
        let of_day = times("SYSTEM", ["14:00:01:0000", "08:00:01:0000"]);
        assert_eq!(of_day, [14.0 * 3600.0 + 1.0, day + 8.0 * 3600.0 + 1.0]);
        for mode in ["ABSOLUTE", "RELATIVE"] {
            let of_start = times(mode, ["00:00:01:0000", "00:00:01:0000"]);
            assert_eq!(of_start, [1.0, 18.0 * 3600.0 + 1.5], "{mode}");
        }
    }

    #[test]
    fn busmaster() {
        let head = "***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n***HEX***\n***SYSTEM MODE***\n";
        let rows = "23:59:59:9000 Rx 1 0x025 s 2 49 03 \n00:00:00:1000 Tx 2 0x18FECA34 x 0\n\
                    00:00:00:2000 Rx 1 0x025 sr 2\n00:00:00 Rx 1 0x025 s 0\n";
        let day = 86_400.0;
        let (read, faults) = all(&format!("{head}{rows}"));
        assert_eq!((read.len(), faults), (2, 1));
        assert_eq!(read[0], frame(day - 0.1, "1", 0x25, false, &[0x49, 3]));
        assert_eq!((read[1].id, read[1].is_extended), (0x18FE_CA34, true));
        assert!((read[1].time - day - 0.1).abs() < 1e-6, "{}", read[1].time);
        let relative = head.replace("SYSTEM", "RELATIVE").replace("HEX", "DEC");
        let rows = "00:00:01:0000 Rx 1 37 s 1 73\n00:00:00:5000 Rx 1 37 s 1 3\n";
        let (read, _) = all(&format!("{relative}{rows}"));
        assert_eq!(read[1], frame(1.5, "1", 0x25, false, &[3]));
    }
}
