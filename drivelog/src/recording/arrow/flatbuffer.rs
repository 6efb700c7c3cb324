//! Tables of a flatbuffer, in which Arrow states its schemas and batches.

/// A table of a flatbuffer.
pub(super) struct Table<'b> {
    pub(super) bytes: &'b [u8],
    at: usize,
}

impl<'b> Table<'b> {
    /// The table that the offset at a place leads to.
    pub(super) fn of(bytes: &'b [u8], place: usize) -> Option<Self> {
        let here = Self { bytes, at: 0 };
        Some(Self { bytes, at: place.checked_add(here.u32(place)? as usize)? })
    }

    pub(super) fn u32(&self, at: usize) -> Option<u32> {
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

    pub(super) fn byte(&self, field: usize) -> Option<u8> {
        self.bytes.get(self.place(field)?).copied()
    }

    /// Where a text or a list begins.
    pub(super) fn reference(&self, field: usize) -> Option<usize> {
        let place = self.place(field)?;
        place.checked_add(self.u32(place)? as usize)
    }

    pub(super) fn table(&self, field: usize) -> Option<Self> {
        Self::of(self.bytes, self.place(field)?)
    }

    /// Whether the field is written.
    pub(super) fn has(&self, field: usize) -> bool {
        self.place(field).is_some()
    }

    /// A number of a field of so many bytes; 0 where it is not written.
    pub(super) fn number<const N: usize>(&self, field: usize) -> Option<i64> {
        let Some(at) = self.place(field) else { return Some(0) };
        integer(self.bytes.get(at..at.checked_add(N)?)?)
    }

    /// The elements of a list, each of so many bytes.
    pub(super) fn list(&self, field: usize, size: usize) -> Option<Vec<&'b [u8]>> {
        let Some(at) = self.reference(field) else { return Some(Vec::new()) };
        let count = usize::try_from(self.u32(at)?).ok()?;
        let bytes = self.bytes.get(at + 4..)?.get(..count.checked_mul(size)?)?;
        Some(bytes.chunks_exact(size).collect())
    }

    /// The tables of a list.
    pub(super) fn tables(&self, field: usize) -> Option<Vec<Self>> {
        let Some(at) = self.reference(field) else { return Some(Vec::new()) };
        let count = usize::try_from(self.u32(at)?).ok()?;
        let is_within = count.checked_mul(4)? <= self.bytes.len();
        let of = |k| Table::of(self.bytes, at + 4 + 4 * k);
        is_within.then(|| (0..count).map(of).collect())?
    }

    pub(super) fn text(&self, field: usize) -> Option<String> {
        let at = self.reference(field)?;
        let length = usize::try_from(self.u32(at)?).ok()?;
        let text = self.bytes.get(at + 4..)?.get(..length)?;
        Some(String::from_utf8_lossy(text).into_owned())
    }
}

/// A signed integer, the low byte first.
pub(super) fn integer(bytes: &[u8]) -> Option<i64> {
    let sign = if bytes.last()? & 0x80 == 0 { 0 } else { 0xFF };
    let mut all = [sign; 8];
    all.get_mut(..bytes.len())?.copy_from_slice(bytes);
    Some(i64::from_le_bytes(all))
}
