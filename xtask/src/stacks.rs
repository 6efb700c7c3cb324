//! The table of the driving stacks in the book, from the module page of each in the crate `stacks`.

use std::fs;
use std::path::Path;

const PAGE: &str = "docs/methods/export.md";

/// The marks around the table.
const TABLE: [&str; 2] = ["<!-- stacks:begin -->\n", "<!-- stacks:end -->"];

/// The page with the table of the stacks, one row of each module page that has one; `root` is the repository.
pub(crate) fn page(root: &Path) -> Result<(String, String), String> {
    let folder = root.join("stacks/src");
    let problem = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut files = Vec::new();
    for entry in fs::read_dir(&folder).map_err(problem)? {
        files.push(entry.map_err(problem)?.path());
    }
    files.sort();
    let mut table: Vec<String> = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        let lines = text.lines().map_while(|line| line.strip_prefix("//!"));
        let rows: Vec<&str> = lines.map(str::trim).filter(|line| line.starts_with('|')).collect();
        // The heading and the line below it are the same in each.
        let known = if table.is_empty() { 0 } else { 2 };
        table.extend(rows.into_iter().skip(known).map(str::to_owned));
    }
    let text = fs::read_to_string(root.join(PAGE)).map_err(|e| format!("{PAGE}: {e}"))?;
    let missing = || format!("{PAGE} has no table of the stacks");
    let (before, rest) = text.split_once(TABLE[0]).ok_or_else(missing)?;
    let (_, after) = rest.split_once(TABLE[1]).ok_or_else(missing)?;
    let table = table.join("\n");
    Ok((PAGE.into(), format!("{before}{}{table}\n{}{after}", TABLE[0], TABLE[1])))
}
