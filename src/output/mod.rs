//! The outputs of a command: checked before its work, written at its end, by the rules of
//! `docs/decisions/0037-outputs-never-replace-inputs.md`. [`Folder`] is the same for a folder of results.

mod folder;
mod identity;
mod kind;
mod lock;
mod manifest;
pub(crate) mod traces;

use crate::failure::Failure;
use crate::terminal::console;
use identity::{Identity, is_character_device, is_fifo, is_open_file, is_stdout};
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use steerwright_formats::{Document, Model};

use lock::Lock;

pub(crate) use folder::Folder;
pub(crate) use kind::OutputKind;

const FORCE: &str = "name another file, or add --force to write over this one";

/// The rules for all outputs of a command.
#[derive(Debug)]
struct Rules {
    force: bool,
    inputs: Vec<(Identity, PathBuf)>,
}

#[derive(Debug)]
pub(crate) struct Outputs {
    rules: Rc<Rules>,
    taken: Vec<Identity>,
}

impl Outputs {
    /// For a command that reads these files; `-` is standard input.
    pub(crate) fn new<P: AsRef<Path>>(force: bool, inputs: impl IntoIterator<Item = P>) -> Self {
        let inputs = inputs.into_iter().filter_map(|path| {
            let path = path.as_ref();
            Some((Identity::of_input(path)?, path.to_path_buf()))
        });
        Self { rules: Rc::new(Rules { force, inputs: inputs.collect() }), taken: Vec::new() }
    }

    pub(crate) fn file(
        &mut self,
        path: impl Into<PathBuf>,
        kind: OutputKind,
    ) -> Result<Output, Failure> {
        let mut output =
            Output { path: path.into(), kind, rules: Rc::clone(&self.rules), _lock: None };
        let mut destination = None;
        let identity = match output.destination()? {
            Destination::Stdout if console::is_json() => {
                let message = format!("{output}: with --json the result is printed there");
                return Err(Failure::new(message, "name a file, or leave --json out"));
            }
            Destination::Stdout => {
                console::take_stdout();
                Some(Identity::New("-".into()))
            }
            Destination::Open(path) => fs::metadata(&path)
                .ok()
                .filter(is_fifo)
                .map(|metadata| Identity::new(&path, &metadata)),
            Destination::File(path) => {
                destination = Some(path.clone());
                Some(match fs::metadata(&path) {
                    Ok(metadata) => Identity::new(&path, &metadata),
                    Err(_) => Identity::of_new(&path),
                })
            }
        };
        if let Some(identity) = identity {
            if self.taken.contains(&identity) {
                let message = format!("{output}: two outputs of this command are this file");
                return Err(Failure::new(message, "name two files"));
            }
            self.taken.push(identity);
        }
        if let Some(path) = destination {
            output._lock = lock_file(&path, &output.path)?;
        }
        Ok(output)
    }

    /// The same for an option that may be left out.
    pub(crate) fn optional(
        &mut self,
        path: Option<&PathBuf>,
        kind: OutputKind,
    ) -> Result<Option<Output>, Failure> {
        path.map(|path| self.file(path, kind)).transpose()
    }

    /// Files of one kind in a folder, by name.
    pub(crate) fn files<N: AsRef<str>>(
        &mut self,
        folder: &Path,
        names: impl IntoIterator<Item = N>,
        kind: OutputKind,
    ) -> Result<Files, Failure> {
        let outputs = names
            .into_iter()
            .map(|name| self.file(folder.join(name.as_ref()), kind))
            .collect::<Result<_, _>>()?;
        Ok(Files { outputs })
    }

    /// A folder of results, for the command of that name.
    pub(crate) fn folder(&self, path: &Path, command: &'static str) -> Result<Folder, Failure> {
        Folder::claim(path, command, self.rules.force, &self.rules.inputs)
    }
}

#[derive(Debug)]
pub(crate) struct Files {
    outputs: Vec<Output>,
}

impl Files {
    /// As [`Output::check_columns`], for all of them.
    pub(crate) fn check_columns(&self, columns: &[String]) -> Result<(), Failure> {
        self.outputs.iter().try_for_each(|output| output.check_columns(columns))
    }

