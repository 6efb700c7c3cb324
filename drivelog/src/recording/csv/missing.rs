//! Missing values as tools write them.

/// Words of R, pandas, SQL, Python, C and of tables, in small letters; a sign without a number.
const WORDS: [&str; 16] = [
    "na", "n/a", "n.a.", "nan", "null", "nil", "none", "-", "--", "---", "?", "%", "inf",
    "infinity", "missing", "<na>",
];
/// What spreadsheets show in place of a number, in English and German.
const SPREADSHEET: [&str; 11] = [
    "#n/a", "#nv", "#na", "#div/0!", "#value!", "#wert!", "#num!", "#zahl!", "#ref!", "#bezug!",
    "#null!",
];

/// Whether the cell, without blanks around it, is a missing value.
pub(in crate::recording) fn is_missing(cell: &str) -> bool {
    // No other marker is longer, and most cells are numbers.
    if cell.is_empty() {
        return true;
    }
    if cell.len() > 16 {
        return false;
    }
    let is = |word: &&str| cell.eq_ignore_ascii_case(word);
    let unsigned = cell.strip_prefix(['-', '+']).unwrap_or(cell);
    // `-nan(ind)` and `1.#QNAN0` of Microsoft's C library, also with a decimal comma.
    let begins =
        |text: &str| unsigned.get(..text.len()).is_some_and(|s| s.eq_ignore_ascii_case(text));
    WORDS.iter().any(is)
        || ["nan", "inf", "infinity"].iter().any(|word| unsigned.eq_ignore_ascii_case(word))
        || ["nan(", "1.#", "1,#"].into_iter().any(begins)
        || is_spreadsheet_error(cell.as_bytes())
}

/// Whether the cell is an error of a spreadsheet, which looks like a comment.
pub(super) fn is_spreadsheet_error(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    let cell = cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\"")).unwrap_or(cell);
    cell.first() == Some(&b'#')
        && SPREADSHEET.iter().any(|word| cell.eq_ignore_ascii_case(word.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_of_tools() {
        for cell in [
            "",
            "NA",
            "N/A",
            "NaN",
            "-nan",
            "-nan(ind)",
            "NAN(SNAN)",
            "1.#QNAN",
            "-1.#IND00",
            "1,#INF",
            "None",
            "null",
            "-",
            "--",
            "?",
            "inf",
            "-Inf",
            "#N/A",
            "#NV",
            "#DIV/0!",
            "#WERT!",
        ] {
            assert!(is_missing(cell), "{cell}");
        }
        for cell in ["0", "1.0", "-1", "nano", "abc", "#", "#1", "1.5", "info", "none of them"] {
            assert!(!is_missing(cell), "{cell}");
        }
    }
}
