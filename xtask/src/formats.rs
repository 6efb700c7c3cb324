//! The book's page on the JSON files, from the types of the crate `formats`: keys, types, descriptions.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use syn::{Attribute, Expr, Fields, Item, Lit, Meta, Type};

/// The documents that are no models, each with its type and its usual file name.
const OTHERS: [(&str, &str); 7] = [
    ("Pid", "pid.json"),
    ("SpeedController", "speed_controller.json"),
    ("Path", "path.json"),
    ("Manoeuvre", "excitation.json"),
    ("Estimator", "estimator.json"),
    ("Start", "start.json"),
    ("AccumulatedDrives", "*.rfactor"),
];

const INTRODUCTION: &str = "\
<!-- Generated from the crate `formats` by `cargo xtask docs --update`. -->

# File formats

Every file is one JSON object with its schema and version in `schema`. Unknown versions, unknown keys, wrong
shapes and numbers that are not finite are refused with the JSON path of the fault. Units are in the names of
the keys or in the descriptions; angles are in rad, signs follow ISO 8855. A key marked *optional* may be absent.
";

/// A type with what its source states about it.
pub(crate) struct Described {
    pub(crate) text: String,
    /// Key, type, description.
    pub(crate) rows: Vec<(String, String, String)>,
    refers_to: Vec<String>,
    pub(crate) is_struct: bool,
}

/// The documents, each with its type and its usual file name: the models, which the variants of `Model` name, and the others.
fn documents(types: &BTreeMap<String, Described>) -> Result<Vec<(String, String)>, String> {
    let models = types.get("Model").ok_or("formats has no type `Model`")?;
    let mut documents = Vec::new();
    for (name, (.., description)) in models.refers_to.iter().zip(&models.rows) {
        let file = description.split(':').next().unwrap_or_default();
        documents.push((name.clone(), file.trim_end_matches('.').replace('`', "")));
    }
    documents.extend(OTHERS.map(|(name, file)| (name.to_owned(), file.to_owned())));
    Ok(documents)
}

/// The types of the documents and of their parts by name, each after those that refer to it; `sources` is the folder of
/// the crate `formats`.
pub(crate) fn types(sources: &Path) -> Result<Vec<(String, Described)>, String> {
    let mut types = BTreeMap::new();
    read(sources, &mut types)?;
    let mut next: VecDeque<String> = documents(&types)?.into_iter().map(|(name, _)| name).collect();
    let mut found = Vec::new();
    while let Some(name) = next.pop_front() {
        if let Some(described) = types.remove(&name) {
            next.extend(described.refers_to.iter().cloned());
            found.push((name, described));
        }
    }
    Ok(found)
}

/// The page as Markdown.
pub(crate) fn page(sources: &Path) -> Result<String, String> {
    let mut types = BTreeMap::new();
    read(sources, &mut types)?;
    let mut page = INTRODUCTION.to_owned();
    let mut written = BTreeSet::new();
    let documents = documents(&types)?;
    for (name, file) in &documents {
        let document = types.get(name).ok_or(format!("formats has no type `{name}`"))?;
        let _ = write!(
            page,
            "\n## {file}\n\n{}\n\n{}",
            document.text,
            table(document, &types, &documents)
        );
        written.insert(name.to_owned());
        let mut next: VecDeque<String> = document.refers_to.iter().cloned().collect();
        while let Some(name) = next.pop_front() {
            let Some(part) = types.get(&name) else { continue };
            if !written.insert(name.clone()) {
                continue;
            }
            let _ = write!(
                page,
                "\n### {name}\n\n{}\n\n{}",
                part.text,
                table(part, &types, &documents)
            );
            next.extend(part.refers_to.iter().cloned());
        }
    }
    Ok(page)
}

fn table(
    of: &Described,
    types: &BTreeMap<String, Described>,
    documents: &[(String, String)],
) -> String {
    let heading =
        if of.is_struct { "| key | type | |\n|---|---|---|\n" } else { "| value | |\n|---|---|\n" };
    let mut text = heading.to_owned();
    for (key, kind, description) in &of.rows {
        let _ = if of.is_struct {
            writeln!(text, "| `{key}` | {} | {description} |", linked(kind, types, documents))
        } else {
            writeln!(text, "| `{key}` | {description} |")
        };
    }
    text
}

