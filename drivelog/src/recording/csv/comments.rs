//! Comment lines, taken out of a text before its cells are parsed: a quote in one opens no cell. Zeros that end a file,
//! as after a loss of power, are taken out too, and a row has a bound.

use super::missing::is_spreadsheet_error;
use std::collections::VecDeque;
use std::io::Read;

const BOM: [u8; 3] = *b"\xEF\xBB\xBF";

/// A reader without comment lines; their ends stay, so that lines count the same.
pub(super) struct WithoutComments<R> {
    inner: R,
    delimiter: u8,
    at: At,
    /// Whether the last byte ends a line.
    at_line_end: bool,
    /// Whether the text ends within quotes.
    is_open: bool,
    /// Bytes of the row so far.
    length: usize,
    /// Zeros since the last other byte but ends of lines.
    zeros: u64,
    line_of_zeros: u64,
    /// Whether these zeros began within a line.
    is_torn: bool,
    /// A `/` that may begin a comment.
    slash: bool,
    /// Blanks that delimit the last cell, where one follows.
    blank: bool,
    /// Bytes of a byte-order mark at the start of a line, as in files that were joined.
    order_mark: usize,
    /// A first cell that may be a comment: `#N/A` and `%` are none.
    mark: Vec<u8>,
    /// The lines of the file that have text: place in what is passed on, and number. The parser counts no line that a
    /// carriage return ends, and none that is blank.
    lines: VecDeque<(u64, u64)>,
    line: u64,
    /// Whether the last byte is a carriage return.
    is_return: bool,
    /// Bytes that have been made ready.
    place: u64,
    /// Whether a byte of this line has been made ready.
    has_text: bool,
    /// Bytes that are read, and from where on they have not been passed on.
    ready: Vec<u8>,
    from: usize,
    buffer: Vec<u8>,
}

/// Where in a line the next byte is.
#[derive(Clone, Copy, PartialEq)]
enum At {
    LineStart,
    /// After blanks at the start.
    Indent,
    CellStart,
    Cell,
    /// After a quote at the start of a cell, until the next one.
    Quoted,
    /// After that next one.
    Quote,
    Comment,
    /// In a first cell that may be a comment.
    Mark,
}

/// No error of a spreadsheet is longer.
const LONGEST_MARK: usize = 10;
/// Most bytes of a row, which is in memory as a whole.
const LONGEST_ROW: usize = 1 << 24;

impl<R: Read> WithoutComments<R> {
    pub(super) fn new(inner: R, delimiter: u8) -> Self {
        let (ready, buffer) = (Vec::new(), vec![0; 1 << 16]);
        let mark = Vec::new();
        Self {
            inner,
            delimiter,
            at: At::LineStart,
            at_line_end: false,
            is_open: false,
            length: 0,
            zeros: 0,
            line_of_zeros: 0,
            is_torn: false,
            slash: false,
            blank: false,
            order_mark: 0,
            mark,
            lines: VecDeque::new(),
            line: 1,
            is_return: false,
            place: 0,
            has_text: false,
            ready,
            from: 0,
            buffer,
        }
    }

    /// The line of the file with the first text at or after a place in what is passed on; the places of successive calls
    /// do not fall.
    pub(super) fn line_at(&mut self, place: u64) -> Option<u64> {
        while self.lines.front().is_some_and(|(own, _)| *own < place) {
            self.lines.pop_front();
        }
        self.lines.front().map(|(_, line)| *line)
    }

    fn pass(&mut self, byte: u8) {
        let ends_line = b"\r\n".contains(&byte);
        if !ends_line && !self.has_text {
            self.lines.push_back((self.place, self.line));
        }
        self.has_text = !ends_line;
        self.place += 1;
        self.ready.push(byte);
    }

    /// What is read, byte for byte but within cells, where most bytes change nothing.
    fn take_all(&mut self, mut bytes: &[u8]) {
        while let Some((byte, rest)) = bytes.split_first() {
            let is_within = matches!(self.at, At::Cell | At::CellStart) && self.has_text;
            if is_within && self.zeros == 0 && self.delimiter != b' ' {
                let plain = bytes.iter().take_while(|b| !matches!(b, 0 | b'\n' | b'\r' | b'"'));
                let (plain, rest) = bytes.split_at(plain.count());
                if let Some(last) = plain.last() {
                    self.at = if *last == self.delimiter { At::CellStart } else { At::Cell };
                    self.length += plain.len();
                    self.place += plain.len() as u64;
                    self.ready.extend_from_slice(plain);
                    bytes = rest;
                    continue;
                }
            }
            self.take(*byte);
            bytes = rest;
        }
    }

    fn pass_mark(&mut self) {
        for byte in std::mem::take(&mut self.mark) {
            self.pass(byte);
        }
    }

    pub(super) fn inner(&self) -> &R {
        &self.inner
    }

    /// Whether what was read ends with the end of a line.
    pub(super) fn ends_line(&self) -> bool {
        self.at_line_end
    }

