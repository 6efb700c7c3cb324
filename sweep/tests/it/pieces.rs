//! Pieces of a study: the bytes of one run of all, whoever makes which piece when.

use crate::support::{How, folder, prepare, run, study};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use steerwright_sweep::{Error, Options, Sweep, SweepPiece};

const RUNS: usize = 23;

fn piece(sweep: &Sweep, folder: &Path, shard: (usize, usize)) -> SweepPiece {
    sweep.piece(folder, shard, &options(&AtomicBool::new(false))).unwrap()
}

fn options(stop: &AtomicBool) -> Options<'_> {
    Options {
        results: Path::new(""),
        runs: None,
        threads: Some(2),
        resume: false,
        overwrite: false,
        trajectories: None,
        isolate: None,
        timeout: None,
        hung: &|_, _| {},
        stop,
        progress: &|_| {},
    }
}

#[test]
fn pieces_in_any_order_are_the_bytes_of_one_run() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let folder = folder.path();
    let sweep = prepare(folder, &study(RUNS)).unwrap();
    let whole = folder.join("whole.csv");
    let finished = run(&sweep, &whole, How::default()).unwrap();
    for of in [1, 2, 7, 23, 40] {
        let pieces = folder.join(format!("of-{of}"));
        let mut files: Vec<PathBuf> =
            (0..of).rev().filter_map(|i| piece(&sweep, &pieces, (i, of)).file).collect();
        let middle = files.len() / 2;
        files.rotate_left(middle);
        let merged = folder.join(format!("merged-{of}.csv"));
        let again = sweep.merge(&files, &merged, false).unwrap();
        assert_eq!(std::fs::read(&merged).unwrap(), std::fs::read(&whole).unwrap(), "{of}");
        assert_eq!(again.summary, finished.summary);
        // Nothing but the pieces is left in their folder.
        assert_eq!(std::fs::read_dir(&pieces).unwrap().count(), files.len());
    }
}

#[test]
fn a_piece_that_is_there_is_not_made_again_and_a_cut_one_is() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let folder = folder.path();
    let sweep = prepare(folder, &study(RUNS)).unwrap();
    let pieces = folder.join("pieces");
    let first = piece(&sweep, &pieces, (1, 4));
    let file = first.file.unwrap();
    let bytes = std::fs::read(&file).unwrap();
    assert!(!first.was_there);
    assert!(piece(&sweep, &pieces, (1, 4)).was_there);
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    assert!(!piece(&sweep, &pieces, (1, 4)).was_there);
    assert_eq!(std::fs::read(&file).unwrap(), bytes);
    // One that is stopped leaves nothing.
    std::fs::remove_file(&file).unwrap();
    let stopped = sweep.piece(&pieces, (1, 4), &options(&AtomicBool::new(true))).unwrap();
    assert!(stopped.file.is_none());
    assert_eq!(std::fs::read_dir(&pieces).unwrap().count(), 0);
}

#[test]
fn gaps_repetitions_and_other_studies_are_refused() {
    let Some(folder) = folder(|_, xml| xml) else { return };
    let folder = folder.path();
    let sweep = prepare(folder, &study(RUNS)).unwrap();
    let made = |of: usize| -> Vec<PathBuf> {
        (0..of).filter_map(|i| piece(&sweep, &folder.join(of.to_string()), (i, of)).file).collect()
    };
    let (three, two) = (made(3), made(2));
    let out = folder.join("merged.csv");
    let refused = |files: &[PathBuf]| {
        let error = sweep.merge(files, &out, false).unwrap_err();
        assert!(!out.exists() && !error.hint().is_empty());
        error
    };
    let error = refused(&[three[0].clone(), three[2].clone()]);
    assert!(matches!(error, Error::Missing { from: 7, to: 14, runs: 23 }), "{error}");
    let error = refused(&three[..2]);
    assert!(matches!(error, Error::Missing { from: 15, to: 22, .. }), "{error}");
    let error = refused(&[three.clone(), vec![three[1].clone()]].concat());
    assert!(matches!(error, Error::Twice { from: 7, to: 14, .. }), "{error}");
    let error = refused(&[three[0].clone(), two[1].clone(), three[1].clone()]);
    assert!(matches!(error, Error::Twice { .. }), "{error}");

    let other = prepare(folder, &study(RUNS).replace("seed = 5", "seed = 4")).unwrap();
    let foreign = piece(&other, &folder.join("other"), (1, 3)).file.unwrap();
    let error = refused(&[three[0].clone(), foreign, three[2].clone()]);
    assert!(matches!(&error, Error::Piece { problem, .. } if problem.contains("study")), "{error}");
    let text = folder.join("text.csv");
    std::fs::write(&text, "run\n1,2\n").unwrap();
    let error = refused(&[text]);
    assert!(matches!(error, Error::Piece { .. }), "{error}");
}