/// The type in words, with links to the types of this page.
fn linked(
    kind: &str,
    types: &BTreeMap<String, Described>,
    documents: &[(String, String)],
) -> String {
    let words = kind.split(' ').map(|word| {
        let name = word.trim_end_matches(',');
        if types.contains_key(name) && documents.iter().all(|(document, _)| document != name) {
            word.replace(name, &format!("[{name}](#{})", name.to_lowercase()))
        } else {
            word.to_owned()
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

fn read(folder: &Path, types: &mut BTreeMap<String, Described>) -> Result<(), String> {
    let problem = |e: &dyn std::fmt::Display| format!("{}: {e}", folder.display());
    for entry in fs::read_dir(folder).map_err(|e| problem(&e))? {
        let path = entry.map_err(|e| problem(&e))?.path();
        if path.is_dir() {
            read(&path, types)?;
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = fs::read_to_string(&path).map_err(|e| problem(&e))?;
            let file = syn::parse_file(&text).map_err(|e| format!("{}: {e}", path.display()))?;
            types.extend(file.items.iter().filter_map(described));
        }
    }
    Ok(())
}

fn described(item: &Item) -> Option<(String, Described)> {
    let (name, attributes, rows, refers_to, is_struct) = match item {
        Item::Struct(of) => {
            let Fields::Named(fields) = &of.fields else { return None };
            let mut refers_to = Vec::new();
            let row = |field: &syn::Field| {
                let name = field.ident.as_ref()?.to_string();
                let key = serde(&field.attrs, "rename").unwrap_or(name);
                let mut kind = in_words(&field.ty, &mut refers_to);
                if is_optional(&field.attrs) && !kind.ends_with("optional") {
                    kind += ", optional";
                }
                Some((key, kind, doc(&field.attrs)))
            };
            let rows = fields.named.iter().filter_map(row).collect();
            (of.ident.to_string(), &of.attrs, rows, refers_to, true)
        }
        Item::Enum(of) => {
            let case = serde(&of.attrs, "rename_all");
            let mut refers_to = Vec::new();
            let row = |variant: &syn::Variant| {
                for field in &variant.fields {
                    in_words(&field.ty, &mut refers_to);
                }
                let name = variant.ident.to_string();
                let renamed = serde(&variant.attrs, "rename");
                let name = renamed.unwrap_or_else(|| cased(&name, case.as_deref()));
                (name, String::new(), doc(&variant.attrs))
            };
            let rows = of.variants.iter().map(row).collect();
            (of.ident.to_string(), &of.attrs, rows, refers_to, false)
        }
        _ => return None,
    };
    let text = doc(attributes).replace("[`", "`").replace("`]", "`");
    Some((name, Described { text, rows, refers_to, is_struct }))
}

fn cased(name: &str, case: Option<&str>) -> String {
    let separator = match case {
        Some("kebab-case") => '-',
        Some("snake_case") => '_',
        Some("lowercase") => return name.to_lowercase(),
        _ => return name.to_owned(),
    };
    let mut text = String::new();
    for (at, letter) in name.char_indices() {
        if letter.is_uppercase() && at > 0 {
            text.push(separator);
        }
        text.extend(letter.to_lowercase());
    }
    text
}

fn in_words(kind: &Type, refers_to: &mut Vec<String>) -> String {
    match kind {
        Type::Array(array) => format!("list of {}", in_words(&array.elem, refers_to)),
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else { return String::new() };
            let inner = match &last.arguments {
                syn::PathArguments::AngleBracketed(of) => of.args.iter().find_map(|a| match a {
                    syn::GenericArgument::Type(inner) => Some(in_words(inner, refers_to)),
                    _ => None,
                }),
                _ => None,
            };
            let name = last.ident.to_string();
            match (name.as_str(), inner) {
                ("Option", Some(inner)) => format!("{inner}, optional"),
                ("Box", Some(inner)) => inner,
                ("Vec", Some(inner)) => format!("list of {inner}"),
                ("f64", _) => "number".into(),
                ("usize" | "u64" | "u32" | "i64", _) => "integer".into(),
                ("bool", _) => "true or false".into(),
                ("String", _) => "text".into(),
                ("Matrix", _) => "matrix (list of rows)".into(),
                _ => {
                    refers_to.push(name.clone());
                    name
                }
            }
        }
        _ => String::new(),
    }
}

/// The documentation comment as one paragraph that fits a table cell.
fn doc(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Str(text) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    let text = lines.collect::<Vec<_>>().join(" ");
    text.replace("[`", "`").replace("`]", "`").replace('|', "\\|").trim().to_owned()
}

/// The text of a key of `#[serde(…)]`.
fn serde(attributes: &[Attribute], key: &str) -> Option<String> {
    let mut found = None;
    for attribute in attributes.iter().filter(|a| a.path().is_ident("serde")) {
        let _ = attribute.parse_nested_meta(|meta| {
            let is_it = meta.path.is_ident(key);
            if let Ok(value) = meta.value() {
                let literal: Lit = value.parse()?;
                if let (true, Lit::Str(text)) = (is_it, literal) {
                    found = Some(text.value());
                }
            }
            Ok(())
        });
    }
    found
}

fn is_optional(attributes: &[Attribute]) -> bool {
    let mut found = false;
    for attribute in attributes.iter().filter(|a| a.path().is_ident("serde")) {
        let _ = attribute.parse_nested_meta(|meta| {
            found |= meta.path.is_ident("default");
            if let Ok(value) = meta.value() {
                let _: Lit = value.parse()?;
            }
            Ok(())
        });
    }
    found
}
