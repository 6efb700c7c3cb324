//! The corpora, and every input that a fault was found with, through their targets.

use std::path::Path;

#[test]
fn every_input_of_the_corpora_returns() {
    for (name, target) in steerwright_fuzzing::TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        let mut files: Vec<_> =
            std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(files.len() >= 10, "the corpus of {name} has {} files", files.len());
        for file in &files {
            // Named, so that a failure identifies it.
            println!("{}", file.display());
            target(&std::fs::read(file).unwrap());
        }
    }
}
