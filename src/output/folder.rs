//! A folder of results that is made next to its place and swapped in when it is complete
//! (`docs/decisions/0038-folders-swapped-under-a-lock.md`).
//!
//! While a command works, next to a folder `out` are `.out.steerwright-lock`,
//! `.out.steerwright-…` (what is being made), and, where two folders cannot be exchanged in one step,
//! `.out.steerwright-old` for a moment.

use super::identity::{Identity, resolved};
use super::lock::Lock;
use super::manifest::{self, Manifest};
use crate::failure::Failure;
use crate::process::program::INTERRUPTED;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A folder that is being made.
#[derive(Debug)]
pub(crate) struct Folder {
    /// The path of the option.
    path: PathBuf,
    /// Where it will be: absolute, without links.
    target: PathBuf,
    command: &'static str,
    force: bool,
    stage: PathBuf,
    /// The paths that an interruption removes; nothing is removed while it is locked.
    rest: Arc<Mutex<Option<Rest>>>,
    lock: Option<Lock>,
}

/// The paths to remove when the command does not reach its end.
#[derive(Debug)]
struct Rest {
    stage: PathBuf,
    /// Folders above the target that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Rest {
    /// Removes the new folder; the next run removes files that remain.
    fn remove_stage(&self) {
        let _ = fs::remove_dir_all(&self.stage);
    }

    /// The same while files are still being written: a file in its place lets no writer make the folder
    /// again, and is removed last.
    fn remove_stage_in_use(&self) {
        const TRIES: usize = 100;
        for _ in 0..TRIES {
            self.remove_stage();
            if File::create_new(&self.stage).is_ok() {
                break;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        // A write that is under way fails meanwhile, and its thread waits for the end.
        std::thread::sleep(Duration::from_millis(20));
        let _ = fs::remove_file(&self.stage);
    }

    /// Folders that hold nothing.
    fn remove_made(&self) {
        for folder in &self.made {
            let _ = fs::remove_dir(folder);
        }
    }
}

impl Folder {
    /// Claims a place, for the command of that name that reads these files.
    pub(super) fn claim(
        path: &Path,
        command: &'static str,
        force: bool,
        inputs: &[(Identity, PathBuf)],
    ) -> Result<Self, Failure> {
        let target = place(path)?;
        check(&target, path, inputs)?;
        let (Some(parent), Some(name)) = (target.parent(), target.file_name()) else {
            return Err(whole(path, "this is the root of a file system"));
        };
        let made = make(parent)?;
        let sibling = |end: &str| {
            let mut hidden = std::ffi::OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".steerwright-{end}"));
            hidden
        };
        let lock = Lock::take(&parent.join(sibling("lock")), path, "folder")?;
        clean(&target, parent, &sibling(""), &sibling("old"), lock.path());
        if target.exists() {
            manifest::check(&target, command, force)?;
        }
        let mut builder = tempfile::Builder::new();
        let prefix = sibling("");
        builder.prefix(&prefix);
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o777))
        };
        let stage = builder.tempdir_in(parent).map_err(|e| Failure::file(parent, &e))?.keep();
        let rest = Arc::new(Mutex::new(Some(Rest { stage: stage.clone(), made })));
        on_interruption(Arc::clone(&rest), lock.path().to_path_buf(), path.to_path_buf());
        Ok(Self { path: path.into(), target, command, force, stage, rest, lock: Some(lock) })
    }

    pub(crate) fn stage(&self) -> &Path {
        &self.stage
    }

    /// Puts what was written in its place.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let failed = |e: std::io::Error| Failure::file(&self.path, &e);
        let manifest = Manifest::from_folder(&self.stage, self.command).map_err(failed)?;
        fs::write(self.stage.join(manifest::NAME), manifest.to_json()).map_err(failed)?;
        sync(&self.stage).map_err(failed)?;
        // Checked once more: someone may have put a file there meanwhile.
        if let Ok(before) = fs::metadata(&self.target) {
            manifest::check(&self.target, self.command, self.force)?;
            let _ = fs::set_permissions(&self.stage, before.permissions());
        }
        // An interruption waits until the folder is whole again.
        let mut rest = self.rest.lock().unwrap_or_else(PoisonError::into_inner);
        swap(&self.stage, &self.target).map_err(failed)?;
        // An interruption from here on has nothing to remove. What the exchange left goes here.
        if let Some(rest) = rest.take() {
            rest.remove_stage();
        }
        Ok(())
    }
}

impl Drop for Folder {
    /// The remaining folder is either the unfinished or the replaced one.
    fn drop(&mut self) {
        let rest = self.rest.lock().unwrap_or_else(PoisonError::into_inner).take();
        // Where it was committed, the lock goes with this value.
        let Some(rest) = rest else { return };
        rest.remove_stage();
        // The lock's file is in the folder that may have been made.
        drop(self.lock.take());
        rest.remove_made();
    }
}