    /// Writes one of them; where it is.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<&Path, Failure> {
        let named = |output: &&Output| output.path.file_name().is_some_and(|n| n == name);
        let output = self.outputs.iter().find(named).ok_or_else(|| {
            Failure::new(format!("{name} was not looked at before"), "report this as a fault")
        })?;
        output.write(bytes)?;
        Ok(&output.path)
    }
}

/// A file to write, that may be written.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    kind: OutputKind,
    rules: Rc<Rules>,
    /// Held until the command has written the file.
    _lock: Option<Lock>,
}

enum Destination {
    Stdout,
    /// A device, a FIFO or an open file.
    Open(PathBuf),
    /// A file that is there or not, no link.
    File(PathBuf),
}

impl std::fmt::Display for Output {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())
    }
}

impl Output {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Refuses a table of trajectories none of whose columns is to be written: any tool's are a time and dotted
    /// names, and only names in common show that the file is of an earlier run of the same system.
    pub(crate) fn check_columns(&self, columns: &[String]) -> Result<(), Failure> {
        let Destination::File(path) = self.destination()? else { return Ok(()) };
        let Ok(file) = fs::File::open(&path) else { return Ok(()) };
        let is_empty = file.metadata().is_ok_and(|metadata| metadata.len() == 0);
        let of_this_system = |cells: Vec<String>| cells.iter().any(|cell| columns.contains(cell));
        if self.rules.force || is_empty || kind::header(file).is_some_and(of_this_system) {
            return Ok(());
        }
        Err(Failure::new(format!("{self}: holds the trajectories of another system"), FORCE))
    }

    /// Writes a document after the checks its reader makes.
    pub(crate) fn document<D: Document>(&self, document: &D) -> Result<(), Failure> {
        document.checked(&self.to_string())?;
        self.write(document.to_json().as_bytes())
    }

    /// As [`Output::document`].
    pub(crate) fn model(&self, model: &Model) -> Result<(), Failure> {
        model.checked(&self.to_string())?;
        self.write(model.to_json().as_bytes())
    }

    /// Writes a file whole or not at all, making its folder.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        let failed = |e: std::io::Error| Failure::file(&self.path, &e);
        // Decided once more: what was found before the work may have changed since.
        match self.destination()? {
            Destination::Stdout => console::bytes(bytes).map_err(failed),
            Destination::Open(path) => OpenOptions::new()
                .append(true)
                .open(path)
                .and_then(|mut file| file.write_all(bytes))
                .map_err(failed),
            Destination::File(path) => replace(&path, bytes).map_err(failed),
        }
    }

    /// The destination of bytes, if they may be written there.
    fn destination(&self) -> Result<Destination, Failure> {
        let refused = |problem: &str, hint: &str| {
            Err(Failure::new(format!("{self}: {problem}"), hint.to_owned()))
        };
        const FOLDER: (&str, &str) = ("this is a folder", "name a file in it");
        if is_stdout(&self.path) {
            return Ok(Destination::Stdout);
        }
        let path = identity::resolved(&self.path);
        if is_stdout(&path) {
            return Ok(Destination::Stdout);
        }
        if self.path.as_os_str().as_encoded_bytes().ends_with(b"/") || path.file_name().is_none() {
            return refused(FOLDER.0, FOLDER.1);
        }
        let metadata = match fs::metadata(&path) {
            Ok(metadata) => metadata,
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                folder_of(&path)?;
                return Ok(Destination::File(path));
            }
            Err(e) => return Err(Failure::file(&self.path, &e)),
        };
        if metadata.is_dir() {
            return refused(FOLDER.0, FOLDER.1);
        }
        let here = Identity::new(&path, &metadata);
        if let Some((_, input)) = self.rules.inputs.iter().find(|(input, _)| *input == here) {
            let problem = if *input == self.path {
                "this output is also an input, and is never written".to_owned()
            } else {
                format!("this output is the input {}, and is never written", input.display())
            };
            return refused(&problem, "name another output; --force overwrites no input either");
        }
        if is_open_file(&path) || is_character_device(&metadata) || is_fifo(&metadata) {
            return Ok(Destination::Open(path));
        }
        if !metadata.is_file() {
            return refused("this is neither a file nor a FIFO", "name a file");
        }
        if is_claimed(&path) {
            return refused(
                "another run is writing this file",
                "name another file, or wait for that run",
            );
        }
        if !self.rules.force {
            if metadata.permissions().readonly() {
                return refused("this file is read-only", FORCE);
            }
            let same = self.kind.is_in(&path).map_err(|e| Failure::file(&self.path, &e))?;
            if !same {
                let kind = self.kind.in_words();
                let problem = format!("this file is there and is no {kind} of this program");
                return refused(&problem, FORCE);
            }
        }
        folder_of(&path)?;
        Ok(Destination::File(path))
    }
}