    /// Zeros at the end of what was read.
    pub(super) fn zeros(&self) -> u64 {
        self.zeros
    }

    /// Whether there are zeros at the end, and they began within a line.
    pub(super) fn is_torn(&self) -> bool {
        self.zeros > 0 && self.is_torn
    }

    /// Whether what was read ends within quotes.
    pub(super) fn is_quoted(&self) -> bool {
        self.is_open
    }

    fn take(&mut self, byte: u8) {
        self.take_byte(byte);
        self.line += u64::from(byte == b'\r' || byte == b'\n' && !self.is_return);
        self.is_return = byte == b'\r';
    }

    fn take_byte(&mut self, byte: u8) {
        if self.at == At::LineStart && BOM.get(self.order_mark) == Some(&byte) {
            self.order_mark += 1;
            if self.order_mark == BOM.len() {
                self.order_mark = 0;
            }
            return;
        }
        // Its first bytes alone are a letter.
        for byte in BOM.into_iter().take(std::mem::take(&mut self.order_mark)) {
            self.at = At::Cell;
            self.pass(byte);
        }
        if byte == 0 {
            if self.zeros == 0 {
                self.is_torn = !self.at_line_end;
                self.line_of_zeros = self.line;
            }
            self.zeros += 1;
            return;
        }
        self.at_line_end = b"\r\n".contains(&byte);
        // The end of the line belongs to the zeros, unless a row began before them.
        if self.zeros > 0 && (self.is_torn || !self.at_line_end) {
            self.zeros = 0;
            let line = std::mem::replace(&mut self.line, self.line_of_zeros);
            self.pass(0);
            self.line = line;
        }
        self.length = if self.at == At::LineStart { 1 } else { self.length + 1 };
        if std::mem::take(&mut self.slash) {
            if byte == b'/' {
                self.at = At::Comment;
            } else {
                self.at = At::Cell;
                self.pass(b'/');
            }
        }
        if self.at == At::Mark {
            let ends = byte == self.delimiter || b"\r\n".contains(&byte);
            if !ends && self.mark.len() < LONGEST_MARK {
                self.mark.push(byte);
                return;
            }
            self.at = if ends && self.is_cell(byte) { At::Cell } else { At::Comment };
            if self.at == At::Cell {
                self.pass_mark();
            }
            if byte == self.delimiter && self.at == At::Comment {
                return;
            }
        }
        if self.delimiter == b' ' && !matches!(self.at, At::Quoted | At::Comment) {
            // A run of blanks is one delimiter, and none at the ends of a line.
            if b" \t".contains(&byte) {
                self.blank = self.at != At::LineStart;
                return;
            }
            if std::mem::take(&mut self.blank) && !self.at_line_end {
                self.at = At::CellStart;
                self.pass(b' ');
            }
        }
        self.at = match (self.at, byte) {
            (At::Quoted, b'"') => At::Quote,
            // Two quotes within are one of the text.
            (At::Quoted, _) | (At::Quote, b'"') => At::Quoted,
            (_, b'\n' | b'\r') => At::LineStart,
            (At::Comment, _) => return,
            (At::LineStart | At::Indent, b'#' | b'%') => {
                self.at = At::Mark;
                self.mark = vec![byte];
                return;
            }
            (At::LineStart | At::Indent, b'/') => {
                self.slash = true;
                return;
            }
            (_, byte) if byte == self.delimiter => At::CellStart,
            (At::LineStart | At::Indent, byte) if byte.is_ascii_whitespace() => At::Indent,
            (At::LineStart | At::CellStart, b'"') => At::Quoted,
            _ => At::Cell,
        };
        self.pass(byte);
    }

    /// Whether the first cell is one, and no comment.
    fn is_cell(&self, end: u8) -> bool {
        let is_delimited = end == self.delimiter && end != b' ';
        is_spreadsheet_error(&self.mark) || is_delimited && self.mark.trim_ascii() == b"%"
    }
}

impl<R: Read> Read for WithoutComments<R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        while self.from == self.ready.len() {
            self.ready.clear();
            self.from = 0;
            let mut buffer = std::mem::take(&mut self.buffer);
            let count = self.inner.read(&mut buffer);
            if let Ok(count) = &count {
                self.take_all(&buffer[..*count]);
            }
            self.buffer = buffer;
            if self.length > LONGEST_ROW {
                let problem = "a row of more than 16 MiB: its end or the end of a quote is missing";
                return Err(std::io::Error::other(problem));
            }
            if count? == 0 {
                self.is_open |= self.at == At::Quoted;
                if std::mem::take(&mut self.slash) {
                    self.pass(b'/');
                }
                if self.at == At::Mark && is_spreadsheet_error(&self.mark) {
                    self.pass_mark();
                }
                self.mark.clear();
                self.at = At::Comment;
                break;
            }
        }
        let count = (&self.ready[self.from..]).read(to)?;
        self.from += count;
        Ok(count)
    }
}
