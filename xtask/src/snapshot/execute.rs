//! Runs the commands, each in a folder of its own, as soon as those that it needs have ended.

use super::archive::{is_archive, opened};
use super::commands::Command;
use super::mask::{Masks, of_archive, replaced, without_study};
use super::recording::Output;
use crate::files::all_below;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The program, where it runs, and what is masked.
pub(super) struct Runner<'a> {
    pub(super) program: &'a Path,
    pub(super) work: &'a Path,
    pub(super) masks: Masks,
}

/// The outputs of all commands, in their order, and the time of each command.
pub(super) struct Recording {
    pub(super) outputs: Vec<Output>,
    pub(super) times: Vec<(Duration, String)>,
}

/// What has been done; a result is there once its command has ended.
struct Done {
    is_started: Vec<bool>,
    results: Vec<Option<Result<Vec<Output>, String>>>,
    times: Vec<(Duration, String)>,
}

impl Runner<'_> {
    /// Runs all commands.
    pub(super) fn run_all(&self, commands: &[Command]) -> Result<Recording, String> {
        let count = commands.len();
        let results = (0..count).map(|_| None).collect();
        let done = Done { is_started: vec![false; count], results, times: Vec::new() };
        let (done, changed) = (Mutex::new(done), Condvar::new());
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| self.work(commands, &done, &changed));
            }
        });
        let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        let outputs: Result<Vec<_>, String> = done.results.into_iter().flatten().collect();
        Ok(Recording { outputs: outputs?.into_iter().flatten().collect(), times: done.times })
    }

    /// Runs commands until all are started.
    fn work(&self, commands: &[Command], done: &Mutex<Done>, changed: &Condvar) {
        let mut state = done.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(first) = state.is_started.iter().position(|is_started| !is_started) {
            let Some(index) =
                (first..commands.len()).find(|&index| state.can_start(commands, index))
            else {
                state = changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            state.is_started[index] = true;
            drop(state);
            let begun = Instant::now();
            let result = self.run(&commands[index]);
            state = done.lock().unwrap_or_else(PoisonError::into_inner);
            state.results[index] = Some(result);
            state.times.push((begun.elapsed(), commands[index].name.clone()));
            changed.notify_all();
        }
    }

    /// Exit status, streams and files of a command.
    fn run(&self, command: &Command) -> Result<Vec<Output>, String> {
        let folder = self.work.join(&command.name);
        let problem = |e: &dyn std::fmt::Display| format!("{}: {e}", command.name);
        fs::create_dir_all(&folder).map_err(|e| problem(&e))?;
        let mut program = std::process::Command::new(self.program);
        for (variable, _) in std::env::vars().filter(|(name, _)| name.starts_with("STEERWRIGHT_")) {
            program.env_remove(variable);
        }
        program.args(self.arguments(command)).current_dir(&folder).env("NO_COLOR", "1");
        let output = program.stdin(Stdio::null()).output().map_err(|e| problem(&e))?;
        let status = output.status.to_string().into_bytes();
        let mut found = vec![("status".to_owned(), status)];
        let streams = [("stdout", output.stdout), ("stderr", output.stderr)];
        found.extend(streams.map(|(name, content)| (name.to_owned(), content)));
        let mut of_archives = Vec::new();
        for file in all_below(&folder)? {
            let name = file.strip_prefix(&folder).unwrap_or(&file).display().to_string();
            let content = fs::read(&file).map_err(|e| problem(&e))?;
            if is_archive(&content) {
                of_archives.extend(of_archive(&content));
            }
            found.extend(opened(&name, content)?);
        }
        let output = |(name, content)| self.output(command, &of_archives, name, content);
        let outputs = found.into_iter().map(output);
        // Not before the masks: of slow work, stderr has its progress, and without it may be empty.
        Ok(outputs.filter(|output| !output.content.is_empty()).collect())
    }

    /// The arguments; one that ends with `/*` as the files of the folder.
    fn arguments(&self, command: &Command) -> Vec<String> {
        let mut arguments = Vec::new();
        for argument in &command.arguments {
            let Some(folder) = argument.strip_suffix("/*") else {
                arguments.push(argument.clone());
                continue;
            };
            let place = self.work.join(&command.name);
            // None where the command before has failed.
            let files = all_below(&place.join(folder)).unwrap_or_default();
            let names = files.iter().filter_map(|file| file.file_name());
            arguments.extend(names.map(|name| format!("{folder}/{}", name.display())));
        }
        arguments
    }

    /// An output without what is masked.
    fn output(
        &self,
        command: &Command,
        of_archives: &[(String, &'static str)],
        name: String,
        content: Vec<u8>,
    ) -> Output {
        let is_sweep = command.arguments.iter().any(|argument| argument == "sweep");
        let study = |text: String| if is_sweep { without_study(&text) } else { text };
        let content = match String::from_utf8(content) {
            Ok(text) => study(replaced(self.masks.mask(&text), of_archives)).into_bytes(),
            Err(error) => error.into_bytes(),
        };
        Output { command: command.name.clone(), file: study(name), content }
    }
}

impl Done {
    /// Whether a command waits for none.
    fn can_start(&self, commands: &[Command], index: usize) -> bool {
        let needed = commands.iter().zip(&self.results).filter(|(c, _)| commands[index].needs(c));
        !self.is_started[index] && needed.into_iter().all(|(_, result)| result.is_some())
    }
}
