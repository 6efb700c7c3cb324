//! The modules of a crate import each other in one direction: their `use` items form no circle.

use cargo_metadata::MetadataCommand;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The path of a module inside its crate; that of the root is empty.
pub(crate) type Module = Vec<String>;

#[derive(Default)]
struct Imports {
    /// Paths from the root of the crate.
    used: Vec<Module>,
    /// Names that a module re-exports, and where they are.
    reexported: BTreeMap<String, Module>,
}

/// The files below a folder of sources, tests apart, by module.
fn read(folder: &Path, module: &Module, texts: &mut BTreeMap<Module, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let mut own = module.clone();
        match path.file_stem().and_then(|name| name.to_str()).unwrap() {
            "tests" => continue,
            "lib" | "main" | "mod" => {}
            name => own.push(name.into()),
        }
        if path.is_dir() {
            read(&path, &own, texts);
        } else if path.extension().is_some_and(|end| end == "rs") {
            *texts.entry(own).or_default() += &std::fs::read_to_string(path).unwrap();
        }
    }
}

/// The paths of a tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn paths(tree: &str) -> Vec<String> {
    let Some((start, rest)) = tree.split_once('{') else { return vec![tree.into()] };
    let mut depth = 0;
    let branches = rest[..rest.rfind('}').unwrap()].split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let branches = branches.filter(|branch| !branch.is_empty());
    branches.flat_map(|branch| paths(&format!("{start}{branch}"))).collect()
}

/// The path from the root of the crate; `None` for another crate.
fn from_root(path: &str, module: &Module, texts: &BTreeMap<Module, String>) -> Option<Module> {
    let mut from = module.clone();
    let mut parts = path.split("::").peekable();
    match *parts.peek()? {
        "crate" => from.clear(),
        "self" => {}
        "super" => {
            while parts.next_if_eq(&"super").is_some() {
                from.pop();
            }
        }
        child => {
            from.push(child.into());
            texts.get(&from)?;
            parts.next();
        }
    }
    from.extend(parts.filter(|part| !["crate", "self"].contains(part)).map(String::from));
    Some(from)
}

/// What the `use` items of a module import and re-export.
fn imports(module: &Module, texts: &BTreeMap<Module, String>) -> Imports {
    let code = texts[module].split("\nmod tests {").next().unwrap();
    let mut found = Imports::default();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].rsplit('\n').next().unwrap().trim();
        let is_reexport = before.starts_with("pub");
        if !before.is_empty() && before != "pub" && !(is_reexport && before.ends_with(')')) {
            continue;
        }
        let tree = code[at + 4..].split(';').next().unwrap().replace(" as ", "@");
        for path in paths(&tree.split_whitespace().collect::<String>()) {
            let (path, alias) = path.split_once('@').unwrap_or((&path, ""));
            let Some(path) = from_root(path, module, texts) else { continue };
            match path.last() {
                Some(name) if is_reexport => {
                    let name = if alias.is_empty() { name } else { alias };
                    found.reexported.insert(name.to_string(), path);
                }
                _ => found.used.push(path),
            }
        }
    }
    found
}

/// The module that an imported item is in, past re-exports.
fn module_of(mut path: Module, all: &BTreeMap<Module, Imports>) -> Module {
    loop {
        let depth = (0..=path.len()).rev().find(|depth| all.contains_key(&path[..*depth])).unwrap();
        let Some(name) = path.get(depth) else { return path };
        match all[&path[..depth]].reexported.get(name) {
            Some(target) if *target != path => {
                path = [target.as_slice(), &path[depth + 1..]].concat();
            }
            _ => return path[..depth].to_vec(),
        }
    }
}

/// The modules that a module imports, and those that these import, and so on.
fn reached<'a>(
    module: &'a Module,
    imports: &'a BTreeMap<Module, BTreeSet<Module>>,
) -> BTreeSet<&'a Module> {
    let (mut found, mut open) = (BTreeSet::new(), vec![module]);
    while let Some(next) = open.pop() {
        open.extend(imports[next].iter().filter(|used| found.insert(*used)));
    }
    found
}

/// The imports that are part of a circle, as text.
fn circles(texts: &BTreeMap<Module, String>) -> Vec<String> {
    let all: BTreeMap<Module, Imports> =
        texts.keys().map(|module| (module.clone(), imports(module, texts))).collect();
    let mut direct = BTreeMap::new();
    for (module, imports) in &all {
        let used = imports.used.iter().map(|path| module_of(path.clone(), &all));
        let used: BTreeSet<Module> = used.filter(|used| used != module).collect();
        direct.insert(module.clone(), used);
    }
    let mut found = Vec::new();
    for (module, used) in &direct {
        for used in used.iter().filter(|used| reached(used, &direct).contains(module)) {
            let [module, used] = [module, used].map(|m| format!("crate::{}", m.join("::")));
            found.push(format!("{module} imports {used}"));
        }
    }
    found
}

/// The sources of the packages, by module.
pub(crate) fn sources() -> Vec<(String, BTreeMap<Module, String>)> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap();
    let mut found = Vec::new();
    for package in metadata.workspace_packages() {
        let folder = package.manifest_path.parent().unwrap().join("src");
        // A package of tests alone has none.
        if folder.is_dir() {
            let mut texts = BTreeMap::new();
            read(folder.as_std_path(), &Vec::new(), &mut texts);
            found.push((package.name.to_string(), texts));
        }
    }
    let files: usize = found.iter().map(|(_, texts)| texts.len()).sum();
    assert!(files > 400, "{files} files");
    found
}

#[test]
fn modules_form_no_circle() {
    let mut found = Vec::new();
    for (package, texts) in sources() {
        found.extend(circles(&texts).iter().map(|import| format!("{package}: {import}\n")));
    }
    assert!(found.is_empty(), "circles of modules:\n{}", found.concat());
}

#[test]
fn a_circle_is_found_past_re_exports() {
    let texts = [
        ("", "pub use a::Thing;\nmod a;\nmod b;\nmod c;\n"),
        ("a", "use crate::b::{\n    Other,\n    deep::Part,\n};\npub struct Thing;\n"),
        ("b", "use super::Thing;\npub struct Other;\n"),
        ("c", "use crate::Thing;\n/// use crate::c;\n"),
    ];
    let module =
        |name: &str| name.split("::").filter(|p| !p.is_empty()).map(String::from).collect();
    let texts = texts.map(|(name, text)| (module(name), text.to_string())).into();
    assert_eq!(circles(&texts), ["crate::a imports crate::b", "crate::b imports crate::a"]);
}
