//! What the schema of Arrow, which writers keep beside that of Parquet, has beyond it: durations.

use std::collections::BTreeMap;

/// Code of a duration among the types of Arrow.
const DURATION: u8 = 18;
/// More columns are not looked at.
const MOST: usize = 1 << 16;

/// The columns that are durations, and how many of their unit a second has.
pub(super) fn durations(schema: &str) -> BTreeMap<String, f64> {
    fields(&base64(schema)).unwrap_or_default()
}

fn fields(bytes: &[u8]) -> Option<BTreeMap<String, f64>> {
    // A mark and the length of the message stand before it; of older writers the length alone.
    let start = if bytes.starts_with(&[0xFF; 4]) { 8 } else { 4 };
    let message = Table::of(bytes.get(start..)?, 0)?;
    let schema = message.table(2)?;
    let list = schema.reference(1)?;
    let count = usize::try_from(schema.u32(list)?).ok()?.min(MOST);
    let mut all = BTreeMap::new();
    for k in 0..count {
        let field = Table::of(schema.bytes, list + 4 + 4 * k)?;
        if field.byte(2) != Some(DURATION) {
            continue;
        }
        // Milliseconds are the default, which is not written.
        let unit = field.table(3)?.byte(0).unwrap_or(1);
        let name = field.reference(0)?;
        let length = usize::try_from(field.u32(name)?).ok()?;
        let name = field.bytes.get(name + 4..)?.get(..length)?;
        all.insert(String::from_utf8_lossy(name).into_owned(), 1e3_f64.powi(unit.into()));
    }
    Some(all)
}

/// A table of a flatbuffer.
struct Table<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Table<'b> {
    /// The table that the offset at a place leads to.
    fn of(bytes: &'b [u8], place: usize) -> Option<Self> {
        let here = Self { bytes, at: 0 };
        Some(Self { bytes, at: place.checked_add(here.u32(place)? as usize)? })
    }

    fn u32(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }

    fn u16(&self, at: usize) -> Option<usize> {
        let bytes = self.bytes.get(at..at.checked_add(2)?)?;
        Some(u16::from_le_bytes(bytes.try_into().ok()?).into())
    }

    /// The place of a field; `None` where it is not written.
    fn place(&self, field: usize) -> Option<usize> {
        let offset = self.u32(self.at)? as i32;
        let layout = usize::try_from(i64::try_from(self.at).ok()? - i64::from(offset)).ok()?;
        let entry = 4 + 2 * field;
        let is_there = entry + 2 <= self.u16(layout)?;
        let own = is_there.then(|| self.u16(layout + entry))??;
        (own > 0).then_some(self.at + own)
    }

    fn byte(&self, field: usize) -> Option<u8> {
        self.bytes.get(self.place(field)?).copied()
    }

    /// Where a text or a list begins.
    fn reference(&self, field: usize) -> Option<usize> {
        let place = self.place(field)?;
        place.checked_add(self.u32(place)? as usize)
    }

    fn table(&self, field: usize) -> Option<Self> {
        Self::of(self.bytes, self.place(field)?)
    }
}

fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |c| DIGITS.iter().position(|own| *own == c).map(|d| d as u32);
    let digits: Vec<u32> = text.bytes().map_while(digit).collect();
    let number = |four: &[u32]| (0..4).fold(0, |n, k| n << 6 | four.get(k).copied().unwrap_or(0));
    let bytes = digits.chunks(4).flat_map(|four| {
        let [_, bytes @ ..] = number(four).to_be_bytes();
        bytes.into_iter().take(four.len() - 1)
    });
    bytes.collect()
}
