//! Pieces of a study's results: consecutive runs in a file of their own, which any machine may make, in any order
//! and more than once.
//!
//! A piece has the header and the rows that the whole results have, under a name that states its runs and the hash
//! of study, FMUs and program; it appears whole or not at all. Merged, the pieces are the bytes of one run of all.

use crate::Error;
use crate::make::Options;
use crate::metric::Outcome;
use crate::prepare::Sweep;
use crate::results::{Results, read, remove_left};
use crate::run::Finished;
use crate::summary::Summary;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What a call for a piece did.
#[derive(Debug)]
pub struct SweepPiece {
    /// The file; none for a piece without runs.
    pub file: Option<PathBuf>,
    /// The runs of the piece.
    pub runs: Range<usize>,
    /// Whether the whole piece was there before.
    pub was_there: bool,
    /// What the runs made, unless the piece was there or is empty. Where rows are missing, there is no file.
    pub finished: Option<Finished>,
}

/// The end of the name of a piece that is being made here: locks need not hold between machines that share a folder.
fn part_ending() -> String {
    let linux = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let machine = linux.or_else(|| std::env::var("COMPUTERNAME").ok()).unwrap_or_default();
    format!("{}.part", machine.trim())
}

/// Removes what killed processes of this machine left unfinished.
fn remove_left_parts(folder: &Path) {
    let ending = format!(".{}", part_ending());
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_part =
            name.to_str().is_some_and(|n| n.starts_with(".runs-") && n.ends_with(&ending));
        if is_part && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            remove_left(&entry.path());
        }
    }
}

/// A file of rows, and the runs that they are of.
struct Held<'a> {
    path: &'a Path,
    runs: Range<usize>,
    outcomes: Vec<Outcome>,
}

impl Sweep {
    /// The runs of a shard, counted from 0: consecutive, and as many as in the others or one less.
    #[must_use]
    pub fn shard(&self, index: usize, of: usize) -> Range<usize> {
        let bound =
            |shard: usize| (self.runs() as u128 * shard as u128 / of.max(1) as u128) as usize;
        bound(index)..bound(index + 1)
    }

    /// The name of the file that holds these runs.
    #[must_use]
    pub fn piece_name(&self, runs: &Range<usize>) -> String {
        let width = self.runs().to_string().len();
        format!(
            "runs-{:0width$}-{:0width$}-{}.csv",
            runs.start,
            runs.end.saturating_sub(1),
            self.id
        )
    }

    /// Makes a shard of the study in a folder, unless the whole piece is there. `options` are those of the runs;
    /// their results and range are the piece's.
    ///
    /// # Errors
    /// As [`Sweep::run`].
    pub fn piece(
        &self,
        folder: &Path,
        (index, of): (usize, usize),
        options: &Options<'_>,
    ) -> Result<SweepPiece, Error> {
        let runs = self.shard(index, of);
        if runs.is_empty() {
            return Ok(SweepPiece { file: None, runs, was_there: false, finished: None });
        }
        let name = self.piece_name(&runs);
        let path = folder.join(&name);
        let io = |source| Error::Io { path: path.clone(), source };
        if let Ok(file) = File::open(&path)
            && read(self, runs.start, file, &path).is_ok_and(|(rows, ..)| rows.len() == runs.len())
        {
            return Ok(SweepPiece { file: Some(path), runs, was_there: true, finished: None });
        }
        fs::create_dir_all(folder).map_err(io)?;
        remove_left_parts(folder);
        // Of this process alone: another one may make the same piece.
        let part = folder.join(format!(".{name}.{}.{}", std::process::id(), part_ending()));
        let finished = self.run(&Options {
            results: &part,
            runs: Some(runs.clone()),
            resume: false,
            overwrite: true,
            trajectories: options.trajectories.clone(),
            ..*options
        });
        let is_whole = finished.as_ref().is_ok_and(|finished| finished.rows == runs.len());
        let kept = if is_whole { fs::rename(&part, &path) } else { fs::remove_file(&part) };
        let finished = finished?;
        kept.map_err(io)?;
        Ok(SweepPiece {
            file: if is_whole { Some(path) } else { None },
            runs,
            was_there: false,
            finished: Some(finished),
        })
    }

    /// Merges pieces, in any order, to the results of the whole study.
    ///
    /// # Errors
    /// [`Error::Piece`] for a file that is no piece of this study, [`Error::Missing`] and [`Error::Twice`] for runs
    /// that no file or two files have; nothing is written then.
    pub fn merge(
        &self,
        pieces: &[PathBuf],
        out: &Path,
        overwrite: bool,
    ) -> Result<Finished, Error> {
        let mut held = pieces.iter().map(|path| self.held(path)).collect::<Result<Vec<_>, _>>()?;
        held.sort_by_key(|piece| piece.runs.start);
        let mut next = 0;
        for (k, piece) in held.iter().enumerate() {
            let Range { start, end } = piece.runs;
            if start > next {
                return Err(self.missing(next..start));
            }
            if start < next {
                let (first, second) = (held[k - 1].path.into(), piece.path.into());
                return Err(Error::Twice { first, second, from: start, to: next.min(end) - 1 });
            }
            next = end;
        }
        if next < self.runs() {
            return Err(self.missing(next..self.runs()));
        }
        let mut results = Results::create(self, out, overwrite)?;
        for piece in &held {
            let bytes = fs::read(piece.path)
                .map_err(|source| Error::Io { path: piece.path.into(), source })?;
            let rows = bytes.iter().position(|b| *b == b'\n').map_or(bytes.len(), |at| at + 1);
            results.append(&bytes[rows..])?;
        }
        results.finish()?;
        let outcomes: Vec<Outcome> = held.into_iter().flat_map(|piece| piece.outcomes).collect();
        let summary = Summary::new(self, 0, &outcomes);
        Ok(Finished { resumed: 0, rows: outcomes.len(), threads: 1, fatal: None, summary })
    }

    fn missing(&self, runs: Range<usize>) -> Error {
        Error::Missing { from: runs.start, to: runs.end - 1, runs: self.runs() }
    }

    /// The rows of a piece, all of this study and in order.
    fn held<'a>(&self, path: &'a Path) -> Result<Held<'a>, Error> {
        let io = |source| Error::Io { path: path.into(), source };
        let no = |problem: String| Error::Piece { path: path.into(), problem };
        let mut lines = BufReader::new(File::open(path).map_err(io)?).lines();
        let first = match (lines.next(), lines.next()) {
            (Some(_), Some(line)) => line.map_err(io)?,
            _ => return Err(no("it has no rows".into())),
        };
        let run = first.split(',').next().and_then(|run| run.parse().ok());
        let run = run.ok_or_else(|| no("its first row has no number of a run".into()))?;
        let file = File::open(path).map_err(io)?;
        let (outcomes, ..) = read(self, run, file, path).map_err(|error| match error {
            Error::Resume { problem, .. } => no(problem),
            error => error,
        })?;
        Ok(Held { path, runs: run..run + outcomes.len(), outcomes })
    }
}
