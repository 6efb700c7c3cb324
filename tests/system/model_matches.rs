//! What a crate does for each structure of a model is one `match`, in a file of its own.

use crate::circles::{Module, sources};
use std::collections::BTreeSet;
use syn::visit::{self, Visit};
use syn::{ItemMod, Macro, PatTupleStruct, Path};

/// Files that match on the variants without the name `model.rs`, each with its reason.
const EXCEPTIONS: [(&str, &str); 2] = [
    // It presents what was identified; there is no other use of the structures in `identify`.
    ("steerwright", "commands::identify::present"),
    // `control` makes a bicycle of a vehicle and `stacks` does not depend on it; a torque has options of its own.
    ("steerwright", "commands::export"),
];

/// Whether a pattern has a variant of the enumeration `Model` of `formats`, the only one of this name.
#[derive(Default)]
struct Search {
    is_found: bool,
}

impl Search {
    fn finds(code: &str) -> bool {
        // Files of one module are joined: their pages and inner attributes stand in the middle.
        let is_code = |line: &&str| !line.starts_with("//!") && !line.starts_with("#![");
        let code: Vec<&str> = code.lines().filter(is_code).collect();
        let mut search = Self::default();
        search.visit_file(&syn::parse_file(&code.join("\n")).unwrap());
        search.is_found
    }
}

impl<'ast> Visit<'ast> for Search {
    fn visit_pat_tuple_struct(&mut self, pattern: &'ast PatTupleStruct) {
        self.is_found |= is_variant(&pattern.path);
        visit::visit_pat_tuple_struct(self, pattern);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        if call.path.is_ident("matches") {
            let text = call.tokens.to_string();
            let words: Vec<&str> = text.split_whitespace().collect();
            let is_pattern = |w: &[&str]| *w == ["Model", "::"];
            self.is_found |= words.windows(2).any(is_pattern);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast ItemMod) {
        if module.ident != "tests" {
            visit::visit_item_mod(self, module);
        }
    }
}

fn is_variant(path: &Path) -> bool {
    let names: Vec<String> = path.segments.iter().map(|part| part.ident.to_string()).collect();
    match &names[..] {
        [.., of, _] => of == "Model",
        _ => false,
    }
}

#[test]
fn a_crate_matches_on_the_structures_of_a_model_in_one_file() {
    let mut found = BTreeSet::new();
    for (package, texts) in sources() {
        let is_matching = |text: &str| text.contains("Model::") && Search::finds(text);
        let own: Vec<&Module> =
            texts.iter().filter(|(_, text)| is_matching(text)).map(|(module, _)| module).collect();
        found.extend(own.iter().map(|module| (package.clone(), module.join("::"))));
    }
    for (package, module) in &found {
        let is_exception = EXCEPTIONS.contains(&(package.as_str(), module.as_str()));
        let is_model = module == "model" || module.ends_with("::model");
        assert!(
            is_model || is_exception,
            "{package}: {module} matches on the variants of `Model`: move it to the `model.rs` of the crate"
        );
        let models = found.iter().filter(|(of, m)| of == package && m.ends_with("model")).count();
        assert!(models <= 1, "{package} has {models} files `model.rs` with such matches");
    }
    for (package, module) in EXCEPTIONS {
        assert!(
            found.contains(&(package.into(), module.into())),
            "{package}: no match in {module}"
        );
    }
    assert!(found.contains(&("steerwright-control".into(), "model".into())), "{found:?}");
}

#[test]
fn a_match_is_found_in_every_form_and_a_constructor_is_none() {
    for code in [
        "fn f() { match m { Model::Bicycle(_) => 1, _ => 2 } }",
        "fn f() { if let Some(formats::Model::Torque(t)) = m {} }",
        "fn f() { let Model::StateSpace(p) = m else { return }; }",
        "fn f() -> bool { matches!(m, Model::SingleTrack(_)) }",
    ] {
        assert!(Search::finds(code), "{code}");
    }
    for code in [
        "fn f() { Model::Bicycle(Box::new(b)) }",
        "fn f() { match m { PlantModel::Bicycle(_) => 1, _ => 2 } }",
        "mod tests { fn f() { if let Model::Torque(t) = m {} } }",
    ] {
        assert!(!Search::finds(code), "{code}");
    }
}
