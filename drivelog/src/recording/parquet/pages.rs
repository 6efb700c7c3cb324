//! Pages of a column: where their bytes come from, and those in Zstandard decompressed in Rust.

use crate::recording::read_at::{At, ReadAt};
use bytes::Bytes;
use parquet::basic::{Compression, Encoding};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::{ParquetError, Result as Outcome};
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

/// A page is never larger, bytes.
const LARGEST_PAGE: u64 = 1 << 30;

/// The reader of a column of a row group.
pub(super) fn reader(
    source: &Arc<Source>,
    metadata: &ParquetMetaData,
    group: usize,
    column: usize,
) -> Outcome<ColumnReader> {
    let group = metadata.row_group(group);
    let chunk = group.column(column);
    let is_zstd = matches!(chunk.compression(), Compression::ZSTD(_));
    // The pages come as they are, and are decompressed here.
    let plain = if is_zstd {
        Some(chunk.clone().into_builder().set_compression(Compression::UNCOMPRESSED).build())
    } else {
        None
    };
    let plain = plain.transpose()?;
    let rows = usize::try_from(group.num_rows())?;
    let pages =
        SerializedPageReader::new(Arc::clone(source), plain.as_ref().unwrap_or(chunk), rows, None)?;
    let most = u64::try_from(chunk.uncompressed_size())?.min(LARGEST_PAGE);
    let pages = Pages { inner: Box::new(pages), is_zstd, most, has_dictionary: false };
    Ok(get_column_reader(chunk.column_descr_ptr(), Box::new(pages)))
}

/// Pages, those in Zstandard decompressed in Rust.
struct Pages {
    inner: Box<dyn PageReader>,
    is_zstd: bool,
    /// Most bytes of a page: those of the whole column by the footer.
    most: u64,
    has_dictionary: bool,
}

impl Pages {
    /// Refuses a page whose dictionary is not there, at which the library panics.
    fn check(&mut self, page: &Page) -> Outcome<()> {
        let of_dictionary = [Encoding::RLE_DICTIONARY, Encoding::PLAIN_DICTIONARY];
        match page {
            Page::DictionaryPage { .. } => self.has_dictionary = true,
            _ if of_dictionary.contains(&page.encoding()) && !self.has_dictionary => {
                return Err(ParquetError::General("a page without its dictionary".into()));
            }
            _ => {}
        }
        Ok(())
    }

    fn decompressed(page: Page, most: u64) -> Outcome<Page> {
        let text = |buffer: &[u8], plain: usize| -> Outcome<Bytes> {
            let failed = |e: String| ParquetError::General(format!("Zstandard: {e}"));
            let plain =
                buffer.get(..plain).ok_or_else(|| failed("levels beyond the page".into()))?;
            let mut all = plain.to_vec();
            let rest = &buffer[plain.len()..];
            if !rest.is_empty() {
                let decoder = ruzstd::decoding::StreamingDecoder::new(rest);
                let decoder = decoder.map_err(|e| failed(e.to_string()))?;
                let read = decoder.take(most + 1).read_to_end(&mut all);
                let length = read.map_err(|e| failed(e.to_string()))? as u64;
                if length > most {
                    return Err(failed(format!("a page of more than {most} bytes")));
                }
            }
            Ok(all.into())
        };
        Ok(match page {
            Page::DataPage {
                buf,
                num_values,
                encoding,
                def_level_encoding,
                rep_level_encoding,
                statistics,
            } => Page::DataPage {
                buf: text(&buf, 0)?,
                num_values,
                encoding,
                def_level_encoding,
                rep_level_encoding,
                statistics,
            },
            Page::DictionaryPage { buf, num_values, encoding, is_sorted } => {
                Page::DictionaryPage { buf: text(&buf, 0)?, num_values, encoding, is_sorted }
            }
            Page::DataPageV2 {
                buf,
                num_values,
                encoding,
                num_nulls,
                num_rows,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                statistics,
            } => {
                let levels = def_levels_byte_len as usize + rep_levels_byte_len as usize;
                let buf = if is_compressed { text(&buf, levels)? } else { buf };
                Page::DataPageV2 {
                    buf,
                    num_values,
                    encoding,
                    num_nulls,
                    num_rows,
                    def_levels_byte_len,
                    rep_levels_byte_len,
                    is_compressed: false,
                    statistics,
                }
            }
        })
    }
}

impl Iterator for Pages {
    type Item = Outcome<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Outcome<Option<Page>> {
        let Some(page) = self.inner.get_next_page()? else { return Ok(None) };
        self.check(&page)?;
        Ok(Some(if self.is_zstd { Self::decompressed(page, self.most)? } else { page }))
    }

    fn peek_next_page(&mut self) -> Outcome<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Outcome<()> {
        self.inner.skip_next_page()
    }
}

/// Our bytes as the library reads them.
#[derive(Clone)]
pub(super) struct Source {
    pub(super) bytes: Arc<dyn ReadAt>,
    pub(super) size: u64,
}

impl Length for Source {
    fn len(&self) -> u64 {
        self.size
    }
}

impl ChunkReader for Source {
    type T = std::io::BufReader<At>;

    fn get_read(&self, start: u64) -> Outcome<Self::T> {
        let mut at = At::new(Arc::clone(&self.bytes));
        at.seek(SeekFrom::Start(start))?;
        Ok(std::io::BufReader::new(at))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Outcome<Bytes> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.size) {
            let problem = format!("{length} bytes at byte {start} are beyond the end of the file");
            return Err(ParquetError::EOF(problem));
        }
        let mut buffer = vec![0; length];
        let mut at = At::new(Arc::clone(&self.bytes));
        at.seek(SeekFrom::Start(start))?;
        at.read_exact(&mut buffer)?;
        Ok(buffer.into())
    }
}