/// Whether a process has the file for itself, as a sweep has its results. The claim of one that was just killed may last a
/// moment longer.
fn is_claimed(path: &Path) -> bool {
    let Ok(file) = fs::File::open(path) else { return false };
    if matches!(lock::lock(&file, &[20, 80, 400]), Err(fs::TryLockError::WouldBlock)) {
        return true;
    }
    // Closed, it would stay locked for as long as a child that is being started has a copy of it.
    let _ = file.unlock();
    false
}

fn no_folder(path: &Path) -> Failure {
    Failure::new(format!("{}: this is a file, not a folder", path.display()), "name another folder")
}

/// Refuses a place below something that is no folder, or that may not be written to.
fn folder_of(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (there, _) = identity::nearest(folder);
    let metadata = fs::metadata(&there).map_err(|e| Failure::file(&there, &e))?;
    if !metadata.is_dir() {
        return Err(no_folder(&there));
    }
    #[cfg(unix)]
    {
        use rustix::fs::Access;
        rustix::fs::access(&there, Access::WRITE_OK | Access::EXEC_OK)
            .map_err(|e| Failure::file(&there, &e.into()))?;
    }
    Ok(())
}

/// Locks a file that a command writes at its end, so that of two runs the second is refused before its work. In a folder
/// that is not there yet nothing is locked.
fn lock_file(path: &Path, named: &Path) -> Result<Option<Lock>, Failure> {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return Ok(None) };
    // A longer name with that of the lock would be none.
    const LONGEST_NAME: usize = 200;
    let is_there = folder.as_os_str().is_empty() || folder.is_dir();
    if !is_there || name.len() > LONGEST_NAME {
        return Ok(None);
    }
    // With the name of a new file, so that the lock of a killed run goes with the next one's.
    let mut lock = std::ffi::OsString::from(NEW);
    lock.push(name);
    lock.push(".lock");
    Lock::take(&folder.join(lock), named, "file").map(Some)
}

/// The start of the names of new files.
const NEW: &str = ".steerwright-new-";

/// Removes the new files of killed runs, whose locks are free.
fn remove_left(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_new = entry.file_name().as_encoded_bytes().starts_with(NEW.as_bytes());
        if is_new
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = fs::File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A new file under a random name, moved to its place by one rename.
fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(NEW);
    // Reduced by the umask, as for any file that a program creates.
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666))
    };
    remove_left(folder);
    let mut file = builder.tempfile_in(folder)?;
    // Without locks no other run takes the file for left.
    let _ = file.as_file().try_lock();
    file.write_all(bytes)?;
    // A rename may be on the disk before what it renames.
    file.as_file().sync_all()?;
    if let Ok(before) = fs::metadata(path) {
        keep_owner_and_mode(file.as_file(), &before);
    }
    file.persist(path).map(|_| ()).map_err(|e| e.error)
}

/// The new file belongs to whom the old one belonged to, as far as that may be.
#[cfg(unix)]
fn keep_owner_and_mode(file: &fs::File, before: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let _ = fchown(file, Some(before.uid()), Some(before.gid()));
    let _ = file.set_permissions(fs::Permissions::from_mode(before.mode() & 0o777));
}

#[cfg(not(unix))]
fn keep_owner_and_mode(_: &fs::File, _: &fs::Metadata) {}
