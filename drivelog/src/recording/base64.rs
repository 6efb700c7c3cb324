//! Base64, in which Parquet keeps the schema of Arrow and python-can the bytes of a frame.

/// The bytes up to the first character that is none.
pub(super) fn base64(text: &str) -> Vec<u8> {
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
