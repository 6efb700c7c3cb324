//! Comment lines, taken out of a text before its cells are parsed: a quote in one opens no cell.

use std::io::Read;

const BOM: [u8; 3] = *b"\xEF\xBB\xBF";

/// A reader without comment lines; their ends stay, so that lines count the same.
pub(super) struct WithoutComments<R> {
    inner: R,
    delimiter: u8,
    at: At,
    /// A `/` that may begin a comment.
    slash: bool,
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
}

impl<R: Read> WithoutComments<R> {
    pub(super) fn new(inner: R, delimiter: u8) -> Self {
        let (ready, buffer) = (Vec::new(), vec![0; 1 << 16]);
        Self { inner, delimiter, at: At::LineStart, slash: false, ready, from: 0, buffer }
    }

    pub(super) fn inner(&self) -> &R {
        &self.inner
    }

    fn take(&mut self, byte: u8) {
        if std::mem::take(&mut self.slash) {
            if byte == b'/' {
                self.at = At::Comment;
            } else {
                self.at = At::Cell;
                self.ready.push(b'/');
            }
        }
        self.at = match (self.at, byte) {
            (At::Quoted, b'"') => At::Quote,
            // Two quotes within are one of the text.
            (At::Quoted, _) | (At::Quote, b'"') => At::Quoted,
            (_, b'\n' | b'\r') => At::LineStart,
            (At::Comment, _) => return,
            (At::LineStart | At::Indent, b'#' | b'%') => {
                self.at = At::Comment;
                return;
            }
            (At::LineStart | At::Indent, b'/') => {
                self.slash = true;
                return;
            }
            (_, byte) if byte == self.delimiter => At::CellStart,
            (At::LineStart, byte) if BOM.contains(&byte) => At::LineStart,
            (At::LineStart | At::Indent, byte) if byte.is_ascii_whitespace() => At::Indent,
            (At::LineStart | At::CellStart, b'"') => At::Quoted,
            _ => At::Cell,
        };
        self.ready.push(byte);
    }
}

impl<R: Read> Read for WithoutComments<R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        while self.from == self.ready.len() {
            self.ready.clear();
            self.from = 0;
            let mut buffer = std::mem::take(&mut self.buffer);
            let count = self.inner.read(&mut buffer);
            count.as_ref().map_or(&[][..], |n| &buffer[..*n]).iter().for_each(|b| self.take(*b));
            self.buffer = buffer;
            if count? == 0 {
                if std::mem::take(&mut self.slash) {
                    self.ready.push(b'/');
                }
                break;
            }
        }
        let count = (&self.ready[self.from..]).read(to)?;
        self.from += count;
        Ok(count)
    }
}