/// The folder that a path leads to, absolute and without links; it need not be there.
fn place(path: &Path) -> Result<PathBuf, Failure> {
    let path = resolved(path);
    let absolute = std::path::absolute(&path).map_err(|e| Failure::file(&path, &e))?;
    if let Ok(there) = fs::canonicalize(&absolute) {
        return Ok(there);
    }
    Ok(match Identity::of_new(&absolute) {
        Identity::New(path) => path,
        Identity::There(..) => absolute,
    })
}

/// Refuses what cannot or must not be replaced as a whole.
fn check(target: &Path, path: &Path, inputs: &[(Identity, PathBuf)]) -> Result<(), Failure> {
    for (_, input) in inputs {
        if fs::canonicalize(input).is_ok_and(|input| input.starts_with(target)) {
            return Err(whole(path, &format!("{} is in this folder and is read", input.display())));
        }
    }
    if std::env::current_dir().is_ok_and(|here| here.starts_with(target)) {
        return Err(whole(path, "this folder is the current one or holds it"));
    }
    let Ok(metadata) = fs::metadata(target) else { return Ok(()) };
    if !metadata.is_dir() {
        return Err(super::no_folder(path));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let parent = target.parent().and_then(|parent| fs::metadata(parent).ok());
        if parent.is_some_and(|parent| parent.dev() != metadata.dev()) {
            return Err(whole(path, "this folder is a mount point"));
        }
    }
    Ok(())
}

fn whole(path: &Path, problem: &str) -> Failure {
    Failure::new(
        format!("{}: {problem}", path.display()),
        "name another folder, or a new one in it: the folder is replaced as a whole",
    )
}

/// Makes the folders that are missing; which, the innermost first.
fn make(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let missing = folder.ancestors().take_while(|f| !f.exists()).map(Path::to_path_buf).collect();
    fs::create_dir_all(folder).map_err(|e| match e.kind() {
        std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => {
            super::no_folder(&super::identity::nearest(folder).0)
        }
        _ => Failure::file(folder, &e),
    })?;
    Ok(missing)
}

/// Removes the remains of a killed run next to the target; the lock is held.
fn clean(
    target: &Path,
    parent: &Path,
    prefix: &std::ffi::OsStr,
    old: &std::ffi::OsStr,
    lock: &Path,
) {
    // Killed between the two renames of an exchange.
    if !target.exists() && parent.join(old).is_dir() {
        let _ = fs::rename(parent.join(old), target);
    }
    let Ok(entries) = fs::read_dir(parent) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_left = name.as_encoded_bytes().starts_with(prefix.as_encoded_bytes());
        if is_left && entry.path() != lock && entry.file_type().is_ok_and(|t| t.is_dir()) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Has all files of a folder on the disk: a rename may be there before what it renames.
fn sync(folder: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sync(&entry.path())?;
        } else {
            // Windows flushes what is open for writing only.
            File::options().append(true).open(entry.path())?.sync_all()?;
        }
    }
    Ok(())
}

/// Puts a new folder in its place; an old one takes the new one's.
fn swap(stage: &Path, target: &Path) -> std::io::Result<()> {
    if !target.exists() {
        return fs::rename(stage, target);
    }
    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        use rustix::io::Errno;
        match renameat_with(CWD, stage, CWD, target, RenameFlags::EXCHANGE) {
            // Not every file system exchanges.
            Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => {}
            done => return Ok(done?),
        }
    }
    let mut old = std::ffi::OsString::from(".");
    old.push(target.file_name().unwrap_or_default());
    old.push(".steerwright-old");
    let old = target.with_file_name(old);
    fs::rename(target, &old)?;
    match fs::rename(stage, target) {
        Ok(()) => fs::rename(&old, stage),
        Err(e) => {
            fs::rename(&old, target)?;
            Err(e)
        }
    }
}

/// Removes unfinished results when the process is interrupted.
fn on_interruption(rest: Arc<Mutex<Option<Rest>>>, lock: PathBuf, path: PathBuf) {
    // A process has one handler; without it the next run removes what is left.
    let _ = steerwright_host::process::on_interruption(move || {
        let rest = rest.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(unfinished) = rest.as_ref() else {
            let message = format!("interrupted: {} is complete", path.display());
            Failure::new(message, "run the command again for what it prints").exit(INTERRUPTED)
        };
        // Removed while it is held, so that it is not another run's.
        let _ = fs::remove_file(&lock);
        unfinished.remove_stage_in_use();
        unfinished.remove_made();
        let message = format!("interrupted: {} is as it was", path.display());
        Failure::new(message, "run the command again").exit(INTERRUPTED)
    });
}
